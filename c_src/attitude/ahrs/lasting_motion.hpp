// Velocities that last. A hand's come back within a second; a vehicle's go on for many, and a horizon that takes them for noise of a
// hand tilts with every bend and brake. The gyroscope tells the two apart: over W seconds a horizon that is known to a tilt of
// variance P lets the force gather no more than (g W)^2 P of velocity. What is more was a motion.
//
// The same force tells a horizon that is wrong. A body that accelerates feels gravity and more: its mean force is upwards by
// g and longer than g. One whose horizon is wrong feels gravity alone: its mean force is g long and upwards by less.
#pragma once

#include "base/instant.hpp"
#include "maths/rotation.hpp"

#include <cmath>

namespace hnav {

// Part of a filter's state: numbers of one kind only.
template <class R>
struct LastingMotion {
    static constexpr int scales = 3;
    static constexpr R scale_s[scales] = {2, 5, R(12.5)};

    R before[2]; // velocity after the last correction
    R velocity[scales][2]; // horizontal, gathered from the force, each fading over its scale
    R lasting[scales][2]; // its running mean: what comes back within the scale, as a hand does, is not in it
    R power[scales], now[scales]; // square of one axis beyond what the tilt explains, running mean and present one, (m/s)^2
    R counted2; // the largest of these that the last correction took for noise of a zero velocity
    R down, down2; // vertical velocity, fading over two seconds, and its running mean square
    R mean_force[3], mean_share; // its fading sum over some seconds, and that of ones
    R rest_force; // length of the mean force at the last rest, m/s^2; 0: no rest since this began
    R force[3], force_s; // gathered in navigation axes while it speaks against the horizon, and for how long

    // Nothing is known of the motion: its velocity has this mean square.
    void begin(R power2) {
        *this = {};
        power[0] = power2; // the shortest scale forgets it soonest
        down2 = power2;
    }

    void forget_velocity() {
        before[0] = before[1] = down = 0;
        for (auto& v : velocity) v[0] = v[1] = 0;
        for (auto& v : lasting) v[0] = v[1] = 0;
        forget_force();
    }

    void forget_force() { force[0] = force[1] = force[2] = force_s = 0; }

    // Force times time in navigation axes over T seconds, by a horizon of tilt variance tilt2; g: gravity.
    void note(const Vector3Of<R>& gathered, R tilt2, R g, R T) {
        constexpr R sigmas2 = 9, min_memory_s = 5, down_s = 2, down_memory_s = 30, mean_of_scale = R(0.5), mean_force_s = 5;
        for (int j = 0; j < scales; ++j) {
            const R W = scale_s[j], explained = g * W;
            R* v = velocity[j];
            R* mean = lasting[j];
            for (int i = 0; i < 2; ++i) {
                v[i] += gathered[i] - T / (W + T) * v[i];
                mean[i] += T / (mean_of_scale * W + T) * (v[i] - mean[i]);
            }
            now[j] = std::fmax(R(0), (mean[0] * mean[0] + mean[1] * mean[1]) / 2 - sigmas2 * tilt2 * explained * explained);
            power[j] += T / (std::fmax(min_memory_s, W) + T) * (now[j] - power[j]);
        }
        down += gathered[2] + g * T - T / (down_s + T) * down;
        down2 += T / (down_memory_s + T) * (down * down - down2);
        const R share = T / (mean_force_s + T);
        mean_share += share * (1 - mean_share);
        for (int i = 0; i < 3; ++i) {
            mean_force[i] += share * (gathered[i] / T - mean_force[i]);
            force[i] += gathered[i];
        }
        force_s += T;
    }

    // A body at rest has none: what it had has ended. force: its length now, which is gravity and the bias of the accelerometer.
    void settle(R force, R T) {
        constexpr R settled_s = R(0.5);
        rest_force = force;
        counted2 = 0;
        for (R& p : power) p *= std::exp(-T / settled_s);
    }

    // A velocity that no longer counts as noise has not ended: a car that went at 20 m/s goes on. Its square is what the velocity at the
    // next correction is uncertain by; else 0 = v would tilt the horizon until the force had taken the velocity away.
    R uncount() {
        R counted_now2 = 0;
        for (int j = 0; j < scales; ++j) counted_now2 = std::fmax(counted_now2, std::fmax(power[j], now[j]));
        const R released2 = std::fmax(R(0), counted2 - counted_now2);
        counted2 = counted_now2;
        return released2;
    }

    // The mean force of some seconds has another length than at rest, or than gravity before any rest: the body accelerates for long.
    bool may_accelerate(R g) const {
        // Of a bank of 16 deg. Less takes the swing of a hand for one: the mean force of a fast hand is off by 0.3 m/s^2 and its horizon right.
        constexpr R longer_m_s2 = R(0.4);
        if (!(mean_share > 0)) return false;
        const R expected = rest_force > 0 ? rest_force : g;
        return std::fabs(Vector3Of<R>(mean_force).norm() / mean_share - expected) > longer_m_s2;
    }

    // Of the velocity at frequency zero, (m/s)^2/Hz, by the scale that shows most: 2 sigma^2 tau.
    R density2() const {
        R most = 0;
        for (int j = 0; j < scales; ++j) most = std::fmax(most, 2 * scale_s[j] * std::fmax(power[j], now[j]));
        return most;
    }

    // Logarithm of the ratio of likelihoods that the horizon is wrong and that the body accelerates. 0: too early to tell, or nothing
    // speaks for it, and the force is gathered anew.
    R wrong_horizon(R g) {
        constexpr R least_s = 3, longest_s = 20, min_ratio = R(0.5), velocity2 = R(0.01), bias2 = R(0.0025), sigmas2 = 9;
        // An aircraft in a turn that begins to sink has for some seconds a mean force of g beside its horizon. What goes far may climb or
        // sink by one part in seven: the square of a slope, chosen between .0025 and .08 on simulated aircraft and cars.
        constexpr R slope2 = R(0.02);
        if (!has_lasted(force_s, least_s)) return 0;
        const Vector3Of<R> f = Vector3Of<R>(force) / force_s;
        const R by_down = f[2] + g, by_length = f.norm() - g;
        const R vertical2 = down2 + velocity2 + slope2 * std::fmax(power[1], now[1]);
        const R variance = vertical2 / (force_s * force_s) + bias2;
        const R ratio = (by_down * by_down - by_length * by_length) / (2 * variance);
        // A force of another length than gravity is explained by neither.
        if (ratio > min_ratio && !has_passed(force_s, longest_s) && by_length * by_length < sigmas2 * variance) return ratio;
        forget_force();
        return 0;
    }

    // After a correction, which turned the horizon about north and east: the force gathered before was another.
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
