// Limits of what a sensor of a body can measure.
#pragma once

namespace hnav {

// Chosen: 95 000 turns a minute, above every body that carries a gyroscope. The cost of an interval grows with the rate, so a
// limit on the rate bounds the time of a call.
constexpr double max_rate_rad_s = 1e4;

} // namespace hnav
