// What is to be estimated of a plant, and what is known beforehand of its start, its noise and its sensors.
//
//   X = (x, d, theta)   states, unknown inputs, parameters: N numbers, of which x and d move between samples
//   x' = f(t, x, u, d, theta) + w,   d' = -d / tau + w,   theta' = w;   y = h(t, x, u, d, theta) + v
#pragma once

#include "base/arena.hpp"
#include "observer/plant.hpp"
#include "signals/sensor_check.hpp"

#include <cstdint>

namespace hnav::observer {

constexpr int max_estimated = 64;
constexpr int max_channels_used = 62; // known inputs and sensors together; see Model::channels
constexpr int max_size = 1000;        // of anything

// As the caller gives it; null where a default stands for it. Widths: N, unknown inputs, known inputs, outputs.
struct Statistics {
    const double* start;           // N; null: zero
    const double* start_sigma;     // N
    const double* noise;           // N, density: unit / sqrt(s); null: none
    const double* nominal;         // N; null: one
    const double* ready_sigma;     // N, above 0; null: no limit
    const double* time_constant_s; // unknown inputs; 0 and null: random walk
    const double* input_start;     // known inputs; null: zero
    const double* sensor_sigma;    // outputs
    const double* gate_nis;        // outputs; 0 and null: no gate
    const double *min, *max;       // N; null: no bounds
    const std::uint8_t* logarithmic; // parameters; 1: by its logarithm; null: none
};

// What is wrong with a plant or with what is said of it.
struct Refusal {
    enum Kind { null, size, non_finite, impossible, plant } kind = impossible;
    char text[320] = "";

    __attribute__((format(printf, 3, 4))) bool refuse(Kind why, const char* format, ...);
};

class Problem {
public:
    // Counts on an arena without memory.
    Problem(Arena& arena, const PlantSizes& sizes);

    static bool sizes_fit(const PlantSizes& sizes, Refusal& why);
    bool assign(const Statistics& given, Refusal& why);
    std::uint64_t fingerprint(std::uint64_t start) const;

    const PlantSizes sizes;
    const int n, moving, N, known, sensors; // states; with unknown inputs; with parameters; known inputs; outputs

    double *start, *start_variance, *noise, *scale, *ready_sigma, *decay_1_s, *input_start; // noise: squared density
    double *sensor_variance, *gate_nis;
    double* noise_scale; // of the tolerances of the noise, unit / sqrt(s)
    // Between which X is, a billionth of its scale within what was given: roots have a derivative there. Of parameters: 1 where X is the
    // logarithm; then all that stands here is of that, but for ready_sigma.
    double *low, *high, *is_log;
    bool bounded = false; // any bound, any logarithm

private:
    bool check(const Statistics& given, Refusal& why) const;
    bool check_bounds(const Statistics& given, Refusal& why) const;
    void set_scales(const Statistics& given);
    void set_logarithm(int parameter);
    void set_bounds(const Statistics& given);
};

constexpr int max_parts = 4;
using Check = SensorCheck<double, 1>;

// Where the numbers of a state stand: up to four parts, each with all that it knows of the plant, then what they share. Of a
// plant without events there is one.
struct Layout {
    explicit Layout(const Problem& p)
        : S(p.moving),
          Qd(S + p.moving * p.N),
          clock(Qd + triangle(p.N)),
          nx(clock + 1),
          parameters(nx),
          P(parameters + p.sizes.parameters),
          beyond(P + triangle(p.N)),
          weight(beyond + p.N),
          elapsed(weight + 1),
          jumps(weight + 2),
          next_event(weight + 3),
          sides(weight + 4),
          memory(sides + p.sizes.indicators),
          part_numbers(memory + p.sizes.memory),
          parts(p.sizes.events ? max_parts : 1),
          inputs(parts * part_numbers),
          information(inputs + p.known),
          t(information + p.N),
          usual(t + 1),
          begun(t + 2),
          broken(t + 3),
          ready(t + 4),
          doubts(t + 5),
          events(t + 6),
          corrections(t + 7),
          likelihood(t + 8),
          parts_used(t + 9),
          stiff(t + 10),
          corrected(t + 11),
          wants_event(t + 12),
          held(t + 13),
          holds(t + 14),
          from(t + 15),
          course(from + p.moving),
          counts(course + p.moving),
          sensors(counts + all_counts),
          checks(sensors + per_sensor * p.sensors),
          numbers(checks + check_numbers * p.sensors) {}

    static constexpr int triangle(int n) { return n * (n + 1) / 2; }
    enum OfSensor { innovation, innovation_sigma, nis, mean_nis, samples, gated, repeats, usual_repeats, per_sensor };
    int of_sensor(int i, OfSensor what) const { return sensors + per_sensor * i + what; }
    static constexpr int check_numbers = sizeof(Check) / sizeof(double);
    enum Counts { splits, grazing, chattering, projected, holding, all_counts };

    // Of a part, from where it begins. x and d come first. S: rows of Phi that move; Qd: upper triangle, in units of `usual`
    // seconds; clock: the time since S and Qd began, elapsed: of these since the event of the filter.
    int S, Qd, clock, nx;
    int parameters, P;
    // Of a plant with bounds: what the mean of the Gaussian that is not cut has beyond x, d and the parameters, which are that of what
    // is left of it. P is not cut: a bound that cuts at every sample what it has cut before would count for more than it says.
    int beyond;
    // How likely it is; events of the plant that changed something; time of the next that time brings; 1 where an indicator is
    // above 0; what the plant remembers.
    int weight, elapsed, jumps, next_event, sides, memory, part_numbers;

    int parts;
    int inputs, information;
    // Of the newest event; about as long as intervals are; flags and counts; logarithm, of the newest correction; whether the plant
    // was stiff in the newest interval; time of the newest correction; whether the plant wants an event at the end of the newest step of
    // an integrator outside; how long the estimate has been held since the plant had an answer for a whole interval, and whether it is
    // in this one; the moving numbers after the newest event, and the fastest that they went lately.
    int t, usual, begun, broken, ready, doubts, events, corrections, likelihood, parts_used, stiff, corrected, wants_event, held,
        holds, from, course, counts, sensors, checks;
    int numbers;
};

} // namespace hnav::observer
