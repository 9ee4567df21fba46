// What no sensor of a body reads.
#pragma once

namespace hnav {

// Chosen: 95 000 turns a minute, above every body that carries a gyroscope. What the flow between two samples costs grows with the
// rate, so a limit on it is one on the time of a call.
constexpr double max_rate_rad_s = 1e4;

} // namespace hnav
