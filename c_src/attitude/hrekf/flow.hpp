// Between events: the attitude and the integral of its rotation matrix under the held rate.
#pragma once

#include "attitude/hrekf/model.hpp"

namespace hnav {

template <class R>
void HrekfModelOf<R>::nominal(R* x) const {
    constexpr R usual_s = R(0.01); // between two corrections
    for (int i = 0; i < 4; ++i) x[i] = 1;
    std::fill(x + 4, x + nx, usual_s);
}

template <class R>
void HrekfModelOf<R>::flow(const State& s, const R* x, R* dx) const {
    if (!s.started) {
        for (int i = 0; i < nx; ++i) dx[i] = 0;
        return;
    }
    const QuaternionR q(x);
    Eigen::Map<QuaternionR> q_rate(dx);
    q_rate = quaternion_rate<R>(q, turn_rate(s));
    Eigen::Map<Matrix3R>(dx + Place::A) = rotation_matrix<R>(q);
    dx[Place::t] = 1;
}

template <class R>
void HrekfModelOf<R>::flow_along(const State& s, const R* x, const R* direction, R* out) const {
    for (int i = 0; i < nx; ++i) out[i] = 0;
    if (!s.started) return;
    const QuaternionR q(x), dq(direction);
    Eigen::Map<QuaternionR> q_rate(out);
    q_rate = quaternion_rate<R>(dq, turn_rate(s));
    Eigen::Map<Matrix3R>(out + Place::A) = rotation_matrix_along<R>(q, dq);
}

// Exact, because the rate is held.
template <class R>
void HrekfModelOf<R>::flow_exactly(State& s, double interval_s) const {
    const R T = R(interval_s);
    const HeldTurn<R> turn(turn_rate(s), T);
    const QuaternionR q(s.x);
    Eigen::Map<Matrix3R>(s.x + Place::A).noalias() += rotation_matrix<R>(q) * turn.integral;
    put_q(s, multiply<R>(q, turn.q));
    s.x[Place::t] += T;
}

} // namespace hnav
