// Correction at rest: the mean rate is the bias of the gyroscope.
#pragma once

#include "attitude/ahrs/condition.hpp"

namespace hnav {

template <class R>
void AhrsModelOf<R>::correct_rest(State& s, Correction& c) const {
    constexpr R gate_nis = 16; // three degrees of freedom; beyond it the mean rate is a turn of the body, not the bias
    Eigen::Matrix<R, errors, 3> PHt;
    for (int k = 0; k < 3; ++k) PHt.col(k) = c.column(bias + k);
    Matrix3R S = rows<3>(PHt, bias);
    const Vector3R innovation = Vector3R(s.rest.mean_rate) - Vector3R(s.bias) - segment<3>(c.error, bias);
    s.rest.note_wander(s.x[13]);
    if (normalised_square<3, R>(S, innovation) > gate_nis) {
        s.rest.still_s = 0;
        return;
    }
    s.lasting.settle(Vector3R(s.rest.mean_force).norm(), s.x[13]);
    S.diagonal().array() += (density_.rest_bias_density2 + s.rest.wander_density2()) / s.x[13];
    condition<3, 0>(c, PHt, S, innovation);
}

} // namespace hnav
