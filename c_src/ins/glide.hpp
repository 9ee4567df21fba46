// Detects a body that moves at constant velocity while its IMU shows rest.
#pragma once

#include <cmath>

namespace hnav::ins {

// An IMU cannot distinguish constant velocity from rest. The mean of many GNSS velocities can, even if each of them is smaller than
// its sigma.
struct Glide {
    static constexpr double alike_s = 1, recent_s = 2; // errors within alike_s are fully correlated

    struct Mean {
        static constexpr double limit = 20, least_m_s = 0.02; // chi-square of two

        double sum[2], weight;

        void note(const double* velocity, double share, double kept) {
            for (int i = 0; i < 2; ++i) sum[i] = kept * sum[i] + share * velocity[i];
            weight = kept * weight + share;
        }
        double speed_m_s() const { return weight > 0 ? std::hypot(sum[0], sum[1]) / weight : 0; }
        bool shows() const { return speed_m_s() > least_m_s && speed_m_s() * speed_m_s() * weight > limit; }
    };

    Mean always, recent; // since the start of the rest, and over the last seconds
    double began_s, last_s;
    double jumped, rested, found; // flags since the start of the rest; rested: a zero-velocity correction was made

    void begin(double t_s) {
        *this = {};
        began_s = last_s = t_s;
    }
    void note(double t_s, const double* velocity, double sigma_m_s) {
        const double since_s = t_s - last_s, share = std::fmin(1, since_s / alike_s) / (sigma_m_s * sigma_m_s);
        always.note(velocity, share, 1);
        recent.note(velocity, share, std::exp(-since_s / recent_s));
        last_s = t_s;
    }
};

} // namespace hnav::ins
