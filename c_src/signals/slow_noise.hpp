// Noise of rate and force at low frequencies, as short means of them show it: what an integral keeps of a vibration, whose power lies above.
#pragma once

#include "maths/rotation.hpp"

#include <cmath>

namespace hnav {

// Square of the second difference of three samples: what a motion that the sampling resolves leaves of it is small. White samples of variance 1
// have second differences of variance 6, on three axes 18.
inline double second_difference2(const Vector3& now, const Vector3& last, const Vector3& before) {
    return (now - 2 * last + before).squaredNorm();
}
constexpr double second_difference2_of_white = 18;

// Part of a filter's state: numbers of eight bytes only.
struct SlowNoise {
    static constexpr int rate = 0, force = 1;

    double sum[2][3], samples, length_s; // of the present mean
    double before[2][2][3]; // the two means before it
    double means; // number of them
    double variance[2]; // of one axis of a sample, if white noise caused the changes of the means

    // A sample, interval_s after the last one.
    void note(const Vector3& new_rate, const Vector3& new_force, double interval_s) {
        // Chosen: half a period of 10 Hz, where engines vibrate and vehicles hardly move. With .02 and .1 s the position of a simulated
        // tractor with carrier phase has a z2 of 14 and 3.5 instead of .8.
        constexpr double mean_s = 0.05;
        // Chosen: memory; an interval that is a gap, after which the means begin again. From 1 to 20 s, and with 1 s, figures hardly change.
        constexpr double memory_s = 5, longest_s = 0.5;
        if (!(interval_s > 0 && interval_s < longest_s)) return begin_mean(0);
        vector(sum[rate]) += new_rate;
        vector(sum[force]) += new_force;
        ++samples;
        length_s += interval_s;
        if (length_s < mean_s - 0.5 * interval_s) return;
        const double share = std::fmax(length_s / (memory_s + length_s), 1 / std::fmax(1, means - 1));
        for (const int k : {rate, force}) note_mean(k, share);
        begin_mean(means + 1);
    }

    // The smaller one of this variance and that between neighbouring samples: white noise makes them equal, a vibration this one smaller, a motion
    // larger.
    double at_most(double between, int k) const {
        constexpr double enough = 10; // means: chosen; the figures with 3 and 30 are the same
        return means < enough ? between : std::fmin(between, variance[k]);
    }

private:
    static Eigen::Map<Vector3> vector(double* v) { return Eigen::Map<Vector3>(v); }

    void begin_mean(double number) {
        means = number;
        samples = length_s = 0;
        vector(sum[rate]).setZero();
        vector(sum[force]).setZero();
    }

    void note_mean(int k, double share) {
        const Vector3 mean = vector(sum[k]) / samples;
        const double change2 = second_difference2(mean, vector(before[k][0]), vector(before[k][1]));
        if (means >= 2) variance[k] += share * (samples * change2 / second_difference2_of_white - variance[k]);
        vector(before[k][1]) = vector(before[k][0]);
        vector(before[k][0]) = mean;
    }
};

} // namespace hnav
