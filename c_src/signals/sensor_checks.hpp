// The sensors of one inertial unit are examined together: the others measure whether the body moves while one repeats a
// value, and the gyroscope measures whether there is noise.
#pragma once

#include "signals/sensor_check.hpp"

namespace hnav {

// Places of the checks, and bits of what they reject.
enum CheckedSensor : int { checked_gyro, checked_accel, checked_mag, checked_count };

// The smallest ranges of chips that one can buy, 125 deg/s and 2 g.
constexpr double least_gyro_range_rad_s = 1.7, least_accel_range_m_s2 = 18;

// The limits of the three sensors by the options of a filter. The smallest ranges of magnetometers are not known.
template <class R>
struct CheckLimits {
    SensorCheckSettings<R> of[checked_count];

    template <class Options>
    CheckLimits(const Options& o, R mag_range)
        : of{{R(o.outlier_rate_rad_s), R(o.gyro_range_rad_s), R(least_gyro_range_rad_s)},
             {R(o.outlier_force_m_s2), R(o.accel_range_m_s2), R(least_accel_range_m_s2)},
             {0, mag_range, R(1e6)}} {}
};

struct Examined {
    std::uint64_t rejected; // bit i: the sample of sensor i is to be treated as missing
    bool rate_at_fault; // an axis of the gyroscope is stuck or saturated: its rate is used, and its turn is uncertain
};

// Whether the rate exceeds that of a body at rest.
template <class R>
inline bool turns(const Vector3Of<R>& rate) {
    constexpr R at_rest_rad_s = R(0.2);
    return rate.squaredNorm() > at_rest_rad_s * at_rest_rad_s;
}

// sample(i, &y): whether sensor i has a sample, and which. interval_s(i): since its last one. force_moves, turns: the body
// accelerates, by the force before this sample; it turns, by the rate before it.
template <class R, class SampleOf, class IntervalOf>
inline Examined examine(SensorCheck<R>* check, const SensorCheckSettings<R>* settings, double t_s, bool force_moves, bool turns,
                        SampleOf&& sample, IntervalOf&& interval_s) {
    Examined found{};
    SensorCheck<R>& rate = check[checked_gyro];
    Vector3Of<R> y;
    const auto reject = [&](int i) {
        found.rejected |= std::uint64_t{1} << i;
        ++check[i].left_out;
    };
    if (sample(int(checked_gyro), &y)) {
        rate.note_course(y);
        if (rate.examine(settings[checked_gyro], y, interval_s(int(checked_gyro)), t_s, force_moves, rate.has_noise())) {
            if (rate.fault == SensorFault::outlier) reject(checked_gyro);
            else found.rate_at_fault = true;
        }
    }
    for (int i = checked_accel; i < checked_count; ++i)
        if (sample(i, &y) && check[i].examine(settings[i], y, interval_s(i), t_s, turns, rate.has_noise())) reject(i);
    return found;
}

} // namespace hnav
