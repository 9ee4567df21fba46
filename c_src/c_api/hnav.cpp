// The C boundary: every function checks its arguments, calls the object, and says in one line what went wrong.
#include "hnav/hnav.h"

#include "c_api/boundary.hpp"
#include "c_api/sized.hpp"
#include "maths/repair.hpp"

#include <algorithm>
#include <iterator>

using hnav::AttitudeSample;
using hnav::hand_out;
using hnav::honest_variances;
using hnav::max_reading;
using hnav::Outcome;
using hnav::Scalar;
using hnav::Vector3;
using namespace hnav::boundary;

const char* hnav::boundary::sensor_name(int sensor) {
    static constexpr const char* names[] = {"gyro", "accel", "mag", "heading"};
    static_assert(sizeof names / sizeof *names == HNAV_SENSOR_COUNT);
    return names[sensor];
}

extern "C" {

// ------------------------------------------------------------------------------------------------ life

void hnav_filter_destroy(hnav_filter* filter) {
    if (filter) filter->destroy();
}

hnav_status hnav_filter_reset(hnav_filter* filter) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    filter->reset();
    return HNAV_OK;
}

hnav_status hnav_filter_realign(hnav_filter* filter) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    filter->realign();
    return HNAV_OK;
}

const char* hnav_filter_message(const hnav_filter* filter) { return filter ? filter->message : "filter is null"; }

// ------------------------------------------------------------------------------------------------ samples

hnav_status hnav_filter_push_gyro(hnav_filter* filter, double t_s, const double rate_b_rad_s[3]) {
    REQUIRE(filter, rate_b_rad_s);
    return push_vector(filter, t_s, rate_b_rad_s, hnav::gyro);
}

hnav_status hnav_filter_push_accel(hnav_filter* filter, double t_s, const double force_b_m_s2[3]) {
    REQUIRE(filter, force_b_m_s2);
    return push_vector(filter, t_s, force_b_m_s2, hnav::accel);
}

hnav_status hnav_filter_push_mag(hnav_filter* filter, double t_s, const double field_b_tesla[3]) {
    REQUIRE(filter, field_b_tesla);
    return push_vector(filter, t_s, field_b_tesla, hnav::mag);
}

hnav_status hnav_filter_push_imu(hnav_filter* filter, double t_s, const double rate_b_rad_s[3], const double force_b_m_s2[3]) {
    REQUIRE(filter, rate_b_rad_s);
    REQUIRE(filter, force_b_m_s2);
    AttitudeSample rate, force;
    hnav_status status = check_vector(filter, t_s, rate_b_rad_s, hnav::gyro, &rate);
    if (status == HNAV_OK) status = check_vector(filter, t_s, force_b_m_s2, hnav::accel, &force);
    if (status != HNAV_OK) return status;
    if (t_s >= filter->late_limit_s() && !filter->has_room(2))
        return filter->fail(HNAV_ERROR_QUEUE_FULL,
                            "the queue is full: advance before pushing the samples at t = %.9g s, or raise queue_capacity", t_s);
    status = push(filter, rate);
    return status == HNAV_OK ? push(filter, force) : status;
}

hnav_status hnav_filter_push_heading(hnav_filter* filter, double t_s, double heading_rad, double sigma_rad) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    if (!std::isfinite(t_s) || !std::isfinite(heading_rad) || !std::isfinite(sigma_rad)) {
        filter->refuse_non_finite();
        return filter->fail(HNAV_ERROR_NON_FINITE, "heading sample at t = %g s is not finite: heading %g, sigma %g", t_s,
                            heading_rad, sigma_rad);
    }
    if (std::fabs(t_s) > max_time_s) {
        filter->refuse_non_finite();
        return check_time(filter, t_s);
    }
    if (!(sigma_rad > 0) || sigma_rad > max_reading) {
        filter->refuse_non_finite();
        return filter->fail(HNAV_ERROR_OUT_OF_RANGE, "sigma_rad = %g of the heading sample at t = %g s must be above 0",
                            sigma_rad, t_s);
    }
    const double magnetic = hnav::wrap_angle(Scalar(heading_rad - filter->frames.declination_rad));
    return push(filter, {clock_time(t_s), hnav::heading, {magnetic, std::fmax(sigma_rad, min_heading_sigma_rad), 0}});
}

hnav_status hnav_filter_advance(hnav_filter* filter, double t_s) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    if (const hnav_status status = check_time(filter, t_s)) return status;
    return advance(filter, clock_time(t_s));
}

hnav_status hnav_filter_commit(hnav_filter* filter, double t_s) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    if (const hnav_status status = check_time(filter, t_s)) return status;
    return advanced(filter, clock_time(t_s), filter->commit(clock_time(t_s)));
}

// ------------------------------------------------------------------------------------------------ estimate

hnav_status hnav_filter_attitude(const hnav_filter* filter, hnav_attitude* attitude) {
    REQUIRE_STRUCT(filter, attitude, hnav_attitude);
    const hnav::Estimate e = filter->estimate(At::shown);
    if (!e.started) return not_started(filter);
    const hnav::Quaternion q = filter->frames.to_user(e.q_bn);
    const Vector3 euler = angles_of(q);
    hnav_attitude result{};
    result.t_s = filter->now_s();
    store(q, result.q_nb);
    store(euler, result.euler_rad);
    result.heading_rad = hnav::wrap_angle(Scalar(angles_of(e.q_bn)[2] + filter->frames.declination_rad));
    rotation_sigma(filter, At::shown, result.sigma_rad);
    result.near_singular = near_singular(q);
    result.tilt_ready = e.tilt_ready;
    result.heading_ready = e.heading_ready;
    hand_out(result, attitude);
    return HNAV_OK;
}

hnav_status hnav_filter_rate(const hnav_filter* filter, double rate_b_rad_s[3]) {
    REQUIRE(filter, rate_b_rad_s);
    store(filter->estimate(At::shown).rate_b, rate_b_rad_s);
    return HNAV_OK;
}

hnav_status hnav_filter_gyro_bias(const hnav_filter* filter, double bias_b_rad_s[3], double sigma_rad_s[3]) {
    REQUIRE(filter, bias_b_rad_s);
    REQUIRE(filter, sigma_rad_s);
    store(filter->estimate(At::shown).bias_b, bias_b_rad_s);
    bias_sigma(filter, At::shown, sigma_rad_s);
    return HNAV_OK;
}

hnav_status hnav_filter_covariance(const hnav_filter* filter, double covariance[36]) {
    REQUIRE(filter, covariance);
    if (!filter->estimate(At::shown).started) return not_started(filter);
    hnav::ErrorCovariance N = hnav::ErrorCovariance::Identity();
    N.topLeftCorner<3, 3>() = filter->frames.navigation;
    hnav::ErrorCovariance C = N * filter->error_covariance() * N.transpose();
    hnav::symmetrise<6>(C);
    // What rounding or a coarse integrator has broken is handed out as a covariance, with the variances of the sigmas.
    const Vector3 rotation = honest_variances(C.diagonal().head<3>()), bias = honest_variances(C.diagonal().tail<3>());
    hnav::repair<6>(C);
    C.diagonal().head<3>() = C.diagonal().head<3>().cwiseMax(rotation);
    C.diagonal().tail<3>() = C.diagonal().tail<3>().cwiseMax(bias);
    for (int i = 0; i < 36; ++i) covariance[i] = C(i);
    return HNAV_OK;
}

hnav_status hnav_filter_posterior(const hnav_filter* filter, hnav_posterior* posterior) {
    REQUIRE_STRUCT(filter, posterior, hnav_posterior);
    const hnav::Estimate e = filter->estimate(At::newest);
    if (!e.started) return not_started(filter);
    const hnav::Quaternion q = filter->frames.to_user(e.q_bn);
    hnav_posterior result{};
    result.t_s = filter->newest_s();
    store(q, result.q_nb);
    store(e.bias_b, result.gyro_bias_rad_s);
    rotation_sigma(filter, At::newest, result.sigma);
    bias_sigma(filter, At::newest, result.sigma + 3);
    result.near_singular = near_singular(q);
    result.tilt_ready = e.tilt_ready;
    result.heading_ready = e.heading_ready;
    hand_out(result, posterior);
    return HNAV_OK;
}

hnav_status hnav_filter_innovation(const hnav_filter* filter, hnav_sensor sensor, hnav_innovation* innovation) {
    REQUIRE_STRUCT(filter, innovation, hnav_innovation);
    if (int(sensor) <= HNAV_SENSOR_GYRO || int(sensor) >= HNAV_SENSOR_COUNT)
        return filter->fail(HNAV_ERROR_OUT_OF_RANGE, "sensor %d has no innovation: ask for accel, mag or an aid", (int)sensor);
    const auto& i = filter->innovation(sensor);
    if (std::isnan(i.t_s)) return filter->fail(HNAV_ERROR_NO_DATA, "no %s sample has been used yet", sensor_name(sensor));
    hnav_innovation result{};
    result.t_s = filter->stamp_of(i.t_s);
    std::copy(std::begin(i.value), std::end(i.value), result.value);
    std::copy(std::begin(i.S), std::end(i.S), result.S);
    result.nis = i.nis;
    result.noise_scale = i.noise_scale;
    result.dimension = static_cast<int32_t>(i.dimension);
    result.accepted = !(i.noise_scale > 1);
    hand_out(result, innovation);
    return HNAV_OK;
}

hnav_status hnav_filter_field(const hnav_filter* filter, hnav_field* field) {
    REQUIRE_STRUCT(filter, field, hnav_field);
    const hnav::FieldEstimate f = filter->field_estimate();
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
    hand_out(result, field);
    return HNAV_OK;
}

hnav_status hnav_filter_gyro_calibration(const hnav_filter* filter, double matrix[9], double sigma[9]) {
    REQUIRE(filter, matrix);
    REQUIRE(filter, sigma);
    filter->gyro_calibration(matrix, sigma);
    return HNAV_OK;
}

hnav_status hnav_filter_diagnostics(const hnav_filter* filter, hnav_diagnostics* diagnostics) {
    REQUIRE_STRUCT(filter, diagnostics, hnav_diagnostics);
    hnav_diagnostics result{};
    filter->diagnostics(&result);
    hand_out(result, diagnostics);
    return HNAV_OK;
}

hnav_status hnav_filter_health(const hnav_filter* filter, hnav_health* health) {
    REQUIRE_STRUCT(filter, health, hnav_health);
    hnav_health result{};
    filter->health(&result);
    hand_out(result, health);
    return HNAV_OK;
}

} // extern "C"
