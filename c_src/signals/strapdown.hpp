// Rate and force between two samples of an inertial unit: held, with what coning and sculling add, and the vibration that
// neighbouring samples show.
#pragma once

#include "maths/rotation.hpp"
#include "signals/hold.hpp"
#include "signals/slow_noise.hpp"

#include <cmath>
#include <limits>

namespace hnav {

// Part of a filter's state: numbers of eight bytes only.
struct HeldSample {
    static constexpr int history = 3; // turns before the present one

    double rate[3], force[3]; // means over the interval in which they act
    double read_rate[2][3], read_force[2][3]; // the last two samples as measured
    double coning[3], sculling[3]; // corrections to them
    double past_turn[history][3], past_gain[history][3], past_interval_s;
    double vibration_rate2, vibration_force2; // variance of one axis between neighbouring samples

    void begin() {
        *this = {};
        forget_past();
    }

    // A new sample, interval_s after the last one.
    void hold(const Vector3& now_rate, const Vector3& now_force, double interval_s, double usual_interval_s, Hold hold) {
        const bool is_even = std::fabs(interval_s - past_interval_s) <= 0.2 * interval_s;
        if (is_even) note_vibration(now_rate, now_force, interval_s);
        vector(coning).setZero();
        vector(sculling).setZero();
        if (hold == Hold::backward) bridge(now_rate, now_force, interval_s, usual_interval_s);
        const Hold between = std::isfinite(interval_s) ? hold : Hold::forward; // there is a last sample
        const Vector3 new_rate = mean_between<double>(between, vector(read_rate[0]), now_rate);
        const Vector3 new_force = mean_between<double>(between, vector(read_force[0]), now_force);
        take(now_rate, read_rate);
        take(now_force, read_force);
        vector(rate) = new_rate;
        vector(force) = new_force;
        if (!(interval_s > 0)) return;
        if (!is_even) forget_past();
        const Vector3 turn = interval_s * new_rate, gain = interval_s * new_force;
        if (hold != Hold::forward) put_coning(turn, gain, interval_s);
        for (int k = history - 1; k > 0; --k) {
            vector(past_turn[k]) = vector(past_turn[k - 1]);
            vector(past_gain[k]) = vector(past_gain[k - 1]);
        }
        vector(past_turn[0]) = turn;
        vector(past_gain[0]) = gain;
        past_interval_s = interval_s;
    }

private:
    static Eigen::Map<Vector3> vector(double* v) { return Eigen::Map<Vector3>(v); }

    static void take(const Vector3& now, double (*read)[3]) {
        vector(read[1]) = vector(read[0]);
        vector(read[0]) = now;
    }

    void forget_past() {
        for (int k = 0; k < history; ++k)
            for (int i = 0; i < 3; ++i) past_turn[k][i] = past_gain[k][i] = std::numeric_limits<double>::quiet_NaN();
    }

    // Changes between neighbouring samples show the rotation of the axes within one. With three of them a coning of 10 Hz at
    // 200 Hz is removed; the coefficients make the error of a steady coning vanish to the seventh order of its angle.
    void put_coning(const Vector3& turn, const Vector3& gain, double interval_s) {
        constexpr double share[history] = {113.0 / 840, -13.0 / 420, 1.0 / 280};
        Vector3 by_turn = Vector3::Zero(), by_gain = Vector3::Zero();
        for (int k = 0; k < history; ++k) {
            const Vector3 turn_k = vector(past_turn[k]), gain_k = vector(past_gain[k]);
            by_turn += share[k] * turn_k.cross(turn);
            by_gain += share[k] * (turn_k.cross(gain) + gain_k.cross(turn));
        }
        if (!std::isfinite(by_turn.sum() + by_gain.sum())) return;
        vector(coning) = by_turn / interval_s;
        vector(sculling) = by_gain / interval_s;
    }

    // After missing samples, rate and force are interpolated linearly from the last sample to the new one, which is the mean
    // of its own interval.
    void bridge(const Vector3& new_rate, const Vector3& new_force, double interval_s, double usual_interval_s) {
        if (!(usual_interval_s > 0) || !(interval_s > 1.5 * usual_interval_s)) return;
        const double share = 0.5 * (1 - usual_interval_s / interval_s);
        vector(coning) = share * (vector(rate) - new_rate);
        vector(sculling) = share * (vector(force) - new_force);
    }

    // The difference between a sample and the mean of its neighbours, evenly spaced: vibration, and the noise of the sensor. A motion that
    // the sampling resolves leaves nothing there.
    void note_vibration(const Vector3& new_rate, const Vector3& new_force, double interval_s) {
        constexpr double memory_s = 2, longest_s = 1; // longer is a gap, after which INS starts again
        if (!(interval_s > 0) || !(interval_s < longest_s)) return;
        const double share = interval_s / (memory_s + interval_s);
        const double rate2 = second_difference2(new_rate, vector(read_rate[0]), vector(read_rate[1]));
        const double force2 = second_difference2(new_force, vector(read_force[0]), vector(read_force[1]));
        vibration_rate2 += share * (rate2 / second_difference2_of_white - vibration_rate2);
        vibration_force2 += share * (force2 / second_difference2_of_white - vibration_force2);
    }
};

} // namespace hnav
