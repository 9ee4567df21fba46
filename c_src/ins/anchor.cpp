// The anchor moves along, so that displacements stay small: a constant turn and shift between two events.
#include "ins/model.hpp"

namespace hnav::ins {

void Model::move_anchor(State& s, Covariance& P) const {
    const Vector3 d = vec(s.x);
    if (!(d.squaredNorm() > settings_.anchor_distance_m * settings_.anchor_distance_m)) return;
    const Matrix3 before = mat(s.axes);
    const Vector3 e = vec(s.anchor_e) + before * d;
    const Matrix3 after = earth::axes_at(earth::place_of(e));
    const Matrix3 C = after.transpose() * before;
    vec(s.anchor_e) = e;
    mat(s.axes) = after;
    vec(s.earth_rate) = after.transpose() * Vector3(0, 0, earth::rate_rad_s);
    vec(s.x).setZero();
    vec(s.x + 3) = Vector3(C * vec(s.x + 3));
    vec(s.felt) = Vector3(C * vec(s.felt));
    vec(s.lately) = Vector3(C * vec(s.lately));
    quat(s.x + 6) = multiply(quaternion_from_matrix(C), quat(s.x + 6)).normalized();
    vec(s.colour) = Vector3(C * vec(s.colour));
    turn_field_memory(C, s);
    for (const int row : {row_d, row_v, row_phi, row_colour}) turn_rows(P, row, C);
}

} // namespace hnav::ins
