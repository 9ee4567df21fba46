// When a sensor samples: index k is due at start + k period, moved by its jitter, and is taken at the first communication
// point at or after that.
#pragma once

#include "simulation/random.hpp"

namespace hnav {

struct SampleClock {
    double start_s = 0, period_s = 0.01, jitter_s = 0; // jitter below half a period keeps the order
    RandomStream random{0, 0};

    double due_s(double k) const {
        const double moved = jitter_s > 0 ? jitter_s * (2 * random.uniform(static_cast<std::uint64_t>(k)) - 1) : 0;
        return start_s + k * period_s + moved;
    }

    // The newest index that is due at t, or one below next when there is none.
    double newest_due(double t_s, double next) const {
        const double tolerance = 1e-9 * std::fmax(1, std::fabs(t_s)); // of importers that add up steps
        double k = std::fmax(next - 1, std::floor((t_s - start_s) / period_s + 1));
        while (k >= next && due_s(k) > t_s + tolerance) --k;
        return k;
    }
};

} // namespace hnav
