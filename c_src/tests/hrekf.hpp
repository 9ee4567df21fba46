// Shared by the tests of the paper's filter.
#pragma once

#include "attitude/hrekf/model.hpp"
#include "laws.hpp"

#include <cstring>

namespace hnav::test {

inline hnav_hrekf_options hrekf_options() {
    constexpr double deg = M_PI / 180;
    hnav_hrekf_options o{};
    o.gyro_noise_rad_per_sqrt_s = 1e-2;
    o.gyro_bias_walk_rad_s_per_sqrt_s = 1e-3;
    o.accel_noise_per_sqrt_hz = 1e-3;
    o.mag_noise_per_sqrt_hz = 2e-3;
    o.max_interval_s = 0.1;
    o.gamma = o.gamma_relative_rate_1_s = o.gamma_kl_rate_1_s = 1;
    o.gamma_weight_attitude = o.gamma_weight_bias = 1;
    o.adaptation_gain = 0.02;
    o.adaptation_max_rad_s_per_sqrt_s = 1;
    o.start_mode = HNAV_START_ATTITUDE;
    o.start_q_nb[0] = o.q_body_sensor[0] = 1;
    o.start_samples = 1;
    o.start_sigma_tilt_rad = 0.1;
    o.start_sigma_heading_rad = 0.3;
    o.start_sigma_bias_rad_s = 0.05;
    o.reference_mode = HNAV_REFERENCE_GIVEN;
    o.reference_strength_tesla = o.reference_dip_rad = 1;
    o.ready_tilt_rad = 2 * deg;
    o.ready_heading_rad = 5 * deg;
    return o;
}

inline HrekfModel::State random_state(const HrekfModel& model, Random& random, double rate = 3) {
    HrekfModel::State s;
    std::memset(static_cast<void*>(&s), 0, sizeof s);
    model.begin(s);
    Eigen::Map<Quaternion>(s.x) = random.quaternion();
    Eigen::Map<Vector3>(s.bias) = random.vector(0.05);
    pack<6>(random.covariance<6>(0.01), s.P);
    Eigen::Map<Vector3>(s.rate) = random.vector(rate);
    s.has_rate = s.started = 1;
    return s;
}

// The 7 x 7 covariance of (q, b) of a state.
inline Square<7> full_covariance(const HrekfModel& model, const HrekfModel::State& s, double length_variance = 0) {
    const Quaternion q = Quaternion(s.x).normalized();
    Eigen::Matrix<double, 7, 6> G = Eigen::Matrix<double, 7, 6>::Zero();
    G.topLeftCorner<4, 3>() = across(q) / 2;
    G.bottomRightCorner<3, 3>().setIdentity();
    Square<7> P = G * model.error_covariance(s) * G.transpose();
    P.topLeftCorner<4, 4>() += length_variance * q * q.transpose();
    return P;
}

} // namespace hnav::test
