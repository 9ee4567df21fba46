// The options of the paper's filter as rows.
#define HNAV_OPTIONS hnav_hrekf_options
#include "api/option_rows.hpp"

namespace hnav {
namespace {

const hnav_option_info hrekf_rows[] = {
    REAL(gyro_noise_rad_per_sqrt_s, "rad/sqrt(s)", 0, 1e3, 1, "Angle random walk: white noise of the gyroscope"),
    REAL(gyro_bias_walk_rad_s_per_sqrt_s, "rad/s/sqrt(s)", 0, 1e3, 1, "Random walk of the gyro bias"),
    REAL(quaternion_noise_per_sqrt_s, "1/sqrt(s)", 0, 1e3, 1,
         "Additional white noise on all four components of the quaternion alike (the paper's L = I)"),
    ABOVE(accel_noise_per_sqrt_hz, "1/sqrt(Hz)", 0, 1e6, 1,
          "Noise density of the direction of specific force; a sample that stands for an interval T has variance density^2/T"),
    ABOVE(mag_noise_per_sqrt_hz, "1/sqrt(Hz)", 0, 1e6, 1,
          "Noise density of the magnetic field in units of the reference strength"),
    ABOVE(interval_limit_s, "s", 0, 1e6, 1,
          "Longest interval that one sample may stand for; the first sample of a sensor stands for none"),
    CHOICE(gyro_hold, gyro_holds, "forward: a rate acts until the next sample; backward: since the one before (C and Co-Simulation)"),
    CHOICE(gamma_mode, gamma_modes, "Robust law: off (HEKF), fixed gamma, relative to the covariance, or by relative entropy"),
    ABOVE(gamma, "", 0, 1e12, 1, "gamma of mode fixed, raised where infeasible"),
    REAL(gamma_relative_rate_1_s, "1/s", 0, 1e6, 1, "rate of mode relative: 1/gamma^2 = (1 - exp(-rate T)) / lmax(L P L')"),
    REAL(gamma_kl_rate_1_s, "1/s", 0, 1e6, 1, "Tolerance of mode kl: relative entropy per second, in nats"),
    REAL(gamma_weight_attitude, "", 0, 1e6, 1, "Weight L of the quaternion in the robust law"),
    REAL(gamma_weight_bias, "", 0, 1e6, 1, "Weight L of the gyro bias in the robust law"),
    CHOICE(adaptation, adaptations, "Robbins-Monro adaptation of the bias walk: off, as printed in the paper, or corrected"),
    REAL(adaptation_gain, "", 0, 1, 1, "alpha of the adaptation; when corrected, the floor of the annealed alpha"),
    REAL(adaptation_floor_rad_s_per_sqrt_s, "rad/s/sqrt(s)", 0, 1e3, 1, "The adapted bias walk does not fall below this (corrected)"),
    REAL(adaptation_cap_rad_s_per_sqrt_s, "rad/s/sqrt(s)", 0, 1e3, 1, "The adapted bias walk does not exceed this (corrected)"),
    CHOICE(start_mode, start_modes, "Start: triad (force and field), attitude (start_q_nb) or heading (force and start_heading_rad)"),
    INTEGER(start_samples, 1, 1e6, "Samples of each sensor averaged for the start"),
    REAL(start_q_nb, "", -2, 2, 4, "Attitude to start from, body to navigation, scalar first; normalised on use"),
    REAL(start_heading_rad, "rad", -2 * pi, 2 * pi, 1, "True heading of body x to start from, clockwise from north"),
    REAL(start_gyro_bias_rad_s, "rad/s", -10, 10, 3, "Gyro bias to start from"),
    ABOVE(start_sigma_tilt_rad, "rad", 0, 10, 1, "Standard deviation of the tilt at the start"),
    ABOVE(start_sigma_heading_rad, "rad", 0, 10, 1, "Standard deviation of the heading at the start"),
    ABOVE(start_sigma_bias_rad_s, "rad/s", 0, 10, 1, "Standard deviation of the gyro bias at the start"),
    CHOICE(reference_mode, reference_modes, "Strength and dip of the magnetic field: learnt from the samples of the start, or given"),
    ABOVE(reference_strength_tesla, "T", 0, 1e6, 1, "Strength of the magnetic field, when given"),
    REAL(reference_dip_rad, "rad", -pi / 2, pi / 2, 1, "Dip of the magnetic field below the horizon, when given"),
    REAL(accel_gate_nis, "", 0, 1e12, 1, "Normalised innovation squared of force beyond which its noise is inflated; 0 = never"),
    REAL(mag_gate_nis, "", 0, 1e12, 1, "Normalised innovation squared of the field beyond which its noise is inflated; 0 = never"),
    REAL(heading_gate_nis, "", 0, 1e12, 1, "Normalised innovation squared of the heading aid beyond which its noise is inflated; 0 = never"),
    ABOVE(ready_tilt_rad, "rad", 0, 10, 1, "Tilt is ready when its sigma is below this and as much information has been gained"),
    ABOVE(ready_heading_rad, "rad", 0, 10, 1, "Heading is ready when its sigma is below this and as much information has been gained"),
    CHOICE(navigation_frame, navigation_frames, "Navigation frame of the outputs and of start_q_nb: north-east-down or east-north-up"),
    REAL(declination_rad, "rad", -pi, pi, 1, "Magnetic declination: true heading = magnetic heading + declination"),
    REAL(q_body_sensor, "", -2, 2, 4, "Mounting: turns sensor vectors into the body frame, scalar first; normalised on use"),
    CHOICE(solver, solvers, "Integrator between events: SUNDIALS ERKStep, SUNDIALS CVODE Adams, closed form, or the paper's Euler"),
    REAL(solver_rtol, "", 1e-14, 1e-2, 1, "Relative tolerance of ERKStep and Adams"),
    REAL(solver_atol, "", 1e-20, 1e-2, 1, "Absolute tolerance of ERKStep and Adams, relative to the nominal size of each state"),
    ABOVE(euler_step_s, "s", 0, 1e3, 1, "Sub-step of Euler"),
    REAL(horizon_s, "s", 0, 1e3, 1, "How much older than the newest used sample a sample may be"),
    INTEGER(queue_capacity, 4, 1e6, "Instants that may wait or lie within the horizon"),
};

} // namespace

OptionTable hrekf_option_table() { return {hrekf_rows, sizeof hrekf_rows / sizeof *hrekf_rows}; }

} // namespace hnav
