// What the filter knows, in the quantities that all attitude filters tell.
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
    e.rate_b = turn_rate(s, s.x).template cast<double>();
    e.bias_b = Vector3R(s.x + 4).template cast<double>();
    const Vector3R variance = rotation_variances_of<R>(q, Blocks(s.x + 7).qq);
    e.tilt_ready = e.started && angle_ready(tilt_variance<R>(variance), s.information.tilt, R(options_.ready_tilt_rad));
    e.heading_ready = e.started && angle_ready(variance[2], s.information.heading, R(options_.ready_heading_rad));
    return e;
}

template <class R>
ErrorCovariance HrekfModelOf<R>::error_covariance(const State& s) const {
    const Blocks P(s.x + 7);
    const Matrix34Of<R> T = rotation_from_error<R>(QuaternionR(s.x).normalized());
    Square<6, R> C;
    block<3, 3>(C, 0, 0) = T * P.qq * T.transpose();
    block<3, 3>(C, 0, 3) = T * P.qb;
    block<3, 3>(C, 3, 0) = block<3, 3>(C, 0, 3).transpose();
    block<3, 3>(C, 3, 3) = P.bb;
    return C.template cast<double>();
}

template <class R>
Matrix3 HrekfModelOf<R>::rotation_covariance(const State& s) const {
    const Matrix34Of<R> T = rotation_from_error<R>(QuaternionR(s.x).normalized());
    const Matrix3R C = T * Blocks(s.x + 7).qq * T.transpose();
    return C.template cast<double>();
}

template <class R>
Vector3 HrekfModelOf<R>::bias_variances(const State& s) const {
    return Blocks(s.x + 7).bb.diagonal().template cast<double>();
}

template <class R>
double HrekfModelOf<R>::bias_walk(const State& s) const {
    return std::sqrt(unpack<3>(s.bias_psd).trace() / 3);
}

template <class R>
double HrekfModelOf<R>::decay_rate(const State& s) const {
    if constexpr (small_build) return 0; // a figure for who studies a filter
    else return hnav::decay_rate(s.error_map);
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
