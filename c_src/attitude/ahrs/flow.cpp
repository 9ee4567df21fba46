// Before the flow over an interval: which samples are used, and the rate that holds.
#include "attitude/ahrs/model.hpp"

namespace hnav {

// Coning: if the axis of rotation turns, the mean rate of an interval misses a rotation, which follows from the rate of the interval
// before (Miller 1983).
void AhrsModel::hold(State& s, const Event& event) const {
    const Vector3R read = vector_of<R>(event, gyro), before(s.rate);
    const R T = R(event.t_s - s.last_s[gyro]);
    const bool follows = s.has_rate && T > 0;
    const Vector3R rate = follows && !s.gap_too_long ? mean_between<R>(hold_of(options_), Vector3R(s.read_rate), read) : read;
    Eigen::Map<Vector3R>(s.read_rate) = read;
    Eigen::Map<Vector3R> coning(s.coning);
    coning.setZero();
    if (follows && !s.is_gap(gyro, event.t_s)) {
        s.rate_change.note(rate - before, T);
        if (holds_backward(options_)) coning = T / 12 * before.cross(rate);
    }
    Eigen::Map<Vector3R>(s.rate) = rate;
    s.has_rate = 1;
    note_turning(s);
}

void AhrsModel::before_flow(State& s, const Event& event) const {
    const auto since_s = [&](int c) { return R(event.t_s - s.last_s[c]); };
    if (examine_event(s, event, limits_, !(s.rest.force_still > 0), since_s)) lose_rate(s, event.t_s);
    s.gap_too_long = s.started && gap_variance(s, event) > 1; // the turn in it is unknown
    if (!holds_backward(options_) || !s.has(event, gyro)) return;
    // Since the last rate sample, events of other sensors were processed under that rate. With backward hold the new rate replaces it for
    // this interval; if means are missing in between, that of both does.
    const R went_on_s = R(s.last_event_s - s.last_s[gyro]);
    const Vector3R before = turn_rate(s);
    hold(s, event);
    if (s.started && went_on_s > 0 && !s.gap_too_long) {
        const Vector3R now = turn_rate(s);
        const bool missing = hold_of(options_) == Hold::backward && s.is_gap(gyro, event.t_s);
        const Vector3R after = missing ? Vector3R(R(0.5) * (now + before)) : now;
        const QuaternionR back = rotation_quaternion<R>(before * -went_on_s), on = rotation_quaternion<R>(after * went_on_s);
        Eigen::Map<QuaternionR>(s.x) = multiply<R>(QuaternionR(s.x), multiply<R>(back, on));
    }
}

void AhrsModel::rehold(State& s, const Event& event, double T) const {
    const bool flowed = holds_backward(options_) && event.has(gyro) && s.started && T > 0 && !std::isinf(T);
    if (flowed) flow_exactly(s, -T);
    before_flow(s, event);
    if (flowed) flow_exactly(s, T);
}

} // namespace hnav
