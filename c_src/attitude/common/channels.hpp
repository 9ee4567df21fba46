// The sensors of an attitude filter as channels of its events.
#pragma once

#include "hnav/filter.h"
#include "hybrid/event.hpp"

#include <cstdint>

namespace hnav {

// In the order in which samples of equal time are used. From the heading on they are aids, which measure a part of the estimate
// itself, with a sigma.
enum Channel : int {
    gyro = HNAV_SENSOR_GYRO,
    accel = HNAV_SENSOR_ACCEL,
    mag = HNAV_SENSOR_MAG,
    heading = HNAV_SENSOR_HEADING,
    speed = HNAV_SENSOR_SPEED,
    channel_count
};

// Values of a sample: rate, force or field in body axes; or those of an aid, and its sigma.
using AttitudeEvent = FixedEvent<channel_count, 3>;
using AttitudeSample = AttitudeEvent::Sample;

// Channels whose samples of one stamp come from a FIFO; two aids of one time come from two sensors.
constexpr std::uint64_t fifo_channels = 1u << gyro | 1u << accel | 1u << mag;

inline bool has_aid(const AttitudeEvent& event) { return event.present >> heading != 0; }

} // namespace hnav
