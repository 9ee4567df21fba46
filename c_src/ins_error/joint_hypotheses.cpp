#include "ins_error/joint_hypotheses.hpp"

namespace hnav {

JointHypotheses::JointHypotheses(MatrixArena& state, MatrixArena& work, int nz, const JointSettings& s)
    : settings_(s),
      nz_(nz),
      scale_(state.doubles(nz)),
      noise_(state.doubles(nz)),
      bias_(state.doubles(nz)),
      process_(state.doubles(1)),
      belief_(state.doubles(nz * modes())),
      process_belief_(state.doubles(processes)),
      tracked_(state.doubles(nz)),
      tracked_variance_(state.doubles(nz)),
      level_(work.doubles(s.levels)),
      precision_(work.doubles(modes())),
      was_healthy_(work.doubles(nz)),
      lasting_(work.doubles(nz * modes())),
      prior_(work.doubles(nz * modes())),
      outlier_(work.doubles(nz)),
      likelihood_(work.doubles(nz * modes())),
      posterior_(work.doubles(hypotheses * nz * modes())),
      innovation_(work.doubles(processes * nz)),
      variance_(work.doubles(processes * nz)),
      weight_(work.doubles(modes())),
      R_(work.doubles(nz)),
      nu_(work.doubles(nz)),
      solved_(work.doubles(nz)),
      opened_(work.doubles(nz)),
      order_(work.integers(nz)),
      S_(work.matrix(nz, nz)),
      inverse_S_(work.matrix(nz, nz)),
      inverse_(work, nz) {}

void JointHypotheses::create() {
    for (int g = 0; g < settings_.levels; ++g) {
        level_[g] = std::pow(settings_.level_ratio, g);
        precision_[g] = 1 / level_[g];
    }
    precision_[bias_mode()] = 0; // a measurement with an unknown bias carries no information
    least_precision_ = std::fmin(1e-4, precision_[settings_.levels - 1]);
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
    for (int p = 0; p < swept_; ++p) {
        if (!begin(in, lively, p)) return false;
        if (p == 0 || needs_a_sweep(p)) {
            sweep(in, p);
        } else {
            evidence_[p] += by_modes_;
            modes_of_[p] = 0;
        }
        if (p == 0) weigh_common(in);
    }
    merge(in.count > 0);
    conclude(in);
    return true;
}

// ------------------------------------------------------------------------------------------------ before the sample

void JointHypotheses::predict_process() {
    const double told = process_belief_[0], lively = 1 - told;
    const double begins = settings_.process_probability / (processes - 1);
    const double changes = settings_.process_drift / (processes - 1);
    for (int p = 1; p < processes; ++p) {
        const double was = process_belief_[p];
        const double leaves = settings_.process_recovery + changes * (processes - 2);
        process_belief_[p] = was * (1 - leaves) + changes * (lively - was) + told * begins;
    }
    process_belief_[0] = told * (1 - settings_.process_probability) + lively * settings_.process_recovery;
}

void JointHypotheses::predict_channel(int i) {
    const int n = settings_.levels;
    const double* was = belief(i);
    double* lasting = lasting_ + i * modes();
    const double drift = settings_.drift_probability;
    // From a faulty level to each of its neighbours, which are faulty too.
    const auto leaves = [&](int g) { return drift / std::max(1, (g > 1) + (g + 1 < n)); };
    double recovers = was[bias_mode()] * settings_.bias_fading;
    for (int g = 1; g < n; ++g) {
        double now = was[g] * (1 - settings_.recovery_probability) + was[0] * settings_.fault_probability / (n - 1);
        if (g > 1) now += was[g - 1] * leaves(g - 1) - was[g] * leaves(g);
        if (g + 1 < n) now += was[g + 1] * leaves(g + 1) - was[g] * leaves(g);
        lasting[g] = now;
        recovers += was[g] * settings_.recovery_probability;
    }
    const double fails = settings_.fault_probability + settings_.outlier_probability + settings_.bias_probability;
    lasting[0] = was[0] * (1 - fails) + recovers;
    lasting[bias_mode()] = was[bias_mode()] * (1 - settings_.bias_fading) + was[0] * settings_.bias_probability;
    outlier_[i] = was[0] * settings_.outlier_probability / (n - first_outlier());
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
    const double share = now > 0 ? belief(i)[bias_mode()] * (1 - settings_.bias_fading) / now : 0;
    const double jump = settings_.bias_sigma * settings_.bias_sigma * fresh;
    const double wanders = lively.driven ? lively.motion(i, i) + lively.colour(i, i) : 0;
    const double mean = share * tracked_[i], away = tracked_[i] - mean;
    tracked_variance_[i] = share * (tracked_variance_[i] + wanders + away * away) + (1 - share) * (jump + mean * mean);
    tracked_[i] = mean;
}

// ------------------------------------------------------------------------------------------------ one process hypothesis

// The channel that is explained least by its own variance comes first, so that the others are tested with its updated noise.
void JointHypotheses::order(const Innovations& in) {
    for (int a = 0; a < in.count; ++a) {
        const int i = in.present[a];
        nu_[i] = in.nu[i] * in.nu[i] / (in.base(i, i) + in.fresh[i] * scale_[i]);
        int place = a;
        for (; place > 0 && nu_[order_[place - 1]] < nu_[i]; --place) order_[place] = order_[place - 1];
        order_[place] = i;
    }
}

bool JointHypotheses::begin(const Innovations& in, const Liveliness& lively, int p) {
    const double motion = lively.driven ? motion_factors[p] - 1 : 0, colour = lively.driven ? colour_factors[p] - 1 : 0;
    for (int a = 0; a < in.count; ++a) {
        const int i = order_[a];
        nu_[a] = in.nu[i];
        R_[a] = in.fresh[i] * scale_[i];
        const double *base = in.base.data() + i * nz_, *moves = lively.motion.data() + i * nz_;
        const double* colours = lively.colour.data() + i * nz_;
        double* row = S_.data() + a * nz_;
        for (int b = 0; b <= a; ++b) row[b] = base[order_[b]] + motion * moves[order_[b]] + colour * colours[order_[b]];
        row[a] += R_[a];
    }
    if (!inverse_.decompose(S_, in.count)) return false;
    evidence_[p] = -0.5 * (inverse_.square(nu_) + inverse_.log_determinant());
    return true;
}

// The modes add less to the evidence than under the stated process: with more process noise there is less for them to explain. So no
// process is overlooked.
bool JointHypotheses::needs_a_sweep(int p) const {
    return process_belief_[p] * std::exp(evidence_[p] + by_modes_ - evidence_[0]) > sweep_from * process_belief_[0];
}

void JointHypotheses::sweep(const Innovations& in, int p) {
    inverse_.invert();
    inverse_.solve(nu_, solved_);
    for (int a = 0; a < in.count; ++a)
        for (int b = 0; b <= a; ++b) inverse_S_(a, b) = inverse_S_(b, a) = inverse_.inverse(a, b);
    modes_of_[p] = p;
    LogProduct factors;
    double exponents = 0;
    for (int a = 0; a < in.count; ++a) {
        const int i = order_[a];
        const double fresh = in.fresh[i];
        if (!(fresh > 0)) continue;
        const double spread = 1 / inverse_S_(a, a), r = solved_[a] * spread;
        const double others = std::fmax(0, spread - R_[a]);
        const double exponent = weigh(i, r, others, fresh);
        const double total = weigh_modes(i, p, prior_of(i));
        double precision = 0;
        for (int m = 0; m < modes(); ++m) precision += posterior(p, i)[m] * precision_[m];
        factors.times(total * std::sqrt(spread));
        exponents += exponent + 0.5 * r * solved_[a];
        innovation_[p * nz_ + i] = r;
        variance_[p * nz_ + i] = others + fresh;
        const double found = fresh / std::fmax(precision, least_precision_);
        change_noise(a, in.count, found - R_[a]);
        R_[a] = found;
    }
    const double by_modes = exponents + factors.log();
    evidence_[p] += by_modes;
    if (p == 0) by_modes_ = by_modes;
}

double JointHypotheses::weigh(int i, double r, double others, double fresh) {
    double* likelihood = likelihood_ + i * modes();
    const double half = 0.5 * r * r, away = r - tracked_[i];
    for (int g = 0; g < settings_.levels; ++g) {
        weight_[g] = 1 / (others + level_[g] * fresh);
        likelihood[g] = -half * weight_[g];
    }
    const int bias = bias_mode();
    weight_[bias] = 1 / (others + fresh + tracked_variance_[i]);
    likelihood[bias] = -0.5 * away * away * weight_[bias];
    // The widest level explains an innovation at least as well as the narrower ones.
    const double largest = std::fmax(likelihood[bias - 1], likelihood[bias]);
    for (int m = 0; m < modes(); ++m) likelihood[m] = std::exp(likelihood[m] - largest) * std::sqrt(weight_[m]);
    return largest;
}

double JointHypotheses::weigh_modes(int i, int p, const double* prior) {
    const double* likelihood = likelihood_ + i * modes();
    double *answer = posterior(p, i), total = 0;
    for (int m = 0; m < modes(); ++m) {
        answer[m] = prior[m] * likelihood[m];
        total += answer[m];
    }
    const double inverse_total = 1 / total;
    for (int m = 0; m < modes(); ++m) answer[m] *= inverse_total;
    return total;
}

// A change of one channel's noise changes the inverse of S by the outer product of its column. Columns of the channels before it are
// not needed any more.
void JointHypotheses::change_noise(int a, int count, double change) {
    const double factor = change / (1 + change * inverse_S_(a, a)), there = factor * solved_[a];
    const double* __restrict column = inverse_S_.data() + a * nz_; // its row, by symmetry
    for (int b = a + 1; b < count; ++b) {
        double* __restrict row = inverse_S_.data() + b * nz_;
        const double by = factor * column[b];
        for (int c = a + 1; c < count; ++c) row[c] -= by * column[c];
        solved_[b] -= there * column[b];
    }
}

void JointHypotheses::weigh_common(const Innovations& in) {
    LogProduct ratio;
    for (int a = 0; a < in.count; ++a) {
        const int i = in.present[a];
        if (!(in.fresh[i] > 0)) continue;
        double told = 0;
        for (int m = 0; m < modes(); ++m) {
            told += prior_of(i)[m] * likelihood_[i * modes() + m];
            weight_[m] = prior_of(i)[m] + begins(i, m);
        }
        ratio.times(weigh_modes(i, common, weight_) / told);
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
        double prior = p == common ? process_belief_[0] * settings_.common_probability : process_belief_[p];
        if (p == 0) prior *= 1 - settings_.common_probability;
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
        bias_[i] *= 1 - settings_.bias_fading;
        if (!(in.fresh[i] > 0)) continue;
        if (measured) {
            merge_channel(i);
            bias_[i] = std::fmin(1, std::fmax(bias_[i], belief(i)[bias_mode()]));
            if (belief(i)[bias_mode()] > settings_.bias_certain) open(i, in.fresh[i]);
        } else {
            std::copy(lasting_ + i * modes(), lasting_ + (i + 1) * modes(), belief(i));
            belief(i)[0] += was_healthy_[i] * settings_.outlier_probability; // an outlier lasts one sample
        }
        noise_[i] = fault_of(i);
    }
}

void JointHypotheses::merge_channel(int i) {
    double* now = belief(i);
    for (int m = 0; m < modes(); ++m) now[m] = weight_of_modes_[0] * posterior(0, i)[m];
    const double stated = weight_of_modes_[0] + hypothesis_[common];
    double precision = 0, r = stated * innovation_[i], variance = stated * variance_[i];
    for (int p = 1; p < swept_; ++p) {
        const double weight = weight_of_modes_[p];
        if (!(weight > 0)) continue;
        r += weight * innovation_[p * nz_ + i];
        variance += weight * variance_[p * nz_ + i];
        for (int m = 0; m < modes(); ++m) now[m] += weight * posterior(p, i)[m];
    }
    for (int m = 0; m < modes(); ++m) {
        const double together = hypothesis_[common] * posterior(common, i)[m];
        precision += (now[m] + together) * precision_[m];
        // An outlier, by its share of the prior, lasts one sample.
        double over = 0;
        if (passing(i, m) > 0) {
            over = passing(i, m) * (now[m] / prior_of(i)[m] + together / (prior_of(i)[m] + begins(i, m)));
            now[0] += over;
        }
        now[m] += together - over;
    }
    scale_[i] = 1 / std::fmax(precision, least_precision_);
    const double gain = tracked_variance_[i] / (tracked_variance_[i] + variance);
    tracked_[i] += gain * (r - tracked_[i]);
    tracked_variance_[i] *= 1 - gain;
}

void JointHypotheses::open(int i, double fresh) {
    opened_[i] = settings_.bias_sigma * settings_.bias_sigma * fresh;
    std::fill(belief(i), belief(i) + modes(), 0.0);
    belief(i)[0] = 1;
    scale_[i] = 1;
    bias_[i] = 1;
}

double JointHypotheses::fault_of(int i) const {
    double sum = 0;
    for (int g = 1; g < settings_.levels; ++g) sum += belief(i)[g];
    return std::fmin(1, sum); // a sum, with its rounding
}

} // namespace hnav
