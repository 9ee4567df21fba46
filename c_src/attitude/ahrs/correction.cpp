// A correction: propagates the covariance, estimates the error from each sensor, and removes it from the state.
#include "attitude/ahrs/condition.hpp"
#include "maths/repair.hpp"

namespace hnav {

void AhrsModel::correct(State& s, const Event& event) const {
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
        if (event.has(heading)) correct_heading(s, c, event);
        if (event.has(speed)) correct_speed(s, c, event);
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

void AhrsModel::correct_by_force(State& s, Correction& c, double t_s, bool rests) const {
    note_motion(s, c);
    // A vehicle at constant velocity is as quiet as one at rest.
    if (is_given_to_travel() && rests && !(s.rests > 0)) forget_velocity(s, c, start_velocity_covariance());
    if (!level_again(s, c) && (rests || !s.speed.is_fresh())) correct_velocity(s, c, t_s, rests);
}

// The angle between the horizon and the mean force, about north and east, is that of the error of the tilt plus this matrix times that of
// the accelerometer's bias, rad per m/s^2. A horizon that was found from a biased force agrees with it: the two cancel until the body turns.
Eigen::Matrix<Scalar, 2, 3> AhrsModel::tilt_of_force_bias(const State& s) {
    const Eigen::Map<const Matrix3R> G(s.x + 4);
    const R share = s.x[13] > 0 ? 1 / (R(gravity_m_s2) * s.x[13]) : 0;
    Eigen::Matrix<R, 2, 3> J;
    J << -share * G.row(1), share * G.row(0);
    return J;
}

// Variance of the horizontal force of one axis by errors of the horizon and of the accelerometer's bias, (m/s^2)^2.
Scalar AhrsModel::explained_force2(const State& s, const Correction& c) {
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
void AhrsModel::note_motion(State& s, Correction& c) const {
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
void AhrsModel::travel(State& s, Correction& c) const {
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
        c.velocity_response.row(i) += across[i] * G.row(2) * c.stepped<3>(bias);
    }
    block<2, 2>(c.P, velocity, velocity) += variance * across * across.transpose();
    c.P.row(rotation + 2).segment<2>(velocity) -= noise * across.transpose();
    c.P.col(rotation + 2).segment<2>(velocity) -= noise * across;
}

// With the attitude, by a rotation vector in navigation axes.
void AhrsModel::turn_velocity(State& s, const Vector3R& rotation_n) {
    const R down = s.speed.m_s * rotation_matrix<R>(QuaternionR(s.x))(2, 0);
    const Vector3R turned = rotate<R>(rotation_quaternion<R>(rotation_n), Vector3R(s.velocity[0], s.velocity[1], down));
    s.velocity[0] = turned[0];
    s.velocity[1] = turned[1];
}

// gamma is finite until the horizon is found, because the error of the start may exceed its sigma; without a force nothing would stop the
// growth. What grows is the angle between the horizon and the force. A tilt that a bias of the accelerometer cancels is not seen by the
// corrections: if it grew too, a hand whose accelerometer has a stated bias of .3 m/s^2 would have a sigma of 1e9 deg after two minutes.
// The heading is not inflated: a heading that was wrong from the start is found by evidence (reference_field.hpp), which an inflated sigma
// would hide.
void AhrsModel::inflate_tilt(State& s, Covariance& P) const {
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

void AhrsModel::apply(State& s, const Vector& error) {
    constexpr R max_latency_s = 1; // limit of the second-order series
    constexpr R max_force_latency = 4; // in intervals; the same limit for the force
    Eigen::Map<QuaternionR> q(s.x);
    q = multiply<R>(rotation_quaternion<R>(segment<3>(error, rotation)), QuaternionR(q)).normalized();
    Eigen::Map<Vector3R>(s.bias) += segment<3>(error, bias);
    Eigen::Map<Eigen::Matrix<R, 9, 1>>(s.calibration) += segment<9>(error, calibration);
    note_turning(s);
    Eigen::Map<Vector2R>(s.velocity) += segment<2>(error, velocity);
    Eigen::Map<Vector3R>(s.force_bias) += segment<3>(error, force_bias);
    s.force_latency = std::clamp(s.force_latency + error[force_latency], -max_force_latency, max_force_latency);
    s.declination = wrap_angle(s.declination + error[declination]);
    Eigen::Map<Vector2R>(s.reference) += segment<2>(error, reference);
    // Keep the reference north; near a magnetic pole a correction may lose it.
    s.reference[0] = std::fmax(R(0), s.reference[0]);
    s.latency = std::clamp(s.latency + error[latency], -max_latency_s, max_latency_s);
}

// Rounding makes a variance non-positive first. Only then, or after an indefinite matrix in a correction, the whole matrix is
// repaired.
void AhrsModel::keep(State& s, Correction& c) {
    if (!c.sound || !(c.P.diagonal().minCoeff() > 0)) {
        for (int j = 0; j < errors; ++j) c.P.col(j) = c.column(j);
        s.repaired += repair<errors>(c.P);
    }
    pack_columns<errors>(c.P, s.P);
    ++s.seldom_changes;
    // NaN in the state must not persist: the engine checks x and ignores the event.
    if (!std::isfinite(c.P.diagonal().sum() + c.error.sum())) s.x[0] = std::numeric_limits<R>::quiet_NaN();
}

} // namespace hnav
