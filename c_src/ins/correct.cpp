// All corrections of one event, and what each of them leaves in the state.
#include "estimation/readiness.hpp"
#include "ins/model.hpp"

namespace hnav::ins {

void add_error(const double* error, State& s) {
    vec(s.x) += vec(error + row_d);
    vec(s.x + 3) += vec(error + row_v);
    const Quaternion turn = rotation_quaternion(vec(error + row_phi));
    quat(s.x + 6) = multiply(turn, quat(s.x + 6)).normalized();
    if (s.field_unit > 0) turn_field(s, rotation_matrix(turn));
    vec(s.gyro_bias) += vec(error + row_gyro);
    vec(s.accel_bias) += vec(error + row_accel);
    vec(s.gyro_scale) += vec(error + row_gyro_scale);
    s.latency += error[row_latency];
    vec(s.in_t.colour) += vec(error + row_colour);
    s.offset += error[row_offset];
    s.scale += error[row_scale];
    for (int i = 0; i < 2; ++i) {
        s.u[i] += error[row_u + i];
        s.mount[i] += error[row_mount + i];
    }
    vec(s.iron) += vec(error + row_iron);
    s.strength += error[row_strength];
    s.direction += error[row_direction];
}

void Model::apply(State& s, Covariance& P, const double* error) const {
    // Unknown biases in axes that are found to stand otherwise: a product of two errors, here it is noise. Without it a tilt and the
    // bias that looks like it would be told from each other by nothing but corrections.
    const Matrix3 turned = cross_matrix(attitude(s).transpose() * vec(error + row_phi));
    const Matrix3 more = turned * P.block(row_accel, row_accel) * turned.transpose();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) P[row_accel + i][row_accel + j] += more(i, j);
    if (step_) step_->add(error);
    add_error(error, s);
    if (!is_free(s)) return;
    const double h = earth::rate_rad_s * std::hypot(s.axes[6], s.axes[7]);
    s.earth_rate[0] = h * s.u[0];
    s.earth_rate[1] = -h * s.u[1];
}

namespace {

void note_innovation(State& s, const Event& event, const Measurement& m, const Covariance& P, const double* mean,
                     const Correction& c) {
    Innovation& i = s.innovation[m.channel];
    i = {};
    i.t_s = event.t_s;
    i.nis = c.nis;
    i.noise_scale = c.scale;
    i.dimension = static_cast<std::uint64_t>(m.rows);
    if (c.scale > 1) ++s.inflated[m.channel];
    for (int k = 0; k < m.rows; ++k) {
        i.value[k] = m.r[k];
        i.variance[k] = m.R[k];
        for (int a = 0; a < P.n; ++a) {
            if (m.H[k][a] == 0) continue;
            i.value[k] -= m.H[k][a] * mean[a];
            for (int b = 0; b < P.n; ++b) i.variance[k] += m.H[k][a] * P[a][b] * m.H[k][b];
        }
    }
}

} // namespace

// How well the satellites and rests fit.
void Model::note_fit(State& s, const Event& event, const Measurement& m, const Correction& c) {
    // A single fix that lies far off is the gate's, and says nothing of the others.
    if (!(c.scale > 1) || s.refused_in_row[m.channel] > 0) s.nis_mean += (std::fmin(c.nis, 30) / m.rows - s.nis_mean) / 20;
    note_strain(s, m.channel, c.nis / m.rows, event.t_s);
}

void Model::note_gain(State& s, int channel, const Spread& before, const Spread& after) {
    if (after.heading > 0 && after.heading < before.heading)
        s.gained_nats[channel] += 0.5 * std::log(before.heading / after.heading);
    s.information_heading += information_gained(before.heading, after.heading);
    s.information_tilt += information_gained(before.tilt, after.tilt);
    s.information_velocity += information_gained(before.velocity, after.velocity);
    s.information_position += information_gained(before.position, after.position);
}

void Model::use(State& s, Covariance& P, const Event& event, const Measurement& m) const {
    const Spread before = spread(s, P);
    double mean[errors];
    for (int i = 0; i < errors; ++i) mean[i] = s.mean[i];
    const Covariance prior = P;
    Correction c = corrected(P, mean, m, options_.gate_nis);
    if (!c.sound) {
        P = prior;
        return;
    }
    note_innovation(s, event, m, prior, mean, c);
    if (is_absolute(m)) note_fit(s, event, m, c);
    if (is_free(s)) take_free(s, prior, P, m, c.error);
    else apply(s, P, c.error);
    const Spread after = spread(s, P);
    note_gain(s, m.channel, before, after);
    if (is_free(s) && std::sqrt(after.heading) < options_.heading_found_rad) collapse(s, P);
}

// An error that may have become larger by so much at this instant, whatever the others are.
void Model::widen(Covariance& P, int row, double variance) const {
    P[row][row] += variance;
    if (step_) step_->jumped(row, variance);
}

// What was refused for long is an error of the satellites' position, or a velocity that has really changed.
void Model::believe_jump(State& s, Covariance& P, Measurement& m) const {
    const int row = m.channel == position ? row_colour : row_v;
    for (int i = 0; i < m.rows; ++i) widen(P, row + i, m.r[i] * m.r[i]);
    if (m.channel == position) s.glide.jumped = s.drifted = 1;
    m.gated = false;
}

// A jump that lasts is believed. Before the heading is found it is rather the first fix that was wrong, and nothing but a few more can tell.
void Model::use_absolute(State& s, Covariance& P, const Event& event, Measurement& m) const {
    double& since_s = s.refused_since_s[m.channel];
    constexpr double believed_when_free = 3, fresh_s = 10;
    double& in_row = s.refused_in_row[m.channel];
    if (is_free(s) && m.channel != ins::rest && in_row >= believed_when_free && event.t_s - s.last_s[position] < fresh_s) {
        s.first_was_wrong = 1; // and tilt and biases have followed it
        return;
    }
    if (std::isfinite(since_s) && event.t_s - since_s > options_.gate_longest_s) {
        believe_jump(s, P, m);
        since_s = nan;
        in_row = 0;
    }
    for (double& r : m.R) r *= widened(s);
    if (is_free(s)) gate_given_heading(s, P, m);
    use(s, P, event, m);
    const bool refused = s.innovation[m.channel].noise_scale > 1;
    in_row = refused ? in_row + 1 : 0;
    if (!refused) since_s = nan;
    else if (std::isnan(since_s)) since_s = event.t_s;
}

// Velocities that do not fit for long, or positions where there are none, say that the state is wrong, however small its
// sigmas.
void Model::note_strain(State& s, int channel, double nis, double now_s) {
    constexpr double small = 4, largest = 10;
    const bool has_velocity = now_s - s.last_s[velocity] < 60;
    if (channel == position && has_velocity) return;
    s.strain += (std::fmin(nis, largest) - s.strain) / 20;
    if (!(s.strain > small)) s.strained_since_s = nan;
    else if (std::isnan(s.strained_since_s)) s.strained_since_s = now_s;
}

void Model::begin_anew_if_wrong(State& s, double now_s) const {
    constexpr double patience_s = 10;
    if (!s.first_was_wrong && !(now_s - s.strained_since_s > patience_s)) return;
    ++s.times_lost;
    // Motion that did not fit is the better witness against a compass.
    constexpr double more = 1e4, most = 1e8, fresh_s = 60;
    const double compass_s = std::fmax(s.last_s[ins::heading], s.field_used_s);
    if (!s.first_was_wrong && now_s - compass_s < fresh_s) s.heading_doubt = std::fmin(most, more * s.heading_doubt);
    s.first_was_wrong = 0;
    vec(s.gyro_bias).setZero();
    vec(s.accel_bias).setZero();
    vec(s.gyro_scale).setZero();
    Covariance P = Covariance::of(s);
    for (int i = 0; i < 3; ++i) {
        P.forget(row_gyro + i);
        P.forget(row_accel + i);
        P.forget(row_gyro_scale + i);
        P[row_gyro + i][row_gyro + i] = options_.start_sigma_gyro_bias_rad_s * options_.start_sigma_gyro_bias_rad_s;
        P[row_accel + i][row_accel + i] = options_.start_sigma_accel_bias_m_s2 * options_.start_sigma_accel_bias_m_s2;
        P[row_gyro_scale + i][row_gyro_scale + i] = options_.start_sigma_gyro_scale * options_.start_sigma_gyro_scale;
    }
    P.keep(s);
    begin_levelling(s);
}

// Positions that drift away slowly drag the estimate along until their error is found to be too large for what they are: by about as much.
void Model::admit_drift(State& s, Covariance& P) const {
    const double off_m = vec(s.in_t.colour).head<2>().norm();
    const bool beyond = off_m > usual_colour * s.slow_m[0];
    const bool found = beyond && s.drifted == 0;
    s.drifted = beyond ? 1 : 0;
    if (!found) return;
    for (const int row : {row_d, row_colour})
        for (int i = 0; i < 2; ++i) widen(P, row + i, off_m * off_m);
}

void Model::correct(State& s, const Event& event) const {
    Covariance P = Covariance::of(s);
    note_stated(s, event);
    const Colour colour = colour_of(s, s.mean);
    propagate(s, P, s.mean);
    if (is_free(s)) s.tilt_noise += turn_variance(s);
    const bool sees_field = wants_field(s, event);
    if (sees_field) begin_field(s, P, event);
    note_prediction(s, P);
    s.direction *= direction_kept(s);
    for (int i = 0; i < 3; ++i) s.in_t.colour[i] *= colour.kept[i];
    for (int i = 0; i < 2; ++i) s.slow_before_m[i] = s.slow_m[i];
    admit_drift(s, P);
    correct_rest(s, P, event);
    if (has_new(s, event, speed)) correct_speed(s, P, event);
    correct_car(s, P, event);
    if (has_new(s, event, pressure)) correct_pressure(s, P, event);
    clear_window(s);
    if (has_new(s, event, velocity)) correct_velocity(s, P, event);
    if (has_new(s, event, position)) correct_position(s, P, event);
    if (has_new(s, event, ins::heading)) correct_heading(s, P, event);
    if (sees_field) correct_field(s, P, event);
    if (!is_free(s)) move_anchor(s, P);
    put_gravity(s);
    P.keep(s);
    s.last_correction_s = event.t_s;
    ++s.corrections;
    const double sigma2 = heading_variance(s, P) * std::fmax(1, s.nis_mean);
    const double limit = options_.ready_heading_rad / contradicted(s, event.t_s);
    const bool small = s.phase == Phase::navigating && sigma2 < limit * limit;
    if (!small) s.heading_since_s = nan;
    else if (std::isnan(s.heading_since_s)) s.heading_since_s = event.t_s;
    begin_anew_if_wrong(s, event.t_s);
}

} // namespace hnav::ins
