// Tells whether the body lies still. At rest the gyroscope shows its own bias, and nothing shows it better.
//
// Rate and force are each compared with their running means; rest is what stays within the thresholds for a while, at a
// mean rate that can be a bias.
#pragma once

#include "maths/rotation.hpp"

namespace hnav {

template <class R>
struct RestSettings {
    R rate_rad_s;      // deviation of the rate from its running mean
    R force_m_s2;      // deviation of the force
    R mean_rate_rad_s; // of each axis: above it the body turns steadily
    R duration_s;      // within all of them for so long
    R filter_s;        // time constant of the running means
};

// Part of a filter's state: numbers of one kind only.
template <class R>
struct RestDetector {
    R mean_rate[3], mean_force[3];
    R still_s;
    R force_still; // 1: the last force sample was within its threshold

    void clear(const Vector3Of<R>& rate, const Vector3Of<R>& force) {
        *this = {};
        for (int i = 0; i < 3; ++i) {
            mean_rate[i] = rate[i];
            mean_force[i] = force[i];
        }
    }

    void note_rate(const RestSettings<R>& settings, const Vector3Of<R>& rate, R interval_s) {
        Eigen::Map<Vector3Of<R>> mean(mean_rate);
        mean += interval_s / (settings.filter_s + interval_s) * (rate - mean);
        const bool still = (rate - mean).squaredNorm() <= settings.rate_rad_s * settings.rate_rad_s &&
                           mean.cwiseAbs().maxCoeff() <= settings.mean_rate_rad_s && force_still > 0;
        still_s = still ? still_s + interval_s : 0;
    }

    void note_force(const RestSettings<R>& settings, const Vector3Of<R>& force, R interval_s) {
        Eigen::Map<Vector3Of<R>> mean(mean_force);
        mean += interval_s / (settings.filter_s + interval_s) * (force - mean);
        force_still = (force - mean).squaredNorm() <= settings.force_m_s2 * settings.force_m_s2;
    }

    bool at_rest(const RestSettings<R>& settings) const { return still_s > settings.duration_s; }
};

} // namespace hnav
