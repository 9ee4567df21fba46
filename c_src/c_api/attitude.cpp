// The C boundary of the attitude filters: their part of the common calls, and their own calls.
#include "c_api/attitude_boundary.hpp"
#include "c_api/sized.hpp"
#include "maths/repair.hpp"

#include <algorithm>
#include <iterator>

namespace hnav {

using namespace boundary;

// ------------------------------------------------------------------------------------------------ samples

hnav_status EveryAttitude::take(int sensor, double t_s, const double* value) {
    auto* self = static_cast<AttitudeObject*>(this);
    if (sensor < heading) return push_vector(self, t_s, value, sensor);
    if (sensor == heading) return push_heading(self, t_s, value[0], value[1]);
    if (sensor == speed) return push_speed(self, t_s, value[0], value[1]);
    return takes_none(this, sensor);
}

hnav_status EveryAttitude::take_imu(double t_s, const double* rate_b, const double* force_b) {
    auto* self = static_cast<AttitudeObject*>(this);
    AttitudeSample rate, force;
    if (const hnav_status status = counted(self, check_vector(self, t_s, rate_b, gyro, &rate))) return status;
    if (const hnav_status status = counted(self, check_vector(self, t_s, force_b, accel, &force))) return status;
    if (t_s >= late_limit_s() && !has_room(2))
        return fail(HNAV_ERROR_QUEUE_FULL,
                    "the queue is full: advance before pushing the samples at t = %.9g s, or raise queue_capacity", t_s);
    const hnav_status status = boundary::push(self, rate);
    return status == HNAV_OK ? boundary::push(self, force) : status;
}

// ------------------------------------------------------------------------------------------------ estimate

hnav_status EveryAttitude::attitude(hnav_attitude* out) const {
    const Estimate e = estimate(At::shown);
    if (!e.started) return not_started(this);
    const Quaternion q = frames.to_user(e.q_bn);
    out->t_s = now_s();
    store(q, out->q_nb);
    store(angles_of(q), out->euler_rad);
    out->heading_rad = wrap_angle(Scalar(angles_of(e.q_bn)[2] + frames.declination_rad));
    rotation_sigma(this, At::shown, out->sigma_rad);
    out->near_singular = near_singular(q);
    out->tilt_ready = e.tilt_ready;
    out->heading_ready = e.heading_ready;
    return HNAV_OK;
}

hnav_status EveryAttitude::rate(double* rate_b) const {
    store(estimate(At::shown).rate_b, rate_b);
    return HNAV_OK;
}

hnav_status EveryAttitude::gyro_bias(double* bias_b, double* sigma) const {
    store(estimate(At::shown).bias_b, bias_b);
    bias_sigma(this, At::shown, sigma);
    return HNAV_OK;
}

hnav_status EveryAttitude::covariance(double* P) const {
    if (!estimate(At::shown).started) return not_started(this);
    ErrorCovariance N = ErrorCovariance::Identity();
    N.topLeftCorner<3, 3>() = frames.navigation;
    ErrorCovariance C = N * error_covariance() * N.transpose();
    symmetrise<6>(C);
    // A matrix that is no covariance because of rounding or a coarse integrator is replaced by the nearest one.
    const Vector3 rotation = honest_variances(C.diagonal().head<3>()), bias = honest_variances(C.diagonal().tail<3>());
    repair<6>(C);
    C.diagonal().head<3>() = C.diagonal().head<3>().cwiseMax(rotation);
    C.diagonal().tail<3>() = C.diagonal().tail<3>().cwiseMax(bias);
    for (int i = 0; i < 36; ++i) P[i] = C(i);
    return HNAV_OK;
}

hnav_status EveryAttitude::innovation(int sensor, hnav_innovation* out) const {
    if (sensor >= sensors) return takes_none(this, sensor);
    const auto& i = last_innovation(sensor);
    if (std::isnan(i.t_s)) return fail(HNAV_ERROR_NO_DATA, "no %s sample has been used yet", sensor_name(sensor));
    fill_innovation(i, stamp_of(i.t_s), out);
    std::copy(std::begin(i.S), std::end(i.S), out->S);
    return HNAV_OK;
}

} // namespace hnav

using hnav::AttitudeObject;
using hnav::hand_out;
using hnav::store;
using namespace hnav::boundary;

extern "C" {

hnav_status hnav_filter_realign(hnav_filter* filter) {
    REQUIRE_OBJECT(AttitudeObject, object, filter);
    object->realign();
    return HNAV_OK;
}

hnav_status hnav_filter_posterior(const hnav_filter* filter, hnav_posterior* posterior) {
    REQUIRE_OBJECT(const AttitudeObject, object, filter);
    REQUIRE_STRUCT(object, posterior, hnav_posterior);
    const hnav::Estimate e = object->estimate(At::newest);
    if (!e.started) return not_started(object);
    const hnav::Quaternion q = object->frames.to_user(e.q_bn);
    hnav_posterior result{};
    result.t_s = object->newest_s();
    store(q, result.q_nb);
    store(e.bias_b, result.gyro_bias_rad_s);
    rotation_sigma(object, At::newest, result.sigma);
    bias_sigma(object, At::newest, result.sigma + 3);
    result.near_singular = near_singular(q);
    result.tilt_ready = e.tilt_ready;
    result.heading_ready = e.heading_ready;
    return hand_out(result, posterior);
}

hnav_status hnav_filter_field(const hnav_filter* filter, hnav_field* field) {
    REQUIRE_OBJECT(const AttitudeObject, object, filter);
    REQUIRE_STRUCT(object, field, hnav_field);
    const hnav::FieldEstimate f = object->field_estimate();
    hnav_field result{};
    result.strength_tesla = f.known ? f.strength_tesla : hnav::nan;
    result.dip_rad = f.known ? f.dip_rad : hnav::nan;
    result.latency_s = f.latency_s;
    result.latency_sigma_s = f.latency_sigma_s;
    result.evidence_s = f.evidence_s;
    result.heading_trust_s = f.heading_trust_s;
    result.reference_changes = f.reference_changes;
    result.gate = static_cast<int32_t>(f.gate);
    result.at_rest = f.at_rest;
    return hand_out(result, field);
}

hnav_status hnav_filter_gyro_calibration(const hnav_filter* filter, double matrix[9], double sigma[9]) {
    REQUIRE_OBJECT(const AttitudeObject, object, filter);
    REQUIRE(object, matrix);
    REQUIRE(object, sigma);
    object->gyro_calibration(matrix, sigma);
    return HNAV_OK;
}

} // extern "C"
