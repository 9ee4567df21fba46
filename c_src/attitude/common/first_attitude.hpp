// The attitude to start from, and the reference field that goes with it.
#pragma once

#include "maths/rotation.hpp"

namespace hnav {

// TRIAD (Black 1964): specific force tells down, the field's part across it tells magnetic north. False when they are
// parallel to within about a thousandth of a radian: then there is no heading in them.
inline bool triad(const Vector3& force_b, const Vector3& field_b, Quaternion* q) {
    const Vector3 down = -force_b.normalized();
    const Vector3 across = down.cross(field_b.normalized());
    if (!(across.norm() > 1e-3)) return false;
    const Vector3 east = across.normalized();
    Matrix3 R_bn; // its rows are the navigation axes in the body
    R_bn << east.cross(down).transpose(), east.transpose(), down.transpose();
    *q = quaternion_from_matrix(R_bn);
    return true;
}

// Tilt from specific force, heading (of body x, about down, from magnetic north) given.
inline Quaternion level_with_heading(const Vector3& force_b, double heading_rad) {
    const Vector3 up = force_b.normalized();
    const double roll = std::atan2(-up[1], -up[2]);
    const double pitch = std::atan2(up[0], std::hypot(up[1], up[2]));
    const Quaternion yaw_q = rotation_quaternion({0, 0, heading_rad});
    const Quaternion pitch_q = rotation_quaternion({0, pitch, 0});
    const Quaternion roll_q = rotation_quaternion({roll, 0, 0});
    return multiply(multiply(yaw_q, pitch_q), roll_q);
}

// Strength and dip of a field seen by a body of attitude q. Its azimuth defines magnetic north, so none is learnt.
struct ReferenceField {
    double strength;
    double dip_rad;
};

inline ReferenceField learn_reference(const Quaternion& q, const Vector3& field_b) {
    const Vector3 field_n = rotation_matrix(q) * field_b;
    return {field_b.norm(), std::atan2(field_n[2], std::hypot(field_n[0], field_n[1]))};
}

} // namespace hnav
