// Growth of errors: gathered at every sample, applied to the covariance a few times a second.
#include "ins/model.hpp"

namespace hnav::ins {
namespace {

// Power spectral density of vibration and noise at the low frequencies that an estimate integrates. share: of the variance between neighbouring
// samples, where means show no less.
double noise_density(const State& s, double share, double between2, int k) {
    return s.usual_interval_s * s.slow_noise.at_most(share * between2, k);
}

} // namespace

// Gathers the interval since the last event, evaluated at its middle.
void Model::gather(State& s, double interval_s) const {
    const double T = interval_s;
    Window& w = s.window;
    const Quaternion middle = (quat(s.seen_q) + quat(s.x + 6)).normalized();
    const Matrix3 R = rotation_matrix(middle);
    if (!(w.length_s > 0)) {
        quat(w.began_q) = quat(s.seen_q);
        w.false_force2 = false_force2(s, R);
    }
    const Vector3 raw = R * shown_force(s);
    note_mean_force(s, raw, T);
    // At rest the force is that against gravity: the noise that vibration leaves in the mean made the heading of tactical sensors look observable, in
    // ten minutes 2.1 deg at an error of 6.6 (5.7 and 5.5 with this).
    const bool rests = at_rest(s, s.last_event_s);
    const Vector3 f = rests ? Vector3(-vec(s.gravity)) : moving_force(s, raw, options_.correction_interval_s),
                  rate = turn_rate(s);
    note_acceleration(s, (rests ? f : raw) + vec(s.gravity), T);
    const Matrix3 turned = cross_matrix(f) * (mat(w.A) + 0.5 * T * R);
    mat(w.D) += T * mat(w.A) + 0.5 * T * T * R;
    mat(w.C) += T * mat(w.B) + 0.5 * T * T * turned;
    mat(w.B) += T * turned;
    mat(w.A) += T * R;
    for (int i = 0; i < 3; ++i) mat(w.by_rate[i]) += T * rate[i] * R;
    vec(w.S) += T * vec(w.F) + 0.5 * T * T * f;
    vec(w.F) += T * f;
    vec(w.rate_sum) += T * vec(s.held.rate);
    w.turned2 += T * rate.squaredNorm();
    w.accelerated2 += T * (vec(s.in_t.mean_force) + vec(s.gravity)).squaredNorm();
    w.length_s += T;
    const Vector3 gained = vec(s.x + 3) - vec(s.seen_v);
    vec(s.gates.gained) += gained;
    vec(s.in_t.gained) += gained;
}

namespace {

Transition transition(const State& s) {
    const Window& w = s.window;
    const double T = w.length_s;
    const Matrix3 I = Matrix3::Identity(), W = cross_matrix(vec(s.earth_rate));
    const double fall = vec(s.gravity).norm() / earth::equator_m;
    Matrix3 G = -fall * I;
    G(2, 2) = 2 * fall;
    Transition t;
    t.put(row_d, row_d, I);
    t.put(row_d, row_v, T * I);
    t.put(row_d, row_phi, -cross_matrix(vec(w.S)));
    t.put(row_d, row_gyro, mat(w.C));
    t.put(row_d, row_accel, -mat(w.D));
    t.put(row_v, row_d, T * G);
    t.put(row_v, row_v, I - 2 * T * W);
    t.put(row_v, row_phi, -cross_matrix(vec(w.F)));
    t.put(row_v, row_gyro, mat(w.B));
    t.put(row_v, row_accel, -mat(w.A));
    t.put(row_phi, row_phi, I - T * W);
    t.put(row_phi, row_gyro, -mat(w.A));
    for (int j = 0; j < 3; ++j)
        for (int row = 0; row < 3; ++row)
            for (int i = 0; i < 3; ++i) t.M[row_phi + row][row_axes + 3 * i + j] = -w.by_rate[j][3 * row + i];
    if (is_free(s)) {
        // The rate of the Earth is (h c, -h s, z) in axes turned by -alpha, h horizontal and z down.
        const double h = earth::rate_rad_s * std::hypot(s.axes[6], s.axes[7]);
        const double vx = s.x[3], vy = s.x[4], vz = s.x[5];
        t.M[row_phi][row_u] = -h * T;
        t.M[row_phi + 1][row_u + 1] = h * T;
        t.M[row_v + 1][row_u] = 2 * h * vz * T;
        t.M[row_v + 2][row_u] = -2 * h * vy * T;
        t.M[row_v][row_u + 1] = 2 * h * vz * T;
        t.M[row_v + 2][row_u + 1] = -2 * h * vx * T;
    }
    return t;
}

// P <- M P M', mean <- M mean.
template <int n>
void carry(const Transition& t, Covariance& P, double* mean) {
    alignas(16) double rows[moved][row_length] = {};
    alignas(16) double response[moved][responses] = {};
    double turned[moved] = {};
    for (int i = 0; i < moved; ++i)
        for (int k = 0; k < movers; ++k) {
            const double m = t.M[i][k];
            if (m == 0) continue;
            for (int j = 0; j < n; ++j) rows[i][j] += m * P[k][j];
            for (int j = 0; j < responses; ++j) response[i][j] += m * P.response[k][j];
            turned[i] += m * mean[k];
        }
    for (int i = 0; i < moved; ++i) {
        mean[i] = turned[i];
        std::copy_n(response[i], responses, P.response[i]);
        for (int j = moved; j < n; ++j) P[i][j] = P[j][i] = rows[i][j];
        for (int j = 0; j <= i; ++j) {
            double sum = 0;
            for (int k = 0; k < movers; ++k) sum += t.M[j][k] * rows[i][k];
            P[i][j] = P[j][i] = sum;
        }
    }
}

// A Gauss-Markov error keeps `share` of itself.
void decay(Covariance& P, double* mean, int row, double share) {
    P.scale(row, share);
    for (double& b : P.response[row]) b *= share;
    mean[row] *= share;
}

// A heading drift of unknown rate also rotates the tilt error. Averages the tilt covariance over a Gaussian rotation of this variance
// (exact for the two axes), so that a long rotation does not make the tilt error grow. Returns the share that each error keeps in the mean.
double turn_tilt(Covariance& P, double lost) {
    if (!(lost > 0)) return 1;
    const double a = P[row_phi][row_phi], b = P[row_phi + 1][row_phi + 1], c = P[row_phi][row_phi + 1];
    const double kept = std::exp(-0.5 * lost), swapped = -0.5 * std::expm1(-2 * lost);
    P.scale(row_phi, kept);
    P.scale(row_phi + 1, kept);
    P[row_phi][row_phi] = a + swapped * (b - a);
    P[row_phi + 1][row_phi + 1] = b + swapped * (a - b);
    P[row_phi][row_phi + 1] = P[row_phi + 1][row_phi] = (1 - 2 * swapped) * c;
    return kept;
}

} // namespace

void Model::note_prediction(const State& s, const Covariance& P, double tilt_kept) const {
    if (!step_) return;
    step_->begin(transition(s), P, s.axes);
    const Colour colour = colour_of(s, s.mean);
    for (int i = 0; i < 3; ++i) step_->kept[row_colour + i] = colour.kept[i];
    step_->kept[row_direction] = direction_kept(s);
    for (int i = 0; i < 2; ++i) step_->kept[row_phi + i] = tilt_kept;
}

double Model::propagate(const State& s, Covariance& P, double* mean) const {
    const double T = s.window.length_s;
    if (!(T > 0)) return 1;
    const double heading_before = P[row_phi + 2][row_phi + 2];
    with_rows(P.n, [&](auto n) { carry<n>(transition(s), P, mean); });
    const Colour colour = colour_of(s, mean);
    for (int i = 0; i < 3; ++i) {
        decay(P, mean, row_colour + i, colour.kept[i]);
        P[row_colour + i][row_colour + i] += colour.grown[i];
    }
    // Deviations from the standard atmosphere do not decay: they are a random walk with the given rate.
    P[row_offset][row_offset] += 2 * options_.pressure_colour_m * options_.pressure_colour_m * T / options_.pressure_colour_s;
    if (P.n == errors) spoil_field(s, P, mean);
    add_noise(s, P);
    return turn_tilt(P, P[row_phi + 2][row_phi + 2] - heading_before);
}

// Iron and strength of the field are slow random walks; the direction of the field is a first-order process over the place.
void Model::spoil_field(const State& s, Covariance& P, double* mean) const {
    constexpr double walk = 1e-3;
    const double kept = direction_kept(s), off = options_.field_direction_rad;
    decay(P, mean, row_direction, kept);
    P[row_direction][row_direction] += off * off * (1 - kept * kept);
    for (int row = row_iron; row <= row_strength; ++row) P[row][row] += walk * walk * s.window.length_s;
}

// The accuracy that a receiver reports is mostly a slowly varying error, which averaging does not reduce. A sigma below `sharp` of the
// usual slow error is used as stated: carrier phase, or cameras instead of GNSS. With an option of 0 all of it is white noise.
constexpr double sharp = 0.1;

double Model::slow_sigma(double stated_m, bool vertical) const {
    const double usual = options_.position_colour_m[vertical];
    if (!(usual > 0)) return 0;
    return stated_m < sharp * usual ? stated_m : std::fmax(usual, stated_m);
}

// The sigma of the slow error follows a smaller stated sigma at once and a larger one gradually: one bad fix is noise, many are not.
void Model::note_stated(State& s, const Event& event) const {
    constexpr double grows_s = 10;
    if (!has_new(s, event, position) || !(s.window.length_s > 0)) return;
    const double* sigma = event.value[position] + 3;
    const double larger = std::sqrt(s.fit(position).noise); // than stated, as is learnt
    const double stated[] = {slow_sigma(larger * std::fmax(sigma[0], sigma[1]), false), slow_sigma(larger * sigma[2], true)};
    const double most = std::exp(s.window.length_s / grows_s);
    for (int i = 0; i < 2; ++i) {
        const double usual = options_.position_colour_m[i], least = is_learnt(s, position) ? usual : sharp * usual;
        s.slow_m[i] = std::fmin(stated[i], most * std::fmax(s.slow_before_m[i], least));
    }
}

// If the estimated slow error exceeds its usual size, its prior is widened to that size and it no longer decays.
Model::Colour Model::colour_of(const State& s, const double* mean) const {
    const Vector3 error = vec(s.in_t.colour) + vec(mean + row_colour);
    const double size[] = {error.head<2>().norm(), std::fabs(error[2])};
    const double fades = std::exp(-s.window.length_s / options_.position_colour_s);
    Colour c{};
    for (int i = 0; i < 3; ++i) {
        const double before = s.slow_before_m[i == 2], now = s.slow_m[i == 2], beyond = size[i == 2] / usual_colour;
        const double less = before > 0 ? std::fmin(1, now / before) : 1, more = std::fmax(0, now * now - before * before);
        const bool jumped = beyond > before;
        c.kept[i] = jumped ? 1 : fades * less;
        c.grown[i] = (jumped ? beyond * beyond : less * less * before * before) * (1 - fades * fades) + more;
    }
    return c;
}

// Power spectral density of the force noise: that of the sensor, or vibration.
double Model::force_psd(const State& s) const {
    return std::fmax(square(options_.accel_noise_m_s_per_sqrt_s),
                     noise_density(s, options_.vibration_share, s.held.vibration_force2, SlowNoise::force));
}

// Variance of the rotation about one axis over the window, likewise.
double Model::turn_variance(const State& s) const {
    const double psd = std::fmax(square(options_.gyro_noise_rad_per_sqrt_s),
                                 noise_density(s, options_.vibration_share, s.held.vibration_rate2, SlowNoise::rate));
    return psd * s.window.length_s + square(options_.gyro_rate_noise_sqrt_s) * s.window.turned2;
}

void Model::add_noise(const State& s, Covariance& P) const {
    // Scale errors and misalignments of the accelerometer are nine constants, which would be states. Within one acceleration of a usual length they
    // add up, so its square is noise of that duration. Chosen: of cars whose accelerometer has 1 %, the tilt has a z2 of 15 without it, 3.3 with 4 s,
    // 1.4 with 16.
    constexpr double accelerates_s = 16;
    const Window& w = s.window;
    const double T = w.length_s, gyro = turn_variance(s),
                 accel = force_psd(s) * T + accelerates_s * square(options_.accel_scale) * w.accelerated2;
    const Matrix3 R = attitude(s);
    P.add(row_phi, row_phi, R * Vector3(w.lost_turn2).asDiagonal() * R.transpose());
    P.add(row_v, row_v, R * Vector3(w.lost_gain2).asDiagonal() * R.transpose());
    for (int i = 0; i < 3; ++i) {
        P[row_v + i][row_v + i] += accel + w.gap.gain2;
        P[row_d + i][row_d + i] += accel * T * T / 3 + w.gap.way2;
        P[row_d + i][row_v + i] += accel * T / 2;
        P[row_v + i][row_d + i] += accel * T / 2;
        P[row_phi + i][row_phi + i] += gyro + w.gap.turn2;
        P[row_gyro + i][row_gyro + i] += square(options_.gyro_bias_walk_rad_s_per_sqrt_s) * T;
        P[row_accel + i][row_accel + i] += square(options_.accel_bias_walk_m_s2_per_sqrt_s) * T;
    }
}

} // namespace hnav::ins
