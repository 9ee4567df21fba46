// What the tests of the paper's filter begin with.
#pragma once

#include "attitude/hrekf/model.hpp"
#include "laws.hpp"

#include <cstring>

namespace hnav::test {

template <class R = double>
HrekfSettings<R> hrekf_settings() {
    constexpr R deg = R(M_PI / 180);
    HrekfSettings<R> s{};
    s.gyro_psd = R(1e-4);
    s.bias_walk_psd = R(1e-6);
    s.accel_density2 = R(1e-6);
    s.mag_density2 = R(4e-6);
    s.max_interval_s = 0.1;
    s.start.mode = StartMode::attitude;
    s.start.samples = 1;
    s.sigma_tilt = R(0.1);
    s.start.sigma_heading = R(0.3);
    s.sigma_bias = R(0.05);
    s.reference_given = true;
    s.reference = {1, 1};
    s.ready_tilt_rad = 2 * deg;
    s.ready_heading_rad = 5 * deg;
    return s;
}

inline HrekfModel::State random_state(const HrekfModel& model, Random& random, double rate = 3) {
    HrekfModel::State s;
    std::memset(static_cast<void*>(&s), 0, sizeof s);
    model.begin(s);
    Eigen::Map<Quaternion>(s.x) = random.quaternion();
    Eigen::Map<Vector3>(s.x + 4) = random.vector(0.05);
    pack<7>(random.covariance<7>(0.01), s.x + 7);
    Eigen::Map<Vector3>(s.rate) = random.vector(rate);
    s.has_rate = s.started = 1;
    return s;
}

} // namespace hnav::test
