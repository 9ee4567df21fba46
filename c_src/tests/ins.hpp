// A vehicle that winds over the ground, its exact samples, and the navigation filter that gets them.
#pragma once

#include "hybrid/filter.hpp"
#include "ins/model.hpp"
#include "laws.hpp"

#include <functional>

namespace hnav::test {

using ins::imu;
using ins::Phase;
using ins::position;
using ins::velocity;
using Navigator = Filter<ins::Model>;

constexpr double deg = M_PI / 180;

inline ins::Options usual() {
    ins::Options o{};
    o.gyro_noise_rad_per_sqrt_s = 5e-5;
    o.gyro_bias_walk_rad_s_per_sqrt_s = 2e-6;
    o.accel_noise_m_s_per_sqrt_s = 6e-4;
    o.accel_bias_walk_m_s2_per_sqrt_s = 3e-5;
    o.position_colour_m[0] = o.position_colour_m[1] = 1.5;
    o.position_colour_s = 60;
    o.pressure_colour_m = 5;
    o.pressure_colour_s = 1000;
    o.start_sigma_velocity_m_s = 30;
    o.start_sigma_gyro_bias_rad_s = 1e-3;
    o.start_sigma_accel_bias_m_s2 = 0.03;
    o.start_sigma_tilt_rad = 0.03;
    o.start_sigma_latency_s = 0.05;
    o.start_sigma_speed_scale = 0.05;
    o.start_sigma_mounting_rad = 0.03;
    o.start_sigma_heading_rad = 0.1;
    o.start_sigma_position_m = 30;
    o.level_window_s = 3;
    o.gate_nis = 16.3;
    o.gate_longest_s = 15;
    o.rest_rate_rad_s = deg;
    o.rest_force_m_s2 = 0.25;
    o.rest_duration_s = 1;
    o.rest_velocity_noise_m_s = 0.02;
    o.rest_rate_noise_rad_per_sqrt_s = 1e-4;
    o.ready_tilt_rad = o.ready_heading_rad = deg;
    o.ready_velocity_m_s = 0.5;
    o.ready_position_m = 5;
    o.ready_hold_s = 5;
    o.heading_found_rad = 4 * deg;
    o.anchor_distance_m = 1e4;
    o.correction_interval_s = 0.1;
    o.longest_gap_s = 1;
    o.gyro_hold = HNAV_GYRO_HOLD_BACKWARD;
    return o;
}

inline void give_place(ins::Options& o, const earth::Place& place) {
    o.start_place = HNAV_INS_PLACE_GIVEN;
    o.start_latitude_rad = place.latitude_rad;
    o.start_longitude_rad = place.longitude_rad;
    o.start_height_m = place.height_m;
}

// A motion given by position in Earth-fixed axes and attitude, and the samples that hold it exactly at their rate.
struct Truth {
    std::function<Vector3(double)> position_e;
    std::function<Quaternion(double)> q_eb;
    double interval_s = 0.01;

    Vector3 velocity_e(double t) const {
        const double h = 1e-3;
        return (position_e(t + h) - position_e(t - h)) / (2 * h);
    }
    // Means over the interval that ends at t.
    void sample(double t, double* value) const {
        const double T = interval_s;
        const Quaternion before = q_eb(t - T), after = q_eb(t);
        const Quaternion earth = rotation_quaternion(Vector3(0, 0, earth::rate_rad_s * T));
        const Vector3 w = rotation_vector(multiply(conjugate(before), multiply(earth, after))) / T;
        const Vector3 v0 = velocity_e(t - T), v1 = velocity_e(t), W(0, 0, earth::rate_rad_s);
        const Vector3 middle = position_e(t - 0.5 * T);
        const Vector3 force_e = (v1 - v0) / T - earth::gravity_at(middle) + W.cross(v0 + v1);
        const Matrix3 mean = HeldTurn<double>(w, T).integral / T;
        const Vector3 half = 0.5 * T * W; // force_e is in axes that have turned with the Earth for half the interval
        const Vector3 f = mean.inverse() * (rotation_matrix(before).transpose() * (force_e + half.cross(force_e)));
        for (int i = 0; i < 3; ++i) {
            value[i] = w[i];
            value[3 + i] = f[i];
        }
    }
    ins::Event at(double t, bool fix = false) const {
        ins::Event e{};
        e.t_s = t;
        ins::Sample s{t, imu, {}};
        sample(t, s.value);
        e.add(s);
        if (fix) {
            e.add(velocity_fix(t));
            e.add(position_fix(t));
        }
        return e;
    }
    ins::Sample velocity_fix(double t, double sigma = 0.1) const {
        const Matrix3 N = earth::axes_at(earth::place_of(position_e(t)));
        const Vector3 v = N.transpose() * velocity_e(t);
        return {t, velocity, {v[0], v[1], v[2], sigma, sigma, sigma}};
    }
    ins::Sample position_fix(double t, double sigma = 0.5) const {
        const earth::Place p = earth::place_of(position_e(t));
        return {t, position, {p.latitude_rad, p.longitude_rad, p.height_m, sigma, sigma, sigma}};
    }
    double heading(double t) const {
        const Matrix3 N = earth::axes_at(earth::place_of(position_e(t)));
        return roll_pitch_yaw(multiply(quaternion_from_matrix(N.transpose()), q_eb(t)))[2];
    }
};

// A vehicle on a winding path about a place, body x ahead.
inline Truth winding(const earth::Place& start, double heading, double speed = 15) {
    const Vector3 p0 = earth::position_of(start);
    const Matrix3 N = earth::axes_at(start);
    const auto yaw = [heading](double t) { return heading + 0.9 * std::sin(0.15 * t); };
    Truth truth;
    truth.position_e = [=](double t) {
        // The integral of the direction from 0, by Simpson's rule: exact to the needs of the tests.
        const int n = 60;
        Vector3 sum = Vector3::Zero();
        const double h = t / n;
        for (int i = 0; i <= n; ++i) {
            const double weight = i == 0 || i == n ? 1 : i % 2 ? 4 : 2, a = yaw(i * h);
            sum += weight * Vector3(std::cos(a), std::sin(a), 0);
        }
        return Vector3(p0 + N * (speed * h / 3 * sum));
    };
    truth.q_eb = [=](double t) { return multiply(quaternion_from_matrix(N), rotation_quaternion(Vector3(0, 0, yaw(t)))); };
    return truth;
}

inline ins::State started_at(const ins::Model& model, const Truth& truth, double t) {
    ins::State s{};
    model.begin(s);
    const earth::Place p = earth::place_of(truth.position_e(t));
    const Matrix3 N = earth::axes_at(p);
    ins::vec(s.anchor_e) = earth::position_of(p);
    ins::mat(s.axes) = N;
    ins::vec(s.earth_rate) = N.transpose() * Vector3(0, 0, earth::rate_rad_s);
    ins::vec(s.gravity) = N.transpose() * earth::gravity_at(truth.position_e(t));
    ins::vec(s.x + 3) = N.transpose() * truth.velocity_e(t);
    ins::quat(s.x + 6) = multiply(quaternion_from_matrix(N.transpose()), truth.q_eb(t));
    s.phase = Phase::navigating;
    s.has_place = 1;
    s.last_s[imu] = s.last_event_s = s.last_correction_s = t;
    ins::quat(s.seen_q) = ins::quat(s.x + 6);
    return s;
}

// Flows over nine samples from 0, without a correction.
inline void flow_uncorrected(const ins::Model& model, const Truth& truth, ins::State& s) {
    for (int k = 1; k <= 9; ++k) {
        const ins::Event e = truth.at(0.01 * k);
        model.before_flow(s, e);
        model.flow_exactly(s, 0.01);
        s.last_correction_s = 0.01 * k; // no correction yet
        model.jump(s, e);
    }
}

struct Flight {
    Navigator filter;

    explicit Flight(const ins::Options& options, bool closed_form = true, double horizon_s = 0) {
        Navigator::Settings e;
        e.closed_form = closed_form;
        e.horizon_s = horizon_s;
        e.time_jump_limit_s = options.time_jump_limit_s;
        e.queue_capacity = 256;
        EXPECT_TRUE(filter.create(ins::Model(options), e));
    }
    void push_imu(const Truth& truth, double t) {
        ins::Sample s{t, imu, {}};
        truth.sample(t, s.value);
        EXPECT_EQ(filter.push(s), Outcome::ok);
    }
    ins::Navigation shown() const {
        return filter.model().navigation(filter.shown(), filter.looked_ahead_s(), filter.event_now_s());
    }
};

// Sample i of a hundred a second, and five fixes a second.
inline void feed(Flight& run, const Truth& truth, int i) {
    const double t = 0.01 * i;
    run.push_imu(truth, t);
    if (i % 20 == 0) {
        run.filter.push(truth.velocity_fix(t));
        run.filter.push(truth.position_fix(t));
    }
}

// A drive of `seconds` with satellites, whose samples `spoil` may change before they are used.
inline void drive(Flight& run, const Truth& truth, int seconds, const std::function<void(ins::Sample&)>& spoil) {
    const auto push = [&](ins::Sample sample) {
        spoil(sample);
        run.filter.push(sample);
    };
    for (int i = 1; i <= 100 * seconds; ++i) {
        const double t = 0.01 * i;
        ins::Sample turn{t, imu, {}};
        truth.sample(t, turn.value);
        push(turn);
        if (i % 20 == 0) {
            push(truth.velocity_fix(t));
            push(truth.position_fix(t));
        }
        ASSERT_EQ(run.filter.advance(t), Outcome::ok);
    }
}

// Off the vertical, in units of its sigma, both axes together: chi square of two.
inline double tilt_nees(const ins::Navigation& n, const Truth& truth, double t) {
    const Matrix3 N = earth::axes_at(n.place);
    const Vector3 down = rotation_matrix(n.q_nb) * (rotation_matrix(truth.q_eb(t)).transpose() * N.col(2));
    return std::pow(down[1] / n.sigma_rotation[0], 2) + std::pow(down[0] / n.sigma_rotation[1], 2);
}

} // namespace hnav::test
