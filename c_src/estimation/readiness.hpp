// When an estimate may be relied upon. A small sigma is not enough: it may be the sigma that the filter started with, or
// a sigma that has shrunk without evidence. So an angle is ready when its sigma is below a limit and the corrections since
// the start have brought at least as much information as that limit stands for. A variance that rounding has left without
// its sign is not small.
#pragma once

#include "maths/rotation.hpp"

namespace hnav {

// The larger of the variances about north and east.
template <class R>
inline R tilt_variance(const Vector3Of<R>& rotation_variances) {
    return std::fmax(rotation_variances[0], rotation_variances[1]);
}

// Information about an angle that a correction brought, 1/rad^2, from its variances before and after.
template <class R>
inline R information_gained(R before, R after) {
    return after > 0 && before > after ? 1 / after - 1 / before : 0;
}

// What corrections have brought since the start, 1/rad^2. Part of a filter's state.
template <class R>
struct AngleInformation {
    R tilt, heading;

    // Variances of the rotation error about the navigation axes before and after a correction.
    void gain_tilt(const Vector3Of<R>& before, const Vector3Of<R>& after) {
        tilt += information_gained(tilt_variance<R>(before), tilt_variance<R>(after));
    }
    void gain_heading(const Vector3Of<R>& before, const Vector3Of<R>& after) {
        heading += information_gained(before[2], after[2]);
    }
};

// As much information as the limit stands for.
template <class R>
inline bool is_earned(R information, R limit) {
    return information > 1 / (limit * limit);
}

template <class R>
inline bool angle_ready(R variance, R information, R limit_rad) {
    return variance > 0 && variance < limit_rad * limit_rad && is_earned(information, limit_rad);
}

} // namespace hnav
