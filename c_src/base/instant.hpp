// When two times are equal, and when a duration has reached its limit.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace hnav {

// Callers add up steps, so times closer than this are one instant. scale_s: times of the same kind differ by at least this;
// the tolerance stays a small part of it, also for a clock that counts from 1970.
inline double instant_s(double t_s, double scale_s) {
    const double size = std::fabs(t_s);
    const double rounding = 4 * std::numeric_limits<double>::epsilon() * size;
    return std::max(rounding, std::min(1e-9 * std::max(1.0, size), 1e-3 * scale_s));
}

// The same for time stamps of samples: those of different sensors within this tolerance form one event. 1 ns, growing with
// time, as sums of steps drift, up to 1 us, which has no visible effect on an estimate.
inline double sample_instant_s(double t_s) { return instant_s(t_s, 1e-3); }

// Durations against a limit: rounding must not decide a tie. Differences and sums of stamps within tie_share of the limit are
// equal to it; that is more than the rounding of a clock that counts from 1970 (2.4e-7 s) for limits from 10 ms on.
constexpr double tie_share = 1e-4;
template <class R>
inline bool has_lasted(R length_s, R limit_s) {
    return length_s >= R(1 - tie_share) * limit_s;
}
template <class R>
inline bool has_passed(R length_s, R limit_s) {
    return length_s > R(1 + tie_share) * limit_s;
}
// Not the negation of has_lasted: both are false for NaN.
template <class R>
inline bool is_within(R length_s, R limit_s) {
    return length_s < R(1 - tie_share) * limit_s;
}

} // namespace hnav
