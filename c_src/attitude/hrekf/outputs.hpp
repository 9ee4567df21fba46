// Outputs, in the quantities that all attitude filters have.
#pragma once

#include "attitude/hrekf/decay_rate.hpp"
#include "attitude/hrekf/model.hpp"
#include "base/small.hpp"

namespace hnav {

template <class R>
Quaternion HrekfModelOf<R>::attitude(const State& s) const {
    return QuaternionR(s.x).normalized().template cast<double>();
}

template <class R>
Estimate HrekfModelOf<R>::estimate(const State& s) const {
    const QuaternionR q = QuaternionR(s.x).normalized();
    Estimate e;
    e.started = s.started != 0;
    e.q_bn = q.template cast<double>();
    e.rate_b = turn_rate(s).template cast<double>();
    e.bias_b = Vector3R(s.bias).template cast<double>();
    if (!e.started) return e;
    const Covariance P = covariance(s);
    const Vector3R variances = diagonal<3>(P, 0);
    e.tilt_ready = tilt_ready(s, variances);
    e.heading_ready = heading_ready(s, variances);
    return e;
}

template <class R>
ErrorCovariance HrekfModelOf<R>::error_covariance(const State& s) const {
    return covariance(s).template cast<double>();
}

template <class R>
Matrix3 HrekfModelOf<R>::rotation_covariance(const State& s) const {
    const Covariance P = covariance(s);
    return block<3, 3>(P, 0, 0).template cast<double>();
}

template <class R>
Vector3 HrekfModelOf<R>::bias_variances(const State& s) const {
    return bias_covariance(s).diagonal().template cast<double>();
}

template <class R>
double HrekfModelOf<R>::bias_walk(const State& s) const {
    return std::sqrt(walk_level(s));
}

template <class R>
double HrekfModelOf<R>::decay_rate(const State& s) const {
    if constexpr (small_build) return 0; // the small build leaves it out
    else return hnav::decay_rate(s.error_map, s.P);
}

template <class R>
FieldEstimate HrekfModelOf<R>::field_estimate(const State& s) const {
    FieldEstimate f;
    f.known = s.has_reference != 0;
    f.strength_tesla = s.reference_strength;
    f.dip_rad = std::atan2(s.reference_down, s.reference_north);
    f.gate = s.innovation[mag].noise_scale > 1 ? FieldGate::inflated : FieldGate::accepted;
    return f;
}

template <class R>
void HrekfModelOf<R>::gyro_calibration(const State&, double* S, double* sigma) const {
    for (int i = 0; i < 9; ++i) S[i] = sigma[i] = 0;
}

} // namespace hnav
