// Whether the innovations of one aid are what their covariance predicts. A filter whose state and noises are right has white innovations of
// unit variance, once they are divided by their sigma (Kailath 1968). Three departures are distinguished:
//
//   wrong noise   successive innovations differ by too much: the mean square successive difference (von Neumann 1941) sees noise and is
//                 blind to whatever changes slowly. It scales the stated variance: up at once, down slowly, never below what is stated
//   correlated    means over a short window scatter by more than white noise of this variance does: the samples within the correlation time,
//                 which is estimated so, have the weight of one
//   wrong state   innovations have a mean. The square of their sum, in which they fade with the time of a window, by the variance of such a
//                 sum of white ones is 1 by chance: a short window for faults, a long one for errors of the model
#pragma once

#include "maths/square.hpp"

#include <algorithm>
#include <cmath>

namespace hnav {

// Part of a filter's state: doubles only.
struct Consistency {
    static constexpr int windows = 2, most_rows = 3;
    static constexpr double window_s[windows] = {2, 20};
    static constexpr double far = 10; // sigmas; a sample that lies further off counts as one of so many
    static constexpr double memory = 20; // samples, of the successive differences
    static constexpr double largest = 25; // one difference counts at most as much
    static constexpr double at_once = 2, slow_s = 30; // ratio of variances beyond which the noise follows at once; else so slowly
    // Chosen: time in which the correlation time follows, and its start; it is at most the short window, whose means show it. Of simulated
    // bodies whose receivers have errors that last for 3 s the tilt was ready and wrong for 4 to 19 % of the time (cable car, rowing boat,
    // anchored ship), now for at most .5 %; with white errors a car is ready after 19.6 s (18.3 without).
    static constexpr double colour_slow_s = 40, usual_colour_s = 0.3;

    double sum[windows][most_rows],
        variance[windows]; // of the normalised innovations, the older the less; of such a sum, were they white
    double sum_rows; // of the newest in it
    double successive; // mean square of successive differences over twice the variance: 1 by chance
    double last[most_rows], last_rows, last_s, last_gated; // innovation
    double noise; // factor on the stated variance
    double colour_s; // correlation time; 0: errors that last have a model of their own
    double stated; // that variance, of the first row

    void begin(double noise_kept, double colour_kept_s) {
        *this = {};
        successive = 1;
        noise = noise_kept;
        colour_s = colour_kept_s;
        last_s = -HUGE_VAL;
    }
    // The noise and its correlation time stay.
    void begin_again() { begin(noise, colour_s); }
    // What was learnt is a variance: where a larger one is stated than before, so much less is missing.
    void restate(double variance) {
        if (variance > stated && stated > 0) noise = std::fmax(1, noise * stated / variance);
        stated = variance;
    }
    // r: innovations, with their variances. gated: this one lies beyond the gate. A single one beyond the gate among others is an outlier.
    // jumped: it says nothing of the mean.
    void note(const double* r, const double* variance, int rows, bool gated, bool jumped, double t_s) {
        const double since_s = std::fmin(t_s - last_s, window_s[windows - 1]);
        double change2 = 0, size2 = 0, y[most_rows] = {};
        for (int i = 0; i < rows; ++i) {
            y[i] = r[i] / std::sqrt(variance[i]);
            change2 += 0.5 * square(r[i] - last[i]) / variance[i] / rows;
            size2 += square(y[i]) / rows;
        }
        const bool alike = gated == (last_gated > 0);
        if (alike && rows == last_rows) note_noise(change2, since_s);
        const double within = size2 > far * far ? far / std::sqrt(size2) : 1;
        for (double& one : y) one *= within;
        if (!jumped && (alike || !gated)) note_mean(y, rows, since_s);
        if (!jumped && alike) note_colour(since_s);
        std::copy(r, r + rows, last);
        last_rows = rows;
        last_s = t_s;
        last_gated = gated ? 1 : 0;
    }
    // Factor on the stated variance of a sample at t_s.
    double weight(double t_s) const { return noise * std::fmax(1, t_s > last_s ? colour_s / (t_s - last_s) : 1); }
    // Square of the sum of a window by its variance, the same as of the mean: 1 by chance.
    double bias(int window) const {
        if (!(variance[window] > 0)) return 0;
        double size2 = 0;
        for (int i = 0; i < sum_rows; ++i) size2 += square(sum[window][i]);
        return size2 / variance[window] / sum_rows;
    }
    // The larger bias of the two windows.
    double bias() const { return std::fmax(bias(0), bias(1)); }
    // Call it after the covariance of the state was multiplied by this factor.
    void widen(double factor) {
        for (auto& window : sum)
            for (double& one : window) one /= std::sqrt(factor);
    }

private:
    void note_noise(double change2, double since_s) {
        successive += (std::fmin(change2, largest) - successive) / memory;
        if (successive > at_once) {
            noise *= successive;
            widen(successive); // sums were of innovations by too small a sigma
            successive = 1;
        } else {
            noise = std::fmax(1, noise * std::exp(since_s / slow_s * (successive - 1)));
        }
    }
    void note_colour(double since_s) {
        constexpr double most = 4; // one mean counts at most as much: a fault is no correlation
        if (!(colour_s > 0 && since_s < window_s[0])) return;
        const double longer = std::exp(since_s / colour_slow_s * (std::fmin(bias(0), most) - 1));
        colour_s = std::fmax(since_s, std::fmin(longer * colour_s, window_s[0]));
    }
    // Every sample counts once: by the interval before it the first one after a gap, or two receivers a millisecond apart, would refute
    // every state.
    void note_mean(const double* y, int rows, double since_s) {
        sum_rows = rows;
        for (int w = 0; w < windows; ++w) {
            const double kept = window_s[w] / (window_s[w] + since_s);
            variance[w] = square(kept) * variance[w] + 1;
            for (int i = 0; i < rows; ++i) sum[w][i] = kept * sum[w][i] + y[i];
        }
    }
};

} // namespace hnav
