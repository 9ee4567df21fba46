// When two times are one.
#pragma once

#include <cmath>
#include <limits>

namespace hnav {

// Callers add up steps: two times that lie closer than this are one instant. scale_s: times of the same kind lie at least so
// far apart, of which the tolerance stays a small part, also for a clock that counts from 1970.
inline double instant_s(double t_s, double scale_s) {
    const double size = std::fabs(t_s);
    const double rounding = 4 * std::numeric_limits<double>::epsilon() * size;
    return std::fmax(rounding, std::fmin(1e-9 * std::fmax(1, size), 1e-3 * scale_s));
}

} // namespace hnav
