// Whether the body lies still. At rest the gyroscope shows its own bias, and nothing shows it better.
//
// Rate and force are each compared with their running means; rest is what stays within the thresholds for a while, at a
// mean rate that can be a bias. A vehicle on a smooth way does too, and its mean rate is its turn: that shows in a mean rate which
// wanders, and in one which the bias known so far cannot be (the filter's test).
#pragma once

#include "base/instant.hpp"
#include "maths/rotation.hpp"

#include <cmath>

namespace hnav {

// NIS of the mean rate beside the known bias, three degrees of freedom, beyond which a body that seems to be at rest turns: exceeded by chance
// once in 880. Chosen.
constexpr double turn_nis = 16;

// How much the mean rate of what seems to be at rest wanders: a bias does not, waves and smooth turns do. Part of a filter's state: numbers of one
// kind only.
template <class R>
struct RateWander {
    R slow_rate[3]; // mean of the mean rate
    R mean2, now2; // mean square of what the mean rate departs from it by, and the present one, of one axis

    void begin(const R* mean_rate) {
        for (int i = 0; i < 3; ++i) slow_rate[i] = mean_rate[i];
        mean2 = now2 = 0;
    }
    void note(const R* mean_rate, R interval_s) {
        constexpr R slow_s = 4;
        const R share = interval_s / (slow_s + interval_s);
        Eigen::Map<Vector3Of<R>> slow(slow_rate);
        const Vector3Of<R> away = Vector3Of<R>(mean_rate) - slow;
        slow += share * away;
        now2 = away.squaredNorm() / 3;
        mean2 += share * (now2 - mean2);
    }
    // As noise of the mean rate, (rad/s)^2/Hz: it stays for about a second.
    R density2() const { return std::fmax(mean2, now2); }
};

// Options have rest_rate_rad_s and rest_force_m_s2, the largest deviations from the running means, rest_mean_rate_rad_s, the largest
// mean rate of an axis, above which the body turns steadily, rest_duration_s for which all of that holds, and rest_filter_s of the means.
// Part of a filter's state: numbers of one kind only.
template <class R>
struct RestDetector {
    R mean_rate[3], mean_force[3];
    RateWander<R> wander;
    R quiet_s; // both have been within their thresholds for so long
    R still_s; // likewise, since the filter last took the mean rate for a turn
    R force_still; // 1: the last force sample was within its threshold

    void clear(const Vector3Of<R>& rate, const Vector3Of<R>& force) {
        *this = {};
        for (int i = 0; i < 3; ++i) {
            mean_rate[i] = rate[i];
            mean_force[i] = force[i];
        }
    }

    template <class Options>
    void note_rate(const Options& o, const Vector3Of<R>& rate, R interval_s) {
        Eigen::Map<Vector3Of<R>> mean(mean_rate);
        mean += interval_s / (R(o.rest_filter_s) + interval_s) * (rate - mean);
        const bool still = (rate - mean).squaredNorm() <= R(o.rest_rate_rad_s) * R(o.rest_rate_rad_s) &&
                           mean.cwiseAbs().maxCoeff() <= R(o.rest_mean_rate_rad_s) && force_still > 0;
        quiet_s = still ? quiet_s + interval_s : 0;
        still_s = still ? still_s + interval_s : 0;
    }

    template <class Options>
    void note_force(const Options& o, const Vector3Of<R>& force, R interval_s) {
        Eigen::Map<Vector3Of<R>> mean(mean_force);
        mean += interval_s / (R(o.rest_filter_s) + interval_s) * (force - mean);
        force_still = (force - mean).squaredNorm() <= R(o.rest_force_m_s2) * R(o.rest_force_m_s2);
    }

    template <class Options>
    bool at_rest(const Options& o) const {
        return has_passed(still_s, R(o.rest_duration_s));
    }
};

// The same for vehicles, whose engine idles and which sway while they stand: not each sample, the root mean squares about the running
// means stay small, and the mean rate stays. What moves smoothly looks the same, so the filter asks for a small speed too.
// Options have rest_rate_rad_s (0: rest is never found), rest_force_m_s2 and rest_duration_s.
// Part of a filter's state: numbers of eight bytes only.
struct Unrest {
    static constexpr double filter_s = 0.5, swaying = 4;

    double mean_rate[3], mean_force[3], rate2, force2, still_s, swaying_s, begun;
    RateWander<double> wander; // while it has been still

    template <class Options>
    void note(const Options& o, const Vector3& rate, const Vector3& force, double interval_s) {
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
        const double r = o.rest_rate_rad_s, f = o.rest_force_m_s2;
        const auto within = [&](double limits) { return rate2 <= limits * limits * r * r && force2 <= limits * limits * f * f; };
        still_s = within(1) ? still_s + interval_s : 0;
        if (has_passed(still_s, o.rest_duration_s)) wander.note(mean_rate, interval_s);
        else wander.begin(mean_rate); // the end of a motion is in the mean
        swaying_s = within(swaying) ? swaying_s + interval_s : 0;
    }

    template <class Options>
    bool still(const Options& o) const {
        // Largest wander of the mean rate, share of rest_rate_rad_s. Chosen: between waves a ferry seems to rest; without this limit its tilt is
        // ready and more than 3 deg off for 9 % of the time in the mean of ten, up to 43 %, with .3 for 4 %, with .2 and .15 for 1 %.
        constexpr double steady = 0.2;
        const double largest = steady * o.rest_rate_rad_s;
        return o.rest_rate_rad_s > 0 && has_passed(still_s, o.rest_duration_s) && wander.density2() <= largest * largest;
    }
    // The same with wider limits: on something that sways.
    template <class Options>
    bool sways(const Options& o) const {
        return o.rest_rate_rad_s > 0 && has_passed(swaying_s, o.rest_duration_s);
    }
};

} // namespace hnav
