// Steps of the gyro bias: how the error responds to them, and what follows when one is likely (bias_steps.hpp).
#pragma once

#include "attitude/ahrs/model.hpp"

namespace hnav {

// Over the time since the last correction, as propagate does with the columns of P.
template <class R>
void AhrsModelOf<R>::carry_response(State& s) const {
    const Eigen::Map<const Matrix3R> G(s.x + 4);
    Eigen::Map<Eigen::Matrix<R, errors, 3>> response(s.steps.response);
    const Matrix3R before = rows<3>(response, rotation), after = before - G.lazyProduct(rows<3>(response, bias));
    const R half = R(0.5 * gravity_m_s2) * s.force_s;
    response.row(velocity) -= half * (before.row(1) + after.row(1));
    response.row(velocity + 1) += half * (before.row(0) + after.row(0));
    rows<3>(response, rotation) = after;
}

// Whether an accepted field shows a drift of the heading. Its azimuth also drifts while a disturbance passes, while a tilt is being found, and
// with the waves that tilt a ship. With iron on a body that has turned it does too: then the field is evidence that a step may be hidden, as
// with lasting velocities. Chosen: without the latter a hand's heading is ready and wrong for 6.4 % of the minute after a step of 1 deg/s, with it
// for 1.0 %; a quadrotor without a fault is ready for 79 % of the time instead of 85.
template <class R>
bool AhrsModelOf<R>::shows_drift(const State& s) const {
    constexpr R level_rad = R(0.045); // chosen: with 0.06 a belt (MOTION waist, with its body) has 1.40 instead of 0.90 deg
    return s.heading_confirmed != 0 && larger_tilt_variance(s) < level_rad * level_rad && options_.body != HNAV_BODY_SHIP;
}

// A likely step is added to the estimate, and its covariance to P.
template <class R>
void AhrsModelOf<R>::admit_steps(State& s, Correction& c) const {
    if (s.lost) return;
    s.steps.note_attitude(s.x);
    if (s.steps.look(s.x[13], s.rate_power, rotation)) {
        const Steps<3, R> found = s.steps.with_step();
        const Eigen::Matrix<R, errors, 3> spread = c.response * found.covariance();
        c.error += c.response * found.mean();
        for (int j = 0; j < errors; ++j)
            for (int i = 0; i <= j; ++i) c.P(i, j) += spread.row(i).dot(c.response.row(j));
    } else if (!s.steps.is_over()) {
        return;
    }
    begin_steps(s);
}

} // namespace hnav
