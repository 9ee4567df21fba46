// Whether the body stands, by its rate and force: their root mean squares about running means stay small for a while. What
// moves smoothly looks the same, so the filter asks for a small speed too, and looks for a glide.
#pragma once

#include "maths/rotation.hpp"

#include <cmath>

namespace hnav::ins {

struct RestSettings {
    double rate_rad_s, force_m_s2, duration_s; // 0 for rate_rad_s: rest is never found
};

struct RestDetector {
    static constexpr double filter_s = 0.5, swaying = 4;

    double mean_rate[3], mean_force[3], rate2, force2, still_s, swaying_s, begun;

    void note(const RestSettings& settings, const Vector3& rate, const Vector3& force, double interval_s) {
        Eigen::Map<Vector3> mean_w(mean_rate), mean_f(mean_force);
        if (begun == 0) {
            mean_w = rate;
            mean_f = force;
            begun = 1;
        }
        const double share = interval_s / (filter_s + interval_s);
        mean_w += share * (rate - mean_w);
        mean_f += share * (force - mean_f);
        rate2 += share * ((rate - mean_w).squaredNorm() - rate2);
        force2 += share * ((force - mean_f).squaredNorm() - force2);
        const double r = settings.rate_rad_s, f = settings.force_m_s2;
        const auto within = [&](double limits) { return rate2 <= limits * limits * r * r && force2 <= limits * limits * f * f; };
        still_s = within(1) ? still_s + interval_s : 0;
        swaying_s = within(swaying) ? swaying_s + interval_s : 0;
    }

    bool still(const RestSettings& s) const { return s.rate_rad_s > 0 && still_s > s.duration_s; }
    // The same with wider limits: on something that sways.
    bool sways(const RestSettings& s) const { return s.rate_rad_s > 0 && swaying_s > s.duration_s; }
};

// What glides evenly looks as still as what stands, but the satellites' velocities have a mean, which many of them tell even where
// each is smaller than its sigma.
struct Glide {
    static constexpr double alike_s = 1, lately_s = 2; // errors within alike_s are the same

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

    Mean always, lately; // since it began, and of the last seconds
    double began_s, last_s;
    double off[2]; // of the satellites' position when it began, m
    double jumped, rested, found; // 1: so it was since it began; rested: what stands has corrected

    void begin(double t_s, const double* off_m) {
        *this = {};
        began_s = last_s = t_s;
        for (int i = 0; i < 2; ++i) off[i] = off_m[i];
    }
    void note(double t_s, const double* velocity, double sigma_m_s) {
        const double since_s = t_s - last_s, share = std::fmin(1, since_s / alike_s) / (sigma_m_s * sigma_m_s);
        always.note(velocity, share, 1);
        lately.note(velocity, share, std::exp(-since_s / lately_s));
        last_s = t_s;
    }
};

} // namespace hnav::ins
