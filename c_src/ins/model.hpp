// Inertial navigation: position, velocity and attitude from rate, force and aids. The initial heading may be unknown; it is estimated
// from motion or from the Earth rate.
//
// Between events d, v, q flow in Earth-fixed axes t (state.hpp), so there is no transport rate, and poles and date line are
// places like any other:
//     d' = v,   v' = R f + g(d) - 2 W x v,   q' = 1/2 q (0, w) - 1/2 (0, W) q
// The flow carries no covariance: samples gather how errors grow (Window), and a few times a second the covariance follows.
//
// Unknown heading. At the start the heading is uniform on the circle. All vectors are then held in t turned about the vertical by
// -alpha, and u = (cos alpha, sin alpha) are two states. GNSS, the Earth rate and the magnetic field are linear in u, so no heading is
// guessed and nothing is linearised about a wrong one. The posterior of alpha on the circle (circle.hpp) has all modes. When it is
// narrow, the filter is conditioned on its mode (collapse) and becomes a usual error-state filter. Scherzinger 1996 and Rogers 1997
// use such states for large heading errors.
//
// The functions are defined in the files named beside them.
#pragma once

#include "base/instant.hpp"
#include "ins/measurement.hpp"
#include "ins/state.hpp"
#include "ins/step.hpp"

#include <cstddef>

namespace hnav::ins {

constexpr double usual_colour = 3; // usual largest slow GNSS error, in sigmas
constexpr double usual_bias = 8; // of Consistency::bias; exceeded with probability 2e-5 (chi-square of three / 3)

// Factor on the variance of a correction with an error that lasts: those within that time have the weight of one.
inline double as_one(const State& s, double lasts_s) { return std::fmax(1, lasts_s / s.window.length_s); }

// Motion at one time, in north-east-down axes at the place.
struct Motion {
    earth::Place place;
    Vector3 velocity_n;
    Quaternion q_nb;
    Vector3 position_e, velocity_e;
};
// Bounds that errors exceed for less than 1e-3 of the time.
struct Protection {
    double horizontal_m, vertical_m, heading_rad;
};
// lie: factor on the sigmas, from the innovations; slow_m: horizontal and vertical excess of the slow GNSS error over its usual size.
Protection protection_of(const Vector3& sigma_position, double sigma_heading, double lie, const double* slow_m);

struct Navigation : Motion {
    Vector3 sigma_position, sigma_velocity, sigma_rotation;
    Circle circle;
    bool tilt_ready, heading_ready, velocity_ready, position_ready;
    Protection protection;
};

// Derivative of a motion along a direction of x.
struct MotionAlong {
    earth::Place place;
    Vector3 velocity_n, euler;
    Quaternion q_nb;
};

// anchor.cpp: expresses the vectors of the state, and rows of its covariance, in axes turned by C.
void turn(State& s, const Matrix3& C);
void turn(Covariance& P, const Matrix3& C);
// field_memory.cpp: turns the remembered field when the attitude estimate turns by C.
void turn_field(State& s, const Matrix3& C);
// From t axes to Earth-fixed axes, by the likeliest heading.
Matrix3 to_earth_axes(const State& s);
// force.cpp
Vector3 shown_force(const State& s); // in body axes
Vector3 moving_force(const State& s, const Vector3& raw, double over_s);
double false_force2(const State& s, const Matrix3& body_to_t);
void note_mean_force(State& s, const Vector3& force, double interval_s);
void note_acceleration(State& s, const Vector3& acceleration, double interval_s);
// What a late velocity misses, in t; taken_back_per_s: share of an error of the velocity that corrections take back in a second.
struct Missed {
    Vector3 acceleration; // of the motion
    Vector3 noise; // velocity that noise has added
};
Missed missed_of(const State& s, double taken_back_per_s);
// Adds an error to the state.
void add_error(const double* error, State& s);
// The motion of a state; to_earth: from t to Earth-fixed axes. Returns the rotation from t to north-east-down at the place.
Matrix3 show_motion(const State& s, const Matrix3& to_earth, Motion* motion);
// The same with the likeliest heading.
Motion motion_of(const State& s);
MotionAlong motion_along(const State& s, const double* direction);
// Sigmas of a vector with covariance P, in the axes that to_axes turns to.
Vector3 sigmas_along(const Matrix3& to_axes, const Matrix3& P);

// With what the body sets where it is not given.
inline Options with_body(Options options) {
    constexpr double car_across_m_s = 0.1; // tyres on a road, as in the simulated and recorded drives (./run study ins --wheels)
    if (options.body == HNAV_BODY_CAR && !(options.car_across_m_s > 0)) options.car_across_m_s = car_across_m_s;
    return options;
}

class Model {
public:
    static constexpr int nx = ins::nx;
    using Event = ins::Event;
    using State = ins::State;
    static constexpr std::size_t seldom_begin = offsetof(State, P),
                                 seldom_bytes = offsetof(State, seldom_changes) - offsetof(State, P);
    static std::uint64_t seldom_changes(const State& s) { return s.seldom_changes; }

    Model() = default;
    explicit Model(const Options& options) : options_(with_body(options)) {}
    const Options& options() const { return options_; }
    // A given state and a given place are those of the first start. After a loss the body is elsewhere.
    bool has_given_state(const State& s) const { return state_given(options_) && s.times_lost == 0; }
    bool has_given_place(const State& s) const { return place_given(options_) && s.times_lost == 0; }
    // Where each correction is recorded; null: it is not.
    void record_corrections(Step* step) { step_ = step; }
    // The state does not step: nothing is looked for in innovations.
    void expect_no_steps() { expects_steps_ = false; }

    // start.cpp
    void begin(State& s) const;
    // The start of a second pass at the time of s, linearised about `later`, the smoothed state integrated back to that time.
    // known_s: how long after it that was.
    State once_more(State s, const State& later, double known_s) const;

    // mechanisation.cpp
    bool flows(const State& s) const { return s.started() && !s.gap_too_long; }
    bool plausible(const State& s) const;
    void normalise(State& s) const;
    void nominal(double* x) const;
    void flow(const State& s, const double* x, double* dx) const;
    void flow_along(const State& s, const double* x, const double* direction, double* out) const; // df/dx along a direction
    static constexpr bool has_closed_form = true;
    void flow_exactly(State& s, double interval_s) const; // may be negative: backwards under the same inputs
    void before_flow(State& s, const Event& event) const;
    static constexpr bool reholds = true;
    void rehold(State& s, const Event& event, double interval_s) const;
    // Two fixes of one time come from two receivers, not from a FIFO.
    static constexpr std::uint64_t bursts = 1u << imu | 1u << field;
    static constexpr bool turns_back = false, bounds_rate = false; // the step is controlled: forces count as much as rates

    // jump.cpp
    void jump(State& s, const Event& event) const;

    // outputs.cpp. ahead_s: time from the last event to the time of the state.
    Navigation navigation(const State& s, double ahead_s, double now_s) const;
    Covariance covariance_at(const State& s, double ahead_s) const;
    bool at_rest(const State& s, double now_s) const; // correct_rest.cpp

private:
    // outputs.cpp
    void put_readiness(const State& s, double now_s, Navigation* n) const;

    // examine.cpp
    void examine(State& s, const Event& event) const;
    bool moves(const State& s) const;
    static void note_stale(State& s, const Event& event, bool elsewhere);
    bool is_elsewhere(const State& s, const Event& event) const;
    void widen_after_clock_jump(State& s) const;

    // jump.cpp
    void cross(State& s, const Event& event) const;
    void note(State& s, const Event& event) const;
    void try_start(State& s, const Event& event) const;

    // mechanisation.cpp
    void hold(State& s, const Event& event) const;
    static void put_gravity(State& s);

    // covariance.cpp
    void gather(State& s, double interval_s) const;
    // Returns the share of the tilt error that turn_tilt keeps.
    double propagate(const State& s, Covariance& P, double* mean) const;
    void note_prediction(const State& s, const Covariance& P, double tilt_kept) const;
    double force_psd(const State& s) const;
    double turn_variance(const State& s) const;
    void add_noise(const State& s, Covariance& P) const;
    // Slow GNSS error: its sigma in m from the stated sigma of a fix; and for north, east, down the share kept and the variance added
    // over an interval.
    double slow_sigma(double stated_m, bool vertical) const;
    void note_stated(State& s, const Event& event) const;
    struct Colour {
        double kept[3], grown[3];
    };
    Colour colour_of(const State& s, const double* mean) const;

    // start.cpp
    void level(State& s, const Event& event) const;
    void level_by_velocity(State& s, const Event& event) const;
    struct Tilt {
        Vector3 down_b = Vector3(0, 0, 1); // the vertical in present body axes
        Matrix3 variance_b = Matrix3::Zero(); // of down_b, from the motion within the window
        bool by_velocity = false;
        double noise = 1; // variance of the velocities over the stated one
    };
    double levelling_variance(const State& s, double window_s, double noise) const;
    Tilt tilt_by_velocity(const State& s, double now_s) const;
    bool find_tilt(const State& s, double now_s, Tilt* tilt) const;
    void start(State& s, const Event& event, const Tilt& tilt) const;
    double start_velocity_sigma(const State& s, int axis) const;
    void put_place(const State& s, Covariance& P, const double* sigma_m, double wide_m) const;
    void put_sensors(const State& s, Covariance& P) const;
    void put_at_antenna(State& s, Covariance& P) const;
    Covariance prior(const State& s) const;
    void start_covariance(State& s, const Vector3& first_sigma, const Tilt& found) const;
    void anchor(State& s, const earth::Place& place) const;
    void begin_levelling(State& s) const;

    // any_heading.cpp
    void centre(State& s, Covariance& P, bool look_at_circle) const;
    Covariance given_circle(const State& s, Covariance P) const;
    void collapse(State& s, Covariance& P) const;
    void restart_heading(State& s, Covariance& P, const Event& event) const;
    bool is_likely(const State& s, double off_m_s, double sigma_m_s, double since_s) const;
    bool velocity_fits(State& s, const Event& event) const;
    bool position_jumped(State& s, const Event& event) const;
    // Largest variances of the axes. While the heading is unknown, those of velocity and position are conditional on it.
    struct Spread {
        double heading, tilt, velocity, position;
    };
    Spread spread(const State& s, const Covariance& P) const;
    void take_free(State& s, const Matrix3& gyro_before, Covariance& P, const Measurement& m, double* error) const;
    void weigh_heading(State& s, Covariance& P, double alpha_rad, double variance, double share) const;
    double nis_given_heading(const State& s, const Covariance& P, const Measurement& m) const;
    double gate_of(const Measurement& m) const;
    void gate_given_heading(const State& s, const Covariance& P, Measurement& m) const;

    // anchor.cpp
    void move_anchor(State& s, Covariance& P) const;

    // correct.cpp
    void correct(State& s, const Event& event) const;
    void use(State& s, Covariance& P, const Event& event, const Measurement& m) const;
    void widen(Covariance& P, int row, double variance) const;
    static void note_gain(State& s, int channel, const Spread& before, const Spread& after);
    void admit_drift(State& s, Covariance& P) const;
    void admit_learnt_noise(State& s, Covariance& P) const;
    void note_small_heading(State& s, const Covariance& P, double now_s) const;
    static bool first_were_wrong(const State& s, int channel, double now_s);
    bool outlasts(const State& s, int channel, double off_m, double now_s) const;
    double misfit(const State& s, double now_s) const;
    void enlarge(Covariance& P, int row, double factor, double largest) const;
    void inflate_inconsistent(State& s, Covariance& P, double now_s) const;
    bool recovers(const State& s) const;
    void accept_jump(State& s, Covariance& P, int channel, double off, double now_s) const;
    void use_absolute(State& s, Covariance& P, const Event& event, Measurement& m) const;
    void apply(State& s, Covariance& P, const double* error) const;
    void restart_if_wrong(State& s, double now_s) const;
    void restart(State& s, double now_s) const;
    bool is_sound(const State& s, const Covariance& P) const;

    // steps.cpp
    static void begin_steps(State& s, Covariance& P, int window, double now_s);
    static void note_steps(State& s, const Measurement& m, const Correction& c);
    void take_steps(State& s, Covariance& P, int window, const Steps<may_step>& found, double now_s) const;
    void admit_steps(State& s, Covariance& P, double now_s) const;

    // correct_NAME.cpp; velocity and position are both in correct_satellites.cpp
    void correct_rest(State& s, Covariance& P, const Event& event) const;
    bool turns_on_the_spot(const State& s, const Covariance& P) const;
    static void note_false_turn(State& s);
    void hold_velocity(State& s, Covariance& P, const Event& event, bool stated) const;
    void hold_heading(State& s, Covariance& P, const Event& event) const;
    void look_for_glide(State& s, Covariance& P, double now_s) const;
    static void note_slow(State& s, double now_s);
    void admit_departure(State& s, Covariance& P) const;
    void correct_speed(State& s, Covariance& P, const Event& event) const;
    void correct_car(State& s, Covariance& P, const Event& event) const;
    void correct_pressure(State& s, Covariance& P, const Event& event) const;
    void correct_velocity(State& s, Covariance& P, const Event& event) const;
    void correct_position(State& s, Covariance& P, const Event& event) const;
    struct North {
        Matrix3 axes; // north, east and down in Earth-fixed axes
        double sigma_rad; // about down
    };
    North north_of(const State& s, const Covariance& P, const Event& event) const;
    void correct_heading(State& s, Covariance& P, const Event& event) const;
    void correct_field(State& s, Covariance& P, const Event& event) const;
    bool wants_field(const State& s, const Event& event) const;
    void begin_field(State& s, Covariance& P, const Event& event) const;
    void forget_field(State& s, Covariance& P) const;
    void accept_other_iron(State& s, Covariance& P, double now_s) const;
    bool leaves_out_field(State& s, const Covariance& P, const Event& event) const;
    double direction_kept(const State& s) const;
    void spoil_field(const State& s, Covariance& P, double* mean) const;

    // field_memory.cpp
    bool remembers_field(State& s, const Covariance& P, const Event& event) const;
    double nis_of_change(const State& s, const Covariance& P, const Vector3& measured, double age_s) const;

    Options options_{};
    Step* step_ = nullptr;
    bool expects_steps_ = true; // of the state: steps.cpp
};

// Rate and force of the present interval: the held sample without bias and error of the axes, with coning and sculling.
// Gyroscopes measure (1 + E) rate + bias.
inline Vector3 turn_rate(const State& s) {
    const Vector3 rate = vec(s.held.rate) - vec(s.gyro_bias);
    return rate - mat(s.gyro_axes) * rate + vec(s.held.coning);
}
inline Vector3 specific_force(const State& s) { return vec(s.held.force) - vec(s.accel_bias) + vec(s.held.sculling); }
inline Matrix3 attitude(const State& s) { return rotation_matrix(quat(s.x + 6)); }
// Factor on the GNSS variance when the mean NIS exceeds its statistical range.
inline double widened(const State& s) {
    constexpr double by_chance = 1.3;
    return std::fmax(1, s.nis_mean / by_chance);
}
// The larger variance of two horizontal rows, beginning with this one.
inline double larger_variance(const State& s, int row) { return std::fmax(s.P[packed(row, row)], s.P[packed(row + 1, row + 1)]); }
// Whether the estimated noise of an aid is much larger than its stated noise.
inline bool is_learnt(const State& s, int channel) {
    constexpr double gross = 4; // of variances: chosen
    return s.fit(channel).noise > gross;
}
// Whether the measurement determines the whole velocity or position.
inline bool is_absolute(const Measurement& m) {
    return m.channel == position || m.channel == velocity || (m.channel == rest && m.rows == 3);
}
inline bool is_free(const State& s) { return s.phase == Phase::any_heading; }
Vector3 displacement(const State& s); // from the anchor, without the lag that it has while the heading is searched
// The estimated one.
inline earth::Place place_of(const State& s) { return earth::place_of(vec(s.anchor_e) + mat(s.axes) * vec(s.x)); }
// Whether the last correction used a fix: monitors of fixes act once for each of them, at the event after it.
inline bool has_judged(const State& s) {
    return std::fmax(s.fit(velocity).last_s, s.fit(position).last_s) >= s.last_correction_s;
}
inline bool has_new(const State& s, const Event& event, int channel) {
    return s.has(event, channel) && !(event.t_s <= s.last_s[channel]);
}

} // namespace hnav::ins
