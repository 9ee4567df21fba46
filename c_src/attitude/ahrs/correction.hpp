// A correction: the covariance of now, what each sensor says about the error, and the error taken out of the state.
#pragma once

#include "attitude/ahrs/model.hpp"
#include "maths/repair.hpp"
#include "maths/scalar.hpp"

namespace hnav {

extern template bool repair<20>(Square<20, Scalar>& P); // repair.cpp

template <class R>
void AhrsModelOf<R>::correct(State& s, const Event& event) const {
    constexpr R runaway_heading_rad = R(0.2); // what tilts the horizon may have turned the heading too
    Correction c{unpack<errors>(s.P)};
    s.gap_rotation += gap_variance(s, event);
    propagate(c.P, s);
    inflate_tilt(s, c.P);

    if (s.lost) find_attitude(s, c);
    else if (s.force_s > 0 && !correct_velocity(s, c, event.t_s)) lose_attitude(s, c, runaway_heading_rad);
    if (!s.lost) {
        if (s.rest.at_rest(settings_.rest)) correct_rest(s, c);
        if (s.field_count > 0 && s.field_s > 0) correct_field(s, c, event.t_s);
        correct_by_aids(s, c, event, std::make_integer_sequence<int, channel_count - heading>());
    }

    apply(s, c.error);
    keep(s, c);
    forget_window(s);
    s.last_correction_s = event.t_s;
    ++s.corrections;
}

template <class R>
template <int... after_heading>
void AhrsModelOf<R>::correct_by_aids(State& s, Correction& c, const Event& event,
                                     std::integer_sequence<int, after_heading...>) const {
    ((event.has(heading + after_heading) ? correct_by<Aid<heading + after_heading>>(s, c, event) : void()), ...);
}

// gamma is finite until the horizon is ready: the start may be further off than its sigma says. The heading is not
// inflated: one that was wrong from the start is found by evidence, which an inflated sigma would call a small change.
template <class R>
void AhrsModelOf<R>::inflate_tilt(State& s, Covariance& P) const {
    RobustReport<R> report;
    if (settings_.robust.mode != GammaMode::off && !tilt_ready(s))
        P = inflate_block<errors, 2>(P, rotation, Vector2R(1, 1), s.x[13], settings_.robust, &report);
    s.gamma = report.gamma;
    s.gamma_margin = report.margin;
    s.gamma_raised += report.raised;
}

// innovation' S^-1 innovation; 0 where S has no sign.
template <int m, class R>
inline R normalised_square(const Square<m, R>& S, const Eigen::Matrix<R, m, 1>& innovation) {
    const Cholesky<m, R> factor(S);
    return factor.positive() ? factor.template quadratic_form<1>(innovation)(0, 0) : 0;
}

// The errors from row `first` on learn from m rows H with PHt = P H' and S = H P H' + noise; those before are considered,
// not corrected (Schmidt): P_ij -= PHt_i S^-1 PHt_j' unless both i and j are. Nothing is learnt where rounding has left S
// without its sign: a reading beyond all sense, millions of times another.
template <class R>
template <int m, int first>
void AhrsModelOf<R>::condition(Correction& c, const Eigen::Matrix<R, errors, m>& PHt, const Square<m, R>& S,
                               const Eigen::Matrix<R, m, 1>& innovation) {
    constexpr int rest = errors - first;
    const Cholesky<m, R> factor(S);
    if (!factor.positive()) {
        c.sound = false;
        return;
    }
    const Eigen::Matrix<R, m, rest> Kt = factor.template solve<rest>(rows<rest>(PHt, first).transpose());
    segment<rest>(c.error, first).noalias() += Kt.transpose() * innovation;
    for (int j = 0; j < rest; ++j) {
        Vector column = c.P.col(first + j);
        for (int k = 0; k < m; ++k) column -= Kt(k, j) * PHt.col(k);
        c.P.col(first + j) = column;
    }
    if constexpr (first > 0) block<rest, first>(c.P, first, 0) = block<first, rest>(c.P, 0, first).transpose();
}

template <class R>
void AhrsModelOf<R>::apply(State& s, const Vector& error) {
    constexpr R max_latency_s = 1; // later fields are turned by more than two terms of a series tell
    Eigen::Map<QuaternionR> q(s.x);
    q = multiply<R>(rotation_quaternion<R>(segment<3>(error, rotation)), QuaternionR(q)).normalized();
    Eigen::Map<Vector3R>(s.bias) += segment<3>(error, bias);
    Eigen::Map<Eigen::Matrix<R, 9, 1>>(s.calibration) += segment<9>(error, calibration);
    Eigen::Map<Vector2R>(s.velocity) += segment<2>(error, velocity);
    Eigen::Map<Vector2R>(s.reference) += segment<2>(error, reference);
    // By what north means; a correction near a magnetic pole may not see it.
    s.reference[0] = std::fmax(R(0), s.reference[0]);
    s.latency = std::clamp(s.latency + error[latency], -max_latency_s, max_latency_s);
}

// A variance that is not positive is the first that rounding would break; only then, or when a correction met a matrix
// without its sign, is the whole matrix looked at.
template <class R>
void AhrsModelOf<R>::keep(State& s, Correction& c) {
    if (!c.sound || !(c.P.diagonal().minCoeff() > 0)) s.repaired += repair<errors>(c.P);
    pack<errors>(c.P, s.P);
    // What is no number any more must not stay: the engine looks at x and drops the event.
    if (!std::isfinite(c.P.diagonal().sum() + c.error.sum())) s.x[0] = std::numeric_limits<R>::quiet_NaN();
}

} // namespace hnav
