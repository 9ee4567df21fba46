// Between events: displacement, velocity and attitude under the held rate and force.
#include "ins/model.hpp"

namespace hnav::ins {
namespace {

// Twice integrated rotation of a held rate: integral over [0, T] of (T - t) exp([w]x t) dt.
Matrix3 twice_integrated(const Vector3& w, double T) {
    const double w2 = w.squaredNorm(), x2 = w2 * T * T;
    double b, c; // of [w]x and its square
    if (x2 < 0.01) {
        b = T * T * T * (1.0 / 6 - x2 / 120);
        c = T * T * T * T * (1.0 / 24 - x2 / 720);
    } else {
        const double n = std::sqrt(w2), x = n * T;
        b = (x - std::sin(x)) / (w2 * n);
        c = (0.5 * x2 - 1 + std::cos(x)) / (w2 * w2);
    }
    const Matrix3 W = cross_matrix(w);
    return 0.5 * T * T * Matrix3::Identity() + b * W + c * W * W;
}

// Change of gravity along a displacement, for a sphere: it decreases with the square of the distance from the centre.
Vector3 gravity_along(const State& s, const Vector3& way) {
    const Vector3 g = vec(s.gravity);
    const double strength = g.norm();
    if (!(strength > 0)) return Vector3::Zero();
    const Vector3 down = g / strength;
    return -strength / earth::equator_m * (way - 3 * down.dot(way) * down);
}

// Gravity at displacement d, linearised about the place where it was computed.
Vector3 gravity_near(const State& s, const Vector3& d) { return vec(s.gravity) + gravity_along(s, d - vec(s.gravity_at)); }

} // namespace

void Model::put_gravity(State& s) {
    const Matrix3 T = mat(s.axes);
    const Vector3 d = vec(s.x);
    vec(s.gravity) = T.transpose() * earth::gravity_at(vec(s.anchor_e) + T * d);
    vec(s.gravity_at) = d;
}

bool Model::plausible(const State& s) const {
    if (!s.started()) return true;
    const double length2 = quat(s.x + 6).squaredNorm();
    return length2 > 0.25 && length2 < 4 && vec(s.x).norm() < 1e8 && vec(s.x + 3).norm() < 1e5 && vec(s.gyro_bias).norm() < 1e3 &&
           vec(s.accel_bias).norm() < 1e4;
}

void Model::normalise(State& s) const {
    const double length2 = quat(s.x + 6).squaredNorm();
    if (!(length2 > 0.25 && length2 < 4)) quat(s.x + 6).normalize();
}

void Model::nominal(double* x) const {
    for (int i = 0; i < nx; ++i) x[i] = 1;
}

void Model::flow(const State& s, const double* x, double* dx) const {
    if (!s.started()) {
        for (int i = 0; i < nx; ++i) dx[i] = 0;
        return;
    }
    const Vector3 v(x + 3), W = vec(s.earth_rate);
    const Quaternion q(x + 6);
    vec(dx) = v;
    vec(dx + 3) = rotation_matrix(q) * specific_force(s) + gravity_near(s, vec(x)) - 2 * W.cross(v);
    quat(dx + 6) = Xi(q) * turn_rate(s) - 0.5 * across(q) * W;
}

void Model::flow_along(const State& s, const double* x, const double* direction, double* out) const {
    const Vector3 d_along(direction), v_along(direction + 3), W = vec(s.earth_rate);
    const Quaternion q(x + 6), q_along(direction + 6);
    vec(out) = v_along;
    vec(out + 3) = rotation_matrix_along(q, q_along) * specific_force(s) + gravity_along(s, d_along) - 2 * W.cross(v_along);
    quat(out + 6) = Xi(q_along) * turn_rate(s) - 0.5 * across(q_along) * W; // linear in q
}

void Model::flow_exactly(State& s, double interval_s) const {
    const double T = interval_s;
    const Vector3 w = turn_rate(s), f = specific_force(s), W = vec(s.earth_rate), d = vec(s.x), v = vec(s.x + 3);
    const Quaternion q = quat(s.x + 6);
    const Matrix3 R = rotation_matrix(q);
    const HeldTurn<double> turn(w, T);
    const Vector3 by_force = R * (turn.integral * f), g = gravity_near(s, d);
    // Coriolis acceleration and the gradient of gravity within the interval, to second order.
    const Vector3 a = g - 2 * W.cross(v), slope = gravity_near(s, d + T * v) - g;
    const Vector3 gained = by_force + a * T - (0.5 * T) * W.cross(by_force) - T * W.cross(by_force + a * T) + 0.5 * T * slope;
    vec(s.x) += v * T + R * (twice_integrated(w, T) * f) + 0.5 * T * T * a;
    vec(s.x + 3) += gained;
    quat(s.x + 6) = multiply(rotation_quaternion(W * -T), multiply(q, turn.q));
}

void Model::hold(State& s, const Event& event) const {
    const double* y = event.value[imu];
    const double interval_s = event.t_s - s.last_s[imu];
    s.held.hold(vec(y), vec(y + 3), interval_s, s.usual_interval_s, hold_of(options_));
    s.slow_noise.note(vec(y), vec(y + 3), interval_s);
}

void Model::before_flow(State& s, const Event& event) const {
    examine(s, event);
    const bool elsewhere = is_elsewhere(s, event);
    if (elsewhere) s.contradiction.verdict = Contradiction::velocity_wrong;
    note_stale(s, event, elsewhere);
    s.gap_too_long = has_passed(event.t_s - s.last_s[imu], options_.longest_gap_s) && std::isfinite(s.last_s[imu]);
    if (!holds_backward(options_) || !has_new(s, event, imu)) return;
    // Since the last IMU sample, events of aids were processed under that sample. With backward hold the new sample holds for this interval.
    const double went_on_s = s.last_event_s - s.last_s[imu];
    const bool flowed = s.started() && went_on_s > 0 && !s.gap_too_long;
    if (flowed) flow_exactly(s, -went_on_s);
    hold(s, event);
    if (flowed) flow_exactly(s, went_on_s);
}

void Model::rehold(State& s, const Event& event, double interval_s) const {
    const bool flowed = holds_backward(options_) && event.has(imu) && s.started() && interval_s > 0 && std::isfinite(interval_s);
    if (flowed) flow_exactly(s, -interval_s);
    before_flow(s, event);
    if (flowed) flow_exactly(s, interval_s);
}

} // namespace hnav::ins
