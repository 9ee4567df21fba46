// GNSS velocity and position, of the antenna at their time of validity.
#include "ins/model.hpp"

#include "maths/square.hpp"

namespace hnav::ins {
namespace {

// B(z) u is z in axes turned by -alpha: linear in u.
void put_turned(Measurement& m, const Vector3& z, const double* u, Vector3* turned) {
    const double B[2][2] = {{z[0], z[1]}, {z[1], -z[0]}};
    for (int i = 0; i < 2; ++i) {
        (*turned)[i] = B[i][0] * u[0] + B[i][1] * u[1];
        for (int k = 0; k < 2; ++k) m.H[i][row_u + k] = -B[i][k];
    }
}

// A fix is late by the latency: a quantity that changes at this rate is measured as it was then. Receivers smooth the vertical channel
// more than the horizontal ones, which adds a delay of its own, so the vertical does not observe the latency.
void put_latency(const Covariance& P, Measurement& m, const Vector3& change) {
    // Sigma of that delay: in a recorded flight horizontal velocities fit best 0.04 s late, vertical ones 0.1 s (docs/ins.md).
    constexpr double of_vertical_s = 0.06;
    for (int i = 0; i < 2; ++i) m.H[i][row_latency] = -change[i];
    m.R[2] += (square(of_vertical_s) + P[row_latency][row_latency]) * square(change[2]);
}

} // namespace

// A receiver takes north and east at its own place. Without it they are those of the estimated place, whose error turns them by its size over
// the distance to the pole.
Model::North Model::north_of(const State& s, const Covariance& P, const Event& event) const {
    const double* fix = event.value[position];
    if (event.has(position) && !is_elsewhere(s, event)) return {earth::axes_at({fix[0], fix[1], fix[2]}), 0};
    if (is_free(s)) return {mat(s.fix_axes), 0};
    const earth::Place here = place_of(s);
    const double off_m = std::sqrt(P.larger(row_d) + square(s.slow_m[0]));
    return {earth::axes_at(here), std::fmin(M_PI, off_m * std::fabs(std::tan(here.latitude_rad)) / earth::equator_m)};
}

void Model::correct_velocity(State& s, Covariance& P, const Event& event) const {
    const double* value = event.value[velocity];
    const bool free = is_free(s);
    if (free && !velocity_fits(s, event)) {
        ++s.inflated[velocity];
        return;
    }
    Measurement m{velocity, std::isnan(value[2]) ? 2 : 3};
    const North north = north_of(s, P, event);
    Vector3 z = vec(value);
    if (m.rows == 2) z[2] = 0;
    z = mat(s.axes).transpose() * (north.axes * z);
    const Matrix3 R = attitude(s);
    const Vector3 w = turn_rate(s), lever = R * w.cross(vec(s.antenna));
    const double stated2 = square(std::fmax(value[3], value[4])), noise2 = stated2 * s.fit(velocity).weight(event.t_s);
    const double known2 = P.larger(row_v), gain = known2 / (known2 + noise2);
    const Missed missed = missed_of(s, gain / (event.t_s - s.last_s[velocity]));
    const Vector3 a = missed.acceleration + R * w.cross(w.cross(vec(s.antenna)));
    // Tilt, heading and accelerometer bias change the missed acceleration; the tilt alone would look observed at rest, where both cancel. In the
    // search products of their errors and that of the latency are not small: with these rows consumer cable cars have a wrong tilt for 2.3 % of the
    // time instead of .4.
    const double late_s = free ? 0 : s.latency;
    m.put(0, row_v, Matrix3::Identity());
    m.put(0, row_phi, late_s * cross_matrix(Vector3(missed.acceleration - vec(s.gravity))) - cross_matrix(lever));
    m.put(0, row_accel, late_s * R);
    m.put(0, row_gyro, R * cross_matrix(vec(s.antenna)));
    m.put(0, row_antenna, R * cross_matrix(w));
    for (int i = 0; i < 3; ++i) m.R[i] = value[3 + i] * value[3 + i];
    for (int i = 0; i < 2; ++i) m.R[i] += square(north.sigma_rad) * z.head<2>().squaredNorm();
    if (free) {
        put_turned(m, z, s.u, &z);
        m.R[0] = m.R[1] = std::fmax(m.R[0], m.R[1]);
        // The latency times the error of the acceleration by the tilt, a product of errors.
        const double by_tilt = vec(s.gravity).squaredNorm() * P.larger(row_phi);
        for (double& r : m.R) r += P[row_latency][row_latency] * by_tilt;
    }
    put_latency(P, m, a);
    const Vector3 expected = vec(s.x + 3) + lever - s.latency * a - missed.noise;
    vec(m.r) = z - expected;
    use_absolute(s, P, event, m);
}

void Model::correct_position(State& s, Covariance& P, const Event& event) const {
    const double* value = event.value[position];
    const bool free = is_free(s);
    constexpr double lost2 = 0.35 * 0.35;
    // A given state may have any sigma, until samples contradict it. Kept for longer, one with a heading 170 deg off made 2 of 12 aircraft ready
    // within 150 s; so it is 12 of 12 (study ins --conditions state).
    const bool trusted = has_given_state(s) && !recovers(s);
    bool lost = P[row_phi + 2][row_phi + 2] > lost2 && !trusted && !is_elsewhere(s, event);
    if (free && position_jumped(s, event)) {
        ++s.inflated[position];
        s.note_refusal(position, true, event.t_s);
        const double off_m = vec(s.gates.jump).head<2>().norm();
        if (!outlasts(s, position, off_m, event.t_s)) return;
        lost = lost || first_were_wrong(s, position, event.t_s);
        if (!lost) accept_jump(s, P, position, off_m, event.t_s);
        vec(s.gates.jump).setZero();
    }
    if (lost) return restart_heading(s, P, event);
    const earth::Place place{value[0], value[1], value[2]};
    mat(s.fix_axes) = earth::axes_at(place);
    Measurement m{position, 3};
    Vector3 z = mat(s.axes).transpose() * (earth::position_of(place) - vec(s.anchor_e));
    const Vector3 lever = attitude(s) * vec(s.antenna), v = vec(s.x + 3);
    m.put(0, row_d, Matrix3::Identity());
    m.put(0, row_colour, Matrix3::Identity());
    m.put(0, row_phi, -cross_matrix(lever));
    m.put(0, row_antenna, attitude(s));
    for (int i = 0; i < 3; ++i) m.R[i] = value[3 + i] * value[3 + i];
    const Vector3 gained = s.latency * missed_of(s, 0).acceleration; // since the time of validity
    const Vector3 late = free ? Vector3(vec(s.in_t.gained)) : Vector3(v - 0.5 * gained);
    if (free) {
        put_turned(m, z, s.u, &z);
        m.R[0] = m.R[1] = std::fmax(m.R[0], m.R[1]);
        put_latency(P, m, late);
    } else {
        put_latency(P, m, v - gained);
        m.put(0, row_v, -s.latency * Matrix3::Identity());
    }
    vec(m.r) = z - (vec(s.x) + lever + vec(s.in_t.colour) - s.latency * late);
    use_absolute(s, P, event, m);
}

} // namespace hnav::ins
