// The paper's filter: hybrid extended Kalman filter (gamma infinite) and hybrid robust extended Kalman filter.
//
// States x = (q, b, P): attitude quaternion, gyro bias, upper triangle of their 7 x 7 covariance. With the held rate w
// and u = w - b the flow is
//     q' = Xi(q) u,   b' = 0,   P' = A P + P A' + L Qc L',
//     A = [Omega(u), -Xi(q); 0, 0],   L = [-Xi(q), 0; 0, I],   Qc = blkdiag(gyro noise, Q_b)
// and the jump at a sample
//     Sigma = inflate(P),  S = H Sigma H' + R,  K = Sigma H' S^-1,  x += K nu,
//     P+ = (I - K H) Sigma (I - K H)' + K R K'   (Joseph; equals the paper's (Sigma^-1 + H'R^-1 H)^-1)
// followed by the return of q to the unit sphere, of which the covariance learns too.
// Equations: Hybrid Robust Extended Kalman Filter for SINS initial alignment, TJEE 54(4), 2024,
// doi 10.22034/tjee.2023.57843.4683, with (9) to (17) corrected.
#pragma once

#include "attitude/common/estimate.hpp"
#include "attitude/common/readiness.hpp"
#include "attitude/common/robust_law.hpp"
#include "attitude/common/start.hpp"
#include "attitude/hrekf/decay_rate.hpp"
#include "attitude/hrekf/noise_adaptation.hpp"
#include "maths/cholesky.hpp"
#include "maths/repair.hpp"

namespace hnav {

extern template bool repair<7>(Square<7>& P); // covariance_repair.cpp

class HrekfModel {
public:
    static constexpr int nx = 35;
    using Covariance = Square<7>;
    using Vector7 = Eigen::Matrix<double, 7, 1>;

    struct Settings {
        double gyro_psd;       // (rad/s)^2/Hz
        double quaternion_psd; // 1/s, on all four components alike: the paper's L = I
        double bias_walk_psd;  // (rad/s)^2/s
        double accel_density2; // 1/Hz, of a direction
        double mag_density2;   // 1/Hz, of a field in units of the reference strength
        double interval_limit_s;
        bool backward_hold;
        RobustSettings robust;
        Vector7 weight = Vector7::Ones(); // L of the H-infinity term, diagonal
        AdaptationSettings adaptation;
        StartSettings start;
        Vector3 start_bias = Vector3::Zero();
        double sigma_tilt, sigma_bias;
        bool reference_given;
        ReferenceField reference;
        double gate_nis[channel_count]; // 0: never
        double ready_tilt_rad, ready_heading_rad;
    };

    // Doubles and 64-bit integers only.
    struct State {
        double x[nx];
        double rate[3];     // held
        double bias_psd[6]; // upper triangle of Q_b
        double reference_strength, reference_north, reference_down; // of the unit field
        StartSamples start;
        double last_s[channel_count]; // time of the newest sample of each channel
        double last_correction_s;
        double previous_bias_covariance[6]; // after the last correction
        double tilt_information, heading_information; // gained since the start, 1/rad^2
        double gamma, gamma_margin;
        ErrorMap error_map; // over the last correction
        Innovation innovation[channel_count];
        std::uint64_t used[channel_count], gated[channel_count];
        std::uint64_t corrections, gamma_raised, repaired, adaptations;
        std::uint64_t started, has_rate, has_reference;
    };

    HrekfModel() = default;
    explicit HrekfModel(const Settings& settings) : settings_(settings) {}

    // -------------------------------------------------------------------------------------------- before the start

    void begin(State& s) const {
        const Quaternion identity(1, 0, 0, 0);
        put_q(s, identity);
        Eigen::Map<Vector3>(s.x + 4) = settings_.start_bias;
        Covariance P = Covariance::Zero();
        P.topLeftCorner<4, 4>() = attitude_covariance(identity, settings_.sigma_tilt, settings_.start.sigma_heading);
        P.bottomRightCorner<3, 3>().diagonal().setConstant(settings_.sigma_bias * settings_.sigma_bias);
        pack<7>(P, s.x + 7);
        pack<3>(Matrix3(settings_.bias_walk_psd * Matrix3::Identity()), s.bias_psd);
        s.gamma = std::numeric_limits<double>::infinity();
        s.gamma_margin = 1;
        for (Innovation& i : s.innovation) i = {};
        forget_attitude(s);
    }

    // Waits for a new start; bias, its covariance and the counters stay.
    void realign(State& s) const {
        put_q(s, {1, 0, 0, 0});
        forget_attitude(s);
    }

    void nominal(double* x) const { nominal_sizes(settings_.sigma_tilt, settings_.start.sigma_heading, settings_.sigma_bias, x); }

    // Sizes of the states from the sigmas that a state claims now; never below a ten-thousandth of the initial ones.
    void nominal(const State& s, double* x) const {
        Covariance P = unpack<7>(s.x + 7);
        const double tilt = 2 * std::sqrt(std::fmax(0, P.topLeftCorner<4, 4>().trace()));
        const double bias = std::sqrt(std::fmax(0, P.bottomRightCorner<3, 3>().trace()));
        nominal_sizes(std::fmax(tilt, 1e-4 * settings_.sigma_tilt), std::fmax(tilt, 1e-4 * settings_.start.sigma_heading),
                      std::fmax(bias, 1e-4 * settings_.sigma_bias), x);
    }

    // -------------------------------------------------------------------------------------------- flow

    bool flows(const State& s) const { return s.started != 0; }
    bool plausible(const State& s) const { return !s.started || is_plausible(s.x, s.x + 4); }
    void normalise(State& s) const { restore_length(s.x); }

    void flow(const State& s, const double* x, double* dx) const {
        if (!s.started) {
            for (int i = 0; i < nx; ++i) dx[i] = 0;
            return;
        }
        const Quaternion q(x);
        const Blocks P(x + 7);
        const Eigen::Matrix4d A_qq = Omega(turn_rate(s, x));
        const Matrix43 A_qb = -Xi(q);

        Eigen::Map<Quaternion>(dx).noalias() = A_qq * q;
        dx[4] = dx[5] = dx[6] = 0;
        Blocks dP;
        const Eigen::Matrix4d half = A_qq * P.qq + A_qb * P.qb.transpose();
        dP.qq = half + half.transpose() + attitude_noise(q);
        dP.qb.noalias() = A_qq * P.qb + A_qb * P.bb;
        dP.bb = unpack<3>(s.bias_psd);
        dP.write(dx + 7);
    }

    // df/dx along a direction: the flow is bilinear in q, u and P, so this is the product rule.
    void flow_along(const State& s, const double* x, const double* direction, double* out) const {
        if (!s.started) {
            for (int i = 0; i < nx; ++i) out[i] = 0;
            return;
        }
        const Quaternion q(x), dq(direction);
        const Blocks P(x + 7), dP(direction + 7);
        const Eigen::Matrix4d A_qq = Omega(turn_rate(s, x));
        const Eigen::Matrix4d dA_qq =
            s.has_rate ? Omega(Vector3(-direction[4], -direction[5], -direction[6])) : Eigen::Matrix4d(Eigen::Matrix4d::Zero());
        const Matrix43 A_qb = -Xi(q), dA_qb = -Xi(dq);

        Eigen::Map<Quaternion>(out).noalias() = A_qq * dq + dA_qq * q;
        out[4] = out[5] = out[6] = 0;
        Blocks result;
        const Eigen::Matrix4d half = A_qq * dP.qq + dA_qq * P.qq + A_qb * dP.qb.transpose() + dA_qb * P.qb.transpose();
        const Eigen::Matrix4d noise_half =
            0.25 * settings_.gyro_psd * (q.dot(dq) * Eigen::Matrix4d::Identity() - dq * q.transpose());
        result.qq = half + half.transpose() + noise_half + noise_half.transpose();
        result.qb.noalias() = A_qq * dP.qb + dA_qq * P.qb + A_qb * dP.bb + dA_qb * P.bb;
        result.bb.setZero();
        result.write(out + 7);
    }

    // The flow over an interval, exact because the rate is held. With r = exp(u T/2) the quaternion turns by right
    // multiplication, q+ = E q, and a bias error b enters through Phi_qb = -Xi(q+) G, G = integral of exp(-[u]x t).
    void flow_exactly(State& s, double T) const {
        const Vector3 u = turn_rate(s, s.x);
        const TurnIntegrals I(u.norm(), T);
        const Matrix3 U = cross_matrix(u);
        const Matrix3 UU = U * U;
        const Matrix3 G = T * Matrix3::Identity() - I.b * U + I.g * UU;
        const Eigen::Matrix4d E = right_multiplication(rotation_quaternion(u * T));
        const Quaternion q_next = E * Quaternion(s.x);
        const Matrix43 B = Xi(q_next);
        const Matrix43 F = -B * G;

        // Phi P Phi'
        const Blocks P(s.x + 7);
        Blocks next;
        const Matrix43 turned = E * P.qb;
        next.qb.noalias() = turned + F * P.bb;
        const Eigen::Matrix4d turned_qq = E * P.qq * E.transpose();
        const Eigen::Matrix4d cross = next.qb * F.transpose() + F * turned.transpose();
        next.qq = turned_qq + cross;
        next.bb = P.bb;

        // Noise of the interval, as rotation (theta) and bias: the walk of the bias reaches theta through G.
        const Matrix3 Qb = unpack<3>(s.bias_psd);
        const Matrix3 theta_b = -(0.5 * T * T * Qb - I.g * U * Qb + I.g1 * UU * Qb);
        const Matrix3 a = U * Qb, aU = a * U, Ua = U * a, UaU = U * aU;
        const Matrix3 theta_theta = I.aa * Qb - I.ab * (a + a.transpose()) + I.ag * (Ua + Ua.transpose()) - I.bb * aU +
                                    I.bg * (UaU + UaU.transpose()) + I.gg * UaU * U;
        Matrix3 theta = theta_theta;
        theta.diagonal().array() += settings_.gyro_psd * T;
        next.qq.noalias() += B * theta * B.transpose();
        next.qq.diagonal().array() += settings_.quaternion_psd * T;
        next.qb.noalias() += B * theta_b;
        next.bb += T * Qb;

        put_q(s, q_next);
        next.write(s.x + 7);
    }

    // -------------------------------------------------------------------------------------------- jump

    // The covariance went through the flow too, and its way back is not stable: no hold after the fact.
    static constexpr bool turns_back = false;
    static constexpr bool reholds = false;
    void rehold(State&, const Event&, double) const {}

    void before_flow(State& s, const Event& event) const {
        if (settings_.backward_hold && event.has(gyro)) hold(s, event);
    }

    void jump(State& s, const Event& event) const {
        for (int c = 0; c < channel_count; ++c) s.used[c] += event.has(c);
        if (!s.started) collect_for_start(s, event);
        else {
            flow_error_map(s.error_map, event.t_s, Quaternion(s.x).normalized(), turn_rate(s, s.x));
            correct_directions(s, event);
            if (event.has(heading)) correct_heading(s, event);
        }
        for (int c = 0; c < channel_count; ++c)
            if (event.has(c)) s.last_s[c] = event.t_s;
        if (event.has(gyro)) hold(s, event);
    }

    // -------------------------------------------------------------------------------------------- what it knows

    Estimate estimate(const State& s) const {
        Estimate e;
        e.started = s.started != 0;
        e.q_bn = Quaternion(s.x).normalized();
        e.rate_b = turn_rate(s, s.x);
        e.bias_b = Vector3(s.x + 4);
        const Vector3 variance = rotation_variances(s);
        e.tilt_ready =
            e.started && angle_ready(std::fmax(variance[0], variance[1]), s.tilt_information, settings_.ready_tilt_rad);
        e.heading_ready = e.started && angle_ready(variance[2], s.heading_information, settings_.ready_heading_rad);
        return e;
    }

    ErrorCovariance error_covariance(const State& s) const {
        const Quaternion q = Quaternion(s.x).normalized();
        const Blocks P(s.x + 7);
        const Matrix34 T = rotation_from_q(q);
        ErrorCovariance C;
        C.topLeftCorner<3, 3>() = T * P.qq * T.transpose();
        C.topRightCorner<3, 3>() = T * P.qb;
        C.bottomLeftCorner<3, 3>() = C.topRightCorner<3, 3>().transpose();
        C.bottomRightCorner<3, 3>() = P.bb;
        return C;
    }

    // Variances of the rotation error about north, east and down.
    Vector3 rotation_variances(const State& s) const {
        return rotation_variances(Quaternion(s.x).normalized(), Blocks(s.x + 7).qq);
    }

    static Vector3 rotation_variances(const Quaternion& q, const Eigen::Matrix4d& Pqq) {
        const Matrix34 T = rotation_from_q(q);
        return (T * Pqq).cwiseProduct(T).rowwise().sum();
    }

    Matrix3 rotation_covariance(const State& s) const {
        const Matrix34 T = rotation_from_q(Quaternion(s.x).normalized());
        return T * Blocks(s.x + 7).qq * T.transpose();
    }

    Vector3 bias_variances(const State& s) const { return Blocks(s.x + 7).bb.diagonal(); }

    // Root of the mean power of the bias walk in use, adapted or not.
    double bias_walk(const State& s) const { return std::sqrt(unpack<3>(s.bias_psd).trace() / 3); }

    double decay_rate(const State& s) const { return hnav::decay_rate(s.error_map); }

    FieldEstimate field_estimate(const State& s) const {
        FieldEstimate f;
        f.known = s.has_reference != 0;
        f.strength_tesla = s.reference_strength;
        f.dip_rad = std::atan2(s.reference_down, s.reference_north);
        f.gate = s.innovation[mag].noise_scale > 1 ? FieldGate::given_in : FieldGate::accepted;
        return f;
    }

    // Not estimated.
    void gyro_calibration(const State&, double* S, double* sigma) const {
        for (int i = 0; i < 9; ++i) S[i] = sigma[i] = 0;
    }

private:
    // The covariance by its blocks, to and from the packed upper triangle.
    struct Blocks {
        Eigen::Matrix4d qq;
        Matrix43 qb;
        Matrix3 bb;

        Blocks() = default;
        explicit Blocks(const double* upper) {
            for (int i = 0; i < 4; ++i) {
                for (int j = i; j < 4; ++j) qq(i, j) = qq(j, i) = *upper++;
                for (int j = 0; j < 3; ++j) qb(i, j) = *upper++;
            }
            bb = unpack<3>(upper);
        }
        void write(double* upper) const {
            for (int i = 0; i < 4; ++i) {
                for (int j = i; j < 4; ++j) *upper++ = qq(i, j);
                for (int j = 0; j < 3; ++j) *upper++ = qb(i, j);
            }
            pack<3>(bb, upper);
        }
    };

    // With G(t) = t I - b(t) U + g(t) U^2, U = [u]x, w = |u|: the coefficients at T and the integrals over [0, T] of
    // their products (a = t), which give the integral of G Q G' for any Q.
    struct TurnIntegrals {
        double b, g, g1; // b(T), g(T) = integral of b, g1 = integral of g
        double aa, ab, ag, bb, bg, gg;

        TurnIntegrals(double w, double T) {
            const double x = w * T, x2 = x * x, T2 = T * T, T3 = T2 * T;
            aa = T3 / 3;
            if (x < 0.02) { // the closed forms lose digits: their series instead
                b = T2 * (0.5 - x2 / 24 + x2 * x2 / 720);
                g = T3 * (1.0 / 6 - x2 / 120 + x2 * x2 / 5040);
                g1 = T2 * T2 * (1.0 / 24 - x2 / 720);
                ab = T2 * T2 * (1.0 / 8 - x2 / 144 + x2 * x2 / 5760);
                ag = T3 * T2 * (1.0 / 30 - x2 / 840);
                bb = T3 * T2 * (1.0 / 20 - x2 / 168);
                gg = T3 * T3 * T * (1.0 / 252 - x2 / 3240);
            } else {
                const double w2 = w * w, s = std::sin(x), c = std::cos(x), h = std::sin(0.5 * x);
                b = 2 * h * h / w2;
                g = (x - s) / (w2 * w);
                g1 = (0.5 * x2 - 2 * h * h) / (w2 * w2);
                ab = (0.5 * T2 - T * s / w + 2 * h * h / w2) / w2;
                ag = (w * aa - (s - x * c) / w2) / (w2 * w);
                bb = (1.5 * T - 2 * s / w + s * c / (2 * w)) / (w2 * w2);
                gg = (w2 * aa - 2 * (s - x * c) / w + 0.5 * T - s * c / (2 * w)) / (w2 * w2 * w2);
            }
            bg = 0.5 * g * g; // since g' = b
        }
    };

    static void put_q(State& s, const Quaternion& q) { Eigen::Map<Quaternion>(s.x) = q; }

    static void hold(State& s, const Event& event) {
        for (int i = 0; i < 3; ++i) s.rate[i] = event.value[gyro][i];
        s.has_rate = 1;
    }

    // Before the first gyro sample the body is taken to be still.
    static Vector3 turn_rate(const State& s, const double* x) {
        if (!s.has_rate) return Vector3::Zero();
        return {s.rate[0] - x[4], s.rate[1] - x[5], s.rate[2] - x[6]};
    }

    // Omega(u) q = 1/2 q (x) (0, u)
    static Eigen::Matrix4d Omega(const Vector3& u) {
        Eigen::Matrix4d m;
        m << 0, -u[0], -u[1], -u[2], //
            u[0], 0, u[2], -u[1],    //
            u[1], -u[2], 0, u[0],    //
            u[2], u[1], -u[0], 0;
        return 0.5 * m;
    }

    static Eigen::Matrix4d right_multiplication(const Quaternion& r) {
        Eigen::Matrix4d m;
        m << r[0], -r[1], -r[2], -r[3], //
            r[1], r[0], r[3], -r[2],    //
            r[2], -r[3], r[0], r[1],    //
            r[3], r[2], -r[1], r[0];
        return m;
    }

    // Xi N Xi' = N/4 (|q|^2 I - q q') for white gyro noise of density N
    Eigen::Matrix4d attitude_noise(const Quaternion& q) const {
        Eigen::Matrix4d Q = -0.25 * settings_.gyro_psd * q * q.transpose();
        Q.diagonal().array() += 0.25 * settings_.gyro_psd * q.squaredNorm() + settings_.quaternion_psd;
        return Q;
    }

    // Rotation about the navigation axes of a quaternion error: theta = 2 vec(dq (x) conj(q)); its inverse is T'/4.
    static Matrix34 rotation_from_q(const Quaternion& q) {
        Matrix34 T;
        T << -q[1], q[0], -q[3], q[2], //
            -q[2], q[3], q[0], -q[1],  //
            -q[3], -q[2], q[1], q[0];
        return 2 * T;
    }

    static Eigen::Matrix4d attitude_covariance(const Quaternion& q, double tilt, double heading_sigma) {
        const Matrix34 T = rotation_from_q(q);
        const Vector3 variance(tilt * tilt, tilt * tilt, heading_sigma * heading_sigma);
        return T.transpose() * variance.asDiagonal() * T / 16;
    }

    static void nominal_sizes(double tilt, double heading_sigma, double bias, double* x) {
        Vector7 sigma;
        sigma.head<4>().setConstant(0.5 * std::fmax(tilt, heading_sigma));
        sigma.tail<3>().setConstant(bias);
        for (int i = 0; i < 4; ++i) x[i] = 1;
        for (int i = 4; i < 7; ++i) x[i] = std::fmax(bias, 1e-6);
        // The gain is a quotient of covariances, and correlations are often far below one: an absolute tolerance on the
        // scale of the product of two sigmas would be felt in the bias. Hence a hundredth of it.
        pack<7>(Covariance((0.01 * sigma * sigma.transpose()).cwiseMax(1e-14)), x + 7);
    }

    // -------------------------------------------------------------------------------------------- start

    void forget_attitude(State& s) const {
        s.started = 0;
        for (int c = 0; c < channel_count; ++c) s.last_s[c] = nan;
        s.start.clear();
        s.tilt_information = s.heading_information = 0;
        s.last_correction_s = nan;
        s.error_map.interval_s = 0;
        s.has_reference = settings_.reference_given;
        put_reference(s, settings_.reference);
        pack<3>(Blocks(s.x + 7).bb, s.previous_bias_covariance);
    }

    static void put_reference(State& s, const ReferenceField& reference) {
        s.reference_strength = reference.strength;
        s.reference_north = std::cos(reference.dip_rad);
        s.reference_down = std::sin(reference.dip_rad);
    }

    void collect_for_start(State& s, const Event& event) const {
        Quaternion q;
        double heading_sigma;
        if (!s.start.add(event, settings_.start, &q, &heading_sigma)) return;
        put_q(s, q);
        Covariance P = Covariance::Zero();
        P.topLeftCorner<4, 4>() = attitude_covariance(q, settings_.sigma_tilt, heading_sigma);
        P.bottomRightCorner<3, 3>() = Blocks(s.x + 7).bb;
        pack<7>(P, s.x + 7);
        if (!s.has_reference && s.start.has_field(settings_.start)) learn(s, q, s.start.field());
        begin_error_map(s.error_map, event.t_s, q, P);
        s.last_correction_s = event.t_s;
        s.started = 1;
    }

    static void learn(State& s, const Quaternion& q, const Vector3& field_b) {
        put_reference(s, learn_reference(q, field_b));
        s.has_reference = 1;
    }

    // -------------------------------------------------------------------------------------------- correction

    // The interval that a sample stands for: the time since the one before, within the limit. The first of a channel
    // stands for none: it carries no information, because its density has nothing to act over.
    double interval(const State& s, int channel, double t_s) const {
        const double since = t_s - s.last_s[channel];
        return since > 0 ? std::fmin(since, settings_.interval_limit_s) : 0;
    }

    // Force and field of one event, together: the six-row correction of the paper.
    void correct_directions(State& s, const Event& event) const {
        const double T_accel = event.has(accel) ? interval(s, accel, event.t_s) : 0;
        double T_mag = event.has(mag) ? interval(s, mag, event.t_s) : 0;
        if (event.has(mag) && !s.has_reference) { // started without a field: this one becomes the reference
            learn(s, Quaternion(s.x).normalized(), Vector3(event.value[mag]));
            T_mag = 0;
        }
        const Direction force{accel, Vector3(0, 0, -1), Vector3(event.value[accel]).normalized(),
                              settings_.accel_density2 / T_accel};
        const Direction field{mag, Vector3(s.reference_north, 0, s.reference_down),
                              in_units(event.value[mag], s.reference_strength), settings_.mag_density2 / T_mag};
        if (T_accel > 0 && T_mag > 0) correct_by<2>(s, event.t_s, {force, field});
        else if (T_accel > 0) correct_by<1>(s, event.t_s, {force});
        else if (T_mag > 0) correct_by<1>(s, event.t_s, {field});
    }

    // Of a field a thousand times the reference no more than the direction is to be believed: taken at its word it would
    // throw the bias beyond all rates.
    static Vector3 in_units(const double* field, double strength) {
        const Vector3 b = Vector3(field) / strength;
        const double length = b.norm();
        return length > 1e3 ? Vector3(b * (1e3 / length)) : b;
    }

    // A vector known in the navigation frame and measured in the body.
    struct Direction {
        int channel;
        Vector3 reference_n;
        Vector3 measured_b;
        double variance;
    };

    template <int count>
    struct Directions {
        Direction at[count];
    };

    template <int count>
    void correct_by(State& s, double t_s, const Directions<count>& directions) const {
        constexpr int m = 3 * count;
        const Quaternion q(s.x);
        const Matrix3 R_nb = rotation_matrix(q).transpose();
        Eigen::Matrix<double, m, 1> nu;
        Eigen::Matrix<double, m, 4> H;
        Square<m> R = Square<m>::Zero();
        for (int k = 0; k < count; ++k) {
            const Direction& d = directions.at[k];
            nu.template segment<3>(3 * k) = d.measured_b - R_nb * d.reference_n;
            H.template middleRows<3>(3 * k) = J_body_q(q, d.reference_n);
            R.template block<3, 3>(3 * k, 3 * k).diagonal().setConstant(d.variance);
        }

        Correction<m> correction(*this, s, t_s, H, R);
        const Square<m> S = correction.innovation_covariance();
        Innovation* used[count];
        bool gated = false;
        for (int k = 0; k < count; ++k) {
            const Direction& d = directions.at[k];
            const Matrix3 S_k = S.template block<3, 3>(3 * k, 3 * k);
            const double scale = record(s, d.channel, t_s, nu.template segment<3>(3 * k), S_k, d.variance);
            used[k] = &s.innovation[d.channel];
            if (scale > 1) {
                // A sample beyond its gate is not dropped: its noise grows until its distance is at the limit.
                gated = true;
                R.template block<3, 3>(3 * k, 3 * k) += (used[k]->nis / settings_.gate_nis[d.channel] - 1) * S_k;
                ++s.gated[d.channel];
            }
        }
        const bool by_force = directions.at[0].channel == accel;
        const bool by_field = directions.at[count - 1].channel == mag;
        if (gated) correction.change_noise(R);
        correction.apply(s, nu, by_force, by_field, gated);
    }

    // Keeps what a sensor said and answers the factor by which its gate inflates the noise.
    double record(State& s, int channel, double t_s, const Vector3& nu, const Matrix3& S, double variance) const {
        Innovation& i = s.innovation[channel];
        i.t_s = t_s;
        i.dimension = 3;
        Eigen::Map<Vector3>(i.value) = nu;
        Eigen::Map<Matrix3>(i.S) = S;
        i.nis = std::fmax(0, Cholesky<3>(S).quadratic_form<1>(nu)(0, 0)); // rounding, where S is nearly singular
        i.noise_scale = 1;
        const double limit = settings_.gate_nis[channel];
        if (limit > 0 && i.nis > limit && gate_works(s, channel))
            i.noise_scale = 1 + (i.nis / limit - 1) * S.trace() / (3 * variance);
        return i.noise_scale;
    }

    // Gates rely on the estimate, so each waits until the angle that its sensor sees is ready.
    bool gate_works(const State& s, int channel) const {
        const Estimate e = estimate(s);
        return channel == accel ? e.tilt_ready : e.tilt_ready && e.heading_ready;
    }

    // True heading of body x from a heading aid; one row.
    void correct_heading(State& s, const Event& event) const {
        const Quaternion q(s.x);
        // Body x in the navigation frame: heading = atan2(east, north), and both are quadratic in q.
        const double north = q[0] * q[0] + q[1] * q[1] - q[2] * q[2] - q[3] * q[3];
        const double east = 2 * (q[1] * q[2] + q[0] * q[3]);
        const double level = north * north + east * east;
        if (!(level > 1e-4)) return; // body x is within 6 deg of the vertical: it has no heading
        Eigen::Matrix<double, 1, 4> H;
        H << north * q[3] - east * q[0], north * q[2] - east * q[1], north * q[1] + east * q[2], north * q[0] + east * q[3];
        H *= 2 / level;

        const double sigma = event.value[heading][1];
        const Square<1> R(sigma * sigma);
        const Eigen::Matrix<double, 1, 1> nu(wrap_angle(event.value[heading][0] - std::atan2(east, north)));
        Correction<1> correction(*this, s, event.t_s, H, R);
        const double S = correction.innovation_covariance()(0, 0);
        Innovation& i = s.innovation[heading];
        i = {};
        i.t_s = event.t_s;
        i.dimension = 1;
        i.value[0] = nu[0];
        i.S[0] = S;
        i.nis = nu[0] * nu[0] / S;
        const double limit = settings_.gate_nis[heading];
        if (limit > 0 && i.nis > limit && gate_works(s, heading)) {
            const Square<1> inflated(R(0, 0) + (i.nis / limit - 1) * S);
            i.noise_scale = inflated(0, 0) / R(0, 0);
            ++s.gated[heading];
            correction.change_noise(inflated);
        }
        correction.apply(s, nu, false, true, i.noise_scale > 1);
    }

    // One correction of m rows that see the quaternion only: H = [H_q, 0].
    template <int m>
    class Correction {
    public:
        using Rows = Eigen::Matrix<double, m, 1>;
        using Gain = Eigen::Matrix<double, 7, m>;

        Correction(const HrekfModel& model, State& s, double t_s, const Eigen::Matrix<double, m, 4>& H, const Square<m>& R)
            : settings_(model.settings_), H_(H), t_s_(t_s), interval_s_(t_s - s.last_correction_s) {
            P_ = unpack<7>(s.x + 7);
            keep_sense(P_);
            RobustReport report = predict();
            change_noise(R);
            if (!factor_.positive()) { // over a long gap the integrator has left P indefinite
                s.repaired += repair<7>(P_);
                report = predict();
                HSigmaHt_.diagonal() = HSigmaHt_.diagonal().cwiseMax(0);
                change_noise(R);
            }
            s.gamma = report.gamma;
            s.gamma_margin = report.margin;
            s.gamma_raised += report.raised;
        }

        void change_noise(const Square<m>& R) {
            R_ = R;
            S_ = HSigmaHt_ + R;
            symmetrise<m>(S_);
            factor_ = Cholesky<m>(S_);
        }

        const Square<m>& innovation_covariance() const { return S_; }

        void apply(State& s, const Rows& nu, bool sees_tilt, bool sees_heading, bool gated) {
            const Quaternion q_minus = Quaternion(s.x).normalized();
            const Vector3 before = rotation_variances(q_minus, P_.template topLeftCorner<4, 4>());
            const Gain K = factor_.template solve<7>(SigmaHt_.transpose()).transpose();

            // Joseph form; I - K H differs from I in its first four columns only.
            const Eigen::Matrix<double, 7, 4> KH = K * H_;
            Covariance P = Sigma_;
            P.noalias() -= KH * Sigma_.template topRows<4>();
            const Eigen::Matrix<double, 7, 4> left = P.template leftCols<4>();
            P.noalias() -= left * KH.transpose();
            P.noalias() += times_noise(K, R_) * K.transpose();

            if (settings_.adaptation.mode != Adaptation::off) adapt(s, nu, K, gated);

            Eigen::Map<Vector7> x(s.x);
            x.noalias() += K * nu;
            const double norm = return_to_unit_sphere(s, P);
            symmetrise<7>(P);
            s.repaired += repair<7>(P);
            pack<7>(P, s.x + 7);
            pack<3>(Matrix3(P.template bottomRightCorner<3, 3>()), s.previous_bias_covariance);

            jump_error_map(s.error_map, interval_s_, KH, q_minus, Quaternion(s.x), norm, P);
            s.last_correction_s = t_s_;
            ++s.corrections;
            const Vector3 after = rotation_variances(Quaternion(s.x), P.template topLeftCorner<4, 4>());
            if (sees_tilt)
                s.tilt_information += information_gained(std::fmax(before[0], before[1]), std::fmax(after[0], after[1]));
            if (sees_heading) s.heading_information += information_gained(before[2], after[2]);
        }

    private:
        RobustReport predict() {
            RobustReport report;
            Sigma_ = inflate<7>(P_, settings_.weight, interval_s_, settings_.robust, &report);
            SigmaHt_.noalias() = Sigma_.template leftCols<4>() * H_.transpose();
            HSigmaHt_.noalias() = H_ * SigmaHt_.template topRows<4>();
            return report;
        }

        // A unit quaternion has no error beyond 1. After ages without a sample its variances outgrow the digits that the
        // noise needs beside them in S; turned down on both sides, P stays a covariance.
        static void keep_sense(Covariance& P) {
            constexpr double largest = 1e6;
            const double trace = P.template topLeftCorner<4, 4>().trace();
            if (!(trace > largest)) return;
            const double factor = std::sqrt(largest / trace);
            P.template topRows<4>() *= factor;
            P.template leftCols<4>() *= factor;
        }

        // K R, where R is block-diagonal: sensors do not share noise.
        static Gain times_noise(const Gain& K, const Square<m>& R) {
            constexpr int n = m % 3 == 0 ? 3 : m;
            Gain KR;
            for (int k = 0; k < m; k += n)
                KR.template middleCols<n>(k).noalias() = K.template middleCols<n>(k) * R.template block<n, n>(k, k);
            return KR;
        }

        // q <- q/|q|, whose derivative is J = (I - q q')/|q|: P <- J P J' on the quaternion. Answers |q|.
        static double return_to_unit_sphere(State& s, Covariance& P) {
            Eigen::Map<Quaternion> x_q(s.x);
            const double norm = x_q.norm();
            x_q /= norm;
            const Quaternion q = x_q;
            const Eigen::Matrix<double, 1, 7> along = q.transpose() * P.template topRows<4>();
            P.template topRows<4>().noalias() -= q * along;
            P.template topRows<4>() /= norm;
            const Vector7 along_columns = P.template leftCols<4>() * q;
            P.template leftCols<4>().noalias() -= along_columns * q.transpose();
            P.template leftCols<4>() /= norm;
            return norm;
        }

        void adapt(State& s, const Rows& nu, const Gain& K, bool gated) const {
            const AdaptationSettings& adaptation = settings_.adaptation;
            const Matrix3 Q = unpack<3>(s.bias_psd);
            if (adaptation.mode == Adaptation::paper) {
                pack<3>(adapt_as_printed(Q, adaptation, K.template bottomRows<3>() * nu), s.bias_psd);
                return;
            }
            // The plain Kalman correction, uninflated; its bias block only.
            const Gain PHt = P_.template leftCols<4>() * H_.transpose();
            Square<m> S = H_ * PHt.template topRows<4>() + R_;
            symmetrise<m>(S);
            const Eigen::Matrix<double, 3, m> bias_rows = PHt.template bottomRows<3>();
            const Eigen::Matrix<double, 3, m> K0 = Cholesky<m>(S).template solve<3>(bias_rows.transpose()).transpose();
            const Matrix3 posterior = P_.template bottomRightCorner<3, 3>() - K0 * bias_rows.transpose();
            if (!gated && interval_s_ > 0) {
                ++s.adaptations;
                const Matrix3 adapted = adapt_corrected(Q, adaptation, K0 * nu, posterior, unpack<3>(s.previous_bias_covariance),
                                                        interval_s_, static_cast<double>(s.adaptations));
                pack<3>(adapted, s.bias_psd);
            }
        }

        const Settings& settings_;
        const Eigen::Matrix<double, m, 4>& H_;
        double t_s_, interval_s_;
        Covariance P_, Sigma_;
        Gain SigmaHt_;
        Square<m> HSigmaHt_, R_, S_;
        Cholesky<m> factor_;
    };

    Settings settings_;
};

} // namespace hnav
