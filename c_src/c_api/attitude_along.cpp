// Derivatives of a filter's outputs, in the user's frames.
#include "c_api/attitude_boundary.hpp"
#include "c_api/sized.hpp"

using hnav::AttitudeObject;
using hnav::hand_out;
using hnav::Quaternion;
using hnav::ShownAlong;
using hnav::store;
using hnav::Vector3;
using namespace hnav::boundary;

namespace {

// Derivative of sigma = sqrt(|variance|) for a variance that changes by `along`.
void store_sigma(const Vector3& variance, const Vector3& along, const double* sigma, double* out) {
    for (int i = 0; i < 3; ++i) out[i] = (variance[i] < 0 ? -along[i] : along[i]) / (2 * sigma[i]);
}

void store_bias(const AttitudeObject* filter, const ShownAlong& along, hnav_shown_along* result) {
    double sigma[3];
    bias_sigma(filter, At::shown, sigma);
    store(along.rate, result->rate_b_rad_s);
    store(along.bias, result->gyro_bias_rad_s);
    store_sigma(filter->bias_variances(At::shown), along.bias_variance, sigma, result->gyro_bias_sigma_rad_s);
}

void store_attitude(const AttitudeObject* filter, const ShownAlong& along, hnav_shown_along* result) {
    const Quaternion internal = filter->estimate(At::shown).q_bn;
    const Quaternion q = filter->frames.to_user(internal), dq = filter->frames.to_user(along.q);
    store(dq, result->q_nb);
    store(hnav::roll_pitch_yaw_along(q, dq), result->euler_rad);
    result->heading_rad = hnav::roll_pitch_yaw_along(internal, along.q)[2];

    hnav::ErrorCovariance N = hnav::ErrorCovariance::Identity();
    N.topLeftCorner<3, 3>() = filter->frames.navigation;
    const hnav::ErrorCovariance C = N * along.covariance * N.transpose();
    for (int i = 0; i < 36; ++i) result->covariance[i] = C(i);
    double sigma[3];
    rotation_sigma(filter, At::shown, sigma);
    const hnav::Matrix3 internal_covariance = filter->rotation_covariance(At::shown);
    const auto& navigation = filter->frames.navigation;
    store_sigma((navigation * internal_covariance * navigation.transpose()).diagonal(), C.diagonal().head<3>(), sigma,
                result->sigma_rad);
}

} // namespace

extern "C" {

hnav_status hnav_filter_shown_along(const hnav_filter* filter, const double* seed, hnav_shown_along* along) {
    REQUIRE_OBJECT(const AttitudeObject, object, filter);
    REQUIRE_STRUCT(object, along, hnav_shown_along);
    REQUIRE(object, seed);
    const ShownAlong model = object->shown_along(seed);
    hnav_shown_along result{};
    store_bias(object, model, &result);
    if (object->estimate(At::shown).started) store_attitude(object, model, &result);
    else
        for (int i = 0; i < 3; ++i) result.covariance[7 * (i + 3)] = model.bias_variance[i];
    return hand_out(result, along);
}

} // extern "C"
