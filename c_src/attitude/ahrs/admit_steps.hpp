// Steps of the gyro bias: how the error responds to them, and what follows when one is likely (bias_steps.hpp).
#pragma once

#include "attitude/ahrs/model.hpp"

namespace hnav {

// Over the time since the last correction, as propagate does with the columns of P.
template <class R>
void AhrsModelOf<R>::carry_response(State& s) const {
    const Eigen::Map<const Matrix3R> G(s.x + 4);
    const Eigen::Map<const Matrix39R> L(s.rate_moment[0]);
    Eigen::Map<Eigen::Matrix<R, errors, 3>> response(s.steps.response);
    const R half = R(0.5 * gravity_m_s2) * s.force_s, forced = s.x[13] > 0 ? s.force_s / s.x[13] : 0;
    for (int j = 0; j < 3; ++j) {
        auto e = response.col(j);
        const Vector3R before = e.template segment<3>(rotation);
        Vector3R after = before;
        for (int k = 0; k < 3; ++k) after -= e[bias + k] * G.col(k);
        for (int k = 0; k < 9; ++k) after -= e[calibration + k] * L.col(k);
        e[velocity] -= half * (before[1] + after[1]);
        e[velocity + 1] += half * (before[0] + after[0]);
        for (int i = 0; i < 2; ++i) {
            e[velocity + i] -= s.swept_velocity[i] * e[force_latency];
            for (int k = 0; k < 3; ++k) e[velocity + i] -= forced * G(i, k) * e[force_bias + k];
        }
        e.template segment<3>(rotation) = after;
    }
}

// A likely step is added to the estimate, and its covariance to P.
template <class R>
void AhrsModelOf<R>::admit_steps(State& s, Correction& c) const {
    if (s.lost) return;
    if (s.steps.look(s.x[13], s.rate_power)) {
        const Steps<3, R> found = s.steps.with_step();
        const Eigen::Matrix<R, errors, 3> spread = c.response * found.covariance();
        c.error += c.response * found.mean();
        for (int j = 0; j < errors; ++j)
            for (int i = 0; i <= j; ++i) c.P(i, j) += spread.row(i).dot(c.response.row(j));
        begin_steps(s);
    } else if (s.steps.is_over()) {
        begin_steps(s);
    }
}

} // namespace hnav
