// One of the three sensors: truth at a communication point becomes a sample, then a reading delivered later.
//
// Order, as in the device: external disturbance, geometry and bias, noise, additive faults, converter, stuck axis.
// Random numbers belong to the index of the sample, so communication steps change only the sampled
// truth.
#pragma once

#include "simulation/delivery.hpp"
#include "simulation/linear_error.hpp"
#include "simulation/noise.hpp"
#include "simulation/quantiser.hpp"
#include "simulation/sample_clock.hpp"
#include "simulation/sensor_faults.hpp"

namespace hnav {

struct SensorModel {
    SampleClock clock;
    double latency_s = 0, dropout = 0;
    RandomStream dropout_chance{0, 0};
    LinearError error;
    double g_sensitivity = 0; // of each axis to the force along it
    Noise noise;
    Quantiser quantiser;
    SensorFaults faults;

    // Plain numbers; all of the history.
    struct State {
        double next; // index of the next sample
        double missed, dropped;
        Noise::State noise;
        double last[3]; // reading, for a stuck axis
        Delivery<3>::State delivery;
    };

    // True when a sample was due. input: of this sensor, in body axes.
    bool sample(double t_s, const Vector3& input, const Vector3& force, const Quaternion& q, State* s) const {
        const double k = clock.newest_due(t_s, s->next);
        if (k < s->next) return false;
        const bool first = s->next == 0;
        if (!first) s->missed += k - s->next; // before the first sample there was no truth: no sample was missed
        // Missed samples advance the noise: the bias continues as if they had been taken.
        for (double i = s->next; i <= k; ++i) noise.step(i, &s->noise);
        s->next = k + 1;

        Vector3 y = error(input + faults.outside(t_s, q), t_s - clock.start_s) + g_sensitivity * force;
        y += noise.at(k, s->noise, faults.white_factor(t_s));
        y += faults.additional(t_s, k);
        for (int i = 0; i < 3; ++i) y[i] = quantiser(y[i]);
        if (faults.sticks(t_s) && !first) y[faults.stuck_axis] = s->last[faults.stuck_axis];
        for (int i = 0; i < 3; ++i) s->last[i] = y[i];

        if (dropout > 0 && dropout_chance.uniform(static_cast<std::uint64_t>(k)) < dropout) s->dropped += 1;
        else Delivery<3>::send(&s->delivery, s->last, t_s, t_s, latency_s);
        return true;
    }
};

} // namespace hnav
