// Compiled once: eigenvalues and vectors take seconds of compile time wherever they are used.
#include "attitude/hrekf/correction.hpp"
#include "maths/unroll.hpp"

namespace hnav {

template bool repair<6>(Square<6, Scalar>& P);

namespace {

// A unit quaternion has no error beyond 1. After ages without a sample its variances outgrow the digits that the noise needs
// beside them in S; turned down on both sides, P stays a covariance.
void limit_covariance(Square<6, Scalar>& P, Scalar& length_variance) {
    using R = Scalar;
    constexpr R max_trace = R(1e6);
    const R trace = block<3, 3>(P, 0, 0).trace() / 4 + length_variance;
    if (!(trace > max_trace)) return;
    const R factor = std::sqrt(max_trace / trace);
    rows<3>(P, 0) *= factor;
    columns<3>(P, 0) *= factor;
    length_variance *= factor * factor;
}

} // namespace

HrekfCorrection::HrekfCorrection(const HrekfLaw& law, HrekfState& s, double t_s, const Covariance& P, R length_variance)
    : law_(law), s_(s), t_s_(t_s), interval_s_(t_s - s.last_correction_s) {
    now_.P = P;
    now_.length_variance = length_variance;
    limit_covariance(now_.P, now_.length_variance);
    before_ = diagonal<3>(now_.P, 0);
    kept_ << Matrix3Of<R>::Identity(), Matrix3Of<R>::Zero();
    if (law_.adaptation.mode == Adaptation::corrected) plain_ = now_;
    if (law_.robust.mode != GammaMode::off && interval_s_ > 0) inflate(R(interval_s_));
}

// By the eigenvalues of L P L' with the weight of the paper's four components of q: that of their rotation by half.
void HrekfCorrection::inflate(R interval_s) {
    const Eigen::Matrix<R, 6, 1>& D = law_.weight;
    const Covariance LP = D.asDiagonal() * now_.P, LPL = LP * D.asDiagonal();
    const R of_length = law_.length_weight * law_.length_weight * now_.length_variance;
    Eigen::Matrix<R, 7, 1> values;
    values << of_length, eigenvalues<6, R>(LPL);
    if (values[0] > values[6]) std::swap(values[0], values[6]);
    const R theta = inflation_theta<7, R>(values, interval_s, law_.robust, &robust_);
    if (!(theta > 0)) return;
    inflate_by<6, 6, R>(now_.P, LP, LPL, theta);
    now_.length_variance /= 1 - theta * of_length;
}

void HrekfCorrection::adapt() {
    const AdaptationSettings<R>& adaptation = law_.adaptation;
    const Matrix3Of<R> Q = unpack<3>(s_.bias_psd);
    if (adaptation.mode == Adaptation::paper) {
        pack<3>(adapt_as_printed<R>(Q, adaptation, segment<3>(now_.mean, 3)), s_.bias_psd);
        return;
    }
    const R posterior = block<3, 3>(plain_.P, 3, 3).trace(), level = Q.trace() / 3;
    if (s_.adaptation.add(t_s_, interval_s_, segment<3>(plain_.mean, 3), posterior - s_.previous_bias_trace) && level > 0)
        pack<3>(Matrix3Of<R>(s_.adaptation.factor(adaptation, level) * Q), s_.bias_psd);
}

// q <- (1 + length, theta / 2) (x) q, back to unit length: what of the error lies along the new q is gone, and the rest is seen from
// there. Leaves the covariance below its diagonal. Answers the turn.
QuaternionOf<Scalar> HrekfCorrection::return_to_unit_sphere() {
    const Vector3Of<R> half = R(0.5) * rows<3>(now_.mean, 0);
    const QuaternionOf<R> raw(1 + now_.length, half[0], half[1], half[2]);
    const R norm = raw.norm();
    const QuaternionOf<R> turn = raw / norm;
    const Vector3Of<R> v(turn[1], turn[2], turn[3]);
    const R length_variance = 4 * now_.length_variance / (norm * norm);
    Matrix3Of<R> J = cross_matrix<R>(v);
    J.diagonal().array() += turn[0];
    J *= 1 / norm;
    const Matrix3Of<R> rotation = J * block<3, 3>(now_.P, 0, 0), with_bias = block<3, 3>(now_.P, 3, 0), kept = rows<3>(kept_, 0);
    HNAV_UNROLL
    for (int i = 0; i < 3; ++i) {
        HNAV_UNROLL
        for (int j = 0; j <= i; ++j)
            now_.P(i, j) =
                rotation(i, 0) * J(j, 0) + rotation(i, 1) * J(j, 1) + rotation(i, 2) * J(j, 2) + length_variance * v[i] * v[j];
    }
    block<3, 3>(now_.P, 3, 0).noalias() = with_bias * J.transpose();
    rows<3>(kept_, 0).noalias() = J * kept;
    return turn;
}

void HrekfCorrection::apply(bool sees_tilt, bool sees_heading) {
    if (law_.adaptation.mode != Adaptation::off) adapt();
    Eigen::Map<QuaternionOf<R>> q(s_.x);
    q = multiply<R>(return_to_unit_sphere(), q);
    q.normalize();
    Eigen::Map<Vector3Of<R>>(s_.bias) += segment<3>(now_.mean, 3);
    s_.repaired += repair<6>(now_.P);
    s_.error_map.jump(interval_s_, kept_, s_.x + AttitudeFlow<R>::A, s_.P);
    pack<6>(now_.P.transpose(), s_.P); // what is below the diagonal
    s_.previous_bias_trace = block<3, 3>(now_.P, 3, 3).trace();

    s_.forget_integrals();
    s_.last_correction_s = t_s_;
    ++s_.corrections;
    s_.gamma = robust_.gamma;
    s_.gamma_margin = robust_.margin;
    s_.gamma_raised += robust_.raised;
    const Vector3Of<R> after = diagonal<3>(now_.P, 0);
    if (sees_tilt) s_.information.gain_tilt(before_, after);
    if (sees_heading) s_.information.gain_heading(before_, after);
}

} // namespace hnav
