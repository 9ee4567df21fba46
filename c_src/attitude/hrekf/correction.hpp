// One correction: inflation, then one row after the other, then the state.
//
// Rows see the rotation alone, H = [H_theta, 0] (covariance.hpp). What a direction says along itself is about the length of the
// quaternion, which nothing else correlates with: a scalar beside the rest. Rows whose noises are independent correct one after the
// other with the linearisation at the start, which equals the paper's correction by all at once:
//     S = H Sigma H' + R,  K = Sigma H' S^-1,  e += K (nu - H e),  Sigma -= K H Sigma.
#pragma once

#include "attitude/hrekf/state.hpp"
#include "estimation/robust_law.hpp"
#include "maths/repair.hpp"
#include "maths/scalar.hpp"
#include "maths/unroll.hpp"

namespace hnav {

extern template bool repair<6>(Square<6, Scalar>& P); // correction.cpp

// The error (theta, b) and the length of q, as a Gaussian whose mean was zero before the correction.
template <class R>
struct HrekfGaussian {
    using Vector = Eigen::Matrix<R, 6, 1>;

    Square<6, R> P; // rotation with bias below the diagonal alone, once something has been learnt
    Vector mean = Vector::Zero();
    R length_variance, length = 0;

    R seen_by(const Vector3Of<R>& h) const { return h.dot(block<3, 3>(P, 0, 0) * h); }

    // One row, nu = h theta + noise. kept: the errors after the correction by the rotation error before, see error_map.hpp. False:
    // rounding has left the variance of the innovation without its sign, and nothing is taken.
    bool take(const Vector3Of<R>& h, R nu, R noise, Eigen::Matrix<R, 6, 3>& kept) {
        const Vector Ph = h[0] * P.col(0) + h[1] * P.col(1) + h[2] * P.col(2);
        const R S = h[0] * Ph[0] + h[1] * Ph[1] + h[2] * Ph[2] + noise;
        if (!(S > 0)) return false;
        const Vector K = Ph * (1 / S);
        mean += (nu - h.dot(rows<3>(mean, 0))) * K;
        for (int j = 0; j < 3; ++j) P.col(j) -= Ph[j] * K;
        for (int j = 3; j < 6; ++j) P.col(j).template tail<3>() -= Ph[j] * K.template tail<3>();
        for (int j = 0; j < 3; ++j) kept.col(j) -= (h[0] * kept(0, j) + h[1] * kept(1, j) + h[2] * kept(2, j)) * K;
        return true;
    }

    // A direction shrinks and grows with the square of the length: its row is 2.
    void take_length(R nu, R noise) {
        const R gain = 2 * length_variance / (4 * length_variance + noise);
        length += gain * (nu - 2 * length);
        length_variance *= 1 - 2 * gain;
    }
};

template <class R>
class HrekfCorrection {
public:
    using Covariance = Square<6, R>;

    // P: of now, before the correction.
    HrekfCorrection(const HrekfLaw<R>& law, HrekfState<R>& s, double t_s, const Covariance& P, R length_variance);

    const HrekfGaussian<R>& gaussian() const { return now_; }
    Vector3Of<R> rotation_variances() const { return before_; } // before the correction, not inflated

    void take(const Vector3Of<R>& h, R nu, R noise) {
        if (!now_.take(h, nu, noise, kept_)) { // after ages without a sample
            s_.repaired += repair<6>(now_.P);
            now_.take(h, nu, noise, kept_);
        }
        if (law_.adaptation.mode == Adaptation::corrected) {
            Eigen::Matrix<R, 6, 3> unused = kept_;
            plain_.take(h, nu, noise, unused);
        }
    }
    void take_length(R nu, R noise) { now_.take_length(nu, noise); }

    // Puts what was learnt into the state.
    void apply(bool sees_tilt, bool sees_heading);

private:
    void inflate(R interval_s);
    void adapt();
    QuaternionOf<R> return_to_unit_sphere();

    const HrekfLaw<R>& law_;
    HrekfState<R>& s_;
    double t_s_, interval_s_;
    HrekfGaussian<R> now_, plain_; // plain: without inflation, for the adaptation
    Vector3Of<R> before_;
    Eigen::Matrix<R, 6, 3> kept_;
    RobustReport<R> robust_;
};

extern template class HrekfCorrection<Scalar>; // correction.cpp

// A unit quaternion has no error beyond 1. After ages without a sample its variances outgrow the digits that the noise needs
// beside them in S; turned down on both sides, P stays a covariance.
template <class R>
void limit_covariance(Square<6, R>& P, R& length_variance) {
    constexpr R max_trace = R(1e6);
    const R trace = block<3, 3>(P, 0, 0).trace() / 4 + length_variance;
    if (!(trace > max_trace)) return;
    const R factor = std::sqrt(max_trace / trace);
    rows<3>(P, 0) *= factor;
    columns<3>(P, 0) *= factor;
    length_variance *= factor * factor;
}

template <class R>
HrekfCorrection<R>::HrekfCorrection(const HrekfLaw<R>& law, HrekfState<R>& s, double t_s, const Covariance& P, R length_variance)
    : law_(law), s_(s), t_s_(t_s), interval_s_(t_s - s.last_correction_s) {
    now_.P = P;
    now_.length_variance = length_variance;
    limit_covariance<R>(now_.P, now_.length_variance);
    before_ = diagonal<3>(now_.P, 0);
    kept_ << Matrix3Of<R>::Identity(), Matrix3Of<R>::Zero();
    if (law_.adaptation.mode == Adaptation::corrected) plain_ = now_;
    if (law_.robust.mode != GammaMode::off && interval_s_ > 0) inflate(R(interval_s_));
}

// By the eigenvalues of L P L' with the weight of the paper's four components of q: that of their rotation by half.
template <class R>
void HrekfCorrection<R>::inflate(R interval_s) {
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

template <class R>
void HrekfCorrection<R>::adapt() {
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
template <class R>
QuaternionOf<R> HrekfCorrection<R>::return_to_unit_sphere() {
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

template <class R>
void HrekfCorrection<R>::apply(bool sees_tilt, bool sees_heading) {
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
