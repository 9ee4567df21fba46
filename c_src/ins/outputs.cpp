// Outputs: always those of the likeliest heading, with the spread over the whole circle.
#include "estimation/readiness.hpp"
#include "ins/model.hpp"

namespace hnav::ins {

Protection protection_of(const Vector3& sigma_position, double sigma_heading, double lie, const double* slow_m) {
    constexpr double sigmas = 5; // tails are heavier than Gaussian: 1e-3 of the errors exceed 4.3 sigmas, not 3.3
    return {sigmas * lie * sigma_position.head<2>().maxCoeff() + slow_m[0], sigmas * lie * sigma_position[2] + slow_m[1],
            std::fmin(M_PI, sigmas * lie * sigma_heading)};
}

Covariance Model::covariance_at(const State& s, double ahead_s) const {
    State now = s;
    if (ahead_s > 0 && flows(s)) {
        gather(now, ahead_s);
        const double silent_s = s.last_event_s - s.last_s[imu];
        now.window.gap.add(silent_s, silent_s + ahead_s, s.usual_interval_s, s.rest.rate2, s.rest.force2);
    }
    Covariance P = Covariance::of(now);
    propagate(now, P, now.mean);
    if (is_free(s)) P = given_circle(now, P);
    return P;
}

namespace {

// Positions move as the velocities predict, or the velocities were found wrong.
bool aids_agree(const State& s, double now_s) {
    return s.contradiction.verdict == Contradiction::velocity_wrong || s.aids.holds(now_s);
}

// A single refusal is an outlier.
bool are_refused(const State& s, int channel) { return s.refused_in_row[channel] > 1; }

// The IMU sends samples, and no monitor has found an inconsistency for consistent_for_s. A given start state needs no aids.
bool is_consistent(const State& s, double now_s, bool given) {
    constexpr double silent_s = 1, consistent_for_s = 2;
    const bool open = are_refused(s, velocity) && s.contradiction.verdict != Contradiction::velocity_wrong;
    return s.started() && !open && !has_passed(now_s - s.last_s[imu], silent_s) &&
           has_passed(now_s - s.inconsistent_s, consistent_for_s) && (given || aids_agree(s, now_s));
}

// Positions that are refused, or have departed from the integrated velocity by more than this limit, are not reliable.
bool places_agree(const State& s, double limit_m) {
    constexpr double far = 5;
    const double off_m = vec(s.in_t.colour).head<2>().norm();
    return !are_refused(s, position) && s.fit(position).bias() < usual_bias && off_m < std::fmax(limit_m, far * s.slow_m[0]);
}

void put_protection(const State& s, Navigation* n) {
    double misfit = std::fmax(1, s.nis_mean);
    for (const Consistency& fit : s.fits) misfit = std::fmax(misfit, fit.bias() / usual_bias);
    const Vector3 colour = vec(s.in_t.colour);
    const double slow_m[] = {std::fmax(0, colour.head<2>().norm() - usual_colour * s.slow_m[0]),
                             std::fmax(0, std::fabs(colour[2]) - usual_colour * s.slow_m[1])};
    n->protection = protection_of(n->sigma_position, n->sigma_rotation[2], std::sqrt(misfit), slow_m);
}

} // namespace

// Samples have contradicted the state, and the information that a ready heading needs has not been gathered since.
bool Model::recovers(const State& s) const {
    return !std::isinf(s.inconsistent_s) && !is_earned(s.information_heading, options_.ready_heading_rad);
}

void Model::put_readiness(const State& s, double now_s, Navigation* n) const {
    constexpr double fresh_s = 60;
    const bool alive = is_consistent(s, now_s, has_given_state(s));
    const double fixed_s = std::fmax(s.last_s[position], std::fmax(s.last_s[velocity], s.last_s[ins::rest]));
    const bool fixed = alive && (is_within(now_s - fixed_s, fresh_s) || at_rest(s, now_s));
    const double tilt = std::fmax(n->sigma_rotation[0], n->sigma_rotation[1]);
    const double lie = std::sqrt(std::fmax(1, s.nis_mean));
    n->tilt_ready = alive && tilt * lie < options_.ready_tilt_rad && is_earned(s.information_tilt, options_.ready_tilt_rad);
    n->heading_ready = alive && has_lasted(now_s - s.heading_since_s, options_.ready_hold_s) &&
                       n->sigma_rotation[2] * lie < options_.ready_heading_rad &&
                       is_earned(s.information_heading, options_.ready_heading_rad);
    n->velocity_ready = fixed && n->sigma_velocity.maxCoeff() * lie < options_.ready_velocity_m_s &&
                        is_earned(s.information_velocity, options_.ready_velocity_m_s);
    n->position_ready = fixed && places_agree(s, options_.ready_position_m) &&
                        n->sigma_position.head<2>().maxCoeff() * lie < options_.ready_position_m &&
                        (has_given_place(s) || is_earned(s.information_position, options_.ready_position_m));
}

Matrix3 show_motion(const State& s, const Matrix3& to_earth, Motion* motion) {
    motion->position_e = vec(s.anchor_e) + to_earth * displacement(s);
    motion->velocity_e = to_earth * vec(s.x + 3);
    motion->place = earth::place_of(motion->position_e);
    const Matrix3 to_north = earth::axes_at(motion->place).transpose() * to_earth;
    motion->velocity_n = to_north * vec(s.x + 3);
    motion->q_nb = multiply(quaternion_from_matrix(to_north), quat(s.x + 6)).normalized();
    return to_north;
}

Matrix3 to_earth_axes(const State& s) {
    const Quaternion turn = rotation_quaternion(Vector3(0, 0, is_free(s) ? s.circle.mode_rad : 0));
    return mat(s.axes) * rotation_matrix(turn);
}

Motion motion_of(const State& s) {
    Motion motion;
    show_motion(s, to_earth_axes(s), &motion);
    return motion;
}

// North, east and down turn while the body moves over the Earth.
MotionAlong motion_along(const State& s, const double* direction) {
    Motion now;
    const Matrix3 to_north = show_motion(s, to_earth_axes(s), &now);
    MotionAlong along;
    along.place = earth::place_along(now.place, to_north * vec(direction));
    const Vector3 turn_n = earth::turn_along(now.place, along.place);
    along.velocity_n = to_north * vec(direction + 3) - turn_n.cross(now.velocity_n);

    const double length = quat(s.x + 6).norm();
    const Quaternion q = quat(s.x + 6) / length;
    Quaternion change = quat(direction + 6) / length;
    change -= q * q.dot(change); // only the direction of the quaternion is shown
    along.q_nb = multiply(quaternion_from_matrix(to_north), change) - 0.5 * across(now.q_nb) * turn_n;
    along.euler = roll_pitch_yaw_along(now.q_nb, along.q_nb);
    return along;
}

Vector3 sigmas_along(const Matrix3& to_axes, const Matrix3& P) {
    const Vector3 variances = (to_axes * P * to_axes.transpose()).diagonal();
    return variances.cwiseMax(0).cwiseSqrt();
}

Navigation Model::navigation(const State& s, double ahead_s, double now_s) const {
    const Covariance P = covariance_at(s, ahead_s);
    Navigation n{};
    const Matrix3 to_north = show_motion(s, to_earth_axes(s), &n);
    const auto sigma = [&](int row) { return sigmas_along(to_north, P.block(row, row)); };
    n.sigma_position = sigma(row_d);
    n.sigma_velocity = sigma(row_v);
    n.sigma_rotation = sigma(row_phi);
    if (is_free(s)) {
        // The chord underestimates the arc of a wide distribution.
        const double spread = s.circle.spread_rad;
        n.sigma_rotation[2] = std::sqrt(P[row_phi + 2][row_phi + 2] + std::fmax(0, spread * spread - s.circle.square[2]));
    }
    n.circle = s.circle;
    if (!is_free(s)) n.circle = {0, n.sigma_rotation[2], 0, 0, {0, 0, 0}};
    n.circle.mode_rad = roll_pitch_yaw(n.q_nb)[2];
    if (is_free(s)) n.circle.second_rad = wrap_angle(n.circle.mode_rad + s.circle.second_rad - s.circle.mode_rad);

    put_readiness(s, now_s, &n);
    put_protection(s, &n);
    // After an inconsistency there is no bound until the gathered information is sufficient for a ready heading again.
    if (recovers(s) || !is_consistent(s, now_s, has_given_state(s))) n.protection.heading_rad = M_PI;
    return n;
}

} // namespace hnav::ins
