// Shared by the calls of attitude filters: checks of samples, and the outputs of an estimate.
#pragma once

#include "c_api/arrays.hpp"
#include "c_api/attitude_object.hpp"
#include "hnav/hnav.h"
#include "maths/finite.hpp"

#include <cmath>

namespace hnav::boundary {

using At = EveryAttitude::At;

constexpr double min_direction_length = 1e-15; // smallest length of force and field, in any unit
constexpr double min_heading_sigma_rad = 1e-7; // the square of a smaller one is lost in the rounding of a covariance of 1 rad^2
constexpr double min_speed_sigma_m_s = 1e-3; // no sensor of speed is better
constexpr double max_speed_m_s = 1e4; // of anything in the air

// ------------------------------------------------------------------------------------------------ samples

inline double max_of(int channel) { return channel == gyro ? max_rate_rad_s : max_reading; }

// A vector sample in body axes. Directions must not be zero.
inline hnav_status check_vector(AttitudeObject* f, double t_s, const double* value, int channel, AttitudeSample* sample) {
    if (!std::isfinite(t_s) || !all_finite(value, 3))
        return f->fail(HNAV_ERROR_NON_FINITE, "%s sample at t = %g s is not finite: (%g, %g, %g)", sensor_name(channel), t_s,
                       value[0], value[1], value[2]);
    if (std::fabs(t_s) > max_time_s) return check_time(f, t_s);
    const double max = Vector3(value).cwiseAbs().maxCoeff(), limit = max_of(channel);
    if (max > limit)
        return f->fail(HNAV_ERROR_OUT_OF_RANGE, "%s sample at t = %g s has a component of %g, beyond %g", sensor_name(channel),
                       t_s, max, limit);
    if (channel != gyro && !(max > min_direction_length))
        return f->fail(HNAV_ERROR_ZERO_VECTOR, "%s sample at t = %g s is the zero vector", sensor_name(channel), t_s);
    sample->t_s = clock_time(t_s);
    sample->channel = channel;
    f->frames.to_body(value, sample->value);
    return HNAV_OK;
}

// The result of a check, which counts a refused sample.
inline hnav_status counted(AttitudeObject* f, hnav_status status) {
    if (status != HNAV_OK) f->count_refused(status == HNAV_ERROR_ZERO_VECTOR);
    return status;
}

inline hnav_status takes_none(const EveryAttitude* f, int sensor) {
    return f->fail(HNAV_ERROR_UNSUPPORTED, "this filter takes no %s samples", sensor_name(sensor));
}

inline hnav_status push(AttitudeObject* f, const AttitudeSample& sample) {
    if (sample.channel >= f->sensors) return takes_none(f, sample.channel);
    return queued(f, f->push(sample), sensor_name(sample.channel), sample.t_s, f->late_limit_s());
}

// An aid: a value and its sigma, named as in the C API. max: of the size of the value.
inline hnav_status check_aid(AttitudeObject* f, double t_s, int channel, double value, double sigma, const char* sigma_name,
                             double max) {
    if (!std::isfinite(t_s) || !std::isfinite(value) || !std::isfinite(sigma))
        return f->fail(HNAV_ERROR_NON_FINITE, "%s sample at t = %g s is not finite: %s %g, sigma %g", sensor_name(channel), t_s,
                       sensor_name(channel), value, sigma);
    if (std::fabs(t_s) > max_time_s) return check_time(f, t_s);
    if (!(sigma > 0) || sigma > max_reading)
        return f->fail(HNAV_ERROR_OUT_OF_RANGE, "%s = %g of the %s sample at t = %g s must be above 0", sigma_name, sigma,
                       sensor_name(channel), t_s);
    if (std::fabs(value) > max)
        return f->fail(HNAV_ERROR_OUT_OF_RANGE, "%s sample at t = %g s is %g, beyond %g", sensor_name(channel), t_s, value, max);
    return HNAV_OK;
}

// True heading of body x.
inline hnav_status push_heading(AttitudeObject* f, double t_s, double heading_rad, double sigma_rad) {
    const hnav_status checked = check_aid(f, t_s, heading, heading_rad, sigma_rad, "sigma_rad", HUGE_VAL);
    if (const hnav_status status = counted(f, checked)) return status;
    const double magnetic = wrap_angle(Scalar(heading_rad - f->frames.declination_rad));
    return push(f, {clock_time(t_s), heading, {magnetic, std::fmax(sigma_rad, min_heading_sigma_rad), 0}});
}

// Along body x.
inline hnav_status push_speed(AttitudeObject* f, double t_s, double speed_m_s, double sigma_m_s) {
    const hnav_status checked = check_aid(f, t_s, speed, speed_m_s, sigma_m_s, "sigma_m_s", max_speed_m_s);
    if (const hnav_status status = counted(f, checked)) return status;
    return push(f, {clock_time(t_s), speed, {speed_m_s, std::fmax(sigma_m_s, min_speed_sigma_m_s), 0}});
}

inline hnav_status push_vector(AttitudeObject* f, double t_s, const double* value, int channel) {
    AttitudeSample sample;
    const hnav_status status = counted(f, check_vector(f, t_s, value, channel, &sample));
    return status == HNAV_OK ? push(f, sample) : status;
}

// ------------------------------------------------------------------------------------------------ estimate

inline hnav_status not_started(const EveryAttitude* f) {
    return f->fail(HNAV_ERROR_NOT_STARTED, "no attitude yet: the start waits for samples");
}

// Roll, pitch and yaw, in the precision of the model.
inline Vector3 angles_of(const Quaternion& q) { return roll_pitch_yaw<Scalar>(q.cast<Scalar>()).template cast<double>(); }

inline bool near_singular(const Quaternion& q) { return std::fabs(angles_of(q)[1]) > near_singular_pitch; }

inline Vector3 sigmas(const Vector3& variances) {
    return honest_variances(variances.cast<Scalar>()).cwiseSqrt().template cast<double>();
}

// Standard deviations of the rotation about the user's navigation axes.
inline void rotation_sigma(const EveryAttitude* f, At at, double* sigma) { store(sigmas(f->rotation_variances(at)), sigma); }

inline void bias_sigma(const EveryAttitude* f, At at, double* sigma) { store(sigmas(f->bias_variances(at)), sigma); }

} // namespace hnav::boundary
