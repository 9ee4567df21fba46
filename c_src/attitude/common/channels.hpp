// The sensors of an attitude filter as channels of its events.
#pragma once

#include "hybrid/event.hpp"

namespace hnav {

// In the order in which samples of equal time act.
enum Channel : int { gyro = 0, accel = 1, mag = 2, heading = 3, channel_count = 4 };

// A reading: rate, force or field in body axes; or heading and its sigma.
using AttitudeEvent = FixedEvent<channel_count, 3>;
using AttitudeSample = AttitudeEvent::Sample;

} // namespace hnav
