// Steps of the attitude and of the biases, which are modelled as almost constant (estimation/steps.hpp).
#include "ins/model.hpp"

namespace hnav::ins {

void Model::begin_steps(State& s, Covariance& P, int window, double now_s) {
    for (int i = 0; i < errors; ++i)
        for (int j = 0; j < may_step; ++j) P.response[i][window * may_step + j] = i == row_phi + j;
    s.steps[window] = s.contradiction.steps[window] = {};
    s.steps_since_s[window] = now_s;
}

// A rejected sample is evidence only if it is a velocity and positions decide that the state is wrong. Until then its evidence is kept apart.
void Model::note_steps(State& s, const Measurement& m, const Correction& c) {
    const Contradiction::Verdict verdict = s.contradiction.verdict;
    const bool rejected = c.scale > 1;
    if (is_free(s) || (rejected && (m.channel != velocity || verdict == Contradiction::velocity_wrong))) return;
    StepEvidence<may_step>* into = rejected && verdict == Contradiction::open ? s.contradiction.steps : s.steps;
    for (int w = 0; w < step_windows; ++w) into[w].add(c.steps[w]);
}

// Adds the likeliest steps of a window to the state, and their covariance to P: what was known before the window is then known as if its begin
// had been uncertain by the prior. The information that readiness needs must be gathered again.
void Model::take_steps(State& s, Covariance& P, int window, const Steps<may_step>& found, double now_s) const {
    Eigen::Matrix<double, errors, may_step> B;
    for (int i = 0; i < errors; ++i)
        B.row(i) = Eigen::Map<const Steps<may_step>::Vector>(P.response[i] + window * may_step).transpose();
    const Eigen::Matrix<double, errors, may_step> BC = B * found.covariance();
    for (int i = 0; i < P.n; ++i)
        for (int j = 0; j < P.n; ++j) P[i][j] += BC.row(i).dot(B.row(j));
    const Eigen::Matrix<double, errors, 1> error = B * found.mean();
    apply(s, P, error.data());
    if (step_) step_->stepped(P);
    s.inconsistent_s = now_s;
    s.information_tilt = s.information_heading = s.information_velocity = 0;
    for (Consistency& fit : s.fits) fit.begin_again();
    for (int k = 0; k < step_windows; ++k) begin_steps(s, P, k, now_s);
}

// Looks for steps when innovations may be explained by them much better than by none. While the heading is searched, errors of the linearisation
// look like steps: ships would not find their heading.
void Model::admit_steps(State& s, Covariance& P, double now_s) const {
    if (is_free(s)) return;
    // Sigmas of the steps of usual faults, and limit: chosen. By chance a window exceeds the limit with a probability of 1e-4.
    constexpr double angle_rad = 0.05, gyro_rad_s = 0.02, accel_m_s2 = 1, limit = 18;
    constexpr double sigmas[may_step] = {angle_rad,  angle_rad,  angle_rad,  gyro_rad_s, gyro_rad_s,
                                         gyro_rad_s, accel_m_s2, accel_m_s2, accel_m_s2};
    if (std::isnan(s.steps_since_s[0]))
        for (int w = 0; w < step_windows; ++w) begin_steps(s, P, w, now_s);
    if (!expects_steps_ || !has_judged(s)) return;
    int likeliest = 0;
    double ratio = -HUGE_VAL;
    for (int w = 0; w < step_windows; ++w) {
        const double of_window = Steps<may_step>(s.steps[w], sigmas).twice_log_ratio();
        if (!(of_window > ratio)) continue;
        likeliest = w;
        ratio = of_window;
    }
    if (ratio > limit) return take_steps(s, P, likeliest, Steps<may_step>(s.steps[likeliest], sigmas), now_s);
    const int older = s.steps_since_s[0] < s.steps_since_s[1] ? 0 : 1;
    if (has_passed(now_s - s.steps_since_s[1 - older], steps_window_s / 2)) begin_steps(s, P, older, now_s);
}

} // namespace hnav::ins
