// Made by c_src/options/generate.py from ahrs.toml: change that, then ./run generate.
#include "options/choices.hpp"

#include "hnav/options/ahrs.h"

#include <cmath>
#include <cstddef>

// clang-format off
namespace hnav {
namespace {

constexpr double defaults[] = {
    0, // body
    8.4e-05, // gyro_noise_rad_per_sqrt_s
    0.0017, // gyro_rate_noise_sqrt_s
    0.0001, // gyro_bias_walk_rad_s_per_sqrt_s
    0.36, // velocity_noise_m_s_per_sqrt_hz
    0.018, // mag_azimuth_noise_per_sqrt_hz
    0.0125, // mag_intensity_noise_per_sqrt_hz
    1.07, // mag_rest_factor
    0.0031, // reference_walk_per_sqrt_s
    0.025, // local_declination_rad
    60, // local_declination_s
    0.03, // speed_slip_rad
    1, // gyro_hold
    0.0347, // correction_interval_s
    0.1, // max_interval_s
    2, // gap_acceleration_m_s2
    2.5, // gap_turn_factor
    3, // max_speed_age_s
    0, // horizon_s
    64, // queue_capacity
    0, // output_latency_s
    0.034906585039886591, // rest_rate_rad_s
    0.5, // rest_force_m_s2
    0.034906585039886591, // rest_mean_rate_rad_s
    1.5, // rest_duration_s
    0.5, // rest_filter_s
    2.8e-05, // rest_bias_noise_rad_s_per_sqrt_hz
    0.035, // mag_gate
    60, // mag_gate_max_s
    3, // mag_gate_share
    4, // mag_azimuth_gate_sigmas
    12, // lost_ratio
    8.8, // heading_gate_nis
    0, // reference_mode
    5e-05, // reference_strength_tesla
    1.0471975511965976, // reference_dip_rad
    0.05, // reference_strength_tolerance
    0.05235987755982989, // reference_dip_tolerance_rad
    0.35, // turning_rad_s
    0.35, // still_weight
    0.17, // candidate_radius
    5, // candidate_mean_s
    1.6, // candidate_first_s
    0.5, // candidate_share
    60, // trust_s
    0.13, // turn_min_rad
    3.75, // turn_sigmas
    0.12, // turn_sigma_rad
    2, // gamma_mode
    1, // gamma
    0.3, // gamma_relative_rate_1_s
    0.75, // gamma_kl_rate_1_s
    0, // start_mode
    2, // start_samples
    1, // start_field_wait_s
    1, 0, 0, 0, // start_q_nb
    0, // start_heading_rad
    0, 0, 0, // start_gyro_bias_rad_s
    0.08, // start_sigma_tilt_rad
    0.2, // start_sigma_heading_rad
    0.008, // start_sigma_bias_rad_s
    0.056, // start_sigma_velocity_m_s
    0.077, // start_sigma_reference
    0.011, // start_sigma_latency_s
    0.25, // start_accel_latency
    0.25, // start_sigma_accel_latency
    0.035, // start_sigma_accel_bias_m_s2
    0.002, // start_sigma_gyro_scale
    0.00056, // start_sigma_gyro_misalignment_rad
    0, // gyro_range_rad_s
    0, // accel_range_m_s2
    0, // mag_range_tesla
    8, // outlier_rate_rad_s
    100, // outlier_force_m_s2
    1, // time_jump_limit_s
    0.034906585039886591, // ready_tilt_rad
    0.087266462599716474, // ready_heading_rad
    2.6, // ready_evidence_s
    7.5, // ready_undisturbed_s
    0, // navigation_frame
    0, // declination_rad
    1, 0, 0, 0, // q_body_sensor
    0, // solver
    1e-08, // solver_rtol
    1e-08, // solver_atol
    0.001, // euler_step_s
};

const OptionRow rows[] = {
    {"body", text("noise"), text(""),
     text("Kind of body: sets the noise of lasting velocities and the test of rest, and switches the robust law off"),
     text("The kind of body is unknown; with the right word the sigmas of a vehicle are correct from the start on."),
     body_names, body_meanings, defaults + 0, offsetof(hnav_ahrs_options, body),
     0, 6, 1, 7, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"gyro_noise_rad_per_sqrt_s", text("noise"), text("rad/sqrt(s)"),
     text("Angle random walk: white noise of the gyroscope"),
     text("Of a usual chip, 5 mdeg/s/sqrt(Hz)."),
     nullptr, nullptr, defaults + 1, offsetof(hnav_ahrs_options, gyro_noise_rad_per_sqrt_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gyro_rate_noise_sqrt_s", text("noise"), text("sqrt(s)"),
     text("Noise of the gyroscope that grows with the rate: density = this x |rate|"),
     text("In hand motion scale factor and misalignment dominate the white noise; without it the error on BROAD is 1.5 times as large."),
     nullptr, nullptr, defaults + 2, offsetof(hnav_ahrs_options, gyro_rate_noise_sqrt_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro_bias_walk_rad_s_per_sqrt_s", text("noise"), text("rad/s/sqrt(s)"),
     text("Random walk of the gyro bias"),
     text("Temperature moves the bias more than the walk on the datasheet, which is for a sensor of constant temperature only."),
     nullptr, nullptr, defaults + 3, offsetof(hnav_ahrs_options, gyro_bias_walk_rad_s_per_sqrt_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"velocity_noise_m_s_per_sqrt_hz", text("noise"), text("m/s/sqrt(Hz)"),
     text("Bound of the velocity, by which the accelerometer measures the tilt"),
     text("A hand or a walking person. Smaller values reduce the tilt noise of a body that does not accelerate, larger ones tolerate long accelerations."),
     nullptr, nullptr, defaults + 4, offsetof(hnav_ahrs_options, velocity_noise_m_s_per_sqrt_hz),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"mag_azimuth_noise_per_sqrt_hz", text("noise"), text("1/sqrt(Hz)"),
     text("Noise density of the field across the reference, in units of its strength"),
     text("Far above any datasheet: it represents the iron of a room. With larger values the heading follows the gyroscope for longer."),
     nullptr, nullptr, defaults + 5, offsetof(hnav_ahrs_options, mag_azimuth_noise_per_sqrt_hz),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 0},
    {"mag_intensity_noise_per_sqrt_hz", text("noise"), text("1/sqrt(Hz)"),
     text("Noise density of horizontal and vertical intensity, in units of the strength"),
     text("Iron of a room changes the intensities slightly less than the azimuth."),
     nullptr, nullptr, defaults + 6, offsetof(hnav_ahrs_options, mag_intensity_noise_per_sqrt_hz),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"mag_rest_factor", text("noise"), text(""),
     text("Factor on the field's variances at rest, where disturbances do not average out"),
     text("At rest all samples have the same disturbance."),
     nullptr, nullptr, defaults + 7, offsetof(hnav_ahrs_options, mag_rest_factor),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"reference_walk_per_sqrt_s", text("noise"), text("1/sqrt(s)"),
     text("Random walk of the reference field, in units of the strength"),
     text("The field varies within a room; with a constant reference the error on BROAD is larger."),
     nullptr, nullptr, defaults + 8, offsetof(hnav_ahrs_options, reference_walk_per_sqrt_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"local_declination_rad", text("noise"), text("rad"),
     text("Variation of the field's azimuth from place to place, one sigma"),
     text("A degree and a half, as in the rooms of BROAD; in the open it is less."),
     nullptr, nullptr, defaults + 9, offsetof(hnav_ahrs_options, local_declination_rad),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"local_declination_s", text("noise"), text("s"),
     text("Time that a moving body stays at a place of constant azimuth"),
     text("Of a hand in a room."),
     nullptr, nullptr, defaults + 10, offsetof(hnav_ahrs_options, local_declination_s),
     0, 1e+09, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"speed_slip_rad", text("noise"), text("rad"),
     text("Sideslip: angle between the horizontal velocity and body x, one sigma; acts with a speed (push_speed)"),
     text("Of tyres in a bend, of an aircraft in a gust, and of a sensor that is mounted a degree off."),
     nullptr, nullptr, defaults + 11, offsetof(hnav_ahrs_options, speed_slip_rad),
     0, 10, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro_hold", text("timing"), text(""),
     text("forward: a rate holds until the next sample; backward: since the previous sample; instant: it was read at its time"),
     text("Integrating gyroscopes and averaging FIFOs return the mean over the interval before a sample."),
     gyro_hold_names, gyro_hold_meanings, defaults + 12, offsetof(hnav_ahrs_options, gyro_hold),
     0, 2, 1, 3, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"correction_interval_s", text("timing"), text("s"),
     text("Interval between corrections, at the nearest sample; aids correct at once"),
     text("Long for samples, so that corrections cost little, and short for the motion; half of it gains nothing. For no usual rate from 25 to 1000 Hz are two samples equally near."),
     nullptr, nullptr, defaults + 13, offsetof(hnav_ahrs_options, correction_interval_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"max_interval_s", text("timing"), text("s"),
     text("Longest interval that one sample represents; the first sample of a sensor represents none"),
     text("Ten times the usual interval; a sample after a longer gap contains no more information."),
     nullptr, nullptr, defaults + 14, offsetof(hnav_ahrs_options, max_interval_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"gap_acceleration_m_s2", text("timing"), text("m/s2"),
     text("Acceleration of the body in a gap between force samples"),
     text("A brisk movement of a hand."),
     nullptr, nullptr, defaults + 15, offsetof(hnav_ahrs_options, gap_acceleration_m_s2),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gap_turn_factor", text("timing"), text(""),
     text("Angular acceleration in a gap between gyro samples, in units of its running RMS"),
     text("A gap may coincide with the fastest part of a turn."),
     nullptr, nullptr, defaults + 16, offsetof(hnav_ahrs_options, gap_turn_factor),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"max_speed_age_s", text("timing"), text("s"),
     text("Time after the last speed (push_speed) after which the velocity is unknown"),
     text("Two samples of a GNSS receiver with 1 Hz may be missing."),
     nullptr, nullptr, defaults + 17, offsetof(hnav_ahrs_options, max_speed_age_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"horizon_s", text("timing"), text("s"),
     text("Largest age of a late sample relative to the newest one"),
     text("Samples are in order; a horizon costs memory and the replay of all events within it."),
     nullptr, nullptr, defaults + 18, offsetof(hnav_ahrs_options, horizon_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"queue_capacity", text("timing"), text(""),
     text("Number of events that can wait or be within the horizon"),
     text("Enough for an advance after every few dozen samples, and little memory."),
     nullptr, nullptr, defaults + 19, offsetof(hnav_ahrs_options, queue_capacity),
     4, 1e+06, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"output_latency_s", text("timing"), text("s"),
     text("Attitude is predicted this far ahead at the present rate"),
     text("Attitude is that of the time stamps; the latency of the user's output is unknown."),
     nullptr, nullptr, defaults + 20, offsetof(hnav_ahrs_options, output_latency_s),
     -1, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"rest_rate_rad_s", text("rest"), text("rad/s"),
     text("Rest: deviation of the rate from its running mean"),
     text("Above the noise of usual gyroscopes, below the tremor of a hand."),
     nullptr, nullptr, defaults + 21, offsetof(hnav_ahrs_options, rest_rate_rad_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"rest_force_m_s2", text("rest"), text("m/s2"),
     text("Rest: deviation of the specific force from its running mean"),
     text("Above the noise of usual accelerometers, below the tremor of a hand."),
     nullptr, nullptr, defaults + 22, offsetof(hnav_ahrs_options, rest_force_m_s2),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"rest_mean_rate_rad_s", text("rest"), text("rad/s"),
     text("Rest: largest mean rate of an axis that can be a bias"),
     text("Turn-on bias of usual gyroscopes; a slower steady turn would be estimated as bias."),
     nullptr, nullptr, defaults + 23, offsetof(hnav_ahrs_options, rest_mean_rate_rad_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"rest_duration_s", text("rest"), text("s"),
     text("Rest: time within the thresholds"),
     text("Longer than the turning points of a movement."),
     nullptr, nullptr, defaults + 24, offsetof(hnav_ahrs_options, rest_duration_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"rest_filter_s", text("rest"), text("s"),
     text("Rest: time constant of the running means"),
     text("Averages some dozen samples and follows the end of a movement."),
     nullptr, nullptr, defaults + 25, offsetof(hnav_ahrs_options, rest_filter_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"rest_bias_noise_rad_s_per_sqrt_hz", text("rest"), text("rad/s/sqrt(Hz)"),
     text("Noise density of the mean rate at rest as a measurement of the bias"),
     text("Below the gyroscope's white noise, which the running mean has averaged."),
     nullptr, nullptr, defaults + 26, offsetof(hnav_ahrs_options, rest_bias_noise_rad_s_per_sqrt_hz),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"mag_gate", text("gate"), text(""),
     text("Deviation of the field's intensities from the reference beyond which it is rejected, in units of the strength"),
     text("Twice the mean deviation within a room; smaller values reject more fields."),
     nullptr, nullptr, defaults + 27, offsetof(hnav_ahrs_options, mag_gate),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 0},
    {"mag_gate_max_s", text("gate"), text("s"),
     text("Longest time for which a field is rejected"),
     text("A gyroscope alone holds the heading for about a minute."),
     nullptr, nullptr, defaults + 28, offsetof(hnav_ahrs_options, mag_gate_max_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag_gate_share", text("gate"), text(""),
     text("Longest time for which a field is rejected, in units of the age of the reference"),
     text("A reference of a few seconds may be wrong itself."),
     nullptr, nullptr, defaults + 29, offsetof(hnav_ahrs_options, mag_gate_share),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag_azimuth_gate_sigmas", text("gate"), text(""),
     text("Deviation of the field's azimuth in sigmas beyond which it is rejected, while the heading is ready; 0 = never"),
     text("A room turns the field by less. Swapped or stuck magnetometer axes turn it by more at the same intensity."),
     nullptr, nullptr, defaults + 30, offsetof(hnav_ahrs_options, mag_azimuth_gate_sigmas),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"lost_ratio", text("gate"), text(""),
     text("Logarithm of the likelihood ratio of a wrong horizon to an accelerating body, from the mean force, above which the horizon is levelled again; 0 = never"),
     text("No simulated vehicle reaches it; after 10 s of clipped gyroscope it is reached within 8 s."),
     nullptr, nullptr, defaults + 31, offsetof(hnav_ahrs_options, lost_ratio),
     0, 1e+12, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"heading_gate_nis", text("gate"), text(""),
     text("Normalised innovation squared of the heading aid beyond which its noise is inflated; 0 = never"),
     text("99.7 % of chi square with 1 degree of freedom."),
     nullptr, nullptr, defaults + 32, offsetof(hnav_ahrs_options, heading_gate_nis),
     0, 1e+12, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"reference_mode", text("reference"), text(""),
     text("Strength and dip of the magnetic field: learnt from the samples of the start, or given"),
     text("It needs nothing but the samples, and indoors no model of the field holds."),
     reference_mode_names, reference_mode_meanings, defaults + 33, offsetof(hnav_ahrs_options, reference_mode),
     0, 1, 1, 2, HNAV_OPTION_CHOICE, 0, 0, 1},
    {"reference_strength_tesla", text("reference"), text("T"),
     text("Strength of the magnetic field, when given"),
     text("A usual field of the Earth in middle latitudes."),
     nullptr, nullptr, defaults + 34, offsetof(hnav_ahrs_options, reference_strength_tesla),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"reference_dip_rad", text("reference"), text("rad"),
     text("Dip of the magnetic field below the horizon, when given"),
     text("A usual dip in middle northern latitudes."),
     nullptr, nullptr, defaults + 35, offsetof(hnav_ahrs_options, reference_dip_rad),
     -1.5707963267948966, 1.5707963267948966, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"reference_strength_tolerance", text("reference"), text(""),
     text("Largest relative difference of the field's strength from the given one. A field outside this or the tolerance of the dip may hold a heading; it does not make the heading ready and does not replace the reference"),
     text("The World Magnetic Model is within 1 % outdoors, a calibrated magnetometer within 3 %. Of false fields that turn the heading by more than 5 deg, 1 to 7 % are within this and the tolerance of the dip."),
     nullptr, nullptr, defaults + 36, offsetof(hnav_ahrs_options, reference_strength_tolerance),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"reference_dip_tolerance_rad", text("reference"), text("rad"),
     text("Largest difference of the field's dip from the given one"),
     text("The World Magnetic Model is within 0.5 deg outdoors, horizon and magnetometer within 2 deg."),
     nullptr, nullptr, defaults + 37, offsetof(hnav_ahrs_options, reference_dip_tolerance_rad),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"turning_rad_s", text("reference"), text("rad/s"),
     text("RMS rate above which a field has full weight as evidence"),
     text("At this rate a magnet that moves with the body changes its direction visibly."),
     nullptr, nullptr, defaults + 38, offsetof(hnav_ahrs_options, turning_rad_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"still_weight", text("reference"), text(""),
     text("Weight of evidence below that rate"),
     text("A body at rest measures the field of one place only."),
     nullptr, nullptr, defaults + 39, offsetof(hnav_ahrs_options, still_weight),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"candidate_radius", text("reference"), text(""),
     text("Difference of intensities up to which fields are one candidate, in units of the strength"),
     text("Five times the gate: a candidate is a mean over places."),
     nullptr, nullptr, defaults + 40, offsetof(hnav_ahrs_options, candidate_radius),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"candidate_mean_s", text("reference"), text("s"),
     text("Averaging time of the candidate"),
     text("Longer than a pass near a piece of iron."),
     nullptr, nullptr, defaults + 41, offsetof(hnav_ahrs_options, candidate_mean_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"candidate_first_s", text("reference"), text("s"),
     text("Evidence with which a candidate replaces a reference that has none"),
     text("A false first sample is replaced soon; a single outlier is not enough."),
     nullptr, nullptr, defaults + 42, offsetof(hnav_ahrs_options, candidate_first_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"candidate_share", text("reference"), text(""),
     text("Share of the reference's evidence with which a candidate replaces it"),
     text("A change of place is detected before as much time has passed there; choose more if the place changes often."),
     nullptr, nullptr, defaults + 43, offsetof(hnav_ahrs_options, candidate_share),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"trust_s", text("reference"), text("s"),
     text("Evidence after which a new field no longer turns the heading"),
     text("The heading then has more evidence than the new field."),
     nullptr, nullptr, defaults + 44, offsetof(hnav_ahrs_options, trust_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"turn_min_rad", text("reference"), text("rad"),
     text("Smallest heading error that a new field corrects at once"),
     text("Smaller errors are removed by the usual corrections."),
     nullptr, nullptr, defaults + 45, offsetof(hnav_ahrs_options, turn_min_rad),
     0, 10, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"turn_sigmas", text("reference"), text(""),
     text("The same in sigmas of the heading"),
     text("Within its own sigma the heading is consistent."),
     nullptr, nullptr, defaults + 46, offsetof(hnav_ahrs_options, turn_sigmas),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"turn_sigma_rad", text("reference"), text("rad"),
     text("Standard deviation added to a heading that a new field has turned"),
     text("The new field may be off by several degrees too."),
     nullptr, nullptr, defaults + 47, offsetof(hnav_ahrs_options, turn_sigma_rad),
     0, 10, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gamma_mode", text("robust"), text(""),
     text("Robust law while heading is not ready: off, fixed gamma, relative to the covariance, or by relative entropy"),
     text("It shortens the convergence from a large initial error, independent of the sample rate."),
     gamma_mode_names, gamma_mode_meanings, defaults + 48, offsetof(hnav_ahrs_options, gamma_mode),
     0, 3, 1, 4, HNAV_OPTION_CHOICE, 0, 0, 1},
    {"gamma", text("robust"), text(""),
     text("gamma of mode fixed, raised where infeasible"),
     text("A neutral value: mode fixed has no setting that fits all, so it is to be chosen."),
     nullptr, nullptr, defaults + 49, offsetof(hnav_ahrs_options, gamma),
     0, 1e+12, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"gamma_relative_rate_1_s", text("robust"), text("1/s"),
     text("rate of mode relative: 1/gamma^2 = (1 - exp(-rate T)) / lmax of the horizon's covariance"),
     text("Mild: the velocity model already covers most accelerations."),
     nullptr, nullptr, defaults + 50, offsetof(hnav_ahrs_options, gamma_relative_rate_1_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gamma_kl_rate_1_s", text("robust"), text("1/s"),
     text("rate of mode kl: a correction may spend (rate T)^2 nats of relative entropy"),
     text("As much inflation as mode relative at 1.5, where one direction has most of the covariance."),
     nullptr, nullptr, defaults + 51, offsetof(hnav_ahrs_options, gamma_kl_rate_1_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_mode", text("start"), text(""),
     text("Start: triad (force and field), attitude (start_q_nb) or heading (force and start_heading_rad)"),
     text("It needs nothing but the samples."),
     start_mode_names, start_mode_meanings, defaults + 52, offsetof(hnav_ahrs_options, start_mode),
     0, 2, 1, 3, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"start_samples", text("start"), text(""),
     text("Consecutive samples of each sensor that are averaged for the start. Propagated by the gyroscope they must agree within 25 %, and each force must be within 25 % of gravity; after 1 s any samples are accepted. 1 = the first sample, unchecked"),
     text("The first sample may be wrong, and a second one rarely agrees with it by chance. More samples help only at rest."),
     nullptr, nullptr, defaults + 53, offsetof(hnav_ahrs_options, start_samples),
     1, 1e+06, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"start_field_wait_s", text("start"), text("s"),
     text("Time after which the filter starts with an unknown heading if there is no field (triad)"),
     text("Far longer than the period of any magnetometer."),
     nullptr, nullptr, defaults + 54, offsetof(hnav_ahrs_options, start_field_wait_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_q_nb", text("start"), text(""),
     text("Start attitude, body to navigation, scalar first; normalised on use"),
     text("Level and to the north; only start mode attitude reads it."),
     nullptr, nullptr, defaults + 55, offsetof(hnav_ahrs_options, start_q_nb),
     -2, 2, 4, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_heading_rad", text("start"), text("rad"),
     text("Start heading of body x, true, clockwise from north"),
     text("North; only start mode heading reads it."),
     nullptr, nullptr, defaults + 59, offsetof(hnav_ahrs_options, start_heading_rad),
     -6.2831853071795862, 6.2831853071795862, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"start_gyro_bias_rad_s", text("start"), text("rad/s"),
     text("Start value of the gyro bias"),
     text("Nothing is known of the sensor."),
     nullptr, nullptr, defaults + 60, offsetof(hnav_ahrs_options, start_gyro_bias_rad_s),
     -10, 10, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_sigma_tilt_rad", text("start"), text("rad"),
     text("Standard deviation of the tilt at the start"),
     text("The body may be accelerating by a tenth of gravity."),
     nullptr, nullptr, defaults + 63, offsetof(hnav_ahrs_options, start_sigma_tilt_rad),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_heading_rad", text("start"), text("rad"),
     text("Standard deviation of the heading at the start"),
     text("The field of the first samples may be off by eleven degrees, as indoors."),
     nullptr, nullptr, defaults + 64, offsetof(hnav_ahrs_options, start_sigma_heading_rad),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_bias_rad_s", text("start"), text("rad/s"),
     text("Standard deviation of the gyro bias at the start"),
     text("A usual turn-on bias of half a degree per second."),
     nullptr, nullptr, defaults + 65, offsetof(hnav_ahrs_options, start_sigma_bias_rad_s),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 0},
    {"start_sigma_velocity_m_s", text("start"), text("m/s"),
     text("Standard deviation of the velocity at the start"),
     text("A start in a hand."),
     nullptr, nullptr, defaults + 66, offsetof(hnav_ahrs_options, start_sigma_velocity_m_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_reference", text("start"), text(""),
     text("Standard deviation of the reference at the start and when the gate begins to inflate, in units of the strength"),
     text("Two gates: error of the first field, or of a field that was rejected for long."),
     nullptr, nullptr, defaults + 67, offsetof(hnav_ahrs_options, start_sigma_reference),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_latency_s", text("start"), text("s"),
     text("Standard deviation of the magnetometer's latency at the start"),
     text("Filters and averaging of usual magnetometers delay by 10 to 20 ms, which data sheets do not state."),
     nullptr, nullptr, defaults + 68, offsetof(hnav_ahrs_options, start_sigma_latency_s),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_accel_latency", text("start"), text(""),
     text("Latency of the accelerometer at the start, in its sample intervals"),
     text("Between an instantaneous reading, 0, and the mean of the interval before it, 0.5; motion makes it observable."),
     nullptr, nullptr, defaults + 69, offsetof(hnav_ahrs_options, start_accel_latency),
     -4, 4, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_sigma_accel_latency", text("start"), text(""),
     text("Standard deviation of that latency"),
     text("An instantaneous reading and a mean over the interval are within one sigma; filtered readings are later."),
     nullptr, nullptr, defaults + 70, offsetof(hnav_ahrs_options, start_sigma_accel_latency),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_accel_bias_m_s2", text("start"), text("m/s2"),
     text("Standard deviation of each axis's bias of the accelerometer at the start"),
     text("4 mg, of a calibrated chip; with a wider prior motion is estimated as bias."),
     nullptr, nullptr, defaults + 71, offsetof(hnav_ahrs_options, start_sigma_accel_bias_m_s2),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_gyro_scale", text("start"), text(""),
     text("Standard deviation of the gyro scale factors at the start"),
     text("0.2 %, of a sensor that was calibrated once; uncalibrated ones have up to 0.01. If it is too small, the stated sigma of the tilt of a turning body is too small."),
     nullptr, nullptr, defaults + 72, offsetof(hnav_ahrs_options, start_sigma_gyro_scale),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_gyro_misalignment_rad", text("start"), text("rad"),
     text("Standard deviation of the gyro misalignments at the start"),
     text("A third of the scale factor's, as in most calibrated sensors."),
     nullptr, nullptr, defaults + 73, offsetof(hnav_ahrs_options, start_sigma_gyro_misalignment_rad),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"gyro_range_rad_s", text("fault"), text("rad/s"),
     text("Rate at which an axis of the gyroscope saturates; 0 = detected from repeated values"),
     text("A saturated sensor repeats its limit, unless a low-pass filter follows."),
     nullptr, nullptr, defaults + 74, offsetof(hnav_ahrs_options, gyro_range_rad_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"accel_range_m_s2", text("fault"), text("m/s2"),
     text("Specific force at which an axis of the accelerometer saturates; 0 = detected from repeated values"),
     text("As for the gyroscope."),
     nullptr, nullptr, defaults + 75, offsetof(hnav_ahrs_options, accel_range_m_s2),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag_range_tesla", text("fault"), text("T"),
     text("Field at which an axis of the magnetometer saturates; 0 = unknown"),
     text("Usual ranges are far above the field of the Earth."),
     nullptr, nullptr, defaults + 76, offsetof(hnav_ahrs_options, mag_range_tesla),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"outlier_rate_rad_s", text("fault"), text("rad/s"),
     text("A single rate sample that differs from the last by more than this, and by more than ten usual changes, is rejected; 0 = never"),
     text("No recorded movement changes the rate so much from one sample to the next; half of it turns by two degrees at 100 Hz."),
     nullptr, nullptr, defaults + 77, offsetof(hnav_ahrs_options, outlier_rate_rad_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"outlier_force_m_s2", text("fault"), text("m/s2"),
     text("A single force sample that differs from the last by more than this, and by more than ten usual changes, is rejected; 0 = never"),
     text("Taps on a table change it by so much; a smaller value would reject real motion."),
     nullptr, nullptr, defaults + 78, offsetof(hnav_ahrs_options, outlier_force_m_s2),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"time_jump_limit_s", text("fault"), text("s"),
     text("Time stamps that run back further start a new time base; a single stamp ten times as far ahead is rejected; 0 = never"),
     text("Longer than usual latencies, shorter than usual clock corrections."),
     nullptr, nullptr, defaults + 79, offsetof(hnav_ahrs_options, time_jump_limit_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"ready_tilt_rad", text("ready"), text("rad"),
     text("Tilt is ready when its sigma is below this and the samples have provided the information for it"),
     text("Sufficient for an attitude display or a levelled heading."),
     nullptr, nullptr, defaults + 80, offsetof(hnav_ahrs_options, ready_tilt_rad),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"ready_heading_rad", text("ready"), text("rad"),
     text("Heading is ready when its sigma is below this and the samples have provided the information for it"),
     text("The field in rooms is wrong by a few degrees, so a smaller sigma would be optimistic."),
     nullptr, nullptr, defaults + 81, offsetof(hnav_ahrs_options, ready_heading_rad),
     0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"ready_evidence_s", text("ready"), text("s"),
     text("And the field has agreed with the reference for this time, with less weight at rest"),
     text("A passing disturbance does not agree for so long."),
     nullptr, nullptr, defaults + 82, offsetof(hnav_ahrs_options, ready_evidence_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"ready_undisturbed_s", text("ready"), text("s"),
     text("And nothing has contradicted the reference for this time; once ready, the sigma alone decides"),
     text("With it the first heading_ready is wrong in less than 1 of 100 simulated starts with a passing disturbance."),
     nullptr, nullptr, defaults + 83, offsetof(hnav_ahrs_options, ready_undisturbed_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"navigation_frame", text("frame"), text(""),
     text("Navigation frame of the outputs and of start_q_nb: north-east-down or east-north-up"),
     text("The usual frame of navigation."),
     navigation_frame_names, navigation_frame_meanings, defaults + 84, offsetof(hnav_ahrs_options, navigation_frame),
     0, 1, 1, 2, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"declination_rad", text("frame"), text("rad"),
     text("Magnetic declination: true heading = magnetic heading + declination"),
     text("Unknown place: north is magnetic north until a declination is given."),
     nullptr, nullptr, defaults + 85, offsetof(hnav_ahrs_options, declination_rad),
     -3.1415926535897931, 3.1415926535897931, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"q_body_sensor", text("frame"), text(""),
     text("Mounting: rotates sensor vectors into body axes, scalar first; normalised on use"),
     text("Body axes are the sensor's."),
     nullptr, nullptr, defaults + 86, offsetof(hnav_ahrs_options, q_body_sensor),
     -2, 2, 4, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"solver", text("solver"), text(""),
     text("Integrator between events: SUNDIALS ERKStep, SUNDIALS CVODE Adams, closed form, or the paper's Euler"),
     text("A one-step method: every interval is integrated alike, to solver_rtol."),
     solver_names, solver_meanings, defaults + 90, offsetof(hnav_ahrs_options, solver),
     0, 3, 1, 4, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"solver_rtol", text("solver"), text(""),
     text("Relative tolerance of ERKStep and Adams"),
     text("The integrator's error stays far below that of any sensor."),
     nullptr, nullptr, defaults + 91, offsetof(hnav_ahrs_options, solver_rtol),
     1e-14, 0.01, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"solver_atol", text("solver"), text(""),
     text("Absolute tolerance of ERKStep and Adams, relative to the nominal size of each state"),
     text("As solver_rtol, relative to the size of each state."),
     nullptr, nullptr, defaults + 92, offsetof(hnav_ahrs_options, solver_atol),
     1e-20, 0.01, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"euler_step_s", text("solver"), text("s"),
     text("Sub-step of Euler"),
     text("For comparison; at 1 ms its error is below that of a usual gyroscope."),
     nullptr, nullptr, defaults + 93, offsetof(hnav_ahrs_options, euler_step_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
};

constexpr Preset presets[] = {
    {{"default", text("Real sensors, one setting for all."), 0}, nullptr, 0},
};

} // namespace

const OptionList ahrs_options = {
    "hnav_ahrs_defaults", 2, sizeof(hnav_ahrs_options), rows, 86, presets, 1};

} // namespace hnav
