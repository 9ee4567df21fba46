// States of an integrator of the caller's, before a filter takes them.
#pragma once

#include "hnav/types.h"

#include <cmath>

namespace hnav {

// Object: has fail. q: where in x the quaternion of an attitude stands, whose direction alone counts.
template <class Object>
hnav_status check_callers_state(const Object& object, const double* x, int nx, int q) {
    constexpr double max_state = 1e50; // beyond, products overflow
    for (int i = 0; i < nx; ++i) {
        if (!std::isfinite(x[i])) return object.fail(HNAV_ERROR_NON_FINITE, "x[%d] = %g is not finite", i, x[i]);
        if (std::fabs(x[i]) > max_state)
            return object.fail(HNAV_ERROR_OUT_OF_RANGE, "x[%d] = %g lies beyond %g", i, x[i], max_state);
    }
    const double square = x[q] * x[q] + x[q + 1] * x[q + 1] + x[q + 2] * x[q + 2] + x[q + 3] * x[q + 3];
    if (!(square > 1e-12))
        return object.fail(HNAV_ERROR_OUT_OF_RANGE, "x holds a quaternion of length %g, which is no attitude", std::sqrt(square));
    return HNAV_OK;
}

} // namespace hnav
