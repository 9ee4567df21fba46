// Settings of the AHRS, derived from its options, and its state.
#pragma once

#include "attitude/ahrs/bias_steps.hpp"
#include "attitude/ahrs/body.hpp"
#include "attitude/ahrs/field_noise.hpp"
#include "attitude/ahrs/given_field.hpp"
#include "attitude/ahrs/given_speed.hpp"
#include "attitude/ahrs/lasting_motion.hpp"
#include "attitude/ahrs/motion_noise.hpp"
#include "attitude/ahrs/reference_field.hpp"
#include "attitude/ahrs/still_field.hpp"
#include "attitude/ahrs/tilt_excess.hpp"
#include "attitude/ahrs/turning_force.hpp"
#include "attitude/ahrs/vehicle_tilt.hpp"
#include "attitude/common/attitude_flow.hpp"
#include "attitude/common/estimate.hpp"
#include "attitude/common/start.hpp"
#include "estimation/readiness.hpp"
#include "estimation/robust_law.hpp"
#include "hnav/options/ahrs.h"
#include "maths/packed_columns.hpp"
#include "maths/scalar.hpp"
#include "maths/square.hpp"
#include "signals/gaps.hpp"
#include "signals/rest.hpp"
#include "signals/sampling.hpp"
#include "signals/sensor_checks.hpp"

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
    static constexpr int responding = errors - rotation; // and the velocity: to a step of the gyro bias, within a window

    // Place of the element i, j, i <= j, in the upper triangle packed column by column.
    static constexpr int packed(int i, int j) { return place_in_columns(i, j); }
};

// Standard deviations at the start.
struct AhrsSigmas {
    Scalar tilt, heading, bias, velocity, reference, latency, scale, misalignment, force_bias, force_latency, declination;
};
inline AhrsSigmas sigmas_of(const hnav_ahrs_options& o) {
    return {Scalar(o.start_sigma_tilt_rad),        Scalar(o.start_sigma_heading_rad),
            Scalar(o.start_sigma_bias_rad_s),      Scalar(o.start_sigma_velocity_m_s),
            Scalar(o.start_sigma_reference),       Scalar(o.start_sigma_latency_s),
            Scalar(o.start_sigma_gyro_scale),      Scalar(o.start_sigma_gyro_misalignment_rad),
            Scalar(o.start_sigma_accel_bias_m_s2), Scalar(o.start_sigma_accel_latency),
            Scalar(o.local_declination_rad)};
}

// Squares of the noise densities, which each sample needs.
struct AhrsDensities {
    using R = Scalar;

    R gyro_psd;       // (rad/s)^2/Hz
    R gyro_rate_psd;  // the same for each (rad/s)^2
    R bias_walk_psd;  // (rad/s)^2/s
    R reference_psd;  // 1/s
    R velocity_density2; // (m/s)^2/Hz, at most
    R lasting_density2; // (m/s)^2/Hz, at least while the body moves; 0: the body is not given
    R swell_density2; // (m/s)^2/Hz, of velocities that return, beside those of a hand
    R vertical2; // (m/s)^2, mean square of the vertical velocity, at least
    R azimuth_density2, intensity_density2; // of the field in a room, 1/Hz
    R rest_bias_density2; // (rad/s)^2/Hz

    explicit AhrsDensities(const hnav_ahrs_options& o)
        : gyro_psd(R(square(o.gyro_noise_rad_per_sqrt_s))),
          gyro_rate_psd(R(square(o.gyro_rate_noise_sqrt_s))),
          bias_walk_psd(R(square(o.gyro_bias_walk_rad_s_per_sqrt_s))),
          reference_psd(R(square(o.reference_walk_per_sqrt_s))),
          velocity_density2(R(square(o.velocity_noise_m_s_per_sqrt_hz))),
          lasting_density2(lasting_density2_of<R>(o.body)),
          swell_density2(swell_density2_of<R>(o.body)),
          vertical2(vertical2_of<R>(o.body)),
          azimuth_density2(R(square(o.mag_azimuth_noise_per_sqrt_hz))),
          intensity_density2(R(square(o.mag_intensity_noise_per_sqrt_hz))),
          rest_bias_density2(R(square(o.rest_bias_noise_rad_s_per_sqrt_hz))) {}
};

// Numbers of eight bytes only.
struct AhrsState {
    using R = Scalar;

    R x[AttitudeFlow<R>::nx]; // the clock: seconds since the last correction
    // Members that only corrections and starts change, about one event in ten. For other events they are not copied. Every change
    // increments seldom_changes.
    R P[AhrsErrors::errors * (AhrsErrors::errors + 1) / 2]; // just after the last correction
    R bias[3], calibration[9], reference[2], latency;
    R force_bias[3], force_latency; // of the accelerometer, m/s^2; its latency in its intervals
    R declination; // of the field here against the reference's north, rad
    R wrong_hold; // probability that rates act an interval earlier or later than the option gyro_hold states
    R strength; // of the field, T
    R foreign2; // share of the declination's variance from a field that is not the given one, rad^2; 0: the field is the given one
    MagneticReference<R> field;
    FieldNoise<R> field_noise;
    AngleInformation<R> information;
    R undisturbed_s; // time without contradiction of the reference
    R reference_variance; // rad^2, in addition to P: the reference may have been false
    R contradicted_s; // time for which fields contradicted the heading, minus time of agreement since
    R azimuth_rejected_s;
    R gamma, gamma_margin;
    InnovationOf<R> innovation[channel_count];
    StartSamples<R> start;
    R level_force[3], level_s; // force in navigation axes times the time it acted, and that time, while the attitude is lost
    std::uint64_t lost, times_lost; // the attitude is to be found again
    std::uint64_t gated[channel_count];
    std::uint64_t corrections, gamma_raised, repaired;
    StillField<R> still_field;
    LastingMotion<R> lasting;
    TurningForce<R> turning_force;
    VehicleTilt<R> vehicle_tilt; // of an unknown body: for readiness and stated variances
    BiasSteps<R, AhrsErrors::responding> steps;
    TiltExcess<R> tilt_excess; // rad^2, in addition to P: corrections that are not white
    R rests; // 1: the last correction was at rest
    GivenSpeed<R> speed;
    std::uint64_t verdict; // of the last field, FieldVerdict
    std::uint64_t heading_confirmed; // since it was last started or turned
    std::uint64_t seldom_changes; // counts changes; last member of this group

    R velocity[2];
    R rate[3], read_rate[3]; // held; as measured
    R coning[3]; // correction for the turn of its axis
    R turning[3]; // constant rate of the same rotation: the corrected rate plus coning
    R force_turn[3]; // rotation vector since the last sample of force
    RateChange<R> rate_change;
    // Since the last correction: L = int R_bn (x) y' dt, a row for each axis, int |u|^2, both up to the last event, G and clock there,
    // the gathered samples.
    R rate_moment[3][9], rate_power, turned[9], turned_s;
    R field_sum[3], turn_sum[3], field_count, field_s, force_s, force_gap_s, gap_rotation;
    R swept_velocity[2]; // change of the velocity by an interval of latency
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

    // Whether samples of a channel are missing, by the time since the last one.
    bool is_gap(int channel, double t_s) const { return hnav::is_gap(t_s - last_s[channel], spacing_s[channel]); }

    void note_time(int channel, double t_s) {
        spacing_s[channel] = usual_interval(t_s - last_s[channel], spacing_s[channel]);
        last_s[channel] = t_s;
    }
};

} // namespace hnav
