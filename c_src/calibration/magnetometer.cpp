#include "calibration/magnetometer.hpp"

#include "calibration/alignment.hpp"
#include "calibration/ellipsoid.hpp"
#include "calibration/joint_fit.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <limits>

namespace hnav {
namespace {

constexpr double thin = 0.1;          // out-of-plane over in-plane spread below which samples count as flat
constexpr double new_attitude = 0.05; // change of field or gravity, relative, that makes a sample a new one
constexpr double round_enough = 0.2;  // scatter about a sphere, in radii; soft iron causes less
// Conditions to use the force: largest dip spread with its rotation, and largest ratio to the spread without.
constexpr double gravity_spread_rad = 3 * M_PI / 180;
constexpr double rotation_gain = 0.9;
constexpr double push_unknown = 0.5;
constexpr double least_tilt_rad = 25 * M_PI / 180;
constexpr double useless_rad = 10 * M_PI / 180; // with a rotation that was not estimated: chips are misaligned by less
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// Dip of a field u (n columns) where the force is accepted: median and robust standard deviation.
void dip_figures(const Columns& u, const Samples& s, double* dip_rad, double* spread_rad) {
    const Columns a = s.a();
    const Values trust = s.trust();
    Values angle = s.angle(), scratch = s.scratch();
    Index known = 0;
    for (Index i = 0; i < s.count; ++i) {
        const double length = u.col(i).norm();
        if (!(trust[i] > 0) || !(length > 0)) continue;
        angle[known] = std::asin(std::fmin(1, std::fmax(-1, -a.col(i).dot(u.col(i)) / length)));
        scratch[known] = angle[known];
        ++known;
    }
    *dip_rad = *spread_rad = not_a_number;
    if (known == 0) return;
    *dip_rad = median(scratch.data(), known);
    for (Index i = 0; i < known; ++i) scratch[i] = std::fabs(angle[i] - *dip_rad);
    // The upper quartile, over its value for a normal distribution: three quarters must agree, not only half, because a
    // sensor in motion is often at one attitude for half of its time.
    *spread_rad = quantile(scratch.data(), known, 0.75) / 1.1503;
}

// Scatter of |u| about its mean, relative to it, over the samples that are no outliers.
double length_scatter(const Columns& u, const Values& inlier) {
    double count = 0, sum = 0, squares = 0;
    for (Index i = 0; i < u.cols(); ++i)
        if (inlier[i] > 0) sum += u.col(i).norm(), ++count;
    const double mean = sum / count;
    for (Index i = 0; i < u.cols(); ++i)
        if (inlier[i] > 0) squares += (u.col(i).norm() / mean - 1) * (u.col(i).norm() / mean - 1);
    return std::sqrt(squares / count);
}

// 1 for directions spread evenly over the sphere, 0 for directions in a plane.
double coverage_of(const Columns& u) {
    Matrix3 moment = Matrix3::Zero();
    double count = 0;
    for (Index i = 0; i < u.cols(); ++i) {
        const double length = u.col(i).norm();
        if (!(length > 0)) continue;
        const Vector3 direction = u.col(i) / length;
        moment += direction * direction.transpose();
        ++count;
    }
    return 3 * Eigen::SelfAdjointEigenSolver<Matrix3>(moment / count, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

// True when the samples lie near a plane.
bool is_flat(const Columns& z) {
    Matrix3 covariance = Matrix3::Zero();
    for (Index i = 0; i < z.cols(); ++i) covariance += z.col(i) * z.col(i).transpose();
    const Vector3 spread = Eigen::SelfAdjointEigenSolver<Matrix3>(covariance, Eigen::EigenvaluesOnly).eigenvalues();
    return !(spread[0] > thin * thin * spread[2]);
}

double dip_spread(const Correction& correction, const Samples& s) {
    const Columns z = s.z();
    Columns u = s.u();
    for (Index i = 0; i < s.count; ++i) u.col(i) = correction.M * (z.col(i) - correction.o);
    double dip_rad, spread_rad;
    dip_figures(u, s, &dip_rad, &spread_rad);
    return spread_rad;
}

// The factor of the same ellipsoid with the smallest rotation of the field: P of the polar decomposition M = R P.
Matrix3 symmetric_factor(const Matrix3& M) {
    const Eigen::JacobiSVD<Matrix3> svd(M, Eigen::ComputeFullV);
    return svd.matrixV() * svd.singularValues().asDiagonal() * svd.matrixV().transpose();
}

// Marks the samples within the limit in s.weight and fills in the figures of merit. u: corrected fields.
void judge(double outlier_sigma, const Vector3& middle, Samples& s, const Columns& z, MagnetometerCalibration* c) {
    Values inlier = s.weight(), residual = s.residual(), angle = s.angle(), scratch = s.scratch();
    const double limit = outlier_sigma * robust_sigma(residual, scratch);
    double outliers = 0;
    for (Index i = 0; i < s.count; ++i) {
        inlier[i] = std::fabs(residual[i]) <= limit;
        outliers += !(inlier[i] > 0);
    }
    c->outlier_fraction = outliers / static_cast<double>(s.count);
    const Columns u = s.u();
    c->residual_after = length_scatter(u, inlier);
    c->coverage = coverage_of(u);
    c->gap = largest_gap(u, inlier, angle, scratch);
    dip_figures(u, s, &c->dip_rad, &c->dip_spread_after_rad);
    Columns raw = s.u();
    for (Index i = 0; i < s.count; ++i) raw.col(i) = z.col(i) + middle;
    c->residual_before = length_scatter(raw, inlier);
    double dip_before;
    dip_figures(raw, s, &dip_before, &c->dip_spread_before_rad);
}

// The refined fit without its bias by noise, and its error. The bias is known to half of its size.
double refined_error(double loss_sigma, Unknowns unknowns, Samples& s, Correction* correction) {
    refine(loss_sigma, unknowns == Unknowns::all, s, correction);
    const double pushed = take_off_push(loss_sigma, unknowns, s, correction);
    if (unknowns == Unknowns::no_rotation) correction->M = symmetric_factor(correction->M);
    return std::hypot(direction_error(loss_sigma, unknowns, s, *correction), push_unknown * pushed);
}

// The rotation between field and force, if gravity determines one; it replaces the symmetric correction.
// A force whose angle to the field is not constant is not gravity. A rotation that explains little of the scatter has been
// fitted to other errors (variation of the field with position, accelerations), and an inaccurate one does harm: chips are
// rarely misaligned by much. The error of an omitted rotation is included in the stated error.
void turn_by_gravity(const hnav_magnetometer_options& options, double loss_sigma, const Ellipsoid& ellipsoid,
                     const Alignment& alignment, Samples& s, Correction* correction, MagnetometerCalibration* c) {
    Correction turned{alignment.R * ellipsoid.root, ellipsoid.centre, alignment.sin_dip};
    const double error = refined_error(loss_sigma, Unknowns::all, s, &turned);
    if (!(turned.M.determinant() > 0)) {
        c->rotation = Rotation::not_gravity;
        return;
    }
    const double spread = dip_spread(turned, s);
    c->rotation = !(spread < gravity_spread_rad)                           ? Rotation::not_gravity
                  : !(error <= options.max_direction_sigma_rad)            ? Rotation::uncertain
                  : !(spread < rotation_gain * dip_spread(*correction, s)) ? Rotation::explains_little
                                                                           : Rotation::found;
    c->rotation_rad = direction_difference(turned, *correction);
    if (c->rotation == Rotation::found) *correction = turned;
    c->direction_sigma_rad =
        c->rotation == Rotation::found ? error : std::hypot(c->direction_sigma_rad, std::hypot(error, c->rotation_rad));
}

// The ellipsoid through the samples, refined, and turned by gravity if that is observable.
FitRefusal find_correction(const hnav_magnetometer_options& options, Samples& s, Correction* correction,
                           MagnetometerCalibration* c) {
    const Columns z = s.z();
    Columns u = s.u();
    Values weight = s.weight(), residual = s.residual(), scratch = s.scratch(), angle = s.angle();
    const double loss_sigma = options.robust ? options.outlier_sigma : 0;
    if (is_flat(z)) return FitRefusal::planar;

    Ellipsoid ellipsoid{};
    const bool fits = fit_ellipsoid(z, loss_sigma, weight, residual, scratch, &ellipsoid);
    c->condition = ellipsoid.condition;
    c->ambiguity = ellipsoid.ambiguity;
    if (c->condition > options.max_condition || c->ambiguity > options.max_ambiguity) return FitRefusal::ill_conditioned;
    if (!fits) return FitRefusal::not_an_ellipsoid;
    for (Index i = 0; i < s.count; ++i) u.col(i) = ellipsoid.root * (z.col(i) - ellipsoid.centre);

    *correction = {ellipsoid.root, ellipsoid.centre, 0};
    Alignment alignment{};
    const bool enough = c->force_samples >= options.min_samples;
    const bool aligned = enough && align(u, s.a(), s.trust(), loss_sigma, angle, scratch, &alignment) &&
                         alignment.condition <= options.max_condition;
    c->rotation = enough ? Rotation::uncertain : Rotation::no_gravity;
    c->shape_sigma_rad = c->direction_sigma_rad = refined_error(loss_sigma, Unknowns::no_rotation, s, correction);
    if (!(correction->M.allFinite() && correction->o.allFinite() && correction->M.determinant() > 0))
        return FitRefusal::not_an_ellipsoid;
    if (aligned) turn_by_gravity(options, loss_sigma, ellipsoid, alignment, s, correction, c);
    return FitRefusal::none;
}

// Whether the correction is accepted: its shape, its uncertainty, and the corrected samples.
FitRefusal judge_correction(const hnav_magnetometer_options& options, const Vector3& middle_z, const Correction& correction,
                            Samples& s, MagnetometerCalibration* c) {
    const Columns z = s.z();
    Columns u = s.u();
    Values residual = s.residual(), angle = s.angle(), scratch = s.scratch();
    // Gravity measures the tilt of the sensor, independent of outliers of the field that seem to cover the sphere.
    if (c->force_samples >= options.min_samples) {
        c->tilt_rad = M_PI - largest_gap(s.a(), s.trust(), angle, scratch).angle_rad;
        if (c->tilt_rad < least_tilt_rad) return FitRefusal::little_tilt;
    }
    const Vector3 inverse_axes = Eigen::JacobiSVD<Matrix3>(correction.M).singularValues();
    c->axis_ratio = inverse_axes[0] / inverse_axes[2];
    if (!(c->axis_ratio <= options.max_axis_ratio)) return FitRefusal::stretched;
    const double error = c->rotation == Rotation::found ? c->direction_sigma_rad : c->shape_sigma_rad;
    if (!(error <= options.max_direction_sigma_rad && c->direction_sigma_rad <= useless_rad)) return FitRefusal::uncertain;

    for (Index i = 0; i < s.count; ++i) {
        u.col(i) = correction.M * (z.col(i) - correction.o);
        residual[i] = u.col(i).norm() - 1;
    }
    judge(options.outlier_sigma, middle_z, s, z, c);
    if (c->coverage < options.min_coverage) return FitRefusal::little_coverage;
    if (c->residual_after > c->residual_before) return FitRefusal::worse;
    return FitRefusal::none;
}

// middle: mean of the field, scale: what z was divided by.
FitRefusal full_fit(const hnav_magnetometer_options& options, const Vector3& middle, double scale, Samples& s,
                    MagnetometerCalibration* c) {
    Correction correction{};
    if (const FitRefusal why = find_correction(options, s, &correction, c); why != FitRefusal::none) return why;
    if (const FitRefusal why = judge_correction(options, middle / scale, correction, s, c); why != FitRefusal::none) return why;

    // The ellipsoid has no unit: with a determinant of 1 the mean strength over all directions is unchanged.
    const double size = std::cbrt(correction.M.determinant());
    c->offset = middle + scale * correction.o;
    c->matrix = correction.M / size;
    c->strength = scale / size;
    c->offset_axes = 3;
    c->full = true;
    return FitRefusal::none;
}

// False if the centre of a circle is not determined, or too inaccurate.
bool hard_iron_fit(const hnav_magnetometer_options& options, const Vector3& middle, double scale, Samples& s,
                   MagnetometerCalibration* c) {
    const Columns z = s.z();
    Values weight = s.weight(), residual = s.residual(), scratch = s.scratch();
    const double loss_sigma = options.robust ? options.outlier_sigma : 0;
    const Sphere sphere = fit_sphere(z, loss_sigma, thin, weight, residual, scratch);
    if (sphere.axes < 2 || !sphere.centre.allFinite()) return false;
    // Across the plane of flat samples the field is unchanged.
    c->offset = sphere.plane * (middle + scale * sphere.centre);
    c->matrix.setIdentity();
    c->offset_axes = sphere.axes;
    c->full = false;
    Columns u = s.u();
    for (Index i = 0; i < s.count; ++i) scratch[i] = residual[i] = (sphere.plane * (z.col(i) - sphere.centre)).norm();
    const double radius = median(scratch.data(), s.count);
    for (Index i = 0; i < s.count; ++i) {
        residual[i] = residual[i] / radius - 1;
        u.col(i) = z.col(i) + (middle - c->offset) / scale;
        scratch[i] = u.col(i).norm();
    }
    c->strength = scale * median(scratch.data(), s.count);
    judge(options.outlier_sigma, middle / scale, s, z, c);
    // For samples that fill a disc or a cap every sphere fits equally badly.
    if (!(robust_sigma(residual, scratch) < round_enough) || c->residual_after > c->residual_before) return false;
    c->direction_sigma_rad = not_a_number; // the direction out of a plane is not determined
    if (sphere.axes < 3) return true;
    const Correction correction{Matrix3::Identity() / radius, sphere.centre, 0};
    c->direction_sigma_rad = direction_error(loss_sigma, Unknowns::centre_and_radius, s, correction);
    return c->direction_sigma_rad <= options.max_direction_sigma_rad;
}

} // namespace

bool calibrate_magnetometer(Index n, const double* field, const double* force, const hnav_magnetometer_options& options,
                            MagnetometerCalibration* c, FitRefusal* refusal) {
    Samples s(n);
    if (!s) {
        *refusal = FitRefusal::no_memory;
        return false;
    }
    gather(n, field, force, s);
    c->samples = s.count;
    drop_wild(s);
    Vector3 middle;
    double scale;
    normalise(s, &middle, &scale);
    if (s.count < options.min_samples) {
        *refusal = FitRefusal::too_few_samples;
        return false;
    }
    // Below lies rounding.
    if (!(scale > 1e-9 * middle.norm()) || !(scale > 1e-100)) {
        *refusal = FitRefusal::constant_field;
        return false;
    }
    choose_forces(options.force_tolerance, s);
    drop_rests(new_attitude, s);
    c->used_samples = s.count;
    c->force_samples = static_cast<Index>(s.trust().sum());
    if (s.count < options.min_samples) {
        *refusal = FitRefusal::too_little_motion;
        return false;
    }
    Vector3 middle_left;
    double scale_left;
    normalise(s, &middle_left, &scale_left);
    middle += scale * middle_left;
    scale *= scale_left;
    *refusal = full_fit(options, middle, scale, s, c);
    if (*refusal == FitRefusal::none) return true;
    return options.allow_hard_iron_only && hard_iron_fit(options, middle, scale, s, c);
}

} // namespace hnav
