// What the AHRS is told, and all that changes in it.
#pragma once

#include "attitude/ahrs/field_noise.hpp"
#include "attitude/ahrs/motion_noise.hpp"
#include "attitude/ahrs/reference_field.hpp"
#include "attitude/common/estimate.hpp"
#include "attitude/common/start.hpp"
#include "estimation/readiness.hpp"
#include "estimation/robust_law.hpp"
#include "maths/packed_columns.hpp"
#include "signals/gaps.hpp"
#include "signals/rest.hpp"
#include "signals/sampling.hpp"
#include "signals/sensor_check.hpp"

namespace hnav {

// Rows of the error state. Those up to the tilt are not corrected by a field.
struct AhrsErrors {
    enum Row : int {
        velocity = 0,
        force_bias = 2,
        force_latency = 5,
        calibration = 6,
        rotation = 15,
        bias = 18,
        reference = 21,
        latency = 23,
        declination = 24
    };
    static constexpr int errors = 25;
    static constexpr int considered = rotation + 2;

    // Place of the element i, j, i <= j, in the upper triangle packed column by column.
    static constexpr int packed(int i, int j) { return place_in_columns(i, j); }
};

constexpr int ahrs_nx = 14; // q 4, G 9, clock: seconds since the last correction

template <class R>
struct AhrsSettings {
    struct Sigmas {
        R tilt, heading, bias, velocity, reference, latency, scale, misalignment, force_bias, force_latency, declination;
    };

    R gyro_psd;          // n_g^2, (rad/s)^2/Hz
    R gyro_rate_psd;     // k^2, (rad/s)^2/Hz for each (rad/s)^2
    R bias_walk_psd;     // (rad/s)^2/s
    R reference_psd;     // 1/s
    R velocity_density2; // (m/s)^2/Hz, at most
    R azimuth_density2, intensity_density2; // of the field in a room, 1/Hz
    R rest_field_factor; // of their variances at rest
    R rest_bias_density2; // (rad/s)^2/Hz
    R force_latency;      // at the start, in intervals of the accelerometer
    R declination_s;      // for which the field keeps its azimuth while the body moves about
    R velocity_gate_nis;  // 0: never
    R azimuth_gate;       // in sigmas, while the heading is known; 0: never
    SensorCheckSettings<R> check[heading];
    double correction_interval_s;
    double max_interval_s;
    R gap_acceleration_m_s2; // that may go by while samples of force are missing
    R gap_turn_factor;       // of the usual change of the rate, while samples of it are missing
    bool backward_hold;
    RobustSettings<R> robust; // until the horizon is ready
    RestSettings<R> rest;
    MagneticReferenceSettings<R> field;
    StartSettings<R> start;
    Vector3Of<R> start_bias = Vector3Of<R>::Zero();
    Sigmas sigma; // at the start; that of heading stands in start
    bool reference_given;
    ReferenceFieldOf<R> reference;
    R heading_gate_nis; // 0: never
    R ready_tilt_rad, ready_heading_rad, ready_evidence_s, ready_undisturbed_s;
    R output_latency_s;
};

// Numbers of eight bytes only.
template <class R>
struct AhrsState {
    R x[ahrs_nx];
    // What only corrections and starts change, one event in ten: the others leave it as it is, and it is not copied for them.
    // Whoever writes any of it counts that.
    R P[AhrsErrors::errors * (AhrsErrors::errors + 1) / 2]; // just after the last correction
    R bias[3], calibration[9], reference[2], latency;
    R force_bias[3], force_latency; // of the accelerometer, m/s^2; its latency in its intervals
    R declination; // of the field here against the reference's north, rad
    R wrong_hold; // probability that rates act an interval earlier or later than the options tell
    R strength; // of the field, T
    MagneticReference<R> field;
    FieldNoise<R> field_noise;
    AngleInformation<R> information;
    R undisturbed_s; // time for which nothing spoke against the reference
    R heading_doubt; // rad^2, beside P: the reference may have been false
    R contradicted_s; // time for which fields did so, less that for which they agreed since
    R azimuth_rejected_s;
    R gamma, gamma_margin;
    InnovationOf<R> innovation[channel_count];
    StartSamples<R> start;
    R level_force[3], level_s; // force in navigation axes times the time it acted, and that time, while the attitude is lost
    std::uint64_t lost, times_lost; // the attitude is to be found again
    std::uint64_t gated[channel_count];
    std::uint64_t corrections, gamma_raised, repaired;
    std::uint64_t verdict; // of the last field, FieldVerdict
    std::uint64_t heading_confirmed; // since it was last started or turned
    std::uint64_t seldom_changes; // the count; the last of what seldom changes

    R velocity[2];
    R rate[3]; // held, as measured
    R coning[3]; // what the turn of its axis adds to it
    R turning[3]; // the constant rate that turns the body as far: from the rate without its errors, and coning
    R force_turn[3]; // rotation vector since the last sample of force
    RateChange<R> rate_change;
    // Since the last correction: L = int R_bn (x) y' dt, a row for each axis, int |u|^2, both up to the last event, G and clock there,
    // the gathered samples.
    R rate_moment[3][9], rate_power, turned[9], turned_s;
    R field_sum[3], turn_sum[3], field_count, field_s, force_s, force_gap_s, gap_rotation;
    R swept_velocity[2]; // what an interval of latency does to the velocity
    RestDetector<R> rest;
    MotionNoise<R> motion;
    SensorCheck<R> check[heading];
    std::uint64_t rejected; // bit c: the present sample of channel c is treated as missing
    R velocity_down; // since the last correction
    std::uint64_t gap_too_long; // before the present event
    double last_s[channel_count], spacing_s[channel_count]; // the newest sample, and the usual time between two
    double last_event_s, last_correction_s;
    std::uint64_t used[channel_count];
    std::uint64_t started, has_rate, has_reference;
    std::uint64_t reversed; // time runs backwards

    // Channels whose sample is there and not rejected, as bits; and whether one is among them.
    std::uint64_t usable(const AttitudeEvent& event) const { return event.present & ~rejected; }
    bool has(const AttitudeEvent& event, int channel) const { return (usable(event) >> channel) & 1; }

    // The time since the last sample of a channel shows that some are missing.
    bool is_gap(int channel, double t_s) const { return hnav::is_gap(t_s - last_s[channel], spacing_s[channel]); }

    void note_time(int channel, double t_s) {
        spacing_s[channel] = usual_interval(t_s - last_s[channel], spacing_s[channel]);
        last_s[channel] = t_s;
    }
};

} // namespace hnav
