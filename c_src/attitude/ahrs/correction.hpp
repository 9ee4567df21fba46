// A correction: propagates the covariance, estimates the error from each sensor, and removes it from the state.
#pragma once

#include "attitude/ahrs/condition.hpp"
#include "attitude/ahrs/correct_field.hpp"
#include "attitude/ahrs/correct_rest.hpp"
#include "attitude/ahrs/correct_velocity.hpp"

namespace hnav {

template <class R>
void AhrsModelOf<R>::correct(State& s, const Event& event) const {
    Correction c(s);
    s.gap_rotation += gap_variance(s, event);
    propagate(c.P, s);
    forget_declination(s, c.P);
    inflate_tilt(s, c.P);

    const bool rests = !s.lost && is_at_rest(s, c);
    if (s.lost) {
        find_attitude(s, c);
    } else if (s.force_s > 0) {
        note_motion(s, c);
        if (is_given_to_travel() && rests && !(s.rests > 0)) begin_rest(s, c);
        if (!level_again(s, c)) correct_velocity(s, c, event.t_s, rests);
    }
    if (!s.lost) {
        if (rests) correct_rest(s, c);
        if (s.field_count > 0 && s.field_s > 0) correct_field(s, c, event.t_s);
        correct_by_aids(s, c, event, std::make_integer_sequence<int, channel_count - heading>());
    }

    if (!s.lost && s.vehicle_tilt.is_possible()) note_vehicle(s, c, rests);
    s.rests = rests;
    apply(s, c.error);
    s.lasting.turn(s.velocity, c.error[rotation], c.error[rotation + 1], R(gravity_m_s2));
    keep(s, c);
    forget_window(s);
    s.last_correction_s = event.t_s;
    ++s.corrections;
}

// Updates the motion monitors with the force since the last correction. A shock only makes the velocity uncertain.
template <class R>
void AhrsModelOf<R>::note_motion(State& s, Correction& c) const {
    constexpr R shock_m_s2 = 100;
    const R* before = s.lasting.before;
    const Vector3R gathered(s.velocity[0] - before[0], s.velocity[1] - before[1], s.velocity_down);
    if (gathered.norm() < shock_m_s2 * s.force_s) {
        const Vector3R tilt = c.rotation_variances();
        s.lasting.note(gathered, (tilt[0] + tilt[1]) / 2, R(gravity_m_s2), s.force_s);
        diagonal<2>(c.P, velocity).array() += s.lasting.uncount();
        return;
    }
    diagonal<2>(c.P, velocity).array() += gathered.squaredNorm();
    std::copy(before, before + 2, s.velocity);
    s.lasting.forget_force();
}

template <class R>
template <int... after_heading>
void AhrsModelOf<R>::correct_by_aids(State& s, Correction& c, const Event& event,
                                     std::integer_sequence<int, after_heading...>) const {
    ((event.has(heading + after_heading) ? correct_by<Aid<heading + after_heading>>(s, c, event) : void()), ...);
}

// gamma is finite until the horizon is ready, because the initial error may exceed its sigma. The heading is not inflated: a heading that
// was wrong from the start is found by evidence (reference_field.hpp), which an inflated sigma would hide.
template <class R>
void AhrsModelOf<R>::inflate_tilt(State& s, Covariance& P) const {
    RobustReport<R> report;
    if (robust_.mode != GammaMode::off && !is_given_to_travel() && !tilt_converged(s, 0))
        inflate_block<errors, 2>(P, rotation, Vector2R(1, 1), s.x[13], robust_, &report);
    s.gamma = report.gamma;
    s.gamma_margin = report.margin;
    s.gamma_raised += report.raised;
}

} // namespace hnav
