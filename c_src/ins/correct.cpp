// All corrections of one event, and the monitors that each of them updates.
#include "estimation/readiness.hpp"
#include "ins/model.hpp"

namespace hnav::ins {

void add_error(const double* error, State& s) {
    vec(s.x) += vec(error + row_d);
    vec(s.x + 3) += vec(error + row_v);
    const Quaternion turn = rotation_quaternion(vec(error + row_phi));
    quat(s.x + 6) = multiply(turn, quat(s.x + 6)).normalized();
    if (s.field_unit > 0) turn_field(s, rotation_matrix(turn));
    each_parameter(s, [error](int row, double* value, int count) {
        for (int i = 0; i < count; ++i) value[i] += error[row + i];
    });
}

void Model::apply(State& s, Covariance& P, const double* error) const {
    const Vector3 turned_b = attitude(s).transpose() * vec(error + row_phi);
    vec(s.turned_b) += turned_b;
    if (is_free(s)) {
        // An attitude correction times an unknown bias is a product of two errors; it is added as noise.
        const Matrix3 turned = cross_matrix(turned_b);
        P.add(row_accel, row_accel, turned * P.block(row_accel, row_accel) * turned.transpose());
    }
    if (step_) step_->add(error);
    add_error(error, s);
    if (!is_free(s)) return;
    const double h = earth::rate_rad_s * std::hypot(s.axes[6], s.axes[7]);
    s.earth_rate[0] = h * s.u[0];
    s.earth_rate[1] = -h * s.u[1];
}

namespace {

void note_innovation(State& s, const Event& event, const Measurement& m, const Correction& c) {
    Innovation& i = s.innovation[m.channel];
    i = {};
    i.t_s = event.t_s;
    i.nis = c.nis;
    i.noise_scale = c.scale;
    i.dimension = static_cast<std::uint64_t>(m.rows);
    if (c.scale > 1) ++s.inflated[m.channel];
    std::copy_n(c.innovation, m.rows, i.value);
    std::copy_n(c.variance, m.rows, i.variance);
}

// Age up to which a fix is used by the monitors: three periods of a usual receiver.
constexpr double fix_age_s = 3;

bool places_fit(const State& s) {
    constexpr double outliers = 4; // more in a row are none
    return s.refused_in_row[position] < outliers && s.fit(position).bias() < usual_bias;
}

// Rejected velocities are not used against the state until consistent positions have decided that the state is wrong.
bool is_contradicted(const State& s, int channel, double now_s) {
    const Contradiction::Verdict verdict = s.contradiction.verdict;
    return channel == velocity && is_within(now_s - s.last_s[position], fix_age_s) &&
           (verdict == Contradiction::velocity_wrong || (verdict == Contradiction::open && places_fit(s)));
}

// The state is wrong, however small its sigmas, if the NIS of velocities stays large, or that of positions where there are no
// velocities.
void note_strain(State& s, int channel, double nis, bool refused, double now_s) {
    constexpr double small = 4, largest = 10;
    const bool has_velocity = is_within(now_s - s.last_s[velocity], 60.0);
    if ((channel == position && has_velocity) || (refused && is_contradicted(s, channel, now_s))) return;
    s.strain += (std::fmin(nis, largest) - s.strain) / 20;
    if (!(s.strain > small)) s.strained_since_s = nan;
    else if (std::isnan(s.strained_since_s)) s.strained_since_s = now_s;
}

// Updates the monitors with the innovation of GNSS or a rest.
void note_fit(State& s, const Event& event, const Measurement& m, const Correction& c) {
    if (m.assumed && c.scale > 1) return; // the body has departed: that refutes the rest, not the state
    const Innovation& i = s.innovation[m.channel];
    // A position far off is a jump, which the gate and its patience handle. Velocities cannot jump for long.
    const bool jumped = m.channel == position && c.nis > m.rows * square(Consistency::far);
    if (m.channel != ins::rest) s.fit(m.channel).note(i.value, i.variance, m.rows, c.scale > 1, jumped, event.t_s);
    // A single outlier is handled by the gate and does not change the mean NIS.
    if (!(c.scale > 1) || s.refused_in_row[m.channel] > 0) s.nis_mean += (std::fmin(c.nis, 30) / m.rows - s.nis_mean) / 20;
    note_strain(s, m.channel, c.nis / m.rows, c.scale > 1, event.t_s);
}

// Velocities are preferred for consistency tests: they observe tilt, heading and biases, while positions have a slow error of their own.
bool judges_velocity(const State& s, double now_s) {
    return is_within(now_s - s.last_s[velocity], fix_age_s) &&
           (s.refused_in_row[velocity] == 0 || s.contradiction.verdict == Contradiction::state_wrong);
}

// Compares the integrated innovations of rejected velocities with the innovations of the positions.
void judge_velocity(State& s, const Event& event) {
    constexpr double sure = 6; // logarithm of the ratio of likelihoods: chosen, 400 to 1
    Contradiction& c = s.contradiction;
    const bool fits_again = !(s.refused_in_row[velocity] > 0);
    if (fits_again || (c.verdict == Contradiction::velocity_wrong && !places_fit(s))) return c.begin();
    const Innovation &fast = s.innovation[velocity], &place = s.innovation[position];
    const double since_s = c.last_s > 0 ? std::fmin(event.t_s - c.last_s, fix_age_s) : 0;
    c.last_s = event.t_s;
    for (int i = 0; i < 3; ++i) c.way[i] += since_s * fast.value[i];
    if (!is_within(event.t_s - place.t_s, fix_age_s)) return;
    if (std::isnan(c.position[0])) std::copy_n(place.value, 3, c.position);
    if (!event.has(position) || c.verdict != Contradiction::open) return;
    double ratio = 0;
    for (int i = 0; i < 3; ++i) {
        const double moved = place.value[i] - c.position[i], variance = 2 * place.variance[i];
        ratio += (square(moved) - square(moved - c.way[i])) / (2 * variance);
    }
    if (!(std::fabs(ratio) > sure)) return;
    c.verdict = ratio > 0 ? Contradiction::state_wrong : Contradiction::velocity_wrong;
    if (c.verdict == Contradiction::state_wrong)
        for (int w = 0; w < step_windows; ++w) s.steps[w].add(c.steps[w]);
}

// A tilt and the accelerometer bias that produces the same force are one unobservable direction until the body turns, and so are the heading and
// the gyro bias that replaces the Earth rate. When corrections turn the estimate, these must be kept, or they seem to be observed
// (observability-constrained filters, Huang et al. 2010): biases stay in t. But by a corrected heading the tilt turns with the body instead, so that
// errors along its axes remain apart: on a straight way the pitch is observed and the roll is not. In the search the heading is u; such a correction
// takes back what the gyroscopes have drifted by, and turns nothing.
void turn_errors(State& s, Covariance& P) {
    const Matrix3 R = attitude(s);
    const Vector3 turned_b = vec(s.turned_b), heading(0, 0, is_free(s) ? 0 : R.row(2).dot(turned_b));
    const auto back = [](const Vector3& angle_b) { return rotation_matrix(rotation_quaternion(-angle_b)); };
    if (!is_free(s)) {
        turn_rows(P, row_phi, rotation_matrix(rotation_quaternion(heading)));
        turn_rows(P, row_gyro, back(turned_b));
    }
    turn_rows(P, row_accel, back(turned_b - R.transpose() * heading));
    vec(s.turned_b).setZero();
}

} // namespace

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
    Correction c = correction_by(m, P, s.mean, gate_of(m));
    if (!c.sound) return;
    note_innovation(s, event, m, c);
    if (is_absolute(m)) {
        note_fit(s, event, m, c);
        note_steps(s, m, c);
    }
    if (c.scale > 1 && !is_free(s) && is_contradicted(s, m.channel, event.t_s)) return;
    if (is_absolute(m) && m.assumed)
        for (int i = 0; i < row_axes; ++i) s.by_rests[i] += c.error[i];
    const Matrix3 gyro_before = P.block(row_gyro, row_gyro);
    reduce(P, c, m.rows);
    if (is_free(s)) take_free(s, gyro_before, P, m, c.error);
    else apply(s, P, c.error);
    const Spread after = spread(s, P);
    note_gain(s, m.channel, before, after);
    if (is_free(s) && std::sqrt(after.heading) < options_.heading_found_rad) collapse(s, P);
}

// Adds variance to a row, without correlation to others.
void Model::widen(Covariance& P, int row, double variance) const {
    P[row][row] += variance;
    if (step_) step_->jumped(row, variance);
}

// Factor by which the bias of the innovations exceeds its limit; 1: consistent.
double Model::misfit(const State& s, double now_s) const {
    constexpr double fastest = 4, grows_s = 1, lasts_s = 2;
    // Limits on Consistency::bias that begin and end an inconsistency. Over the long window model errors, such as a tilt that is
    // correlated with an unknown accelerometer bias, have a mean too; that window is weighted by long_part.
    // Without a claimed heading the linearisation is coarse, and the limit larger by that factor: chosen. A given state is not coarse, and only
    // chance is allowed: of 120 aircraft with a given heading 170 deg off, 119 are ready after 150 s, by the larger limit 111.
    constexpr double begins = 20, ends = 3, long_part = 0.25, coarse = 2;
    const bool by_velocity = judges_velocity(s, now_s);
    const bool inconsistent = is_within(now_s - s.inconsistent_s, lasts_s);
    const bool claimed = has_passed(now_s - s.heading_since_s, options_.ready_hold_s);
    const Consistency& fit = s.fit(by_velocity ? velocity : position);
    const double limit = inconsistent ? ends : claimed ? begins : has_given_state(s) ? usual_bias : coarse * begins;
    const double misfit = std::fmax(fit.bias(0), long_part * fit.bias(1)) / limit;
    if (misfit > 1) return std::fmin(fastest, misfit);
    // Without velocities the slow position error may absorb an error of the state; it must stay within its own sigma.
    const bool swallows =
        vec(s.in_t.colour).head<2>().norm() > usual_colour * s.slow_m[0] && has_passed(now_s - s.last_s[velocity], fix_age_s);
    return swallows ? 1 + s.window.length_s / grows_s : 1;
}

// The variances of a vector grow by this factor, their sigmas up to the largest; correlations are kept.
void Model::enlarge(Covariance& P, int row, double factor, double largest) const {
    for (int i = row; i < row + 3; ++i) {
        if (!(P[i][i] > 0)) continue;
        const double by = std::sqrt(std::fmax(1, std::fmin(factor, square(largest) / P[i][i])));
        P.scale(i, by);
        if (step_) step_->scaled(i, by);
    }
}

// Innovations with a significant mean: the state is wrong and its covariance too small. The sigmas of all rows that could explain it
// grow by the misfit (fading memory, Zhou and Frank 1996) until the innovations fit, with their correlations but for the latency's. A
// heading lost in this way is searched again, a lost tilt is levelled again. The information that readiness needs must be gathered again.
void Model::inflate_inconsistent(State& s, Covariance& P, double now_s) const {
    // Largest sigmas, chosen for usual faults: rad/s, m/s2, rad, m/s.
    constexpr double gyro = 0.05, accel = 3, angle = 1, speed = 30;
    if (s.phase != Phase::navigating || !has_judged(s)) return;
    const double factor = misfit(s, now_s);
    if (!(factor > 1)) return;
    enlarge(P, row_v, factor, speed);
    enlarge(P, row_phi, factor, angle);
    enlarge(P, row_gyro, factor, gyro);
    enlarge(P, row_accel, factor, accel);
    // A displacement and the latency that explains it are not observed apart while the velocity is constant. Scaled without the displacement,
    // the latency would seem to be observed: of a start near the pole it was .15 s off at a sigma of .008. Beyond what it is at the start it is not
    // made: one of 60 cars with a wrong given state is never ready without this limit, 120 deg off.
    const double late2 = P[row_latency][row_latency];
    widen(P, row_latency, std::fmax(0, std::fmin(factor * late2, square(options_.start_sigma_latency_s)) - late2));
    for (Consistency& fit : s.fits) fit.widen(factor);
    s.inconsistent_s = now_s;
    s.information_tilt = s.information_heading = s.information_velocity = 0;
}

// Of two groups of samples that contradict each other the one that lasted longer is accepted.
bool Model::first_were_wrong(const State& s, int channel, double now_s) {
    const double refused_s = s.refused_since_s[channel];
    return refused_s - s.placed_s < now_s - refused_s;
}

// Whether rejected samples have lasted long enough to be accepted. No GNSS error reaches kilometres: such positions are another
// receiver's or invalid, and need more patience. The first positions of a start are defended no longer than they have lasted.
bool Model::outlasts(const State& s, int channel, double off_m, double now_s) const {
    constexpr double in_row = 3, far_m = 5e3, longer = 8; // refusals; m; of the usual patience: chosen
    const double since_s = s.refused_since_s[channel];
    double patience_s = options_.gate_longest_s;
    if (channel == position) patience_s = std::fmin((off_m > far_m ? longer : 1) * patience_s, since_s - s.placed_s);
    return s.refused_in_row[channel] >= in_row && has_passed(now_s - since_s, patience_s);
}

// Accepts a jump that has lasted: as an error of the GNSS position, or as a real change of velocity. If the first positions of a start
// were wrong, the estimated position is wrong instead.
void Model::accept_jump(State& s, Covariance& P, int channel, double off, double now_s) const {
    int row = row_v;
    if (channel == position) {
        const bool first = first_were_wrong(s, position, now_s);
        row = first ? row_d : row_colour;
        if (!first) s.glide.jumped = s.drifted = 1;
        s.placed_s = s.refused_since_s[position];
    }
    for (int i = 0; i < 3; ++i) widen(P, row + i, off * off);
    s.note_refusal(channel, false, now_s);
}

namespace {

// Whether a position is so far off that the estimated attitude has no horizon there, as after fixes at (0, 0) while a receiver has none.
bool turns_vertical(int channel, double off_m) {
    constexpr double turned_rad = 0.05; // the tilt of three degrees that no ready flag allows
    return channel == position && off_m > turned_rad * earth::equator_m;
}

// Factor on the stated variance: estimated for each aid; for rests, and before the heading is known, from the mean NIS of all aids.
double noise_of(const State& s, int channel, double now_s) {
    if (channel == ins::rest) return widened(s);
    const double learnt = s.fit(channel).weight(now_s);
    return is_free(s) ? std::fmax(widened(s), learnt) : learnt; // a coarse linearisation adds errors that are not noise
}

} // namespace

// Accepts a jump that lasts. Before the heading is found the first fix may be the wrong one; only later fixes can decide.
void Model::use_absolute(State& s, Covariance& P, const Event& event, Measurement& m) const {
    // Errors of positions last for some fixes: without the 2 s a flight past the pole, 2 m off at a stated 0.5 m, starts again and again.
    constexpr double refusals_when_free = 3, lasting_s = 2, fresh_s = 10;
    const double off = vec(m.r).norm();
    const bool refutes_start = is_free(s) && m.channel != ins::rest && s.refused_in_row[m.channel] >= refusals_when_free &&
                               has_lasted(event.t_s - s.refused_since_s[m.channel], lasting_s) &&
                               is_within(event.t_s - s.last_s[position], fresh_s);
    const bool jumps = outlasts(s, m.channel, off, event.t_s) && !is_contradicted(s, m.channel, event.t_s);
    if (refutes_start || (jumps && turns_vertical(m.channel, off))) {
        // Tilt and biases have followed the first fixes, or have stepped since.
        s.refuted = first_were_wrong(s, m.channel, event.t_s) ? Refuted::first_fixes : Refuted::state;
        return;
    }
    if (jumps) {
        accept_jump(s, P, m.channel, off, event.t_s);
        m.gated = false;
    }
    if (m.channel != ins::rest) s.fit(m.channel).restate(square(event.value[m.channel][3]));
    for (double& r : m.R) r *= noise_of(s, m.channel, event.t_s);
    if (is_free(s)) gate_given_heading(s, P, m);
    use(s, P, event, m);
    s.note_refusal(m.channel, s.innovation[m.channel].noise_scale > 1, event.t_s);
}

void Model::restart_if_wrong(State& s, double now_s) const {
    constexpr double patience_s = 10;
    if (s.phase == Phase::navigating && at_rest(s, now_s)) s.strained_since_s = nan; // rest has a monitor of its own
    if (s.refuted != Refuted::nothing || has_passed(now_s - s.strained_since_s, patience_s)) restart(s, now_s);
}

// Starts again from the priors: nothing that was learnt is kept. If the last restart was a short time ago, the biases may exceed their
// priors, which are widened.
void Model::restart(State& s, double now_s) const {
    constexpr double soon_s = 120, wider = 5, widest = 100;
    const bool first = s.refuted == Refuted::first_fixes;
    s.bias_inflation = is_within(now_s - s.restarted_s, soon_s) && !first ? std::fmin(widest, wider * s.bias_inflation) : 1;
    s.restarted_s = now_s;
    ++s.times_lost;
    // Motion contradicted the heading: the compass or the field may be wrong, so their variance is inflated.
    constexpr double more = 1e4, most = 1e8, fresh_s = 60;
    const double compass_s = std::fmax(s.last_s[ins::heading], s.field_used_s);
    if (!first && is_within(now_s - compass_s, fresh_s)) s.heading_inflation = std::fmin(most, more * s.heading_inflation);
    s.refuted = Refuted::nothing;
    for (double* estimate : {s.gyro_bias, s.accel_bias}) vec(estimate).setZero();
    mat(s.gyro_axes).setZero();
    // What motion has refuted may be the accelerometer. Chosen: with 0 the tilt is ready and wrong for 8 % of the time after a step of the force
    // of 2 m/s2 on a quadrotor, with this for .03 %; with 1 it is right again 0.6 s later in the mean over all faults.
    constexpr double stepped_m_s2 = 0.3;
    Covariance P = Covariance::of(s);
    put_sensors(s, P);
    for (int i = 0; i < 3 && !first; ++i) P[row_accel + i][row_accel + i] += square(stepped_m_s2);
    P.keep(s);
    for (double& x : s.x) x = 0;
    s.x[6] = 1;
    begin_levelling(s);
}

// All variances are finite and positive, and the tilt is small enough for the linear model.
bool Model::is_sound(const State& s, const Covariance& P) const {
    constexpr double largest_tilt = 1; // rad
    bool sound = plausible(s) && std::isfinite(vec(s.x).sum() + vec(s.x + 3).sum());
    for (int i = 0; i < P.n; ++i) sound = sound && P[i][i] >= 0 && std::isfinite(P[i][i]);
    const int attitude = is_free(s) ? row_phi + 2 : row_gyro; // the rotation about the vertical is exact where its search begins
    for (int i = 0; i < attitude; ++i) sound = sound && P[i][i] > 0;
    return sound && P.larger(row_phi) < square(largest_tilt);
}

// A slow drift of the positions moves the estimate along. When their slow error exceeds its usual size, the estimate is wrong by about
// the same amount.
void Model::admit_drift(State& s, Covariance& P) const {
    const double off_m = vec(s.in_t.colour).head<2>().norm();
    const bool beyond = off_m > usual_colour * s.slow_m[0];
    const bool found = beyond && s.drifted == 0;
    s.drifted = beyond ? 1 : 0;
    if (!found) return;
    for (const int row : {row_d, row_colour})
        for (int i = 0; i < 2; ++i) widen(P, row + i, off_m * off_m);
}

// Records the time since which the sigma of the heading has been below its limit.
void Model::note_small_heading(State& s, const Covariance& P, double now_s) const {
    const double sigma2 = spread(s, P).heading * std::fmax(1, s.nis_mean);
    const bool small = s.phase == Phase::navigating && sigma2 < square(options_.ready_heading_rad) && s.inconsistent_s < now_s;
    if (!small) s.heading_since_s = nan;
    else if (std::isnan(s.heading_since_s)) s.heading_since_s = now_s;
}

// Positions whose stated sigma was far too small were weighted too much: widens the position to the usual slow error.
void Model::admit_learnt_noise(State& s, Covariance& P) const {
    if (is_learnt(s, position)) {
        for (int i = 0; i < 3; ++i) {
            const double usual_m = std::fmin(s.slow_m[i == 2], options_.position_colour_m[i == 2]);
            widen(P, row_d + i, std::fmax(0, square(usual_m) - square(s.slow_before_m[i == 2])));
        }
    }
    for (int i = 0; i < 2; ++i) s.slow_before_m[i] = s.slow_m[i];
}

void Model::correct(State& s, const Event& event) const {
    Covariance P = Covariance::of(s);
    note_stated(s, event);
    const Colour colour = colour_of(s, s.mean);
    const double tilt_kept = propagate(s, P, s.mean);
    const bool sees_field = wants_field(s, event);
    if (sees_field) begin_field(s, P, event);
    note_prediction(s, P, tilt_kept);
    s.direction *= direction_kept(s);
    vec(s.in_t.colour) = Vector3(vec(s.in_t.colour).cwiseProduct(vec(colour.kept)));
    admit_learnt_noise(s, P);
    admit_drift(s, P);
    admit_steps(s, P, event.t_s);
    inflate_inconsistent(s, P, event.t_s);
    correct_rest(s, P, event);
    if (has_new(s, event, speed)) correct_speed(s, P, event);
    correct_car(s, P, event);
    if (has_new(s, event, pressure)) correct_pressure(s, P, event);
    s.window = {};
    if (has_new(s, event, velocity)) {
        correct_velocity(s, P, event);
        if (s.refused_in_row[velocity] == 0) begin_steps(s, P, newest_window, event.t_s);
    }
    if (has_new(s, event, position)) correct_position(s, P, event);
    if (has_new(s, event, ins::heading)) correct_heading(s, P, event);
    if (s.phase == Phase::navigating && !is_elsewhere(s, event)) judge_velocity(s, event);
    if (sees_field) correct_field(s, P, event);
    turn_errors(s, P);
    if (!is_free(s)) move_anchor(s, P);
    s.last_correction_s = event.t_s;
    ++s.corrections;
    if (!is_sound(s, P)) return restart(s, event.t_s);
    put_gravity(s);
    P.keep(s);
    note_small_heading(s, P, event.t_s);
    restart_if_wrong(s, event.t_s);
}

} // namespace hnav::ins
