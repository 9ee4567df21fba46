// Settings of the paper's filter, derived from its options, and its state.
#pragma once

#include "attitude/common/attitude_flow.hpp"
#include "attitude/common/estimate.hpp"
#include "attitude/common/start.hpp"
#include "attitude/hrekf/error_map.hpp"
#include "attitude/hrekf/noise_adaptation.hpp"
#include "estimation/readiness.hpp"
#include "estimation/robust_law.hpp"
#include "hnav/options/hrekf.h"
#include "maths/scalar.hpp"
#include "maths/square.hpp"
#include "signals/gaps.hpp"
#include "signals/sensor_checks.hpp"

#include <algorithm>

namespace hnav {

// Squares of the noise densities, which each sample needs.
struct HrekfDensities {
    using R = Scalar;

    R gyro_psd;       // (rad/s)^2/Hz
    R quaternion_psd; // 1/s, on all four components alike: the paper's L = I
    R bias_walk_psd;  // (rad/s)^2/s
    R accel_density2; // 1/Hz, of a direction
    R mag_density2;   // 1/Hz, of a field in units of the reference strength

    explicit HrekfDensities(const hnav_hrekf_options& o)
        : gyro_psd(R(square(o.gyro_noise_rad_per_sqrt_s))),
          quaternion_psd(R(square(o.quaternion_noise_per_sqrt_s))),
          bias_walk_psd(R(square(o.gyro_bias_walk_rad_s_per_sqrt_s))),
          accel_density2(R(square(o.accel_noise_per_sqrt_hz))),
          mag_density2(R(square(o.mag_noise_per_sqrt_hz))) {}
};

// NIS beyond which the noise of a sample is inflated; 0: never.
struct HrekfGates {
    double nis[heading + 1];

    explicit HrekfGates(const hnav_hrekf_options& o) : nis{0, accel_gate(o), o.mag_gate_nis, o.heading_gate_nis} {}

private:
    // A force innovation beyond this multiple of the default noise is an acceleration, whatever noise the options state: the gate
    // stays at that innovation, up to the 99.7 % limit of chi-square with 3 degrees of freedom.
    static double accel_gate(const hnav_hrekf_options& o) {
        constexpr double usual_nis = 0.13, usual_density = 0.115, chi_square = 13.9;
        if (o.accel_gate_nis >= 0) return o.accel_gate_nis;
        return std::fmin(std::fmax(usual_nis * square(usual_density / o.accel_noise_per_sqrt_hz), usual_nis), chi_square);
    }
};

// The robust law and the adaptation of the bias walk.
struct HrekfLaw {
    using R = Scalar;

    RobustSettings<R> robust;
    Eigen::Matrix<R, 6, 1> weight; // L of the H-infinity term, diagonal: of rotation and bias
    R length_weight;
    AdaptationSettings<R> adaptation;

    explicit HrekfLaw(const hnav_hrekf_options& o)
        : robust(o),
          adaptation{static_cast<Adaptation>(o.adaptation), R(o.adaptation_gain), R(square(o.adaptation_min_rad_s_per_sqrt_s)),
                     R(square(o.adaptation_max_rad_s_per_sqrt_s))} {
        length_weight = R(o.gamma_weight_attitude);
        weight.head<3>().setConstant(length_weight / 2);
        weight.tail<3>().setConstant(R(o.gamma_weight_bias));
    }
};

// Numbers of eight bytes only.
struct HrekfState {
    using R = Scalar;

    R x[AttitudeFlow<R>::nx];
    R bias[3];
    R P[21]; // upper triangle of the covariance of (theta, b) just after the last correction
    // Rotation variance by the bias walk up to the last event, with A and the time there: bias_walk.hpp.
    R C[9], N[6], walk_A[9], walk_s;
    R rate[3], read_rate[3]; // held; as measured
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
    double spacing_s; // usual time between two rate samples
    R mean_force[3]; // in navigation axes, of the last second
    std::uint64_t force_changes; // the newest force differs from it
    R field_far_s; // time for which the field was far from the reference, minus time near it
    std::uint64_t lost, times_lost; // 1 while the start is awaited; number of losses

    std::uint64_t usable(const AttitudeEvent& event) const { return event.present & ~rejected; }
    bool has(const AttitudeEvent& event, int channel) const { return (usable(event) >> channel) & 1; }
    void forget_integrals() {
        std::fill(x + AttitudeFlow<R>::A, x + AttitudeFlow<R>::nx, R(0));
        std::fill(C, C + 9, R(0));
        std::fill(N, N + 6, R(0));
        std::fill(walk_A, walk_A + 9, R(0));
        walk_s = 0;
    }
};

} // namespace hnav
