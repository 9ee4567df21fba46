// The AHRS: an error-state filter for off-the-shelf gyroscopes, accelerometers and magnetometers.
//
// States: attitude q, gyro bias b, gyro calibration S (scale and misalignment), horizontal velocity v, bias and
// latency of the accelerometer, the reference field M = (H, 0, Z) in units of its strength, its declination d at the present
// place, and the latency l of the magnetometer. Rate u = y - b - S y, and coning.
// The error is defined in navigation axes, q_true = exp(theta / 2) q, where its transition has a closed form:
//     theta' = -R_bn (db + dS y) + noise     =>  theta(T) = theta - G db - L dS,  G = int R_bn, L = int R_bn (x) y'
//     dv'    = g (-theta_E, theta_N)             (gravity, not the measured force, decouples tilt from heading)
// So the flow carries x = (q, G, clock) and not the covariance: at any time
//     P(T) = Phi(G, L, T) P Phi' + Q(T),   Q_theta = int (n_g^2 + k^2 |u|^2) dt.
//
// Samples are gathered in navigation axes at their own times. A few dozen times a second they correct the estimate:
//   velocity   0 = v + noise: the velocity of a body is bounded, which makes the tilt observable
//   rest       mean rate = b
//   field      M against the mean field: azimuth, horizontal and vertical intensity. Tilt, velocity and gyro calibration
//              are consider states: no magnet may tilt the horizon
//   heading    a heading aid; other aids likewise
// The noise of motion and place is estimated: motion_noise.hpp, field_noise.hpp. Choice of the reference field:
// reference_field.hpp. Until the horizon is ready its covariance is inflated by the robust
// law (robust_law.hpp), gamma finite; after that gamma is infinite.
//
// Accelerometer as bounded velocity: Laidig and Seel, Information Fusion 91, 2023, section 3; consider states: Schmidt 1966;
// earth-frame error: Sola, arXiv 1711.02508, section 7.
//
// The members are defined in the files named beside them.
#pragma once

#include "attitude/ahrs/state.hpp"
#include "base/instant.hpp"
#include "maths/earth.hpp"
#include "maths/scalar.hpp"
#include "maths/square.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace hnav {

class AhrsModel : public AhrsErrors {
public:
    using R = Scalar;
    static constexpr int nx = AttitudeFlow<R>::nx;
    static constexpr double gravity_m_s2 = earth::standard_gravity_m_s2;
    using Options = hnav_ahrs_options;
    static constexpr int sensors = channel_count; // those that it takes, in the order of Channel
    using Event = AttitudeEvent;
    using Flow = AttitudeFlow<R>;
    using State = AhrsState;
    using Sigmas = AhrsSigmas;
    static constexpr std::size_t seldom_begin = offsetof(State, P), seldom_bytes = offsetof(State, velocity) - seldom_begin;
    static std::uint64_t seldom_changes(const State& s) { return s.seldom_changes; }
    using Covariance = Square<errors, R>;
    using Vector = Eigen::Matrix<R, errors, 1>;

    AhrsModel() : AhrsModel(Options{}) {}
    explicit AhrsModel(const Options& options, const Frames& frames = {})
        : options_(options),
          density_(options),
          sigma_(sigmas_of(options)),
          robust_(options),
          start_(options, frames, options.start_field_wait_s),
          limits_(options, R(options.mag_range_tesla)),
          place_(options) {}

    // start.cpp
    void begin(State& s) const; // the state before any sample
    // Waits for a new start. Estimated sensor errors are kept: bias, calibration, latency.
    void realign(State& s) const;
    // To be called after a change of the rate, its coning, or the estimated gyro errors.
    static void note_turning(State& s) { Eigen::Map<Vector3R>(s.turning) = rate(s) + Vector3R(s.coning); }
    // Reverses time; the next sample is at t_s. Rates change sign, and with them bias, latency and velocity.
    static constexpr bool turns_back = true;
    static constexpr std::uint64_t bursts = fifo_channels;
    void turn_back(State& s, double t_s) const;

    // flow.cpp
    bool flows(const State& s) const { return s.started != 0 && !s.gap_too_long; }
    bool plausible(const State& s) const { return !s.started || is_plausible(s.x, s.bias); }
    void normalise(State& s) const { restore_length(s.x); }
    // Sizes of the states that absolute tolerances are relative to.
    void nominal(R* x) const {
        std::fill(x, x + Flow::A, R(1));
        std::fill(x + Flow::A, x + nx, R(options_.correction_interval_s));
    }
    void flow(const State& s, const R* x, R* dx) const { Flow::derivative(s.started, turn_rate(s), x, dx); }
    // df/dx along a direction
    void flow_along(const State& s, const R* x, const R* direction, R* out) const {
        Flow::along(s.started, turn_rate(s), x, direction, out);
    }
    static constexpr bool has_closed_form = true;
    // interval_s may be negative: backwards under the same rate.
    void flow_exactly(State& s, double interval_s) const { Flow::exactly(turn_rate(s), R(interval_s), s.x); }
    static constexpr int read = 4; // q; its integral and the clock do not affect the outputs
    static constexpr bool bounds_rate = true;
    double fastest_rate(const State& s) const { return turn_rate(s).norm(); }
    static constexpr bool reholds = true;
    void before_flow(State& s, const Event& event) const;
    // For a state that an external integrator has propagated over T seconds under the previous rate: replaces that rate by the rate of
    // the event, and keeps the error of the integrator.
    void rehold(State& s, const Event& event, double T) const;

    // jump.cpp
    void jump(State& s, const Event& event) const;

    // outputs.cpp
    Quaternion attitude(const State& s) const; // of the estimate
    Estimate estimate(const State& s) const;
    Matrix3 rotation_covariance(const State& s) const;
    Vector3 rotation_variances(const State& s) const; // its diagonal
    Vector3 bias_variances(const State& s) const;
    // Variance of the rotation about an axis for an estimate that is shown silence_s after the newest event.
    R silence_variance(const State& s, double silence_s) const {
        return s.rate_change.silence_variance(silence_s, s.spacing_s[gyro], R(options_.gap_turn_factor));
    }
    ErrorCovariance error_covariance(const State& s) const; // of rotation and bias at the time of x
    // The part of it due to a possibly wrong option gyro_hold, as one standard deviation with its direction.
    Vector3Of<R> hold_error(const State& s) const;
    double bias_walk(const State&) const { return std::sqrt(density_.bias_walk_psd); }
    // Not computed: corrections have consider states, and the reference field may change in between.
    double decay_rate(const State&) const { return 0; }
    FieldEstimate field_estimate(const State& s) const;
    // Scale and misalignment S of the gyroscope, row-major, and the sigma of each.
    void gyro_calibration(const State& s, double* S, double* sigma) const;

private:
    using Vector2R = Eigen::Matrix<R, 2, 1>;
    using Vector3R = Vector3Of<R>;
    using Matrix2R = Square<2, R>;
    using Matrix3R = Matrix3Of<R>;
    using Matrix39R = Eigen::Matrix<R, 3, 9, Eigen::RowMajor>;
    using QuaternionR = QuaternionOf<R>;
    static constexpr int step_parts = BiasSteps<R, responding>::parts;
    template <int m>
    using Response = Eigen::Matrix<R, m, step_parts>; // of m rows of errors or of a sensor
    using StepResponse = Response<responding>;
    using Evidence = typename BiasSteps<R, responding>::Evidence;

    // Working memory of the corrections of one instant.
    struct Correction {
        Covariance P; // after the first correction only its upper triangle is valid
        Vector error = Vector::Zero(); // estimated error, applied to the state after all corrections
        bool sound = true; // no correction has found an indefinite covariance
        // To steps of the gyro bias, and to iron; of the errors from the rotation on, and of the velocity.
        Eigen::Map<StepResponse> response;
        Eigen::Map<Response<2>> velocity_response;

        explicit Correction(State& s)
            : P(unpack_columns<errors>(s.P)), response(s.steps.response), velocity_response(s.steps.velocity_response) {}

        Vector column(int j) const {
            Vector c = P.col(j);
            for (int i = j + 1; i < errors; ++i) c[i] = P(j, i);
            return c;
        }
        template <int m>
        auto stepped(int row) const {
            return response.middleRows<m>(row - rotation);
        }
        R& heading_variance() { return P(rotation + 2, rotation + 2); }
        Vector3R rotation_variances() const { return diagonal<3>(P, rotation); }
    };

    // Before the first gyro sample the rate is 0.
    static Vector3R rate(const State& s) {
        if (!s.has_rate) return Vector3R::Zero();
        const Eigen::Map<const Eigen::Matrix<R, 3, 3, Eigen::RowMajor>> S(s.calibration);
        const Vector3R y(s.rate);
        return y - Vector3R(s.bias) - S * y;
    }
    static Vector3R turn_rate(const State& s) { return Vector3R(s.turning); }

    R interval(const State& s, int channel, double t_s) const {
        return R(interval_of_sample(t_s - s.last_s[channel], s.spacing_s[channel], options_.max_interval_s));
    }

    bool tilt_ready(const State& s) const {
        const R limit_rad = R(options_.ready_tilt_rad);
        const R added = s.tilt_excess.variance + unstated_tilt2(s) + hold_error(s).head<2>().cwiseAbs2().maxCoeff();
        return is_tilt_within(s, added, limit_rad) && s.vehicle_tilt.square() < limit_rad * limit_rad &&
               s.steps.suspected_tilt2 < limit_rad * limit_rad &&
               (s.speed.is_fresh() || !s.lasting.may_accelerate(R(gravity_m_s2)));
    }
    static R larger_tilt_variance(const State& s) {
        return std::fmax(s.P[packed(rotation, rotation)], s.P[packed(rotation + 1, rotation + 1)]);
    }
    // added: variance in addition to that of P, rad^2
    static bool is_tilt_within(const State& s, R added, R limit_rad) {
        return angle_ready(larger_tilt_variance(s) + added, s.information.tilt, limit_rad);
    }
    // Sigma of a horizon that is found: its covariance is no longer inflated. Not ready_tilt_rad, because the limit of a flag changes no
    // estimate. Chosen: at 1.5 deg the errors of simulated motions are 2 % larger.
    static constexpr R found_tilt_rad = R(2 * M_PI / 180);
    static bool is_tilt_found(const State& s) { return is_tilt_within(s, 0, found_tilt_rad); }

    static constexpr R suspected_hold = R(0.03); // prior probability that the option gyro_hold is wrong
    // A rate may as well be a reading of its instant, half an interval from the mean that it is taken for; in squared intervals. If force
    // and field are read likewise nothing shows it: everything is late or early by the same time.
    static constexpr R unstated_instant = R(0.5 * 0.25);
    // A field that replaced the reference and still contradicts the heading.
    static constexpr R lasting_s = 60;
    static constexpr R max_azimuth_rejected_s = 2; // beyond, the heading is not ready
    // A steady false field cannot be distinguished from a true one. Readiness therefore requires that the field was observed for a while,
    // from several directions or for longer, without contradiction for longer than most disturbances last.
    bool heading_ready(const State& s) const {
        if (s.heading_confirmed == 0 || has_passed(s.azimuth_rejected_s, max_azimuth_rejected_s)) return false;
        const R limit_rad = R(options_.ready_heading_rad);
        if (!(s.steps.suspected_heading2 < limit_rad * limit_rad)) return false;
        const R added = s.steps.heading_variance_by_iron() + reference_variance(s) + unstated_heading2(s, unstated_tilt2(s)) +
                        tilted_field_variance(s) + square(hold_error(s)[2]);
        return angle_ready(s.P[packed(rotation + 2, rotation + 2)] + added, s.information.heading, limit_rad);
    }
    // Variance of a heading from a field, whose horizontal part is found with a horizon of this variance.
    static R by_horizon(const State& s, R tilt2) {
        if (s.used[heading] > 0 || !s.has_reference) return 0;
        const R tangent = s.reference[1] / s.reference[0];
        return std::fmin(any_angle_variance<R>, tilt2 * tangent * tangent);
    }
    // With the horizon of a vehicle (vehicle_tilt.hpp).
    static R tilted_field_variance(const State& s) {
        return s.vehicle_tilt.is_possible() ? by_horizon(s, s.vehicle_tilt.square()) : 0;
    }
    // Of tilt and heading by an accelerometer that is worse than stated (lasting_motion.hpp).
    R unstated_tilt2(const State& s) const {
        return std::fmin(any_angle_variance<R>, s.lasting.unstated_tilt2(R(gravity_m_s2), sigma_.force_bias * sigma_.force_bias));
    }
    static R unstated_heading2(const State& s, R tilt2) { return tilt2 > 0 ? tilt2 + by_horizon(s, tilt2) : 0; }

    // Variance of the heading in addition to P: the reference may be false.
    R reference_variance(const State& s) const {
        const bool field_alone = !reference_given(options_) && s.used[heading] == 0;
        return std::fmin(any_angle_variance<R>, s.reference_variance + (field_alone ? implausible_azimuth2(s) : 0));
    }
    // The Earth's field has 22 to 67 uT. A reference outside this range, allowing for scale errors of usual magnetometers, contains a
    // disturbance of at least the difference, in an unknown direction.
    static R implausible_azimuth2(const State& s) {
        constexpr R weakest = R(20e-6), strongest = R(70e-6);
        const R H = s.strength * s.reference[0], B = s.strength * length(s.reference[0], s.reference[1]);
        const R false_part = std::fmax(weakest - B, B - strongest);
        return s.has_reference && false_part > 0 ? false_part * false_part / (H * H) : 0;
    }

    void hold(State& s, const Event& event) const; // flow.cpp

    // recovery.cpp
    void lose_rate(State& s, double t_s) const;
    void lose_attitude(State& s, Correction& c, R heading_sigma) const;
    void find_attitude(State& s, Correction& c) const;
    void begin_motion(State& s) const;
    bool level_again(State& s, Correction& c) const;
    static void turn_up(State& s, const Vector3R& up);
    void forget_rotation(State& s, Covariance& P, R tilt_variance, R heading_variance) const;
    static void widen_after_clock_jump(State& s);
    void pass_gap(State& s, double t_s) const;

    // start.cpp
    void forget_attitude(State& s) const;
    void start_covariance(State& s, const Sigmas& start) const;
    Sigmas start_sigmas(R sigma_heading) const;
    static void put_reference(State& s, const ReferenceFieldOf<R>& field);
    static void put_learnt_reference(State& s, const Vector3R& field_b);
    static void tie_heading_to_horizon(State& s);
    static void add_error(State& s, int from, R factor, int to);
    void start(State& s, const Event& event) const;
    static void turn_heading(State& s, R angle_rad);
    static void turn_errors(Correction& c, R angle_rad);
    void initialise_heading_by_field(State& s, const Vector3R& field_b) const;

    // outputs.cpp
    class RotationNow;
    R noise_now(const State& s) const;
    Vector3R added_variances(const State& s) const;
    Matrix3R rotation_covariance(const State& s, const RotationNow& now) const;

    // preintegration.cpp
    struct TurnedOn;
    static void forget_window(State& s);
    using Moment = decltype(State::rate_moment);
    static void add_turn(const State& s, Moment& moment);
    static void take_turn(State& s);
    void gather(State& s, const Event& event, R rate_s) const; // rate_s: the interval of the sample of rate, if there is one
    void gather_force(State& s, const Event& event, const Matrix3R& R_bn) const;
    void gather_field(State& s, const Event& event, const Matrix3R& R_bn) const;

    // Of the rotation about an axis by the gap before this event.
    R gap_variance(const State& s, const Event& event) const {
        if (!s.is_gap(gyro, event.t_s)) return 0;
        return s.rate_change.gap_variance(R(event.t_s - s.last_s[gyro]), s.has(event, gyro), R(options_.gap_turn_factor));
    }
    // int (n_g^2 + k^2 |u|^2) dt since the last correction, and what went by in gaps
    R rotation_noise(const State& s) const {
        return density_.gyro_psd * s.x[13] + density_.gyro_rate_psd * s.rate_power + s.gap_rotation;
    }

    // covariance.cpp
    struct Turned;
    void propagate(Covariance& P, const State& s) const;
    void forget_declination(State& s, Covariance& P) const;

    // correction.cpp
    void correct(State& s, const Event& event) const;
    void correct_by_force(State& s, Correction& c, double t_s, bool rests) const;
    void inflate_tilt(State& s, Covariance& P) const;
    void note_motion(State& s, Correction& c) const;
    static Eigen::Matrix<R, 2, 3> tilt_of_force_bias(const State& s);
    static R explained_force2(const State& s, const Correction& c);

    // admit_steps.cpp
    void begin_steps(State& s) const { s.steps.begin(bias - rotation, R(options_.residual_iron)); }
    void carry_response(State& s) const;
    void admit_steps(State& s, Correction& c) const;

    // condition.hpp
    template <int m>
    static Response<m> weighted(const Cholesky<m, R>& S, const Response<m>& stepped);
    template <int m, int first>
    static void condition(Correction& c, const Eigen::Matrix<R, errors, m>& PHt, const Square<m, R>& S,
                          const Eigen::Matrix<R, m, 1>& innovation, const Response<m>& stepped, Evidence* evidence = nullptr,
                          R withheld = 0);
    static void withhold(Correction& c, const Eigen::Matrix<R, errors, 2>& PHt, const Eigen::Matrix<R, 2, errors>& Kt,
                         const Vector2R& innovation, R share);
    template <int m, int first, int... after_first>
    static void take_out(Covariance& P, const Eigen::Matrix<R, errors, m>& PHt, const Eigen::Matrix<R, m, errors - first>& Kt,
                         std::integer_sequence<int, after_first...>);
    template <int m, int first, int j>
    static void take_out_of_column(Covariance& P, const Eigen::Matrix<R, errors, m>& PHt,
                                   const Eigen::Matrix<R, m, errors - first>& Kt);
    static void apply(State& s, const Vector& error);
    static void keep(State& s, Correction& c);

    // correct_velocity.cpp
    static InnovationOf<R>& record_velocity(InnovationOf<R>& i, double t_s, const Vector2R& innovation, const Matrix2R& S);
    static void condition_on_velocity(State& s, Correction& c, const Eigen::Matrix<R, errors, 2>& PHt, const Matrix2R& S,
                                      const Vector2R& innovation, R T, Evidence* evidence, R withheld = 0);
    void correct_velocity(State& s, Correction& c, double t_s, bool rests) const;
    static void note_hidden_step(State& s, const Correction& c, const Matrix2R& S, R hiding2, const Vector2R& innovation);
    static void forget_velocity(State& s, Correction& c, const Matrix2R& covariance);
    // A body is given whose velocities last: vehicles and walkers (body.hpp).
    bool is_given_to_travel() const { return density_.lasting_density2 > 0; }
    bool may_accelerate_long(const State& s) const { return s.vehicle_tilt.is_possible() || accelerates_long(options_.body); }
    bool is_at_rest(State& s, Correction& c) const; // correct_rest.cpp
    void admit_bias_at_rest(State& s, Correction& c, const Vector3R& from_bias) const;
    bool is_field_still(State& s) const;
    bool is_vehicle_at_rest(const State& s, bool rests) const;
    void note_vehicle(State& s, const Correction& c, bool rests) const;
    Matrix2R start_velocity_covariance() const { return sigma_.velocity * sigma_.velocity * Matrix2R::Identity(); }
    void travel(State& s, Correction& c) const;
    static void turn_velocity(State& s, const Vector3R& rotation_n);
    void correct_rest(State& s, Correction& c) const;

    // correct_heading.cpp, correct_speed.cpp
    void correct_heading(State& s, Correction& c, const Event& event) const;
    void correct_speed(State& s, Correction& c, const Event& event) const;
    static void begin_speed(State& s, Correction& c, const Matrix2R& noise);
    void follow_speed(State& s, Correction& c, double t_s, R since_s, const Vector2R& measured_n, const Matrix2R& noise) const;

    void judge_hold(State& s, R latency_variance) const; // correct_velocity.cpp

    // correct_field.cpp
    struct FieldRows;
    void correct_field(State& s, Correction& c, double t_s) const;
    void choose_reference(State& s, Correction& c, MeanField<R>& mean) const;
    void change_reference(State& s, Correction& c, MeanField<R>& mean) const;
    static void keep_unit(State& s, MeanField<R>& mean);
    static void forget_reference(Covariance& P, R sigma);
    static void forget_heading_far_off(Correction& c, const FieldRows& rows);
    bool take_foreign_field(State& s, Correction& c, const MeanField<R>& mean) const;
    void leave_foreign_field(State& s, Correction& c) const;
    static void note_rejected_field(State& s, const Matrix3R& S, const Response<3>& stepped, const Vector3R& innovation);
    void start_in_foreign_field(State& s) const;
    R azimuth_deviation(const State& s, const Correction& c, const FieldRows& rows) const;
    static void note_contradiction(State& s, FieldVerdict verdict, const FieldRows& rows);
    FieldVerdict judge_field(State& s, Correction& c, R deviation) const;
    Vector3R field_noise(const State& s) const;
    void learn_field_noise(State& s, Correction& c, const MeanField<R>& mean, const Vector3R& innovation,
                           const Vector3R& known) const;
    R noise_inflation(FieldVerdict verdict, R deviation) const;
    static void record_field(State& s, double t_s, const Vector3R& innovation, const Matrix3R& S, R inflation);
    void confirm_heading(State& s, FieldVerdict verdict, bool azimuth_is_far) const;

    // The options, and values derived from them at creation.
    Options options_;
    AhrsDensities density_;
    Sigmas sigma_;
    RobustSettings<R> robust_;
    StartSettings<R> start_;
    CheckLimits<R> limits_;
    GivenField<R> place_;
};

} // namespace hnav
