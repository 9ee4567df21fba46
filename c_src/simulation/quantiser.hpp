// The converter of a sensor: readings are multiples of the resolution and saturate at the range.
#pragma once

#include <cmath>

namespace hnav {

struct Quantiser {
    double range = 0;      // 0: unlimited
    double resolution = 0; // 0: continuous

    double operator()(double x) const {
        if (resolution > 0) x = resolution * std::nearbyint(x / resolution);
        return range > 0 ? std::fmin(range, std::fmax(-range, x)) : x;
    }
};

} // namespace hnav
