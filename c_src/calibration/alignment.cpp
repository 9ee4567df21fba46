#include "calibration/alignment.hpp"

#include "calibration/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/SVD>

namespace hnav {
namespace {

using Vector10 = Eigen::Matrix<double, 10, 1>;
using Matrix10 = Eigen::Matrix<double, 10, 10>;

constexpr int passes = 30;
constexpr double converged = 1e-12; // rad: a step below is rounding

Matrix3 nearest_rotation(const Matrix3& X) {
    const Eigen::JacobiSVD<Matrix3> svd(X, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Matrix3 &U = svd.matrixU(), &V = svd.matrixV();
    return U * Vector3(1, 1, (U * V.transpose()).determinant() < 0 ? -1 : 1).asDiagonal() * V.transpose();
}

// a . R u + sin(dip), which is zero for a perfect rotation.
void residuals(const Columns& u, const Columns& a, const Alignment& at, Values& residual) {
    for (Index i = 0; i < u.cols(); ++i) residual[i] = a.col(i).dot(at.R * u.col(i)) + at.sin_dip;
}

// Gauss-Newton on the rotation group, R <- exp(phi) R, with robust weights; returns the robust scale it ends at.
double refine(const Columns& u, const Columns& a, const Values& use, double outlier_sigma, Values& residual, Values& scratch,
              Alignment* at) {
    double sum = 0, count = 0;
    residuals(u, a, {at->R, 0, 0}, residual);
    for (Index i = 0; i < u.cols(); ++i)
        if (use[i] > 0) sum += residual[i], ++count;
    at->sin_dip = -sum / count;
    for (int pass = 0; pass < passes; ++pass) {
        residuals(u, a, *at, residual);
        const double limit = outlier_sigma * robust_sigma(residual, scratch, &use);
        Eigen::Matrix4d JtJ = Eigen::Matrix4d::Zero();
        Eigen::Vector4d Jtr = Eigen::Vector4d::Zero();
        for (Index i = 0; i < u.cols(); ++i) {
            if (!(use[i] > 0)) continue;
            const double weight = outlier_sigma > 0 ? geman_mcclure(residual[i], limit) : 1;
            Eigen::Vector4d J;
            J << (at->R * u.col(i)).cross(a.col(i)), 1;
            JtJ += weight * J * J.transpose();
            Jtr += weight * J * residual[i];
        }
        JtJ.diagonal() *= 1 + 1e-9; // keeps the step finite where a direction is not observable
        const Eigen::Vector4d step = -JtJ.ldlt().solve(Jtr);
        if (!step.allFinite()) break;
        const Quaternion turn = rotation_quaternion(step.head<3>());
        at->R = rotation_matrix(turn.normalized()) * at->R;
        at->sin_dip += step[3];
        if (step.norm() < converged) break;
    }
    residuals(u, a, *at, residual);
    return robust_sigma(residual, scratch, &use);
}

} // namespace

bool align(const Columns& u, const Columns& a, const Values& use, double outlier_sigma, Values& residual, Values& scratch,
           Alignment* best) {
    // Linear in the nine elements of R and the dip if R need not be a rotation: the null direction of the rows
    // (a u', 1) is the solution up to scale and sign.
    Matrix10 S = Matrix10::Zero();
    Index count = 0;
    for (Index i = 0; i < u.cols(); ++i) {
        if (!(use[i] > 0)) continue;
        Vector10 row;
        for (int j = 0; j < 3; ++j) row.segment<3>(3 * j) = a(j, i) * u.col(i);
        row[9] = 1;
        S.noalias() += row * row.transpose();
        ++count;
    }
    if (count == 0) return false;
    Matrix10 vectors;
    const Vector10 eigenvalues = symmetric_eigenvalues(S, &vectors);
    const Vector10 unseen = vectors.col(0);
    Matrix3 X;
    for (int j = 0; j < 3; ++j) X.row(j) = unseen.segment<3>(3 * j).transpose();

    // A disturbed force can spoil the linear start. The identity is a third candidate: chips are rarely misaligned by
    // much.
    const Matrix3 starts[] = {nearest_rotation(X), nearest_rotation(-X), Matrix3::Identity()};
    double least = INFINITY;
    for (const Matrix3& start : starts) {
        Alignment candidate{start, 0, 0};
        const double sigma = refine(u, a, use, outlier_sigma, residual, scratch, &candidate);
        if (!(sigma < least)) continue;
        least = sigma;
        *best = candidate;
    }
    best->condition = eigenvalues[9] / std::fmax(eigenvalues[1], 1e-300);
    return least < INFINITY;
}

} // namespace hnav
