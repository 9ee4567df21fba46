// Faults of a sensor, each within a time window that includes its start and excludes its end.
#pragma once

#include "base/instant.hpp"
#include "maths/rotation.hpp"
#include "simulation/random.hpp"

namespace hnav {

struct Window {
    double start_s = 0, stop_s = 0;

    // Stamps just before a bound because of rounding count as on it.
    bool holds(double t_s) const {
        const double late = t_s + instant_s(t_s, 0.01);
        return late >= start_s && late < stop_s;
    }
};

struct SensorFaults {
    Window disturbance, outliers, stuck, jump, noise;
    Vector3 disturbance_n = Vector3::Zero(); // added to the external field
    double outlier_probability = 0, outlier_sigma = 0;
    RandomStream outlier_chance{0, 0}, outlier_size{0, 0};
    int stuck_axis = -1; // 0, 1, 2; -1: none
    Vector3 jump_size = Vector3::Zero();
    double noise_factor = 1;

    Vector3 outside(double t_s, const Quaternion& q) const {
        if (!disturbance.holds(t_s)) return Vector3::Zero();
        return rotation_matrix(q).transpose() * disturbance_n;
    }

    double white_factor(double t_s) const { return noise.holds(t_s) ? noise_factor : 1; }

    Vector3 additional(double t_s, double k) const {
        Vector3 sum = Vector3::Zero();
        if (jump.holds(t_s)) sum += jump_size;
        const auto index = static_cast<std::uint64_t>(k);
        if (outliers.holds(t_s) && outlier_chance.uniform(index) < outlier_probability)
            for (int i = 0; i < 3; ++i) sum[i] += outlier_sigma * outlier_size.normal(4 * index + static_cast<unsigned>(i));
        return sum;
    }

    bool sticks(double t_s) const { return stuck_axis >= 0 && stuck.holds(t_s); }
};

} // namespace hnav
