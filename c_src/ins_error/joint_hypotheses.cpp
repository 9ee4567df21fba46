#include "ins_error/joint_hypotheses.hpp"

namespace hnav {

JointHypotheses::JointHypotheses(MatrixArena& state, MatrixArena& work, int nz, const hnav_ins_error_options& options)
    : options_(options), nz_(nz), inverse_(work.matrix(nz, nz)), S_(work, nz) {
    for (double** of_channels : {&scale_, &noise_, &bias_}) *of_channels = state.doubles(nz);
    process_ = state.doubles(1);
    belief_ = state.doubles(nz * modes());
    process_belief_ = state.doubles(processes);
    for (double** of_channels : {&tracked_, &tracked_variance_}) *of_channels = state.doubles(nz);
    for (double** of_levels : {&level_, &leaves_}) *of_levels = work.doubles(options.hmm_levels);
    for (double** of_modes : {&precision_, &weight_}) *of_modes = work.doubles(modes());
    for (double** of_channels : {&was_healthy_, &outlier_, &common_, &opened_, &unexplained_, &column_, &gain_, &behind_})
        *of_channels = work.doubles(nz);
    for (double** both : {&lasting_, &prior_}) *both = work.doubles(nz * modes());
    support_ = work.doubles(processes * nz * modes());
    for (double** both : {&innovation_, &variance_}) *both = work.doubles(processes * nz);
    order_ = work.integers(nz);
}

void JointHypotheses::create() {
    for (int g = 0; g < options_.hmm_levels; ++g) {
        level_[g] = std::pow(options_.hmm_level_ratio, g);
        precision_[g] = 1 / level_[g];
        // From a faulty level to each of its neighbours, which are faulty too.
        leaves_[g] = drift_probability / std::max(1, (g > 1) + (g + 1 < options_.hmm_levels));
    }
    precision_[bias_mode()] = 0; // a measurement with an unknown bias carries no information
    least_precision_ = std::fmin(1e-4, precision_[options_.hmm_levels - 1]);
    reset();
}

void JointHypotheses::reset() {
    std::fill(scale_, scale_ + nz_, 1.0);
    for (double* each : {noise_, bias_, tracked_, tracked_variance_, opened_}) std::fill(each, each + nz_, 0.0);
    *process_ = 0;
    std::fill(belief_, belief_ + nz_ * modes(), 0.0);
    for (int i = 0; i < nz_; ++i) belief(i)[0] = 1;
    std::fill(process_belief_, process_belief_ + processes, 0.0);
    process_belief_[0] = 1;
    motion_ = colour_ = 1;
}

bool JointHypotheses::update(const Innovations& in, const Liveliness& lively) {
    swept_ = lively.driven ? processes : 1;
    if (lively.driven) predict_process();
    for (int i = 0; i < nz_; ++i) {
        opened_[i] = 0;
        if (!(in.fresh[i] > 0)) continue; // no noise to test
        predict_channel(i);
        predict_bias(i, in.fresh[i], lively);
    }
    order(in);
    if (!compare(in, lively)) return false;
    sweep(in, 0);
    weigh_common(in);
    for (int p = 1; p < swept_; ++p) {
        modes_of_[p] = 0;
        if (needs_a_sweep(p)) sweep(in, p);
        else evidence_[p] += by_modes_;
    }
    merge(in.count > 0);
    conclude(in);
    return true;
}

// ------------------------------------------------------------------------------------------------ before the sample

void JointHypotheses::predict_process() {
    const double stated = process_belief_[0], increased = 1 - stated;
    const double begins = options_.joint_process_probability / (processes - 1);
    const double changes = process_drift / (processes - 1);
    for (int p = 1; p < processes; ++p) {
        const double was = process_belief_[p];
        const double leaves = options_.joint_process_recovery_probability + changes * (processes - 2);
        process_belief_[p] = was * (1 - leaves) + changes * (increased - was) + stated * begins;
    }
    process_belief_[0] =
        stated * (1 - options_.joint_process_probability) + increased * options_.joint_process_recovery_probability;
}

void JointHypotheses::predict_channel(int i) {
    const int n = options_.hmm_levels;
    const double* was = belief(i);
    double* lasting = lasting_ + i * modes();
    const double stays = 1 - options_.joint_recovery_probability, fault = was[0] * options_.joint_fault_probability / (n - 1);
    double faulty = 0;
    for (int g = 1; g < n; ++g) {
        lasting[g] = was[g] * stays + fault;
        if (g > 1) lasting[g] += was[g - 1] * leaves_[g - 1] - was[g] * leaves_[g];
        if (g + 1 < n) lasting[g] += was[g + 1] * leaves_[g + 1] - was[g] * leaves_[g];
        faulty += was[g];
    }
    const double recovers = faulty * options_.joint_recovery_probability + was[bias_mode()] * bias_fading;
    const double fails = options_.joint_fault_probability + options_.joint_outlier_probability + options_.joint_bias_probability;
    lasting[0] = was[0] * (1 - fails) + recovers;
    lasting[bias_mode()] = was[bias_mode()] * (1 - bias_fading) + was[0] * options_.joint_bias_probability;
    outlier_[i] = was[0] * options_.joint_outlier_probability / (n - first_outlier());
    was_healthy_[i] = was[0];

    double precision = 0, *prior = prior_of(i);
    for (int m = 0; m < modes(); ++m) {
        prior[m] = lasting[m] + passing(i, m);
        precision += prior[m] * precision_[m];
    }
    scale_[i] = 1 / std::fmax(precision, least_precision_);
}

// The tracked constant is the previous one, a random walk with the variance of the channel's prediction, or it begins.
void JointHypotheses::predict_bias(int i, double fresh, const Liveliness& lively) {
    const double now = lasting_[i * modes() + bias_mode()];
    const double share = now > 0 ? belief(i)[bias_mode()] * (1 - bias_fading) / now : 0;
    const double jump = options_.joint_bias_sigma * options_.joint_bias_sigma * fresh;
    const double wanders = lively.driven ? lively.motion(i, i) + lively.colour(i, i) : 0;
    const double mean = share * tracked_[i], away = tracked_[i] - mean;
    tracked_variance_[i] = share * (tracked_variance_[i] + wanders + away * away) + (1 - share) * (jump + mean * mean);
    tracked_[i] = mean;
}

// ------------------------------------------------------------------------------------------------ one process hypothesis

// The channel that is explained least by its own variance is swept first, so that the others are tested with its updated noise. It is the
// last one of S: the factor's last rows are the covariance of the last channels given all others.
void JointHypotheses::order(const Innovations& in) {
    for (int a = 0; a < in.count; ++a) {
        const int i = in.present[a];
        unexplained_[i] = in.nu[i] * in.nu[i] / (in.base(i, i) + in.fresh[i] * scale_[i]);
        int place = a;
        for (; place > 0 && unexplained_[order_[place - 1]] >= unexplained_[i]; --place) order_[place] = order_[place - 1];
        order_[place] = i;
    }
}

bool JointHypotheses::compare(const Innovations& in, const Liveliness& lively) {
    double motion[hypotheses], colour[hypotheses];
    for (int p = 0; p < hypotheses; ++p) {
        motion[p] = lively.driven ? motion_factors[p] - 1 : 0;
        colour[p] = lively.driven ? colour_factors[p] - 1 : 0;
    }
    for (int a = 0; a < in.count; ++a) {
        const int i = order_[a];
        for (int b = 0; b <= a; ++b) {
            const int j = order_[b];
            const double base = in.base(i, j) + (a == b ? in.fresh[i] * scale_[i] : 0);
            const double moves = lively.motion(i, j), colours = lively.colour(i, j);
            double* S = S_.element(a, b);
            for (int p = 0; p < hypotheses; ++p) S[p] = base + motion[p] * moves + colour[p] * colours;
        }
        std::fill_n(S_.right(a), hypotheses, in.nu[i]);
    }
    if (!S_.decompose(in.count)) return false;
    for (int p = 0; p < swept_; ++p) evidence_[p] = S_.log_density(in.count, p);
    return true;
}

// The modes add less to the evidence than under the stated process: with more process noise there is less for them to explain. So no
// process is overlooked.
bool JointHypotheses::needs_a_sweep(int p) const {
    return process_belief_[p] * std::exp(evidence_[p] + by_modes_ - evidence_[0]) > sweep_from * process_belief_[0];
}

// From the last channel of S to the first. The channels from a on, given those before it, have the covariance M M' with the lower right
// block M = [t 0; v T] of the factor, and there the innovations M (h, g), a part of L^-1 nu. With E^-1 = inverse_, E = T T' with the updated
// noise of the channels behind a, the innovation of a given all others is
//
//   r = t (h - v' E^-1 T g) / (1 + v' E^-1 v), of variance t^2 / (1 + v' E^-1 v)
void JointHypotheses::sweep(const Innovations& in, int p) {
    modes_of_[p] = p;
    LogProduct factors;
    double exponents = 0;
    for (int a = in.count - 1; a >= 0; --a) {
        const int i = order_[a];
        const double fresh = in.fresh[i], R = fresh * scale_[i], t = S_.factor(a, a, p), h = S_.solved(a, p);
        double along = 0, explained = 0;
        for (int b = a + 1; b < in.count; ++b) column_[b] = S_.factor(b, a, p);
        for (int b = a + 1; b < in.count; ++b) {
            const double* row = inverse_.data() + b * nz_;
            gain_[b] = 0;
            for (int c = a + 1; c < in.count; ++c) gain_[b] += row[c] * column_[c];
            along += gain_[b] * column_[b];
            explained += gain_[b] * behind_[b];
        }
        const double share = 1 / (1 + along), spread = t * t * share, r = t * share * (h - explained);
        double found = R;
        if (fresh > 0) { // else no noise to test
            const double others = std::fmax(0, spread - R);
            const Weighed channel = weigh(i, p, r, others, fresh);
            found = fresh * channel.scale;
            factors.times(channel.total * std::sqrt(spread));
            exponents += channel.exponent + 0.5 * (h - explained) * (h - explained) * share;
            innovation_[p * nz_ + i] = r;
            variance_[p * nz_ + i] = others + fresh;
        }
        change_noise(a, in.count, t * share, share, spread, found - R);
        for (int b = a + 1; b < in.count; ++b) behind_[b] += column_[b] * h;
        behind_[a] = t * h;
    }
    const double by_modes = exponents + factors.log();
    evidence_[p] += by_modes;
    if (p == 0) by_modes_ = by_modes;
}

JointHypotheses::Weighed JointHypotheses::weigh(int i, int p, double r, double others, double fresh) {
    double* each = support(p, i);
    const double half = 0.5 * r * r, away = r - tracked_[i];
    for (int g = 0; g < options_.hmm_levels; ++g) {
        weight_[g] = 1 / (others + level_[g] * fresh);
        each[g] = -half * weight_[g];
    }
    const int bias = bias_mode();
    weight_[bias] = 1 / (others + fresh + tracked_variance_[i]);
    each[bias] = -0.5 * away * away * weight_[bias];
    // The widest level explains an innovation at least as well as the narrower ones.
    const double largest = std::fmax(each[bias - 1], each[bias]);
    double total = 0, precision = 0;
    for (int m = 0; m < modes(); ++m) {
        each[m] = std::exp(each[m] - largest) * std::sqrt(weight_[m]);
        total += prior_of(i)[m] * each[m];
        precision += prior_of(i)[m] * each[m] * precision_[m];
    }
    const double inverse_total = 1 / total;
    for (int m = 0; m < modes(); ++m) each[m] *= inverse_total;
    return {largest, total, total / std::fmax(precision, least_precision_ * total)};
}

void JointHypotheses::change_noise(int a, int count, double shown, double share, double spread, double change) {
    const double precision = 1 / (spread + change), narrows = share * change * precision;
    const double* __restrict gain = gain_;
    double* __restrict first = inverse_.data() + a * nz_;
    first[a] = precision;
    for (int b = a + 1; b < count; ++b) {
        double* __restrict row = inverse_.data() + b * nz_;
        const double by = narrows * gain[b];
        for (int c = a + 1; c < count; ++c) row[c] -= by * gain[c];
        row[a] = first[b] = -shown * precision * gain[b];
    }
}

void JointHypotheses::weigh_common(const Innovations& in) {
    LogProduct ratio;
    for (int a = 0; a < in.count; ++a) {
        const int i = in.present[a];
        if (!(in.fresh[i] > 0)) continue;
        const double* each = support(0, i);
        double total = 1;
        for (int m = 0; m < bias_mode(); ++m) total += begins(i, m) * each[m];
        ratio.times(total);
        common_[i] = 1 / total;
    }
    evidence_[common] = evidence_[0] + ratio.log();
}

// ------------------------------------------------------------------------------------------------ all together

void JointHypotheses::merge(bool seen) {
    double largest = evidence_[common];
    for (int p = 0; p < swept_; ++p) largest = std::fmax(largest, evidence_[p]);
    double sum = 0;
    for (int p = 0; p < hypotheses; ++p) {
        const bool is_weighed = seen && (p < swept_ || p == common);
        double prior = p == common ? process_belief_[0] * options_.joint_common_probability : process_belief_[p];
        if (p == 0) prior *= 1 - options_.joint_common_probability;
        hypothesis_[p] = is_weighed ? prior * std::exp(evidence_[p] - largest) : prior;
        sum += hypothesis_[p];
    }
    motion_ = colour_ = 0;
    for (int p = 0; p < hypotheses; ++p) {
        hypothesis_[p] /= sum;
        motion_ += hypothesis_[p] * std::sqrt(motion_factors[p]);
        colour_ += hypothesis_[p] * std::sqrt(colour_factors[p]);
    }
    std::fill(weight_of_modes_, weight_of_modes_ + processes, 0.0);
    for (int p = 0; p < swept_; ++p) weight_of_modes_[modes_of_[p]] += hypothesis_[p];
    // Of standard deviations: an improbable hypothesis has little effect.
    motion_ *= motion_;
    colour_ *= colour_;
    std::copy(hypothesis_, hypothesis_ + processes, process_belief_);
    process_belief_[0] += hypothesis_[common]; // it begins, and is then noise of each channel
    *process_ = 0;
    for (int p = 1; p < processes; ++p) *process_ += process_belief_[p];
}

void JointHypotheses::conclude(const Innovations& in) {
    for (int i = 0, a = 0; i < nz_; ++i) {
        const bool measured = a < in.count && in.present[a] == i;
        a += measured;
        bias_[i] *= 1 - bias_fading;
        if (!(in.fresh[i] > 0)) continue;
        if (measured) {
            merge_channel(i);
            bias_[i] = std::fmin(1, std::fmax(bias_[i], belief(i)[bias_mode()]));
            if (belief(i)[bias_mode()] > bias_certain) open(i, in.fresh[i]);
        } else {
            std::copy(lasting_ + i * modes(), lasting_ + (i + 1) * modes(), belief(i));
            belief(i)[0] += was_healthy_[i] * options_.joint_outlier_probability; // an outlier lasts one sample
        }
        noise_[i] = fault_of(i);
    }
}

void JointHypotheses::merge_channel(int i) {
    double* now = belief(i);
    const double *lasting = lasting_ + i * modes(), together = hypothesis_[common] * common_[i];
    for (int m = 0; m < modes(); ++m) now[m] = weight_of_modes_[0] * support(0, i)[m];
    const double stated = weight_of_modes_[0] + hypothesis_[common];
    double r = stated * innovation_[i], variance = stated * variance_[i];
    for (int p = 1; p < swept_; ++p) {
        const double weight = weight_of_modes_[p];
        if (!(weight > 0)) continue;
        r += weight * innovation_[p * nz_ + i];
        variance += weight * variance_[p * nz_ + i];
        for (int m = 0; m < modes(); ++m) now[m] += weight * support(p, i)[m];
    }
    double precision = 0, outliers = 0;
    for (int m = 0; m < modes(); ++m) {
        const double common_support = together * support(0, i)[m], each = now[m] + common_support;
        const double outlier = passing(i, m) * each; // lasts one sample
        now[m] = lasting[m] * each + begins(i, m) * common_support;
        precision += (now[m] + outlier) * precision_[m];
        outliers += outlier;
    }
    now[0] += outliers;
    scale_[i] = 1 / std::fmax(precision, least_precision_);
    const double gain = tracked_variance_[i] / (tracked_variance_[i] + variance);
    tracked_[i] += gain * (r - tracked_[i]);
    tracked_variance_[i] *= 1 - gain;
}

void JointHypotheses::open(int i, double fresh) {
    opened_[i] = options_.joint_bias_sigma * options_.joint_bias_sigma * fresh;
    std::fill(belief(i), belief(i) + modes(), 0.0);
    belief(i)[0] = 1;
    scale_[i] = 1;
    bias_[i] = 1;
}

double JointHypotheses::fault_of(int i) const {
    double sum = 0;
    for (int g = 1; g < options_.hmm_levels; ++g) sum += belief(i)[g];
    return std::fmin(1, sum); // a sum, with its rounding
}

} // namespace hnav
