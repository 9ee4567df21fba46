// Whether the body stands, by its rate and force: their root mean squares about running means stay small for a while. What
// moves smoothly looks the same, so the filter asks for a small speed too.
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

} // namespace hnav::ins
