#include "calibration/direction_error.hpp"

#include "calibration/joint_equations.hpp"

#include <Eigen/LU>

namespace hnav {
namespace {

constexpr Index blocks = 40;
constexpr int directions = 64, gap_directions = 400;
constexpr double gap_share = 0.01; // share of samples allowed in a gap: a few outliers do not fill it
// Quantile of the normal distribution for 95 of 100: a margin over the promised nine of ten, since the covariance is estimated.
constexpr double promised = 1.6449;

// Directions spread evenly over the sphere: the spiral of Fibonacci.
Vector3 direction(int k, int count = directions) {
    const double z = 1 - (2 * k + 1.0) / count;
    const double turn = k * M_PI * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
}

// The directions in which a fit may move: the first columns of the basis, unit vectors.
struct Freedom {
    Matrix13 basis = Matrix13::Zero();
    int count = 0;
};

Freedom freedom_of(Unknowns unknowns, const Matrix13& JtJ) {
    Freedom of;
    if (unknowns == Unknowns::centre_and_radius) {
        of.count = 4;
        for (int j = 0; j < 3; ++j) {
            of.basis(4 * j, 0) = 1 / std::sqrt(3.0); // the diagonal of M
            of.basis(9 + j, 1 + j) = 1;
        }
        return of;
    }
    // Without force the four weakest directions are the rotation and the dip, which no equation determines.
    of.count = unknowns == Unknowns::all ? 13 : 9;
    Matrix13 vectors;
    symmetric_eigenvalues(JtJ, &vectors);
    of.basis.leftCols(of.count) = vectors.rightCols(of.count);
    return of;
}

// JtJ^-1 right within the free unknowns.
Vector13 solve_within(const Freedom& of, const Matrix13& JtJ, const Vector13& right) {
    Matrix13 information = of.basis.transpose() * JtJ * of.basis;
    for (int k = of.count; k < 13; ++k) information(k, k) = 1; // omitted unknowns are decoupled
    return of.basis * solve_symmetric(information, Vector13(of.basis.transpose() * right));
}

// Mean square rotation of directions by a step of the unknowns, over the sphere: step' W step.
Matrix13 turn_of_steps(const Correction& c) {
    const Matrix3 M_inverse = c.M.inverse();
    Matrix13 W = Matrix13::Zero();
    for (int k = 0; k < directions; ++k) {
        const Vector3 p = direction(k);
        Matrix3x13 across = J_corrected(c, M_inverse * p);
        across -= p * (p.transpose() * across).eval(); // a change of length is no rotation
        W += across.transpose() * across / directions;
    }
    return W;
}

// The nearest sample of field and force that the correction explains exactly.
struct Clean {
    Vector3 p, force;
    bool with_force;
};

Clean clean_sample(const Samples& s, const Correction& c, Index i, bool with_force) {
    Clean clean{(c.M * (s.z().col(i) - c.o)).normalized(), s.a().col(i), with_force && s.trust()[i] > 0};
    if (!clean.with_force) return clean;
    const Vector3 across = clean.p - clean.force * clean.force.dot(clean.p);
    const double length2 = across.squaredNorm();
    if (length2 > 0) clean.force = (clean.force - (clean.force.dot(clean.p) + c.sin_dip) / length2 * across).normalized();
    return clean;
}

// Adds the equations of a sample at a displaced field and force.
void add_moved(const Correction& c, const Matrix3& M_inverse, const Scales& scales, const Clean& clean, const Vector3& field_step,
               const Vector3& force_step, Vector13& Jtr) {
    const Vector3 p = clean.p + field_step, force = clean.force + force_step;
    Equations of{p.norm() - 1, 0, 0, 0};
    of.weight = weight_of(of.length, scales.length, scales);
    if (clean.with_force) {
        of.angle = force.dot(p) / p.norm() + c.sin_dip;
        of.angle_weight = weight_of(of.angle, scales.angle, scales);
    }
    accumulate(c, M_inverse * p, force, of, nullptr, Jtr);
}

// Mean of the equations over the noise of the samples without outliers; it is zero where noise has no bias. Along each axis a
// second difference with a step of sqrt(3) sigma, exact to the fourth power.
Vector13 push_of_noise(const Samples& s, const Correction& c, bool with_force, const Scales& scales) {
    const Matrix3 M_inverse = c.M.inverse();
    const double field = std::sqrt(3.0) * scales.length;
    // Scatter of the angle beyond the field's noise is noise of the force.
    const double force2 = square(scales.angle) - square(scales.length) * (1 - square(c.sin_dip));
    const double force = std::sqrt(3.0 * std::fmax(force2, 0));
    const double limit = (scales.outlier > 0 ? scales.outlier : INFINITY) * scales.length;
    Vector13 sum = Vector13::Zero();
    for (Index i = 0; i < s.count; ++i) {
        if (!(std::fabs(s.residual()[i]) <= limit)) continue;
        const Clean clean = clean_sample(s, c, i, with_force);
        // Axes that turn with the sensor: along the field, across it and the force, or the offset, and across both.
        const Vector3 across = clean.p.cross(clean.with_force ? clean.force : c.o).normalized();
        const Vector3 none = Vector3::Zero(), field_axes[] = {clean.p, across, clean.p.cross(across)};
        const Vector3 force_axes[] = {across, clean.force.cross(across)};
        for (const double sign : {-1., 1.}) {
            for (const Vector3& axis : field_axes) add_moved(c, M_inverse, scales, clean, sign * field * axis, none, sum);
            if (clean.with_force)
                for (const Vector3& axis : force_axes) add_moved(c, M_inverse, scales, clean, none, sign * force * axis, sum);
        }
    }
    return sum / 6;
}

} // namespace

double take_off_push(double outlier_sigma, Unknowns unknowns, Samples& s, Correction* c) {
    const bool with_force = unknowns == Unknowns::all;
    Values length = s.residual(), angle = s.angle();
    residuals(s, *c, with_force, length, angle);
    const Scales scales = weigh(outlier_sigma, with_force, s);
    Matrix13 JtJ = Matrix13::Zero();
    Vector13 Jtr = Vector13::Zero();
    accumulate(s, *c, 0, s.count, JtJ, Jtr, slopes_of(s, scales));
    fill_upper(JtJ);
    const Vector13 step = solve_within(freedom_of(unknowns, JtJ), JtJ, push_of_noise(s, *c, with_force, scales));
    const double turned = std::sqrt(step.dot(turn_of_steps(*c) * step));
    if (step.allFinite()) *c = moved(*c, step);
    return turned;
}

double direction_error(double outlier_sigma, Unknowns unknowns, Samples& s, const Correction& c) {
    const bool with_force = unknowns == Unknowns::all;
    Values length = s.residual(), angle = s.angle();
    residuals(s, c, with_force, length, angle);
    const Slopes slopes = slopes_of(s, weigh(outlier_sigma, with_force, s));
    // Neighbouring samples have correlated errors (slow motion, acceleration, distorted places), so their number is no measure of
    // information, and a few samples may determine an unknown. Each block of time is omitted in turn, and the change of the fit is the
    // measure: the jackknife with clusters (Cameron and Miller 2015, "A practitioner's guide to cluster-robust inference",
    // section VI.B).
    Matrix13 JtJ = Matrix13::Zero();
    Vector13 whole = Vector13::Zero();
    accumulate(s, c, 0, s.count, JtJ, whole, slopes);
    fill_upper(JtJ);
    const Freedom freedom = freedom_of(unknowns, JtJ);
    Matrix13 covariance = Matrix13::Zero();
    for (Index b = 0; b < blocks; ++b) {
        Matrix13 block = Matrix13::Zero();
        Vector13 Jtr = Vector13::Zero();
        accumulate(s, c, b * s.count / blocks, (b + 1) * s.count / blocks, block, Jtr, slopes);
        fill_upper(block);
        const Vector13 step = solve_within(freedom, JtJ - block, Jtr);
        covariance += (blocks - 1.0) / blocks * step * step.transpose();
    }
    // A sum of squares of normal errors, of which each pair of moments fits a chi square of so many degrees of freedom
    // (Satterthwaite), and its quantile by Wilson and Hilferty.
    const Matrix13 squares = covariance * turn_of_steps(c);
    const double mean = squares.trace(), freedoms = square(mean) / (squares * squares).trace();
    const double share = 2 / (9 * freedoms);
    const double root = 1 - share + promised * std::sqrt(share);
    return std::sqrt(mean * root * root * root);
}

Gap largest_gap(const Columns& u, const Values& use, Values& lengths, Values& scratch) {
    for (Index i = 0; i < u.cols(); ++i) lengths[i] = use[i] > 0 ? u.col(i).norm() : 0;
    Gap largest{Vector3::UnitX(), -1};
    for (int k = 0; k < gap_directions; ++k) {
        const Vector3 p = direction(k, gap_directions);
        Index known = 0;
        for (Index i = 0; i < u.cols(); ++i)
            if (lengths[i] > 0) scratch[known++] = -p.dot(u.col(i)) / lengths[i];
        const double angle = std::acos(std::fmax(-1, std::fmin(1, -quantile(scratch.data(), known, gap_share))));
        if (angle > largest.angle_rad) largest = {p, angle};
    }
    return largest;
}

double direction_difference(const Correction& one, const Correction& other) {
    const Matrix3 M_inverse = one.M.inverse();
    double squares = 0;
    for (int k = 0; k < directions; ++k) {
        const Vector3 p = direction(k), q = other.M * (M_inverse * p + one.o - other.o);
        squares += square(std::atan2(p.cross(q).norm(), p.dot(q))) / directions;
    }
    return std::sqrt(squares);
}

} // namespace hnav
