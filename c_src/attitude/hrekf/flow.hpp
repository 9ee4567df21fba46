// Between events: the attitude and the integral of its rotation matrix under the held rate.
#pragma once

#include "attitude/common/attitude_flow.hpp"
#include "attitude/hrekf/model.hpp"

#include <algorithm>

namespace hnav {

template <class R>
void HrekfModelOf<R>::nominal(R* x) const {
    constexpr R usual_s = R(0.01); // between two corrections
    for (int i = 0; i < 4; ++i) x[i] = 1;
    std::fill(x + 4, x + nx, usual_s);
}

template <class R>
void HrekfModelOf<R>::flow(const State& s, const R* x, R* dx) const {
    if (s.started) AttitudeFlow<R>::derivative(turn_rate(s), x, dx);
    else std::fill(dx, dx + nx, R(0));
}

template <class R>
void HrekfModelOf<R>::flow_along(const State& s, const R* x, const R* direction, R* out) const {
    if (s.started) AttitudeFlow<R>::along(turn_rate(s), x, direction, out);
    else std::fill(out, out + nx, R(0));
}

template <class R>
void HrekfModelOf<R>::flow_exactly(State& s, double interval_s) const {
    AttitudeFlow<R>::exactly(turn_rate(s), R(interval_s), s.x);
}

} // namespace hnav
