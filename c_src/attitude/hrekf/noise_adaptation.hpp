// Robbins-Monro adaptation of the bias walk Q_b (3 x 3, per second).
//
//   as printed    Q <- (1 - alpha) Q + alpha K nu nu' K'
//   corrected     Qhat = (1/T) [K0 nu nu' K0' + P0+ - P+_{k-1}] on the bias block (the bias does not flow, so Phi = I),
//                 Q <- (1 - alpha_k) Q + alpha_k Qhat,  alpha_k = max(alpha, 1/(k + 1)),  eigenvalues kept within bounds
// K0 and P0+ are of the plain Kalman correction: the inflated gain would feed its own inflation back.
#pragma once

#include "maths/rotation.hpp"
#include "maths/scalar.hpp"

#include <Eigen/Eigenvalues>

namespace hnav {

enum class Adaptation { off, paper, corrected };

template <class R>
struct AdaptationSettings {
    Adaptation mode = Adaptation::off;
    R gain = R(0.02);
    R min = 0, max = 1; // bounds of the eigenvalues of Q_b, (rad/s)^2/s
};

template <class R>
inline Matrix3Of<R> adapt_as_printed(const Matrix3Of<Exactly<R>>& Q, const AdaptationSettings<R>& settings,
                                     const Vector3Of<Exactly<R>>& bias_step) {
    return (1 - settings.gain) * Q + settings.gain * bias_step * bias_step.transpose();
}

// bias_step = K0 nu; posterior, previous: bias covariance after this and after the last correction; k = 1, 2, ...
template <class R>
Matrix3Of<R> adapt_corrected(const Matrix3Of<Exactly<R>>& Q, const AdaptationSettings<R>& settings,
                             const Vector3Of<Exactly<R>>& bias_step, const Matrix3Of<Exactly<R>>& posterior,
                             const Matrix3Of<Exactly<R>>& previous, Exactly<R> interval_s, Exactly<R> k) {
    const R alpha = std::fmax(settings.gain, 1 / (k + 1));
    const Matrix3Of<R> estimate = (bias_step * bias_step.transpose() + posterior - previous) / interval_s;
    const Matrix3Of<R> mixed = (1 - alpha) * Q + alpha * estimate;
    const Eigen::SelfAdjointEigenSolver<Matrix3Of<R>> eigen(mixed);
    const Vector3Of<R> bounded = eigen.eigenvalues().cwiseMax(settings.min).cwiseMin(settings.max);
    Matrix3Of<R> adapted = eigen.eigenvectors() * bounded.asDiagonal() * eigen.eigenvectors().transpose();
    symmetrise<3>(adapted);
    return adapted;
}

extern template Matrix3Of<Scalar> adapt_corrected<Scalar>(const Matrix3Of<Scalar>& Q, const AdaptationSettings<Scalar>& settings,
                                                          const Vector3Of<Scalar>& bias_step, const Matrix3Of<Scalar>& posterior,
                                                          const Matrix3Of<Scalar>& previous, Scalar interval_s, Scalar k);

} // namespace hnav
