// Gathers the samples that an attitude filter starts from.
#pragma once

#include "attitude/common/estimate.hpp"
#include "attitude/common/first_attitude.hpp"

namespace hnav {

enum class StartMode { triad, attitude, heading };

template <class R>
struct StartSettings {
    StartMode mode = StartMode::triad;
    QuaternionOf<R> q{1, 0, 0, 0};
    R heading_rad = 0; // magnetic
    std::uint64_t samples = 1;
    R sigma_heading = 0;
    double field_wait_s = std::numeric_limits<double>::infinity(); // after that, start without a field
};

// An attitude found, and the sigma of its heading.
template <class R>
struct FirstAttitude {
    QuaternionOf<R> q;
    R sigma_heading;
};

// Part of a filter's state: numbers of eight bytes only.
template <class R>
struct StartSamples {
    R sum[2][3]; // force, field
    R aid, aid_sigma; // heading
    double first_s;
    std::uint64_t count[2];
    std::uint64_t has_aid;

    void clear() {
        *this = {};
        first_s = nan;
    }

    Vector3Of<R> force() const { return Vector3Of<R>(sum[0]) / static_cast<R>(count[0]); }
    Vector3Of<R> field() const { return Vector3Of<R>(sum[1]) / static_cast<R>(count[1]); }
    bool has_force(const StartSettings<R>& settings) const { return count[0] >= settings.samples; }
    bool has_field(const StartSettings<R>& settings) const {
        return count[1] >= settings.samples && Vector3Of<R>(sum[1]).norm() > 0;
    }

    // Adds the samples of an event. True once an attitude follows from them.
    bool add(const AttitudeEvent& event, const StartSettings<R>& settings, FirstAttitude<R>* found) {
        gather(event, settings);
        found->sigma_heading = settings.sigma_heading;
        if (settings.mode == StartMode::attitude) {
            found->q = settings.q;
            return true;
        }
        if (!has_force(settings) || !(force().norm() > 0)) return false;
        if (settings.mode == StartMode::heading) {
            found->q = level_with_heading<R>(force(), settings.heading_rad);
            return true;
        }
        if (has_aid) {
            *found = {level_with_heading<R>(force(), aid), aid_sigma};
            return true;
        }
        if (!has_field(settings)) {
            if (!(event.t_s - first_s >= settings.field_wait_s)) return false;
            // Any heading is as likely as any other.
            *found = {level_with_heading<R>(force(), 0), R(M_PI / std::sqrt(3.0))};
            return true;
        }
        if (triad<R>(force(), field(), &found->q)) return true;
        const double began_s = first_s; // no heading in these samples: wait for better ones
        clear();
        first_s = began_s;
        return false;
    }

private:
    void gather(const AttitudeEvent& event, const StartSettings<R>& settings) {
        if (std::isnan(first_s)) first_s = event.t_s;
        for (int k = 0; k < 2; ++k) {
            const int c = accel + k;
            if (!event.has(c) || count[k] >= settings.samples) continue;
            for (int i = 0; i < 3; ++i) sum[k][i] += R(event.value[c][i]);
            ++count[k];
        }
        if (event.has(heading)) {
            aid = R(event.value[heading][0]);
            aid_sigma = R(event.value[heading][1]);
            has_aid = 1;
        }
    }
};

} // namespace hnav
