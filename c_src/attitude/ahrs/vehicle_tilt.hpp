// The tilt if the body were a vehicle: a second estimate, by the velocities of a car.
//
// A start within a lasting bend or brake looks like a rest with another vertical. The velocity of a hand makes the tilt certain within
// seconds, and a vehicle tilts the horizon of the filter. The tilt is therefore ready only while it would also be ready with the velocities
// of a car, at about the same horizon, until the body has turned faster than vehicles do. The stated variance is that of both horizons
// together: without this the squared tilt errors of aircraft and ships are 11 and 3 times the stated ones. No gain depends on it.
#pragma once

#include "attitude/ahrs/body.hpp"

namespace hnav {

// Part of a filter's state: numbers of one kind only.
template <class R>
struct VehicleTilt {
    R tilt2, tilt_velocity, velocity2; // covariance of one axis, rad and m/s; tilt2 0: no vehicle
    R tilt[2], velocity[2]; // north and east; tilt: from the horizon of the filter, by what it adds to the velocity, rad
    R rate2; // running mean square of the rate, (rad/s)^2
    R stood; // 1: the last correction was at rest

    void begin() {
        constexpr R acceleration2 = R(0.065); // square of 2.5 m/s^2 in units of gravity: a firm brake; chosen
        *this = {};
        tilt2 = acceleration2;
        forget_velocity();
    }

    void forget_velocity() {
        velocity[0] = velocity[1] = tilt_velocity = 0;
        velocity2 = 20 * 20; // any speed of a car, m/s
    }

    bool is_possible() const { return tilt2 > 0; }

    // While a speed is given, the horizon of the filter is that of a vehicle.
    void follow(R of_tilt2, R of_velocity2) {
        const R kept_rate2 = rate2;
        *this = {};
        rate2 = kept_rate2;
        tilt2 = of_tilt2;
        velocity2 = of_velocity2;
    }

    // Variance of one axis and squared distance of the two horizons, rad^2.
    R square() const { return tilt2 + tilt[0] * tilt[0] + tilt[1] * tilt[1]; }

    // Whether a force at rest is vertical for this horizon. level: its horizontal part in units of gravity, by the horizon of the filter.
    bool is_level(const R* level) const {
        constexpr R sigmas2 = 9, bias2 = R(1e-4); // squares of the limit, and of an accelerometer bias of 0.1 m/s^2
        const R north = level[0] + tilt[0], east = level[1] + tilt[1];
        return north * north + east * east < sigmas2 * (tilt2 + bias2);
    }

    // Over T seconds. gathered: horizontal force times time; correction: of the filter's horizon about north and east, rad; turned2: integral
    // of the squared rate, rad^2/s; turn2: variance of the rotation by gyro noise, rad^2; rest_density2: of the velocity at rest,
    // (m/s)^2/Hz, 0: not at rest; g: gravity.
    void note(const R* gathered, const R* correction, R turned2, R turn2, R rest_density2, R g, R T) {
        constexpr R memory_s = 2, fastest2 = R(0.5) * R(0.5); // (rad/s)^2: vehicles turn slower, hands and feet faster; chosen
        rate2 += (turned2 - rate2 * T) / (memory_s + T);
        if (rate2 > fastest2) {
            *this = {};
            return;
        }
        const bool stands = rest_density2 > 0;
        if (stands && !(stood > 0)) begin_rest();
        stood = stands;
        for (int i = 0; i < 2; ++i) velocity[i] += gathered[i] + g * T * tilt[i];
        tilt[0] += correction[1];
        tilt[1] -= correction[0];
        velocity2 += g * T * (2 * tilt_velocity + g * T * tilt2);
        tilt_velocity += g * T * tilt2;
        tilt2 += turn2;
        correct((stands ? rest_density2 : lasting_density2_of<R>(HNAV_BODY_CAR)) / T);
    }

private:
    // The velocity is relative to that at the begin of a rest: a vehicle at constant velocity is as quiet as one at rest.
    void begin_rest() {
        velocity[0] = velocity[1] = tilt_velocity = 0;
        velocity2 = R(0.01);
    }

    // By 0 = v.
    void correct(R noise2) {
        const R S = velocity2 + noise2, kept = noise2 / S, gain = tilt_velocity / S;
        for (int i = 0; i < 2; ++i) {
            tilt[i] -= gain * velocity[i];
            velocity[i] *= kept;
        }
        tilt2 -= gain * tilt_velocity;
        tilt_velocity *= kept;
        velocity2 *= kept;
    }
};

} // namespace hnav
