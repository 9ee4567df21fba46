// Gathers the samples that an attitude filter starts from.
#pragma once

#include "attitude/common/estimate.hpp"
#include "attitude/common/first_attitude.hpp"
#include "attitude/common/frames.hpp"
#include "base/instant.hpp"
#include "hnav/options/shared.h"
#include "maths/earth.hpp"
#include "signals/hold.hpp"

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

    // A given attitude is that of the beginning: after a loss the samples determine it, and without a field the heading is unknown.
    StartSettings after_loss() const {
        constexpr double field_s = 1; // far longer than the period of any magnetometer
        StartSettings s = *this;
        if (mode != StartMode::triad) s.field_wait_s = field_s;
        s.mode = StartMode::triad;
        return s;
    }
};

// From the options that all attitude filters share.
template <class Options>
inline bool reference_given(const Options& o) {
    return o.reference_mode == HNAV_REFERENCE_GIVEN;
}
template <class R, class Options>
inline ReferenceFieldOf<R> reference_of(const Options& o) {
    return {R(o.reference_strength_tesla), R(o.reference_dip_rad)};
}

// An attitude found, the sigma of its heading, and whether that is the heading of a field.
template <class R>
struct FirstAttitude {
    QuaternionOf<R> q;
    R sigma_heading;
    bool by_field = false;
};

// The mean of the newest samples that agree, in the body axes of now. A first sample may be wrong (a chip that wakes up, a lost byte), so a
// start takes several. Each force is within max_acceleration of gravity, and each sample within max_apart of the mean of those before it,
// propagated by the gyroscope. A sample further away restarts the mean. After patience_s any samples are accepted, because a body may
// move so violently that none agree.
//
// Part of a filter's state: numbers of eight bytes only.
template <class R>
struct StartSamples {
    static constexpr R gravity_m_s2 = R(earth::standard_gravity_m_s2);
    static constexpr R max_acceleration = R(0.25); // in units of gravity
    static constexpr R max_apart = R(0.25); // of a sample and the mean, in units of the mean: 14 deg
    static constexpr double patience_s = 1;

    R mean[2][3]; // force, field
    R aid, aid_sigma; // heading
    double first_s, last_s; // the first event and the newest
    std::uint64_t count[2];
    std::uint64_t has_aid;

    void clear() {
        *this = {};
        first_s = last_s = nan;
    }

    Vector3Of<R> force() const { return Vector3Of<R>(mean[0]); }
    Vector3Of<R> field() const { return Vector3Of<R>(mean[1]); }
    bool has_force(const StartSettings<R>& settings) const { return count[0] >= settings.samples; }
    bool has_field(const StartSettings<R>& settings) const { return count[1] >= settings.samples && field().norm() > 0; }

    // Adds the samples of an event. usable: bit c is set if channel c has a sample that is not rejected. rate: of the body since the last
    // event, rad/s, body axes. True once an attitude follows from the samples.
    bool add(const AttitudeEvent& event, std::uint64_t usable, const Vector3Of<R>& rate, const StartSettings<R>& settings,
             FirstAttitude<R>* found) {
        turn(event.t_s, rate);
        gather(event, usable, settings);
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
            // Uniform on the circle.
            *found = {level_with_heading<R>(force(), 0), R(M_PI / std::sqrt(3.0))};
            return true;
        }
        found->by_field = triad<R>(force(), field(), &found->q);
        if (found->by_field) return true;
        const double began_s = first_s; // no heading in these samples: wait for better ones
        clear();
        first_s = began_s;
        return false;
    }

private:
    void turn(double t_s, const Vector3Of<R>& rate) {
        if (std::isnan(first_s)) first_s = t_s;
        const Vector3Of<R> since = rate * (t_s > last_s ? R(t_s - last_s) : R(0));
        last_s = t_s;
        if (!(since.squaredNorm() > 0)) return;
        const Matrix3Of<R> back = rotation_matrix<R>(rotation_quaternion<R>(-since));
        for (auto& of_sensor : mean) {
            Eigen::Map<Vector3Of<R>> m(of_sensor);
            m = Vector3Of<R>(back * m);
        }
    }

    void gather(const AttitudeEvent& event, std::uint64_t usable, const StartSettings<R>& settings) {
        const bool patient = settings.samples > 1 && is_within(event.t_s - first_s, patience_s);
        for (int k = 0; k < 2; ++k)
            if ((usable >> (accel + k)) & 1) take(k, vector_of<R>(event, accel + k), patient, settings.samples);
        if (!((usable >> heading) & 1)) return;
        aid = R(event.value[heading][0]);
        aid_sigma = R(event.value[heading][1]);
        has_aid = 1;
    }

    void take(int k, const Vector3Of<R>& y, bool patient, std::uint64_t samples) {
        if (count[k] >= samples && !patient) return;
        Eigen::Map<Vector3Of<R>> m(mean[k]);
        if (patient) {
            if (k == 0 && !(std::fabs(y.norm() - gravity_m_s2) <= max_acceleration * gravity_m_s2)) return;
            if (!((y - m).norm() <= max_apart * m.norm())) count[k] = 0;
        }
        ++count[k];
        m += (y - m) / static_cast<R>(count[k]);
    }
};

} // namespace hnav
