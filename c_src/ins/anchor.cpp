// Moves the anchor with the body, so that displacements stay small: a constant rotation and shift between two events.
#include "ins/model.hpp"

namespace hnav::ins {
namespace {

void turn_vector(const Matrix3& C, double* v) { vec(v) = Vector3(C * vec(v)); }

} // namespace

void turn(State& s, const Matrix3& C) {
    for (double* v : {s.x, s.x + 3}) turn_vector(C, v);
    quat(s.x + 6) = multiply(quaternion_from_matrix(C), quat(s.x + 6)).normalized();
    double* const first = s.in_t.colour;
    for (std::size_t i = 0; i < sizeof s.in_t / sizeof *first; i += 3) turn_vector(C, first + i);
}

void turn(Covariance& P, const Matrix3& C) {
    for (const int row : {row_d, row_v, row_phi, row_colour}) turn_rows(P, row, C);
}

void Model::move_anchor(State& s, Covariance& P) const {
    const Vector3 d = vec(s.x);
    if (!(d.squaredNorm() > options_.anchor_distance_m * options_.anchor_distance_m)) return;
    const Matrix3 before = mat(s.axes);
    const Vector3 e = vec(s.anchor_e) + before * d;
    const Matrix3 after = earth::axes_at(earth::place_of(e));
    const Matrix3 C = after.transpose() * before;
    vec(s.anchor_e) = e;
    mat(s.axes) = after;
    vec(s.earth_rate) = after.transpose() * Vector3(0, 0, earth::rate_rad_s);
    turn(s, C);
    turn(P, C);
    vec(s.x).setZero();
}

} // namespace hnav::ins
