// Variance of the tilt if the body were a vehicle.
//
// A start within a lasting bend or brake looks like a rest with another vertical, and the velocity of a hand makes the tilt certain within
// seconds. The tilt is therefore ready only when it would also be ready with the velocities of a car, or after a rest, or after the body
// has turned faster than vehicles do. No gain and no output variance depends on it.
#pragma once

#include "attitude/ahrs/body.hpp"

namespace hnav {

// Part of a filter's state: numbers of one kind only.
template <class R>
struct VehicleTilt {
    R tilt2, tilt_velocity, velocity2; // covariance of one axis, rad and m/s; tilt2 0: rested, or no vehicle
    R rate2; // running mean square of the rate, (rad/s)^2

    void begin() {
        constexpr R acceleration2 = R(0.065); // square of 2.5 m/s^2 in units of gravity: a firm brake; chosen
        *this = {acceleration2, 0, 20 * 20, 0}; // 20 m/s: any speed of a car
    }
    // Over T seconds. turned2: integral of the squared rate, rad^2/s; turn2: variance of the rotation by gyro noise, rad^2; g: gravity.
    void note(R turned2, R turn2, R g, R T) {
        constexpr R memory_s = 2, fastest2 = R(0.5) * R(0.5); // (rad/s)^2: vehicles turn slower, hands and feet faster; chosen
        constexpr R density2 = lasting_density2_of<R>(HNAV_BODY_CAR);
        rate2 += (turned2 - rate2 * T) / (memory_s + T);
        if (rate2 > fastest2) {
            tilt2 = 0;
            return;
        }
        velocity2 += g * T * (2 * tilt_velocity + g * T * tilt2);
        tilt_velocity += g * T * tilt2;
        tilt2 += turn2;
        const R S = velocity2 + density2 / T, kept = density2 / T / S;
        tilt2 -= tilt_velocity * tilt_velocity / S;
        tilt_velocity *= kept;
        velocity2 *= kept;
    }
};

} // namespace hnav
