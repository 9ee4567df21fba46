// The start: tilt from a few seconds of motion, no heading yet.
//
// The velocity integrated from the force in gyro-stabilised axes, compared with the GNSS velocity, determines the tilt of a body that
// accelerates and banks (optimisation-based alignment, Wu and Pan 2013). Its heading is not used: the filter estimates the heading
// itself, so that no information is used twice. Without velocities the tilt is that of the mean force.
#include "ins/circle.hpp"
#include "ins/model.hpp"

#include <Eigen/SVD>

namespace hnav::ins {
namespace {

constexpr double mean_force_tilt = 0.1; // rad, sigma of a tilt by the mean force of a vehicle
constexpr double given_place_m = 0.1; // sigma of a place that is given; chosen: users measure no better, and no variance is 0
constexpr double any_velocity_m_s = 90; // as the default of start_sigma_velocity_m_s: an aircraft, in any direction

// Means of cos, cos^2 and sin^2 of an angle with the density exp(strength cos angle) on the circle.
struct OnCircle {
    double cosine = 0, cosine2 = 0, sine2 = 0;

    explicit OnCircle(double strength) {
        constexpr int points = 64;
        const double half = std::fmin(M_PI, 8 / std::sqrt(strength + 1e-9)), step = 2 * half / points;
        double mass = 0;
        for (int k = 0; k < points; ++k) {
            const double angle = -half + (k + 0.5) * step, c = std::cos(angle), p = std::exp(strength * (c - 1));
            mass += p;
            cosine += p * c;
            cosine2 += p * c * c;
        }
        cosine /= mass;
        cosine2 /= mass;
        sine2 = 1 - cosine2;
    }
};

// In a longer window than this the unknown gyro bias rotates the axes by more than the stated sigma of the tilt.
bool wants_window(const Options& options, const Levelling& l, double now_s) {
    const double longest_s =
        std::fmax(2 * options.level_window_s, options.start_sigma_tilt_rad / options.start_sigma_gyro_bias_rad_s);
    return std::isnan(l.first_velocity_s) || (l.count >= 2 && has_passed(now_s - l.first_velocity_s, longest_s));
}

// Starts the window at this velocity.
void begin_window(State& s, const Event& event) {
    const Levelling before = s.levelling;
    Levelling& l = s.levelling;
    l = {};
    l.q[0] = 1;
    l.began_s = before.began_s;
    l.since_s = before.since_s;
    l.samples = before.samples;
    vec(l.force) = vec(before.force);
    l.takes_all = before.takes_all;
    l.first_velocity_s = l.fits_s = event.t_s;
    vec(l.velocity0) = vec(event.value[velocity]);
}

// Variance of the velocities over the stated one, by what the rotation leaves of them, whose sum of singular values this is (Wahba's loss).
// Without this law quadrotors would start with a tilt three sigmas off, beside receivers that state a quarter of their noise.
double noise_left(const Levelling& l, double singular_values) {
    const double freedom = 3 * l.count - 6; // without the rotation and the mean
    if (!(freedom > 0)) return 1;
    const double squares = l.sum_squares - (vec(l.sum_seen).squaredNorm() + vec(l.sum_gained).squaredNorm()) / l.count;
    const double left2 = squares - 2 * singular_values;
    const double noise = left2 / freedom * l.count / l.variance;
    // Less may be chance, and more is no noise: the velocities are false, and motion must refute what they start. Chosen: without the upper limit
    // cars whose receiver begins with zeros have their heading after 31 s in the median instead of 29.
    return noise > Consistency::at_once && noise < Consistency::largest ? noise : 1;
}

} // namespace

void Model::begin_levelling(State& s) const {
    s.levelling = {};
    s.levelling.q[0] = 1;
    s.levelling.began_s = s.levelling.since_s = s.levelling.first_velocity_s = nan;
    s.phase = std::isfinite(s.last_s[imu]) ? Phase::levelling : Phase::waiting;
    s.gates.begin();
    s.rest = {};
    s.forget_rests();
    s.heading_since_s = s.strained_since_s = nan;
    s.begin_monitors();
    s.contradiction.begin();
    s.strain = 1;
    for (int c = 0; c < channel_count; ++c) s.note_refusal(c, false, s.last_event_s);
    for (double& e : s.mean) e = 0;
}

void Model::begin(State& s) const {
    s = State{};
    s.x[6] = 1;
    for (int c = 0; c < channel_count; ++c) {
        s.last_s[c] = -std::numeric_limits<double>::infinity();
        s.innovation[c].t_s = nan;
    }
    s.last_event_s = s.last_correction_s = s.field_used_s = -std::numeric_limits<double>::infinity();
    s.held.begin();
    s.speed_known_s = s.slow_since_s = nan;
    s.inconsistent_s = s.restarted_s = -std::numeric_limits<double>::infinity();
    s.bias_inflation = 1;
    s.fit(velocity).begin(1, Consistency::usual_colour_s);
    s.fit(position).begin(1, 0); // errors that last are its colour
    s.aids.begin();
    s.nis_mean = s.heading_inflation = 1;
    s.circle = any;
    if (place_given(options_))
        anchor(s, earth::Place{options_.start_latitude_rad, options_.start_longitude_rad, options_.start_height_m});
    Covariance P = Covariance::of(s);
    put_sensors(s, P);
    P.keep(s);
    begin_levelling(s);
}

// The priors of biases and axes.
void Model::put_sensors(const State& s, Covariance& P) const {
    for (int row = row_gyro; row < row_u; ++row) P.forget(row);
    for (int i = 0; i < 3; ++i) {
        P.put_sigma(row_gyro + i, s.bias_inflation * options_.start_sigma_gyro_bias_rad_s);
        P.put_sigma(row_accel + i, s.bias_inflation * options_.start_sigma_accel_bias_m_s2);
        for (int j = 0; j < 3; ++j)
            P.put_sigma(row_axes + 3 * i + j,
                        i == j ? options_.start_sigma_gyro_scale : options_.start_sigma_gyro_misalignment_rad);
    }
}

void Model::anchor(State& s, const earth::Place& place) const {
    const Matrix3 T = earth::axes_at(place);
    vec(s.anchor_e) = earth::position_of(place);
    mat(s.axes) = T;
    mat(s.fix_axes) = T;
    vec(s.earth_rate) = T.transpose() * Vector3(0, 0, earth::rate_rad_s);
    vec(s.x).setZero();
    put_gravity(s);
    s.has_place = 1;
}

// Processes an IMU sample or a velocity before the first tilt.
void Model::level(State& s, const Event& event) const {
    Levelling& l = s.levelling;
    const double T = event.t_s - s.last_event_s;
    if (std::isfinite(s.last_s[imu]) && T > 0 && is_within(T, options_.longest_gap_s)) {
        const Vector3 w = turn_rate(s), f = specific_force(s);
        const Quaternion q = quat(l.q);
        const HeldTurn<double> turn(w, T);
        const Matrix3 R = rotation_matrix(q);
        vec(l.gained) += R * (turn.integral * f);
        mat(l.sum_A) += T * mat(l.A) + 0.5 * T * T * R;
        mat(l.A) += T * R;
        quat(l.q) = multiply(q, turn.q).normalized();
        vec(l.force) = Vector3(rotation_matrix(turn.q).transpose() * vec(l.force));
        l.length_s += T;
    } else if (has_lasted(T, options_.longest_gap_s) && std::isfinite(s.last_event_s)) {
        begin_levelling(s);
    }
    if (s.has(event, imu)) {
        if (std::isnan(l.began_s)) l.began_s = event.t_s;
        vec(l.force) += vec(event.value[imu] + 3) - vec(s.accel_bias);
        l.samples += 1;
        s.phase = Phase::levelling;
    }
    const bool with_velocity = s.has(event, velocity) && !std::isnan(event.value[velocity][2]);
    if (with_velocity && !std::isnan(l.began_s)) level_by_velocity(s, event);
}

void Model::level_by_velocity(State& s, const Event& event) const {
    constexpr double patience = 4;
    Levelling& l = s.levelling;
    if (wants_window(options_, l, event.t_s)) {
        if (std::isnan(l.since_s)) l.since_s = event.t_s;
        return begin_window(s, event);
    }
    const double strength = s.has_place ? vec(s.gravity).norm() : 9.8;
    const Vector3 gained = vec(l.gained), seen = vec(event.value[velocity]) - vec(l.velocity0) -
                                                 Vector3(0, 0, strength * (event.t_s - l.first_velocity_s));
    const double since_s = event.t_s - l.fits_s;
    const double off = (seen - vec(l.fits_seen)).norm() - (gained - vec(l.fits_gained)).norm();
    if (l.takes_all == 0 && !is_likely(s, off, vec(event.value[velocity] + 3).maxCoeff(), since_s)) {
        // An outlier is rejected. After several in a row the reference velocity was the outlier.
        if (++l.refused < patience) return;
        begin_window(s, event);
        l.takes_all = 1;
        return;
    }
    l.refused = 0;
    l.fits_s = event.t_s;
    vec(l.fits_seen) = seen;
    vec(l.fits_gained) = gained;
    mat(l.moment) += seen * gained.transpose();
    l.variance += vec(event.value[velocity] + 3).squaredNorm() / 3;
    vec(l.sum_seen) += seen;
    vec(l.sum_gained) += gained;
    l.sum_squares += seen.squaredNorm() + gained.squaredNorm();
    l.count += 1;
}

// Variance of the velocities in the window: GNSS noise, plus the curvature that gyro bias, vibration and force noise can add, in the
// worst case common to all samples.
double Model::levelling_variance(const State& s, double window_s, double noise) const {
    const Levelling& l = s.levelling;
    // RMS distance of a parabola in time from a straight line.
    const double bend = window_s * window_s / 27 * vec(l.gained).norm() / window_s * options_.start_sigma_gyro_bias_rad_s;
    return noise * l.variance / l.count + l.count * (bend * bend + force_psd(s) * window_s / 15);
}

// Tilt by velocities. If they change in one direction only, as in one straight acceleration, the rotation of the body about that
// direction is unknown: the vertical lies on a cone about it. The estimate is the mean over the cone, with its variance.
Model::Tilt Model::tilt_by_velocity(const State& s, double now_s) const {
    const Levelling& l = s.levelling;
    const Matrix3 moment = mat(l.moment) - vec(l.sum_seen) * vec(l.sum_gained).transpose() / l.count;
    const Eigen::JacobiSVD<Matrix3> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3 U = svd.matrixU();
    const double hand = U.determinant() * svd.matrixV().determinant() < 0 ? -1 : 1;
    U.col(2) *= hand;
    const Matrix3 now = rotation_matrix(quat(l.q)).transpose();
    const Vector3 down = now * (U * svd.matrixV().transpose()).row(2).transpose();
    const Vector3 axis = now * svd.matrixV().col(0), along = axis.dot(down) * axis, out = down - along;
    const Vector3& size = svd.singularValues();
    Tilt tilt;
    tilt.noise = noise_left(l, size[0] + size[1] + hand * size[2]);
    const OnCircle on((size[1] + hand * size[2]) / levelling_variance(s, now_s - l.first_velocity_s, tilt.noise));
    const Vector3 aside = axis.cross(out);
    tilt.by_velocity = true;
    tilt.down_b = (along + on.cosine * out).normalized();
    tilt.variance_b = on.sine2 * aside * aside.transpose() + (on.cosine2 - on.cosine * on.cosine) * out * out.transpose();
    return tilt;
}

bool Model::find_tilt(const State& s, double now_s, Tilt* tilt) const {
    const Levelling& l = s.levelling;
    const double window_s = now_s - l.first_velocity_s;
    if (l.count >= 2 && has_lasted(window_s, options_.level_window_s)) {
        *tilt = tilt_by_velocity(s, now_s);
        // After a straight acceleration the tilt becomes observable when the acceleration ends: wait for it.
        constexpr double wide_rad = 0.05, patience = 6;
        return tilt->variance_b.trace() < wide_rad * wide_rad ||
               has_passed(now_s - l.since_s, patience * options_.level_window_s);
    }
    // A single velocity may be the only one: wait longer before using the mean force.
    const double patience = std::isnan(l.first_velocity_s) ? 1 : 3;
    const double alone_s = now_s - (l.first_velocity_s > l.since_s ? l.first_velocity_s : l.began_s);
    const Vector3 force = vec(l.force);
    if (l.count >= 2 || !has_lasted(alone_s, patience * options_.level_window_s) || !(force.norm() > 0)) return false;
    tilt->down_b = -force.normalized();
    return true;
}

// The sigma of a given velocity says nothing of another one. Vertical velocities are smaller than horizontal ones.
double Model::start_velocity_sigma(const State& s, int axis) const {
    constexpr double vertical_share = 0.2;
    const double unknown = state_given(options_) && !has_given_state(s) ? any_velocity_m_s : 0;
    return std::fmax(unknown, options_.start_sigma_velocity_m_s) * (axis == 2 ? vertical_share : 1);
}

// Position, colour and velocity at a fix of these sigmas. wide_m: sigma of what is unknown beyond them.
void Model::put_place(const State& s, Covariance& P, const double* sigma_m, double wide_m) const {
    for (int i = 0; i < 3; ++i) {
        const double colour2 = square(s.slow_m[i == 2]);
        P[row_colour + i][row_colour + i] = colour2;
        P[row_d + i][row_d + i] = square(sigma_m[i]) + square(wide_m) + colour2;
        P[row_d + i][row_colour + i] = P[row_colour + i][row_d + i] = -colour2;
        P[row_v + i][row_v + i] = square(start_velocity_sigma(s, i));
    }
}

// A displacement that is a fix less the antenna's place in the body.
void Model::put_at_antenna(State& s, Covariance& P) const {
    const Matrix3 R = attitude(s), antenna = P.block(row_antenna, row_antenna);
    vec(s.x) = -(R * vec(s.antenna));
    for (int j = row_phi; j < P.n; ++j) {
        const Vector3 by = R * Vector3(P[row_antenna][j], P[row_antenna + 1][j], P[row_antenna + 2][j]);
        for (int i = 0; i < 3; ++i) P[row_d + i][j] = P[j][row_d + i] = P[row_d + i][j] - by[i];
    }
    P.add(row_d, row_d, R * antenna * R.transpose());
}

// Sensor errors as they are, and the priors of what no fix shows at once.
Covariance Model::prior(const State& s) const {
    Covariance P = Covariance::of(s);
    for (int row = 0; row < P.n; ++row)
        if (row < row_gyro || row >= row_u) P.forget(row);
    P.put_sigma(row_scale, options_.start_sigma_speed_scale);
    for (int i = 0; i < 2; ++i) P.put_sigma(row_mount + i, options_.start_sigma_mounting_rad);
    P.put_sigma(row_latency, options_.start_sigma_latency_s);
    for (int i = 0; i < 3; ++i) P.put_sigma(row_antenna + i, options_.start_sigma_antenna_m);
    return P;
}

// The sigma of the first position contains start_sigma_position_m, so that a bad first fix does no harm.
void Model::start_covariance(State& s, const Vector3& first_sigma, const Tilt& found) const {
    Covariance P = prior(s);
    s.slow_m[0] = s.slow_before_m[0] = slow_sigma(first_sigma.head<2>().maxCoeff(), false);
    s.slow_m[1] = s.slow_before_m[1] = slow_sigma(first_sigma[2], true);
    put_place(s, P, first_sigma.data(), has_given_place(s) ? given_place_m : options_.start_sigma_position_m);
    const bool sharp = has_given_state(s) || (found.by_velocity && !state_given(options_));
    const double tilt = std::fmax(sharp ? 0 : mean_force_tilt, options_.start_sigma_tilt_rad);
    if (has_given_state(s)) {
        for (int i = 0; i < 3; ++i) P.put_sigma(row_phi + i, i == 2 ? options_.start_sigma_heading_rad : tilt);
        return P.keep(s);
    }
    for (int i = 0; i < 2; ++i) P.put_sigma(row_u + i, std::sqrt(0.5));
    // Gyro and accelerometer biases acted on the window: the tilt is correlated with them.
    const Levelling& l = s.levelling;
    const Matrix3 to_now = attitude(s) * rotation_matrix(quat(l.q)).transpose();
    Matrix3 by_gyro = Matrix3::Zero(), by_accel = Matrix3::Zero();
    if (l.length_s > 0) {
        by_gyro = -(to_now * (mat(l.A) - mat(l.sum_A) / l.length_s));
        const Matrix3 mean = to_now * mat(l.A) / l.length_s;
        const double g = vec(s.gravity).norm();
        by_accel.row(0) = mean.row(1) / g;
        by_accel.row(1) = -mean.row(0) / g;
    }
    by_gyro.row(2).setZero();
    const Matrix3 G = P.block(row_gyro, row_gyro), F = P.block(row_accel, row_accel);
    const Matrix3 with_gyro = by_gyro * G, with_accel = by_accel * F;
    const Matrix3 own = with_gyro * by_gyro.transpose() + with_accel * by_accel.transpose();
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 3; ++j) {
            P[row_phi + i][row_gyro + j] = P[row_gyro + j][row_phi + i] = with_gyro(i, j);
            P[row_phi + i][row_accel + j] = P[row_accel + j][row_phi + i] = with_accel(i, j);
        }
        for (int j = 0; j < 2; ++j) P[row_phi + i][row_phi + j] = own(i, j) + (i == j ? tilt * tilt : 0);
    }
    // A rotation about one horizontal axis moves the vertical along the other.
    const Matrix3 off = attitude(s) * found.variance_b * attitude(s).transpose();
    P[row_phi][row_phi] += off(1, 1);
    P[row_phi + 1][row_phi + 1] += off(0, 0);
    P[row_phi][row_phi + 1] -= off(0, 1);
    P[row_phi + 1][row_phi] -= off(0, 1);
    P.keep(s);
}

// Starts at the first fix after the window, or at the given place; after a loss without fixes at the last place, which is as uncertain as
// it is far from the given one.
void Model::start(State& s, const Event& event, const Tilt& tilt) const {
    const bool given = has_given_state(s);
    const Vector3 down_b = tilt.down_b;
    Vector3 sigma;
    if (s.has(event, position)) {
        const double* p = event.value[position];
        anchor(s, {p[0], p[1], p[2]});
        sigma = vec(p + 3);
    } else {
        sigma.setConstant(vec(s.x).norm());
    }
    const double roll = std::atan2(down_b[1], down_b[2]), pitch = std::atan2(-down_b[0], std::hypot(down_b[1], down_b[2]));
    const Quaternion level = multiply(rotation_quaternion(Vector3(0, pitch, 0)), rotation_quaternion(Vector3(roll, 0, 0)));
    quat(s.x + 6) = given ? Quaternion(options_.start_q_nb).normalized() : level;
    vec(s.x + 3) = given ? Vector3(options_.start_velocity_n_m_s) : Vector3(Vector3::Zero());
    vec(s.antenna) = vec(options_.antenna_b_m);
    s.u[0] = given ? 1 : 0;
    s.u[1] = 0;
    if (!given) s.earth_rate[0] = s.earth_rate[1] = 0;
    s.circle = given ? Circle{} : any;
    s.external = {};
    s.placed_s = event.t_s;
    for (double& e : s.mean) e = 0;
    s.latency = s.scale = 0;
    s.offset = nan; // until there is a pressure
    for (double& c : s.in_t.colour) c = 0;
    for (double& g : s.in_t.gained) g = 0;
    for (double& m : s.mount) m = 0;
    s.nis_mean = 1;
    s.field_unit = 0; // until there is a magnetometer
    start_covariance(s, sigma, tilt);
    if (s.has(event, position)) {
        Covariance P = Covariance::of(s);
        put_at_antenna(s, P);
        P.keep(s);
    }
    // Ratio of variances. Chosen: latency and scale errors of a recorded flight look like up to 6 times the variance; taken for noise of the
    // velocities, four of its 28 starts would not become ready.
    constexpr double certainly_noise = 8;
    if (tilt.noise > certainly_noise) s.fit(velocity).begin(tilt.noise, s.fit(velocity).colour_s);
    s.phase = given ? Phase::navigating : Phase::any_heading;
    if (s.has(event, velocity)) {
        // The second velocity is compared with this one, because nothing else is known yet.
        s.gates.velocity_s = s.gates.fitting_s = event.t_s;
        vec(s.gates.velocity) = vec(event.value[velocity]);
    }
    s.information_tilt = s.information_heading = s.information_velocity = s.information_position = 0;
    put_gravity(s);
    s.in_t.mean_force[0] = nan;
    s.mean_force2 = s.recent2 = s.false_force2 = 0;
    s.window = {};
    s.last_correction_s = event.t_s;
}

// Sensor errors are those of s; everything else has a wide prior and only the point of linearisation of `later`. The samples determine
// it again, so that no information is used twice.
State Model::once_more(State s, const State& later, double known_s) const {
    constexpr double any_tilt = 0.1, any_heading = 0.5;
    const bool at_given_place = has_given_place(s);
    s.times_lost = 0; // this state is a given one, which nothing has contradicted
    s.inconsistent_s = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < 2; ++i) s.slow_m[i] = s.slow_before_m[i] = later.slow_m[i];
    Covariance P = prior(s);
    for (int i = 0; i < 3; ++i) {
        const double fast = start_velocity_sigma(s, i), colour = s.slow_m[i == 2];
        P.put_sigma(row_colour + i, colour);
        P.put_sigma(row_d + i, at_given_place ? colour : std::hypot(options_.start_sigma_position_m, fast * known_s));
        P.put_sigma(row_v + i, fast);
        P.put_sigma(row_phi + i, i == 2 ? any_heading : any_tilt);
    }
    s.field_unit = later.field_unit;
    if (s.field_unit > 0) forget_field(s, P);
    P.keep(s);

    double estimate[errors];
    each_parameter(later, [&](int row, const double* value, int count) { std::copy_n(value, count, estimate + row); });
    each_parameter(s, [&](int row, double* value, int count) { std::copy_n(estimate + row, count, value); });
    vec(s.in_t.colour).setZero();
    vec(s.anchor_e) = vec(later.anchor_e);
    mat(s.axes) = mat(later.axes);
    vec(s.earth_rate) = vec(later.earth_rate);
    std::copy(later.x, later.x + nx, s.x);
    begin_levelling(s); // gates and detectors are those of a start
    s.phase = Phase::navigating;
    s.has_place = 1;
    s.u[0] = 1;
    s.u[1] = s.scale = s.mount[0] = s.mount[1] = 0;
    s.circle = Circle{};
    s.offset = nan;
    s.nis_mean = 1;
    s.in_t.mean_force[0] = nan;
    s.mean_force2 = s.recent2 = s.false_force2 = 0;
    quat(s.seen_q) = quat(s.x + 6);
    vec(s.seen_v) = vec(s.x + 3);
    put_gravity(s);
    s.window = {};
    s.last_correction_s = s.last_event_s;
    return s;
}

} // namespace hnav::ins
