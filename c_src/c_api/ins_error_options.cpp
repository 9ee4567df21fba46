// The options of the filter for coloured INS errors as rows.
#define HNAV_OPTIONS hnav_ins_error_options
#include "c_api/option_rows.hpp"

namespace hnav {
namespace {

const char* const forms[] = {"mdkf", "amdkf", "differenced", "augmented", "plain"};
const char* const noise_scalings[] = {"none", "paper_match", "gated_match", "hmm"};

const hnav_option_info ins_error_rows[] = {
    CHOICE(
        form, forms,
        "mdkf and amdkf: the paper's, as printed, one step late; differenced: correct; augmented: optimal; plain: ignores the colour"),
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

} // namespace

OptionTable ins_error_option_table() { return {ins_error_rows, sizeof ins_error_rows / sizeof *ins_error_rows}; }

} // namespace hnav
