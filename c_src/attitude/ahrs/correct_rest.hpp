// Correction at rest: the mean rate is the bias of the gyroscope.
#pragma once

#include "attitude/ahrs/condition.hpp"

namespace hnav {

template <class R>
void AhrsModelOf<R>::correct_rest(const State& s, Correction& c) const {
    const Eigen::Matrix<R, errors, 3> PHt = columns<3>(c.P, bias);
    Matrix3R S = block<3, 3>(c.P, bias, bias);
    S.diagonal().array() += settings_.rest_bias_density2 / s.x[13];
    const Vector3R innovation = Vector3R(s.rest.mean_rate) - Vector3R(s.bias) - segment<3>(c.error, bias);
    condition<3, 0>(c, PHt, S, innovation);
}

} // namespace hnav
