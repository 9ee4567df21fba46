// When two times are one, and when a duration has reached its limit.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace hnav {

// Callers add up steps: two times that lie closer than this are one instant. scale_s: times of the same kind lie at least so
// far apart, of which the tolerance stays a small part, also for a clock that counts from 1970.
inline double instant_s(double t_s, double scale_s) {
    const double size = std::fabs(t_s);
    const double rounding = 4 * std::numeric_limits<double>::epsilon() * size;
    return std::max(rounding, std::min(1e-9 * std::max(1.0, size), 1e-3 * scale_s));
}

// The same for the stamps of samples: those of different sensors that lie closer belong to one event. 1 ns, with the time that it
// takes sums of steps to drift up to 1 us, which no estimate feels.
inline double sample_instant_s(double t_s) { return instant_s(t_s, 1e-3); }

// Lengths of time against a limit: rounding decides no tie. Differences and sums of stamps within tie_share of the limit are at it;
// that is more than the rounding of a clock that counts from 1970 (2.4e-7 s) for limits from 10 ms on.
constexpr double tie_share = 1e-4;
template <class R>
inline bool has_lasted(R length_s, R limit_s) {
    return length_s >= R(1 - tie_share) * limit_s;
}
template <class R>
inline bool has_passed(R length_s, R limit_s) {
    return length_s > R(1 + tie_share) * limit_s;
}
// Not the contrary of has_lasted for NaN: no time at all is neither.
template <class R>
inline bool is_within(R length_s, R limit_s) {
    return length_s < R(1 - tie_share) * limit_s;
}

} // namespace hnav
