// Estimates the velocity of the body from its force. The accelerometer observes the tilt because the velocity is bounded; the accuracy
// depends on that bound. In a hand it is the option's value; on a bench it is 0, and only the noise of the force limits the tilt.
#pragma once

#include "maths/rotation.hpp"

#include <cmath>

namespace hnav {

// Part of a filter's state: numbers of one kind only.
template <class R>
struct MotionNoise {
    // Ratio of density to RMS velocity; chosen: on recordings of hands the tilt error is smallest.
    static constexpr R densities = R(1.1); // sqrt(s)
    static constexpr R min_density = R(0.02); // m/s/sqrt(Hz)
    // The same while the body is not at rest: a ship in a smooth turn accelerates for a minute, which the velocity over a second does not
    // show.
    static constexpr R min_moving_density = R(0.05);
    static constexpr R force_density =
        R(0.002); // m/s^2/sqrt(Hz), noise of a usual chip, which the velocity integrates on a bench

    R mean_force[2]; // horizontal; contains the tilt error, which is not motion
    R velocity[2]; // integrated from the rest of the force, decaying
    R power; // running mean square of one axis, (m/s)^2

    // Initialises for an unknown motion, up to the limit of the options.
    void begin(R max_density2) {
        mean_force[0] = mean_force[1] = 0;
        forget_velocity();
        power = max_density2 / (densities * densities);
    }

    void forget_velocity() { velocity[0] = velocity[1] = 0; }

    void note(const Vector3Of<R>& force_n, R T) {
        constexpr R mean_s = 3, fading_s = 1, memory_s = 10;
        for (int i = 0; i < 2; ++i) {
            mean_force[i] += T / (mean_s + T) * (force_n[i] - mean_force[i]);
            velocity[i] += T * (force_n[i] - mean_force[i]) - T / (fading_s + T) * velocity[i];
        }
        power += T / (memory_s + T) * (now() - power);
    }

    // A motion counts from its first sample, and for a while after its end.
    R density2(R max_density2, bool at_rest) const {
        const R least = at_rest ? min_density : min_moving_density;
        const R seen = densities * densities * std::fmax(power, now());
        return std::fmin(max_density2, std::fmax(least * least, seen));
    }

private:
    R now() const { return (velocity[0] * velocity[0] + velocity[1] * velocity[1]) / 2; }
};

} // namespace hnav
