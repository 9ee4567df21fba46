// The equations of joint_fit.hpp with their weights and derivatives, for the fit and its error.
#pragma once

#include "calibration/decompositions.hpp"
#include "calibration/joint_fit.hpp"
#include "maths/square.hpp"

namespace hnav {

using Vector13 = VectorOf<13>; // nine elements of M row by row, three of o, sin(dip)
using Matrix13 = SquareOf<13>;
using Matrix3x13 = Eigen::Matrix<double, 3, 13>;

// with_force: without it the second equation has no weight.
inline void residuals(const Samples& s, const Correction& c, bool with_force, Values& length, Values& angle) {
    const Columns z = s.z(), a = s.a();
    const Values trust = s.trust();
    for (Index i = 0; i < s.count; ++i) {
        const Vector3 p = c.M * (z.col(i) - c.o);
        const double norm = p.norm();
        length[i] = norm - 1;
        // The residual of the direction alone: a shrinking M would otherwise reduce the residual of the second equation.
        angle[i] = with_force && trust[i] > 0 && norm > 0 ? a.col(i).dot(p) / norm + c.sin_dip : 0;
    }
}

// Scale of the residuals: their scatter, and the limit of a good sample in units of it (0: none).
struct Scales {
    double length, angle, outlier;
};

// Slope of weight times residual by the residual, over the weight, mean over the samples. Less than 1, because weights
// decrease: without it the information of the equations would be overestimated.
struct Slopes {
    double length = 1, angle = 1;
};

// Weight by the robust loss, divided by the variance.
inline double weight_of(double residual, double sigma, const Scales& scales) {
    return (scales.outlier > 0 ? geman_mcclure(residual, scales.outlier * sigma) : 1) / square(sigma);
}

// Weights of both equations from their residuals.
inline Scales weigh(double outlier_sigma, bool with_force, Samples& s) {
    const Values length = s.residual(), angle = s.angle(), trust = s.trust();
    Values weight = s.weight(), angle_weight = s.angle_weight(), scratch = s.scratch();
    const Scales scales{robust_sigma(length, scratch), robust_sigma(angle, scratch, &trust), outlier_sigma};
    for (Index i = 0; i < s.count; ++i) {
        weight[i] = weight_of(length[i], scales.length, scales);
        angle_weight[i] = with_force && trust[i] > 0 ? weight_of(angle[i], scales.angle, scales) : 0;
    }
    return scales;
}

inline Slopes slopes_of(const Samples& s, const Scales& scales) {
    if (!(scales.outlier > 0)) return {};
    const auto slope = [&](const Values& residual, const Values& weight, double sigma) {
        double weights = 0, slopes = 0;
        for (Index i = 0; i < s.count; ++i) {
            const double x2 = square(residual[i] / (scales.outlier * sigma));
            weights += weight[i];
            slopes += weight[i] * (1 - 3 * x2) / (1 + x2); // of the loss of Geman and McClure
        }
        return weights > 0 ? slopes / weights : 1;
    };
    return {slope(s.residual(), s.weight(), scales.length), slope(s.angle(), s.angle_weight(), scales.angle)};
}

// d(M d)/d(unknowns) for d = z - o.
inline Matrix3x13 J_corrected(const Correction& c, const Vector3& d) {
    Matrix3x13 J = Matrix3x13::Zero();
    for (int j = 0; j < 3; ++j) J.block<1, 3>(j, 3 * j) = d.transpose();
    J.block<3, 3>(0, 9) = -c.M;
    return J;
}

// Both equations of one sample: residuals and weights.
struct Equations {
    double length, weight, angle, angle_weight;
};

// Adds the equations of d = z - o and the force to the normal equations JtJ step = -Jtr. JtJ: lower triangle, may be null.
inline void accumulate(const Correction& c, const Vector3& d, const Vector3& force, const Equations& of, Matrix13* JtJ,
                       Vector13& Jtr, const Slopes& slopes = {}) {
    const Vector3 p = c.M * d;
    const double norm = p.norm();
    if (!(norm > 0)) return;
    const Vector3 along = p / norm;
    const Matrix3x13 J_p = J_corrected(c, d);
    const Vector13 J_length = J_p.transpose() * along;
    if (JtJ) JtJ->selfadjointView<Eigen::Lower>().rankUpdate(J_length, slopes.length * of.weight);
    Jtr += of.weight * of.length * J_length;
    if (!(of.angle_weight > 0)) return;
    Vector13 J_angle = J_p.transpose() * (force - along * along.dot(force)) / norm;
    J_angle[12] = 1;
    if (JtJ) JtJ->selfadjointView<Eigen::Lower>().rankUpdate(J_angle, slopes.angle * of.angle_weight);
    Jtr += of.angle_weight * of.angle * J_angle;
}

// The same for the samples from begin to end.
inline void accumulate(const Samples& s, const Correction& c, Index begin, Index end, Matrix13& JtJ, Vector13& Jtr,
                       const Slopes& slopes = {}) {
    for (Index i = begin; i < end; ++i)
        accumulate(c, s.z().col(i) - c.o, s.a().col(i), {s.residual()[i], s.weight()[i], s.angle()[i], s.angle_weight()[i]}, &JtJ,
                   Jtr, slopes);
}

inline void fill_upper(Matrix13& JtJ) { JtJ.triangularView<Eigen::StrictlyUpper>() = JtJ.transpose(); }

inline Correction moved(const Correction& c, const Vector13& step) {
    Correction next = c;
    for (int j = 0; j < 3; ++j) next.M.row(j) += step.segment<3>(3 * j).transpose();
    next.o += step.segment<3>(9);
    next.sin_dip += step[12];
    return next;
}

} // namespace hnav
