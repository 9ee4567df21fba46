// Before an event is used: implausible samples are treated as missing, and faulty axes add uncertainty.
#include "ins/model.hpp"

#include "maths/square.hpp"

#include <algorithm>

namespace hnav::ins {
namespace {

// The body moves, or has gained speed since the position last changed.
bool has_gone(const State& s, double now_s) {
    constexpr double least_m_s = 1, sure = 5; // sigmas
    const auto beyond = [](double size, double variance) { return size > std::fmax(least_m_s, sure * std::sqrt(variance)); };
    const double over_s = now_s - s.changed_s, by_tilt = vec(s.gravity).squaredNorm() * larger_variance(s, row_phi);
    const double gained = (vec(s.gates.gained) - vec(s.changed_gained)).head<2>().norm();
    return beyond(vec(s.x + 3).norm(), larger_variance(s, row_v)) ||
           beyond(gained, square(over_s) * (by_tilt + larger_variance(s, row_accel)));
}

// A single force sample far from its neighbours is a sensor fault or a knock, which cannot be distinguished. It is rejected, and the
// velocity that it would have added becomes uncertain. In simulated hands with 15 taps a minute the heading error is 1.6 deg, without
// this 27 deg.
void note_knock(State& s, const Vector3& force, double interval_s) {
    constexpr double largest_m_s2 = 160, share = 0.5; // 16 g, the range of usual sensors; probability of a knock
    const Vector3 change = (force - vec(s.held.force)).cwiseAbs().cwiseMin(largest_m_s2);
    for (int i = 0; i < 3; ++i) s.window.lost_gain2[i] += share * square(change[i] * interval_s);
}

// The error is constant for as long as the fault lasts, and as large as what an axis does unseen in a gap.
void note_lost(State& s, double t_s, double interval_s) {
    constexpr double share = 0.5; // of what the axis shows, where it is at its end
    if (!(interval_s > 0) || !std::isfinite(interval_s)) return;
    const auto lost = [&](const SensorCheck<double>& check, const double* shown, double unseen2, double* variance) {
        const double memory_s = t_s - check.since_s + 0.5 * interval_s, usual = std::sqrt(unseen2);
        for (int i = 0; i < 3; ++i)
            variance[i] += check.lost(i, interval_s, t_s, std::fmax(usual, share * std::fabs(shown[i])), memory_s);
    };
    lost(s.check[checked_gyro], s.held.rate, GapMotion::unseen2(GapMotion::rate_rad_s, s.rest.rate2), s.window.lost_turn2);
    lost(s.check[checked_accel], s.held.force, GapMotion::unseen2(GapMotion::force_m_s2, s.rest.force2), s.window.lost_gain2);
}

} // namespace

// The body moves by force, rate or velocity. A sensor that repeats a value meanwhile is faulty.
bool Model::moves(const State& s) const {
    constexpr double turning_rad_s = 0.02, goes_m_s = 1; // more than a bias; faster than any rest
    const bool goes = s.started() && vec(s.x + 3).squaredNorm() > goes_m_s * goes_m_s;
    return goes || s.rest.force2 > options_.rest_force_m_s2 * options_.rest_force_m_s2 ||
           (vec(s.held.rate) - vec(s.gyro_bias)).norm() > turning_rad_s;
}

// A position that equals the previous one bit for bit is stale if the repeated velocity is not that of rest, if the body moves, or if
// the position is far away: receivers and loggers repeat both when they have no fix. A velocity alone may be constant.
void Model::note_stale(State& s, const Event& event, bool elsewhere) {
    bool equal[2] = {};
    for (const int channel : {velocity, position}) {
        double* last = s.fix[channel - velocity];
        if (!event.has(channel)) continue;
        equal[channel - velocity] = std::equal(last, last + 3, event.value[channel], [](double a, double b) { return a == b; });
        std::copy_n(event.value[channel], 3, last);
    }
    if (!event.has(position)) return;
    if (!equal[1]) {
        s.changed_s = event.t_s;
        vec(s.changed_gained) = vec(s.gates.gained);
        return;
    }
    const bool stands = !equal[0] || vec(s.fix[0]).head<2>().isZero(0);
    if (elsewhere) s.note_refusal(position, true, event.t_s);
    else if (stands && (s.phase != Phase::navigating || !has_gone(s, event.t_s))) return;
    s.rejected |= std::uint64_t{1} << position;
    if (equal[0]) s.rejected |= std::uint64_t{1} << velocity;
}

// No GNSS error reaches kilometres: such a position is another receiver's fix or an invalid one, and the velocity of the same fix is
// wrong too.
bool Model::is_elsewhere(const State& s, const Event& event) const {
    constexpr double far_m = 5e3; // chosen: above every error of a receiver that has a fix
    if (!s.started() || !s.has(event, position)) return false;
    const double* p = event.value[position];
    // While the heading is unknown the direction of the displacement is unknown too.
    const double turned2 = is_free(s) ? 4 * vec(s.x).squaredNorm() : 0;
    const Vector3 off = earth::position_of({p[0], p[1], p[2]}) - vec(s.anchor_e) - mat(s.axes) * (vec(s.x) + vec(s.in_t.colour));
    return off.squaredNorm() > square(far_m) + larger_variance(s, row_d) + turned2 &&
           !outlasts(s, position, off.norm(), event.t_s);
}

// Rate and force are one sample: an outlier in one of them rejects both. The value of a stuck or saturated axis is used, and the
// motion that it may have missed is added as noise.
void Model::examine(State& s, const Event& event) const {
    s.rejected = 0;
    const bool has_imu = has_new(s, event, imu), has_field = has_new(s, event, field);
    if (!has_imu && !has_field) return;
    CheckLimits<double> limits(options_, 0);
    const Vector3 rate = vec(s.held.rate) - vec(s.gyro_bias);
    const auto sample = [&](int sensor, Vector3* y) {
        *y = vec(sensor == checked_mag ? event.value[field] : event.value[imu] + 3 * sensor);
        return sensor == checked_mag ? has_field : has_imu;
    };
    const auto interval_s = [&](int sensor) { return event.t_s - s.last_s[sensor == checked_mag ? field : imu]; };
    // The allowed change of a sample grows in proportion to the gap before it.
    const double longer = s.usual_interval_s > 0 ? std::fmax(1, interval_s(checked_gyro) / s.usual_interval_s) : 1;
    for (const int sensor : {checked_gyro, checked_accel}) limits.of[sensor].outlier *= longer;
    const Examined found = hnav::examine(s.check, limits.of, event.t_s, moves(s), turns(rate), sample, interval_s);
    const bool wild = s.check[checked_gyro].fault == SensorFault::outlier || s.check[checked_accel].fault == SensorFault::outlier;
    if (has_imu && wild) s.rejected |= std::uint64_t{1} << imu;
    if ((found.rejected >> checked_mag) & 1) s.rejected |= std::uint64_t{1} << field;
    if (!has_imu || !s.started()) return;
    note_lost(s, event.t_s, interval_s(imu));
    if (s.check[checked_accel].fault == SensorFault::outlier) note_knock(s, vec(event.value[imu] + 3), interval_s(imu));
}

// The sigma of the position is kept: a wide one would accept the next fix unchecked, even an outlier.
void Model::widen_after_clock_jump(State& s) const {
    constexpr double velocity_m_s = 5; // chosen: a firm brake for a second or two
    Covariance P = Covariance::of(s);
    for (int i = 0; i < 3; ++i) {
        P[row_v + i][row_v + i] += square(velocity_m_s);
        P[row_phi + i][row_phi + i] += square(i == 2 ? clock_jump_heading_rad : clock_jump_tilt_rad);
    }
    P.keep(s);
}

} // namespace hnav::ins
