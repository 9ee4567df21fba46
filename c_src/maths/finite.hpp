// Whether all of some numbers are finite.
#pragma once

#include <algorithm>
#include <cmath>

namespace hnav {

inline bool all_finite(const double* values, int count) {
    return std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
}

} // namespace hnav
