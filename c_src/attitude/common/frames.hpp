// Between the user's frames and the filter's own (rotation.hpp): mounting of the sensor, magnetic declination, and
// north-east-down or east-north-up. The rest of the library uses one frame only.
#pragma once

#include "maths/rotation.hpp"
#include "maths/scalar.hpp"

namespace hnav {

struct Frames {
    Quaternion user_from_internal{1, 0, 0, 0}; // magnetic north-east-down to the user's navigation frame
    Matrix3 navigation = Matrix3::Identity();  // the same as a matrix
    Matrix3 mounting = Matrix3::Identity();    // sensor to body
    double declination_rad = 0;
    bool same_navigation = true, same_body = true; // the usual case: no rotation is needed

    void set(bool east_north_up, double declination, const double* q_body_sensor) {
        declination_rad = declination;
        // Magnetic north is `declination` east of true north: a rotation about down.
        const Quaternion to_true_north = rotation_quaternion<Scalar>({0, 0, Scalar(declination)}).cast<double>();
        const double s = std::sqrt(0.5);
        const Quaternion enu_from_ned{0, s, s, 0};
        user_from_internal = east_north_up ? multiply(enu_from_ned, to_true_north) : to_true_north;
        navigation = rotation_matrix<Scalar>(user_from_internal.cast<Scalar>()).cast<double>();
        mounting = rotation_matrix<Scalar>(Quaternion(q_body_sensor).cast<Scalar>().normalized()).cast<double>();
        same_navigation = navigation == Matrix3::Identity();
        same_body = mounting == Matrix3::Identity();
    }

    Quaternion to_user(const Quaternion& q_internal) const {
        return same_navigation ? q_internal : multiply(user_from_internal, q_internal);
    }
    Quaternion to_internal(const Quaternion& q_user) const { return multiply(conjugate(user_from_internal), q_user); }
    void to_body(const double* sensor_axes, double* body_axes) const {
        Eigen::Map<Vector3> v(body_axes);
        v = Vector3(sensor_axes);
        if (!same_body) v = mounting * Vector3(v);
    }
    // Variances about the user's navigation axes, from the covariance about the internal ones.
    template <class R>
    Vector3Of<R> variances_to_user(const Matrix3Of<R>& internal) const {
        if (same_navigation) return internal.diagonal();
        const Matrix3Of<R> N = navigation.cast<R>();
        return (N * internal * N.transpose()).diagonal();
    }
};

} // namespace hnav
