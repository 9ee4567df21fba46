// Correction by the accelerometer: 0 = v + noise. The velocity of a body is bounded, which makes the tilt observable. The noise is that
// of a hand (motion_noise.hpp) plus that of lasting velocities (lasting_motion.hpp).
#include "attitude/ahrs/condition.hpp"

namespace hnav {

// The horizontal velocity as a sensor measures it.
InnovationOf<Scalar>& AhrsModel::record_velocity(InnovationOf<R>& i, double t_s, const Vector2R& innovation, const Matrix2R& S) {
    i = {};
    i.t_s = t_s;
    i.dimension = 2;
    i.value[0] = innovation[0];
    i.value[1] = innovation[1];
    i.S[0] = S(0, 0);
    i.S[1] = i.S[3] = S(0, 1);
    i.S[4] = S(1, 1);
    i.nis = normalised_square<2, R>(S, innovation);
    return i;
}

// PHt: columns of the velocity. T: since the last measurement of its kind, s. evidence, withheld: as of condition.
void AhrsModel::condition_on_velocity(State& s, Correction& c, const Eigen::Matrix<R, errors, 2>& PHt, const Matrix2R& S,
                                      const Vector2R& innovation, R T, Evidence* evidence, R withheld) {
    const Vector3R before = c.rotation_variances();
    condition<2, 0>(c, PHt, S, innovation, c.velocity_response, evidence, withheld);
    const Vector3R after = c.rotation_variances();
    s.information.gain_tilt(before, after);
    s.tilt_excess.pass(T);
    s.tilt_excess.note(c.error.data() + rotation, (before[0] + before[1] - after[0] - after[1]) / 2);
}

void AhrsModel::correct_velocity(State& s, Correction& c, double t_s, bool rests) const {
    const Eigen::Matrix<R, errors, 2> PHt = columns<2>(c.P, velocity);
    Matrix2R S = block<2, 2>(c.P, velocity, velocity);
    const R lasting2 = rests ? s.lasting.density2() : std::max(s.lasting.density2(), density_.lasting_density2);
    S.diagonal().array() += (s.motion.density2(density_.velocity_density2, rests) + lasting2) / s.force_s;
    const Vector2R innovation(-s.velocity[0], -s.velocity[1]);
    record_velocity(s.innovation[accel], t_s, innovation, S);
    const bool is_evidence = !may_accelerate_long(s);
    const R hiding2 = lasting2 - density_.swell_density2;
    if (is_evidence && hiding2 > 0) note_hidden_step(s, c, S, hiding2 / s.force_s, innovation);
    s.turning_force.note(s.rate_power, s.x[13]);
    condition_on_velocity(s, c, PHt, S, innovation, s.force_s, is_evidence ? &s.steps.evidence : nullptr,
                          s.turning_force.withheld(sigma_.force_bias));
    judge_hold(s, c.P(force_latency, force_latency));
}

// Evidence of a step of the gyro bias that the noise of lasting velocities hides. hiding2: its variance in S.
void AhrsModel::note_hidden_step(State& s, const Correction& c, const Matrix2R& S, R hiding2, const Vector2R& innovation) {
    const Matrix2R bounded = S - hiding2 * Matrix2R::Identity();
    const Cholesky<2, R> with(S), without(bounded);
    if (!without.positive()) return;
    const Response<2> stepped = c.velocity_response;
    s.steps.hidden.add(stepped, Response<2>(weighted<2>(without, stepped) - weighted<2>(with, stepped)), innovation);
}

// If rates act an interval later or earlier than the option gyro_hold states, attitude and force are out of step, which looks like a
// latency of the force by one interval d. The likelihood ratio of the estimated latency, l with variance P from l0 with P0, decides
// between its prior and the prior shifted by d: exp(+-(l - l0) d / P0 - d^2 (P0 - P) / (2 P0^2)).
void AhrsModel::judge_hold(State& s, R latency_variance) const {
    const R prior = sigma_.force_latency * sigma_.force_latency;
    if (!(prior > 0 && s.spacing_s[gyro] > 0 && s.spacing_s[accel] > 0)) return;
    const R expected = s.reversed ? -R(options_.start_accel_latency) : R(options_.start_accel_latency);
    const R interval = R(s.spacing_s[gyro] / s.spacing_s[accel]);
    const R learnt = interval * interval * std::max(R(0), 1 - latency_variance / prior) / (2 * prior);
    const R moved = (s.force_latency - expected) * interval / prior;
    const R either = (std::exp(moved - learnt) + std::exp(-moved - learnt)) / 2; // cosh(moved) alone may overflow
    s.wrong_hold = 1 / (1 + (1 - suspected_hold) / (suspected_hold * either));
}

// The velocity state is relative to the present velocity, with this covariance.
void AhrsModel::forget_velocity(State& s, Correction& c, const Matrix2R& covariance) {
    s.velocity[0] = s.velocity[1] = 0;
    rows<2>(c.P, velocity).setZero();
    columns<2>(c.P, velocity).setZero();
    block<2, 2>(c.P, velocity, velocity) = covariance;
    segment<2>(c.error, velocity).setZero();
    c.velocity_response.setZero();
}

} // namespace hnav
