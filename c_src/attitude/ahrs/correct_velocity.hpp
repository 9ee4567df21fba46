// Correction by the accelerometer: 0 = v + noise. A body moves, but it does not run away, and this tells the horizon. A
// velocity far beyond that bound says that the horizon is wrong, or the force.
#pragma once

#include "attitude/ahrs/condition.hpp"

namespace hnav {

// False: beyond the gate, and nothing was learnt.
template <class R>
bool AhrsModelOf<R>::correct_velocity(State& s, Correction& c, double t_s) const {
    const Vector3R before = c.rotation_variances();
    const Eigen::Matrix<R, errors, 2> PHt = columns<2>(c.P, velocity);
    Matrix2R S = block<2, 2>(c.P, velocity, velocity);
    S.diagonal().array() += s.motion.density2(settings_.velocity_density2) / s.force_s;
    const Vector2R innovation(-s.velocity[0], -s.velocity[1]);

    InnovationOf<R>& i = s.innovation[accel];
    i = {};
    i.t_s = t_s;
    i.dimension = 2;
    i.value[0] = innovation[0];
    i.value[1] = innovation[1];
    i.S[0] = S(0, 0);
    i.S[1] = i.S[3] = S(0, 1);
    i.S[4] = S(1, 1);
    i.nis = normalised_square<2, R>(S, innovation);

    if (settings_.velocity_gate_nis > 0 && i.nis > settings_.velocity_gate_nis) return false;
    condition<2, 0>(c, PHt, S, innovation);
    s.information.gain_tilt(before, c.rotation_variances());
    return true;
}

} // namespace hnav
