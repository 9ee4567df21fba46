// Tests whether the field is constant in body axes. In a smooth bend a vehicle has the force and the rate of a body at rest, and its turn
// would be estimated as gyro bias; but the field turns in its axes.
#pragma once

#include "maths/rotation.hpp"
#include "maths/square.hpp"

#include <algorithm>
#include <cmath>

namespace hnav {

// Part of a filter's state: numbers of one kind only.
template <class R>
struct StillField {
    R first[3], mean[3]; // mean at the begin and present mean, in units of the reference's strength
    R turn[3]; // that the gyroscope shows since the begin, rad
    R noise2; // mean square of one axis about the mean
    R limit2; // square of the change that a constant field may show
    R still_s; // 0: there is no first mean yet

    void begin() { *this = {}; }

    // field_b: mean over the T seconds since the last call; rate: of the body, body axes. Returns false if the field has turned.
    bool note(const Vector3Of<R>& field_b, const Vector3Of<R>& rate, R T) {
        // Time constants of the mean (and length of the first mean) and of the noise.
        constexpr R mean_s = R(0.5), noise_s = 2;
        // Turn of a constant field by the resolution of a magnetometer, rad: 0.2 uT of 50. Square of the limit in sigmas of a mean.
        constexpr R least_turn = R(0.004), sigmas2 = 16;
        Eigen::Map<Vector3Of<R>> now(mean), before(first);
        if (!(still_s > 0)) now = field_b;
        still_s += T;
        const Vector3Of<R> away = field_b - now;
        now += T / (std::min(still_s, mean_s) + T) * away;
        noise2 += T / (noise_s + T) * (away.squaredNorm() / 3 - noise2);
        if (still_s <= mean_s) before = now;
        else Eigen::Map<Vector3Of<R>>(turn) += T * rate;
        limit2 = least_turn * least_turn + sigmas2 * noise2 * T / mean_s;
        return (now - before).squaredNorm() <= limit2;
    }

    // Whether the turn that the gyroscope shows would have changed the field clearly.
    bool excludes_turn() const {
        constexpr R clear = 3; // chosen: iron may hide two thirds of the Earth's field
        return Vector3Of<R>(turn).cross(Vector3Of<R>(mean)).squaredNorm() > square(clear) * limit2;
    }
};

} // namespace hnav
