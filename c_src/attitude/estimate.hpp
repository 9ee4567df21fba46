// What an attitude filter knows at one moment, in internal frames (rotation.hpp).
#pragma once

#include "attitude/rotation.hpp"

#include <cstdint>
#include <limits>

namespace hnav {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Channels of an attitude filter, in the order in which samples of equal time act.
enum Channel : int { gyro = 0, accel = 1, mag = 2, heading = 3, channel_count = 4 };

// The last correction by one sensor. Eight-byte members: part of the saved state.
struct Innovation {
    double t_s = nan;
    double value[3] = {};
    double S[9] = {};
    double nis = nan;
    double noise_scale = 1; // above 1: the gate inflated the noise
    std::uint64_t dimension = 0;
};

struct Estimate {
    bool started = false;
    Quaternion q_bn{1, 0, 0, 0};
    Vector3 rate_b = Vector3::Zero(); // bias removed
    Vector3 bias_b = Vector3::Zero();
    bool tilt_ready = false;
    bool heading_ready = false;
};

// Rotation error about the navigation axes, then gyro bias error; q_true = exp(error / 2) q.
using ErrorCovariance = Eigen::Matrix<double, 6, 6>;

} // namespace hnav
