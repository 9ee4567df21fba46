#include "observer/problem.hpp"

#include "base/hash.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace hnav::observer {
namespace {

double at(const double* values, int i, double otherwise) { return values ? values[i] : otherwise; }

// Numbers of the caller, null where a default applies. Their squares must be finite.
struct Row {
    const char* name;
    const double* values;
    int count;
    enum Range { any, bound, not_negative, positive, limit } range; // bound, limit: infinite for none, limit above 0

    bool check(Refusal& why) const {
        for (int i = 0; values && i < count; ++i) {
            if ((range == limit && values[i] == HUGE_VAL) || (range == bound && !std::isnan(values[i]))) continue;
            if (!std::isfinite(values[i]))
                return why.refuse(Refusal::non_finite, "%s[%d] = %g is not finite", name, i, values[i]);
            const double square = values[i] * values[i];
            const char* must = range >= positive && !(values[i] > 0 && square > 0) ? "above 0"
                               : range == not_negative && values[i] < 0            ? "at least 0"
                               : !std::isfinite(square)                            ? "below 1e154"
                                                                                   : nullptr;
            if (must) return why.refuse(Refusal::impossible, "%s[%d] = %g: it must be %s", name, i, values[i], must);
        }
        return true;
    }
};

} // namespace

Problem::Problem(Arena& arena, const PlantSizes& given)
    : sizes(given),
      n(given.states),
      moving(given.states + given.unknown_inputs),
      N(given.estimated()),
      known(given.known_inputs()),
      sensors(given.outputs) {
    for (double** row : {&start, &start_variance, &noise, &scale, &ready_sigma, &noise_scale, &low, &high})
        *row = arena.doubles(N);
    decay_1_s = arena.doubles(given.unknown_inputs);
    input_start = arena.doubles(known);
    for (double** row : {&sensor_variance, &gate_nis}) *row = arena.doubles(sensors);
    is_log = arena.doubles(given.parameters);
}

bool Problem::numbers_fit(const PlantSizes& s, Refusal& why) {
    const double all = double(s.states) + s.unknown_inputs + s.parameters;
    if (all > max_estimated)
        return why.refuse(
            Refusal::size,
            "%.0f states, unknown inputs and parameters take more than 1 GiB, the most of an observer: estimate fewer "
            "parameters and unknown inputs, or export a coarser model",
            all);
    const double channels = double(s.inputs) - s.unknown_inputs + s.outputs;
    if (channels > max_channels_used)
        return why.refuse(Refusal::size, "inputs and sensors are %.0f, the most is %d", channels, max_channels_used);
    return true;
}

bool Problem::sizes_fit(const PlantSizes& s, Refusal& why) {
    for (const int count : {s.states, s.inputs, s.unknown_inputs, s.parameters, s.outputs})
        if (count < 0) return why.refuse(Refusal::size, "a size of the plant is %d, below 0", count);
    if (s.indicators < 0 || s.indicators > max_indicators)
        return why.refuse(Refusal::size, "the plant has %d indicators, not 0 to %d", s.indicators, max_indicators);
    if (s.states == 0) return why.refuse(Refusal::impossible, "the plant has no continuous states: there is nothing to estimate");
    if (s.outputs == 0) return why.refuse(Refusal::impossible, "no sensor is named: without one nothing can be estimated");
    if (s.unknown_inputs > s.inputs)
        return why.refuse(Refusal::size, "%d inputs are unknown, but there are %d", s.unknown_inputs, s.inputs);
    return numbers_fit(s, why);
}

bool Problem::check(const Statistics& g, Refusal& why) const {
    if (!g.start_sigma) return why.refuse(Refusal::null, "start_sigma is null");
    if (!g.sensor_sigma) return why.refuse(Refusal::null, "sensor_sigma is null");
    const Row rows[] = {
        {"start", g.start, N, Row::any},
        {"start_sigma", g.start_sigma, N, Row::not_negative},
        {"noise", g.noise, N, Row::not_negative},
        {"nominal", g.nominal, N, Row::not_negative},
        {"ready_sigma", g.ready_sigma, N, Row::limit},
        {"time_constant_s", g.time_constant_s, sizes.unknown_inputs, Row::not_negative},
        {"input_start", g.input_start, known, Row::any},
        {"sensor_sigma", g.sensor_sigma, sensors, Row::positive},
        {"gate_nis", g.gate_nis, sensors, Row::not_negative},
        {"min", g.min, N, Row::bound},
        {"max", g.max, N, Row::bound},
    };
    for (const Row& row : rows)
        if (!row.check(why)) return false;
    if (!check_bounds(g, why)) return false;
    for (int i = 0; i < N; ++i)
        if (g.start_sigma[i] > 0 || at(g.noise, i, 0) > 0) return true;
    return why.refuse(Refusal::impossible, "every start_sigma is 0 and there is no noise: give a state a start_sigma or noise");
}

bool Problem::check_bounds(const Statistics& g, Refusal& why) const {
    for (int i = 0; i < N; ++i)
        if (!(at(g.min, i, -HUGE_VAL) < at(g.max, i, HUGE_VAL)))
            return why.refuse(Refusal::impossible, "min[%d] = %g is not below max[%d] = %g", i, g.min[i], i, g.max[i]);
    for (int k = 0; g.logarithmic && k < sizes.parameters; ++k) {
        const int i = moving + k;
        if (!g.logarithmic[k]) continue;
        const double mean = at(g.start, i, 0), spread = std::max(g.start_sigma[i], at(g.noise, i, 0)) / mean;
        if (!(mean > 0 && at(g.max, i, HUGE_VAL) > 0))
            return why.refuse(Refusal::impossible, "start[%d] = %g and its max must be above 0: it is estimated by its logarithm",
                              i, mean);
        if (!std::isfinite(spread * spread))
            return why.refuse(Refusal::impossible, "start[%d] = %g is too far below its start_sigma and noise: raise it", i,
                              mean);
    }
    return true;
}

bool Problem::assign(const Statistics& g, Refusal& why) {
    if (!check(g, why)) return false;
    for (int i = 0; i < N; ++i) {
        start[i] = at(g.start, i, 0);
        start_variance[i] = g.start_sigma[i] * g.start_sigma[i];
        noise[i] = at(g.noise, i, 0) * at(g.noise, i, 0);
        ready_sigma[i] = at(g.ready_sigma, i, HUGE_VAL);
    }
    for (int i = 0; i < sizes.unknown_inputs; ++i) {
        const double tau = at(g.time_constant_s, i, 0);
        decay_1_s[i] = tau > 0 ? 1 / tau : 0;
    }
    for (int i = 0; i < known; ++i) input_start[i] = at(g.input_start, i, 0);
    for (int i = 0; i < sensors; ++i) {
        sensor_variance[i] = g.sensor_sigma[i] * g.sensor_sigma[i];
        gate_nis[i] = at(g.gate_nis, i, 0);
    }
    for (int k = 0; k < sizes.parameters; ++k) is_log[k] = g.logarithmic && g.logarithmic[k];
    set_scales(g);
    set_bounds(g);
    return true;
}

// Moments of the logarithm such that the parameter has the given mean and variance.
void Problem::set_logarithm(int k) {
    const int i = moving + k;
    const double mean = start[i];
    start_variance[i] = std::log1p(start_variance[i] / (mean * mean));
    start[i] = std::log(mean) - 0.5 * start_variance[i];
    noise[i] /= mean * mean;
    scale[i] = 1;
}

void Problem::set_bounds(const Statistics& g) {
    constexpr double margin = 1e-9; // of a scale
    bounded = false;
    for (int i = 0; i < N; ++i) {
        double min = at(g.min, i, -HUGE_VAL), max = at(g.max, i, HUGE_VAL);
        const bool logarithm = i >= moving && is_log[i - moving] != 0;
        if (logarithm) {
            min = min > 0 ? std::log(min) : -HUGE_VAL;
            max = std::log(max);
        }
        bounded = bounded || logarithm || std::isfinite(min) || std::isfinite(max);
        const double within = std::min(margin * scale[i], 0.25 * (max - min));
        low[i] = min + within;
        high[i] = max - within;
    }
}

// A nominal value of 1 for a pressure of 1e5 Pa is common, so it is never used alone. Numbers without process noise receive a
// noise scale from the others: a hundredth of the largest; more accuracy has no use.
void Problem::set_scales(const Statistics& g) {
    double largest = 0;
    for (int i = 0; i < N; ++i) {
        const double nominal = at(g.nominal, i, i < n ? 1 : 0);
        scale[i] = std::max({nominal, std::fabs(start[i]), g.start_sigma[i]});
        if (!(scale[i] > 0)) scale[i] = 1;
        if (i >= moving && is_log[i - moving] != 0) set_logarithm(i - moving);
        largest = std::max(largest, std::sqrt(noise[i]) / scale[i]);
    }
    for (int i = 0; i < N; ++i) noise_scale[i] = largest > 0 ? std::sqrt(noise[i]) + 1e-2 * largest * scale[i] : scale[i];
}

std::uint64_t Problem::fingerprint(std::uint64_t from) const {
    const int counts[] = {sizes.states,  sizes.inputs,     sizes.unknown_inputs, sizes.parameters,
                          sizes.outputs, sizes.indicators, sizes.memory,         sizes.events};
    std::uint64_t sum = hash(counts, sizeof counts, from);
    for (const double* values : {start, start_variance, noise, scale, ready_sigma, low, high})
        sum = hash(values, N * sizeof(double), sum);
    sum = hash(is_log, sizes.parameters * sizeof(double), sum);
    sum = hash(decay_1_s, sizes.unknown_inputs * sizeof(double), sum);
    sum = hash(input_start, known * sizeof(double), sum);
    sum = hash(sensor_variance, sensors * sizeof(double), sum);
    return hash(gate_nis, sensors * sizeof(double), sum);
}

} // namespace hnav::observer
