// The options of the paper's filter as rows.
#define HNAV_OPTIONS hnav_hrekf_options
#include "c_api/option_rows.hpp"

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
    CHOICE(gyro_hold, gyro_holds,
           "forward: a rate acts until the next sample; backward: since the one before (C and Co-Simulation)"),
    CHOICE(gamma_mode, gamma_modes, "Robust law: off (HEKF), fixed gamma, relative to the covariance, or by relative entropy"),
    ABOVE(gamma, "", 0, 1e12, 1, "gamma of mode fixed, raised where infeasible"),
    REAL(gamma_relative_rate_1_s, "1/s", 0, 1e6, 1, "rate of mode relative: 1/gamma^2 = (1 - exp(-rate T)) / lmax(L P L')"),
    REAL(gamma_kl_rate_1_s, "1/s", 0, 1e6, 1, "Tolerance of mode kl: relative entropy per second, in nats"),
    REAL(gamma_weight_attitude, "", 0, 1e6, 1, "Weight L of the quaternion in the robust law"),
    REAL(gamma_weight_bias, "", 0, 1e6, 1, "Weight L of the gyro bias in the robust law"),
    CHOICE(adaptation, adaptations, "Robbins-Monro adaptation of the bias walk: off, as printed in the paper, or corrected"),
    REAL(adaptation_gain, "", 0, 1, 1, "alpha of the adaptation; when corrected, the floor of the annealed alpha"),
    REAL(adaptation_floor_rad_s_per_sqrt_s, "rad/s/sqrt(s)", 0, 1e3, 1,
         "The adapted bias walk does not fall below this (corrected)"),
    REAL(adaptation_cap_rad_s_per_sqrt_s, "rad/s/sqrt(s)", 0, 1e3, 1, "The adapted bias walk does not exceed this (corrected)"),
    CHOICE(start_mode, start_modes,
           "Start: triad (force and field), attitude (start_q_nb) or heading (force and start_heading_rad)"),
    INTEGER(start_samples, 1, 1e6, "Samples of each sensor averaged for the start"),
    START_ROWS,
    REFERENCE_ROWS,
    REAL(accel_gate_nis, "", 0, 1e12, 1, "Normalised innovation squared of force beyond which its noise is inflated; 0 = never"),
    REAL(mag_gate_nis, "", 0, 1e12, 1,
         "Normalised innovation squared of the field beyond which its noise is inflated; 0 = never"),
    REAL(heading_gate_nis, "", 0, 1e12, 1,
         "Normalised innovation squared of the heading aid beyond which its noise is inflated; 0 = never"),
    ABOVE(ready_tilt_rad, "rad", 0, 10, 1, "Tilt is ready when its sigma is below this and as much information has been gained"),
    ABOVE(ready_heading_rad, "rad", 0, 10, 1,
          "Heading is ready when its sigma is below this and as much information has been gained"),
    FRAME_ROWS,
    SOLVER_ROWS,
};

} // namespace

OptionTable hrekf_option_table() { return {hrekf_rows, sizeof hrekf_rows / sizeof *hrekf_rows}; }

} // namespace hnav
