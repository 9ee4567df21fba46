// A correction: propagates the covariance, estimates the error from each sensor, and removes it from the state.
#pragma once

#include "attitude/ahrs/admit_steps.hpp"
#include "attitude/ahrs/condition.hpp"
#include "attitude/ahrs/correct_field.hpp"
#include "attitude/ahrs/correct_rest.hpp"
#include "attitude/ahrs/correct_velocity.hpp"

namespace hnav {

template <class R>
void AhrsModelOf<R>::correct(State& s, const Event& event) const {
    Correction c(s);
    s.gap_rotation += gap_variance(s, event);
    carry_response(s);
    propagate(c.P, s);
    forget_declination(s, c.P);
    inflate_tilt(s, c.P);

    if (s.speed.is_fresh()) travel(s, c);
    const bool rests = !s.lost && !s.speed.moves() && is_at_rest(s, c);
    if (s.lost) {
        find_attitude(s, c);
    } else if (s.force_s > 0) {
        correct_by_force(s, c, event.t_s, rests);
    }
    if (!s.lost) {
        if (rests) correct_rest(s, c);
        if (s.field_count > 0 && s.field_s > 0) correct_field(s, c, event.t_s);
        correct_by_aids(s, c, event, std::make_integer_sequence<int, channel_count - heading>());
    }

    admit_steps(s, c);
    if (!s.lost && s.vehicle_tilt.is_possible()) note_vehicle(s, c, rests);
    s.rests = rests;
    if (s.speed.is_fresh()) turn_velocity(s, segment<3>(c.error, rotation));
    apply(s, c.error);
    s.lasting.turn(s.velocity, c.error[rotation], c.error[rotation + 1], R(gravity_m_s2));
    keep(s, c);
    forget_window(s);
    s.last_correction_s = event.t_s;
    ++s.corrections;
}

template <class R>
void AhrsModelOf<R>::correct_by_force(State& s, Correction& c, double t_s, bool rests) const {
    note_motion(s, c);
    // A vehicle at constant velocity is as quiet as one at rest.
    if (is_given_to_travel() && rests && !(s.rests > 0)) forget_velocity(s, c, start_velocity_covariance());
    if (!level_again(s, c) && (rests || !s.speed.is_fresh())) correct_velocity(s, c, t_s, rests);
}

// The angle between the horizon and the mean force, about north and east, is that of the error of the tilt plus this matrix times that of
// the accelerometer's bias, rad per m/s^2. A horizon that was found from a biased force agrees with it: the two cancel until the body turns.
template <class R>
Eigen::Matrix<R, 2, 3> AhrsModelOf<R>::tilt_of_force_bias(const State& s) {
    const Eigen::Map<const Matrix3R> G(s.x + 4);
    const R share = s.x[13] > 0 ? 1 / (R(gravity_m_s2) * s.x[13]) : 0;
    Eigen::Matrix<R, 2, 3> J;
    J << -share * G.row(1), share * G.row(0);
    return J;
}

// Variance of the horizontal force of one axis by errors of the horizon and of the accelerometer's bias, (m/s^2)^2.
template <class R>
R AhrsModelOf<R>::explained_force2(const State& s, const Correction& c) {
    const Eigen::Matrix<R, 2, 3> J = tilt_of_force_bias(s);
    const Matrix3R P_bias = block<3, 3>(c.P, force_bias, force_bias);
    R sum = 0;
    for (int i = 0; i < 2; ++i) {
        const Vector3R axis = J.row(i), shared = block<3, 1>(c.P, force_bias, rotation + i);
        sum += c.P(rotation + i, rotation + i) + 2 * axis.dot(shared) + axis.dot(P_bias * axis);
    }
    return std::max(R(0), R(gravity_m_s2) * R(gravity_m_s2) * sum / 2);
}

// Updates the motion monitors with the force since the last correction. A shock only makes the velocity uncertain.
template <class R>
void AhrsModelOf<R>::note_motion(State& s, Correction& c) const {
    constexpr R shock_m_s2 = 100;
    const R* before = s.lasting.before;
    const Vector3R gathered(s.velocity[0] - before[0], s.velocity[1] - before[1], s.velocity_down);
    if (gathered.norm() < shock_m_s2 * s.force_s) {
        s.lasting.note(gathered, explained_force2(s, c), R(gravity_m_s2), s.force_s);
        const R released2 = s.lasting.uncount();
        if (!s.speed.is_fresh()) diagonal<2>(c.P, velocity).array() += released2;
        return;
    }
    diagonal<2>(c.P, velocity).array() += gathered.squaredNorm();
    std::copy(before, before + 2, s.velocity);
    s.lasting.forget_force();
}

// The velocity along body x turns with the heading, and so does its error with the bias and the noise of the gyroscope. Without speeds for
// too long the velocity is unknown again.
template <class R>
void AhrsModelOf<R>::travel(State& s, Correction& c) const {
    s.speed.left_s -= s.x[13];
    if (!s.speed.is_fresh()) {
        forget_velocity(s, c, start_velocity_covariance());
        return;
    }
    const Vector2R across(-s.velocity[1], s.velocity[0]);
    const Eigen::Map<const Matrix3R> G(s.x + 4);
    const Vector drift = columns<3>(c.P, bias) * G.row(2).transpose();
    const R noise = rotation_noise(s), variance = G.row(2).dot(segment<3>(drift, bias)) + noise;
    for (int i = 0; i < 2; ++i) {
        c.P.row(velocity + i) += across[i] * drift.transpose();
        c.P.col(velocity + i) += across[i] * drift;
        c.velocity_response.row(i) += across[i] * G.row(2) * c.template stepped<3>(bias);
    }
    block<2, 2>(c.P, velocity, velocity) += variance * across * across.transpose();
    c.P.row(rotation + 2).template segment<2>(velocity) -= noise * across.transpose();
    c.P.col(rotation + 2).template segment<2>(velocity) -= noise * across;
}

// With the attitude, by a rotation vector in navigation axes.
template <class R>
void AhrsModelOf<R>::turn_velocity(State& s, const Vector3R& rotation_n) {
    const R down = s.speed.m_s * rotation_matrix<R>(QuaternionR(s.x))(2, 0);
    const Vector3R turned = rotate<R>(rotation_quaternion<R>(rotation_n), Vector3R(s.velocity[0], s.velocity[1], down));
    s.velocity[0] = turned[0];
    s.velocity[1] = turned[1];
}

template <class R>
template <int... after_heading>
void AhrsModelOf<R>::correct_by_aids(State& s, Correction& c, const Event& event,
                                     std::integer_sequence<int, after_heading...>) const {
    ((event.has(heading + after_heading) ? correct_by<Aid<heading + after_heading>>(s, c, event) : void()), ...);
}

// gamma is finite until the horizon is found, because the error of the start may exceed its sigma; without a force nothing would stop the
// growth. What grows is the angle between the horizon and the force. A tilt that a bias of the accelerometer cancels is not seen by the
// corrections: if it grew too, a hand whose accelerometer has a stated bias of .3 m/s^2 would have a sigma of 1e9 deg after two minutes.
// The heading is not inflated: a heading that was wrong from the start is found by evidence (reference_field.hpp), which an inflated sigma
// would hide.
template <class R>
void AhrsModelOf<R>::inflate_tilt(State& s, Covariance& P) const {
    RobustReport<R> report;
    if (robust_.mode != GammaMode::off && s.force_s > 0 && !is_given_to_travel() && !is_tilt_found(s)) {
        const Eigen::Matrix<R, 2, 3> J = tilt_of_force_bias(s);
        const Eigen::Matrix<R, 2, errors> LP = rows<2>(P, rotation) + J * rows<3>(P, force_bias);
        const Matrix2R LPL = columns<2>(LP, rotation) + columns<3>(LP, force_bias) * J.transpose();
        inflate<errors, 2, R>(P, LP, LPL, s.x[13], robust_, &report);
    }
    s.gamma = report.gamma;
    s.gamma_margin = report.margin;
    s.gamma_raised += report.raised;
}

} // namespace hnav
