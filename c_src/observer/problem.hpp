// The estimation problem of a plant: start, process noise and sensors.
//
//   X = (x, d, theta)   states, unknown inputs, parameters: N numbers, of which x and d move between samples
//   x' = f(t, x, u, d, theta) + w,   d' = -d / tau + w,   theta' = w;   y = h(t, x, u, d, theta) + v
#pragma once

#include "base/arena.hpp"
#include "base/refusal.hpp"
#include "hnav/observer.h"
#include "observer/plant.hpp"
#include "signals/sensor_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace hnav::observer {

// Sizes of arrays are an int up to here. Memory ends before: one matrix of so many has 200 MB, and an observer has more than ten.
constexpr int max_estimated = 5000;
constexpr int max_channels_used = 62; // known inputs and sensors together; see Model::channels
constexpr int max_indicators = 2000;

// Null where a default applies.
using Statistics = hnav_observer_statistics;

class Problem {
public:
    // Counts on an arena without memory.
    Problem(Arena& arena, const PlantSizes& sizes);

    static bool sizes_fit(const PlantSizes& sizes, Refusal& why);
    // What arrays are sized by.
    static bool numbers_fit(const PlantSizes& sizes, Refusal& why);
    bool assign(const Statistics& given, Refusal& why);
    std::uint64_t fingerprint(std::uint64_t start) const;

    const PlantSizes sizes;
    const int n, moving, N, known, sensors; // states; with unknown inputs; with parameters; known inputs; outputs

    double *start, *start_variance, *noise, *scale, *ready_sigma, *decay_1_s, *input_start; // noise: squared density
    double *sensor_variance, *gate_nis;
    double* noise_scale; // of the tolerances of the noise, unit / sqrt(s)
    // Range of X, a billionth of its scale inside the given bounds: roots have a derivative there. logarithmic, of parameters: 1 where X is
    // the logarithm; the other values here are then of the logarithm, except ready_sigma.
    double *low, *high, *is_log;
    bool bounded = false; // any bound, any logarithm

    // Of a difference: the cube root of the rounding, where rounding and truncation errors are equal.
    double step(int i, double x) const { return 6e-6 * std::max(std::fabs(x), scale[i]); }

private:
    bool check(const Statistics& given, Refusal& why) const;
    bool check_bounds(const Statistics& given, Refusal& why) const;
    void set_scales(const Statistics& given);
    void set_logarithm(int parameter);
    void set_bounds(const Statistics& given);
};

constexpr int max_parts = 4;
using Check = SensorCheck<double, 1>;

// Layout of a state: up to four parts, each with its own discrete state of the plant, then the shared numbers. A plant without
// events has one part.
struct Layout {
    explicit Layout(const Problem& p, bool smooths = false) {
        int end = p.moving;
        const auto take = [&end](int count) { return std::exchange(end, end + count); };
        S = take(p.moving * p.N);
        Qd = take(triangle(p.N));
        clock = take(1);
        nx = end;
        parameters = take(p.sizes.parameters);
        P = take(triangle(p.N));
        beyond = take(p.N);
        for (int* one : {&weight, &elapsed, &jumps, &next_event, &pending}) *one = take(1);
        sides = take(p.sizes.indicators);
        memory = take(p.sizes.memory);
        joint_numbers = smooths ? p.N + triangle(p.N) + p.N * p.N : 0;
        joint = take(joint_numbers);
        part_numbers = end;
        parts = p.sizes.events ? max_parts : 1;
        end = parts * part_numbers;
        inputs = take(p.known);
        information = take(p.N);
        for (int* one : {&t, &usual, &begun, &broken, &ready, &violations, &events, &corrections, &likelihood, &parts_used,
                         &stiff, &corrected, &wants_event, &held, &holds, &closed})
            *one = take(1);
        for (int* row : {&from, &course}) *row = take(p.moving);
        counts = take(all_counts);
        sensors = take(per_sensor * p.sensors);
        checks = take(check_numbers * p.sensors);
        numbers = end;
    }

    static constexpr int triangle(int n) { return n * (n + 1) / 2; }
    enum OfSensor { innovation, innovation_sigma, nis, mean_nis, samples, gated, repeats, usual_repeats, per_sensor };
    int of_sensor(int i, OfSensor what) const { return sensors + per_sensor * i + what; }
    static constexpr int check_numbers = sizeof(Check) / sizeof(double);
    enum Counts { splits, grazing, chattering, projected, holding, all_counts };

    // Of a part, relative to its beginning. x and d come first. S: moving rows of Phi; Qd: upper triangle, in units of `usual`
    // seconds; clock: time since S and Qd were reset; elapsed: time since the event of the filter.
    int S, Qd, clock, nx;
    int parameters, P;
    // Of a plant with bounds: difference of the mean of the untruncated Gaussian from x, d and the parameters, which are that of the
    // truncated one. P is not truncated: a bound that truncates again at every sample would be counted more than once.
    int beyond;
    // Weight; events of the plant with an effect; time of the next time event; share that noise has led over a guard and that is no
    // part of its own yet; 1 where an indicator is above 0; discrete state of the plant.
    int weight, elapsed, jumps, next_event, pending, sides, memory;
    // For a smoother, otherwise empty: the joint moments with X at the instant before, see joint.cpp.
    int joint, joint_numbers;
    int part_numbers;

    int parts;
    int inputs, information;
    // Of the newest event; usual length of intervals; flags and counts; log-likelihood of the newest correction; whether the plant
    // was stiff in the newest interval; time of the newest correction; whether the plant requests an event at the end of the newest step
    // of an integrator outside; how long the estimate has been held since the plant's last complete interval, and whether it is held in
    // this one; whether the joint moments are complete, so that the next interval begins others; the moving numbers after the newest event, and their largest recent rates.
    int t, usual, begun, broken, ready, violations, events, corrections, likelihood, parts_used, stiff, corrected, wants_event,
        held, holds, closed, from, course, counts, sensors, checks;
    int numbers;
};

} // namespace hnav::observer
