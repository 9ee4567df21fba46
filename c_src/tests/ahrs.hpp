// What the tests of the AHRS begin with.
#pragma once

#include "attitude/ahrs/model.hpp"
#include "laws.hpp"

namespace hnav::test {

template <class R = double>
AhrsSettings<R> ahrs_settings() {
    constexpr R deg = R(M_PI / 180);
    AhrsSettings<R> s{};
    s.gyro_psd = R(1e-8);
    s.gyro_rate_psd = R(6e-6);
    s.bias_walk_psd = R(2e-8);
    s.reference_psd = R(2e-5);
    s.velocity_density2 = R(0.3);
    s.azimuth_density2 = R(7e-4);
    s.intensity_density2 = R(3e-4);
    s.rest_field_factor = R(1.5);
    s.rest_bias_density2 = R(2e-9);
    s.correction_interval_s = 0.035;
    s.max_interval_s = 0.1;
    s.gap_acceleration_m_s2 = 2;
    s.gap_turn_factor = R(1.5);
    s.backward_hold = true;
    s.rest = {2 * deg, R(0.5), 2 * deg, R(1.5), R(0.5)};
    s.field = {R(0.035), 60, 3, R(0.35), R(0.35), R(0.17), 5, R(1.6), R(0.4), 60, R(0.13), R(3.75), R(0.12)};
    s.start.mode = StartMode::triad;
    s.start.sigma_heading = R(0.28);
    s.start.field_wait_s = 1;
    s.sigma = {R(0.08), R(0.28), R(0.008), R(0.08), R(0.11), R(0.016), R(1.6e-3), R(8e-4), R(0.05), R(0.35), R(0.035)};
    s.force_latency = R(0.25);
    s.declination_s = 60;
    s.ready_tilt_rad = 2 * deg;
    s.ready_heading_rad = 5 * deg;
    s.ready_evidence_s = 3;
    s.ready_undisturbed_s = 8;
    return s;
}

// A body that turns at a constant rate under gravity and a field dipping by 60 degrees, its sensors without error.
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

// Samples at 200 Hz for `duration_s`, by the closed form.
template <class Model>
void follow(const Model& model, typename Model::State& s, const Turning& motion, double duration_s, double from_s = 0) {
    const int n = static_cast<int>(std::lround(duration_s * 200));
    for (int k = 0; k <= n; ++k) {
        const AttitudeEvent e = motion.event(from_s + 0.005 * k);
        model.before_flow(s, e);
        if (model.flows(s) && k > 0) model.flow_exactly(s, 0.005);
        model.jump(s, e);
    }
}

inline double angle_between(const Quaternion& a, const Quaternion& b) {
    return 2 * std::acos(std::fmin(1.0, std::fabs(a.normalized().dot(b.normalized()))));
}

} // namespace hnav::test
