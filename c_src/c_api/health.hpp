// Health of each sensor, from the checks of samples and stamps.
#pragma once

#include "hnav/hnav.h"
#include "signals/sensor_check.hpp"

#include <cmath>

namespace hnav {

// Time for which a state of single samples is shown.
constexpr double shown_s = 1;

// Health of a sensor that the filter does not use.
inline hnav_sensor_health sensor_without_samples() {
    hnav_sensor_health h{};
    h.state = HNAV_SENSOR_STATE_MISSING;
    h.since_s = std::numeric_limits<double>::quiet_NaN();
    return h;
}

// What the engine has counted.
template <class Filter>
void diagnose(const Filter& filter, hnav_diagnostics* out) {
    out->newest_sample_s = std::isfinite(filter.newest_s()) ? filter.newest_s() : std::numeric_limits<double>::quiet_NaN();
    out->late = filter.refused.late;
    out->non_finite = filter.refused.non_finite;
    out->zero = filter.refused.zero;
    out->solver_rhs_evals = filter.propagator().rhs_evals();
    out->solver_steps = filter.propagator().steps();
    out->waiting = filter.waiting();
}

// check: null for a sensor without checks.
template <class Check, class Filter>
hnav_sensor_health sensor_health(const Check* check, const Filter& filter, int channel) {
    constexpr double missing_intervals = 10;
    const auto& stamps = filter.stamps();
    const double now_s = filter.event_now_s();
    hnav_sensor_health h{};
    h.late = stamps.late(channel);
    h.left_out = stamps.left_out(channel) + (check ? check->left_out : 0);
    h.since_s = std::numeric_limits<double>::quiet_NaN();
    const auto is = [&](hnav_sensor_state state, double since_s) {
        h.state = state;
        h.since_s = since_s;
    };
    if (h.late > 0 && now_s - stamps.late_s(channel) <= shown_s) is(HNAV_SENSOR_STATE_LATE, stamps.late_s(channel));
    if (check) {
        h.outliers = check->outliers;
        h.stuck = check->stuck;
        h.saturated = check->saturated;
        h.axes = static_cast<int32_t>(check->axes);
        if (h.state == HNAV_SENSOR_STATE_OK && check->outliers + check->stuck + check->saturated > 0) h.since_s = check->since_s;
        if (check->outliers > 0 && now_s - check->outlier_s <= shown_s) is(HNAV_SENSOR_STATE_OUTLIER, check->outlier_s);
        if (check->fault == SensorFault::stuck) is(HNAV_SENSOR_STATE_STUCK, check->since_s);
        if (check->fault == SensorFault::saturated) is(HNAV_SENSOR_STATE_SATURATED, check->since_s);
    }
    const double last_s = stamps.last_s(channel) + stamps.offset_s();
    if (std::isinf(last_s)) is(HNAV_SENSOR_STATE_MISSING, std::numeric_limits<double>::quiet_NaN());
    else if (now_s - last_s > shown_s + missing_intervals * stamps.interval_s(channel)) is(HNAV_SENSOR_STATE_MISSING, last_s);
    h.since_s = filter.stamp_of(h.since_s);
    return h;
}

} // namespace hnav
