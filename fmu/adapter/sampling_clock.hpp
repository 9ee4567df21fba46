// The sampling clock of all FMUs: when held inputs are a new sample.
#pragma once

#include "adapter/variable.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hnav::fmu {

// Importers add up steps, so two times within this tolerance are equal. scale_s: a period or step; the tolerance stays a
// small part of it, also for a clock that counts from 1970.
inline double time_tolerance(double t_s, double scale_s) {
    const double size = std::fabs(t_s), rounding = 4 * std::numeric_limits<double>::epsilon() * size;
    return std::max(rounding, std::min(1e-9 * std::max(1.0, size), 1e-3 * scale_s));
}

// Shorter periods are refused: an importer would stop at each of them and make no progress.
constexpr double min_period_s = 1e-6;
// Largest number of samples within one communication step. Chosen: at up to 10 us each, a call takes less than a second.
constexpr double max_samples_inside = 5e4;

// True once at the rising edge of a command.
inline bool rising(double level, double* last) {
    const bool edge = level != 0 && *last == 0;
    *last = level;
    return edge;
}

enum SamplingMode { periodic = 0, counter = 1, held = 2, automatic = 3 };
constexpr Choice sampling_modes[] = {
    {"periodic", "Inputs are a sample at the first communication point at or after each period, stamped with its time"},
    {"counter", "Inputs are a sample when their counter has changed, stamped with their t_meas"},
    {"held",
     "As periodic, and within a longer communication step the held inputs are a sample again at each period, as if they "
     "were constant and without noise"},
    {"auto",
     "As periodic, where a longer communication step has one sample of each sensor and loses none; from the first change of a "
     "sensor's counter on as counter"},
};

struct NewSample {
    double t_s;  // when it was measured
    double lost; // samples before it that fell between communication points
};

// The clock of one sensor. Eight-byte numbers, saved bytewise.
struct SamplingClock {
    double start_s;
    double period_s; // of periodic sampling; 0: never
    double mode;     // SamplingMode
    double seen;     // counter of the newest sample
    double due;      // periods from the start until the next sample
    double by_period = 0; // 1: samples were taken at the period, while the mode is automatic

    // Whether there is a new sample at t_s. now, t_meas_s: the inputs that mark a sample in counter mode.
    bool take(double t_s, double now, double t_meas_s, NewSample* sample) {
        sample->t_s = t_meas_s;
        if (counts(now)) mode = counter;
        if (mode == counter) return counter_changed(now, &sample->lost);
        if (!period_elapsed(t_s, &sample->lost)) return false;
        // A held value belongs to one period, whatever the rounding of the communication point.
        sample->t_s = mode == held ? start_s + (due - 1) * period_s : t_s;
        return true;
    }

    bool counts(double now) const { return mode == counter || (mode == automatic && now != seen); }

    // The counter changed for the first time after samples were taken at the period: those were no new samples.
    bool begins_to_count(double now) const { return by_period != 0 && mode == automatic && counts(now); }

    // The first communication point at or after k periods takes sample k; late points lose samples.
    bool period_elapsed(double t_s, double* lost) {
        if (!(period_s > 0)) return false;
        const double k = std::floor((t_s - start_s + time_tolerance(t_s, period_s)) / period_s);
        if (k < due) return false;
        *lost = k - due;
        due = k + 1;
        return true;
    }

    // Time of the next sample; infinity in counter mode.
    double next_s() const {
        return mode != counter && period_s > 0 ? start_s + due * period_s : std::numeric_limits<double>::infinity();
    }

    // Time of the next sample inside a step to end_s; infinity if there is none.
    double next_inside_s(double end_s) const {
        const bool inside = mode == held && next_s() < end_s - time_tolerance(end_s, period_s);
        return inside ? next_s() : std::numeric_limits<double>::infinity();
    }

private:
    // A counter that increased by more than one has counted samples between two communication points.
    bool counter_changed(double now, double* lost) {
        if (now == seen) return false;
        *lost = std::max(0.0, now - seen - 1); // a sensor that restarts has lost nothing
        seen = now;
        return true;
    }
};

} // namespace hnav::fmu
