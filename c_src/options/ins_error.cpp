// Made by c_src/options/generate.py from ins_error.toml: change that, then ./run generate.
#include "options/lists.hpp"

#include "hnav/options/ins_error.h"

#include <cmath>
#include <cstddef>

// clang-format off
namespace hnav {
namespace {

const char* const form_names[] = {text("mdkf"), text("amdkf"), text("differenced"), text("augmented"), text("plain")};
const char* const form_meanings[] = {
    text("measurement differencing as printed; its estimate is one step late"),
    text("the same with covariance matching over a window, as printed"),
    text("differencing with the correlation where it belongs; exact when v = 0"), text("lambda as states: optimal"),
    text("Kalman filter that takes lambda for white noise of covariance Lambda0"),
};
const char* const noise_scaling_names[] = {text("none"), text("paper_match"), text("gated_match"), text("hmm"), text("joint")};
const char* const noise_scaling_meanings[] = {
    text("Qv as given"), text("innovation covariance matching over a window, never below 1"),
    text("the same behind a chi-square test of conditional innovations"), text("a hidden Markov chain over noise levels"),
    text("joint hypotheses: noise, jumps of the error, a livelier process"),
};

// Of all rows, one after the other.
constexpr double defaults[] = {
    3, 0, 1, 4, 20, 0.001, 5, 4, 0.001, 0.002, 0.01, 0.0001, 0.002, 0.025, 0.00015, 10, 0.003, 0.004, 0.001,
};

const OptionRow rows[] = {
    {"form", text("form"), text(""),
    text("mdkf and amdkf: the paper's, as printed, one step late; differenced: correct; augmented: optimal; plain: ignores the colour"),
    text("Optimal whatever v is, and it estimates lambda too."), form_names, form_meanings, defaults + 0,
    offsetof(hnav_ins_error_options, form), 0, 4, 1, 5, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"lag", text("form"), text(""), text("1: the outputs are of the step before the newest sample, smoothed by it"),
    text("Outputs are of now; a lag of one step sees one sample more."), nullptr, nullptr, defaults + 1,
    offsetof(hnav_ins_error_options, lag), 0, 1, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
    {"joseph", text("form"), text(""), text("1: covariance in Joseph's form, safe against rounding; 0: short form"),
    text("Safe; the short form saves little."), nullptr, nullptr, defaults + 2, offsetof(hnav_ins_error_options, joseph), 0, 1, 1,
    0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"noise_scaling", text("scaling"), text(""),
    text("Adaptation of the noise of each channel (differenced, augmented, plain); joint needs augmented, the others take it for hmm"),
    text("It distinguishes a faulty channel from a process livelier than its model, which hmm blames on the channels."),
    noise_scaling_names, noise_scaling_meanings, defaults + 3, offsetof(hnav_ins_error_options, noise_scaling), 0, 4, 1, 5,
    HNAV_OPTION_CHOICE, 0, 0, 0},
    {"window", text("scaling"), text(""), text("Steps of the window of amdkf, paper_match and gated_match"),
    text("A variance known to a third, and a fault that shows within two seconds at 10 Hz."), nullptr, nullptr, defaults + 4,
    offsetof(hnav_ins_error_options, window), 1, 1000, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
    {"gate_alpha", text("scaling"), text(""), text("gated_match: probability of a false alarm in one test of a window"),
    text("One false alarm in a thousand steps."), nullptr, nullptr, defaults + 5, offsetof(hnav_ins_error_options, gate_alpha), 0,
    0.5, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"hmm_levels", text("scaling"), text(""), text("hmm, joint: noise levels, the first of them healthy"),
    text("Variances of 1, 4, 16, 64, 256: noise of up to sixteen times the healthy sigma."), nullptr, nullptr, defaults + 6,
    offsetof(hnav_ins_error_options, hmm_levels), 2, 16, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"hmm_level_ratio", text("scaling"), text(""), text("hmm, joint: ratio of the variances of neighbouring levels"),
    text("Steps of two in sigma: a few samples cannot distinguish nearer levels."), nullptr, nullptr, defaults + 7,
    offsetof(hnav_ins_error_options, hmm_level_ratio), 1.1, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"hmm_fault_probability", text("scaling"), text(""), text("hmm: probability per step that a healthy channel becomes faulty"),
    text("Faults are rare: one in a thousand steps."), nullptr, nullptr, defaults + 8,
    offsetof(hnav_ins_error_options, hmm_fault_probability), 0, 0.5, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"hmm_recovery_probability", text("scaling"), text(""), text("hmm: probability per step that a faulty channel recovers"),
    text("Faults last: some hundred steps."), nullptr, nullptr, defaults + 9,
    offsetof(hnav_ins_error_options, hmm_recovery_probability), 0, 0.5, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"hmm_drift_probability", text("scaling"), text(""),
    text("hmm: probability per step that a faulty channel changes to a neighbouring level"),
    text("A fault grows or fades within a hundred steps."), nullptr, nullptr, defaults + 10,
    offsetof(hnav_ins_error_options, hmm_drift_probability), 0, 0.5, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"joint_fault_probability", text("scaling"), text(""),
    text("joint: probability per step that the noise of a healthy channel grows and stays"),
    text("Below that of the process: channels suspect together then mean the process."), nullptr, nullptr, defaults + 11,
    offsetof(hnav_ins_error_options, joint_fault_probability), 0, 0.1, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"joint_recovery_probability", text("scaling"), text(""), text("joint: probability per step that a faulty channel recovers"),
    text("That of hmm: faults last some hundred steps. At 5e-4 an alarm ends 0.3 s later than that of hmm, at 3e-3 NEES grows."),
    nullptr, nullptr, defaults + 12, offsetof(hnav_ins_error_options, joint_recovery_probability), 0, 0.1, 1, 0, HNAV_OPTION_REAL,
    1, 0, 1},
    {"joint_outlier_probability", text("scaling"), text(""),
    text("joint: probability that one sample of a healthy channel is an outlier"),
    text("A sample far off is no fault that lasts: a channel with 5 % outliers stays healthy."), nullptr, nullptr, defaults + 13,
    offsetof(hnav_ins_error_options, joint_outlier_probability), 0, 0.1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"joint_bias_probability", text("scaling"), text(""),
    text("joint: probability per step that the coloured error of a channel jumps"),
    text("A jump that stays is certain after some five samples."), nullptr, nullptr, defaults + 14,
    offsetof(hnav_ins_error_options, joint_bias_probability), 0, 0.1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"joint_bias_sigma", text("scaling"), text(""),
    text("joint: standard deviation of such a jump, in sigma of the white noise of the channel"),
    text("Smaller jumps are taken for a livelier coloured error; larger ones are learned as well."), nullptr, nullptr,
    defaults + 15, offsetof(hnav_ins_error_options, joint_bias_sigma), 0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"joint_process_probability", text("scaling"), text(""),
    text("joint: probability per step that state or coloured errors become livelier than Qw and QU"),
    text("Above that of a fault: a model that is wrong is more common than channels that fail together."), nullptr, nullptr,
    defaults + 16, offsetof(hnav_ins_error_options, joint_process_probability), 0, 0.1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"joint_process_recovery_probability", text("scaling"), text(""),
    text("joint: probability per step that they become those of the model again"),
    text("A model that was wrong for a while stays so."), nullptr, nullptr, defaults + 17,
    offsetof(hnav_ins_error_options, joint_process_recovery_probability), 0, 0.1, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"joint_common_probability", text("scaling"), text(""),
    text("joint: probability per step that noise begins in many channels at once"),
    text("Power supply and vibration reach all channels."), nullptr, nullptr, defaults + 18,
    offsetof(hnav_ins_error_options, joint_common_probability), 0, 0.1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
};

constexpr Preset presets[] = {
    {{"default", text("The defaults."), 0}, nullptr, 0},
};

} // namespace

const OptionList ins_error_options = {
    "hnav_ins_error_defaults", 3, sizeof(hnav_ins_error_options), rows, 19, presets, 1};

} // namespace hnav
