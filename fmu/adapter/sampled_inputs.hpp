// Several sampled inputs, each with its own clock: which are new at a communication point, and which samples were lost.
#pragma once

#include "adapter/held_source.hpp"
#include "adapter/model.hpp"
#include "adapter/sampling_clock.hpp"
#include "adapter/sensor_rows.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>

namespace hnav::fmu {

// False, with the reason, for a period that is too short; 0 disables it.
inline bool check_period(const char* name, double period_s, Message* why) {
    if (!(period_s > 0) || period_s >= min_period_s) return true;
    std::snprintf(why->text, sizeof why->text, "%s = %g s is below %g s; 0 means never", name, period_s, min_period_s);
    return false;
}

// False, with the reason, if a step contains more samples than the limit. name: of the period.
inline bool check_span(double from_s, double to_s, const char* name, double period_s, Message* why) {
    if (!(to_s - from_s > max_samples_inside * period_s)) return true;
    std::snprintf(why->text, sizeof why->text, "a step to %g s holds more than %.0f samples at %s = %g s: take a shorter one",
                  to_s, max_samples_inside, name, period_s);
    return false;
}

// The sampling mode in the row of its parameter; without one, the clocks of FMI 3 count their ticks.
inline double mode_in(const double* values, int row) { return row < 0 ? double(counter) : values[row]; }

// At most `most` inputs, counted from 0. Eight-byte numbers, saved bytewise.
template <int most>
struct SampledInputs {
    SamplingClock clock[most];
    double missed; // samples that were lost
    double first_missed; // the input that first lost one, counted from 1; 0 while none has
    double first_sparse; // likewise, the first with a step longer than its period, in automatic mode
    double first_mistaken; // likewise, the one whose counter first changed after samples at its period
    double first_unstamped; // likewise, the first whose counter changed while its t_meas did not, or was none of the simulation
    double first_repeated; // likewise, the first whose source is slower than its period
    double last_t_meas_s[most], has_t_meas[most];
    HeldSource source[most];

    // Whether input i has a new sample at t_s. now, t_meas_s: see SamplingClock.
    bool take(int i, double t_s, bool valid, double now, double t_meas_s, NewSample* sample) {
        if (!clock[i].take(t_s, now, t_meas_s, sample)) return false;
        // A sensor that is declared invalid loses no periodic samples, only those that its counter counts.
        if (valid || clock[i].mode == counter) {
            const bool sparse = clock[i].mode == automatic;
            double& first = sparse ? first_sparse : first_missed;
            if (sample->lost > 0 && first == 0) first = i + 1;
            if (!sparse) missed += sample->lost;
        }
        if (valid && clock[i].mode == counter) check_stamp(i, t_s, t_meas_s);
        if (valid) clock[i].by_period = 1;
        return valid;
    }

    // Whether the values of input i, taken at its period, are not those of the sample before, which the importer holds.
    bool is_new(int i, const double* value, int count, const double* also = nullptr, int also_count = 0) {
        if (clock[i].mode == counter || clock[i].mode == held || source[i].is_new(value, count, also, also_count)) return true;
        if (first_repeated == 0) first_repeated = i + 1;
        return false;
    }

    // A sample that is counted has a time of its own, in seconds of the simulation.
    void check_stamp(int i, double t_s, double t_meas_s) {
        constexpr double far_s = 1000; // chosen: later than any sample, and reached within a second by times in ms
        const bool repeats = has_t_meas[i] != 0 && t_meas_s == last_t_meas_s[i];
        if (first_unstamped == 0 && (repeats || std::fabs(t_meas_s - t_s) > far_s)) first_unstamped = i + 1;
        last_t_meas_s[i] = t_meas_s;
        has_t_meas[i] = 1;
    }

    // Called before samples are taken: the counter of input i has changed, so its samples at the period were no new ones.
    bool begins_to_count(int i, double now) {
        if (!clock[i].begins_to_count(now)) return false;
        if (first_mistaken == 0) first_mistaken = i + 1;
        for (SamplingClock& each : clock) each.by_period = 0;
        return true;
    }
    template <int sensors>
    bool begins_to_count(const SensorRows (&rows)[sensors], const double* values) {
        bool any = false;
        for (int s = 0; s < sensors; ++s) any |= begins_to_count(s, values[rows[s].sample]);
        return any;
    }

    // Sets the clocks of the sensors from their parameters; mode: the row of sampling_mode. False, with the reason, if a period is too short.
    template <int sensors>
    bool start(const SensorRows (&rows)[sensors], const double* values, double start_s, int mode, const char* const* periods,
               Message* why) {
        for (int s = 0; s < sensors; ++s) {
            const double period_s = rows[s].period < 0 ? 0 : values[rows[s].period];
            if (!check_period(periods[s], period_s, why)) return false;
            clock[s] = {start_s, period_s, mode_in(values, mode), 0, 0};
        }
        return true;
    }

    // Calls push(s, t_s, value) for each sensor that has a new sample; true if one has.
    template <int sensors, class Push>
    bool push_new(const SensorRows (&rows)[sensors], const double* values, double t_s, Push push) {
        bool taken = false;
        for (int s = 0; s < sensors; ++s) {
            const SensorRows& at = rows[s];
            NewSample sample;
            if (!take(s, t_s, at.valid < 0 || values[at.valid] != 0, values[at.sample], values[at.t_meas], &sample)) continue;
            if (!is_new(s, values + at.value, at.count(), at.also < 0 ? nullptr : values + at.also, 3)) continue;
            push(s, sample.t_s, values + at.value);
            taken = true;
        }
        return taken;
    }

    // The earliest next sample of all clocks; a clock that was not set is never due.
    double next_s() const {
        double next_s = std::numeric_limits<double>::infinity();
        for (const SamplingClock& each : clock) next_s = std::min(next_s, each.next_s());
        return next_s;
    }

    double next_inside_s(double end_s) const {
        double next_s = std::numeric_limits<double>::infinity();
        for (const SamplingClock& each : clock) next_s = std::min(next_s, each.next_inside_s(end_s));
        return next_s;
    }

    // The message about the first mistaken sample; null if there was none. name: as for lost.
    template <class Name>
    const char* mistaken(Name&& name) const {
        return first_mistaken > 0 ? name(static_cast<int>(first_mistaken) - 1, true) : nullptr;
    }

    // The first input whose source is slower than its period, with the period of the source. name: as for lost.
    template <class Name>
    Lost repeated(Name&& name) const {
        if (first_repeated == 0) return {};
        const int i = static_cast<int>(first_repeated) - 1;
        return {name(i, false), clock[i].period_s * source[i].repeats()};
    }

    // The message about the first sample without a time, or else the first lost one, or else the first long step. name(i,
    // by_counter): of the counter of input i, or of its period.
    template <class Name>
    Lost lost(Name&& name) const {
        if (first_unstamped > 0) return {name(static_cast<int>(first_unstamped) - 1, true), 0, false, true};
        const double first = first_missed > 0 ? first_missed : first_sparse;
        if (first == 0) return {};
        const int i = static_cast<int>(first) - 1;
        const bool counted = clock[i].mode == counter;
        return {name(i, counted), counted ? 0 : clock[i].period_s, first_missed == 0};
    }
};

} // namespace hnav::fmu
