// The options of the AHRS as rows.
#define HNAV_OPTIONS hnav_ahrs_options
#include "c_api/option_rows.hpp"

namespace hnav {
namespace {

const hnav_option_info ahrs_rows[] = {
    REAL(gyro_noise_rad_per_sqrt_s, "rad/sqrt(s)", 0, 1e3, 1, "Angle random walk: white noise of the gyroscope"),
    REAL(gyro_rate_noise_sqrt_s, "sqrt(s)", 0, 1e3, 1, "Noise of the gyroscope that grows with the rate: density = this x |rate|"),
    REAL(gyro_bias_walk_rad_s_per_sqrt_s, "rad/s/sqrt(s)", 0, 1e3, 1, "Random walk of the gyro bias"),
    ABOVE(velocity_noise_m_s_per_sqrt_hz, "m/s/sqrt(Hz)", 0, 1e6, 1,
          "How far the velocity is held to be from zero: the bound by which the accelerometer tells the horizon"),
    REAL(unseen_acceleration_m_s2, "m/s2", 0, 1e6, 1, "Acceleration that may go unseen while force samples are missing"),
    REAL(unseen_turn_factor, "", 0, 1e6, 1, "Angular acceleration while samples of the gyroscope are missing, in units of its running root mean square"),
    ABOVE(mag_azimuth_noise_per_sqrt_hz, "1/sqrt(Hz)", 0, 1e6, 1, "Noise density of the field across the reference, in units of its strength"),
    ABOVE(mag_intensity_noise_per_sqrt_hz, "1/sqrt(Hz)", 0, 1e6, 1, "Noise density of horizontal and vertical intensity, in units of the strength"),
    ABOVE(mag_rest_factor, "", 0, 1e6, 1, "Factor of the field's variances at rest, where distortions do not average out"),
    REAL(reference_walk_per_sqrt_s, "1/sqrt(s)", 0, 1e3, 1, "Random walk of the reference field, in units of the strength"),
    ABOVE(correction_interval_s, "s", 0, 1e3, 1, "Samples are gathered and corrected so often, at the sample nearest; heading aids at once"),
    ABOVE(interval_limit_s, "s", 0, 1e6, 1, "Longest interval that one sample may stand for; the first sample of a sensor stands for none"),
    REAL(rest_rate_rad_s, "rad/s", 0, 1e3, 1, "Rest: deviation of the rate from its running mean"),
    REAL(rest_force_m_s2, "m/s2", 0, 1e6, 1, "Rest: deviation of the specific force from its running mean"),
    REAL(rest_mean_rate_rad_s, "rad/s", 0, 1e3, 1, "Rest: mean rate of each axis, as far as it can be a bias"),
    REAL(rest_duration_s, "s", 0, 1e6, 1, "Rest: within the thresholds for so long"),
    ABOVE(rest_filter_s, "s", 0, 1e6, 1, "Rest: time constant of the running means"),
    ABOVE(rest_bias_noise_rad_s_per_sqrt_hz, "rad/s/sqrt(Hz)", 0, 1e3, 1, "Noise density of the mean rate at rest as a measurement of the bias"),
    ABOVE(mag_gate, "", 0, 1e6, 1, "Distance of the field's intensities from the reference beyond which it is refused, in units of the strength"),
    REAL(mag_gate_longest_s, "s", 0, 1e6, 1, "A field is refused no longer than this"),
    REAL(mag_gate_share, "", 0, 1e6, 1, "A field is refused no longer than this times the time for which the reference has served"),
    REAL(turning_rad_s, "rad/s", 0, 1e3, 1, "Root mean square rate above which a field counts fully as evidence"),
    REAL(still_weight, "", 0, 1, 1, "Weight of evidence below that rate"),
    ABOVE(candidate_radius, "", 0, 1e6, 1, "Fields whose intensities lie so close are one candidate, in units of the strength"),
    ABOVE(candidate_mean_s, "s", 0, 1e6, 1, "The candidate is a mean over this time"),
    REAL(candidate_first_s, "s", 0, 1e6, 1, "Evidence with which a candidate replaces a reference that has none"),
    REAL(candidate_share, "", 0, 1e6, 1, "Share of the reference's evidence with which a candidate replaces it"),
    ABOVE(trust_s, "s", 0, 1e6, 1, "Evidence after which a new field no longer turns the heading"),
    REAL(turn_least_rad, "rad", 0, 10, 1, "Least error of the heading that a new field corrects at once"),
    REAL(turn_sigmas, "", 0, 1e3, 1, "The same in sigmas of the heading"),
    REAL(turn_sigma_rad, "rad", 0, 10, 1, "Standard deviation added to a heading that a new field has turned"),
    CHOICE(gyro_hold, gyro_holds, "forward: a rate acts until the next sample; backward: since the one before"),
    CHOICE(gamma_mode, gamma_modes, "Robust law while heading is not ready: off, fixed gamma, relative to the covariance, or by relative entropy"),
    ABOVE(gamma, "", 0, 1e12, 1, "gamma of mode fixed, raised where infeasible"),
    REAL(gamma_relative_rate_1_s, "1/s", 0, 1e6, 1, "rate of mode relative: 1/gamma^2 = (1 - exp(-rate T)) / lmax of the horizon's covariance"),
    REAL(gamma_kl_rate_1_s, "1/s", 0, 1e6, 1, "Tolerance of mode kl: relative entropy per second, in nats"),
    CHOICE(start_mode, start_modes, "Start: triad (force and field), attitude (start_q_nb) or heading (force and start_heading_rad)"),
    INTEGER(start_samples, 1, 1e6, "Samples of each sensor averaged for the start"),
    REAL(start_field_wait_s, "s", 0, 1e6, 1, "Start level with an unknown heading if no field has come by then (triad)"),
    START_ROWS,
    ABOVE(start_sigma_velocity_m_s, "m/s", 0, 1e3, 1, "Standard deviation of the velocity at the start"),
    ABOVE(start_sigma_reference, "", 0, 10, 1, "Standard deviation of the reference at the start and when the gate gives in, in units of the strength"),
    ABOVE(start_sigma_latency_s, "s", 0, 10, 1, "Standard deviation of the magnetometer's latency at the start"),
    ABOVE(start_sigma_gyro_scale, "", 0, 10, 1, "Standard deviation of the gyro scale factors at the start"),
    ABOVE(start_sigma_gyro_misalignment_rad, "rad", 0, 10, 1, "Standard deviation of the gyro misalignments at the start"),
    REFERENCE_ROWS,
    REAL(heading_gate_nis, "", 0, 1e12, 1, "Normalised innovation squared of the heading aid beyond which its noise is inflated; 0 = never"),
    ABOVE(ready_tilt_rad, "rad", 0, 10, 1, "Tilt is ready when its sigma is below this and as much information has been gained"),
    ABOVE(ready_heading_rad, "rad", 0, 10, 1, "Heading is ready when its sigma is below this and as much information has been gained"),
    REAL(ready_evidence_s, "s", 0, 1e6, 1, "And the field has agreed with the reference for so long, counted less at rest"),
    REAL(ready_calm_s, "s", 0, 1e6, 1, "And nothing has spoken against the reference for so long; once ready, sigma alone decides"),
    FRAME_ROWS,
    REAL(output_latency_s, "s", -1, 1, 1, "Attitude is shown as it will be this much later at the present rate"),
    SOLVER_ROWS,
};

} // namespace

OptionTable ahrs_option_table() { return {ahrs_rows, sizeof ahrs_rows / sizeof *ahrs_rows}; }

} // namespace hnav
