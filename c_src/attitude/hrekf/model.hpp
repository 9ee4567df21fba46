// The paper's filter: hybrid extended Kalman filter (gamma infinite) and hybrid robust extended Kalman filter.
//
// Estimated are the attitude quaternion q, the gyro bias b and their 7 x 7 covariance P. With the held rate w and u = w - b the flow
// is
//     q' = Xi(q) u,   b' = 0,   P' = A P + P A' + L Qc L',
//     A = [Omega(u), -Xi(q); 0, 0],   L = [-Xi(q), 0; 0, I],   Qc = blkdiag(gyro noise, Q_b)
// of which the integrator gets q and the integral of its rotation matrix, from which P follows: covariance.cpp. The jump at a sample is
//     Sigma = inflate(P),  S = H Sigma H' + R,  K = Sigma H' S^-1,  x += K nu,
//     P+ = Sigma - K H Sigma   (equals the paper's (Sigma^-1 + H'R^-1 H)^-1)
// followed by the normalisation of q, which is applied to the covariance too.
// Equations: Hybrid Robust Extended Kalman Filter for SINS initial alignment, TJEE 54(4), 2024,
// doi 10.22034/tjee.2023.57843.4683, with (9) to (17) corrected.
//
// The members are defined in the files named beside them.
#pragma once

#include "attitude/hrekf/state.hpp"
#include "base/instant.hpp"
#include "maths/scalar.hpp"
#include "signals/sampling.hpp"

namespace hnav {

struct HrekfDirection; // correct_directions.cpp
struct HrekfRows;
class HrekfCorrection; // correction.hpp

class HrekfModel {
public:
    using R = Scalar;
    static constexpr int nx = AttitudeFlow<R>::nx;
    static constexpr int sensors = heading + 1; // those that it takes, in the order of Channel
    using Event = AttitudeEvent;
    using Place = AttitudeFlow<R>;
    using State = HrekfState;
    using Options = hnav_hrekf_options;
    using Covariance = Square<6, R>; // of (theta, b): rotation error about the navigation axes, gyro bias error

    HrekfModel() : HrekfModel(Options{}) {}
    explicit HrekfModel(const Options& options, const Frames& frames = {})
        : options_(options),
          density_(options),
          law_(options),
          gates_(options),
          start_(options, frames),
          limits_(options, R(options.mag_range_tesla)) {}

    // The state before any sample. start.cpp
    void begin(State& s) const;
    // Waits for a new start; bias, its covariance and the counters stay.
    void realign(State& s) const;

    // Sizes of the states that absolute tolerances are relative to.
    void nominal(R* x) const {
        constexpr R usual_s = R(0.01); // between two corrections
        std::fill(x, x + Place::A, R(1));
        std::fill(x + Place::A, x + nx, usual_s);
    }
    bool flows(const State& s) const { return s.started != 0; }
    bool plausible(const State& s) const {
        const bool finite = std::isfinite(Eigen::Map<const Eigen::Matrix<R, 36, 1>>(s.P).sum()); // P, C and N
        return !s.started || (finite && is_plausible(s.x, s.bias));
    }
    void normalise(State& s) const { restore_length(s.x); }
    void flow(const State& s, const R* x, R* dx) const { Place::derivative(s.started, turn_rate(s), x, dx); }
    // df/dx along a direction
    void flow_along(const State& s, const R* x, const R* direction, R* out) const {
        Place::along(s.started, turn_rate(s), x, direction, out);
    }
    static constexpr bool has_closed_form = true;
    void flow_exactly(State& s, double interval_s) const { Place::exactly(turn_rate(s), R(interval_s), s.x); }
    static constexpr int read = Place::A; // the attitude
    static constexpr bool bounds_rate = true;
    double fastest_rate(const State& s) const { return turn_rate(s).norm(); }

    // The noise of a turn cannot be undone for another rate: no hold after the fact.
    static constexpr bool turns_back = false;
    static constexpr std::uint64_t bursts = fifo_channels;
    static constexpr bool reholds = false;
    // Factor on the usual change of the rate: a gap may fall into the fastest part of a turn.
    static constexpr R gap_turn_factor = R(2.5);

    void before_flow(State& s, const Event& event) const {
        if (!holds_backward(options_)) return;
        examine(s, event);
        if (s.has(event, gyro)) hold(s, event);
    }
    void jump(State& s, const Event& event) const; // jump.cpp

    // outputs.cpp
    Quaternion attitude(const State& s) const { return QuaternionR(s.x).normalized().cast<double>(); } // of the estimate
    Estimate estimate(const State& s) const;
    // Variance of the rotation about an axis for an estimate that is shown silence_s after the newest event.
    R silence_variance(const State& s, double silence_s) const {
        return s.rate_change.silence_variance(silence_s, s.spacing_s, gap_turn_factor);
    }
    ErrorCovariance error_covariance(const State& s) const { return covariance(s).cast<double>(); }
    Vector3Of<R> hold_error(const State&) const { return Vector3Of<R>::Zero(); } // the option gyro_hold is exact
    Matrix3 rotation_covariance(const State& s) const { return covariance(s).topLeftCorner<3, 3>().cast<double>(); }
    Vector3 rotation_variances(const State& s) const { return rotation_covariance(s).diagonal(); }
    Vector3 bias_variances(const State& s) const { return bias_covariance(s).diagonal().cast<double>(); }
    double bias_walk(const State& s) const { return std::sqrt(walk_level(s)); } // of the walk in use, adapted or not
    double decay_rate(const State& s) const; // decay_rate.cpp
    FieldEstimate field_estimate(const State& s) const;
    void gyro_calibration(const State&, double* S, double* sigma) const { // not estimated
        for (int i = 0; i < 9; ++i) S[i] = sigma[i] = 0;
    }

private:
    using Vector3R = Vector3Of<R>;
    using Matrix3R = Matrix3Of<R>;
    using QuaternionR = QuaternionOf<R>;

    static void put_q(State& s, const QuaternionR& q) { Eigen::Map<QuaternionR>(s.x) = q; }

    void hold(State& s, const Event& event) const {
        const Vector3R read = vector_of<R>(event, gyro);
        const R T = R(event.t_s - s.last_s[gyro]);
        const bool follows = s.has_rate && T > 0;
        const Vector3R rate = follows ? mean_between<R>(hold_of(options_), Vector3R(s.read_rate), read) : read;
        Eigen::Map<Vector3R>(s.read_rate) = read;
        if (follows && !is_gap(T, s.spacing_s)) s.rate_change.note(rate - Vector3R(s.rate), T);
        Eigen::Map<Vector3R>(s.rate) = rate;
        s.has_rate = 1;
    }

    // Before the first gyro sample the rate is 0.
    static Vector3R turn_rate(const State& s) {
        if (!s.has_rate) return Vector3R::Zero();
        return Vector3R(s.rate) - Vector3R(s.bias);
    }

    void take_turn(State& s) const; // bias_walk.cpp
    bool walks_evenly() const { return law_.adaptation.mode != Adaptation::paper; } // the walk of the bias is a multiple of I
    static R walk_level(const State& s) { return (s.bias_psd[0] + s.bias_psd[3] + s.bias_psd[5]) / 3; }
    Matrix3R walk_shape(const State& s) const {
        const R level = walk_level(s);
        return walks_evenly() || !(level > 0) ? Matrix3R(Matrix3R::Identity()) : Matrix3R(unpack<3>(s.bias_psd) / level);
    }

    // covariance.cpp
    Covariance covariance(const State& s) const;
    Matrix3R bias_covariance(const State& s) const { // it stands last in the triangle
        return unpack<3>(s.P + 15) + s.x[Place::t] * unpack<3>(s.bias_psd);
    }
    R length_variance(const State& s) const { return density_.quaternion_psd * s.x[Place::t]; }

    // recovery.cpp
    void examine(State& s, const Event& event) const;
    void lose_rate(State& s, double t_s) const;
    void widen(State& s, const Matrix3R& rotation_covariance) const;
    void widen_for_gap(State& s, const Event& event) const;
    bool is_lost(State& s, const Event& event) const;
    void lose_attitude(State& s) const;
    static void note_contradiction(State& s, R interval_s);

    // start.cpp
    void begin_bias(State& s) const;
    void put_covariance(State& s, R sigma_heading, const Matrix3R& of_bias) const;
    void forget_attitude(State& s) const;
    void collect_for_start(State& s, const Event& event) const;
    static void put_reference(State& s, const ReferenceFieldOf<R>& reference);
    static void learn(State& s, const QuaternionR& q, const Vector3R& field_b);

    // The interval that a sample stands for. A gap cannot be distinguished from a slow sensor; the limit bounds both.
    R interval(const State& s, int channel, double t_s) const {
        return R(interval_of_sample(t_s - s.last_s[channel], 0, options_.max_interval_s));
    }

    // correct_directions.cpp, correct_heading.cpp
    void correct_directions(State& s, const Event& event) const;
    void judge(State& s, double t_s, const HrekfDirection& d, const HrekfCorrection& correction, HrekfRows& rows) const;
    void correct_by(State& s, double t_s, const HrekfDirection* directions, int count) const;
    void correct_heading(State& s, const Event& event) const;

    bool tilt_ready(const State& s, const Vector3R& variances) const {
        return angle_ready(tilt_variance<R>(variances), s.information.tilt, R(options_.ready_tilt_rad));
    }
    bool heading_ready(const State& s, const Vector3R& variances) const {
        return angle_ready(variances[2], s.information.heading, R(options_.ready_heading_rad));
    }

    // A gate depends on the estimate, so it is used only when the angle that its sensor observes is ready.
    bool gate_works(const State& s, int channel, const Vector3R& variances) const {
        return tilt_ready(s, variances) && (channel == accel || heading_ready(s, variances));
    }

    R gate_nis(int channel) const { return R(gates_.nis[channel]); }

    // The options, and values derived from them at creation.
    Options options_;
    HrekfDensities density_;
    HrekfLaw law_;
    HrekfGates gates_;
    StartSettings<R> start_;
    CheckLimits<R> limits_;
};

} // namespace hnav
