// The interval that a sample represents. The rate of a sensor is not an option: it follows from its time stamps.
#pragma once

#include <algorithm>

namespace hnav {

// Samples are missing when the time since the last is far above the usual; jitter and a single loss are not. usual_s: 0 while
// it is not known. Two lost samples of a regular sensor reach the limit exactly, and rounding must not decide.
inline bool is_gap(double since_s, double usual_s) { return usual_s > 0 && since_s > (3 + 1e-3) * usual_s; }

// The time since the sample before, or the usual one after a gap, within the limit. 0 for the first sample: it carries no
// information, because its density has no interval.
inline double interval_of_sample(double since_s, double usual_s, double max_interval_s) {
    if (!(since_s > 0)) return 0;
    return std::min(is_gap(since_s, usual_s) ? usual_s : since_s, max_interval_s);
}

// The usual interval after a sample that came since_s after the one before.
inline double usual_interval(double since_s, double usual_s) {
    if (!(since_s > 0)) return usual_s;
    if (!(usual_s > 0)) return since_s;
    if (is_gap(since_s, usual_s)) return 1.2 * usual_s; // a slower rate is adopted after a few samples
    return usual_s + 0.1 * (since_s - usual_s);
}

} // namespace hnav
