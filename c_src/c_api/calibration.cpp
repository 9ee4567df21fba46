// The C boundary of the calibration: checks samples and options, and writes the messages.
#include "calibration/magnetometer.hpp"

#include "c_api/arrays.hpp"
#include "c_api/sized.hpp"
#include "hnav/calibration.h"
#include "options/lists.hpp"

#include <cmath>
#include <cstdio>

namespace {

using hnav::FitRefusal;
using hnav::Vector3;

constexpr double deg = M_PI / 180;
constexpr double wide_gap_rad = 30 * deg; // a sphere without such a gap has samples on all sides
constexpr double max_reading = 1e12; // in any unit; beyond this, fourth powers lose their digits

// Rows of three NaN are missing; all others must be finite and within the limit.
hnav_status check_rows(const hnav::CallersMessage& caller, const char* name, const double* rows, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
        const double* v = rows + 3 * i;
        if (hnav::is_missing(v)) continue;
        for (int k = 0; k < 3; ++k) {
            if (!std::isfinite(v[k]))
                return caller.fail(HNAV_ERROR_NON_FINITE, "%s row %zu is not finite: (%g, %g, %g)", name, i, v[0], v[1], v[2]);
            if (std::fabs(v[k]) > max_reading)
                return caller.fail(HNAV_ERROR_OUT_OF_RANGE, "%s row %zu has a component of %g, beyond %g", name, i, v[k],
                                   max_reading);
        }
    }
    return HNAV_OK;
}

// Refusals that need no numbers; null for the others.
const char* sentence_of(FitRefusal refusal) {
    switch (refusal) {
    case FitRefusal::no_memory: return "no memory for the samples";
    case FitRefusal::constant_field: return "the field never changes: turn the sensor about all axes while recording";
    case FitRefusal::planar:
        return "the field stays in a plane, as when the sensor turns about one axis only: turn it about all axes";
    case FitRefusal::not_an_ellipsoid:
        return "the field is no ellipsoid: record again far from iron that does not turn with the sensor";
    case FitRefusal::worse:
        return "the corrected field would be less constant than the measured one: record again far from iron that does not turn "
               "with the sensor";
    default: return nullptr;
    }
}

void describe(FitRefusal refusal, const hnav::MagnetometerCalibration& c, const hnav_magnetometer_options& o, char* text,
              size_t size) {
    switch (refusal) {
    case FitRefusal::too_few_samples:
        std::snprintf(text, size, "too few samples: %lld rows have a field, min_samples = %d", static_cast<long long>(c.samples),
                      o.min_samples);
        break;
    case FitRefusal::too_little_motion:
        std::snprintf(
            text, size,
            "too little motion: only %lld of %lld rows saw a new attitude, min_samples = %d; turn the sensor about all axes",
            static_cast<long long>(c.used_samples), static_cast<long long>(c.samples), o.min_samples);
        break;
    case FitRefusal::ill_conditioned:
        std::snprintf(
            text, size,
            "several ellipsoids fit (condition %.3g, limit %.3g; ambiguity %.3g, limit %.3g): turn the sensor further about all axes",
            c.condition, o.max_condition, c.ambiguity, o.max_ambiguity);
        break;
    case FitRefusal::stretched:
        std::snprintf(
            text, size,
            "the fitted ellipsoid is stretched by %.3g, max_axis_ratio = %.3g: record again far from iron that does not turn with the sensor",
            c.axis_ratio, o.max_axis_ratio);
        break;
    case FitRefusal::uncertain:
        std::snprintf(
            text, size,
            "the corrected direction would be uncertain by %.3g deg, max_direction_sigma_rad allows %.3g deg: turn the sensor further about all axes, slowly, far from iron",
            c.direction_sigma_rad / deg, o.max_direction_sigma_rad / deg);
        break;
    case FitRefusal::little_tilt:
        std::snprintf(text, size,
                      "gravity stayed within %.0f deg of one direction: turn the sensor about all axes, upside down too",
                      c.tilt_rad / deg);
        break;
    case FitRefusal::little_coverage:
        std::snprintf(
            text, size,
            "the directions of the field cover too little of the sphere (coverage %.3g, limit %.3g): turn the sensor about all axes",
            c.coverage, o.min_coverage);
        break;
    default: std::snprintf(text, size, "%s", sentence_of(refusal));
    }
}

// The omitted parts of the correction with their reason, and the part of the sphere without samples.
void annotate(const hnav::MagnetometerCalibration& c, const hnav_magnetometer_options& o, char* text, size_t size) {
    const double turned = c.rotation_rad / deg;
    int length = 0;
    if (c.full) switch (c.rotation) {
        case hnav::Rotation::found: break;
        case hnav::Rotation::no_gravity:
            length = std::snprintf(
                text, size,
                "without rotation, whose error is not stated: only %lld rows have a force like gravity, min_samples = %d; ",
                static_cast<long long>(c.force_samples), o.min_samples);
            break;
        case hnav::Rotation::not_gravity:
            length = std::snprintf(text, size, "without rotation: force and field keep no angle to each other; ");
            break;
        case hnav::Rotation::uncertain:
            length = std::snprintf(text, size, "without rotation: gravity does not determine it to %.3g deg; ",
                                   o.max_direction_sigma_rad / deg);
            break;
        case hnav::Rotation::explains_little:
            length =
                std::snprintf(text, size, "without rotation: one of %.2g deg would explain too little of the scatter; ", turned);
            break;
        }
    const Vector3& at = c.gap.direction;
    std::snprintf(
        text + length, size - static_cast<size_t>(length),
        c.gap.angle_rad > wide_gap_rad
            ? "no sample within %.0f deg of the direction (%.2f, %.2f, %.2f): turn the sensor so that the field points there too"
            : "every direction has a sample within %.0f deg",
        c.gap.angle_rad / deg, at[0], at[1], at[2]);
}

void store(const hnav::MagnetometerCalibration& c, hnav_magnetometer_calibration* out) {
    hnav::store(c.offset, out->offset);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) out->matrix[3 * i + j] = c.matrix(i, j);
    out->strength = c.strength;
    out->dip_rad = c.dip_rad;
    out->residual_before = c.residual_before;
    out->residual_after = c.residual_after;
    out->dip_spread_before_rad = c.dip_spread_before_rad;
    out->dip_spread_after_rad = c.dip_spread_after_rad;
    out->outlier_fraction = c.outlier_fraction;
    out->coverage = c.coverage;
    out->condition = c.condition;
    out->ambiguity = c.ambiguity;
    out->axis_ratio = c.axis_ratio;
    out->direction_sigma_rad = c.direction_sigma_rad;
    out->samples = static_cast<std::uint64_t>(c.samples);
    out->used_samples = static_cast<std::uint64_t>(c.used_samples);
    out->force_samples = static_cast<std::uint64_t>(c.force_samples);
    out->fit = !c.full                               ? HNAV_MAGNETOMETER_HARD_IRON_ONLY
               : c.rotation == hnav::Rotation::found ? HNAV_MAGNETOMETER_FULL
                                                     : HNAV_MAGNETOMETER_NO_ROTATION;
    out->offset_axes = c.offset_axes;
    hnav::store(c.gap.direction, out->gap_direction);
    out->gap_rad = c.gap.angle_rad;
}

} // namespace

extern "C" {

hnav_status hnav_calibrate_magnetometer(size_t n, const double* field, const double* force_b_m_s2,
                                        const hnav_magnetometer_options* options, hnav_magnetometer_calibration* calibration,
                                        char* message, size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    caller.clear();
    if (!field) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "field is null");
    if (!calibration) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "calibration is null");
    hnav_status status = hnav::check_size(caller, *calibration, "calibration", "hnav_magnetometer_calibration");
    if (status != HNAV_OK) return status;
    const hnav_magnetometer_options o = options ? *options : hnav_magnetometer_defaults();
    status = caller.check_options(&o, hnav::magnetometer_options);
    if (status == HNAV_OK) status = check_rows(caller, "field", field, n);
    if (status == HNAV_OK && force_b_m_s2) status = check_rows(caller, "force_b_m_s2", force_b_m_s2, n);
    if (status != HNAV_OK) return status;

    hnav::MagnetometerCalibration c;
    FitRefusal refusal;
    const bool answered = hnav::calibrate_magnetometer(static_cast<hnav::Index>(n), field, force_b_m_s2, o, &c, &refusal);
    char reason[320] = "";
    if (refusal == FitRefusal::none) annotate(c, o, reason, sizeof reason);
    else describe(refusal, c, o, reason, sizeof reason);
    if (answered) {
        hnav_magnetometer_calibration result{};
        store(c, &result);
        hnav::hand_out(result, calibration);
        return caller.fail(HNAV_OK, "%s", reason);
    }
    const bool tried_hard_iron = o.allow_hard_iron_only && c.used_samples >= o.min_samples;
    return caller.fail(refusal == FitRefusal::no_memory ? HNAV_ERROR_OUT_OF_MEMORY : HNAV_ERROR_ILL_CONDITIONED, "%s%s", reason,
                       tried_hard_iron ? "; nor is hard iron alone determined" : "");
}

} // extern "C"
