// Steps of the attitude and of the biases, which are modelled as almost constant (estimation/steps.hpp).
#include "ins/model.hpp"

namespace hnav::ins {

void Model::begin_steps(State& s, Covariance& P, int window, double now_s) {
    for (int i = 0; i < errors; ++i)
        for (int j = 0; j < may_step; ++j) P.response[i][window * may_step + j] = i == row_phi + j;
    s.steps[window] = {};
    s.steps_since_s[window] = now_s;
}

// Rejected samples contain no evidence unless positions have decided that the state is wrong.
void Model::note_steps(State& s, const Measurement& m, const Correction& c) {
    if (c.scale > 1 && !(m.channel == velocity && s.contradiction.verdict == Contradiction::state_wrong)) return;
    for (int w = 0; w < step_windows; ++w) s.steps[w].add(c.steps[w], is_free(s) ? 1 / coarse : 1);
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
    if (step_) step_->before = P;
    const Eigen::Matrix<double, errors, 1> error = B * found.mean();
    if (is_free(s)) Eigen::Map<Eigen::Matrix<double, errors, 1>>(s.mean) += error;
    else apply(s, P, error.data());
    s.inconsistent_s = now_s;
    s.information_tilt = s.information_heading = s.information_velocity = 0;
    for (Consistency& fit : s.fits) fit.begin(fit.noise);
    for (int k = 0; k < step_windows; ++k) begin_steps(s, P, k, now_s);
}

// Looks for steps when innovations may be explained by them much better than by none.
void Model::admit_steps(State& s, Covariance& P, double now_s) const {
    // Sigmas of the steps of usual faults, length of the windows, and limits: chosen. By chance a window exceeds the limit with a probability of
    // 1e-4. While the heading is searched, errors of the linearisation add to the evidence: with 40 ships lose the heading (23 of 100 ready
    // instead of 24, 3.9 deg instead of 2.1), without the law a quadrotor is falsely ready for 36 % of the time after a step of the force of
    // 2 m/s2 (28 %).
    constexpr double angle_rad = 0.05, gyro_rad_s = 0.02, accel_m_s2 = 1, window_s = 20, limit = 18, limit_free = 80;
    constexpr double sigmas[may_step] = {angle_rad,  angle_rad,  angle_rad,  gyro_rad_s, gyro_rad_s,
                                         gyro_rad_s, accel_m_s2, accel_m_s2, accel_m_s2};
    if (std::isnan(s.steps_since_s[0]))
        for (int w = 0; w < step_windows; ++w) begin_steps(s, P, w, now_s);
    if (!has_judged(s)) return;
    for (int w = 0; w < step_windows; ++w) {
        const Steps<may_step> found(s.steps[w], sigmas);
        if (found.twice_log_ratio() > (is_free(s) ? limit_free : limit)) return take_steps(s, P, w, found, now_s);
    }
    const int older = s.steps_since_s[0] < s.steps_since_s[1] ? 0 : 1;
    if (has_passed(now_s - s.steps_since_s[1 - older], window_s / step_windows)) begin_steps(s, P, older, now_s);
}

} // namespace hnav::ins
