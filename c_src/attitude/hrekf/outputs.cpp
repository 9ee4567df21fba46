// Outputs, in the quantities that all attitude filters have.
#include "attitude/hrekf/model.hpp"

namespace hnav {

Estimate HrekfModel::estimate(const State& s) const {
    Estimate e;
    e.started = s.started != 0;
    e.q_bn = attitude(s);
    e.rate_b = turn_rate(s).cast<double>();
    e.bias_b = Vector3R(s.bias).cast<double>();
    if (!e.started) return e;
    const Covariance P = covariance(s);
    const Vector3R variances = diagonal<3>(P, 0);
    e.tilt_ready = tilt_ready(s, variances);
    e.heading_ready = heading_ready(s, variances);
    return e;
}

FieldEstimate HrekfModel::field_estimate(const State& s) const {
    FieldEstimate f;
    f.known = s.has_reference != 0;
    f.strength_tesla = s.reference_strength;
    f.dip_rad = std::atan2(s.reference_down, s.reference_north);
    f.gate = s.innovation[mag].noise_scale > 1 ? FieldGate::inflated : FieldGate::accepted;
    return f;
}

} // namespace hnav
