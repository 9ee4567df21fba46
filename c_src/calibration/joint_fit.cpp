#include "calibration/joint_fit.hpp"

#include "calibration/decompositions.hpp"

#include <Eigen/LU>

namespace hnav {
namespace {

using Vector13 = Eigen::Matrix<double, 13, 1>; // nine elements of M row by row, three of o, sin(dip)
using Matrix13 = Eigen::Matrix<double, 13, 13>;
using Matrix3x13 = Eigen::Matrix<double, 3, 13>;

constexpr int passes = 50;        // a few suffice once the weights have settled
constexpr double settled = 1e-12; // step in units of the field strength
constexpr Index blocks = 40;
constexpr int directions = 64;

double square(double x) { return x * x; }

// with_force: else the second equation counts for nothing.
void residuals(const Samples& s, const Correction& c, bool with_force, Values& length, Values& angle) {
    const Columns z = s.z(), a = s.a();
    const Values trust = s.trust();
    for (Index i = 0; i < s.count; ++i) {
        const Vector3 p = c.M * (z.col(i) - c.o);
        const double norm = p.norm();
        length[i] = norm - 1;
        // Of the direction alone: a shrinking M would otherwise satisfy the second equation ever better.
        angle[i] = with_force && trust[i] > 0 && norm > 0 ? a.col(i).dot(p) / norm + c.sin_dip : 0;
    }
}

// Weights of both equations from their residuals: of the loss, over the variance.
void weigh(double outlier_sigma, bool with_force, Samples& s) {
    const Values length = s.residual(), angle = s.angle(), trust = s.trust();
    Values weight = s.weight(), angle_weight = s.angle_weight(), scratch = s.scratch();
    const double sigma_length = robust_sigma(length, scratch);
    const double sigma_angle = robust_sigma(angle, scratch, &trust);
    const auto of = [&](double residual, double sigma) {
        return (outlier_sigma > 0 ? geman_mcclure(residual, outlier_sigma * sigma) : 1) / square(sigma);
    };
    for (Index i = 0; i < s.count; ++i) {
        weight[i] = of(length[i], sigma_length);
        angle_weight[i] = with_force && trust[i] > 0 ? of(angle[i], sigma_angle) : 0;
    }
}

double cost(const Samples& s) {
    const Values length = s.residual(), angle = s.angle(), weight = s.weight(), angle_weight = s.angle_weight();
    double sum = 0;
    for (Index i = 0; i < s.count; ++i) sum += weight[i] * square(length[i]) + angle_weight[i] * square(angle[i]);
    return sum;
}

// d(M d)/d(unknowns) for d = z - o.
Matrix3x13 J_corrected(const Correction& c, const Vector3& d) {
    Matrix3x13 J = Matrix3x13::Zero();
    for (int j = 0; j < 3; ++j) J.block<1, 3>(j, 3 * j) = d.transpose();
    J.block<3, 3>(0, 9) = -c.M;
    return J;
}

// Adds sample i to the normal equations JtJ step = -Jtr.
void accumulate(const Samples& s, const Correction& c, Index i, Matrix13& JtJ, Vector13& Jtr) {
    const Vector3 d = s.z().col(i) - c.o;
    const Vector3 p = c.M * d;
    const double norm = p.norm();
    if (!(norm > 0)) return;
    const Vector3 along = p / norm;
    const Matrix3x13 J_p = J_corrected(c, d);
    const double w = s.weight()[i], w_angle = s.angle_weight()[i];
    const Vector13 J_length = J_p.transpose() * along;
    JtJ.selfadjointView<Eigen::Lower>().rankUpdate(J_length, w);
    Jtr += w * s.residual()[i] * J_length;
    if (w_angle > 0) {
        const Vector3 force = s.a().col(i);
        Vector13 J_angle = J_p.transpose() * (force - along * along.dot(force)) / norm;
        J_angle[12] = 1;
        JtJ.selfadjointView<Eigen::Lower>().rankUpdate(J_angle, w_angle);
        Jtr += w_angle * s.angle()[i] * J_angle;
    }
}

Correction moved(const Correction& c, const Vector13& step) {
    Correction next = c;
    for (int j = 0; j < 3; ++j) next.M.row(j) += step.segment<3>(3 * j).transpose();
    next.o += step.segment<3>(9);
    next.sin_dip += step[12];
    return next;
}

// Directions spread evenly over the sphere: the spiral of Fibonacci.
Vector3 direction(int k) {
    const double z = 1 - (2 * k + 1.0) / directions;
    const double turn = k * M_PI * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
}

} // namespace

void refine(double outlier_sigma, bool with_force, Samples& s, Correction* c) {
    Values length = s.residual(), angle = s.angle();
    double damping = 1e-6;
    for (int pass = 0; pass < passes; ++pass) {
        residuals(s, *c, with_force, length, angle);
        weigh(outlier_sigma, with_force, s);
        const double before = cost(s);
        Matrix13 JtJ = Matrix13::Zero();
        Vector13 Jtr = Vector13::Zero();
        for (Index i = 0; i < s.count; ++i) accumulate(s, *c, i, JtJ, Jtr);
        JtJ.triangularView<Eigen::StrictlyUpper>() = JtJ.transpose();

        bool better = false;
        Vector13 step = Vector13::Zero();
        for (int attempt = 0; attempt < 8 && !better; ++attempt) {
            Matrix13 damped = JtJ;
            // The second term holds unknowns that no equation sees.
            damped.diagonal() += damping * (JtJ.diagonal() + Vector13::Constant(1e-6 * JtJ.trace()));
            step = -solve_symmetric(damped, Jtr);
            const Correction next = moved(*c, step);
            residuals(s, next, with_force, length, angle);
            better = cost(s) <= before;
            if (better) *c = next;
            damping = better ? std::fmax(damping / 10, 1e-12) : damping * 10;
        }
        if (!better || step.norm() < settled) break;
    }
}

double direction_sigma(double outlier_sigma, Unknowns unknowns, Samples& s, const Correction& c) {
    const bool with_force = unknowns == Unknowns::all;
    Values length = s.residual(), angle = s.angle();
    residuals(s, c, with_force, length, angle);
    weigh(outlier_sigma, with_force, s);
    // Neighbouring samples err alike (slow motion, acceleration, distorted places), so their number says little. The
    // covariance is that of sums over blocks of time, which need not be independent inside: the sandwich estimate with
    // clusters (Cameron and Miller 2015, "A practitioner's guide to cluster-robust inference", eq. 11).
    Matrix13 JtJ = Matrix13::Zero(), scores = Matrix13::Zero();
    for (Index b = 0; b < blocks; ++b) {
        Vector13 Jtr = Vector13::Zero();
        for (Index i = b * s.count / blocks; i < (b + 1) * s.count / blocks; ++i) accumulate(s, c, i, JtJ, Jtr);
        scores += Jtr * Jtr.transpose();
    }
    JtJ.triangularView<Eigen::StrictlyUpper>() = JtJ.transpose();
    // The fit moves in the columns of the basis only: unit vectors, as many as there are unknowns.
    Matrix13 vectors;
    symmetric_eigenvalues(JtJ, &vectors);
    Matrix13 basis = Matrix13::Zero();
    int count = 13;
    if (unknowns == Unknowns::centre_and_radius) {
        count = 4;
        for (int j = 0; j < 3; ++j) {
            basis(4 * j, 0) = 1 / std::sqrt(3.0); // the diagonal of M
            basis(9 + j, 1 + j) = 1;
        }
    } else {
        // Without force the four weakest directions are the rotation and the dip, which no equation sees.
        count = with_force ? 13 : 9;
        basis.leftCols(count) = vectors.rightCols(count);
    }
    Matrix13 information = basis.transpose() * JtJ * basis;
    for (int k = count; k < 13; ++k) information(k, k) = 1; // what is left out stands apart
    const Matrix13 bread = basis * solve_symmetric(information, Matrix13(basis.transpose()));
    const Matrix13 covariance =
        bread * scores * bread * (blocks / (blocks - double(count))); // they were fitted to the same blocks

    const Matrix3 M_inverse = c.M.inverse();
    double variance = 0;
    for (int k = 0; k < directions; ++k) {
        const Vector3 p = direction(k);
        Matrix3x13 across = J_corrected(c, M_inverse * p);
        across -= p * (p.transpose() * across).eval(); // a change of length turns nothing
        variance += (across * covariance * across.transpose()).trace() / directions;
    }
    return std::sqrt(variance);
}

} // namespace hnav
