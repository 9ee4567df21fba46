#include "calibration/magnetometer.hpp"

#include "calibration/alignment.hpp"
#include "calibration/ellipsoid.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cstdlib>
#include <limits>
#include <memory>

namespace hnav {
namespace {

using Vector13 = Eigen::Matrix<double, 13, 1>;
using Matrix13 = Eigen::Matrix<double, 13, 13>;

constexpr double thin = 0.1;      // out-of-plane over in-plane spread below which samples count as flat
constexpr int passes = 50;        // of the joint refinement; a few suffice when the weights settle
constexpr double settled = 1e-12; // step in units of the field strength
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// What all steps work on: normalised samples and a few numbers for each, in one block.
class Samples {
public:
    explicit Samples(Index n)
        : block_(static_cast<double*>(std::calloc(static_cast<std::size_t>(n) + 1, columns * sizeof(double)))), n_(n) {}
    explicit operator bool() const { return block_ != nullptr; }

    Columns z() const { return Columns(at(0), 3, count); }  // field, centred and scaled
    Columns u() const { return Columns(at(3), 3, count); }  // field, corrected to length 1
    Columns a() const { return Columns(at(6), 3, count); }  // direction of force
    Values trust() const { return Values(at(9), count); }   // 1 where the force may be gravity
    Values weight() const { return Values(at(10), count); } // of the field
    Values residual() const { return Values(at(11), count); }
    Values angle() const { return Values(at(12), count); }  // residual of the dip
    Values angle_weight() const { return Values(at(13), count); }
    Values scratch() const { return Values(at(14), count); }

    Index count = 0; // rows with a field

private:
    static constexpr std::size_t columns = 15;
    double* at(Index column) const { return block_.get() + column * n_; }

    struct Free {
        void operator()(double* p) const { std::free(p); }
    };
    std::unique_ptr<double[], Free> block_;
    Index n_;
};

// Takes over the rows that have a field: about their mean, in units of their root mean square distance from it.
void gather(Index n, const double* field, const double* force, Samples& s, Vector3* middle, double* scale) {
    for (Index i = 0; i < n; ++i) s.count += !std::isnan(field[3 * i]);
    Columns z = s.z(), a = s.a();
    Index k = 0;
    for (Index i = 0; i < n; ++i) {
        if (std::isnan(field[3 * i])) continue;
        z.col(k) = Vector3(field + 3 * i);
        a.col(k) = force ? Vector3(force + 3 * i) : Vector3::Constant(not_a_number);
        ++k;
    }
    middle->setZero();
    for (Index i = 0; i < s.count; ++i) *middle += z.col(i) / static_cast<double>(s.count);
    double mean_square = 0;
    for (Index i = 0; i < s.count; ++i) mean_square += (z.col(i) - *middle).squaredNorm() / static_cast<double>(s.count);
    *scale = std::sqrt(mean_square);
    for (Index i = 0; i < s.count; ++i) z.col(i) = (z.col(i) - *middle) / *scale;
}

// Gravity has one length: a force of another length holds acceleration as well. Returns how many rows are left.
Index choose_forces(double tolerance, Samples& s) {
    Columns a = s.a();
    Values trust = s.trust(), scratch = s.scratch();
    Index known = 0;
    for (Index i = 0; i < s.count; ++i)
        if (a.col(i).norm() > 0) scratch[known++] = a.col(i).norm(); // false for NaN too
    const double gravity = median(scratch.data(), known);
    Index used = 0;
    for (Index i = 0; i < s.count; ++i) {
        const double norm = a.col(i).norm();
        const bool near = norm > 0 && std::fabs(norm - gravity) <= tolerance * gravity;
        trust[i] = near;
        if (near) a.col(i) /= norm;
        used += near;
    }
    return used;
}

// M (z - o) has length 1 and keeps its angle to gravity.
struct Correction {
    Matrix3 M;
    Vector3 o;
    double sin_dip;
};

// with_force: else the second equation counts for nothing.
void residuals(const Samples& s, const Correction& c, bool with_force, Values& length, Values& angle) {
    const Columns z = s.z(), a = s.a();
    const Values trust = s.trust();
    for (Index i = 0; i < s.count; ++i) {
        const Vector3 p = c.M * (z.col(i) - c.o);
        length[i] = p.norm() - 1;
        angle[i] = with_force && trust[i] > 0 ? a.col(i).dot(p) + c.sin_dip : 0;
    }
}

// Both equations together, over all 13 unknowns, by Levenberg and Marquardt with robust weights. Each equation is divided
// by the scatter it shows, which makes this maximum likelihood: the force is as noisy as it is. Without force the rotation
// in M is free; the damping holds it.
void refine(double outlier_sigma, bool with_force, Samples& s, Correction* c) {
    const Columns z = s.z(), a = s.a();
    const Values trust = s.trust();
    Values weight = s.weight(), length = s.residual(), angle = s.angle(), scratch = s.scratch(), angle_weight = s.angle_weight();
    double damping = 1e-6;
    for (int pass = 0; pass < passes; ++pass) {
        residuals(s, *c, with_force, length, angle);
        const double sigma_length = robust_sigma(length, scratch);
        const double sigma_angle = robust_sigma(angle, scratch, &trust);
        const auto loss_weight = [&](double residual, double sigma) {
            return (outlier_sigma > 0 ? geman_mcclure(residual, outlier_sigma * sigma) : 1) / (sigma * sigma);
        };
        Matrix13 JtJ = Matrix13::Zero();
        Vector13 Jtr = Vector13::Zero();
        double cost = 0;
        const auto add = [&](const Vector3& along, const Vector3& d, double dip, double residual, double w) {
            Vector13 J; // of along . M d: nine of M row by row, three of o, the dip
            for (int j = 0; j < 3; ++j) J.segment<3>(3 * j) = along[j] * d;
            J.segment<3>(9) = -c->M.transpose() * along;
            J[12] = dip;
            JtJ.selfadjointView<Eigen::Lower>().rankUpdate(J, w);
            Jtr += w * residual * J;
            cost += w * residual * residual;
        };
        for (Index i = 0; i < s.count; ++i) {
            const Vector3 d = z.col(i) - c->o;
            const Vector3 p = c->M * d;
            weight[i] = loss_weight(length[i], sigma_length);
            if (p.norm() > 0) add(p.normalized(), d, 0, length[i], weight[i]);
            angle_weight[i] = with_force && trust[i] > 0 ? loss_weight(angle[i], sigma_angle) : 0;
            if (angle_weight[i] > 0) add(a.col(i), d, 1, angle[i], angle_weight[i]);
        }
        JtJ.triangularView<Eigen::StrictlyUpper>() = JtJ.transpose();

        bool better = false;
        Vector13 step = Vector13::Zero();
        for (int attempt = 0; attempt < 8 && !better; ++attempt) {
            Matrix13 damped = JtJ;
            damped.diagonal() += damping * (JtJ.diagonal() + Vector13::Constant(1e-6 * JtJ.trace()));
            step = -damped.ldlt().solve(Jtr);
            Correction next = *c;
            for (int j = 0; j < 3; ++j) next.M.row(j) += step.segment<3>(3 * j).transpose();
            next.o += step.segment<3>(9);
            next.sin_dip += step[12];
            residuals(s, next, with_force, length, angle);
            double next_cost = 0;
            for (Index i = 0; i < s.count; ++i)
                next_cost += weight[i] * length[i] * length[i] + angle_weight[i] * angle[i] * angle[i];
            better = next_cost <= cost;
            if (better) *c = next;
            damping = better ? std::fmax(damping / 10, 1e-12) : damping * 10;
        }
        if (!better || step.norm() < settled) break;
    }
}

// Dip of a field u (n columns of length about 1) where the force is trusted: median and robust standard deviation.
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
    *spread_rad = 1.4826 * median(scratch.data(), known);
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

// Marks the samples within the limit in s.weight and fills in what the user judges the answer by. u: corrected fields.
void judge(double outlier_sigma, const Vector3& middle, Samples& s, const Columns& z, MagnetometerCalibration* c) {
    Values inlier = s.weight(), residual = s.residual(), scratch = s.scratch();
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
    dip_figures(u, s, &c->dip_rad, &c->dip_spread_after_rad);
    Columns raw = s.u();
    for (Index i = 0; i < s.count; ++i) raw.col(i) = z.col(i) + middle;
    c->residual_before = length_scatter(raw, inlier);
    double dip_before;
    dip_figures(raw, s, &dip_before, &c->dip_spread_before_rad);
}

// middle: mean of the field, scale: what z was divided by.
Refusal full_fit(const MagnetometerSettings& settings, const Vector3& middle, double scale, Samples& s,
                 MagnetometerCalibration* c) {
    const Columns z = s.z();
    Columns u = s.u();
    Values weight = s.weight(), residual = s.residual(), scratch = s.scratch(), angle = s.angle();
    const double loss_sigma = settings.robust ? settings.outlier_sigma : 0;
    if (is_flat(z)) return Refusal::planar;

    Ellipsoid ellipsoid{};
    const bool fits = fit_ellipsoid(z, loss_sigma, weight, residual, scratch, &ellipsoid);
    c->condition = ellipsoid.condition;
    c->ambiguity = ellipsoid.ambiguity;
    if (c->condition > settings.condition_limit || c->ambiguity > settings.ambiguity_limit) return Refusal::ill_conditioned;
    if (!fits) return Refusal::not_an_ellipsoid;
    for (Index i = 0; i < s.count; ++i) u.col(i) = ellipsoid.root * (z.col(i) - ellipsoid.centre);

    Correction correction{ellipsoid.root, ellipsoid.centre, 0};
    Alignment alignment{};
    const Values trust = s.trust();
    c->aligned = c->force_samples >= settings.samples_least &&
                 align(u, s.a(), trust, loss_sigma, angle, scratch, &alignment) &&
                 alignment.condition <= settings.condition_limit;
    if (c->aligned) {
        correction.M = alignment.R * ellipsoid.root;
        correction.sin_dip = alignment.sin_dip;
    }
    refine(loss_sigma, c->aligned, s, &correction);

    const Eigen::JacobiSVD<Matrix3> svd(correction.M, Eigen::ComputeFullV);
    const Vector3 inverse_axes = svd.singularValues();
    c->axis_ratio = inverse_axes[0] / inverse_axes[2];
    if (!correction.M.allFinite() || !correction.o.allFinite() || !(correction.M.determinant() > 0))
        return Refusal::not_an_ellipsoid;
    if (!(c->axis_ratio <= settings.axis_ratio_limit)) return Refusal::stretched;
    // Nothing tells the rotation: the symmetric factor turns the field least.
    if (!c->aligned) correction.M = svd.matrixV() * inverse_axes.asDiagonal() * svd.matrixV().transpose();

    for (Index i = 0; i < s.count; ++i) {
        u.col(i) = correction.M * (z.col(i) - correction.o);
        residual[i] = u.col(i).norm() - 1;
    }
    judge(settings.outlier_sigma, middle / scale, s, z, c);
    if (c->coverage < settings.coverage_limit) return Refusal::little_coverage;

    // The ellipsoid has no unit: a determinant of 1 keeps the strength on the mean over all directions.
    const double size = std::cbrt(correction.M.determinant());
    c->offset = middle + scale * correction.o;
    c->matrix = correction.M / size;
    c->strength = scale / size;
    c->offset_axes = 3;
    c->full = true;
    return Refusal::none;
}

// False when not even the centre of a circle is determined.
bool hard_iron_fit(const MagnetometerSettings& settings, const Vector3& middle, double scale, Samples& s,
                   MagnetometerCalibration* c) {
    const Columns z = s.z();
    Values weight = s.weight(), residual = s.residual(), scratch = s.scratch();
    const Sphere sphere = fit_sphere(z, settings.robust ? settings.outlier_sigma : 0, thin, weight, residual, scratch);
    if (sphere.axes < 2 || !sphere.centre.allFinite()) return false;
    // Across the plane of flat samples the field is left as it was.
    c->offset = sphere.plane * (middle + scale * sphere.centre);
    c->matrix.setIdentity();
    c->offset_axes = sphere.axes;
    c->axis_ratio = 1;
    c->full = c->aligned = false;
    Columns u = s.u();
    for (Index i = 0; i < s.count; ++i) scratch[i] = residual[i] = (sphere.plane * (z.col(i) - sphere.centre)).norm();
    const double radius = median(scratch.data(), s.count);
    for (Index i = 0; i < s.count; ++i) {
        residual[i] = residual[i] / radius - 1;
        u.col(i) = z.col(i) + (middle - c->offset) / scale;
        scratch[i] = u.col(i).norm();
    }
    c->strength = scale * median(scratch.data(), s.count);
    judge(settings.outlier_sigma, middle / scale, s, z, c);
    return true;
}

} // namespace

bool calibrate_magnetometer(Index n, const double* field, const double* force, const MagnetometerSettings& settings,
                            MagnetometerCalibration* c, Refusal* refusal) {
    Samples s(n);
    if (!s) {
        *refusal = Refusal::no_memory;
        return false;
    }
    Vector3 middle;
    double scale;
    gather(n, field, force, s, &middle, &scale);
    c->samples = s.count;
    if (s.count < settings.samples_least) {
        *refusal = Refusal::too_few_samples;
        return false;
    }
    // Below lies rounding.
    if (!(scale > 1e-9 * middle.norm()) || !(scale > 1e-100)) {
        *refusal = Refusal::constant_field;
        return false;
    }
    c->force_samples = choose_forces(settings.force_tolerance, s);
    *refusal = full_fit(settings, middle, scale, s, c);
    if (*refusal == Refusal::none) return true;
    return settings.allow_hard_iron_only && hard_iron_fit(settings, middle, scale, s, c);
}

} // namespace hnav
