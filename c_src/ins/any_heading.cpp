// The phase of unknown heading: its point of linearisation, the transition to navigation, and the return to it.
#include "estimation/gate.hpp"
#include "ins/circle.hpp"
#include "ins/model.hpp"
#include "maths/cholesky.hpp"

namespace hnav::ins {
namespace {

struct OnU {
    double S[2][2], G[errors][2]; // covariance of u; regression of the state on u
};

OnU regression(const Covariance& P) {
    OnU on;
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) on.S[i][j] = P[row_u + i][row_u + j];
    const double determinant = on.S[0][0] * on.S[1][1] - on.S[0][1] * on.S[1][0];
    for (int i = 0; i < P.n; ++i) {
        const double a = P[i][row_u], b = P[i][row_u + 1];
        on.G[i][0] = determinant > 0 ? (a * on.S[1][1] - b * on.S[1][0]) / determinant : 0;
        on.G[i][1] = determinant > 0 ? (b * on.S[0][0] - a * on.S[0][1]) / determinant : 0;
    }
    return on;
}

Circle circle_of(const State& s, const double covariance[2][2], const ExternalHeading& external) {
    const double wider = widened(s), m[2] = {s.u[0] + s.mean[row_u], s.u[1] + s.mean[row_u + 1]};
    const double S[2][2] = {{covariance[0][0] * wider, covariance[0][1] * wider},
                            {covariance[1][0] * wider, covariance[1][1] * wider}};
    return heading_on_circle(m, S, external);
}

// d(u)/d(alpha) at the likeliest alpha.
struct Tangent {
    double x, y;
    explicit Tangent(const Circle& circle) : x(-std::sin(circle.mode_rad)), y(std::cos(circle.mode_rad)) {}
};

// Variance of the present heading: the drift of the gyroscopes since the start is correlated with alpha.
double heading_given(const State& s, const Covariance& P, const OnU& on) {
    const int row = row_phi + 2;
    const Tangent t(s.circle);
    const double by_u = on.G[row][0] * P[row_u][row] + on.G[row][1] * P[row_u + 1][row];
    const double along = s.circle.spread_rad * (1 + on.G[row][0] * t.x + on.G[row][1] * t.y);
    return std::fmax(0, P[row][row] - by_u) + along * along;
}

double largest_given(const Covariance& P, const OnU& on, int row, int count) {
    double largest = 0;
    for (int i = row; i < row + count; ++i)
        largest = std::fmax(largest, P[i][i] - (on.G[i][0] * P[row_u][i] + on.G[i][1] * P[row_u + 1][i]));
    return largest;
}

} // namespace

Model::Spread Model::spread(const State& s, const Covariance& P) const {
    const OnU on = is_free(s) ? regression(P) : OnU{};
    return {is_free(s) ? heading_given(s, P, on) : P[row_phi + 2][row_phi + 2], P.larger(row_phi), largest_given(P, on, row_v, 3),
            largest_given(P, on, row_d, 2)};
}

// NIS of a sample given the likeliest heading and its spread. The mean of the Gaussian is not suitable, because its u may be short,
// and then an outlier has a small NIS. External headings are left out: they may be wrong, and a fix that contradicts them must pass.
double Model::nis_given_heading(const State& s, const Covariance& P, const Measurement& m) const {
    const OnU on = regression(P);
    const Circle circle = s.external.information > 0 ? circle_of(s, on.S, {}) : s.circle;
    const Tangent t(circle);
    const double spread = circle.spread_rad, across = spread * spread / std::sqrt(2.0);
    const double turned[2] = {t.y - std::cos(s.circle.mode_rad), -t.x - std::sin(s.circle.mode_rad)};
    Matrix3 S = Matrix3::Identity();
    Vector3 r = Vector3::Zero();
    double HP[3][errors] = {}, HG[3][2] = {};
    for (int k = 0; k < m.rows; ++k) {
        r[k] = m.r[k];
        for (int i = 0; i < P.n; ++i) {
            if (m.H[k][i] == 0) continue;
            for (int j = 0; j < P.n; ++j) HP[k][j] += m.H[k][i] * P[i][j];
            for (int j = 0; j < 2; ++j) HG[k][j] += m.H[k][i] * on.G[i][j];
        }
        r[k] -= HG[k][0] * turned[0] + HG[k][1] * turned[1];
    }
    for (int k = 0; k < m.rows; ++k)
        for (int l = 0; l < m.rows; ++l) {
            double sum = k == l ? m.R[k] : 0;
            for (int i = 0; i < P.n; ++i) sum += HP[k][i] * m.H[l][i];
            for (int j = 0; j < 2; ++j) sum -= HG[k][j] * HP[l][row_u + j];
            const double along[2] = {HG[k][0] * t.x + HG[k][1] * t.y, HG[l][0] * t.x + HG[l][1] * t.y};
            const double out[2] = {HG[k][0] * t.y - HG[k][1] * t.x, HG[l][0] * t.y - HG[l][1] * t.x};
            S(k, l) = sum + spread * spread * along[0] * along[1] + across * across * out[0] * out[1];
        }
    const Cholesky<3> factor(S);
    return factor.positive() ? r.dot(factor.solve<1>(r)) : 0;
}

void Model::gate_given_heading(const State& s, const Covariance& P, Measurement& m) const {
    m.nis = nis_given_heading(s, P, m);
    const double over = m.gated ? beyond_gate(m.nis, gate_for_rows(m.rows, gate_of(m))) : 1;
    m.scale = over * over; // redescending; only the noise is inflated, H P H' contains the spread of the heading
    for (double& r : m.R) r *= m.scale;
    m.gated = false;
}

namespace {

// While the heading is unknown, GNSS does not observe the gyro bias about the vertical. Tilts and velocities that were linearised about
// different headings only make it look observable. The bias is therefore a consider state: its variance is kept, and its correlations
// correct the other states (Schmidt).
void leave_vertical_bias(const State& s, const Matrix3& before, Covariance& after, double* error) {
    constexpr double any_rad = 1;
    if (!(s.circle.spread_rad > any_rad)) return;
    const Vector3 vertical_b = attitude(s).row(2).transpose();
    const double learnt = vertical_b.dot((before - after.block(row_gyro, row_gyro)) * vertical_b);
    after.add(row_gyro, row_gyro, std::fmax(0, learnt) * vertical_b * vertical_b.transpose());
    vec(error + row_gyro) -= vertical_b.dot(vec(error + row_gyro)) * vertical_b;
}

} // namespace

// Linearises the state at the likeliest alpha, where |u| = 1. GNSS noise in the rows of u shrinks its mean, and the tilt and velocity
// that correspond to a short u are a poor point of linearisation.
void Model::centre(State& s, Covariance& P, bool look_at_circle) const {
    const OnU on = regression(P);
    const double m[2] = {s.u[0] + s.mean[row_u], s.u[1] + s.mean[row_u + 1]};
    if (look_at_circle) s.circle = circle_of(s, on.S, s.external);
    const double u[2] = {std::cos(s.circle.mode_rad), std::sin(s.circle.mode_rad)};
    const auto by_u = [&on, &u](int row, const double* from) {
        return on.G[row][0] * (u[0] - from[0]) + on.G[row][1] * (u[1] - from[1]);
    };
    double shift[errors] = {};
    for (int i = 0; i < P.n; ++i) {
        shift[i] = s.mean[i] + by_u(i, m);
        s.mean[i] -= shift[i];
    }
    apply(s, P, shift);
}

// Applies a correction while the heading is unknown.
void Model::take_free(State& s, const Matrix3& gyro_before, Covariance& P, const Measurement& m, double* error) const {
    if (m.channel == velocity || m.channel == position) leave_vertical_bias(s, gyro_before, P, error);
    for (int i = 0; i < errors; ++i) s.mean[i] += error[i];
    centre(s, P, is_absolute(m) || m.channel == field || m.channel == speed);
}

// An external heading measures the rotation of the axes, alpha; it enters the density on the circle only. External headings within
// heading_colour_s have the same error, and together the weight of one. share: the part of that weight that this sample adds.
void Model::weigh_heading(State& s, Covariance& P, double alpha_rad, double variance, double share) const {
    const Spread before = spread(s, P);
    const double turned = before.heading - s.circle.spread_rad * s.circle.spread_rad; // drift of the gyroscopes since the start
    const double off = std::remainder(alpha_rad - s.circle.mode_rad, 2 * M_PI), own = variance + std::fmax(0, turned);
    Innovation& i = s.innovation[ins::heading];
    i = {s.last_event_s, {off}, {own + s.circle.spread_rad * s.circle.spread_rad}, 0, 1, 1};
    i.nis = off * off / i.variance[0];
    const double over = beyond_gate(i.nis, gate_for_rows(1, options_.gate_nis));
    i.noise_scale = over * over;
    if (over > 1) ++s.inflated[ins::heading];
    const double information = share / own;
    s.external.information += information;
    s.external.alpha_rad += information / s.external.information * std::remainder(alpha_rad - s.external.alpha_rad, 2 * M_PI);
    centre(s, P, true);
    const Spread after = spread(s, P);
    note_gain(s, ins::heading, before, after);
    if (std::sqrt(after.heading) < options_.heading_found_rad) collapse(s, P);
}

namespace {

// While the heading is searched, the velocity v0 at its begin has no known direction. The displacement in the state is then that of fixes which
// are late by tau: it lags by tau v0, and only what the velocity has gained since then shows tau.
Vector3 lag_per_second(const State& s) { return vec(s.x + 3) - vec(s.in_t.gained); }

// Transforms the covariance of the displacement d to that of its value without the lag: by the errors of the latency and of v0, which changes
// with the heading. Without the latter the next position would seem to show the heading, the more sharply the later the fixes are.
void admit_lag(const State& s, Covariance& P) {
    const Vector3 v0 = lag_per_second(s);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < P.n; ++j) P[row_d + i][j] += v0[i] * P[row_latency][j] + s.latency * P[row_v + i][j];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < P.n; ++j) P[j][row_d + i] += v0[i] * P[j][row_latency] + s.latency * P[j][row_v + i];
}

} // namespace

Vector3 displacement(const State& s) {
    Vector3 d = vec(s.x);
    if (is_free(s)) d += s.latency * lag_per_second(s);
    return d;
}

// Covariance about the likeliest heading. Given u everything is Gaussian and linear. Another heading on the circle changes the state
// through its regression on u, and by turning the vectors held in axes turned by -alpha. Both are linear in (x, y) = (cos - 1, sin) of
// the heading error. The turned vectors change with (x, y) too: of these products x^2 + y^2 = -2 x is kept. It cancels the apparent
// change of a displacement and a velocity along themselves, which GNSS excludes.
Covariance Model::given_circle(const State& s, Covariance P) const {
    admit_lag(s, P);
    const OnU on = regression(P);
    const double c = std::cos(s.circle.mode_rad), t = std::sin(s.circle.mode_rad);
    double by[errors][2], GS[errors][2];
    for (int i = 0; i < P.n; ++i) {
        by[i][0] = on.G[i][0] * c + on.G[i][1] * t;
        by[i][1] = on.G[i][1] * c - on.G[i][0] * t;
        for (int k = 0; k < 2; ++k) GS[i][k] = P[i][row_u + k];
    }
    const auto turns = [&by](int row, const double* vector) {
        by[row][1] -= vector[1];
        by[row + 1][1] += vector[0];
        by[row][0] = by[row + 1][1];
        by[row + 1][0] = -by[row][1];
    };
    const Vector3 d = displacement(s);
    turns(row_d, d.data());
    turns(row_v, s.x + 3);
    turns(row_colour, s.in_t.colour);
    by[row_phi + 2][1] += 1;
    const double* square = s.circle.square;
    for (int i = 0; i < P.n; ++i) {
        const double x = by[i][0] * square[0] + by[i][1] * square[1], y = by[i][0] * square[1] + by[i][1] * square[2];
        for (int j = 0; j < P.n; ++j) P[i][j] += x * by[j][0] + y * by[j][1] - on.G[i][0] * GS[j][0] - on.G[i][1] * GS[j][1];
    }
    P.forget(row_u);
    P.forget(row_u + 1);
    return P;
}

// The heading is found: turns the state by alpha. From here on the filter is a usual error-state filter.
void Model::collapse(State& s, Covariance& P) const {
    const double alpha = s.circle.mode_rad;
    P = given_circle(s, P);
    vec(s.x) = displacement(s);
    const Matrix3 R = rotation_matrix(rotation_quaternion(Vector3(0, 0, alpha)));
    turn(s, R);
    turn(P, R);
    for (double& e : s.mean) e = 0;
    s.u[0] = 1;
    s.u[1] = 0;
    s.phase = Phase::navigating;
    s.begin_monitors();
    vec(s.earth_rate) = mat(s.axes).transpose() * Vector3(0, 0, earth::rate_rad_s);
    put_gravity(s);
}

// The gyroscopes have lost the heading, by a long rest with an unknown bias or by a saturated axis. Tilt and biases are kept; heading,
// velocity and displacement are estimated again from their priors. Where samples have contradicted the heading before it was lost, tilt and
// biases are wrong with it, and everything starts again: else the mean squared normalised error of the tilt of trains with consumer sensors
// would be 117 after a minute instead of 1.6.
void Model::restart_heading(State& s, Covariance& P, const Event& event) const {
    if (!is_free(s) && recovers(s)) {
        s.refuted = Refuted::state;
        return;
    }
    s.phase = Phase::any_heading;
    double tilt_and_biases[errors] = {};
    for (int row = row_phi; row < row_u; ++row) tilt_and_biases[row] = s.mean[row];
    for (int row = row_iron; row <= row_direction; ++row) tilt_and_biases[row] = s.mean[row];
    apply(s, P, tilt_and_biases);
    for (double& e : s.mean) e = 0;
    const double* p = event.value[position];
    for (int i = 0; i < 3; ++i)
        for (const int row : {row_d, row_v, row_colour}) P.forget(row + i);
    for (const int row : {row_phi + 2, row_u + 0, row_u + 1}) P.forget(row);
    const Matrix3 before = to_earth_axes(s);
    anchor(s, {p[0], p[1], p[2]});
    const Matrix3 C = mat(s.axes).transpose() * before;
    turn(s, C);
    turn(P, C);
    s.earth_rate[0] = s.earth_rate[1] = 0;
    vec(s.x + 3).setZero();
    for (int i = 0; i < 3; ++i) s.in_t.colour[i] = s.in_t.gained[i] = 0;
    put_place(s, P, p + 3, options_.start_sigma_position_m);
    put_at_antenna(s, P);
    P[row_u][row_u] = P[row_u + 1][row_u + 1] = 0.5;
    s.u[0] = s.u[1] = 0;
    s.circle = any;
    s.external = {};
    s.placed_s = event.t_s;
    s.gates.begin();
    for (const int channel : {velocity, position}) s.note_refusal(channel, false, event.t_s);
    ++s.times_lost;
    put_gravity(s);
}

// Whether a change of velocity with this sigma can exceed the velocity gained by the force by so much.
bool Model::is_likely(const State& s, double off_m_s, double sigma_m_s, double since_s) const {
    constexpr double unmodelled_m_s2 = 0.2;
    const double noise2 = sigma_m_s * sigma_m_s + force_psd(s) * since_s;
    return !(std::fabs(off_m_s) > 6 * std::sqrt(noise2) + unmodelled_m_s2 * since_s);
}

// Finds a wrong velocity without a heading, by the length of the change of velocity. Of two groups of velocities that contradict each
// other the one that lasted longer is accepted.
bool Model::velocity_fits(State& s, const Event& event) const {
    const double* z = event.value[velocity];
    FreeGates& g = s.gates;
    if (std::isnan(g.velocity_s)) g.fitting_s = event.t_s;
    const bool fits = is_likely(s, (vec(z) - vec(g.velocity)).head<2>().norm() - vec(g.gained).head<2>().norm(), z[3],
                                event.t_s - g.velocity_s);
    if (!fits) {
        if (std::isnan(g.refused_s)) g.refused_s = event.t_s;
        if (event.t_s - g.refused_s < g.refused_s - g.fitting_s) return false;
        g.fitting_s = g.refused_s;
    }
    vec(g.velocity) = vec(z);
    vec(g.gained).setZero();
    g.velocity_s = event.t_s;
    g.refused_s = nan;
    return true;
}

// Sums what positions change by from a jump on, relative to the velocity. The sum of an outlier returns to 0. Returns true while it has not. Changes
// too small for a jump belong to the sum: without them noise of four times the stated sigma looks like a jump that lasts.
bool Model::position_jumped(State& s, const Event& event) const {
    const double* z = event.value[position];
    FreeGates& g = s.gates;
    constexpr double half_acceleration_m_s2 = 2; // a lasting acceleration of 4 m/s2 is not counted as a jump
    const double sigma = z[3] * std::sqrt(s.fit(position).noise), sigmas = 6 * sigma;
    const double since_s = event.t_s - g.position_s;
    const double changes_s = since_s + 2 * (event.t_s - g.velocity_s + options_.start_sigma_latency_s);
    const Vector3 now = earth::position_of({z[0], z[1], z[2]});
    const Vector3 off = mat(s.fix_axes).transpose() * (now - vec(g.position)) - since_s * vec(g.velocity);
    const double unknown = half_acceleration_m_s2 * changes_s * since_s;
    const bool lasts = !vec(g.jump).isZero(0);
    if (lasts || off.head<2>().norm() > sigmas + unknown) vec(g.jump) += off;
    g.unknown_m = lasts ? g.unknown_m + unknown : 0;
    vec(g.position) = now;
    g.position_s = event.t_s;
    if (vec(g.jump).head<2>().norm() > sigmas + g.unknown_m) {
        const double variance[] = {sigma * sigma, sigma * sigma};
        s.fit(position).note(g.jump, variance, 2, true, true, event.t_s);
        return true;
    }
    vec(g.jump).setZero();
    return false;
}

} // namespace hnav::ins
