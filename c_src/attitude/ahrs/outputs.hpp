// What the filter knows, in the quantities that all attitude filters tell.
#pragma once

#include "attitude/ahrs/covariance.hpp"

namespace hnav {

template <class R>
Estimate AhrsModelOf<R>::estimate(const State& s) const {
    const Vector3R rate = this->rate(s);
    QuaternionR q = QuaternionR(s.x).normalized();
    // The attitude as it will be at the present rate.
    if (settings_.output_latency_s != 0) q = multiply<R>(q, rotation_quaternion<R>(rate * settings_.output_latency_s));
    Estimate e;
    e.started = s.started != 0;
    e.rate_b = rate.template cast<double>();
    e.bias_b = Vector3R(s.bias).template cast<double>();
    e.q_bn = q.template cast<double>();
    e.tilt_ready = e.started && tilt_ready(s);
    e.heading_ready = e.started && heading_ready(s);
    return e;
}

template <class R>
Matrix3 AhrsModelOf<R>::rotation_covariance(const State& s) const {
    const ErrorCovariance C = error_covariance(s);
    return block<3, 3>(C, 0, 0);
}

template <class R>
Vector3 AhrsModelOf<R>::bias_variances(const State& s) const {
    Vector3 v;
    for (int i = 0; i < 3; ++i) v[i] = s.P[packed(bias + i, bias + i)] + settings_.bias_walk_psd * s.x[13];
    return v;
}

template <class R>
ErrorCovariance AhrsModelOf<R>::error_covariance(const State& s) const {
    Square<6, R> C;
    const Covariance P = unpack<errors>(s.P);
    block<3, 3>(C, 3, 3) = block<3, 3>(P, bias, bias);
    diagonal<3>(C, 3).array() += settings_.bias_walk_psd * s.x[13];
    if (!s.started) {
        rows<3>(C, 0).setZero();
        columns<3>(C, 0).setZero();
        block<3, 3>(C, 0, 0) = block<3, 3>(P, rotation, rotation);
        return C.template cast<double>();
    }
    State now = s;
    take_turn(now);
    const Turned turned(P, now);
    block<3, 3>(C, 0, 0) = turned.rotation;
    diagonal<3>(C, 0).array() += rotation_noise(now);
    C(2, 2) += heading_doubt(s);
    const Vector3R by_hold = rotation_matrix<R>(QuaternionR(s.x)) * rate(s) * R(s.spacing_s[gyro]);
    block<3, 3>(C, 0, 0) += s.wrong_hold * by_hold * by_hold.transpose();
    block<3, 3>(C, 0, 3) = rows<3>(turned.columns, bias).transpose();
    block<3, 3>(C, 3, 0) = rows<3>(turned.columns, bias);
    return C.template cast<double>();
}

template <class R>
double AhrsModelOf<R>::bias_walk(const State&) const {
    return std::sqrt(settings_.bias_walk_psd);
}

// Not computed: a correction considers states that it leaves alone, and the field may change its reference in between.
template <class R>
double AhrsModelOf<R>::decay_rate(const State&) const {
    return 0;
}

template <class R>
FieldEstimate AhrsModelOf<R>::field_estimate(const State& s) const {
    FieldEstimate f;
    f.known = s.has_reference != 0;
    f.strength_tesla = s.strength * std::hypot(s.reference[0], s.reference[1]);
    f.dip_rad = std::atan2(s.reference[1], s.reference[0]);
    f.latency_s = s.latency;
    f.latency_sigma_s = std::sqrt(honest_variances(Square<1, R>(s.P[packed(latency, latency)]))[0]);
    f.evidence_s = s.field.evidence_s;
    f.heading_trust_s = s.field.heading_trust_s;
    f.reference_changes = static_cast<int>(s.field.changes);
    switch (FieldVerdict(s.verdict)) {
    case FieldVerdict::accept: f.gate = FieldGate::accepted; break;
    case FieldVerdict::reject: f.gate = FieldGate::rejected; break;
    default: f.gate = FieldGate::inflated;
    }
    f.at_rest = s.rest.at_rest(settings_.rest);
    return f;
}

template <class R>
void AhrsModelOf<R>::gyro_calibration(const State& s, double* S, double* sigma) const {
    Eigen::Matrix<R, 9, 1> variances;
    for (int i = 0; i < 9; ++i) variances[i] = s.P[packed(calibration + i, calibration + i)];
    variances = honest_variances(variances);
    for (int i = 0; i < 9; ++i) {
        S[i] = s.calibration[i];
        sigma[i] = std::sqrt(variances[i]);
    }
}

} // namespace hnav
