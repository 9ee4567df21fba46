// Robbins-Monro adaptation of the bias walk Q_b (3 x 3, per second).
//
//   as printed    Q <- (1 - alpha) Q + alpha K nu nu' K'
//   corrected     Qhat = (1/T) [K0 nu nu' K0' + P0+ - P+_{k-1}] on the bias block (the bias does not flow, so Phi = I),
//                 Q <- (1 - alpha_k) Q + alpha_k Qhat,  alpha_k = max(alpha, 1/(k + 1)),  eigenvalues kept within bounds
// K0 and P0+ are of the plain Kalman correction: the inflated gain would feed its own inflation back.
#pragma once

#include "maths/covariance.hpp"
#include "maths/rotation.hpp"

#include <Eigen/Eigenvalues>

namespace hnav {

enum class Adaptation { off, paper, corrected };

struct AdaptationSettings {
    Adaptation mode = Adaptation::off;
    double gain = 0.02;
    double least = 0, most = 1; // bounds of the eigenvalues of Q_b, (rad/s)^2/s
};

inline Matrix3 adapt_as_printed(const Matrix3& Q, const AdaptationSettings& settings, const Vector3& bias_step) {
    return (1 - settings.gain) * Q + settings.gain * bias_step * bias_step.transpose();
}

// bias_step = K0 nu; posterior, previous: bias covariance after this and after the last correction; k = 1, 2, ...
inline Matrix3 adapt_corrected(const Matrix3& Q, const AdaptationSettings& settings, const Vector3& bias_step,
                               const Matrix3& posterior, const Matrix3& previous, double interval_s, double k) {
    const double alpha = std::fmax(settings.gain, 1 / (k + 1));
    const Matrix3 estimate = (bias_step * bias_step.transpose() + posterior - previous) / interval_s;
    const Matrix3 mixed = (1 - alpha) * Q + alpha * estimate;
    const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(mixed);
    const Vector3 bounded = eigen.eigenvalues().cwiseMax(settings.least).cwiseMin(settings.most);
    Matrix3 adapted = eigen.eigenvectors() * bounded.asDiagonal() * eigen.eigenvectors().transpose();
    symmetrise<3>(adapted);
    return adapted;
}

} // namespace hnav
