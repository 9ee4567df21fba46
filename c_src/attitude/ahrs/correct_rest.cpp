// Correction at rest: the mean rate is the bias of the gyroscope.
#include "attitude/ahrs/condition.hpp"

namespace hnav {

// Whether the body is at rest: rate and force are quiet, and neither the field (of a given body) nor the bias shows a turn. A mean rate that
// is not the bias is a turn of the body, unless the field would have turned: then the bias has stepped.
bool AhrsModel::is_at_rest(State& s, Correction& c) const {
    if (!is_field_still(s) && is_given_to_travel()) {
        s.rest.still_s = 0;
        return false;
    }
    if (!s.rest.at_rest(options_)) return false;
    s.rest.wander.note(s.rest.mean_rate, s.x[13]);
    const Vector3R from_bias = Vector3R(s.rest.mean_rate) - Vector3R(s.bias);
    if (normalised_square<3, R>(block<3, 3>(c.P, bias, bias), from_bias) <= R(turn_nis)) return true;
    if (s.still_field.excludes_turn()) {
        admit_bias_at_rest(s, c, from_bias);
        return true;
    }
    s.rest.still_s = 0;
    return false;
}

// The bias has been wrong by so much, and the attitude has drifted by the turn that was none.
void AhrsModel::admit_bias_at_rest(State& s, Correction& c, const Vector3R& from_bias) const {
    const Vector3R drifted = rotation_matrix<R>(QuaternionR(s.x)) * Vector3R(s.still_field.turn);
    diagonal<3>(c.P, bias) += from_bias.cwiseAbs2();
    diagonal<3>(c.P, rotation) += drifted.cwiseAbs2();
    s.still_field.begin();
    begin_steps(s);
}

// Notes the field of a quiet body. Once the field has turned, the next one is the first.
bool AhrsModel::is_field_still(State& s) const {
    if (!(s.rest.quiet_s > s.x[13])) s.still_field.begin();
    if (!(s.rest.quiet_s > 0 && s.field_count > 0)) return true;
    const Vector3R field_b = rotation_matrix<R>(QuaternionR(s.x)).transpose() * Vector3R(s.field_sum) / s.field_count;
    if (s.still_field.note(field_b, Vector3R(s.rest.mean_rate) - Vector3R(s.bias), s.field_s)) return true;
    s.still_field.begin();
    return false;
}

// Whether an unknown body rests, if it is a vehicle: the field has been constant in body axes for longer than a bend would allow, and the
// force is vertical.
bool AhrsModel::is_vehicle_at_rest(const State& s, bool rests) const {
    constexpr R bend_s = 2;
    if (!rests || !(s.still_field.still_s > bend_s || s.used[mag] == 0)) return false;
    const Vector3R level = rotation_matrix<R>(QuaternionR(s.x)) * Vector3R(s.rest.mean_force) / R(gravity_m_s2);
    return s.vehicle_tilt.is_level(level.data());
}

void AhrsModel::note_vehicle(State& s, const Correction& c, bool rests) const {
    const R rest_density2 = is_vehicle_at_rest(s, rests) ? s.motion.density2(density_.velocity_density2, true) : 0;
    const R turn2 = density_.gyro_psd * s.x[13] + density_.gyro_rate_psd * s.rate_power;
    const R gathered[] = {s.velocity[0] - s.lasting.before[0], s.velocity[1] - s.lasting.before[1]};
    s.vehicle_tilt.note(gathered, c.error.data() + rotation, s.rate_power, turn2, rest_density2, R(gravity_m_s2), s.x[13]);
}

void AhrsModel::correct_rest(State& s, Correction& c) const {
    Eigen::Matrix<R, errors, 3> PHt;
    for (int k = 0; k < 3; ++k) PHt.col(k) = c.column(bias + k);
    Matrix3R S = rows<3>(PHt, bias);
    const Vector3R innovation = Vector3R(s.rest.mean_rate) - Vector3R(s.bias) - segment<3>(c.error, bias);
    s.lasting.settle(Vector3R(s.rest.mean_force).norm(), s.x[13]);
    S.diagonal().array() += (density_.rest_bias_density2 + s.rest.wander.density2()) / s.x[13];
    condition<3, 0>(c, PHt, S, innovation, c.stepped<3>(bias), &s.steps.evidence);
}

} // namespace hnav
