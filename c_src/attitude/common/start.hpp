// Gathers the samples that an attitude filter starts from.
#pragma once

#include "attitude/common/estimate.hpp"
#include "attitude/common/first_attitude.hpp"
#include "attitude/common/frames.hpp"
#include "base/instant.hpp"
#include "hnav/options/shared.h"

namespace hnav {

enum class StartMode { triad, attitude, heading };

template <class R>
struct StartSettings {
    StartMode mode;
    QuaternionOf<R> q;
    R heading_rad; // magnetic
    std::uint64_t samples;
    R sigma_heading;
    double field_wait_s; // after that, start without a field

    template <class Options>
    StartSettings(const Options& o, const Frames& frames, double wait_s = std::numeric_limits<double>::infinity())
        : mode(static_cast<StartMode>(o.start_mode)),
          q(frames.to_internal(Quaternion(o.start_q_nb).cast<R>().normalized().template cast<double>()).template cast<R>()),
          heading_rad(R(o.start_heading_rad - o.declination_rad)),
          samples(static_cast<std::uint64_t>(o.start_samples)),
          sigma_heading(R(o.start_sigma_heading_rad)),
          field_wait_s(wait_s) {}
};

// What the options of all attitude filters mean alike.
template <class Options>
inline bool holds_backward(const Options& o) {
    return o.gyro_hold == HNAV_GYRO_HOLD_BACKWARD;
}
template <class Options>
inline bool reference_given(const Options& o) {
    return o.reference_mode == HNAV_REFERENCE_GIVEN;
}
template <class R, class Options>
inline ReferenceFieldOf<R> reference_of(const Options& o) {
    return {R(o.reference_strength_tesla), R(o.reference_dip_rad)};
}

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
            if (!has_lasted(event.t_s - first_s, settings.field_wait_s)) return false;
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
