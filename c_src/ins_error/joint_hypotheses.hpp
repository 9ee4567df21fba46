// Fault hypotheses, tested by the whole innovation: increased white noise of a channel, a jump of its coloured error, or
// increased process noise. docs/filter_ins_error.md has the equations.
//
//   channel   a Markov chain over noise levels s = 1, 4, 16, ... that last, as in noise_scale.hpp, and beside them
//             an outlier, noise of s >= 16 in one sample alone, and
//             a bias: the innovation is a constant b that is tracked, b ~ N(0, bias_sigma^2 r) when it begins
//   process   a Markov chain over factors on the covariance of what drives the state (Q) and the coloured errors (Ql)
// common    noise that begins in many channels at once, which is almost impossible for independent chains
//
// Each process hypothesis p has its own S_p = base + (x_p - 1) H Q H' + (c_p - 1) Ql + R. Under it one sweep over the channels
// (expectation propagation; T. Minka, 2001) weights the modes of each by its innovation given all others, with the updated noise
// of the channels before it, and gives the evidence of the whole innovation:
//
//   log Z_p = log N(nu; 0, S_p) + sum_i log [ sum_m pi_i(m) N(r_i; b_m, var_m) / N(r_i; 0, var_i) ]
//
// Where p is improbable even with the sum of the stated process, which is larger, it has that sum and its posteriors, without a sweep.
// Simultaneous errors of several channels raise the probability of the process if its S_p explains them with one change.
// The hypotheses are merged after each sample (GPB1): one filter with R_i = r_i / E[1/s], and with Q and Ql whose standard
// deviations have their expected factors. A bias above bias_certain increases the variance of that channel's lambda, which
// then estimates the jump in a few samples.
#pragma once

#include "ins_error/noise_scale.hpp"
#include "maths/cholesky_lanes.hpp"

namespace hnav {

// Inputs of one sample beside its innovations (noise_scale.hpp): the variance that the process adds to them in one step.
struct Liveliness {
    const Matrix& motion; // H Q H'
    const Matrix& colour; // Ql
    bool driven; // false in the first sample: no step before it
};

class JointHypotheses {
public:
    // state: contents of a saved filter; work: scratch of a step. The options are kept by reference.
    JointHypotheses(MatrixArena& state, MatrixArena& work, int nz, const hnav_ins_error_options& options);

    void create();
    void reset();

    // False: the variances are not those of a covariance.
    bool update(const Innovations& in, const Liveliness& lively);

    const double* scale() const { return scale_; } // by channel: factor on Qv
    const double* noise_probability() const { return noise_; } // by channel: noise above its healthy level
    const double* bias_probability() const { return bias_; } // by channel: its coloured error has jumped
    double process_probability() const { return *process_; }
    double motion_factor() const { return motion_; } // on Q of this step
    double colour_factor() const { return colour_; } // on Ql
    const double* opened() const { return opened_; } // by channel: variance to add to lambda

private:
    // Factors on Q and Ql; the first hypothesis is the stated process. Common noise comes last, with the stated process. No hypothesis is a
    // quieter process: with {0.1, 1} and a true Q of a ninth, NEES/n stays (0.68, 0.67 without), for a third more sweeps.
    static constexpr int processes = 3, common = processes, hypotheses = processes + 1;
    static constexpr double motion_factors[hypotheses] = {1, 10, 1, 1}, colour_factors[hypotheses] = {1, 2, 20, 1};

    // Without an option: the results hardly depend on them.
    static constexpr double drift_probability = 0.01; // per step, from a noise level to its neighbours
    static constexpr double bias_certain = 0.9; // probability above which the variance of lambda is increased
    static constexpr double bias_fading = 0.07; // per step: decay of the probability of a jump
    static constexpr double process_drift = 5e-4; // per step, from one increased process noise to another
    static constexpr double common_share = 0.8; // of the channels that common noise reaches

    // Odds against the stated process below which an increased one takes its modes instead of a sweep of its own. With 0.1 an eighth of the
    // time is saved again, but the probability of an increased process rises by a hundredth.
    static constexpr double sweep_from = 0.05;

    struct Weighed {
        double exponent, total; // the likelihood of the innovation is total * exp(exponent)
        double scale; // updated factor on Qv
    };

    // Probabilities before the sample.
    void predict_process();
    void predict_channel(int i);
    void predict_bias(int i, double fresh, const Liveliness& lively);

    void order(const Innovations& in);
    // log N(nu; 0, S) of each hypothesis about the process, and the factors of its S.
    bool compare(const Innovations& in, const Liveliness& lively);
    // Of an increased process: whether it is probable enough for modes of its own.
    bool needs_a_sweep(int p) const;
    void sweep(const Innovations& in, int p);
    // Tests a channel by its innovation r, whose variance is `others` plus noise: the support of its modes.
    Weighed weigh(int i, int p, double r, double others, double fresh);
    // E^-1 of the channels from a on, with the updated noise of a.
    void change_noise(int a, int count, double shown, double share, double spread, double change);
    // From the result of the sweep under the stated process.
    void weigh_common(const Innovations& in);

    void merge(bool seen);
    void conclude(const Innovations& in);
    void merge_channel(int i);
    // The channel is reset: its lambda is unknown, its noise healthy.
    void open(int i, double fresh);
    double fault_of(int i) const;

    // Modes of a channel: the noise levels, then bias.
    int modes() const { return options_.hmm_levels + 1; }
    int bias_mode() const { return options_.hmm_levels; }
    // The smallest level of an outlier: four sigma.
    int first_outlier() const { return std::min(2, options_.hmm_levels - 1); }
    double* belief(int i) const { return belief_ + i * modes(); }
    double* support(int p, int i) const { return support_ + (p * nz_ + i) * modes(); }
    double* prior_of(int i) const { return prior_ + i * modes(); }
    // What common noise adds to the prior of a mode.
    double begins(int i, int m) const {
        if (m == bias_mode()) return 0;
        const double more = (common_share - options_.joint_fault_probability) * was_healthy_[i];
        return m == 0 ? -more : more / (options_.hmm_levels - 1);
    }
    // Prior of an outlier with the noise of a mode.
    double passing(int i, int m) const { return m >= first_outlier() && m < options_.hmm_levels ? outlier_[i] : 0; }

    const hnav_ins_error_options& options_;
    int nz_;
    double *scale_, *noise_, *bias_, *process_;
    double* belief_; // by channel and mode
    double* process_belief_;
    double *tracked_, *tracked_variance_; // the bias of each channel and its variance
    double *level_, *precision_; // by level; by mode, in units of the healthy one
    double* leaves_; // by level: probability per step of a change to each neighbouring level
    double least_precision_ = 0; // below it a channel is treated as missing
    double* was_healthy_; // by channel: probability before this step
    double *lasting_, *prior_; // by channel and mode: without outliers, and with them
    double* outlier_; // by channel: for each level of an outlier
    double* support_; // by process, channel and mode: posterior over prior
    double* common_; // by channel: support under common noise over that under the stated process
    double *innovation_, *variance_; // by process and channel: given the others, healthy
    double* weight_; // by mode
    double* opened_;
    double* unexplained_; // by channel: its squared innovation over its variance
    double *column_, *gain_, *behind_; // by place in S: of a sweep
    int* order_; // of the present channels in S
    Matrix inverse_;
    CholeskyLanes<hypotheses> S_;
    double evidence_[hypotheses], hypothesis_[hypotheses]; // log Z, then the probability
    double by_modes_ = 0; // log Z - log N(nu; 0, S) of the stated process
    int modes_of_[processes]; // the process whose sweep gave the modes
    double weight_of_modes_[processes]; // of those, together
    double motion_ = 1, colour_ = 1;
    int swept_ = processes; // of them; 1 in the first sample, without process noise
};

} // namespace hnav
