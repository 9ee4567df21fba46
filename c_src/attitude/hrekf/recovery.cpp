// Sensor faults, gaps, and a lost attitude: which samples are used, which variances grow, and when the filter starts again.
#include "attitude/hrekf/model.hpp"

namespace hnav {

void HrekfModel::examine(State& s, const Event& event) const {
    const auto since_s = [&](int c) { return interval(s, c, event.t_s); };
    if (examine_event(s, event, limits_, s.force_changes != 0, since_s)) lose_rate(s, event.t_s);
}

// Variance of the rotation about faulty axes, with the rates of a hand.
void HrekfModel::lose_rate(State& s, double t_s) const {
    if (!s.started) return;
    const Matrix3R R_bn = rotation_matrix<R>(QuaternionR(s.x).normalized());
    Matrix3R lost = Matrix3R::Zero();
    for (int axis = 0; axis < 3; ++axis)
        lost += s.check[gyro].lost_rotation(axis, interval(s, gyro, t_s), t_s) * R_bn.col(axis) * R_bn.col(axis).transpose();
    widen(s, lost);
}

// Adds to the covariance of the rotation error about the navigation axes, which the flow leaves as it is.
void HrekfModel::widen(State& s, const Matrix3R& rotation_covariance) const {
    Covariance P = unpack<6>(s.P);
    block<3, 3>(P, 0, 0) += rotation_covariance;
    pack<6>(P, s.P);
    s.information = {};
}

// Once, with the rate that ends the gap; the flow went through it under one rate.
void HrekfModel::widen_for_gap(State& s, const Event& event) const {
    if (!s.has(event, gyro)) return;
    const R variance = s.rate_change.gap_variance(R(event.t_s - s.last_s[gyro]), holds_backward(options_), gap_turn_factor);
    widen(s, Matrix3R(variance * Matrix3R::Identity()));
}

// The mean force is far from the vertical although its length is that of gravity; or the turn in a gap is unknown.
bool HrekfModel::is_lost(State& s, const Event& event) const {
    constexpr R mean_s = 1, far_cosine = R(0.76); // 40 deg
    constexpr R g = R(earth::standard_gravity_m_s2), still_m_s2 = R(0.5);
    constexpr double max_gap_s = 1;
    const double since_s = event.t_s - s.last_s[gyro];
    if (is_gap(since_s, s.spacing_s) && has_passed(since_s, max_gap_s)) return true;
    if (!s.has(event, accel)) return false;
    const R T = interval(s, accel, event.t_s);
    Eigen::Map<Vector3R> mean(s.mean_force);
    const Vector3R away = rotation_matrix<R>(QuaternionR(s.x).normalized()) * vector_of<R>(event, accel) - mean;
    mean += T / (mean_s + T) * away;
    s.force_changes = away.squaredNorm() > still_m_s2 * still_m_s2;
    const R size = mean.norm();
    return std::fabs(size - g) < R(0.4) * g && -mean[2] < far_cosine * size;
}

// The estimated bias is kept, unless its prior excludes it: then it comes from wrong samples, and with it the attitude would be lost again
// and again, each time after seconds, until the bias has returned after a minute.
void HrekfModel::lose_attitude(State& s) const {
    constexpr R excluded = 10; // sigmas of the prior; chosen: every gyroscope is within
    const Vector3R off = Vector3R(s.bias) - Vector3(options_.start_gyro_bias_rad_s).cast<R>();
    if (off.lpNorm<Eigen::Infinity>() > excluded * R(options_.start_sigma_bias_rad_s)) begin_bias(s);
    realign(s);
    for (R& f : s.mean_force) f = 0;
    s.lost = 1;
    ++s.times_lost;
}

// A field that stays far from the reference contradicts the reference or the heading: the heading is ready again when enough
// information about it has been gathered afterwards.
void HrekfModel::note_contradiction(State& s, R interval_s) {
    constexpr R far = R(0.5), max_far_s = 2; // of the reference's length: about 30 deg
    const bool is_far = Eigen::Map<const Vector3R>(s.innovation[mag].value).squaredNorm() > far * far;
    s.field_far_s = std::fmax(R(0), s.field_far_s + (is_far ? interval_s : -interval_s));
    if (has_passed(s.field_far_s, max_far_s)) s.information.heading = 0;
}

} // namespace hnav
