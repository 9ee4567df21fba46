// What the functions of the C boundary share: checks of arguments and samples, and the one line that says what was wrong.
#pragma once

#include "c_api/attitude_filter.hpp"
#include "hnav/hnav.h"

#include <cmath>
#include <cstring>

namespace hnav::boundary {

using At = hnav_filter::At;

constexpr double min_direction_length = 1e-15; // of force and field, in any unit: below lies nothing but rounding
constexpr double min_heading_sigma_rad = 1e-9; // smaller ones drown in the rounding of a covariance
constexpr double max_time_s = 1e12; // beyond, intervals overflow in a covariance; and no clock counts so far in seconds
constexpr double near_singular_pitch = 85 * M_PI / 180;
const char* sensor_name(int sensor); // in messages; beside the push calls, hnav.cpp

inline bool finite(const double* v, int n) {
    for (int i = 0; i < n; ++i)
        if (!std::isfinite(v[i])) return false;
    return true;
}

inline void store(const Quaternion& q, double* out) {
    for (int i = 0; i < 4; ++i) out[i] = q[i];
}

inline void store(const Vector3& v, double* out) {
    for (int i = 0; i < 3; ++i) out[i] = v[i];
}

// Times nearer to 0 than a picosecond are 0: elsewhere numbers lie further apart than that, here two of them may differ by
// so little that nothing can be divided by it.
inline double clock_time(double t_s) { return std::fabs(t_s) < 1e-12 ? 0 : t_s; }

inline hnav_status check_time(const hnav_filter* f, double t_s) {
    if (std::fabs(t_s) <= max_time_s) return HNAV_OK;
    if (!std::isfinite(t_s)) return f->fail(HNAV_ERROR_NON_FINITE, "t_s = %g is not finite", t_s);
    return f->fail(HNAV_ERROR_OUT_OF_RANGE, "t_s = %g lies beyond %g s", t_s, max_time_s);
}

// ------------------------------------------------------------------------------------------------ samples

// A vector sample in body axes, or the reason against it. Directions must not be zero.
inline hnav_status check_vector(hnav_filter* f, double t_s, const double* value, int channel, AttitudeSample* sample) {
    if (!std::isfinite(t_s) || !finite(value, 3)) {
        f->refuse_non_finite();
        return f->fail(HNAV_ERROR_NON_FINITE, "%s sample at t = %g s is not finite: (%g, %g, %g)", sensor_name(channel), t_s,
                       value[0], value[1], value[2]);
    }
    if (std::fabs(t_s) > max_time_s) {
        f->refuse_non_finite();
        return check_time(f, t_s);
    }
    const double max = Vector3(value).cwiseAbs().maxCoeff();
    if (max > max_reading) {
        f->refuse_non_finite();
        return f->fail(HNAV_ERROR_OUT_OF_RANGE, "%s sample at t = %g s has a component of %g, beyond %g", sensor_name(channel),
                       t_s, max, max_reading);
    }
    if (channel != gyro && !(max > min_direction_length)) {
        f->refuse_zero();
        return f->fail(HNAV_ERROR_ZERO_VECTOR, "%s sample at t = %g s is the zero vector", sensor_name(channel), t_s);
    }
    sample->t_s = clock_time(t_s);
    sample->channel = channel;
    f->frames.to_body(value, sample->value);
    return HNAV_OK;
}

inline hnav_status push(hnav_filter* f, const AttitudeSample& sample) {
    if (sample.channel >= f->sensors)
        return f->fail(HNAV_ERROR_UNSUPPORTED, "this filter takes no %s samples", sensor_name(sample.channel));
    switch (f->push(sample)) {
    case Outcome::ok: return HNAV_OK;
    case Outcome::late:
        return f->fail(HNAV_ERROR_LATE_SAMPLE, "%s sample at t = %.9g s is late: samples before %.9g s are closed",
                       sensor_name(sample.channel), sample.t_s, f->late_limit_s());
    default:
        return f->fail(HNAV_ERROR_QUEUE_FULL,
                       "the queue is full: advance before pushing the %s sample at t = %.9g s, or raise queue_capacity",
                       sensor_name(sample.channel), sample.t_s);
    }
}

inline hnav_status push_vector(hnav_filter* f, double t_s, const double* value, int channel) {
    AttitudeSample sample;
    const hnav_status status = check_vector(f, t_s, value, channel, &sample);
    return status == HNAV_OK ? push(f, sample) : status;
}

// What an advance to t_s came to.
inline hnav_status advanced(hnav_filter* f, double t_s, Outcome outcome) {
    switch (outcome) {
    case Outcome::ok: return HNAV_OK;
    case Outcome::backwards:
        return f->fail(HNAV_ERROR_TIME_BACKWARDS, "t_s = %.9g s is before the last advance to %.9g s", t_s, f->now_s());
    default: return f->fail(HNAV_ERROR_SOLVER, "samples up to t = %.9g s led to no usable estimate and were dropped", t_s);
    }
}

inline hnav_status advance(hnav_filter* f, double t_s) { return advanced(f, t_s, f->advance(t_s)); }

// ------------------------------------------------------------------------------------------------ estimate

inline hnav_status not_started(const hnav_filter* f) {
    return f->fail(HNAV_ERROR_NOT_STARTED, "no attitude yet: the start waits for samples");
}

// Roll, pitch and yaw, computed as exactly as the model computes.
inline Vector3 angles_of(const Quaternion& q) { return roll_pitch_yaw<Scalar>(q.cast<Scalar>()).template cast<double>(); }

inline bool near_singular(const Quaternion& q) { return std::fabs(angles_of(q)[1]) > near_singular_pitch; }

inline Vector3 sigmas(const Vector3& variances) {
    return honest_variances(variances.cast<Scalar>()).cwiseSqrt().template cast<double>();
}

// Of the rotation about the user's navigation axes.
inline void rotation_sigma(const hnav_filter* f, At at, double* sigma) { store(sigmas(f->rotation_variances(at)), sigma); }

inline void bias_sigma(const hnav_filter* f, At at, double* sigma) { store(sigmas(f->bias_variances(at)), sigma); }

} // namespace hnav::boundary
