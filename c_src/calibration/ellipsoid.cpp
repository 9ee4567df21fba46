#include "calibration/ellipsoid.hpp"

#include "calibration/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace hnav {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector10 = Eigen::Matrix<double, 10, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix64 = Eigen::Matrix<double, 6, 4>;
using Matrix10 = Eigen::Matrix<double, 10, 10>;

constexpr int reweightings = 10; // the weights converge long before

// Monomials of the quadric p . (x2 y2 z2 2yz 2xz 2xy 2x 2y 2z 1) = 0.
Vector10 monomials(const Vector3& v) {
    Vector10 d;
    d << v[0] * v[0], v[1] * v[1], v[2] * v[2], 2 * v[1] * v[2], 2 * v[0] * v[2], 2 * v[0] * v[1], 2 * v[0], 2 * v[1], 2 * v[2],
        1;
    return d;
}

// Inverse of the constraint 4J - I^2 = 1 of Li and Griffiths ("Least squares ellipsoid specific fitting", 2004, eq. 11):
// every quadric that keeps it is an ellipsoid, so noise cannot turn the fit into a hyperboloid.
Matrix6 inverse_constraint() {
    Matrix3 C;
    C << -1, 1, 1, 1, -1, 1, 1, 1, -1;
    Matrix6 inverse = Matrix6::Zero();
    inverse.topLeftCorner<3, 3>() = C.inverse();
    inverse.bottomRightCorner<3, 3>().diagonal().setConstant(-0.25);
    return inverse;
}

// Least squares of the quadric under the constraint: the eigenvector of the only positive eigenvalue of the 6 x 6 problem
// that remains after elimination of the linear terms (their eq. 15).
bool solve_quadric(const Matrix10& S, Ellipsoid* e) {
    const Matrix64 S12 = S.topRightCorner<6, 4>();
    const Eigen::FullPivLU<Eigen::Matrix4d> lu(S.bottomRightCorner<4, 4>());
    if (!lu.isInvertible()) return false;
    const Eigen::Matrix<double, 4, 6> X = lu.solve(S12.transpose());
    Vector6 quadratic;
    if (!largest_eigenvector(inverse_constraint() * (S.topLeftCorner<6, 6>() - S12 * X), &quadratic)) return false;
    const Eigen::Vector4d linear = -X * quadratic;

    Matrix3 A;
    A << quadratic[0], quadratic[5], quadratic[4], quadratic[5], quadratic[1], quadratic[3], quadratic[4], quadratic[3],
        quadratic[2];
    const Eigen::FullPivLU<Matrix3> lu_A(A);
    if (!lu_A.isInvertible()) return false;
    e->centre = -lu_A.solve(linear.head<3>());
    // Either sign of the eigenvector is the same surface: the division gives A the sign for a right side of 1.
    A /= e->centre.dot(A * e->centre) - linear[3];
    const Eigen::LLT<Matrix3> llt(A);
    if (llt.info() != Eigen::Success) return false;
    e->root = llt.matrixU();
    return e->centre.allFinite() && e->root.allFinite();
}

} // namespace

bool fit_ellipsoid(const Columns& z, double outlier_sigma, Values& weight, Values& residual, Values& scratch, Ellipsoid* e) {
    weight.setOnes();
    const int passes = outlier_sigma > 0 ? reweightings : 1;
    for (int pass = 0; pass < passes; ++pass) {
        Matrix10 S = Matrix10::Zero();
        for (Index i = 0; i < z.cols(); ++i) {
            const Vector10 d = monomials(z.col(i));
            S.noalias() += weight[i] * d * d.transpose();
        }
        S /= weight.sum();
        // An exact ellipsoid leaves one eigenvalue of zero. When the next is small as well, another quadric fits nearly
        // as well, and the data do not distinguish them.
        const Vector10 eigenvalues = symmetric_eigenvalues(S, nullptr);
        const double second = std::fmax(eigenvalues[1], 1e-300);
        e->condition = eigenvalues[9] / second;
        e->ambiguity = std::fmax(eigenvalues[0], 0) / second;
        if (!solve_quadric(S, e)) return false;
        if (outlier_sigma <= 0) return true;
        for (Index i = 0; i < z.cols(); ++i) residual[i] = (e->root * (z.col(i) - e->centre)).norm() - 1;
        const double limit = outlier_sigma * robust_sigma(residual, scratch);
        for (Index i = 0; i < z.cols(); ++i) weight[i] = geman_mcclure(residual[i], limit);
    }
    return true;
}

Sphere fit_sphere(const Columns& z, double outlier_sigma, double thin, Values& weight, Values& residual, Values& scratch) {
    Sphere sphere{Vector3::Zero(), Matrix3::Zero(), 0};
    weight.setOnes();
    const int passes = outlier_sigma > 0 ? reweightings : 1;
    for (int pass = 0; pass < passes; ++pass) {
        const double total = weight.sum();
        Vector3 mean = Vector3::Zero();
        double mean_square = 0;
        for (Index i = 0; i < z.cols(); ++i) {
            mean += weight[i] / total * z.col(i);
            mean_square += weight[i] / total * z.col(i).squaredNorm();
        }
        // |z - o|^2 = r^2 is linear in o once the mean is subtracted:  2 cov(z, z) o = cov(z, |z|^2).
        Matrix3 covariance = Matrix3::Zero();
        Vector3 right = Vector3::Zero();
        for (Index i = 0; i < z.cols(); ++i) {
            const Vector3 d = z.col(i) - mean;
            covariance += weight[i] / total * d * d.transpose();
            right += weight[i] / total * 0.5 * (z.col(i).squaredNorm() - mean_square) * d;
        }
        Matrix3 axes;
        const Vector3 spreads2 = symmetric_eigenvalues(covariance, &axes);
        // Directions with hardly any spread of the samples are omitted.
        Matrix3 inverse = Matrix3::Zero();
        sphere.plane = Matrix3::Zero();
        sphere.axes = 0;
        for (int k = 0; k < 3; ++k) {
            const double spread2 = spreads2[k];
            if (!(spread2 > thin * thin * spreads2[2])) continue;
            const Vector3 axis = axes.col(k);
            inverse += axis * axis.transpose() / spread2;
            sphere.plane += axis * axis.transpose();
            ++sphere.axes;
        }
        sphere.centre = inverse * right + (Matrix3::Identity() - sphere.plane) * mean;
        if (outlier_sigma <= 0) break;
        for (Index i = 0; i < z.cols(); ++i) scratch[i] = residual[i] = (sphere.plane * (z.col(i) - sphere.centre)).norm();
        const double radius = median(scratch.data(), z.cols());
        for (Index i = 0; i < z.cols(); ++i) residual[i] = residual[i] / radius - 1;
        const double limit = outlier_sigma * robust_sigma(residual, scratch);
        for (Index i = 0; i < z.cols(); ++i) weight[i] = geman_mcclure(residual[i], limit);
    }
    return sphere;
}

} // namespace hnav
