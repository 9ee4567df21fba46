// Correction at rest: the mean rate is the bias of the gyroscope.
#pragma once

#include "attitude/ahrs/condition.hpp"

namespace hnav {

template <class R>
void AhrsModelOf<R>::correct_rest(const State& s, Correction& c) const {
    Eigen::Matrix<R, errors, 3> PHt;
    for (int k = 0; k < 3; ++k) PHt.col(k) = c.column(bias + k);
    Matrix3R S = rows<3>(PHt, bias);
    S.diagonal().array() += density_.rest_bias_density2 / s.x[13];
    const Vector3R innovation = Vector3R(s.rest.mean_rate) - Vector3R(s.bias) - segment<3>(c.error, bias);
    condition<3, 0>(c, PHt, S, innovation);
}

} // namespace hnav
