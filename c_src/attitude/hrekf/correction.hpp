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

namespace hnav {

extern template bool repair<6>(Square<6, Scalar>& P); // correction.cpp

// The error (theta, b) and the length of q, as a Gaussian whose mean was zero before the correction.
struct HrekfGaussian {
    using R = Scalar;
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
        for (int j = 3; j < 6; ++j) P.col(j).tail<3>() -= Ph[j] * K.tail<3>();
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

class HrekfCorrection {
public:
    using R = Scalar;
    using Covariance = Square<6, R>;

    // P: of now, before the correction.
    HrekfCorrection(const HrekfLaw& law, HrekfState& s, double t_s, const Covariance& P, R length_variance);

    const HrekfGaussian& gaussian() const { return now_; }
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

    const HrekfLaw& law_;
    HrekfState& s_;
    double t_s_, interval_s_;
    HrekfGaussian now_, plain_; // plain: without inflation, for the adaptation
    Vector3Of<R> before_;
    Eigen::Matrix<R, 6, 3> kept_;
    RobustReport<R> robust_;
};

} // namespace hnav
