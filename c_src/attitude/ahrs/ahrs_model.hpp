// The AHRS: an error-state filter for the gyroscopes, accelerometers and magnetometers that one can buy.
//
// Known of the body: attitude q, gyro bias b, gyro calibration S (scale and misalignment), horizontal velocity v, the
// reference field M = (H, 0, Z) in units of its strength, and the latency l of the magnetometer. Rate u = y - b - S y.
// The error is held in navigation axes, q_true = exp(theta / 2) q, for there its transition needs no step:
//     theta' = -R_bn (db + dS y) + noise     =>  theta(T) = theta - G db - L dS,  G = int R_bn, L = int R_bn (x) y'
//     dv'    = g (-theta_E, theta_N)             (gravity, not the measured force: heading stays out of the horizon)
// So the flow carries x = (q, G, clock) and not the covariance: at any time
//     P(T) = Phi(G, L, T) P Phi' + Q(T),   Q_theta = int (n_g^2 + k^2 |u|^2) dt.
//
// Samples are gathered in navigation axes at their own times. A few dozen times a second they correct the estimate:
//   velocity   0 = v + noise: a body moves, but it does not run away; this is what tells the horizon
//   rest       mean rate = b
//   field      M against the mean field: azimuth, horizontal and vertical intensity. Tilt, velocity and gyro calibration
//              are considered but not corrected: no magnet may tilt the horizon
// The magnetic reference (magnetic_reference.hpp) decides which field that is. Until the horizon is ready its
// covariance is inflated by the robust law (robust_law.hpp), gamma finite; after that gamma is infinite.
//
// Accelerometer as bounded velocity: Laidig and Seel, Information Fusion 91, 2023, section 3; consider states: Schmidt 1966;
// earth-frame error: Sola, arXiv 1711.02508, section 7.
#pragma once

#include "attitude/ahrs/magnetic_reference.hpp"
#include "attitude/ahrs/rest_detector.hpp"
#include "attitude/common/readiness.hpp"
#include "attitude/common/robust_law.hpp"
#include "attitude/common/start.hpp"
#include "maths/repair.hpp"

namespace hnav {

extern template bool repair<20>(Square<20>& P); // covariance_repair.cpp

class AhrsModel {
public:
    static constexpr int nx = 14; // q 4, G 9, clock: seconds since the last correction
    static constexpr int errors = 20;
    // Rows of the error state. The first thirteen are those that a field does not correct.
    enum Error : int { velocity = 0, calibration = 2, rotation = 11, bias = 14, reference = 17, latency = 19 };
    static constexpr int considered = rotation + 2;
    static constexpr double gravity_m_s2 = 9.80665;
    static constexpr double largest_latency_s = 1; // later fields are turned by more than two terms of a series tell
    static constexpr double rate_change_memory_s = 2; // longer than a swing of the arm

    using Covariance = Square<errors>;
    using Vector = Eigen::Matrix<double, errors, 1>;
    using Matrix39 = Eigen::Matrix<double, 3, 9, Eigen::RowMajor>;

    struct Sigmas {
        double tilt, heading, bias, velocity, reference, latency, scale, misalignment;
    };

    struct Settings {
        double gyro_psd;         // n_g^2, (rad/s)^2/Hz
        double gyro_rate_psd;    // k^2, (rad/s)^2/Hz for each (rad/s)^2
        double bias_walk_psd;    // (rad/s)^2/s
        double reference_psd;    // 1/s
        double velocity_density2; // (m/s)^2/Hz
        double azimuth_density2, intensity_density2; // of the field, 1/Hz
        double rest_field_factor; // of their variances at rest
        double rest_bias_density2; // (rad/s)^2/Hz
        double correction_interval_s;
        double interval_limit_s;
        double unseen_acceleration_m_s2; // that may go by while samples of force are missing
        double unseen_turn_factor;       // and while those of rate are, in units of its usual change
        bool backward_hold;
        RobustSettings robust; // while aligning
        RestSettings rest;
        MagneticReferenceSettings field;
        StartSettings start;
        Vector3 start_bias = Vector3::Zero();
        Sigmas sigma; // at the start; that of heading stands in start
        bool reference_given;
        ReferenceField reference;
        double heading_gate_nis; // 0: never
        double ready_tilt_rad, ready_heading_rad, ready_evidence_s, ready_calm_s;
        double output_latency_s;
    };

    // Doubles and 64-bit integers only.
    struct State {
        double x[nx];
        double P[errors * (errors + 1) / 2]; // just after the last correction
        double bias[3], calibration[9], velocity[2], reference[2], latency;
        double rate[3];     // held, as measured
        double rate_change_power; // running mean square of its change per second, of one axis
        double strength;    // of the field, T
        // Since the last correction: L and int |u|^2, both up to the last event, G and clock there, the gathered samples.
        double lever[27], rate_power, turned[9], turned_s;
        double field_sum[3], turn_sum[3], field_count, field_s, force_s, missing_force_s, missing_rotation;
        RestDetector rest;
        MagneticReference field;
        StartSamples start;
        double last_s[channel_count], spacing_s[channel_count]; // the newest sample, and the time between two
        double last_event_s, last_correction_s;
        double tilt_information, heading_information; // gained since the start, 1/rad^2
        double calm_s; // time for which nothing spoke against the reference
        double gamma, gamma_margin;
        Innovation innovation[channel_count];
        std::uint64_t used[channel_count], gated[channel_count];
        std::uint64_t corrections, gamma_raised, repaired;
        std::uint64_t started, has_rate, has_reference;
        std::uint64_t verdict; // of the last field, MagneticReference::Verdict
        std::uint64_t settled; // the heading has been confirmed since it was last started or turned
    };

    AhrsModel() = default;
    explicit AhrsModel(const Settings& settings) : settings_(settings) {}
    const Settings& settings() const { return settings_; }

    // -------------------------------------------------------------------------------------------- before the start

    void begin(State& s) const {
        Eigen::Map<Vector3>(s.bias) = settings_.start_bias;
        s.gamma = std::numeric_limits<double>::infinity();
        s.gamma_margin = 1;
        for (Innovation& i : s.innovation) i = {};
        forget_attitude(s);
    }

    // Waits for a new start. What was learnt of the sensors stays: bias, calibration, latency.
    void realign(State& s) const {
        const Covariance P = unpack<errors>(s.P);
        forget_attitude(s);
        Covariance kept = unpack<errors>(s.P);
        kept.block<9, 9>(calibration, calibration) = P.block<9, 9>(calibration, calibration);
        kept.block<3, 3>(bias, bias) = P.block<3, 3>(bias, bias);
        kept(latency, latency) = P(latency, latency);
        pack<errors>(kept, s.P);
    }

    // Time reversed from here on, the next sample at t_s: rates change their sign, and with them bias, latency and
    // velocity. The sigmas are those of a filter that has seen the recording, wide enough to learn its other end anew.
    static constexpr bool turns_back = true;
    void turn_back(State& s, double t_s) const {
        for (double& b : s.bias) b = -b;
        for (double& y : s.rate) y = -y;
        s.latency = -s.latency;
        s.velocity[0] = s.velocity[1] = 0;
        start_covariance(s, {0.02, 0.05, 1e-3, settings_.sigma.velocity, 0.03, 3e-3, 7e-4, 7e-4});
        s.field.refused_s = s.field.given_in = s.field.candidate_age_s = s.field.candidate_evidence_s = 0;
        s.rest.clear(Vector3::Zero(), Vector3::Zero());
        for (double& t : s.last_s) t = nan;
        s.last_correction_s = t_s;
        forget_window(s);
    }

    void nominal(double* x) const {
        for (int i = 0; i < 4; ++i) x[i] = 1;
        for (int i = 4; i < 13; ++i) x[i] = settings_.correction_interval_s;
        x[13] = settings_.correction_interval_s;
    }
    void nominal(const State&, double* x) const { nominal(x); }

    // -------------------------------------------------------------------------------------------- flow

    bool flows(const State& s) const { return s.started != 0; }
    bool plausible(const State& s) const { return !s.started || is_plausible(s.x, s.bias); }
    void normalise(State& s) const { restore_length(s.x); }

    void flow(const State& s, const double* x, double* dx) const {
        if (!s.started) {
            for (int i = 0; i < nx; ++i) dx[i] = 0;
            return;
        }
        const Vector3 u = turn_rate(s);
        const Quaternion q(x);
        Eigen::Map<Quaternion>(dx).noalias() = Xi(q) * u;
        Eigen::Map<Matrix3>(dx + 4) = rotation_matrix(q);
        dx[13] = 1;
    }

    // df/dx along a direction.
    void flow_along(const State& s, const double* x, const double* direction, double* out) const {
        for (int i = 0; i < nx; ++i) out[i] = 0;
        if (!s.started) return;
        const Quaternion q(x), dq(direction);
        Eigen::Map<Quaternion>(out).noalias() = Xi(dq) * turn_rate(s);
        // R is quadratic in q: its derivative is the difference of two values, exactly.
        Eigen::Map<Matrix3>(out + 4) = 0.5 * (rotation_matrix(q + dq) - rotation_matrix(q - dq));
    }

    // T may be negative: backwards under the same rate.
    void flow_exactly(State& s, double T) const {
        const Vector3 u = turn_rate(s);
        const HeldTurn turn(u, T);
        const Quaternion q(s.x);
        Eigen::Map<Matrix3>(s.x + 4).noalias() += rotation_matrix(q) * turn.integral;
        Eigen::Map<Quaternion>(s.x) = multiply(q, turn.q);
        s.x[13] += T;
    }

    // -------------------------------------------------------------------------------------------- jump

    static constexpr bool reholds = true;

    void before_flow(State& s, const Event& event) const {
        if (!settings_.backward_hold || !event.has(gyro)) return;
        // Events of other sensors since the last rate went on under that one. If the new rate stands for their interval
        // too, it takes its place; if samples of rate are missing in between, the mean of both does.
        const double went_on_s = s.last_event_s - s.last_s[gyro];
        const Vector3 before = turn_rate(s);
        hold(s, event);
        if (s.started && went_on_s > 0) {
            const Vector3 after = gap(s, gyro, event.t_s) ? Vector3(0.5 * (turn_rate(s) + before)) : turn_rate(s);
            const Quaternion instead = multiply(rotation_quaternion(before * -went_on_s), rotation_quaternion(after * went_on_s));
            Eigen::Map<Quaternion>(s.x) = multiply(Quaternion(s.x), instead);
        }
    }

    // For a state that an integrator outside has brought over T seconds under the rate of before: the rate that came with
    // the event takes its place, the error of the integrator stays.
    void rehold(State& s, const Event& event, double T) const {
        if (!settings_.backward_hold || !event.has(gyro)) return;
        const bool flowed = s.started && T > 0 && !std::isinf(T);
        if (flowed) flow_exactly(s, -T);
        before_flow(s, event);
        if (flowed) flow_exactly(s, T);
    }

    void jump(State& s, const Event& event) const {
        for (int c = 0; c < channel_count; ++c) s.used[c] += event.has(c);
        if (s.started) {
            Eigen::Map<Quaternion>(s.x).normalize();
            take_turn(s);
        }
        if (event.has(gyro) && !settings_.backward_hold) hold(s, event);
        if (!s.started) {
            start(s, event);
        } else {
            gather(s, event);
            const double since = event.t_s - s.last_correction_s;
            // At the sample nearest to the interval, whatever its jitter.
            const double half_sample_s = event.has(gyro) ? 0.5 * interval(s, gyro, event.t_s) : 0;
            if (since + half_sample_s >= settings_.correction_interval_s || event.has(heading)) correct(s, event);
        }
        for (int c = 0; c < channel_count; ++c)
            if (event.has(c)) see_time(s, c, event.t_s);
        s.last_event_s = event.t_s;
    }

    // -------------------------------------------------------------------------------------------- what it knows

    Estimate estimate(const State& s) const {
        Estimate e;
        e.started = s.started != 0;
        e.rate_b = turn_rate(s);
        e.bias_b = Vector3(s.bias);
        e.q_bn = Quaternion(s.x).normalized();
        if (settings_.output_latency_s != 0)
            e.q_bn = multiply(e.q_bn, rotation_quaternion(e.rate_b * settings_.output_latency_s));
        if (!e.started) return e;
        e.tilt_ready = tilt_ready(s);
        e.heading_ready = heading_ready(s);
        return e;
    }

    Matrix3 rotation_covariance(const State& s) const { return error_covariance(s).topLeftCorner<3, 3>(); }
    Vector3 bias_variances(const State& s) const {
        Vector3 v;
        for (int i = 0; i < 3; ++i) v[i] = s.P[packed(bias + i, bias + i)] + settings_.bias_walk_psd * s.x[13];
        return v;
    }

    // Rotation and bias at the time of x.
    ErrorCovariance error_covariance(const State& s) const {
        ErrorCovariance C;
        const Covariance P = unpack<errors>(s.P);
        C.bottomRightCorner<3, 3>() = P.block<3, 3>(bias, bias);
        C.bottomRightCorner<3, 3>().diagonal().array() += settings_.bias_walk_psd * s.x[13];
        if (!s.started) {
            C.topRows<3>().setZero();
            C.leftCols<3>().setZero();
            C.topLeftCorner<3, 3>() = P.block<3, 3>(rotation, rotation);
            return C;
        }
        State now = s;
        take_turn(now);
        const Turned turned(P, now);
        C.topLeftCorner<3, 3>() = turned.rotation;
        C.topLeftCorner<3, 3>().diagonal().array() += rotation_noise(now);
        C.topRightCorner<3, 3>() = turned.columns.middleRows<3>(bias).transpose();
        C.bottomLeftCorner<3, 3>() = turned.columns.middleRows<3>(bias);
        return C;
    }

    double bias_walk(const State&) const { return std::sqrt(settings_.bias_walk_psd); }

    // Not computed: a correction considers states that it leaves alone, and the field may change its reference in between.
    double decay_rate(const State&) const { return 0; }

    FieldEstimate field_estimate(const State& s) const {
        FieldEstimate f;
        f.known = s.has_reference != 0;
        f.strength_tesla = s.strength * std::hypot(s.reference[0], s.reference[1]);
        f.dip_rad = std::atan2(s.reference[1], s.reference[0]);
        f.latency_s = s.latency;
        f.latency_sigma_s = std::sqrt(s.P[packed(latency, latency)]);
        f.evidence_s = s.field.evidence_s;
        f.heading_trust_s = s.field.heading_trust_s;
        f.adopted = static_cast<int>(s.field.adopted);
        f.gate = static_cast<FieldGate>(s.verdict < 2 ? s.verdict : 2);
        f.at_rest = s.rest.at_rest(settings_.rest);
        return f;
    }

    // Scale and misalignment S of the gyroscope, row-major, and the sigma of each.
    void gyro_calibration(const State& s, double* S, double* sigma) const {
        for (int i = 0; i < 9; ++i) {
            S[i] = s.calibration[i];
            sigma[i] = std::sqrt(s.P[packed(calibration + i, calibration + i)]);
        }
    }

private:
    static constexpr int packed(int i, int j) { return i * errors - i * (i - 1) / 2 + j - i; } // i <= j, of pack()

    // How fast the rate changes tells how far off the turn may be while samples of it are missing.
    static void hold(State& s, const Event& event) {
        const Vector3 rate(event.value[gyro]);
        const double T = event.t_s - s.last_s[gyro];
        if (s.has_rate && T > 0 && !gap(s, gyro, event.t_s)) {
            const double power = (rate - Vector3(s.rate)).squaredNorm() / (3 * T * T);
            s.rate_change_power += T / (T + rate_change_memory_s) * (power - s.rate_change_power);
        }
        Eigen::Map<Vector3>(s.rate) = rate;
        s.has_rate = 1;
    }

    // Before the first gyro sample the body is taken to be still.
    static Vector3 turn_rate(const State& s) {
        if (!s.has_rate) return Vector3::Zero();
        const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> S(s.calibration);
        const Vector3 y(s.rate);
        return y - Vector3(s.bias) - S * y;
    }

    // The interval that a sample stands for: the time since the one before, or the usual one if samples are missing, within
    // the limit. The first stands for none.
    double interval(const State& s, int channel, double t_s) const {
        const double since = t_s - s.last_s[channel];
        if (!(since > 0)) return 0;
        return std::fmin(gap(s, channel, t_s) ? s.spacing_s[channel] : since, settings_.interval_limit_s);
    }

    // Samples are missing when the time since the last is far above the usual; jitter and a single loss are not.
    static bool gap(const State& s, int channel, double t_s) {
        return s.spacing_s[channel] > 0 && t_s - s.last_s[channel] > 3 * s.spacing_s[channel];
    }

    static void see_time(State& s, int channel, double t_s) {
        const double since = t_s - s.last_s[channel];
        double& spacing = s.spacing_s[channel];
        if (since > 0) // a sensor that has become slower is believed after a few samples
            spacing = !(spacing > 0) ? since : gap(s, channel, t_s) ? 1.2 * spacing : spacing + 0.1 * (since - spacing);
        s.last_s[channel] = t_s;
    }

    bool tilt_ready(const State& s) const {
        const double tilt = std::fmax(s.P[packed(rotation, rotation)], s.P[packed(rotation + 1, rotation + 1)]);
        return angle_ready(tilt, s.tilt_information, settings_.ready_tilt_rad);
    }

    // A field that is false and steady looks like a true one. What can be asked for is that it was seen for a while, from
    // several sides or for longer, and that nothing spoke against it for longer than most disturbances pass unnoticed.
    bool heading_ready(const State& s) const {
        return s.settled != 0 &&
               angle_ready(s.P[packed(rotation + 2, rotation + 2)], s.heading_information, settings_.ready_heading_rad);
    }

    // -------------------------------------------------------------------------------------------- start

    void forget_attitude(State& s) const {
        for (double& v : s.x) v = 0;
        s.x[0] = 1;
        s.started = 0;
        s.start.clear();
        s.field = {};
        s.velocity[0] = s.velocity[1] = 0;
        for (double& t : s.last_s) t = nan;
        for (double& t : s.spacing_s) t = 0;
        s.last_correction_s = nan;
        s.tilt_information = s.heading_information = 0;
        s.verdict = s.settled = 0;
        s.calm_s = 0;
        s.has_reference = settings_.reference_given;
        put_reference(s, settings_.reference);
        start_covariance(s, start_sigmas(settings_.start.sigma_heading));
        forget_window(s);
    }

    static void start_covariance(State& s, const Sigmas& start) {
        Vector sigma;
        sigma.segment<2>(velocity).setConstant(start.velocity);
        sigma.segment<9>(calibration).setConstant(start.misalignment);
        for (int i = 0; i < 9; i += 4) sigma[calibration + i] = start.scale;
        sigma.segment<2>(rotation).setConstant(start.tilt);
        sigma[rotation + 2] = start.heading;
        sigma.segment<3>(bias).setConstant(start.bias);
        sigma.segment<2>(reference).setConstant(start.reference);
        sigma[latency] = start.latency;
        pack<errors>(Covariance(sigma.cwiseAbs2().asDiagonal()), s.P);
    }

    Sigmas start_sigmas(double sigma_heading) const {
        Sigmas sigmas = settings_.sigma;
        sigmas.heading = sigma_heading;
        return sigmas;
    }

    // A field known beforehand is the unit; a learnt one is its own.
    static void put_reference(State& s, const ReferenceField& field) {
        s.strength = field.strength;
        s.reference[0] = std::cos(field.dip_rad);
        s.reference[1] = std::sin(field.dip_rad);
    }

    void start(State& s, const Event& event) const {
        Quaternion q;
        double sigma_heading;
        if (!s.start.add(event, settings_.start, &q, &sigma_heading)) return;
        Eigen::Map<Quaternion>(s.x) = q;
        const bool realigned = s.corrections > 0;
        Covariance P = unpack<errors>(s.P);
        if (!realigned) start_covariance(s, start_sigmas(sigma_heading));
        else {
            P(rotation + 2, rotation + 2) = sigma_heading * sigma_heading;
            pack<errors>(P, s.P);
        }
        if (!s.has_reference && s.start.has_field(settings_.start)) {
            put_reference(s, learn_reference(q, s.start.field()));
            s.has_reference = 1;
        }
        s.rest.clear(Vector3::Zero(), s.start.count[0] ? s.start.force() : Vector3::Zero());
        s.last_correction_s = event.t_s;
        s.started = 1;
    }

    // A filter that started without a field meets one: its azimuth is north, so the heading turns to it.
    void meet_field(State& s, const Vector3& field_b) const {
        const Vector3 field_n = rotation_matrix(Quaternion(s.x)) * field_b;
        if (!(std::hypot(field_n[0], field_n[1]) > 1e-3 * field_n.norm())) return;
        const double from_north = std::atan2(field_n[1], field_n[0]);
        Covariance P = unpack<errors>(s.P);
        if (from_north * from_north > P(rotation + 2, rotation + 2) || P(rotation + 2, rotation + 2) > 1) {
            turn_heading(s, -from_north);
            P(rotation + 2, rotation + 2) += settings_.start.sigma_heading * settings_.start.sigma_heading;
            pack<errors>(P, s.P);
        }
        put_reference(s, learn_reference(Quaternion(s.x), field_b));
        s.has_reference = 1;
    }

    // -------------------------------------------------------------------------------------------- gathering

    static void forget_window(State& s) {
        for (int i = 4; i < nx; ++i) s.x[i] = 0;
        for (double& v : s.lever) v = 0;
        for (double& v : s.turned) v = 0;
        s.rate_power = s.turned_s = 0;
        for (int i = 0; i < 3; ++i) s.field_sum[i] = s.turn_sum[i] = 0;
        s.field_count = s.field_s = s.force_s = s.missing_force_s = s.missing_rotation = 0;
    }

    // int (n_g^2 + k^2 |u|^2) dt since the last correction, and what went by unseen
    double rotation_noise(const State& s) const {
        return settings_.gyro_psd * s.x[13] + settings_.gyro_rate_psd * s.rate_power + s.missing_rotation;
    }

    // While samples of rate are missing the turn is not known: after T seconds to within a T^2 / 2 by the last rate, and
    // to a T^2 / 8 by the mean of the last and the next, with an angular acceleration a as it was before.
    void miss_turn(State& s, const Event& event) const {
        if (!gap(s, gyro, event.t_s)) return;
        const double T = event.t_s - s.last_s[gyro],
                     share = (event.has(gyro) ? 0.125 : 0.5) * settings_.unseen_turn_factor * T * T;
        s.missing_rotation += share * share * s.rate_change_power;
    }

    // L += dG (x) y for the turn since the last event, which went on under one rate.
    static void take_turn(State& s) {
        s.rate_power += turn_rate(s).squaredNorm() * (s.x[13] - s.turned_s);
        s.turned_s = s.x[13];
        const Eigen::Map<const Matrix3> G(s.x + 4);
        Eigen::Map<Matrix3> seen(s.turned);
        const Matrix3 turn = G - seen;
        seen = G;
        const Vector3 y(s.rate);
        double* out = s.lever;
        for (int i = 0; i < 3; ++i)
            for (int l = 0; l < 3; ++l)
                for (int j = 0; j < 3; ++j) *out++ += turn(i, l) * y[j];
    }

    void gather(State& s, const Event& event) const {
        const Matrix3 R = rotation_matrix(Quaternion(s.x));
        if (event.has(gyro)) s.rest.see_rate(settings_.rest, Vector3(s.rate), interval(s, gyro, event.t_s));
        if (event.has(accel)) {
            const Vector3 force_b(event.value[accel]);
            const double since = event.t_s - s.last_s[accel], T = interval(s, accel, event.t_s);
            const Vector3 force_n = R * force_b;
            s.velocity[0] += force_n[0] * T;
            s.velocity[1] += force_n[1] * T;
            s.force_s += T;
            if (since > T) s.missing_force_s += since - T;
            s.rest.see_force(settings_.rest, force_b, T);
        }
        if (event.has(mag)) {
            const Vector3 measured_b(event.value[mag]);
            if (!s.has_reference) {
                meet_field(s, measured_b);
                return;
            }
            // The field of `latency` ago, turned on to now: to second order in the turn.
            const Vector3 u = turn_rate(s), field_b = measured_b / s.strength;
            const Vector3 turning = u.cross(field_b);
            const Vector3 now_b = field_b - s.latency * turning + 0.5 * s.latency * s.latency * u.cross(turning);
            Eigen::Map<Vector3>(s.field_sum) += R * now_b;
            Eigen::Map<Vector3>(s.turn_sum) += R * u;
            s.field_count += 1;
            s.field_s += interval(s, mag, event.t_s);
        }
    }

    // -------------------------------------------------------------------------------------------- correction

    // Columns of P Phi' for the rotation, and its own block.
    struct Turned {
        Eigen::Matrix<double, errors, 3> columns; // covariance of the error before with the rotation after
        Matrix3 rotation;

        Turned(const Covariance& P, const State& s) {
            const Eigen::Map<const Matrix3> G(s.x + 4);
            const Eigen::Map<const Matrix39> L(s.lever);
            // Column by column, here and below: Eigen would send products of this size through code for large matrices.
            for (int i = 0; i < 3; ++i) {
                Vector column = P.col(Error::rotation + i);
                for (int j = 0; j < 3; ++j) column -= G(i, j) * P.col(bias + j);
                for (int j = 0; j < 9; ++j) column -= L(i, j) * P.col(calibration + j);
                columns.col(i) = column;
            }
            rotation = columns.middleRows<3>(Error::rotation);
            rotation -= G.lazyProduct(columns.middleRows<3>(bias));
            rotation -= L.lazyProduct(columns.middleRows<9>(calibration));
        }
    };

    // P <- Phi P Phi' + Q over the time since the last correction.
    void propagate(Covariance& P, const State& s) const {
        const Eigen::Map<const Matrix3> G(s.x + 4);
        const Eigen::Map<const Matrix39> L(s.lever);
        const Turned turned(P, s);

        // v_N -= g T theta_E, v_E += g T theta_N, with the mean of theta before and after.
        const double half = 0.5 * gravity_m_s2 * s.force_s;
        Eigen::Matrix<double, errors, 2> v = P.middleCols<2>(velocity); // of the error before with v after
        v.col(0) -= half * (P.col(rotation + 1) + turned.columns.col(1));
        v.col(1) += half * (P.col(rotation) + turned.columns.col(0));
        Eigen::Matrix<double, 3, 2> theta_v = v.middleRows<3>(rotation); // theta after, v after
        theta_v -= G.lazyProduct(v.middleRows<3>(bias));
        theta_v -= L.lazyProduct(v.middleRows<9>(calibration));
        Eigen::Matrix2d v_v = v.middleRows<2>(velocity);
        v_v.row(0) -= half * (v.row(rotation + 1) + theta_v.row(1));
        v_v.row(1) += half * (v.row(rotation) + theta_v.row(0));

        P.middleCols<3>(rotation) = turned.columns;
        P.middleRows<3>(rotation) = turned.columns.transpose();
        P.middleCols<2>(velocity) = v;
        P.middleRows<2>(velocity) = v.transpose();
        P.block<3, 3>(rotation, rotation) = turned.rotation;
        P.block<3, 2>(rotation, velocity) = theta_v;
        P.block<2, 3>(velocity, rotation) = theta_v.transpose();
        P.block<2, 2>(velocity, velocity) = v_v;

        const double T = s.x[13], lost = settings_.unseen_acceleration_m_s2 * s.missing_force_s;
        P.diagonal().segment<2>(velocity).array() += lost * lost;
        P.diagonal().segment<3>(rotation).array() += rotation_noise(s);
        P.diagonal().segment<3>(bias).array() += settings_.bias_walk_psd * T;
        P.diagonal().segment<2>(reference).array() += settings_.reference_psd * T;
    }

    // The errors from row `first` on learn from m rows H with PHt = P H' and S = H P H' + R; those before are considered,
    // not corrected (Schmidt): P_ij -= PHt_i S^-1 PHt_j' unless both i and j are. False, and nothing learnt, where rounding
    // has left S without its sign: a reading beyond all sense, millions of times another.
    template <int m, int first>
    static bool condition(Covariance& P, Vector& error, const Eigen::Matrix<double, errors, m>& PHt, const Square<m>& S,
                          const Eigen::Matrix<double, m, 1>& innovation) {
        constexpr int rest = errors - first;
        const Cholesky<m> factor(S);
        if (!factor.positive()) return false;
        const Eigen::Matrix<double, m, rest> Kt = factor.template solve<rest>(PHt.template bottomRows<rest>().transpose());
        error.template tail<rest>().noalias() += Kt.transpose() * innovation;
        for (int j = 0; j < rest; ++j) {
            Vector column = P.col(first + j);
            for (int k = 0; k < m; ++k) column -= Kt(k, j) * PHt.col(k);
            P.col(first + j) = column;
        }
        if constexpr (first > 0)
            P.template bottomRows<rest>().template leftCols<first>() =
                P.template rightCols<rest>().template topRows<first>().transpose();
        return true;
    }

    // innovation' S^-1 innovation; 0 where S has no sign.
    template <int m>
    static double normalised_square(const Square<m>& S, const Eigen::Matrix<double, m, 1>& innovation) {
        const Cholesky<m> factor(S);
        return factor.positive() ? factor.template quadratic_form<1>(innovation)(0, 0) : 0;
    }

    void correct(State& s, const Event& event) const {
        Covariance P = unpack<errors>(s.P);
        miss_turn(s, event);
        propagate(P, s);
        align(s, P);
        Vector error = Vector::Zero();

        const double tilt_before = std::fmax(P(rotation, rotation), P(rotation + 1, rotation + 1));
        bool sound = true;
        if (s.force_s > 0) sound &= correct_velocity(s, P, error, event.t_s);
        s.tilt_information += information_gained(tilt_before, std::fmax(P(rotation, rotation), P(rotation + 1, rotation + 1)));
        if (s.rest.at_rest(settings_.rest)) sound &= correct_bias(s, P, error);
        if (s.field_count > 0 && s.field_s > 0) sound &= correct_field(s, P, error, event.t_s);
        if (event.has(heading)) sound &= correct_heading(s, P, error, event);

        apply(s, error);
        keep(s, P, sound);
        // What is no number any more must not stay: the engine looks at x and drops the event.
        if (!std::isfinite(P.diagonal().sum() + error.sum())) s.x[0] = std::numeric_limits<double>::quiet_NaN();
        forget_window(s);
        s.last_correction_s = event.t_s;
        ++s.corrections;
    }

    // gamma is finite until the horizon is ready: the start may be further off than its sigma says. The heading is not
    // inflated: one that was wrong from the start is found by evidence, which an inflated sigma would call a small change.
    void align(State& s, Covariance& P) const {
        RobustReport report;
        if (settings_.robust.mode != GammaMode::off && !tilt_ready(s))
            P = inflate_block<errors, 2>(P, rotation, Eigen::Vector2d(1, 1), s.x[13], settings_.robust, &report);
        s.gamma = report.gamma;
        s.gamma_margin = report.margin;
        s.gamma_raised += report.raised;
    }

    bool correct_velocity(State& s, Covariance& P, Vector& error, double t_s) const {
        const Eigen::Matrix<double, errors, 2> PHt = P.middleCols<2>(velocity);
        Eigen::Matrix2d S = P.block<2, 2>(velocity, velocity);
        S.diagonal().array() += settings_.velocity_density2 / s.force_s;
        const Eigen::Vector2d innovation(-s.velocity[0], -s.velocity[1]);
        Innovation& i = s.innovation[accel];
        i = {};
        i.t_s = t_s;
        i.dimension = 2;
        i.value[0] = innovation[0];
        i.value[1] = innovation[1];
        i.S[0] = S(0, 0);
        i.S[1] = i.S[3] = S(0, 1);
        i.S[4] = S(1, 1);
        i.nis = normalised_square<2>(S, innovation);
        return condition<2, 0>(P, error, PHt, S, innovation);
    }

    bool correct_bias(const State& s, Covariance& P, Vector& error) const {
        const Eigen::Matrix<double, errors, 3> PHt = P.middleCols<3>(bias);
        Matrix3 S = P.block<3, 3>(bias, bias);
        S.diagonal().array() += settings_.rest_bias_density2 / s.x[13];
        const Vector3 innovation = Vector3(s.rest.mean_rate) - Vector3(s.bias) - error.segment<3>(bias);
        return condition<3, 0>(P, error, PHt, S, innovation);
    }

    bool correct_field(State& s, Covariance& P, Vector& error, double t_s) const {
        const double T = s.field_s;
        MeanField mean{Vector3(s.field_sum) / s.field_count};
        const Vector3 u_n = Vector3(s.turn_sum) / s.field_count;
        const double fast = settings_.field.turning_rad_s;
        const bool turning = s.rate_power > fast * fast * s.x[13];
        choose_reference(s, P, mean, turning, T);

        const double H = s.reference[0], Z = s.reference[1];
        // Azimuth, horizontal and vertical intensity: exact for any heading error.
        const Vector3 residual(H - mean.horizontal(), -H * mean.azimuth_rad(), Z - mean.n[2]);
        const auto verdict = s.field.judge(settings_.field, length(residual[0], residual[2]), T);
        s.verdict = static_cast<std::uint64_t>(verdict);
        const bool given_in =
            verdict == MagneticReference::Verdict::give_in || verdict == MagneticReference::Verdict::give_in_now;
        if (verdict == MagneticReference::Verdict::give_in_now) forget_reference(P, error, settings_.sigma.reference);

        // residual = H_m error: theta x M - dM - (u x M) dl
        const Vector3 M(H, 0, Z), swept = u_n.cross(M);
        Eigen::Matrix<double, errors, 3> PHt;
        PHt.col(0) = Z * P.col(rotation + 1) - P.col(reference) - swept[0] * P.col(latency);
        PHt.col(1) = H * P.col(rotation + 2) - Z * P.col(rotation) - swept[1] * P.col(latency);
        PHt.col(2) = -H * P.col(rotation + 1) - P.col(reference + 1) - swept[2] * P.col(latency);
        Matrix3 S;
        Vector3 innovation;
        const auto project = [&](const auto& c) {
            return Vector3(Z * c[rotation + 1] - c[reference] - swept[0] * c[latency],
                           H * c[rotation + 2] - Z * c[rotation] - swept[1] * c[latency],
                           -H * c[rotation + 1] - c[reference + 1] - swept[2] * c[latency]);
        };
        for (int k = 0; k < 3; ++k) S.col(k) = project(PHt.col(k));
        innovation = residual - project(error);

        const double deviation = length(residual[0], residual[2]) / settings_.field.gate;
        const double scale = (s.rest.at_rest(settings_.rest) ? settings_.rest_field_factor : 1) / T;
        const double soft = given_in ? deviation * deviation : 1;
        const Vector3 R(settings_.intensity_density2 * scale, settings_.azimuth_density2 * scale,
                        settings_.intensity_density2 * scale);
        Innovation& i = s.innovation[mag];
        i = {};
        i.t_s = t_s;
        i.dimension = 3;
        i.noise_scale = verdict == MagneticReference::Verdict::refuse ? std::numeric_limits<double>::infinity() : soft;
        Eigen::Map<Vector3>(i.value) = innovation;
        Matrix3 S_plain = S;
        S_plain.diagonal() += R;
        Eigen::Map<Matrix3>(i.S) = S_plain;
        i.nis = normalised_square<3>(S_plain, innovation);
        // One refusal may be noise: it takes back thrice its own time.
        s.calm_s = verdict == MagneticReference::Verdict::accept ? s.calm_s + T : std::fmax(0, s.calm_s - 3 * T);
        // A place where the reference has changed before is asked for thrice as long.
        const double calm_needed_s = settings_.ready_calm_s * (s.field.adopted > 0 ? 3 : 1);
        if (s.calm_s >= calm_needed_s && s.field.heading_trust_s >= settings_.ready_evidence_s) s.settled = 1;
        if (i.noise_scale > 1) s.gated[mag] += static_cast<std::uint64_t>(s.field_count);
        if (verdict == MagneticReference::Verdict::refuse) return true;

        S.diagonal() += soft * R;
        const double before = P(rotation + 2, rotation + 2);
        const bool sound = condition<3, considered>(P, error, PHt, S, innovation);
        s.heading_information += information_gained(before, P(rotation + 2, rotation + 2));
        return sound;
    }

    // Evidence, and the change of reference that it may bring; turns the mean field with the heading.
    void choose_reference(State& s, Covariance& P, MeanField& mean, bool turning, double T) const {
        MagneticReference& field = s.field;
        field.weigh(settings_.field, mean, s.reference[0], s.reference[1], turning, T);
        if (!field.candidate_wins(settings_.field, s.reference[0], s.reference[1])) return;
        double& variance = P(rotation + 2, rotation + 2);
        const double distrust = field.distrust(settings_.field, variance);
        keep_unit(s, mean);
        s.reference[0] = field.candidate_horizontal();
        s.reference[1] = field.candidate[2];
        Vector none = Vector::Zero();
        forget_reference(P, none, settings_.field.gate);
        if (distrust > 0) {
            const double angle = -distrust * field.candidate_azimuth_rad();
            turn_heading(s, angle);
            mean.n = rotation_matrix(rotation_quaternion({0, 0, angle})) * mean.n;
            variance += distrust * settings_.field.heading_added_rad * settings_.field.heading_added_rad;
            s.heading_information = 0;
            s.settled = 0;
            field.heading_trust_s *= 1 - distrust;
        }
        field.adopt_candidate();
        s.calm_s = 0;
    }

    // Gates and noise are in units of the strength. One that started inside a shield or beside a magnet would measure the
    // field that it adopts in units of another one; within four of them no place on Earth differs from another.
    static void keep_unit(State& s, MeanField& mean) {
        const double change = Vector3(s.field.candidate).norm();
        if ((change < 4 && change > 0.25) || change == 0) return;
        s.strength *= change;
        Eigen::Map<Vector3>(s.field.candidate) /= change;
        mean.n /= change;
    }

    // Turns attitude and all that is kept in navigation axes about the vertical.
    static void turn_heading(State& s, double angle_rad) {
        const Quaternion about_down = rotation_quaternion({0, 0, angle_rad});
        Eigen::Map<Quaternion>(s.x) = multiply(about_down, Quaternion(s.x));
        const double c = std::cos(angle_rad), sn = std::sin(angle_rad);
        for (double* v : {s.velocity, s.field.candidate}) {
            const double north = v[0], east = v[1];
            v[0] = c * north - sn * east;
            v[1] = sn * north + c * east;
        }
    }

    static void forget_reference(Covariance& P, Vector& error, double sigma) {
        P.middleRows<2>(reference).setZero();
        P.middleCols<2>(reference).setZero();
        P.diagonal().segment<2>(reference).setConstant(sigma * sigma);
        error.segment<2>(reference).setZero();
    }

    // True heading of body x from a heading aid. It does not correct the horizon either.
    bool correct_heading(State& s, Covariance& P, Vector& error, const Event& event) const {
        const Vector3 body_x = rotation_matrix(Quaternion(s.x)).col(0);
        const double level = body_x.head<2>().squaredNorm();
        if (!(level > 1e-4)) return true; // body x is within 0.6 deg of the vertical: it has no heading
        // theta x body_x, seen about down
        const Vector3 h(-body_x[2] * body_x[0] / level, -body_x[2] * body_x[1] / level, 1);
        const Eigen::Matrix<double, errors, 1> PHt = P.middleCols<3>(rotation) * h;
        const double sigma = event.value[heading][1];
        Square<1> S(h.dot(PHt.segment<3>(rotation)) + sigma * sigma);
        const Eigen::Matrix<double, 1, 1> innovation(wrap_angle(event.value[heading][0] - std::atan2(body_x[1], body_x[0])) -
                                                     h.dot(error.segment<3>(rotation)));
        Innovation& i = s.innovation[heading];
        i = {};
        i.t_s = event.t_s;
        i.dimension = 1;
        i.value[0] = innovation[0];
        i.S[0] = S(0, 0);
        i.nis = normalised_square<1>(S, innovation);
        const double limit = settings_.heading_gate_nis;
        if (limit > 0 && i.nis > limit && heading_ready(s)) {
            i.noise_scale = 1 + (i.nis / limit - 1) * S(0, 0) / (sigma * sigma);
            S(0, 0) *= i.nis / limit;
            ++s.gated[heading];
        }
        const double before = P(rotation + 2, rotation + 2);
        const bool sound = condition<1, considered>(P, error, PHt, S, innovation);
        s.heading_information += information_gained(before, P(rotation + 2, rotation + 2));
        s.settled = 1; // heading from elsewhere needs no evidence of a field
        return sound;
    }

    static void apply(State& s, const Vector& error) {
        Eigen::Map<Quaternion> q(s.x);
        q = multiply(rotation_quaternion(error.segment<3>(rotation)), Quaternion(q)).normalized();
        Eigen::Map<Vector3>(s.bias) += error.segment<3>(bias);
        Eigen::Map<Eigen::Matrix<double, 9, 1>>(s.calibration) += error.segment<9>(calibration);
        Eigen::Map<Eigen::Vector2d>(s.velocity) += error.segment<2>(velocity);
        Eigen::Map<Eigen::Vector2d>(s.reference) += error.segment<2>(reference);
        s.reference[0] = std::fmax(0, s.reference[0]); // by what north means; a correction near a magnetic pole may not see it
        s.latency = std::clamp(s.latency + error[latency], -largest_latency_s, largest_latency_s);
    }

    // A variance that is not positive is the first that rounding would break; only then, or when a correction met a matrix
    // without its sign, is the whole matrix looked at.
    static void keep(State& s, Covariance& P, bool sound) {
        if (!sound || !(P.diagonal().minCoeff() > 0)) s.repaired += repair<errors>(P);
        pack<errors>(P, s.P);
    }

    Settings settings_;
};

} // namespace hnav
