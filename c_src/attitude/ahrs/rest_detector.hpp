// Tells whether the body lies still. At rest the gyroscope shows its own bias, and nothing shows it better.
//
// Rate and force are each compared with their running means; rest is what stays within the thresholds for a while, at a
// mean rate that can be a bias.
#pragma once

#include "maths/rotation.hpp"

namespace hnav {

struct RestSettings {
    double rate_rad_s;      // deviation of the rate from its running mean
    double force_m_s2;      // deviation of the force
    double mean_rate_rad_s; // of each axis: above it the body turns steadily
    double duration_s;      // within all of them for so long
    double filter_s;        // time constant of the running means
};

// Part of a filter's state: doubles only.
struct RestDetector {
    double mean_rate[3], mean_force[3];
    double still_s;
    double force_still; // 1: the last force sample was within its threshold

    void clear(const Vector3& rate, const Vector3& force) {
        *this = {};
        for (int i = 0; i < 3; ++i) {
            mean_rate[i] = rate[i];
            mean_force[i] = force[i];
        }
    }

    void see_rate(const RestSettings& settings, const Vector3& rate, double interval_s) {
        Eigen::Map<Vector3> mean(mean_rate);
        mean += interval_s / (settings.filter_s + interval_s) * (rate - mean);
        const bool still = (rate - mean).squaredNorm() <= settings.rate_rad_s * settings.rate_rad_s &&
                           mean.cwiseAbs().maxCoeff() <= settings.mean_rate_rad_s && force_still > 0;
        still_s = still ? still_s + interval_s : 0;
    }

    void see_force(const RestSettings& settings, const Vector3& force, double interval_s) {
        Eigen::Map<Vector3> mean(mean_force);
        mean += interval_s / (settings.filter_s + interval_s) * (force - mean);
        force_still = (force - mean).squaredNorm() <= settings.force_m_s2 * settings.force_m_s2;
    }

    bool at_rest(const RestSettings& settings) const { return still_s > settings.duration_s; }
};

} // namespace hnav
