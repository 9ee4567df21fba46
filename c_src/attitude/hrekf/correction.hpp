// One correction of m rows that see the quaternion only, H = [H_q, 0]: inflation, gain, covariance and state.
#pragma once

#include "attitude/hrekf/state.hpp"
#include "estimation/robust_law.hpp"
#include "maths/repair.hpp"
#include "maths/scalar.hpp"

namespace hnav {

extern template bool repair<7>(Square<7, Scalar>& P); // this and the next in covariance.cpp
extern template Square<7, Scalar> inflate<7>(const Square<7, Scalar>& P, const Eigen::Matrix<Scalar, 7, 1>& L, Scalar interval_s,
                                             const RobustSettings<Scalar>& settings, RobustReport<Scalar>* report);

// What does not depend on the number of rows.
template <class R>
class HrekfCorrectionBase {
protected:
    using Covariance = Square<7, R>;

    HrekfCorrectionBase(const HrekfLaw<R>& law, HrekfState<R>& s, double t_s);

    void inflate_covariance() { Sigma_ = inflate<7>(P_, law_.weight, R(interval_s_), law_.robust, &robust_); }
    void repair_covariance() { s_.repaired += repair<7>(P_); }

    // x holds the sum of state and correction, P the covariance that goes with it; KHN = K H_q N(q_minus), see error_map.hpp.
    void finish(Covariance& P, const Eigen::Matrix<R, 7, 3>& KHN, bool sees_tilt, bool sees_heading);

    const HrekfLaw<R>& law_;
    HrekfState<R>& s_;
    double t_s_, interval_s_;
    QuaternionOf<R> q_minus_;
    Covariance P_, Sigma_;
    RobustReport<R> robust_;

private:
    static void limit_covariance(Covariance& P);
    R return_to_unit_sphere(Covariance& P);
};

extern template class HrekfCorrectionBase<Scalar>; // correction.cpp

template <int m, class R>
class HrekfCorrection : HrekfCorrectionBase<R> {
public:
    using Rows = Eigen::Matrix<R, m, 1>;
    using Gain = Eigen::Matrix<R, 7, m>;

    HrekfCorrection(const HrekfLaw<R>& law, HrekfState<R>& s, double t_s, const Eigen::Matrix<R, m, 4>& H,
                    const Square<m, R>& noise)
        : Base(law, s, t_s), H_(H) {
        predict();
        change_noise(noise);
        if (factor_.positive()) return;
        this->repair_covariance(); // over a long gap the integrator has left P indefinite
        predict();
        HSigmaHt_.diagonal() = HSigmaHt_.diagonal().cwiseMax(0);
        change_noise(noise);
    }

    void change_noise(const Square<m, R>& noise) {
        noise_ = noise;
        S_ = HSigmaHt_ + noise;
        symmetrise<m>(S_);
        factor_ = Cholesky<m, R>(S_);
    }

    const Square<m, R>& innovation_covariance() const { return S_; }

    void apply(const Rows& nu, bool sees_tilt, bool sees_heading) {
        const Gain K = factor_.template solve<7>(SigmaHt_.transpose()).transpose();
        typename Base::Covariance P;
        P.noalias() = Sigma_ - K.lazyProduct(SigmaHt_.transpose());
        if (law_.adaptation.mode != Adaptation::off) adapt(nu, K);
        Eigen::Map<Eigen::Matrix<R, 7, 1>>(s_.x).noalias() += K * nu;
        const Eigen::Matrix<R, m, 3> HN = H_.lazyProduct(across<R>(this->q_minus_));
        this->finish(P, K.lazyProduct(HN), sees_tilt, sees_heading);
    }

private:
    using Base = HrekfCorrectionBase<R>;
    using Base::interval_s_, Base::P_, Base::s_, Base::law_, Base::Sigma_;

    void predict() {
        this->inflate_covariance();
        SigmaHt_.noalias() = columns<4>(Sigma_, 0) * H_.transpose();
        HSigmaHt_.noalias() = H_ * rows<4>(SigmaHt_, 0);
    }

    void adapt(const Rows& nu, const Gain& K) {
        const AdaptationSettings<R>& adaptation = law_.adaptation;
        const Matrix3Of<R> Q = unpack<3>(s_.bias_psd);
        if (adaptation.mode == Adaptation::paper) {
            pack<3>(adapt_as_printed<R>(Q, adaptation, rows<3>(K, 4) * nu), s_.bias_psd);
            return;
        }
        // The plain Kalman correction, uninflated; its bias block only.
        const Gain PHt = columns<4>(P_, 0) * H_.transpose();
        Square<m, R> S = H_ * rows<4>(PHt, 0) + noise_;
        symmetrise<m>(S);
        const Eigen::Matrix<R, 3, m> bias_rows = rows<3>(PHt, 4);
        const Eigen::Matrix<R, 3, m> K0 = Cholesky<m, R>(S).template solve<3>(bias_rows.transpose()).transpose();
        const R posterior = (block<3, 3>(P_, 4, 4) - K0 * bias_rows.transpose()).trace();
        const R level = Q.trace() / 3;
        if (s_.adaptation.add(this->t_s_, interval_s_, K0 * nu, posterior - s_.previous_bias_trace) && level > 0)
            pack<3>(Matrix3Of<R>(s_.adaptation.factor(adaptation, level) * Q), s_.bias_psd);
    }

    const Eigen::Matrix<R, m, 4>& H_;
    Gain SigmaHt_;
    Square<m, R> HSigmaHt_, noise_, S_;
    Cholesky<m, R> factor_;
};

template <class R>
HrekfCorrectionBase<R>::HrekfCorrectionBase(const HrekfLaw<R>& law, HrekfState<R>& s, double t_s)
    : law_(law),
      s_(s),
      t_s_(t_s),
      interval_s_(t_s - s.last_correction_s),
      q_minus_(QuaternionOf<R>(s.x).normalized()),
      P_(unpack<7>(s.x + 7)) {
    limit_covariance(P_);
}

// A unit quaternion has no error beyond 1. After ages without a sample its variances outgrow the digits that the noise needs
// beside them in S; turned down on both sides, P stays a covariance.
template <class R>
void HrekfCorrectionBase<R>::limit_covariance(Covariance& P) {
    constexpr R max_trace = R(1e6);
    const R trace = block<4, 4>(P, 0, 0).trace();
    if (!(trace > max_trace)) return;
    const R factor = std::sqrt(max_trace / trace);
    rows<4>(P, 0) *= factor;
    columns<4>(P, 0) *= factor;
}

template <class R>
void HrekfCorrectionBase<R>::finish(Covariance& P, const Eigen::Matrix<R, 7, 3>& KHN, bool sees_tilt, bool sees_heading) {
    const Vector3Of<R> before = rotation_variances_of<R>(q_minus_, block<4, 4>(P_, 0, 0));
    const R norm = return_to_unit_sphere(P);
    symmetrise<7>(P);
    s_.repaired += repair<7>(P);
    pack<7>(P, s_.x + 7);
    s_.previous_bias_trace = block<3, 3>(P, 4, 4).trace();

    const QuaternionOf<R> q_plus(s_.x);
    s_.error_map.jump(interval_s_, KHN, q_minus_, q_plus, norm, s_.x + 7);
    s_.last_correction_s = t_s_;
    ++s_.corrections;
    s_.gamma = robust_.gamma;
    s_.gamma_margin = robust_.margin;
    s_.gamma_raised += robust_.raised;
    const Vector3Of<R> after = rotation_variances_of<R>(q_plus, block<4, 4>(P, 0, 0));
    if (sees_tilt) s_.information.gain_tilt(before, after);
    if (sees_heading) s_.information.gain_heading(before, after);
}

// q <- q/|q|, whose derivative is J = (I - q q')/|q|: P <- J P J' on the quaternion. Answers |q|.
template <class R>
R HrekfCorrectionBase<R>::return_to_unit_sphere(Covariance& P) {
    Eigen::Map<QuaternionOf<R>> x_q(s_.x);
    const R norm = x_q.norm();
    x_q /= norm;
    const QuaternionOf<R> q = x_q;
    const Eigen::Matrix<R, 1, 7> along = q.transpose() * rows<4>(P, 0);
    rows<4>(P, 0).noalias() -= q * along;
    rows<4>(P, 0) /= norm;
    const Eigen::Matrix<R, 7, 1> along_columns = columns<4>(P, 0) * q;
    columns<4>(P, 0).noalias() -= along_columns * q.transpose();
    columns<4>(P, 0) /= norm;
    return norm;
}

} // namespace hnav
