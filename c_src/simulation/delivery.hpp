// Samples that have been taken and are delivered after their latency.
#pragma once

#include "base/instant.hpp"

#include <cstring>
#include <limits>

namespace hnav {

constexpr int max_in_flight = 64; // latency is at most 30 periods, and jitter may bring two samples close together
constexpr double max_latency_periods = 30;

// Chosen: above every quantity of a body in SI units, and the readings stay finite.
constexpr double largest_truth = 1e12;

// values: of a sample.
template <int values>
class Delivery {
public:
    struct Sample {
        double t_meas_s, arrives_s;
        double value[values];
    };

    // Plain numbers, oldest sample first.
    struct State {
        double waiting;
        Sample queue[max_in_flight];
        Sample newest; // delivered
        double count;
    };

    // stamp_s: the time stamp of the sample.
    static void send(State* s, const double* value, double t_s, double stamp_s, double latency_s) {
        Sample& sample = s->queue[static_cast<int>(s->waiting++)];
        sample = {stamp_s, t_s + latency_s, {}};
        std::memcpy(sample.value, value, sizeof sample.value);
    }

    static void advance(State* s, double t_s) {
        const double tolerance = instant_s(t_s, 1e-3);
        const int waiting = static_cast<int>(s->waiting);
        int arrived = 0;
        while (arrived < waiting && s->queue[arrived].arrives_s <= t_s + tolerance) ++arrived;
        if (arrived == 0) return;
        s->newest = s->queue[arrived - 1];
        s->count += arrived;
        for (int i = arrived; i < waiting; ++i) s->queue[i - arrived] = s->queue[i];
        for (int i = waiting - arrived; i < waiting; ++i) s->queue[i] = {}; // equal states, equal bytes
        s->waiting -= arrived;
    }

    static double next_s(const State& s) {
        return s.waiting > 0 ? s.queue[0].arrives_s : std::numeric_limits<double>::infinity();
    }
};

} // namespace hnav
