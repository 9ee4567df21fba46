// Integrates the samples between two corrections in navigation axes, at their own times.
#include "attitude/ahrs/model.hpp"

namespace hnav {

// A vector that is constant in navigation axes, measured a share of a turn ago, in present body axes: to second order.
struct AhrsModel::TurnedOn {
    Vector3R now_b;
    Vector3R swept_b; // derivative by the share

    TurnedOn(const Vector3R& measured_b, const Vector3R& turn, R share) {
        const Vector3R turning = turn.cross(measured_b), again = turn.cross(turning);
        now_b = measured_b - share * turning + R(0.5) * share * share * again;
        swept_b = turning - share * again;
    }
};

void AhrsModel::forget_window(State& s) {
    for (int i = 4; i < nx; ++i) s.x[i] = 0;
    for (auto& of_axis : s.rate_moment)
        for (R& v : of_axis) v = 0;
    for (R& v : s.turned) v = 0;
    s.rate_power = s.turned_s = 0;
    for (int i = 0; i < 3; ++i) s.field_sum[i] = s.turn_sum[i] = 0;
    s.velocity_down = s.swept_velocity[0] = s.swept_velocity[1] = 0;
    s.field_count = s.field_s = s.force_s = s.force_gap_s = s.gap_rotation = 0;
}

// The rotation since the last event, under a constant rate.
void AhrsModel::add_turn(const State& s, Moment& moment) {
    using Pair = Eigen::Array<R, 2, 1>;
    const R* y = s.rate;
    const Pair y01(y[0], y[1]), y20(y[2], y[0]), y12(y[1], y[2]);
    for (int i = 0; i < 3; ++i) {
        R *row = moment[i], turn[3];
        for (int l = 0; l < 3; ++l) turn[l] = s.x[4 + 3 * l + i] - s.turned[3 * l + i];
        Eigen::Map<Pair>(row + 0) += turn[0] * y01;
        Eigen::Map<Pair>(row + 2) += Pair(turn[0], turn[1]) * y20;
        Eigen::Map<Pair>(row + 4) += turn[1] * y12;
        Eigen::Map<Pair>(row + 6) += turn[2] * y01;
        row[8] += turn[2] * y[2];
    }
}

void AhrsModel::take_turn(State& s) {
    const Vector3R u = turn_rate(s);
    const R T = s.x[13] - s.turned_s;
    s.rate_power += u.squaredNorm() * T;
    Eigen::Map<Vector3R>(s.force_turn) += u * T;
    s.turned_s = s.x[13];
    add_turn(s, s.rate_moment);
    std::copy(s.x + 4, s.x + 13, s.turned);
}

void AhrsModel::gather(State& s, const Event& event, R rate_s) const {
    const Matrix3R R_bn = rotation_matrix<R>(QuaternionR(s.x));
    if (s.has(event, gyro)) s.rest.note_rate(options_, Vector3R(s.rate), rate_s);
    if (s.has(event, accel)) gather_force(s, event, R_bn);
    if (!s.has(event, mag)) return;
    if (s.has_reference) gather_field(s, event, R_bn);
    else initialise_heading_by_field(s, vector_of<R>(event, mag));
}

// A force sample may be the mean of its interval, and so half an interval old, or a reading of its instant: the latency is estimated. Its
// error changes the velocity of a body that turns, which makes it observable.
void AhrsModel::gather_force(State& s, const Event& event, const Matrix3R& R_bn) const {
    const Vector3R measured_b = vector_of<R>(event, accel);
    const R since = R(event.t_s - s.last_s[accel]), T = interval(s, accel, event.t_s);
    Eigen::Map<Vector3R> turned(s.force_turn);
    const Vector3R turn = since > 0 ? Vector3R(turned * (T / since)) : Vector3R(Vector3R::Zero());
    turned.setZero();
    const TurnedOn force(measured_b - Vector3R(s.force_bias), turn, s.force_latency);
    const Vector3R force_n = R_bn * force.now_b, swept_n = R_bn * force.swept_b;
    s.swept_velocity[0] += swept_n[0] * T;
    s.swept_velocity[1] += swept_n[1] * T;
    s.velocity[0] += force_n[0] * T;
    s.velocity[1] += force_n[1] * T;
    s.velocity_down += force_n[2] * T;
    s.force_s += T;
    s.motion.note(force_n, T);
    if (since > T) s.force_gap_s += since - T;
    s.rest.note_force(options_, measured_b, T);
}

void AhrsModel::gather_field(State& s, const Event& event, const Matrix3R& R_bn) const {
    const Vector3R u = turn_rate(s), field_b = vector_of<R>(event, mag) / s.strength;
    Eigen::Map<Vector3R>(s.field_sum) += R_bn * TurnedOn(field_b, u, s.latency).now_b;
    Eigen::Map<Vector3R>(s.turn_sum) += R_bn * u;
    s.field_count += 1;
    s.field_s += interval(s, mag, event.t_s);
}

} // namespace hnav
