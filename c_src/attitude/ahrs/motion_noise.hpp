// How violently the body moves, from its force. The accelerometer tells the horizon because a body does not run away; how
// tightly depends on the velocities that it has. In a hand they are what the options allow, on a bench there are none, and
// the horizon is known as well as the noise of the force lets it be.
#pragma once

#include "maths/rotation.hpp"

#include <cmath>

namespace hnav {

// Part of a filter's state: numbers of one kind only.
template <class R>
struct MotionNoise {
    // On recordings of hands the horizon is best at a density of the velocity that is so many times its root mean square.
    static constexpr R densities = R(1.1);      // sqrt(s)
    static constexpr R min_density = R(0.02);   // m/s/sqrt(Hz)
    // The same while the body is not at rest: a ship that turns smoothly has accelerations of a minute, and none that the velocity of a
    // second shows.
    static constexpr R min_moving_density = R(0.05);
    static constexpr R force_density = R(0.002); // m/s^2/sqrt(Hz), of a usual chip: what the velocity gathers on a bench

    R mean_force[2]; // horizontal; a tilted horizon shows in it, and is no motion
    R velocity[2]; // gathered from the rest of the force, and fading
    R power; // running mean square of one axis, (m/s)^2

    // Nothing is known of the motion: it may be all that the options allow.
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

    // A motion counts from its first moment, and for a while after its end.
    R density2(R max_density2, bool at_rest) const {
        const R least = at_rest ? min_density : min_moving_density;
        const R seen = densities * densities * std::fmax(power, now());
        return std::fmin(max_density2, std::fmax(least * least, seen));
    }

private:
    R now() const { return (velocity[0] * velocity[0] + velocity[1] * velocity[1]) / 2; }
};

} // namespace hnav
