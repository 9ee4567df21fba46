// Sampling times of a sensor: index k is due at start + k period plus jitter, and is taken at the first communication
// point at or after that.
#pragma once

#include "base/instant.hpp"
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
        const double latest_s = t_s + instant_s(t_s, period_s);
        double k = std::fmax(next - 1, std::floor((t_s - start_s) / period_s + 1));
        // Jitter and rounding shift an index by two at most.
        for (int i = 0; i < 3 && k >= next && due_s(k) > latest_s; ++i) k -= 1;
        return k;
    }
};

} // namespace hnav
