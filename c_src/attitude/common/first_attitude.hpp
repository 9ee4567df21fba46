// The attitude to start from, and the reference field that goes with it.
#pragma once

#include "maths/rotation.hpp"

namespace hnav {

// TRIAD (Black 1964): the specific force determines down, the horizontal part of the field magnetic north. Returns false if both are
// parallel to within about 0.001 rad, because then the heading is undetermined.
template <class R = double>
inline bool triad(const Vector3Of<Exactly<R>>& force_b, const Vector3Of<Exactly<R>>& field_b, QuaternionOf<R>* q) {
    const Vector3Of<R> down = -force_b.normalized();
    const Vector3Of<R> across_both = down.cross(field_b.normalized());
    if (!(across_both.norm() > R(1e-3))) return false;
    const Vector3Of<R> east = across_both.normalized();
    Matrix3Of<R> R_bn; // its rows are the navigation axes in the body
    R_bn << east.cross(down).transpose(), east.transpose(), down.transpose();
    *q = quaternion_from_matrix<R>(R_bn);
    return true;
}

// Tilt from specific force, heading (of body x, about down, from magnetic north) given.
template <class R = double>
inline QuaternionOf<R> level_with_heading(const Vector3Of<Exactly<R>>& force_b, Exactly<R> heading_rad) {
    const Vector3Of<R> up = force_b.normalized();
    const R roll = std::atan2(-up[1], -up[2]);
    const R pitch = std::atan2(up[0], std::hypot(up[1], up[2]));
    const QuaternionOf<R> yaw_q = rotation_quaternion<R>({0, 0, heading_rad});
    const QuaternionOf<R> pitch_q = rotation_quaternion<R>({0, pitch, 0});
    const QuaternionOf<R> roll_q = rotation_quaternion<R>({roll, 0, 0});
    return multiply<R>(multiply<R>(yaw_q, pitch_q), roll_q);
}

// Strength and dip of a field seen by a body of attitude q. Its azimuth defines magnetic north, so none is learnt.
template <class R>
struct ReferenceFieldOf {
    R strength;
    R dip_rad;
};
using ReferenceField = ReferenceFieldOf<double>;

template <class R = double>
inline ReferenceFieldOf<R> learn_reference(const QuaternionOf<Exactly<R>>& q, const Vector3Of<Exactly<R>>& field_b) {
    const Vector3Of<R> field_n = rotation_matrix<R>(q) * field_b;
    return {field_b.norm(), std::atan2(field_n[2], std::hypot(field_n[0], field_n[1]))};
}

} // namespace hnav
