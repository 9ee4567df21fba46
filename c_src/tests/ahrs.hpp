// Shared by the tests of the AHRS.
#pragma once

#include "attitude/ahrs/model.hpp"
#include "laws.hpp"

namespace hnav::test {

inline hnav_ahrs_options ahrs_options() {
    constexpr double deg = M_PI / 180;
    hnav_ahrs_options o{};
    o.gyro_noise_rad_per_sqrt_s = 1e-4;
    o.gyro_rate_noise_sqrt_s = std::sqrt(6e-6);
    o.gyro_bias_walk_rad_s_per_sqrt_s = std::sqrt(2e-8);
    o.reference_walk_per_sqrt_s = std::sqrt(2e-5);
    o.velocity_noise_m_s_per_sqrt_hz = std::sqrt(0.3);
    o.mag_azimuth_noise_per_sqrt_hz = std::sqrt(7e-4);
    o.mag_intensity_noise_per_sqrt_hz = std::sqrt(3e-4);
    o.mag_rest_factor = 1.5;
    o.rest_bias_noise_rad_s_per_sqrt_hz = std::sqrt(2e-9);
    o.correction_interval_s = 0.035;
    o.max_interval_s = 0.1;
    o.gap_acceleration_m_s2 = 2;
    o.gap_turn_factor = 1.5;
    o.gyro_hold = HNAV_GYRO_HOLD_BACKWARD;
    o.rest_rate_rad_s = o.rest_mean_rate_rad_s = 2 * deg;
    o.rest_force_m_s2 = 0.5;
    o.rest_duration_s = 1.5;
    o.rest_filter_s = 0.5;
    o.mag_gate = 0.035;
    o.reference_strength_tolerance = 0.05;
    o.reference_dip_tolerance_rad = 3 * deg;
    o.mag_gate_max_s = 60;
    o.mag_gate_share = 3;
    o.turning_rad_s = 0.35;
    o.still_weight = 0.35;
    o.candidate_radius = 0.17;
    o.candidate_mean_s = 5;
    o.candidate_first_s = 1.6;
    o.candidate_share = 0.4;
    o.trust_s = 60;
    o.turn_min_rad = 0.13;
    o.turn_sigmas = 3.75;
    o.turn_sigma_rad = 0.12;
    o.start_mode = HNAV_START_TRIAD;
    o.start_q_nb[0] = o.q_body_sensor[0] = 1;
    o.start_samples = 1;
    o.start_field_wait_s = 1;
    o.start_sigma_tilt_rad = 0.08;
    o.start_sigma_heading_rad = 0.28;
    o.start_sigma_bias_rad_s = 0.008;
    o.start_sigma_velocity_m_s = 0.08;
    o.start_sigma_reference = 0.11;
    o.start_sigma_latency_s = 0.016;
    o.start_sigma_gyro_scale = 1.6e-3;
    o.start_sigma_gyro_misalignment_rad = 8e-4;
    o.start_sigma_accel_bias_m_s2 = 0.05;
    o.start_sigma_accel_latency = 0.35;
    o.start_accel_latency = 0.25;
    o.local_declination_rad = 0.035;
    o.local_declination_s = 60;
    o.ready_tilt_rad = 2 * deg;
    o.ready_heading_rad = 5 * deg;
    o.ready_evidence_s = 3;
    o.ready_undisturbed_s = 8;
    return o;
}

// A body that turns at a constant rate under gravity and a field with a dip of 60 degrees; its sensors have no error.
struct Turning {
    Vector3 rate_b{0.3, -0.5, 0.8};
    Vector3 bias = Vector3::Zero();
    Quaternion start_q = Quaternion(0.8, 0.2, -0.1, 0.5).normalized();
    double latency_s = 0;

    Quaternion q(double t_s) const { return multiply(start_q, HeldTurn(rate_b, t_s).q); }
    Vector3 force_b(double t_s) const { return rotation_matrix(q(t_s)).transpose() * Vector3(0, 0, -AhrsModel::gravity_m_s2); }
    Vector3 field_b(double t_s) const { return rotation_matrix(q(t_s - latency_s)).transpose() * Vector3(2.5e-5, 0, 4.33e-5); }

    AttitudeEvent event(double t_s, bool with_mag = true) const {
        AttitudeEvent e{};
        e.t_s = t_s;
        const auto add = [&](int channel, const Vector3& v) { e.add(AttitudeSample{t_s, channel, {v[0], v[1], v[2]}}); };
        add(gyro, rate_b + bias);
        add(accel, force_b(t_s));
        if (with_mag) add(mag, field_b(t_s));
        return e;
    }
};

template <class Model>
typename Model::State state_at_start(const Model& model) {
    typename Model::State s{};
    model.begin(s);
    return s;
}

// An event after an interval, by the closed form.
template <class Model>
void take(const Model& model, typename Model::State& s, const AttitudeEvent& e, double interval_s) {
    model.before_flow(s, e);
    if (model.flows(s) && interval_s > 0) model.flow_exactly(s, interval_s);
    model.jump(s, e);
}

// Samples at 200 Hz for `duration_s`, by the closed form.
template <class Model>
void follow(const Model& model, typename Model::State& s, const Turning& motion, double duration_s, double from_s = 0) {
    const int n = static_cast<int>(std::lround(duration_s * 200));
    for (int k = 0; k <= n; ++k) take(model, s, motion.event(from_s + 0.005 * k), k > 0 ? 0.005 : 0);
}

inline double angle_between(const Quaternion& a, const Quaternion& b) {
    return 2 * std::acos(std::fmin(1.0, std::fabs(a.normalized().dot(b.normalized()))));
}

} // namespace hnav::test
