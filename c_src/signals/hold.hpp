// The interval that a sampled rate or force stands for, and its mean there.
#pragma once

#include "maths/rotation.hpp"

namespace hnav {

enum class Hold { forward, backward, instant }; // hnav_gyro_hold

template <class Options>
inline Hold hold_of(const Options& o) {
    return static_cast<Hold>(o.gyro_hold);
}
// A sample determines the motion over the interval that ends with it.
template <class Options>
inline bool holds_backward(const Options& o) {
    return hold_of(o) != Hold::forward;
}

// Mean over the interval between two samples, for what is held backward. Instants: by the trapezoid; taken for means, they would
// lead by half an interval.
template <class R>
inline Vector3Of<R> mean_between(Hold hold, const Vector3Of<R>& last, const Vector3Of<R>& now) {
    return hold == Hold::instant ? Vector3Of<R>(R(0.5) * (last + now)) : now;
}

} // namespace hnav
