// The state of the navigation filter.
//
//   t  Earth-fixed axes, north-east-down at an anchor near the body. While the heading is unknown vectors of t are held
//      turned about the vertical by -alpha, and u = (cos alpha, sin alpha) is a part of the state.
//   d  displacement from the anchor
#pragma once

#include "estimation/consistency.hpp"
#include "estimation/steps.hpp"
#include "hnav/options/ins.h"
#include "hybrid/event.hpp"
#include "ins/aid_agreement.hpp"
#include "ins/glide.hpp"
#include "maths/earth.hpp"
#include "maths/square.hpp"
#include "signals/gaps.hpp"
#include "signals/rest.hpp"
#include "signals/sensor_checks.hpp"
#include "signals/slow_noise.hpp"
#include "signals/strapdown.hpp"

#include <cmath>
#include <cstdint>
#include <limits>

namespace hnav::ins {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// In the order in which samples of one instant are used.
enum Channel : int { imu, rest, speed, pressure, velocity, position, heading, field, channel_count };

// Values of a sample: rate and force; or those of an aid, followed by their sigmas.
constexpr int event_values = 6;
using Event = FixedEvent<channel_count, event_values>;
using Sample = Event::Sample;

enum class Phase : std::uint64_t { waiting, levelling, any_heading, navigating };
// What the aids have refuted before the heading is found; it starts again at the end of the event.
enum class Refuted : std::uint64_t { nothing, first_fixes, state };

// Rows of the error state: q_true = exp(phi / 2) q, everything else true minus estimate; phi and vectors in t axes.
enum Row : int {
    row_d = 0,
    row_v = 3,
    row_phi = 6,
    row_gyro = 9,
    row_accel = 12,
    row_axes = 15, // E of the gyroscopes, row by row: scales on its diagonal, misalignments beside it
    row_u = 24,
    row_latency = 26,
    row_colour = 27, // slowly varying error of the satellites' position
    row_offset = 30, // of the height by pressure
    row_scale = 31,  // of the speed
    row_mount = 32,  // yaw and pitch of the axis of travel in the body
    row_antenna = 34, // place of the antenna in the body
    errors_without_field = 37,
    row_iron = 37,      // of the body, in the unit of the horizontal field
    row_strength = 40,  // 1 over the horizontal field, in a unit that makes it about 1
    row_direction = 41, // deviation of the horizontal field from the declination, rad
    errors = 42
};

constexpr int nx = 10;    // d 3, v 3, q 4
constexpr int may_step = 9; // rows from row_phi on: attitude, biases of gyroscopes and accelerometers
// Windows for steps: one of the first two begins in the middle of the other, so that none is always short; the newest begins with the last
// accepted velocity.
constexpr int newest_window = 2, step_windows = 3;
constexpr int responses = may_step * step_windows;

// Lower triangle by rows, i <= j being the column: without a magnetometer the first rows suffice.
constexpr int packed(int i, int j) { return j * (j + 1) / 2 + i; }

using Options = hnav_ins_options;
inline bool state_given(const Options& o) { return o.start == HNAV_INS_START_STATE; }
inline bool place_given(const Options& o) { return o.start_place == HNAV_INS_PLACE_GIVEN; }

// The last correction by one channel.
struct Innovation {
    double t_s, value[3], variance[3], nis, noise_scale;
    std::uint64_t dimension;
};

// Rejected velocities are wrong themselves, or the state is. If the state is wrong, the position innovations grow by the integral of the
// velocity innovations; if the velocities are wrong, they do not. The likelihood ratio of both decides.
struct Contradiction {
    enum Verdict : std::uint64_t { open, velocity_wrong, state_wrong };

    double way[3]; // integral of the innovations, m
    double position[3]; // innovation of the position when it began; NaN until there is one
    double last_s; // of the newest velocity
    StepEvidence<may_step> steps[step_windows]; // of the rejected velocities: it counts if the state is found wrong
    Verdict verdict;

    void begin() {
        *this = {};
        position[0] = NAN;
    }
};

// Moments of the density of the heading on the circle.
struct Circle {
    double mode_rad, spread_rad; // of the highest mode, and the RMS about it
    double second_rad, second_share; // of the second highest mode, and its probability; share 0: there is none
    double square[3]; // means of x^2, x y, y^2; (x, y) = (cos - 1, sin) of the heading error
};

// External headings while the heading is unknown: the weighted mean of their alpha.
struct ExternalHeading {
    double alpha_rad, information; // 1 over its variance; 0: there was none
};

// Growth of errors between two corrections, gathered from the samples:
//     phi = phi0 - A dg,   v = v0 + T v0' - [F] phi0 + B dg - A da,   d = d0 + T v0 - [S] phi0 + C dg - D da
// An error dE of the gyroscopes' axes acts like a bias dE rate: by_rate are the integrals of rotation times each rate. What it adds to v and d
// within a window is small.
struct Window {
    double A[9], B[9], C[9], D[9]; // row-major
    double by_rate[3][9];
    double F[3], S[3];
    double began_q[4]; // attitude at its begin
    double false_force2; // at its begin: variance of the horizontal force that errors of tilt and accelerometer bias put into t
    double turned2, accelerated2, length_s; // integrals of the squared rate and acceleration; seconds
    double rate_sum[3]; // integral of the measured rate, rad
    GapMotion gap;
    double lost_turn2[3], lost_gain2[3]; // variances of rotation and velocity missed by stuck or saturated axes, body axes
};

// Velocity integrated from the force in gyro-stabilised axes, against the GNSS velocity.
struct Levelling {
    double q[4]; // body to the gyro-stabilised axes
    double gained[3]; // velocity by force in these axes
    double began_s, since_s; // of the first sample of rate and force, of the first velocity
    double first_velocity_s, velocity0[3]; // at the begin of the window
    double moment[9], sum_seen[3], sum_gained[3], sum_squares, count; // sum_squares: of both
    double variance; // sum of the variances of the velocities
    double A[9], sum_A[9]; // integral of the rotation, and its integral: sensitivity to biases
    double length_s, force[3], samples;
    double fits_s, fits_seen[3], fits_gained[3]; // of the last accepted velocity: its change has the size of the gained velocity
    double refused, takes_all; // number refused in a row; 1: all are accepted
};

// Tests of GNSS jumps that need no heading.
struct FreeGates {
    double velocity_s, velocity[3], gained[3]; // gained by the IMU since then
    double position_s, position[3], jump[3]; // Earth-fixed; north, east, down
    double unknown_m; // by which accelerations may have added to the jump
    double fitting_s, refused_s; // velocities were accepted since; rejected since, NaN: the last one was accepted

    void begin() {
        *this = {};
        velocity_s = position_s = refused_s = nan;
    }
};

// Vectors in t other than displacement, velocity and attitude. It contains vectors only, because turn() rotates all members.
struct InAxes {
    double colour[3]; // slowly varying error of the satellites' position
    double colour_at_rest[3]; // that error when the present rest began
    double mean_force[3]; // force without vibration
    double recent_acceleration[3]; // mean over the GNSS latency, with noise
    double gained[3]; // velocity gained since the search for the heading began
    // Mean of the used magnetometer samples over field_colour_s, in axes of the present attitude estimate.
    double field[3];
    double attitude[3][3]; // mean attitude over the same samples
};

// Members of eight bytes only (saved states); x comes first.
struct State {
    double x[nx];
    // Members that change only at events with an aid, at corrections and before the first tilt. For other events they are not copied
    // (Model::jump counts the changes).
    double P[errors * (errors + 1) / 2]; // just after the last correction
    double response[errors * responses]; // of the error to unit steps at the begin of the windows, row by row
    StepEvidence<may_step> steps[step_windows];
    double steps_since_s[step_windows]; // begin of the windows; NaN: they begin at the next correction
    double mean[errors]; // of the error, relative to the point of linearisation; 0 when the heading is known
    double gyro_bias[3], accel_bias[3], gyro_axes[9], u[2], latency, offset, scale, mount[2], antenna[3];
    double iron[3], strength, direction, field_unit; // magnetometer; field_unit 0: there is none
    Circle circle;
    ExternalHeading external;
    double anchor_e[3], axes[9]; // row-major: columns are the axes of t in Earth-fixed ones
    double earth_rate[3]; // in t
    double fix_axes[9]; // north-east-down of the last fix in Earth-fixed axes
    std::uint64_t has_place;
    // Sigma of the slow GNSS error, horizontal and vertical: now, and at the last correction.
    double slow_m[2], slow_before_m[2];
    double drifted; // 1: that error exceeds its usual size, and the position was widened by it
    Levelling levelling;
    double by_rests[row_axes]; // recent corrections by zero velocities
    double refused_since_s[channel_count]; // NaN: the last one was accepted
    double refused_in_row[channel_count];
    double placed_s; // positions have agreed since this time, until one is rejected
    double speed_known_m_s, speed_sigma_m_s, speed_known_s; // of the GNSS, horizontal
    double slow_since_s; // NaN: the last one was that of motion
    Consistency fits[2]; // of velocity and position
    AidAgreement aids;
    Contradiction contradiction; // velocities that are refused, against the positions
    double turned_b[3]; // rotation by the corrections of the present event, body axes
    double fix[2][3]; // the last velocity and position as received
    double changed_s, changed_gained[3]; // time at which the position last changed; gates.gained at that time
    double inconsistent_s; // time of the last inconsistency
    double restarted_s, bias_inflation; // time of the last restart; factor on the prior sigmas of the biases
    double heading_inflation; // factor on the variance of external headings
    double nis_mean;
    double strain, strained_since_s; // mean NIS of aids that rarely fail; time since it has been large, NaN: it is not
    double information_tilt, information_heading, information_velocity, information_position;
    double gained_nats[channel_count]; // information about the heading, by channel
    double heading_since_s; // the sigma of the heading has been below its limit since; NaN: it is above
    Innovation innovation[channel_count];
    std::uint64_t inflated[channel_count];
    std::uint64_t times_lost, corrections;
    Refuted refuted;
    Phase phase;
    std::uint64_t seldom_changes; // last member of this group

    InAxes in_t;
    double gravity[3], gravity_at[3]; // where it was computed
    HeldSample held;
    SlowNoise slow_noise;
    SensorCheck<double> check[checked_count]; // of rate, force and field
    std::uint64_t rejected; // bit c: the present sample of channel c is treated as missing
    double mean_force2; // mean square of the mean force along the horizontal
    double recent2; // mean square of the recent acceleration along the horizontal
    double false_force2; // mean of the part of these that errors cause: of that of the windows
    double seen_q[4], seen_v[3]; // attitude and velocity just after the last event
    Window window;
    FreeGates gates;
    Unrest rest;
    Glide glide;
    double last_s[channel_count]; // time of the newest sample
    double last_event_s, usual_interval_s, last_correction_s;
    double field_until_s, field_used_s; // newest sample in the mean of the field, NaN: there is none; newest that corrected
    std::uint64_t used[channel_count];
    std::uint64_t gap_too_long;

    bool started() const { return phase >= Phase::any_heading; }
    void forget_rests() {
        for (double& by : by_rests) by = 0;
    }
    // At a new linearisation; the estimated noise of aids and its correlation time are kept.
    void begin_monitors() {
        for (Consistency& fit : fits) fit.begin_again();
        for (double& since_s : steps_since_s) since_s = nan;
    }
    Consistency& fit(int channel) { return fits[channel - velocity]; }
    const Consistency& fit(int channel) const { return fits[channel - velocity]; }
    bool has(const Event& event, int channel) const { return event.has(channel) && !((rejected >> channel) & 1); }
    void note_refusal(int channel, bool refused, double now_s) {
        refused_in_row[channel] = refused ? refused_in_row[channel] + 1 : 0;
        if (!refused) refused_since_s[channel] = nan;
        else if (std::isnan(refused_since_s[channel])) refused_since_s[channel] = now_s;
    }
};

static_assert(sizeof(InAxes) % sizeof(double[3]) == 0);

// Calls visit(row, values, count) for all estimates to which the errors of these rows are added as they are.
template <class AnyState, class Visit>
void each_parameter(AnyState& s, Visit visit) {
    visit(row_gyro, s.gyro_bias, 3);
    visit(row_accel, s.accel_bias, 3);
    visit(row_axes, s.gyro_axes, 9);
    visit(row_u, s.u, 2);
    visit(row_latency, &s.latency, 1);
    visit(row_colour, s.in_t.colour, 3);
    visit(row_offset, &s.offset, 1);
    visit(row_scale, &s.scale, 1);
    visit(row_mount, s.mount, 2);
    visit(row_antenna, s.antenna, 3);
    visit(row_iron, s.iron, 3);
    visit(row_strength, &s.strength, 1);
    visit(row_direction, &s.direction, 1);
}

inline Eigen::Map<Vector3> vec(double* p) { return Eigen::Map<Vector3>(p); }
inline Vector3 vec(const double* p) { return Vector3(p); }
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
inline Eigen::Map<RowMajor3> mat(double* p) { return Eigen::Map<RowMajor3>(p); }
inline Matrix3 mat(const double* p) { return Eigen::Map<const RowMajor3>(p); }
inline Eigen::Map<Quaternion> quat(double* p) { return Eigen::Map<Quaternion>(p); }
inline Quaternion quat(const double* p) { return Quaternion(p); }

} // namespace hnav::ins
