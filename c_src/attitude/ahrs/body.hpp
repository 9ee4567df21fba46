// What the option `body` assumes of the motion: the size and duration of velocities that last, and how fast it climbs.
#pragma once

#include "hnav/options/shared.h"

namespace hnav {

// (m/s)^2/Hz at frequency zero: 2 sigma^2 tau of a velocity that changes by sigma and stays for tau. The tilt depends on this product
// alone (lasting_motion.hpp). 0: it is estimated from the force only. Chosen on the seeds 0 to 31 of the simulated motions.
template <class R>
constexpr R lasting_density2_of(int body) {
    const auto density2 = [](R speed_m_s, R duration_s) { return 2 * speed_m_s * speed_m_s * duration_s; };
    switch (body) {
    case HNAV_BODY_WALKER: return density2(R(1.2), 10); // walks and stops
    case HNAV_BODY_CAR: return density2(12, 10); // stops and crossings of a town
    case HNAV_BODY_SHIP: return density2(1, 10); // turns and swell
    case HNAV_BODY_QUADROTOR: return density2(2, 5); // from one hover to the next
    case HNAV_BODY_AIRCRAFT: return density2(30, 10); // turns by a right angle at 60 m/s
    default: return 0;
    }
}

// (m/s)^2, mean square of a vertical velocity, at least. 0: it is estimated from the force only.
template <class R>
constexpr R vertical2_of(int body) {
    return body == HNAV_BODY_QUADROTOR ? 4 : 0; // it climbs as fast as it travels
}

// (m/s)^2/Hz at frequency zero of velocities that return, beside those of a hand. Chosen: with 0 ships and boats without a fault are ready for
// 39 and 58 % of the time, with 0.4 for 50 and 84, without any suspicion of a step for 53 and 89.
template <class R>
constexpr R swell_density2_of(int body) {
    return body == HNAV_BODY_SHIP ? R(0.4) : 0;
}

// Whether its accelerations last, in bends and turns, as a drift does.
constexpr bool accelerates_long(int body) { return body == HNAV_BODY_CAR || body == HNAV_BODY_AIRCRAFT; }

} // namespace hnav
