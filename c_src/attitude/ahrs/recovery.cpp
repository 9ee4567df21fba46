// Finds a lost attitude again: after a force that contradicts the horizon (lasting_motion.hpp), or after a gap with an unknown turn.
// Estimated sensor errors are kept.
//
// After a gap there are no corrections. The force is averaged in gyro-stabilised axes until its mean is gravity; then the horizon is
// turned onto it, unless the angle is small enough for the usual corrections.
#include "attitude/ahrs/condition.hpp"

namespace hnav {

// Of a tilt that is unknown, rad^2.
constexpr Scalar any_tilt_variance = 1;

// Variance of the rotation about faulty axes.
void AhrsModel::lose_rate(State& s, double t_s) const {
    s.rest.quiet_s = s.rest.still_s = 0;
    if (!s.started) return;
    begin_steps(s); // the turn that it misses is no drift
    ++s.seldom_changes;
    const Matrix3R R_bn = rotation_matrix<R>(QuaternionR(s.x));
    for (int axis = 0; axis < 3; ++axis) {
        const R variance = s.check[gyro].lost_rotation(axis, interval(s, gyro, t_s), t_s);
        const Vector3R n = R_bn.col(axis);
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j) s.P[packed(rotation + i, rotation + j)] += variance * n[i] * n[j];
        s.lasting.lost_turn2 += variance;
    }
    s.information = {};
}

// heading_sigma: added to the heading, rad.
void AhrsModel::lose_attitude(State& s, Correction& c, R heading_sigma) const {
    const R heading_variance = std::fmin(any_angle_variance<R>, c.heading_variance() + heading_sigma * heading_sigma);
    forget_rotation(s, c.P, any_tilt_variance, heading_variance);
    c.error.setZero();
    s.velocity[0] = s.velocity[1] = 0;
    for (R& f : s.level_force) f = 0;
    s.level_s = 0;
    begin_motion(s);
    s.information = {};
    s.times_lost += !s.lost;
    s.lost = 1;
}

// The motion of the body is unknown.
void AhrsModel::begin_motion(State& s) const {
    constexpr R densities2 = MotionNoise<R>::densities * MotionNoise<R>::densities;
    s.motion.begin(density_.velocity_density2);
    s.tilt_excess = {};
    s.speed = {};
    s.vehicle_tilt = {};
    if (options_.body == HNAV_BODY_ANY) s.vehicle_tilt.begin();
    s.lasting.begin(density_.velocity_density2 / densities2);
}

// If the mean force of the last seconds has the length of gravity but not the direction of the vertical, turns the horizon onto it and
// returns true. Axes whose rotation was not measured turn during the sum: if it grows as a random walk, the sum is off by a third of its
// variance.
bool AhrsModel::level_again(State& s, Correction& c) const {
    constexpr R found_rad = R(0.1), lost_share = R(1.0 / 3);
    constexpr R heading_rad = R(0.2); // the cause of the tilt may have turned the heading too
    const R limit = R(options_.lost_ratio);
    if (!(limit > 0 && s.lasting.wrong_horizon(R(gravity_m_s2), density_.vertical2) > limit)) return false;
    turn_up(s, Vector3R(s.lasting.force));
    const R tilt_variance = std::fmin(any_tilt_variance, found_rad * found_rad + lost_share * s.lasting.lost_turn2);
    forget_rotation(s, c.P, tilt_variance, c.heading_variance() + heading_rad * heading_rad);
    c.error.setZero();
    s.velocity[0] = s.velocity[1] = 0;
    begin_motion(s);
    s.information = {};
    ++s.times_lost;
    return true;
}

// A direction in navigation axes becomes the vertical. The samples gathered since the last correction turn with the attitude.
void AhrsModel::turn_up(State& s, const Vector3R& up) {
    const Vector3R axis = up.cross(Vector3R(0, 0, -1));
    const Vector3R about = axis.norm() > 0 ? Vector3R(axis.normalized()) : Vector3R(1, 0, 0);
    Eigen::Map<QuaternionR> q(s.x);
    const QuaternionR turn = rotation_quaternion<R>(about * std::atan2(axis.norm(), -up[2]));
    q = multiply<R>(turn, QuaternionR(q)).normalized();
    const Matrix3R turned = rotation_matrix<R>(turn);
    for (R* sum : {s.field_sum, s.turn_sum}) {
        Eigen::Map<Vector3R> n(sum);
        n = (turned * n).eval();
    }
}

// Attitude and velocity get the prior of a start, uncorrelated with the sensor errors.
void AhrsModel::forget_rotation(State& s, Covariance& P, R tilt_variance, R heading_variance) const {
    begin_steps(s);
    rows<2>(P, velocity).setZero();
    columns<2>(P, velocity).setZero();
    rows<3>(P, rotation).setZero();
    columns<3>(P, rotation).setZero();
    diagonal<2>(P, velocity).setConstant(sigma_.velocity * sigma_.velocity);
    diagonal<3>(P, rotation) = Vector3R(tilt_variance, tilt_variance, heading_variance);
}

// The attitude of before the gap is kept, because the clock may have jumped while the body did not turn.
void AhrsModel::pass_gap(State& s, double t_s) const {
    Correction c(s);
    const R bias_variance = sigma_.bias * sigma_.bias;
    const R walked = density_.bias_walk_psd * R(t_s - s.last_s[gyro]);
    for (int i = bias; i < bias + 3; ++i) c.P(i, i) = std::fmax(c.P(i, i), std::fmin(bias_variance, c.P(i, i) + walked));
    lose_attitude(s, c, R(M_PI));
    keep(s, c);
    forget_window(s);
    s.last_correction_s = t_s;
    for (double& last : s.last_s)
        if (!std::isnan(last)) last = t_s;
    s.gap_too_long = 0;
}

// The clock was set: the body has hardly moved, but the time without samples is unknown.
void AhrsModel::widen_after_clock_jump(State& s) {
    constexpr R tilt_rad = R(clock_jump_tilt_rad), heading_rad = R(clock_jump_heading_rad);
    ++s.seldom_changes;
    s.P[packed(rotation, rotation)] += tilt_rad * tilt_rad;
    s.P[packed(rotation + 1, rotation + 1)] += tilt_rad * tilt_rad;
    s.P[packed(rotation + 2, rotation + 2)] += heading_rad * heading_rad;
}

void AhrsModel::find_attitude(State& s, Correction& c) const {
    constexpr R gathered_s = R(0.3), far_rad = R(0.35), found_rad = R(0.2);
    const Vector3R sum = Vector3R(s.velocity[0], s.velocity[1], s.velocity_down);
    s.velocity[0] = s.velocity[1] = s.velocity_down = 0;
    Eigen::Map<Vector3R> gathered(s.level_force);
    gathered += sum;
    s.level_s += s.force_s;
    const R g = R(gravity_m_s2);
    const bool violent = !(sum.norm() < 2 * g * s.force_s); // a shock goes on
    const Vector3R up = gathered / s.level_s;
    if (!violent && is_within(s.level_s, gathered_s)) return;
    gathered.setZero();
    s.level_s = 0;
    if (violent || !(std::fabs(up.norm() - g) < R(0.4) * g)) return;
    if (std::atan2(up.cross(Vector3R(0, 0, -1)).norm(), -up[2]) > far_rad) turn_up(s, up);
    forget_rotation(s, c.P, found_rad * found_rad, c.heading_variance());
    s.lost = 0;
}

} // namespace hnav
