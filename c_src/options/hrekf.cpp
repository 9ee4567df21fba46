// Made by c_src/options/generate.py from hrekf.toml: change that, then ./run generate.
#include "options/choices.hpp"

#include "hnav/options/hrekf.h"

#include <cmath>
#include <cstddef>

// clang-format off
namespace hnav {
namespace {

const char* const adaptation_names[] = {text("off"), text("paper"), text("corrected")};
const char* const adaptation_meanings[] = {
    text("the bias walk stays as it is set"), text("Q <- (1 - alpha) Q + alpha K nu nu' K' on the bias block, as printed"),
    text("its level, from windows of ten seconds once the start has settled, annealed, bounded"),
};

// Of all rows, one after the other.
constexpr double defaults[] = {
    0.01, 0.0001, 0, 0.115, 0.16, 0, 0.1, 0, 64, 0, 1, 1.5, 0.75, 1, 1, 0, 0.02, 1e-06, 0.01, 0, 2, 1, 0, 0, 0, 0, 0, 0, 0, 0.1,
    0.35, 0.01, 0, 5e-05, 1.0471975511965976, -1, 13.9, 8.8, 0, 0, 0, 8, 100, 1, 0.034906585039886591, 0.087266462599716474, 0, 0,
    1, 0, 0, 0, 0, 1e-08, 1e-08, 0.005,
};

const OptionRow rows[] = {
    {"gyro_noise_rad_per_sqrt_s", text("noise"), text("rad/sqrt(s)"), text("Angle random walk: white noise of the gyroscope"),
    text("Far above the datasheet: it keeps the gain large for motion that the filter does not model."), nullptr, nullptr,
    defaults + 0, offsetof(hnav_hrekf_options, gyro_noise_rad_per_sqrt_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gyro_bias_walk_rad_s_per_sqrt_s", text("noise"), text("rad/s/sqrt(s)"), text("Random walk of the gyro bias"),
    text("Temperature moves the bias more than the walk on the datasheet."), nullptr, nullptr, defaults + 1,
    offsetof(hnav_hrekf_options, gyro_bias_walk_rad_s_per_sqrt_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"quaternion_noise_per_sqrt_s", text("noise"), text("1/sqrt(s)"),
    text("Additional white noise on all four components of the quaternion alike (the paper's L = I)"),
    text("The gyro noise already determines the uncertainty of the attitude; noise on the length of a quaternion has no meaning."),
    nullptr, nullptr, defaults + 2, offsetof(hnav_hrekf_options, quaternion_noise_per_sqrt_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0,
    0, 1},
    {"accel_noise_per_sqrt_hz", text("noise"), text("1/sqrt(Hz)"),
    text("Noise density of the direction of specific force; a sample of an interval T has variance density^2/T"),
    text("It represents accelerations of the body; use the datasheet's value for a body that does not accelerate."),
    nullptr, nullptr, defaults + 3, offsetof(hnav_hrekf_options, accel_noise_per_sqrt_hz), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0,
    0},
    {"mag_noise_per_sqrt_hz", text("noise"), text("1/sqrt(Hz)"),
    text("Noise density of the magnetic field in units of the reference strength"),
    text("It represents the iron of a room; use the datasheet's value for a clean field."), nullptr, nullptr, defaults + 4,
    offsetof(hnav_hrekf_options, mag_noise_per_sqrt_hz), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 0},
    {"gyro_hold", text("timing"), text(""),
    text("forward: a rate holds until the next sample; backward: since the previous sample (C and Co-Simulation)"),
    text("Causal: C, Co-Simulation and Model Exchange agree."), gyro_hold_names, gyro_hold_meanings, defaults + 5,
    offsetof(hnav_hrekf_options, gyro_hold), 0, 2, 1, 3, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"max_interval_s", text("timing"), text("s"),
    text("Longest interval that one sample represents; the first sample of a sensor represents none"),
    text("Ten times the usual interval; a sample after a longer gap contains no more information."), nullptr, nullptr,
    defaults + 6, offsetof(hnav_hrekf_options, max_interval_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"horizon_s", text("timing"), text("s"), text("Largest age of a late sample relative to the newest one"),
    text("Samples are in order; a horizon costs memory and the replay of all events within it."), nullptr, nullptr, defaults + 7,
    offsetof(hnav_hrekf_options, horizon_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"queue_capacity", text("timing"), text(""), text("Number of events that can wait or be within the horizon"),
    text("Enough for an advance after every few dozen samples, and little memory."), nullptr, nullptr, defaults + 8,
    offsetof(hnav_hrekf_options, queue_capacity), 4, 1e+06, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"gamma_mode", text("robust"), text(""),
    text("Robust law: off (HEKF), fixed gamma, relative to the covariance, or by relative entropy"),
    text("Real sensors mostly have outliers, against which gates help; a finite gamma gives outliers more weight."),
    gamma_mode_names, gamma_mode_meanings, defaults + 9, offsetof(hnav_hrekf_options, gamma_mode), 0, 3, 1, 4, HNAV_OPTION_CHOICE,
    0, 0, 0},
    {"gamma", text("robust"), text(""), text("gamma of mode fixed, raised where infeasible"),
    text("A neutral value: mode fixed has no setting that fits all, so it is to be chosen."), nullptr, nullptr, defaults + 10,
    offsetof(hnav_hrekf_options, gamma), 0, 1e+12, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"gamma_relative_rate_1_s", text("robust"), text("1/s"),
    text("rate of mode relative: 1/gamma^2 = (1 - exp(-rate T)) / lmax(L P L')"),
    text("The paper preset's, rounded: 1.5 % of the limit for each correction at 100 Hz."), nullptr, nullptr, defaults + 11,
    offsetof(hnav_hrekf_options, gamma_relative_rate_1_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gamma_kl_rate_1_s", text("robust"), text("1/s"),
    text("rate of mode kl: a correction may spend (rate T)^2 nats of relative entropy"),
    text("As much inflation as mode relative at 1.5, where one direction has most of the covariance."), nullptr, nullptr,
    defaults + 12, offsetof(hnav_hrekf_options, gamma_kl_rate_1_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gamma_weight_attitude", text("robust"), text(""), text("Weight L of the quaternion in the robust law"),
    text("The paper's L = I."), nullptr, nullptr, defaults + 13, offsetof(hnav_hrekf_options, gamma_weight_attitude), 0, 1e+06, 1,
    0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gamma_weight_bias", text("robust"), text(""), text("Weight L of the gyro bias in the robust law"),
    text("The paper's L = I."), nullptr, nullptr, defaults + 14, offsetof(hnav_hrekf_options, gamma_weight_bias), 0, 1e+06, 1, 0,
    HNAV_OPTION_REAL, 0, 0, 1},
    {"adaptation", text("adaptation"), text(""),
    text("Robbins-Monro adaptation of the bias walk: off, as printed in the paper, or corrected (experimental)"),
    text("With the right noise it gains nothing and increases the bias error by up to 10 %; as printed it increases the error."),
    adaptation_names, adaptation_meanings, defaults + 15, offsetof(hnav_hrekf_options, adaptation), 0, 2, 1, 3,
    HNAV_OPTION_CHOICE, 0, 0, 0},
    {"adaptation_gain", text("adaptation"), text(""), text("alpha of the adaptation; when corrected, its lower limit"),
    text("A memory of fifty corrections, or windows of ten seconds when corrected."), nullptr, nullptr, defaults + 16,
    offsetof(hnav_hrekf_options, adaptation_gain), 0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"adaptation_min_rad_s_per_sqrt_s", text("adaptation"), text("rad/s/sqrt(s)"),
    text("The adapted bias walk does not fall below this (corrected)"),
    text("The walk of a very good gyroscope: the bias remains adaptable."), nullptr, nullptr, defaults + 17,
    offsetof(hnav_hrekf_options, adaptation_min_rad_s_per_sqrt_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"adaptation_max_rad_s_per_sqrt_s", text("adaptation"), text("rad/s/sqrt(s)"),
    text("The adapted bias walk does not exceed this (corrected)"),
    text("A hundred times the default walk: beyond it the bias would follow every movement."), nullptr, nullptr, defaults + 18,
    offsetof(hnav_hrekf_options, adaptation_max_rad_s_per_sqrt_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_mode", text("start"), text(""),
    text("Start: triad (force and field), attitude (start_q_nb) or heading (force and start_heading_rad)"),
    text("It needs nothing but the samples."), start_mode_names, start_mode_meanings, defaults + 19,
    offsetof(hnav_hrekf_options, start_mode), 0, 2, 1, 3, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"start_samples", text("start"), text(""),
    text("Consecutive samples of each sensor that are averaged for the start. Propagated by the gyroscope they must agree within 25 %, and each force must be within 25 % of gravity; after 1 s any samples are accepted. 1 = the first sample, unchecked"),
    text("The first sample may be wrong, and a second one rarely agrees with it by chance. More samples help only at rest."),
    nullptr, nullptr, defaults + 20, offsetof(hnav_hrekf_options, start_samples), 1, 1e+06, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"start_q_nb", text("start"), text(""), text("Start attitude, body to navigation, scalar first; normalised on use"),
    text("Level and to the north; only start mode attitude reads it."), nullptr, nullptr, defaults + 21,
    offsetof(hnav_hrekf_options, start_q_nb), -2, 2, 4, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_heading_rad", text("start"), text("rad"), text("Start heading of body x, true, clockwise from north"),
    text("North; only start mode heading reads it."), nullptr, nullptr, defaults + 25,
    offsetof(hnav_hrekf_options, start_heading_rad), -6.2831853071795862, 6.2831853071795862, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"start_gyro_bias_rad_s", text("start"), text("rad/s"), text("Start value of the gyro bias"),
    text("Nothing is known of the sensor."), nullptr, nullptr, defaults + 26, offsetof(hnav_hrekf_options, start_gyro_bias_rad_s),
    -10, 10, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_sigma_tilt_rad", text("start"), text("rad"), text("Standard deviation of the tilt at the start"),
    text("The body may be accelerating by a tenth of gravity."), nullptr, nullptr, defaults + 29,
    offsetof(hnav_hrekf_options, start_sigma_tilt_rad), 0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_heading_rad", text("start"), text("rad"), text("Standard deviation of the heading at the start"),
    text("The field of the first samples may be off by twenty degrees, as indoors."), nullptr, nullptr, defaults + 30,
    offsetof(hnav_hrekf_options, start_sigma_heading_rad), 0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_bias_rad_s", text("start"), text("rad/s"), text("Standard deviation of the gyro bias at the start"),
    text("A usual turn-on bias of half a degree per second."), nullptr, nullptr, defaults + 31,
    offsetof(hnav_hrekf_options, start_sigma_bias_rad_s), 0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 0},
    {"reference_mode", text("reference"), text(""),
    text("Strength and dip of the magnetic field: learnt from the samples of the start, or given"),
    text("It needs nothing but the samples, and indoors no model of the field holds."),
    reference_mode_names, reference_mode_meanings, defaults + 32, offsetof(hnav_hrekf_options, reference_mode), 0, 1, 1, 2,
    HNAV_OPTION_CHOICE, 0, 0, 1},
    {"reference_strength_tesla", text("reference"), text("T"), text("Strength of the magnetic field, when given"),
    text("A usual field of the Earth in middle latitudes."), nullptr, nullptr, defaults + 33,
    offsetof(hnav_hrekf_options, reference_strength_tesla), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"reference_dip_rad", text("reference"), text("rad"), text("Dip of the magnetic field below the horizon, when given"),
    text("A usual dip in middle northern latitudes."), nullptr, nullptr, defaults + 34,
    offsetof(hnav_hrekf_options, reference_dip_rad), -1.5707963267948966, 1.5707963267948966, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel_gate_nis", text("gate"), text(""),
    text("Normalised innovation squared of force beyond which its noise is inflated; 0 = never, -1 = by accel_noise_per_sqrt_hz"),
    text("By the noise: 0.13 x (0.115 / accel_noise_per_sqrt_hz)^2, within 0.13 and 13.9. Accelerations have heavy tails, so the gate lies far inside the default noise, like the threshold of a Huber loss; it begins at the same innovation when less noise is given, up to 99.7 % of chi square with 3 degrees of freedom."),
    nullptr, nullptr, defaults + 35, offsetof(hnav_hrekf_options, accel_gate_nis), -1, 1e+12, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"mag_gate_nis", text("gate"), text(""),
    text("Normalised innovation squared of the field beyond which its noise is inflated; 0 = never"),
    text("99.7 % of chi square with 3 degrees of freedom."), nullptr, nullptr, defaults + 36,
    offsetof(hnav_hrekf_options, mag_gate_nis), 0, 1e+12, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"heading_gate_nis", text("gate"), text(""),
    text("Normalised innovation squared of the heading aid beyond which its noise is inflated; 0 = never"),
    text("99.7 % of chi square with 1 degree of freedom."), nullptr, nullptr, defaults + 37,
    offsetof(hnav_hrekf_options, heading_gate_nis), 0, 1e+12, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro_range_rad_s", text("fault"), text("rad/s"),
    text("Rate at which an axis of the gyroscope saturates; 0 = detected from repeated values"),
    text("A saturated sensor repeats its limit, unless a low-pass filter follows."), nullptr, nullptr, defaults + 38,
    offsetof(hnav_hrekf_options, gyro_range_rad_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel_range_m_s2", text("fault"), text("m/s2"),
    text("Specific force at which an axis of the accelerometer saturates; 0 = detected from repeated values"),
    text("As for the gyroscope."), nullptr, nullptr, defaults + 39, offsetof(hnav_hrekf_options, accel_range_m_s2), 0, 1e+06, 1,
    0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag_range_tesla", text("fault"), text("T"), text("Field at which an axis of the magnetometer saturates; 0 = unknown"),
    text("Usual ranges are far above the field of the Earth."), nullptr, nullptr, defaults + 40,
    offsetof(hnav_hrekf_options, mag_range_tesla), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"outlier_rate_rad_s", text("fault"), text("rad/s"),
    text("A single rate sample that differs from the last by more than this, and by more than ten usual changes, is rejected; 0 = never"),
    text("No recorded movement changes the rate so much from one sample to the next; half of it turns by two degrees at 100 Hz."),
    nullptr, nullptr, defaults + 41, offsetof(hnav_hrekf_options, outlier_rate_rad_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"outlier_force_m_s2", text("fault"), text("m/s2"),
    text("A single force sample that differs from the last by more than this, and by more than ten usual changes, is rejected; 0 = never"),
    text("Taps on a table change it by so much; a smaller value would reject real motion."), nullptr, nullptr, defaults + 42,
    offsetof(hnav_hrekf_options, outlier_force_m_s2), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"time_jump_limit_s", text("fault"), text("s"),
    text("Time stamps that run back further start a new time base; a single stamp ten times as far ahead is rejected; 0 = never"),
    text("Longer than usual latencies, shorter than usual clock corrections."), nullptr, nullptr, defaults + 43,
    offsetof(hnav_hrekf_options, time_jump_limit_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"ready_tilt_rad", text("ready"), text("rad"),
    text("Tilt is ready when its sigma is below this and the samples have provided the information for it"),
    text("Sufficient for an attitude display or a levelled heading."), nullptr, nullptr, defaults + 44,
    offsetof(hnav_hrekf_options, ready_tilt_rad), 0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"ready_heading_rad", text("ready"), text("rad"),
    text("Heading is ready when its sigma is below this and the samples have provided the information for it"),
    text("The field in rooms is wrong by a few degrees, so a smaller sigma would be optimistic."), nullptr, nullptr,
    defaults + 45, offsetof(hnav_hrekf_options, ready_heading_rad), 0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"navigation_frame", text("frame"), text(""),
    text("Navigation frame of the outputs and of start_q_nb: north-east-down or east-north-up"),
    text("The usual frame of navigation."), navigation_frame_names, navigation_frame_meanings, defaults + 46,
    offsetof(hnav_hrekf_options, navigation_frame), 0, 1, 1, 2, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"declination_rad", text("frame"), text("rad"), text("Magnetic declination: true heading = magnetic heading + declination"),
    text("Unknown place: north is magnetic north until a declination is given."), nullptr, nullptr, defaults + 47,
    offsetof(hnav_hrekf_options, declination_rad), -3.1415926535897931, 3.1415926535897931, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"q_body_sensor", text("frame"), text(""),
    text("Mounting: rotates sensor vectors into body axes, scalar first; normalised on use"), text("Body axes are the sensor's."),
    nullptr, nullptr, defaults + 48, offsetof(hnav_hrekf_options, q_body_sensor), -2, 2, 4, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"solver", text("solver"), text(""),
    text("Integrator between events: SUNDIALS ERKStep, SUNDIALS CVODE Adams, closed form, or the paper's Euler"),
    text("A one-step method: every interval is integrated alike, to solver_rtol."), solver_names, solver_meanings, defaults + 52,
    offsetof(hnav_hrekf_options, solver), 0, 3, 1, 4, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"solver_rtol", text("solver"), text(""), text("Relative tolerance of ERKStep and Adams"),
    text("The integrator's error stays far below that of any sensor."), nullptr, nullptr, defaults + 53,
    offsetof(hnav_hrekf_options, solver_rtol), 1e-14, 0.01, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"solver_atol", text("solver"), text(""),
    text("Absolute tolerance of ERKStep and Adams, relative to the nominal size of each state"),
    text("As solver_rtol, relative to the size of each state."), nullptr, nullptr, defaults + 54,
    offsetof(hnav_hrekf_options, solver_atol), 1e-20, 0.01, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"euler_step_s", text("solver"), text("s"), text("Sub-step of Euler"),
    text("The paper's two steps for each sample at 100 Hz."), nullptr, nullptr, defaults + 55,
    offsetof(hnav_hrekf_options, euler_step_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
};

// Row, component, value.
constexpr PresetValue paper_values[] = {
    {0, 0, 0}, // gyro_noise_rad_per_sqrt_s
    {1, 0, 0.001}, // gyro_bias_walk_rad_s_per_sqrt_s
    {2, 0, 0.001}, // quaternion_noise_per_sqrt_s
    {3, 0, 0.01}, // accel_noise_per_sqrt_hz
    {4, 0, 0.01}, // mag_noise_per_sqrt_hz
    {9, 0, 2}, // gamma_mode
    {11, 0, 1.5113637810048171}, // gamma_relative_rate_1_s
    {16, 0, 0.5}, // adaptation_gain
    {20, 0, 1}, // start_samples
    {24, 0, 0.002}, // start_sigma_tilt_rad
    {25, 0, 0.002}, // start_sigma_heading_rad
    {26, 0, 0.001}, // start_sigma_bias_rad_s
    {30, 0, 0}, // accel_gate_nis
    {31, 0, 0}, // mag_gate_nis
    {32, 0, 0}, // heading_gate_nis
    {36, 0, 0}, // outlier_rate_rad_s
    {37, 0, 0}, // outlier_force_m_s2
    {44, 0, 3}, // solver
};

constexpr Preset presets[] = {
    {{"default", text("Real sensors: one setting for all, found on recordings of the BROAD benchmark."), 0}, nullptr, 0},
    {{"paper", text("The paper's: Q = 1e-6 I7, R = 1e-2 I6 at 100 Hz, P0 = 1e-6 I7, L = I, two Euler steps per sample. P0 and the rate of gamma are fitted: with them the ratios of the paper's Table 1 come back."), 1}, paper_values, 18},
};

} // namespace

const OptionList hrekf_options = {
    "hnav_hrekf_defaults", 1, sizeof(hnav_hrekf_options), rows, 48, presets, 2};

} // namespace hnav
