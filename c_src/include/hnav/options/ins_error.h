/* Made by c_src/options/generate.py from ins_error.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_INS_ERROR_H
#define HNAV_OPTIONS_INS_ERROR_H

#include <stddef.h>
#include <stdint.h>

/* How the filter treats the correlation of the measurement errors. */
typedef enum hnav_ins_error_form {
    HNAV_INS_ERROR_MDKF = 0,        /* measurement differencing as printed; its estimate is one step late */
    HNAV_INS_ERROR_AMDKF = 1,       /* the same with covariance matching over a window, as printed */
    HNAV_INS_ERROR_DIFFERENCED = 2, /* differencing with the correlation where it belongs; exact when v = 0 */
    HNAV_INS_ERROR_AUGMENTED = 3,   /* lambda as states: optimal */
    HNAV_INS_ERROR_PLAIN = 4        /* Kalman filter that takes lambda for white noise of covariance Lambda0 */
} hnav_ins_error_form;

/* Adaptation of Qv by channel. */
typedef enum hnav_noise_scaling {
    HNAV_NOISE_SCALING_NONE = 0,        /* Qv as given */
    HNAV_NOISE_SCALING_PAPER_MATCH = 1, /* innovation covariance matching over a window, never below 1 */
    HNAV_NOISE_SCALING_GATED_MATCH = 2, /* the same behind a chi-square test of conditional innovations */
    HNAV_NOISE_SCALING_HMM = 3,         /* a hidden Markov chain over noise levels */
    HNAV_NOISE_SCALING_JOINT = 4        /* joint hypotheses: noise, jumps of the error, a livelier process */
} hnav_noise_scaling;

/* Options of the filter for time-correlated measurement errors. The defaults are the form that is optimal and the noise
 * scaling that was nowhere far from the best of nine in simulated flights with every kind of fault.
 * Make them with hnav_ins_error_defaults, then change what you need; hnav_option("ins_error", i) states all this at run
 * time. */
typedef struct hnav_ins_error_options {
    size_t size;    /* of this struct in bytes; set by hnav_ins_error_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    /* ------------------------ form
     * The equations of the filter. */

    /* mdkf and amdkf: the paper's, as printed, one step late; differenced: correct; augmented: optimal; plain: ignores the
     * colour.
     * hnav_ins_error_form, default augmented. Optimal whatever v is, and it estimates lambda too. */
    int32_t form;
    /* 1: the outputs are of the step before the newest sample, smoothed by it.
     * [0, 1], default 0. Outputs are of now; a lag of one step sees one sample more. */
    int32_t lag;
    /* 1: covariance in Joseph's form, safe against rounding; 0: short form.
     * [0, 1], default 1. Safe; the short form saves little. */
    int32_t joseph;

    /* ------------------------ scaling
     * Adaptation of the white noise, channel by channel; not for the printed forms mdkf and amdkf. */

    /* Adaptation of the noise of each channel (differenced, augmented, plain); joint needs augmented, the others take it
     * for hmm.
     * hnav_noise_scaling, default joint. It distinguishes a faulty channel from a process livelier than its model, which
     * hmm blames on the channels. */
    int32_t noise_scaling;
    /* Steps of the window of amdkf, paper_match and gated_match.
     * [1, 1000], default 20. A variance known to a third, and a fault that shows within two seconds at 10 Hz. */
    int32_t window;
    /* gated_match: probability of a false alarm in one test of a window.
     * (0, 0.5], default 1e-3. One false alarm in a thousand steps. */
    double gate_alpha;
    /* hmm, joint: noise levels, the first of them healthy.
     * [2, 16], default 5. Variances of 1, 4, 16, 64, 256: noise of up to sixteen times the healthy sigma. */
    int32_t hmm_levels;
    /* hmm, joint: ratio of the variances of neighbouring levels.
     * [1.1, 1000], default 4. Steps of two in sigma: a few samples cannot distinguish nearer levels. */
    double hmm_level_ratio;
    /* hmm: probability per step that a healthy channel becomes faulty.
     * (0, 0.5], default 1e-3. Faults are rare: one in a thousand steps. */
    double hmm_fault_probability;
    /* hmm: probability per step that a faulty channel recovers.
     * (0, 0.5], default 2e-3. Faults last: some hundred steps. */
    double hmm_recovery_probability;
    /* hmm: probability per step that a faulty channel changes to a neighbouring level.
     * [0, 0.5], default 1e-2. A fault grows or fades within a hundred steps. */
    double hmm_drift_probability;
    /* joint: probability per step that the noise of a healthy channel grows and stays.
     * (0, 0.1], default 1e-4. Below that of the process: channels suspect together then mean the process. */
    double joint_fault_probability;
    /* joint: probability per step that a faulty channel recovers.
     * (0, 0.1], default 2e-3. That of hmm: faults last some hundred steps. At 5e-4 an alarm ends 0.3 s later than that of
     * hmm, at 3e-3 NEES grows. */
    double joint_recovery_probability;
    /* joint: probability that one sample of a healthy channel is an outlier.
     * [0, 0.1], default 0.025. A sample far off is no fault that lasts: a channel with 5 % outliers stays healthy. */
    double joint_outlier_probability;
    /* joint: probability per step that the coloured error of a channel jumps.
     * [0, 0.1], default 1.5e-4. A jump that stays is certain after some five samples. */
    double joint_bias_probability;
    /* joint: standard deviation of such a jump, in sigma of the white noise of the channel.
     * (0, 1000], default 10. Smaller jumps are taken for a livelier coloured error; larger ones are learned as well. */
    double joint_bias_sigma;
    /* joint: probability per step that state or coloured errors become livelier than Qw and QU.
     * [0, 0.1], default 3e-3. Above that of a fault: a model that is wrong is more common than channels that fail
     * together. */
    double joint_process_probability;
    /* joint: probability per step that they become those of the model again.
     * (0, 0.1], default 4e-3. A model that was wrong for a while stays so. */
    double joint_process_recovery_probability;
    /* joint: probability per step that noise begins in many channels at once.
     * [0, 0.1], default 1e-3. Power supply and vibration reach all channels. */
    double joint_common_probability;
} hnav_ins_error_options;

#endif /* HNAV_OPTIONS_INS_ERROR_H */
