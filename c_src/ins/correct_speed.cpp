// Wheel speed along the body, and the constraint that a car does not move across its wheels. While the heading is unknown the
// direction of the estimated velocity in the body is unknown too. Rows are then linearised about the velocity that the wheels
// measure, so that no heading is assumed.
#include "ins/model.hpp"

#include "maths/square.hpp"

namespace hnav::ins {
namespace {

// Velocity of the contact point of the wheels in body axes, and its Jacobian.
struct AtWheels {
    Matrix3 by_velocity, by_turn, by_gyro;
    Vector3 v_b;
    double turning, gain; // rate about z, acceleration along x
    double forward; // speed about which the rows are linearised
    double place2; // variance of the wheels' place in the body, per correction; an option of 0 means that it was not measured

    // forward_m_s: measured by the wheels; NaN: use the estimate.
    AtWheels(const State& s, const Vector3& wheel_b, double forward_m_s) {
        constexpr double measured_m = 0.1, unmeasured_m = 1;
        const Matrix3 R = attitude(s);
        const Vector3 v = vec(s.x + 3), rate = turn_rate(s);
        turning = rate[2];
        gain = R.col(0).dot(vec(s.in_t.mean_force) + vec(s.gravity));
        // The place does not change, so the corrections of a turn have the weight of one. Chosen: the time of a roundabout or some of a ramp. With
        // noise that is white the heading of simulated cars whose sensor is 1.2 m ahead of the axle is 2.5 deg off at a sigma of .5, so .3.
        constexpr double turn_s = 20;
        place2 = square(wheel_b.isZero() ? unmeasured_m : measured_m) * as_one(s, turn_s);
        by_velocity = R.transpose();
        by_gyro = cross_matrix(wheel_b);
        v_b = R.transpose() * v + rate.cross(wheel_b);
        forward = std::isnan(forward_m_s) ? v_b[0] : forward_m_s;
        const Vector3 about = std::isnan(forward_m_s) ? v : R * (Vector3(forward, 0, 0) - rate.cross(wheel_b));
        by_turn = R.transpose() * cross_matrix(about);
    }
    void put(Measurement& m, int row, int axis) const {
        for (int j = 0; j < 3; ++j) {
            m.H[row][row_v + j] = by_velocity(axis, j);
            m.H[row][row_phi + j] = by_turn(axis, j);
            m.H[row][row_gyro + j] = by_gyro(axis, j);
        }
    }
};

} // namespace

// Driven wheels slip during acceleration, and wheel speed has an unknown latency (late_s). The sideways place of the wheels has half
// the sigma of the lengthwise one, because a car is half as wide as it is long.
void Model::correct_speed(State& s, Covariance& P, const Event& event) const {
    const double* z = event.value[speed];
    const AtWheels at(s, vec(options_.wheel_b_m), is_free(s) ? z[0] : nan);
    if (is_free(s) && !(options_.car_across_m_s > 0)) return; // the body may move sideways
    Measurement m{speed, 1};
    at.put(m, 0, 0);
    for (int j = 0; j < errors; ++j) m.H[0][j] *= 1 + s.scale;
    m.H[0][row_scale] = at.forward;
    constexpr double late_s = 0.1;
    m.R[0] = z[1] * z[1] + late_s * late_s * at.gain * at.gain + at.turning * at.turning * at.place2 / 4;
    m.r[0] = z[0] - (1 + s.scale) * at.v_b[0];
    use(s, P, event, m);
}

// A car does not move sideways or up in its own axes, whose yaw and pitch in the body are states. Tyres slip in turns. The suspension
// lets the body pitch against the direction of travel for springs_s, so corrections within that time have the weight of one.
void Model::correct_car(State& s, Covariance& P, const Event& event) const {
    const bool measured = has_new(s, event, speed);
    if (!(options_.car_across_m_s > 0) || (is_free(s) && !measured)) return;
    const AtWheels at(s, vec(options_.wheel_b_m), is_free(s) ? event.value[speed][0] : nan);
    const double forward = at.forward, turning = at.turning;
    Measurement m{speed, 2};
    at.put(m, 0, 1);
    at.put(m, 1, 2);
    // In the car's axes, by the estimated mounting angles.
    Measurement ahead{speed};
    at.put(ahead, 0, 0);
    for (int j = 0; j < errors; ++j) {
        m.H[0][j] -= s.mount[0] * ahead.H[0][j];
        m.H[1][j] += s.mount[1] * ahead.H[0][j];
    }
    m.H[0][row_mount] = -forward;
    m.H[1][row_mount + 1] = forward;
    m.r[0] = -(at.v_b[1] - s.mount[0] * forward);
    m.r[1] = -(at.v_b[2] + s.mount[1] * forward);
    const double slip = 1 + 9 * turning * turning + 0.01 * forward * forward * turning * turning;
    m.R[0] = m.R[1] = options_.car_across_m_s * options_.car_across_m_s * slip + turning * turning * at.place2;
    constexpr double springs_rad = 0.01, springs_s = 2; // rad, s; chosen: cars pitch by 1 to 3 deg per g
    m.R[1] += square(springs_rad * forward) * as_one(s, springs_s);
    use(s, P, event, m);
}

} // namespace hnav::ins
