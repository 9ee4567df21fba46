// Outputs, in the quantities that all attitude filters have.
#pragma once

#include "attitude/ahrs/covariance.hpp"

namespace hnav {

template <class R>
Quaternion AhrsModelOf<R>::attitude(const State& s) const {
    QuaternionR q = QuaternionR(s.x).normalized();
    // Predicted at the present rate.
    if (R(options_.output_latency_s) != 0) q = multiply<R>(q, rotation_quaternion<R>(rate(s) * R(options_.output_latency_s)));
    return q.template cast<double>();
}

template <class R>
Estimate AhrsModelOf<R>::estimate(const State& s) const {
    Estimate e;
    e.started = s.started != 0;
    e.rate_b = rate(s).template cast<double>();
    e.bias_b = Vector3R(s.bias).template cast<double>();
    e.q_bn = attitude(s);
    e.tilt_ready = e.started && tilt_ready(s);
    e.heading_ready = e.started && heading_ready(s);
    return e;
}

// Variance about each axis that is independent of the errors in P, without that of the hold.
template <class R>
R AhrsModelOf<R>::noise_now(const State& s) const {
    return rotation_noise(s) + density_.gyro_rate_psd * turn_rate(s).squaredNorm() * (s.x[13] - s.turned_s);
}

template <class R>
typename AhrsModelOf<R>::Matrix3R AhrsModelOf<R>::rotation_covariance(const State& s, const RotationNow& now) const {
    Matrix3R C = now.covariance();
    if (!s.started) return C;
    C.diagonal().array() += noise_now(s);
    C.diagonal() += added_variances(s);
    const Vector3R by_hold = hold_error(s);
    for (int k = 0; k < 3; ++k) C.col(k) += by_hold[k] * by_hold;
    return C;
}

// Variances about the navigation axes in addition to P. An unknown body is a vehicle as probably as not, and so has a suspected step of the
// gyro bias happened: variances of the mixtures.
template <class R>
Vector3Of<R> AhrsModelOf<R>::added_variances(const State& s) const {
    constexpr R even = R(0.5);
    const R unstated = unstated_tilt2(s);
    const R tilt = s.tilt_excess.variance + unstated + even * s.steps.suspected_tilt2 +
                   even * std::fmax(R(0), s.vehicle_tilt.square() - larger_tilt_variance(s));
    const R heading = s.steps.heading_variance_by_iron() + reference_variance(s) + unstated_heading2(s, unstated) +
                      even * (s.steps.suspected_heading2 + tilted_field_variance(s));
    return {tilt, tilt, heading};
}

template <class R>
Vector3Of<R> AhrsModelOf<R>::hold_error(const State& s) const {
    const QuaternionR q(s.x);
    const Vector3R u = turn_rate(s) - Vector3R(s.coning);
    const R interval_s = std::sqrt(s.wrong_hold + unstated_instant) * R(s.spacing_s[gyro]);
    return rotate<R>(q, u) * (interval_s / q.squaredNorm()); // whatever the length of the quaternion
}

template <class R>
Matrix3 AhrsModelOf<R>::rotation_covariance(const State& s) const {
    return rotation_covariance(s, RotationNow(s)).template cast<double>();
}

template <class R>
Vector3 AhrsModelOf<R>::rotation_variances(const State& s) const {
    Vector3R v = RotationNow(s).variances();
    if (s.started) {
        v.array() += noise_now(s);
        v += added_variances(s);
        v += hold_error(s).cwiseAbs2();
    }
    return v.template cast<double>();
}

template <class R>
Vector3 AhrsModelOf<R>::bias_variances(const State& s) const {
    Vector3 v;
    for (int i = 0; i < 3; ++i) v[i] = s.P[packed(bias + i, bias + i)] + density_.bias_walk_psd * s.x[13];
    return v;
}

template <class R>
ErrorCovariance AhrsModelOf<R>::error_covariance(const State& s) const {
    const RotationNow now(s);
    const Matrix3R rotation_bias = now.with_bias();
    Square<6, R> C;
    block<3, 3>(C, 0, 0) = rotation_covariance(s, now);
    block<3, 3>(C, 0, 3) = rotation_bias;
    block<3, 3>(C, 3, 0) = rotation_bias.transpose();
    block<3, 3>(C, 3, 3) = RotationNow::bias_block(s.P);
    diagonal<3>(C, 3).array() += density_.bias_walk_psd * s.x[13];
    return C.template cast<double>();
}

template <class R>
double AhrsModelOf<R>::bias_walk(const State&) const {
    return std::sqrt(density_.bias_walk_psd);
}

// Not computed: corrections have consider states, and the reference field may change in between.
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
    f.at_rest = s.rest.at_rest(options_);
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
