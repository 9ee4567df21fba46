// The estimate of an attitude filter at one moment, in internal frames (rotation.hpp). Outputs are double, whatever scalar the state
// has.
#pragma once

#include "attitude/common/channels.hpp"
#include "maths/rotation.hpp"
#include "signals/sensor_checks.hpp"

#include <cstdint>
#include <limits>

namespace hnav {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Largest value of a sample in any unit, and of a gyro bias; larger values overflow in products.
constexpr double max_reading = 1e6;

// A sample of three components.
template <class R>
inline Vector3Of<R> vector_of(const AttitudeEvent& event, int channel) {
    return Vector3(event.value[channel]).cast<R>();
}

// Before the event is used: a rejected sample is treated as missing. True: an axis of the gyroscope is at fault; its rate is used as
// measured. force_moves: as of examine (signals/sensor_checks.hpp); interval_s(channel): since its last sample.
template <class R, class State, class IntervalOf>
bool examine_event(State& s, const AttitudeEvent& event, const CheckLimits<R>& limits, bool force_moves,
                   IntervalOf&& interval_s) {
    const auto sample = [&event](int c, Vector3Of<R>* y) {
        if (event.has(c)) *y = vector_of<R>(event, c);
        return event.has(c);
    };
    const Examined found = examine(s.check, limits.of, event.t_s, force_moves, turns(Vector3Of<R>(s.rate)), sample, interval_s);
    s.rejected = found.rejected;
    return found.rate_at_fault;
}

// The last correction by one sensor. Eight-byte members: part of the saved state.
template <class R>
struct InnovationOf {
    double t_s = nan;
    R value[3] = {};
    R S[9] = {};
    R nis = std::numeric_limits<R>::quiet_NaN();
    R noise_scale = 1; // above 1: the gate inflated the noise
    std::uint64_t dimension = 0;
};
using Innovation = InnovationOf<double>;

struct Estimate {
    bool started = false;
    Quaternion q_bn{1, 0, 0, 0};
    Vector3 rate_b = Vector3::Zero(); // bias removed
    Vector3 bias_b = Vector3::Zero();
    bool tilt_ready = false;
    bool heading_ready = false;
};

// Whether numbers can be an attitude and a gyro bias. Coarse integration changes the length of a quaternion; a length outside these
// bounds, or a bias larger than any rate, is not an estimate.
template <class R>
inline bool has_sound_length(const R* q) {
    const R square = QuaternionOf<R>(q).squaredNorm();
    return square > R(0.25) && square < 4;
}
template <class R>
inline bool is_plausible(const R* q, const R* bias) {
    return has_sound_length(q) && Vector3Of<R>(bias).cwiseAbs().maxCoeff() <= R(max_reading);
}

// The direction of the quaternion is the attitude; an external integrator may have changed its length.
template <class R>
inline void restore_length(R* q) {
    if (!has_sound_length(q)) Eigen::Map<QuaternionOf<R>>(q).normalize();
}

enum class FieldGate { accepted, rejected, inflated };

// Estimates of the magnetic field and its sensor.
struct FieldEstimate {
    bool known = false;
    double strength_tesla = 0, dip_rad = 0; // of the reference in use
    double latency_s = 0, latency_sigma_s = 0; // latency of the magnetometer relative to its time stamps
    double evidence_s = 0; // time for which the reference was observed, with less weight at rest
    double heading_trust_s = 0; // the same for the heading, through changes of reference
    int reference_changes = 0;
    FieldGate gate = FieldGate::accepted; // of the last field
    bool at_rest = false;
};

// Rotation error about the navigation axes, then gyro bias error; q_true = exp(error / 2) q.
using ErrorCovariance = Eigen::Matrix<double, 6, 6>;

} // namespace hnav
