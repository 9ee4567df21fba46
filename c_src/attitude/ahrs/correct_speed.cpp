// Correction by a speed along body x, from GNSS, wheels or airspeed: two rows, the horizontal velocity of a body that moves where it
// points. Between two speeds the velocity is integrated from the force, so no bend and no brake tilts the horizon.
//
// The velocity error is v_true = exp(theta) v + error, whose transition contains gravity alone (Barrau and Bonnabel, IEEE Transactions
// on Automatic Control 62, 2017). A velocity given in body axes then has no row of the heading.
#include "attitude/ahrs/condition.hpp"
#include "estimation/gate.hpp"

namespace hnav {

void AhrsModel::correct_speed(State& s, Correction& c, const Event& event) const {
    const Vector2R ahead = rotation_matrix<R>(QuaternionR(s.x)).col(0).head<2>();
    const bool begins = !s.speed.is_fresh();
    const R since_s = R(options_.max_speed_age_s) - s.speed.left_s;
    s.speed.m_s = R(s.reversed ? -event.value[speed][0] : event.value[speed][0]);
    s.speed.sigma_m_s = R(event.value[speed][1]);
    s.speed.left_s = R(options_.max_speed_age_s);
    const Matrix2R noise = s.speed.covariance(ahead, R(options_.speed_slip_rad));
    if (begins) {
        begin_speed(s, c, noise);
        Eigen::Map<Vector2R>(s.velocity) = s.speed.m_s * ahead;
    } else {
        follow_speed(s, c, event.t_s, since_s, s.speed.m_s * ahead, noise);
    }
    const Vector3R tilt = c.rotation_variances();
    if (s.vehicle_tilt.is_possible()) s.vehicle_tilt.follow(std::max(tilt[0], tilt[1]), c.P(velocity, velocity));
}

// Velocity and tilt up to now are those of an unknown body, whose horizon a lasting acceleration may have tilted.
void AhrsModel::begin_speed(State& s, Correction& c, const Matrix2R& noise) {
    forget_velocity(s, c, noise);
    if (!s.vehicle_tilt.is_possible()) return;
    const R square = s.vehicle_tilt.square();
    diagonal<2>(c.P, rotation).array() += square;
    c.heading_variance() += tilted_field_variance(s);
    diagonal<2>(c.P, reference).array() += square;
}

void AhrsModel::follow_speed(State& s, Correction& c, double t_s, R since_s, const Vector2R& measured_n,
                             const Matrix2R& noise) const {
    constexpr R gate_nis = R(13.8); // 99.9 % of chi square with two degrees of freedom
    Eigen::Matrix<R, errors, 2> PHt;
    for (int k = 0; k < 2; ++k) PHt.col(k) = c.column(velocity + k);
    Matrix2R S = rows<2>(PHt, velocity) + noise;
    const Vector2R innovation = measured_n - Eigen::Map<Vector2R>(s.velocity) - segment<2>(c.error, velocity);
    InnovationOf<R>& i = record_velocity(s.innovation[speed], t_s, innovation, S);
    const R over = beyond_gate(i.nis, gate_nis);
    if (over > 1 && tilt_ready(s)) {
        i.noise_scale = 1 + (over - 1) * S.trace() / noise.trace();
        S *= over;
        ++s.gated[speed];
    }
    condition_on_velocity(s, c, PHt, S, innovation, since_s, &s.steps.evidence);
}

} // namespace hnav
