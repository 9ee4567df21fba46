// Rest: zero velocity, and no rotation.
#include "ins/model.hpp"
#include "maths/cholesky.hpp"
#include "maths/square.hpp"

namespace hnav::ins {

constexpr double slow_m_s = 0.3; // largest GNSS speed of a rest: three sigmas of a usual receiver
constexpr double silent_s = 60; // without velocities for so long, positions alone show motion

// Records the time since which all GNSS speeds have been small: after a departure a single one may look like rest again.
void Model::note_slow(State& s, double now_s) {
    constexpr double slowest_m_s = 0.6;
    if (!(s.speed_known_m_s < std::fmin(slowest_m_s, std::fmax(slow_m_s, 2 * s.speed_sigma_m_s)))) s.slow_since_s = nan;
    else if (std::isnan(s.slow_since_s)) s.slow_since_s = now_s;
}

// An IMU cannot distinguish rest from constant velocity, so the speed must be small too: the GNSS speed while it is fresh, otherwise
// the estimated speed while its sigma is small. A body with a given place and without aids is at rest, even if it sways, and so is one between
// stated rests. Those of a foot are instants: with each taken for two seconds its velocity was ready and wrong for 22 % of the time, now for 0.
bool Model::at_rest(const State& s, double now_s) const {
    constexpr double fresh_s = 2, known_m_s = 1;
    const bool alone = place_given(options_) && s.used[velocity] + s.used[position] + s.used[speed] == 0;
    if (alone || is_within(now_s - s.last_s[ins::rest], fresh_s)) return s.rest.sways(options_);
    if (!s.rest.still(options_) || s.glide.found > 0) return false;
    if (is_within(now_s - s.speed_known_s, fresh_s)) return has_lasted(now_s - s.slow_since_s, options_.rest_duration_s);
    if (!s.started()) return false;
    const double variance = larger_variance(s, row_v);
    return variance < known_m_s * known_m_s && vec(s.x + 3).head<2>().norm() < std::fmax(slow_m_s, 2 * std::sqrt(variance));
}

// While a slow glide or a gentle departure was taken for rest, velocity and position were wrongly held, and the acceleration was
// estimated as tilt. Widens these states by what was missed. Without GNSS velocities, positions that move away show the glide.
void Model::look_for_glide(State& s, Covariance& P, double now_s) const {
    constexpr double far = 5, departs_s = 5;
    if (s.glide.found > 0 || s.glide.rested == 0 || !s.rest.still(options_)) return;
    const double stood_s = now_s - s.glide.began_s, moved_m = (vec(s.in_t.colour) - vec(s.in_t.colour_at_rest)).head<2>().norm();
    const bool alone = !is_within(now_s - s.last_s[velocity], silent_s) && s.glide.jumped == 0;
    double speed = 0, way = 0, since_s = stood_s;
    if (s.glide.always.shows()) {
        speed = s.glide.always.speed_m_s();
        way = speed * stood_s;
    } else if (s.glide.recent.shows()) {
        speed = s.glide.recent.speed_m_s();
        since_s = std::fmin(departs_s, stood_s);
        way = speed * since_s;
    } else if (alone && moved_m > far * s.slow_m[0]) {
        speed = moved_m / stood_s;
        way = moved_m;
    } else {
        return;
    }
    s.glide.found = 1;
    const double tilt = speed / since_s / vec(s.gravity).norm();
    for (int i = 0; i < 2; ++i) {
        widen(P, row_phi + i, tilt * tilt);
        widen(P, row_v + i, speed * speed);
        widen(P, row_d + i, way * way);
        widen(P, row_colour + i, way * way);
    }
}

// A gentle departure looks like a tilt or a bias that changes: in the last seconds of what seemed a rest the velocity was not zero. What
// zero velocities have corrected within that time becomes uncertain. Without this the squared normalised tilt errors of trains are 1.5 to 3.6
// after a departure, by grade, instead of .5 to 1.2.
void Model::admit_departure(State& s, Covariance& P) const {
    for (int i = 0; i < row_axes; ++i) widen(P, i, square(s.by_rests[i]));
    s.forget_rests();
}

// The noise of a detected rest is that of a body that moves a little: its NIS stays below 1. A larger one is a gentle departure. With the gate
// of other aids the mean squared normalised error of the tilt of trains is 3.4 instead of 1, and one of 60 was ready 180 deg off.
double Model::gate_of(const Measurement& m) const {
    constexpr double departs_nis = 3;
    return m.assumed ? departs_nis : options_.gate_nis;
}

// A steady rate that the bias known so far cannot be is a turn: of a turntable, or of a robot on the spot. Taken for rest, the bias of
// consumer sensors followed it by 5 deg/s, and the tilt was ready and wrong for 10 % of the time, now for 0.
bool Model::turns_on_the_spot(const State& s, const Covariance& P) const {
    if (!s.rest.sways(options_)) return false;
    const Vector3 turn = vec(s.rest.mean_rate) - vec(s.gyro_bias);
    const double noise = square(options_.gyro_noise_rad_per_sqrt_s) + square(options_.rest_rate_noise_rad_per_sqrt_s);
    Matrix3 S = P.block(row_gyro, row_gyro);
    S.diagonal().array() += noise / Unrest::filter_s + s.rest.rate2 / 3 + s.rest.wander.density2() + square(earth::rate_rad_s);
    return normalised_square<3, double>(S, turn) > turn_nis;
}

void Model::correct_rest(State& s, Covariance& P, const Event& event) const {
    const bool turns = turns_on_the_spot(s, P);
    if (turns) s.rest.still_s = 0;
    look_for_glide(s, P, event.t_s);
    const bool stated = has_new(s, event, ins::rest), stood = at_rest(s, event.t_s);
    if (!stated && !stood) return admit_departure(s, P);
    s.glide.rested = 1;
    const bool is_steady = stood && !turns;
    if (is_steady) note_false_turn(s);
    hold_velocity(s, P, event, stated);
    if (is_steady) hold_heading(s, P, event);
}

// What the attitude turns by while the body stands is an error. A tilt and the bias that produces the same force stay indistinguishable, so that
// direction is kept as with corrections (turn_errors). Otherwise the errors of the gyroscope would seem to observe it: in ten minutes the
// tilt of consumer sensors was ready at a sigma of .6 deg and an error of 6.9, now 2.5 and 2.4. Steps that this event has admitted have turned the
// attitude already: they are within.
void Model::note_false_turn(State& s) {
    if (s.window.length_s > 0) vec(s.turned_b) = rotation_vector(multiply(conjugate(quat(s.window.began_q)), quat(s.x + 6)));
}

namespace {

// Variance of the velocity of a correction by rest where positions alone say that the body stands: what their noise and slow error leave open over
// the time of the rest. Without it a robot at .45 m/s was at rest for a fifth of the way, its velocity ready with a z2 of 250, now .4.
double speed_left_open2(const State& s, const Options& options, double now_s, double stood_s) {
    constexpr double fix_s = 10; // chosen: without a fix for so long, as in an outage, positions neither show nor refute a rest
    if (is_within(now_s - s.last_s[velocity], silent_s) || !is_within(now_s - s.last_s[position], fix_s)) return 0;
    const Consistency& fit = s.fit(position);
    const double change2 = fit.stated * fit.noise - square(s.slow_m[0]) * std::expm1(-stood_s / options.position_colour_s);
    return 2 * change2 / square(stood_s) * as_one(s, stood_s);
}

} // namespace

void Model::hold_velocity(State& s, Covariance& P, const Event& event, bool stated) const {
    constexpr double departs_s = 3; // until the speed of a gentle departure shows in the satellites: chosen
    Measurement still{ins::rest, 3};
    still.put(0, row_v, Matrix3::Identity());
    const double sigma = stated ? event.value[ins::rest][0] : options_.rest_velocity_noise_m_s;
    // A body that comes to rest moves slowly for a few more seconds.
    constexpr double creeps_m_s = 0.2, settles_s = 1;
    const double stood_s = s.rest.still(options_) ? s.rest.still_s : s.rest.swaying_s;
    // What the first seconds of a rest correct is the error of the motion before it.
    const double kept = stood_s > departs_s ? std::exp(-s.window.length_s / departs_s) : 0;
    for (double& by : s.by_rests) by *= kept;
    const double creep = stated ? 0 : creeps_m_s * std::exp((options_.rest_duration_s - stood_s) / settles_s);
    const double open2 = stated ? 0 : speed_left_open2(s, options_, event.t_s, stood_s);
    for (double& r : still.R) r = sigma * sigma + creep * creep + open2;
    still.assumed = !stated;
    vec(still.r) = -vec(s.x + 3);
    use_absolute(s, P, event, still);
}

// The mean rate about the vertical is the Earth rate plus a bias. The horizontal rates have corrected the biases through the tilt already, with
// the same noise.
void Model::hold_heading(State& s, Covariance& P, const Event& event) const {
    const double T = s.window.length_s;
    if (!(T > 0)) return;
    const Vector3 vertical_b = attitude(s).row(2).transpose();
    Measurement steady{ins::rest, 1};
    // The rotation of a body that stands is that of the Earth. Linearised at the measured one, errors of the biases would turn the tilt.
    steady.H[0][row_phi] = s.earth_rate[1];
    steady.H[0][row_phi + 1] = -s.earth_rate[0];
    for (int i = 0; i < 3; ++i) steady.H[0][row_gyro + i] = -vertical_b[i];
    // A swaying body rotates by the rate that the rest detector measured.
    steady.R[0] =
        (square(options_.gyro_noise_rad_per_sqrt_s) + square(options_.rest_rate_noise_rad_per_sqrt_s)) / T + s.rest.rate2 / 3;
    steady.r[0] = s.earth_rate[2] - vertical_b.dot(vec(s.window.rate_sum) / T - vec(s.gyro_bias));
    use(s, P, event, steady);
}

} // namespace hnav::ins
