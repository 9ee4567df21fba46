// x^2, for readable expressions; the variance of an angle without information.
#pragma once

#include <cmath>

namespace hnav {

template <class R>
constexpr R square(R x) {
    return x * x;
}

// Variance of a uniform distribution over a turn, rad^2.
template <class R>
constexpr R any_angle_variance = R(M_PI * M_PI / 3);

} // namespace hnav
