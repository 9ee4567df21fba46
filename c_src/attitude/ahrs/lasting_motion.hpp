// Lasting velocities. The velocity of a hand returns to 0 within a second; that of a vehicle lasts for many. If a vehicle's velocity is
// treated as that of a hand, every bend and brake tilts the horizon. The gyroscope distinguishes the two: over W seconds an error of the
// horizontal force of variance F, by tilt and bias, explains an integrated force of variance W^2 F. The excess is motion.
//
// The same force distinguishes a wrong horizon from an acceleration. If the body accelerates, the vertical component of the mean force is
// g and its length exceeds g. If the horizon is wrong, its length is g and the vertical component is smaller.
#pragma once

#include "base/instant.hpp"
#include "maths/rotation.hpp"

#include <algorithm>
#include <cmath>

namespace hnav {

// Part of a filter's state: numbers of one kind only.
template <class R>
struct LastingMotion {
    static constexpr int scales = 3;
    static constexpr R scale_s[scales] = {2, 5, R(12.5)};
    // Chosen: a departure counts as rest for up to a second. With its acceleration as the force at rest, a lift that starts with .6 m/s^2 had no ready
    // tilt until the next rest.
    static constexpr R rest_force_s = 5;
    static constexpr R down_s = 2, down_memory_s = 30; // of the vertical velocity, and of its means
    static constexpr R by_chance2 = 4; // squares beyond two sigmas show that an accelerometer is worse than stated

    R before[2]; // velocity after the last correction
    R velocity[scales][2]; // horizontal, integrated from the force, each decaying over its scale
    R lasting[scales][2]; // its running mean, which excludes motion that returns within the scale
    R power[scales], now[scales]; // mean square of one axis in excess of the tilt error: running mean and present value, (m/s)^2
    R counted2; // largest value that the last correction used as noise of zero velocity
    R down, down2; // vertical velocity, decaying over down_s, and its running mean square
    R down_mean, down_noted_s; // its mean over at most down_memory_s, and the time that this covers
    R mean_force[3], mean_share; // exponentially weighted sum of the force over some seconds, and of the weights
    R rest_force; // length of the mean force at rest, the last seconds of it, m/s^2; 0: no rest since this began
    R force[3], force_s; // integrated in navigation axes while it contradicts the horizon, and the time
    R lost_turn2; // variance of the rotation that faulty rates missed in that time, rad^2

    // Initialises for an unknown motion, whose velocity has this mean square.
    void begin(R power2) {
        *this = {};
        power[0] = power2; // the shortest scale decays soonest
        down2 = power2;
    }

    void forget_velocity() {
        before[0] = before[1] = down = 0;
        for (auto& v : velocity) v[0] = v[1] = 0;
        for (auto& v : lasting) v[0] = v[1] = 0;
        forget_force();
    }

    void forget_force() { force[0] = force[1] = force[2] = force_s = lost_turn2 = 0; }

    // Force times time in navigation axes over T seconds. force2: variance of the horizontal force of one axis by errors of horizon and bias,
    // (m/s^2)^2; g: gravity.
    void note(const Vector3Of<R>& gathered, R force2, R g, R T) {
        // sigmas2 is chosen on the simulated motions: with 9 walkers have 1.17 deg instead of 1.06, with 6.5 hands on CROP 2.92 instead of 2.89.
        constexpr R sigmas2 = R(7.5), min_memory_s = 5, mean_of_scale = R(0.5), mean_force_s = 5;
        for (int j = 0; j < scales; ++j) {
            const R W = scale_s[j];
            R* v = velocity[j];
            R* mean = lasting[j];
            for (int i = 0; i < 2; ++i) {
                v[i] += gathered[i] - T / (W + T) * v[i];
                mean[i] += T / (mean_of_scale * W + T) * (v[i] - mean[i]);
            }
            now[j] = std::max(R(0), (mean[0] * mean[0] + mean[1] * mean[1]) / 2 - sigmas2 * force2 * W * W);
            power[j] += T / (std::max(min_memory_s, W) + T) * (now[j] - power[j]);
        }
        down += gathered[2] + g * T - T / (down_s + T) * down;
        down2 += T / (down_memory_s + T) * (down * down - down2);
        down_noted_s = std::min(down_memory_s, down_noted_s + T);
        down_mean += T / down_noted_s * (down - down_mean);
        const R share = T / (mean_force_s + T);
        mean_share += share * (1 - mean_share);
        for (int i = 0; i < 3; ++i) {
            mean_force[i] += share * (gathered[i] / T - mean_force[i]);
            force[i] += gathered[i];
        }
        force_s += T;
    }

    // Rest ends all lasting velocities. force: present length of the force, which is gravity plus accelerometer bias.
    void settle(R force, R T) {
        constexpr R settled_s = R(0.5);
        rest_force += (rest_force > 0 ? T / (rest_force_s + T) : R(1)) * (force - rest_force);
        counted2 = 0;
        for (R& p : power) p *= std::exp(-T / settled_s);
    }

    // A lasting velocity does not end when it is no longer counted as noise: a car at 20 m/s continues. Its square is added to the variance
    // of the velocity at the next correction; otherwise 0 = v would tilt the horizon.
    R uncount() {
        R counted_now2 = 0;
        for (int j = 0; j < scales; ++j) counted_now2 = std::max(counted_now2, std::max(power[j], now[j]));
        const R released2 = std::max(R(0), counted2 - counted_now2);
        counted2 = counted_now2;
        return released2;
    }

    // Whether the length of the mean force differs from that at rest (before any rest: from gravity): a lasting acceleration.
    bool may_accelerate(R g) const {
        // That of a bank of 16 deg. A smaller limit is exceeded by a fast hand with a correct horizon, whose mean force differs by 0.3 m/s^2.
        constexpr R longer_m_s2 = R(0.4);
        if (!(mean_share > 0)) return false;
        const R expected = rest_force > 0 ? rest_force : g;
        return std::fabs(Vector3Of<R>(mean_force).norm() / mean_share - expected) > longer_m_s2;
    }

    // Square of the error of the accelerometer along the vertical, (m/s^2)^2: by the length of the force at the last rest, and by the mean of
    // the vertical velocity, into which an error b enters as down_s b. Velocities of the body return to 0; what is left of them in the mean
    // is taken off.
    R vertical_error2(R g) const {
        const R by_rest = rest_force > 0 ? rest_force - g : 0, mean2 = down_mean * down_mean;
        const R left2 = down_noted_s > 0 ? std::max(R(0), down2 - mean2) * 2 * down_s / down_noted_s : mean2;
        return std::max(by_rest * by_rest, (mean2 - by_chance2 * left2) / (down_s * down_s));
    }

    // Variance of the horizon by an accelerometer that is worse than stated, rad^2. Its error along the vertical shows; those along the other
    // axes are taken for as large. So is a force without gravity or of another unit. Recorded hands whose accelerometer has an unstated bias
    // of 0.2 m/s^2 have a z2 of the tilt of 1.2, without it 4.8. stated2: variance of the stated bias, (m/s^2)^2; g: gravity.
    R unstated_tilt2(R g, R stated2) const {
        constexpr R local_m_s2 = R(0.02); // of gravity between the equator and the poles
        return std::max(R(0), vertical_error2(g) - by_chance2 * (stated2 + local_m_s2 * local_m_s2)) / (g * g);
    }

    // Spectral density of the velocity at frequency zero, (m/s)^2/Hz, 2 sigma^2 tau, largest over the scales.
    R density2() const {
        R most = 0;
        for (int j = 0; j < scales; ++j) most = std::max(most, 2 * scale_s[j] * std::max(power[j], now[j]));
        return most;
    }

    // Logarithm of the likelihood ratio of a wrong horizon to an accelerating body. 0: the interval is too short, or acceleration is
    // likelier, and the integration restarts. least_vertical2: mean square of the vertical velocity, at least, (m/s)^2.
    R wrong_horizon(R g, R least_vertical2) {
        constexpr R least_s = 3, longest_s = 20, min_ratio = R(0.5), velocity2 = R(0.01), bias2 = R(0.0025), sigmas2 = 9;
        // An aircraft in a turn that begins to sink has for some seconds a mean force of g beside its horizon. What goes far may climb or
        // sink by one part in seven: the square of a slope, chosen between .0025 and .08 on simulated aircraft and cars.
        constexpr R slope2 = R(0.02);
        if (!has_lasted(force_s, least_s)) return 0;
        const Vector3Of<R> f = Vector3Of<R>(force) / force_s;
        const R by_down = f[2] + g, by_length = f.norm() - g;
        const R vertical2 = std::max(down2 + velocity2 + slope2 * std::max(power[1], now[1]), least_vertical2);
        const R variance = vertical2 / (force_s * force_s) + bias2;
        const R ratio = (by_down * by_down - by_length * by_length) / (2 * variance);
        // A force whose length differs from gravity contradicts a wrong horizon.
        if (ratio > min_ratio && !has_passed(force_s, longest_s) && by_length * by_length < sigmas2 * variance) return ratio;
        forget_force();
        return 0;
    }

    // After a correction, which turned the horizon about north and east: adjusts the integrated force.
    void turn(const R* velocity_now, R north_rad, R east_rad, R g) {
        before[0] = velocity_now[0];
        before[1] = velocity_now[1];
        for (int j = 0; j < scales; ++j) {
            const R north = -g * scale_s[j] * east_rad, east = g * scale_s[j] * north_rad;
            velocity[j][0] += north;
            velocity[j][1] += east;
            lasting[j][0] += north;
            lasting[j][1] += east;
        }
    }
};

} // namespace hnav
