#include "api/option_table.hpp"

#include <cmath>
#include <cstring>
#include <limits>

namespace hnav {
namespace {

constexpr double pi = 3.14159265358979323846;

const char* const gyro_holds[] = {"forward", "backward"};
const char* const gamma_modes[] = {"off", "fixed", "relative", "kl"};
const char* const adaptations[] = {"off", "paper", "corrected"};
const char* const start_modes[] = {"triad", "attitude", "heading"};
const char* const reference_modes[] = {"learnt", "given"};
const char* const navigation_frames[] = {"ned", "enu"};
const char* const solvers[] = {"erkstep", "adams", "closed_form", "euler"};
const char* const forms[] = {"mdkf", "amdkf", "differenced", "augmented", "plain"};
const char* const noise_scalings[] = {"none", "paper_match", "gated_match", "hmm"};

#define FIELD(name) #name
#define AT(name) offsetof(OPTIONS, name)
#define OPTIONS hnav_hrekf_options
// [min, max]
#define REAL(name, unit, min, max, count, text) \
    { FIELD(name), unit, text, nullptr, AT(name), min, max, count, 0, HNAV_OPTION_REAL, 0 }
// (min, max]
#define ABOVE(name, unit, min, max, count, text) \
    { FIELD(name), unit, text, nullptr, AT(name), min, max, count, 0, HNAV_OPTION_REAL, 1 }
#define INTEGER(name, min, max, text) \
    { FIELD(name), "", text, nullptr, AT(name), min, max, 1, 0, HNAV_OPTION_INTEGER, 0 }
#define CHOICE(name, list, text)                                                                                     \
    {                                                                                                                \
        FIELD(name), "", text, list, AT(name), 0, sizeof list / sizeof *list - 1, 1, sizeof list / sizeof *list,     \
            HNAV_OPTION_CHOICE, 0                                                                                    \
    }

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

#undef OPTIONS
#define OPTIONS hnav_ins_error_options

const hnav_option_info ins_error_rows[] = {
    CHOICE(form, forms, "mdkf and amdkf: the paper's, as printed, one step late; differenced: correct; augmented: optimal; plain: ignores the colour"),
    CHOICE(noise_scaling, noise_scalings, "Adaptation of the noise of each channel (differenced, augmented, plain)"),
    INTEGER(window, 1, 1000, "Steps of the window of amdkf, paper_match and gated_match"),
    ABOVE(gate_alpha, "", 0, 0.5, 1, "gated_match: probability of a false alarm in one test of a window"),
    INTEGER(hmm_levels, 2, 16, "hmm: noise levels, the first of them healthy"),
    REAL(hmm_level_ratio, "", 1.1, 1000, 1, "hmm: ratio of the variances of neighbouring levels"),
    ABOVE(hmm_fault_probability, "", 0, 0.5, 1, "hmm: probability per step that a healthy channel becomes faulty"),
    ABOVE(hmm_recovery_probability, "", 0, 0.5, 1, "hmm: probability per step that a faulty channel recovers"),
    REAL(hmm_drift_probability, "", 0, 0.5, 1, "hmm: probability per step that a faulty channel changes to a neighbouring level"),
    INTEGER(lag, 0, 1, "1: the outputs are of the step before the newest sample, smoothed by it"),
    INTEGER(joseph, 0, 1, "1: covariance in Joseph's form, safe against rounding; 0: short form"),
};

#undef OPTIONS
#undef FIELD
#undef AT
#undef REAL
#undef ABOVE
#undef INTEGER
#undef CHOICE

double component_of(const hnav_option_info& row, const void* options, int i) {
    const char* field = static_cast<const char*>(options) + row.offset;
    if (row.kind == HNAV_OPTION_REAL) {
        double value;
        std::memcpy(&value, field + i * sizeof value, sizeof value);
        return value;
    }
    std::int32_t value;
    std::memcpy(&value, field + i * sizeof value, sizeof value);
    return value;
}

} // namespace

OptionTable hrekf_option_table() { return {hrekf_rows, sizeof hrekf_rows / sizeof *hrekf_rows}; }
OptionTable ins_error_option_table() { return {ins_error_rows, sizeof ins_error_rows / sizeof *ins_error_rows}; }

const hnav_option_info* find_impossible(const OptionTable& table, const void* options, int* component, double* value) {
    for (int k = 0; k < table.count; ++k) {
        const hnav_option_info& row = table.rows[k];
        for (int i = 0; i < row.count; ++i) {
            const double v = component_of(row, options, i);
            const bool inside = v <= row.max && (row.min_is_open ? v > row.min : v >= row.min); // false for NaN
            if (inside) continue;
            *component = i;
            *value = v;
            return &row;
        }
    }
    return nullptr;
}

std::uint64_t fingerprint(const OptionTable& table, const void* options) {
    std::uint64_t hash = 14695981039346656037ull;
    for (int k = 0; k < table.count; ++k)
        for (int i = 0; i < table.rows[k].count; ++i) {
            const double v = component_of(table.rows[k], options, i);
            std::uint64_t word;
            std::memcpy(&word, &v, sizeof word);
            hash = (hash ^ word) * 1099511628211ull;
        }
    return hash;
}

} // namespace hnav
