// When held inputs are a new sample.
#pragma once

#include <cmath>

namespace hnav::fmu {

enum SamplingMode { periodic = 0, counter = 1 };
constexpr const char* sampling_modes[] = {"periodic", "counter"};

// True once when a command goes up.
inline bool rising(double level, double* last) {
    const bool edge = level != 0 && *last == 0;
    *last = level;
    return edge;
}

// The clock of one sensor. Eight-byte numbers, saved as they are.
struct SampleClock {
    double start_s;
    double seen; // counter of the newest sample
    double due;  // periods from the start until the next sample

    // A counter that went up by more than one says that samples came and went between two communication points.
    bool counter_changed(double now, double* lost) {
        if (now == seen) return false;
        *lost = std::fmax(0, now - seen - 1); // a sensor that starts anew has lost nothing
        seen = now;
        return true;
    }

    // The first communication point at or after k periods takes sample k; points that come too late lose samples.
    bool period_elapsed(double t_s, double period_s, double* lost) {
        const double tolerance = 1e-9 * std::fmax(1, std::fabs(t_s));
        const double k = std::floor((t_s - start_s + tolerance) / period_s);
        if (k < due) return false;
        *lost = k - due;
        due = k + 1;
        return true;
    }

    double next_s(double period_s) const { return start_s + due * period_s; }
};

} // namespace hnav::fmu
