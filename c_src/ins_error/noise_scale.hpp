// Noise scale of each measurement channel: a factor s_i >= 1 on the variance of its white noise v_i, estimated from the
// innovations. Only Qv is scaled: a sensor fault does not change the aircraft or its air.
//
//   paper match  s_i = max(1, (mean of nu_i^2 over a window - variance of the prediction) / r_i), the paper's adaptation
//                on one channel. Biased: the maximum of 1 and an estimate of 1 is above 1, by 1/sqrt(pi M).
//   gated match  the same, but 1 as long as the conditional innovations of the window pass a chi-square test.
//   HMM          s_i is a hidden Markov chain over 1, 4, 16, ...: it stays healthy, jumps to any level, recovers, drifts.
//                Its posterior is updated by each innovation, so no window delays onset and recovery.
//
// The error of the prediction is common to the innovations of all channels, so a fault in one appears in all. Test and chain therefore use
// the innovation of a channel given those of all others: (S^-1 nu)_i / (S^-1)_ii, of variance 1 / (S^-1)_ii.
#pragma once

#include "hnav/options/ins_error.h"
#include "maths/lower_inverse.hpp"

#include <unsupported/Eigen/SpecialFunctions>

#include <algorithm>
#include <cmath>

namespace hnav {

// x with P(chi square of `freedom` > x) = alpha. Bisection: done once, in create.
inline double chi_square_limit(int freedom, double alpha) {
    double low = 0, high = 1;
    while (Eigen::numext::igammac(0.5 * freedom, 0.5 * high) > alpha) high *= 2;
    for (int i = 0; i < 200 && low < high; ++i) {
        const double middle = 0.5 * (low + high);
        if (middle == low || middle == high) break;
        (Eigen::numext::igammac(0.5 * freedom, 0.5 * middle) > alpha ? low : high) = middle;
    }
    return high;
}

// Innovations of one sample, and the parts of their variance.
struct Innovations {
    const double* nu; // by channel
    const Matrix& base; // S without the white noise that is to be scaled
    const double* fresh; // healthy variance of the noise that is scaled: Qv_ii
    const double* past; // variance of earlier noise in nu (differenced forms), as scaled then
    const double* past_healthy; // the same, unscaled
    const int* present; // channels that have a measurement
    int count; // of them
};

class NoiseScale {
public:
    // state: contents of a saved filter; work: scratch of a step.
    // scaling: HNAV_NOISE_SCALING_NONE to _HMM. The options are kept by reference.
    NoiseScale(MatrixArena& state, MatrixArena& work, int nz, const hnav_ins_error_options& options, int scaling)
        : options_(options), scaling_(scaling), nz_(nz), S_(work.matrix(nz, nz)), inverse_(work, nz) {
        for (double** of_channels : {&scale_, &fault_, &seen_}) *of_channels = state.doubles(nz);
        for (double** ring : {&squared_, &predicted_, &normalised_}) *ring = state.doubles(windowed() ? nz * options.window : 0);
        const int levels = options.hmm_levels;
        belief_ = state.doubles(nz * levels);
        for (double** of_levels : {&level_, &inverse_level_, &weight_}) *of_levels = work.doubles(levels);
        transition_ = work.doubles(levels * levels);
        for (double** of_channels : {&nu_, &solved_, &R_}) *of_channels = work.doubles(nz);
    }

    void create() {
        gate_limit_ = chi_square_limit(options_.window, options_.gate_alpha);
        const int n = options_.hmm_levels;
        for (int g = 0; g < n; ++g) {
            level_[g] = std::pow(options_.hmm_level_ratio, g);
            inverse_level_[g] = 1 / level_[g];
        }
        std::fill(transition_, transition_ + n * n, 0.0);
        const auto T = [&](int from, int to) -> double& { return transition_[from * n + to]; };
        T(0, 0) = 1 - options_.hmm_fault_probability;
        for (int g = 1; g < n; ++g) {
            T(0, g) = options_.hmm_fault_probability / (n - 1);
            T(g, 0) = options_.hmm_recovery_probability;
            const int neighbours = (g > 1) + (g + 1 < n);
            if (g > 1) T(g, g - 1) = options_.hmm_drift_probability / neighbours;
            if (g + 1 < n) T(g, g + 1) = options_.hmm_drift_probability / neighbours;
            T(g, g) = 1 - options_.hmm_recovery_probability - (neighbours ? options_.hmm_drift_probability : 0);
        }
        reset();
    }

    void reset() {
        std::fill(scale_, scale_ + nz_, 1.0);
        std::fill(fault_, fault_ + nz_, 0.0);
        std::fill(seen_, seen_ + nz_, 0.0);
        std::fill(belief_, belief_ + nz_ * options_.hmm_levels, 0.0);
        for (int i = 0; i < nz_; ++i) belief_[i * options_.hmm_levels] = 1;
        if (!windowed()) return;
        for (double* ring : {squared_, predicted_, normalised_}) std::fill(ring, ring + nz_ * options_.window, 0.0);
    }

    const double* scale() const { return scale_; }

    // HMM: probability of any faulty level; gated match: 1 while the gate is open; else 0.
    const double* fault_probability() const { return fault_; }

    // False: the variances are no covariance.
    bool update(const Innovations& in) {
        switch (scaling_) {
        case HNAV_NOISE_SCALING_NONE: return true;
        case HNAV_NOISE_SCALING_HMM: return update_chain(in);
        default: return update_window(in);
        }
    }

private:
    bool windowed() const { return scaling_ == HNAV_NOISE_SCALING_PAPER_MATCH || scaling_ == HNAV_NOISE_SCALING_GATED_MATCH; }

    // S of the present channels with the noise R, and S^-1 nu.
    bool solve(const Innovations& in) {
        for (int a = 0; a < in.count; ++a) {
            const int i = in.present[a];
            nu_[a] = in.nu[i];
            for (int b = 0; b <= a; ++b) S_(a, b) = in.base(i, in.present[b]);
            S_(a, a) += R_[a];
        }
        if (!inverse_.factor(S_, in.count)) return false;
        inverse_.solve(nu_, solved_);
        return true;
    }

    bool update_window(const Innovations& in) {
        const int M = options_.window;
        const bool gated = scaling_ == HNAV_NOISE_SCALING_GATED_MATCH;
        for (int a = 0; a < in.count; ++a) R_[a] = in.fresh[in.present[a]] + in.past_healthy[in.present[a]];
        if (gated && !solve(in)) return false;
        for (int a = 0; a < in.count; ++a) {
            const int i = in.present[a];
            if (!(in.fresh[i] > 0)) continue; // no noise to scale
            const int place = i * M + static_cast<int>(std::fmod(seen_[i], M));
            squared_[place] = in.nu[i] * in.nu[i];
            predicted_[place] = in.base(i, i);
            if (gated) normalised_[place] = solved_[a] * solved_[a] / inverse_.inverse_diagonal(a);
            seen_[i] += 1;
            if (seen_[i] < M) continue;
            const double squared = mean(squared_ + i * M);
            const double predicted = gated ? mean(predicted_ + i * M) : in.base(i, i);
            const bool open = !gated || mean(normalised_ + i * M) * M > gate_limit_;
            scale_[i] = open ? std::fmax(1, (squared - predicted) / R_[a]) : 1;
            fault_[i] = gated && open;
        }
        return true;
    }

    double mean(const double* ring) const {
        double sum = 0;
        for (int k = 0; k < options_.window; ++k) sum += ring[k];
        return sum / options_.window;
    }

    // Two passes: the predicted chain gives the noise of each channel; then the innovation of each channel, given the others
    // with that noise, weighs its levels. R = fresh / E[1/s] gives the measurement the weight that it has in the mixture.
    bool update_chain(const Innovations& in) {
        for (int i = 0; i < nz_; ++i)
            if (in.fresh[i] > 0) predict(i);
        for (int a = 0; a < in.count; ++a) R_[a] = in.fresh[in.present[a]] * scale_[in.present[a]] + in.past[in.present[a]];
        if (!solve(in)) return false;
        for (int a = 0; a < in.count; ++a) {
            const int i = in.present[a];
            if (!(in.fresh[i] > 0)) continue;
            const double spread = 1 / inverse_.inverse_diagonal(a);
            const double conditional = solved_[a] * spread;
            weigh(i, 0.5 * conditional * conditional, std::fmax(0, spread - R_[a]) + in.past[i], in.fresh[i]);
        }
        return true;
    }

    void predict(int i) {
        const int n = options_.hmm_levels;
        double* belief = belief_ + i * n;
        for (int to = 0; to < n; ++to) {
            double sum = 0;
            for (int from = 0; from < n; ++from) sum += belief[from] * transition_[from * n + to];
            weight_[to] = sum;
        }
        std::copy(weight_, weight_ + n, belief);
        conclude(i);
    }

    // Normal likelihoods of the levels, scaled by the largest exponent so that none of them overflows or all vanish.
    void weigh(int i, double half_square, double others, double fresh) {
        const int n = options_.hmm_levels;
        double* belief = belief_ + i * n;
        const double widest = others + level_[n - 1] * fresh;
        double sum = 0;
        for (int g = 0; g < n; ++g) {
            const double variance = others + level_[g] * fresh;
            belief[g] *= std::exp(half_square / widest - half_square / variance) / std::sqrt(variance);
            sum += belief[g];
        }
        const double inverse_sum = 1 / sum;
        for (int g = 0; g < n; ++g) belief[g] *= inverse_sum;
        conclude(i);
    }

    void conclude(int i) {
        const int n = options_.hmm_levels;
        const double* belief = belief_ + i * n;
        double precision = 0, faulty = 0;
        for (int g = 0; g < n; ++g) precision += belief[g] * inverse_level_[g];
        for (int g = 1; g < n; ++g) faulty += belief[g];
        scale_[i] = 1 / precision;
        fault_[i] = std::fmin(1, faulty); // a sum, with its rounding
    }

    const hnav_ins_error_options& options_;
    const int scaling_;
    int nz_;
    double gate_limit_ = 0;
    double *scale_, *fault_;
    double* seen_; // samples of each channel so far; a double, because saved states are numbers
    double *squared_, *predicted_, *normalised_;
    double* belief_;
    double *level_, *inverse_level_, *transition_;
    Matrix S_;
    LowerInverse inverse_;
    double *nu_, *solved_, *weight_, *R_;
};

} // namespace hnav
