// The interval that a sample stands for. Sensors are not asked for their rate: it follows from their time stamps.
#pragma once

#include <algorithm>

namespace hnav {

// Samples are missing when the time since the last is far above the usual; jitter and a single loss are not.
// usual_s: 0 while it is not known. Two lost samples of an even sensor are the limit itself, and rounding does not decide of it.
inline bool is_gap(double since_s, double usual_s) { return usual_s > 0 && since_s > (3 + 1e-3) * usual_s; }

// The time since the sample before, or the usual one after a gap, within the limit. The first stands for none: it carries no
// information, because its density has nothing to act over.
inline double interval_of_sample(double since_s, double usual_s, double max_interval_s) {
    if (!(since_s > 0)) return 0;
    return std::min(is_gap(since_s, usual_s) ? usual_s : since_s, max_interval_s);
}

// The usual time between two samples of which the second came since_s after the first.
inline double usual_interval(double since_s, double usual_s) {
    if (!(since_s > 0)) return usual_s;
    if (!(usual_s > 0)) return since_s;
    if (is_gap(since_s, usual_s)) return 1.2 * usual_s; // a sensor that has become slower is taken so after a few samples
    return usual_s + 0.1 * (since_s - usual_s);
}

} // namespace hnav
