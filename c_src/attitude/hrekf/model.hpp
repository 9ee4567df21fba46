// The paper's filter: hybrid extended Kalman filter (gamma infinite) and hybrid robust extended Kalman filter.
//
// States x = (q, b, P): attitude quaternion, gyro bias, upper triangle of their 7 x 7 covariance. With the held rate w
// and u = w - b the flow is
//     q' = Xi(q) u,   b' = 0,   P' = A P + P A' + L Qc L',
//     A = [Omega(u), -Xi(q); 0, 0],   L = [-Xi(q), 0; 0, I],   Qc = blkdiag(gyro noise, Q_b)
// and the jump at a sample
//     Sigma = inflate(P),  S = H Sigma H' + R,  K = Sigma H' S^-1,  x += K nu,
//     P+ = Sigma - K H Sigma   (equals the paper's (Sigma^-1 + H'R^-1 H)^-1)
// followed by the return of q to the unit sphere, of which the covariance learns too.
// Equations: Hybrid Robust Extended Kalman Filter for SINS initial alignment, TJEE 54(4), 2024,
// doi 10.22034/tjee.2023.57843.4683, with (9) to (17) corrected.
//
// The members are defined in the files named beside them, and compiled for one scalar (scalar.hpp) in the .cpp files here.
#pragma once

#include "attitude/hrekf/state.hpp"
#include "base/instant.hpp"
#include "maths/scalar.hpp"
#include "signals/sampling.hpp"

namespace hnav {

template <class R>
struct HrekfDirection; // correct_directions.hpp

template <class R>
class HrekfModelOf {
public:
    static constexpr int nx = hrekf_nx;
    static constexpr int sensors = heading + 1; // those that it takes, in the order of Channel
    using Event = AttitudeEvent;
    using State = HrekfState<R>;
    using Options = hnav_hrekf_options;
    using Covariance = Square<7, R>;
    using Vector7 = Eigen::Matrix<R, 7, 1>;

    HrekfModelOf() : HrekfModelOf(Options{}) {}
    explicit HrekfModelOf(const Options& options, const Frames& frames = {})
        : options_(options),
          density_(options),
          law_(options),
          gates_(options),
          start_(options, frames),
          limits_(options, R(options.mag_range_tesla)) {}

    // The state before any sample. start.hpp
    void begin(State& s) const;
    // Waits for a new start; bias, its covariance and the counters stay.
    void realign(State& s) const;

    // Sizes of the states that absolute tolerances are relative to: at the start, and from the sigmas that a state claims.
    void nominal(R* x) const;
    void nominal(const State& s, R* x) const;

    // flow.hpp, closed_form.hpp
    bool flows(const State& s) const { return s.started != 0; }
    bool plausible(const State& s) const { return !s.started || is_plausible(s.x, s.x + 4); }
    void normalise(State& s) const { restore_length(s.x); }
    void flow(const State& s, const R* x, R* dx) const;
    void flow_along(const State& s, const R* x, const R* direction, R* out) const; // df/dx along a direction
    static constexpr bool has_closed_form = true;
    void flow_exactly(State& s, double interval_s) const;
    static constexpr bool knows_rate = true;
    double fastest_rate(const State& s) const { return turn_rate(s, s.x).norm(); }

    // The covariance went through the flow too, and its way back is not stable: no hold after the fact.
    static constexpr bool turns_back = false;
    static constexpr bool reholds = false;
    // Of the usual change of the rate: a gap may fall into the fastest part of a turn.
    static constexpr R gap_turn_factor = R(2.5);

    void before_flow(State& s, const Event& event) const {
        if (!holds_backward(options_)) return;
        examine(s, event);
        if (s.has(event, gyro)) hold(s, event);
    }
    void jump(State& s, const Event& event) const; // jump.hpp

    // outputs.hpp
    Quaternion attitude(const State& s) const; // of the estimate
    Estimate estimate(const State& s) const;
    // Of the rotation about an axis, when the estimate is shown so long after the newest event.
    R silence_variance(const State& s, double silence_s) const {
        return s.rate_change.silence_variance(silence_s, s.spacing_s, gap_turn_factor);
    }
    ErrorCovariance error_covariance(const State& s) const;
    Vector3Of<R> hold_error(const State&) const { return Vector3Of<R>::Zero(); } // the hold is taken as told
    Matrix3 rotation_covariance(const State& s) const;
    Vector3 rotation_variances(const State& s) const { return rotation_covariance(s).diagonal(); }
    Vector3 bias_variances(const State& s) const;
    double bias_walk(const State& s) const; // root of the mean power of the bias walk in use, adapted or not
    double decay_rate(const State& s) const;
    FieldEstimate field_estimate(const State& s) const;
    void gyro_calibration(const State&, double* S, double* sigma) const; // not estimated: zero

private:
    using Vector3R = Vector3Of<R>;
    using Matrix3R = Matrix3Of<R>;
    using QuaternionR = QuaternionOf<R>;
    using Blocks = HrekfBlocks<R>;

    static void put_q(State& s, const QuaternionR& q) { Eigen::Map<QuaternionR>(s.x) = q; }

    static void hold(State& s, const Event& event) {
        const Vector3R rate = vector_of<R>(event, gyro);
        const R T = R(event.t_s - s.last_s[gyro]);
        if (s.has_rate && T > 0 && !is_gap(T, s.spacing_s)) s.rate_change.note(rate - Vector3R(s.rate), T);
        Eigen::Map<Vector3R>(s.rate) = rate;
        s.has_rate = 1;
    }

    // Before the first gyro sample the body is taken to be still.
    static Vector3R turn_rate(const State& s, const R* x) {
        if (!s.has_rate) return Vector3R::Zero();
        return {s.rate[0] - x[4], s.rate[1] - x[5], s.rate[2] - x[6]};
    }

    // recovery.hpp
    void examine(State& s, const Event& event) const;
    void lose_rate(State& s, double t_s) const;
    void widen(State& s, const Matrix3R& rotation_covariance) const;
    void widen_for_gap(State& s, const Event& event) const;
    bool is_lost(State& s, const Event& event) const;
    static void doubt_heading(State& s, R interval_s);

    // start.hpp
    void forget_attitude(State& s) const;
    void collect_for_start(State& s, const Event& event) const;
    static void put_reference(State& s, const ReferenceFieldOf<R>& reference);
    static void learn(State& s, const QuaternionR& q, const Vector3R& field_b);

    Square<4, R> attitude_noise(const QuaternionR& q) const; // flow.hpp

    // The interval that a sample stands for. No gap is told from a slow sensor: the limit bounds both.
    R interval(const State& s, int channel, double t_s) const {
        return R(interval_of_sample(t_s - s.last_s[channel], 0, options_.max_interval_s));
    }

    // correct_directions.hpp, correct_heading.hpp
    void correct_directions(State& s, const Event& event) const;
    template <int count>
    void correct_by(State& s, double t_s, const HrekfDirection<R> (&directions)[count]) const;
    const InnovationOf<R>& record(State& s, const HrekfDirection<R>& direction, double t_s, const Vector3R& nu,
                                  const Matrix3R& S) const;
    void correct_heading(State& s, const Event& event) const;

    // Gates rely on the estimate, so each waits until the angle that its sensor sees is ready.
    bool gate_works(const State& s, int channel) const {
        const Estimate e = estimate(s);
        return channel == accel ? e.tilt_ready : e.tilt_ready && e.heading_ready;
    }

    R gate_nis(int channel) const { return R(gates_.nis[channel]); }

    // The options, and what is made of them once.
    Options options_;
    HrekfDensities<R> density_;
    HrekfLaw<R> law_;
    HrekfGates gates_;
    StartSettings<R> start_;
    CheckLimits<R> limits_;
};

using HrekfModel = HrekfModelOf<double>;

} // namespace hnav
