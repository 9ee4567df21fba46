// The uncertainty of what happened while samples were missing.
#pragma once

#include "maths/rotation.hpp"
#include "maths/square.hpp"
#include "signals/sampling.hpp"

namespace hnav {

// The variance of the turn in a gap, from how fast the rate has changed: after T seconds the turn is known to a T^2 / 2 by the last
// rate, and to a T^2 / 8 by the mean of the last and the next, with an angular acceleration a as it was before.
// Part of a filter's state: a number.
template <class R>
struct RateChange {
    R power; // running mean square of the change per second, of one axis

    void note(const Vector3Of<R>& change, R interval_s) {
        constexpr R memory_s = 2; // longer than a swing of the arm
        const R square = change.squaredNorm() / (3 * interval_s * interval_s);
        power += interval_s / (interval_s + memory_s) * (square - power);
    }

    // Variance of the rotation about an axis. ended: the sample after the gap exists. factor: multiplies the usual change.
    R gap_variance(R gap_s, bool ended, R factor) const {
        const R share = (ended ? R(0.125) : R(0.5)) * factor * gap_s * gap_s;
        return share * share * power;
    }

    // The same for an estimate shown silence_s after its newest event; usual_s: the interval between two samples of the rate.
    R silence_variance(double silence_s, double usual_s, R factor) const {
        return is_gap(silence_s, usual_s) ? std::fmin(any_angle_variance<R>, gap_variance(R(silence_s), false, factor)) : 0;
    }
};

// Variances about one axis for a gap between inertial samples of a vehicle: of its turn, velocity and displacement.
struct GapMotion {
    static constexpr double rate_rad_s = 0.2, force_m_s2 = 2; // chosen: a brisk turn and a firm brake of a car
    double turn2, gain2, way2;

    // Mean square of what one axis does unseen; swing2: how the body has just swung, of three axes.
    static double unseen2(double usual, double swing2) { return usual * usual + swing2 / 3; }

    // The part of the gap from from_s to to_s after the last sample. It turns and accelerates as vehicles do and, once the gap is as
    // long as a swing, by as much as it has just swung (mean squares of rate and force about their means, three axes together).
    void add(double from_s, double to_s, double usual_s, double swing_rate2, double swing_force2) {
        if (!is_gap(to_s, usual_s)) return;
        add_whole(to_s - usual_s, 1, swing_rate2, swing_force2);
        if (is_gap(from_s, usual_s)) add_whole(from_s - usual_s, -1, swing_rate2, swing_force2);
    }

private:
    void add_whole(double gap_s, double sign, double swing_rate2, double swing_force2) {
        constexpr double swing_s = 0.3; // shorter gaps: the change between the samples is even
        const double gap2 = sign * gap_s * gap_s, swings2 = std::fmin(1, gap_s * gap_s / (swing_s * swing_s));
        const double shown = swings2 * swings2;
        const double gain = gap2 * unseen2(force_m_s2, shown * swing_force2);
        turn2 += gap2 * unseen2(rate_rad_s, shown * swing_rate2);
        gain2 += gain;
        way2 += gain * gap_s * gap_s / 4;
    }
};

// A clock was set: the body has hardly moved, but the length of the gap is unknown. Standard deviations to add; chosen: a
// hand turns by so much in a second.
constexpr double clock_jump_tilt_rad = 0.1, clock_jump_heading_rad = 0.2;

} // namespace hnav
