// What the paper's filter is told, and all that changes in it.
#pragma once

#include "attitude/common/estimate.hpp"
#include "attitude/common/start.hpp"
#include "attitude/hrekf/error_map.hpp"
#include "attitude/hrekf/noise_adaptation.hpp"
#include "estimation/readiness.hpp"
#include "estimation/robust_law.hpp"
#include "signals/gaps.hpp"
#include "signals/sensor_check.hpp"

namespace hnav {

constexpr int hrekf_nx = 35; // q 4, b 3, upper triangle of their covariance

template <class R>
struct HrekfSettings {
    R gyro_psd;       // (rad/s)^2/Hz
    R quaternion_psd; // 1/s, on all four components alike: the paper's L = I
    R bias_walk_psd;  // (rad/s)^2/s
    R accel_density2; // 1/Hz, of a direction
    R mag_density2;   // 1/Hz, of a field in units of the reference strength
    double max_interval_s;
    bool backward_hold;
    RobustSettings<R> robust;
    Eigen::Matrix<R, 7, 1> weight = Eigen::Matrix<R, 7, 1>::Ones(); // L of the H-infinity term, diagonal
    AdaptationSettings<R> adaptation;
    StartSettings<R> start;
    Vector3Of<R> start_bias = Vector3Of<R>::Zero();
    R sigma_tilt, sigma_bias;
    bool reference_given;
    ReferenceFieldOf<R> reference;
    R gate_nis[channel_count]; // 0: never
    SensorCheckSettings<R> check[heading];
    R ready_tilt_rad, ready_heading_rad;
};

// Numbers of eight bytes only.
template <class R>
struct HrekfState {
    R x[hrekf_nx];
    R rate[3];     // held
    R bias_psd[6]; // upper triangle of Q_b
    R reference_strength, reference_north, reference_down; // of the unit field
    StartSamples<R> start;
    double last_s[channel_count]; // time of the newest sample of each channel
    double last_correction_s;
    R previous_bias_trace; // of the bias covariance after the last correction
    AdaptationWindow<R> adaptation;
    AngleInformation<R> information;
    R gamma, gamma_margin;
    ErrorMap<R> error_map; // over the last correction
    InnovationOf<R> innovation[channel_count];
    std::uint64_t used[channel_count], gated[channel_count];
    std::uint64_t corrections, gamma_raised, repaired;
    std::uint64_t started, has_rate, has_reference;
    SensorCheck<R> check[heading];
    std::uint64_t rejected; // bit c: the present sample of channel c is treated as missing
    RateChange<R> rate_change;
    double spacing_s;          // usual time between two rates
    R mean_force[3];           // in navigation axes, of the last second
    std::uint64_t force_changes; // the newest force lies away from that
    R field_far_s;               // time for which the field lay far from the reference, less that for which it did not
    std::uint64_t lost, times_lost; // started anew, or waiting for that

    bool has(const AttitudeEvent& event, int channel) const { return event.has(channel) && !((rejected >> channel) & 1); }
};

// The covariance by its blocks, to and from the packed upper triangle.
template <class R>
struct HrekfBlocks {
    Square<4, R> qq;
    Matrix43Of<R> qb;
    Matrix3Of<R> bb;

    HrekfBlocks() = default;
    explicit HrekfBlocks(const R* upper) {
        for (int i = 0; i < 4; ++i) {
            for (int j = i; j < 4; ++j) qq(i, j) = qq(j, i) = *upper++;
            for (int j = 0; j < 3; ++j) qb(i, j) = *upper++;
        }
        bb = unpack<3>(upper);
    }
    void write(R* upper) const {
        for (int i = 0; i < 4; ++i) {
            for (int j = i; j < 4; ++j) *upper++ = qq(i, j);
            for (int j = 0; j < 3; ++j) *upper++ = qb(i, j);
        }
        pack<3>(bb, upper);
    }
};

// Variances of the rotation error about north, east and down, from the covariance of the unit quaternion q.
template <class R>
inline Vector3Of<R> rotation_variances_of(const QuaternionOf<R>& q, const Square<4, std::common_type_t<R>>& Pqq) {
    const Matrix34Of<R> T = rotation_from_error<R>(q);
    return (T * Pqq).cwiseProduct(T).rowwise().sum();
}

} // namespace hnav
