// THE convention, stated here once.
//
//   n  navigation frame north-east-down, x towards magnetic north
//   b  body frame, the axes of the sensor after mounting
//   q  Hamilton quaternion [q0 q1 q2 q3], scalar first, body to navigation:  v_n = R_bn(q) v_b
//   f  specific force; level and at rest f_b = (0, 0, -g)
//   m  magnetic field; m_n = (cos dip, 0, sin dip) in units of its strength
//
// Kinematics (corrected equation 9 of the paper):  q' = 1/2 q (x) (0, u) = Xi(q) u = Omega(u) q.
// East-north-up exists only at the interface (frames.hpp).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry> // cross
#include <cmath>

namespace hnav {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Quaternion = Eigen::Vector4d; // [q0 q1 q2 q3]
using Matrix43 = Eigen::Matrix<double, 4, 3>;
using Matrix34 = Eigen::Matrix<double, 3, 4>;

inline Quaternion multiply(const Quaternion& a, const Quaternion& b) {
    return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

inline Quaternion conjugate(const Quaternion& q) { return {q[0], -q[1], -q[2], -q[3]}; }

// Body to navigation, quadratic in q: not normalised, so that its derivative is exact off the unit sphere too.
inline Matrix3 rotation_matrix(const Quaternion& q) {
    const double a = q[0], b = q[1], c = q[2], d = q[3];
    Matrix3 R;
    R << a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c), //
        2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b),  //
        2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d;
    return R;
}

// exp of half a rotation vector: the quaternion of the rotation phi.
inline Quaternion rotation_quaternion(const Vector3& phi) {
    const double angle2 = phi.squaredNorm();
    const double angle = std::sqrt(angle2);
    // sin(angle/2)/angle by its series where the quotient would lose digits
    const double s = angle > 1e-4 ? std::sin(0.5 * angle) / angle : 0.5 - angle2 / 48;
    return {std::cos(0.5 * angle), s * phi[0], s * phi[1], s * phi[2]};
}

// A turn at the constant body rate u over T seconds: its quaternion exp(u T / 2), and the integral of its rotation matrix,
//     integral over [0, T] of exp([u]x t) dt = T I + b [u]x + g [u]x^2,  b = (1 - cos x)/w^2, g = (x - sin x)/w^3, x = w T.
// T may be negative: the turn that undoes.
struct HeldTurn {
    Quaternion q;
    Matrix3 integral;

    HeldTurn(const Vector3& u, double T) {
        const double w2 = u.squaredNorm(), x2 = w2 * T * T;
        double c, s, b, g; // cos(x/2), T sin(x/2)/x
        if (x2 < 0.01) { // series, exact to rounding: the quotients would lose digits
            const double y = 0.25 * x2;
            c = 1 - y * (1.0 / 2 - y * (1.0 / 24 - y * (1.0 / 720 - y / 40320)));
            s = 0.5 * T * (1 - y * (1.0 / 6 - y * (1.0 / 120 - y * (1.0 / 5040 - y / 362880))));
            b = T * T * (1.0 / 2 - x2 * (1.0 / 24 - x2 * (1.0 / 720 - x2 * (1.0 / 40320 - x2 / 3628800))));
            g = T * T * T * (1.0 / 6 - x2 * (1.0 / 120 - x2 * (1.0 / 5040 - x2 * (1.0 / 362880 - x2 / 39916800))));
        } else {
            const double w = std::sqrt(w2), half = 0.5 * w * T, sin_half = std::sin(half);
            c = std::cos(half);
            s = sin_half / w;
            b = 2 * sin_half * sin_half / w2;
            g = (w * T - 2 * sin_half * c) / (w2 * w);
        }
        q = {c, s * u[0], s * u[1], s * u[2]};
        // [u]x^2 = u u' - w^2 I
        integral = g * u * u.transpose();
        integral.diagonal().array() += T - g * w2;
        integral(0, 1) -= b * u[2];
        integral(0, 2) += b * u[1];
        integral(1, 0) += b * u[2];
        integral(1, 2) -= b * u[0];
        integral(2, 0) -= b * u[1];
        integral(2, 1) += b * u[0];
    }
};

// The rotation vector of a unit quaternion, no longer than pi.
inline Vector3 rotation_vector(const Quaternion& q) {
    const double sine = q.tail<3>().norm();
    const double angle = 2 * std::atan2(sine, std::fabs(q[0]));
    const double scale = sine > 1e-8 ? angle / sine : 2;
    return (q[0] < 0 ? -scale : scale) * q.tail<3>();
}

// Xi(q) u = 1/2 q (x) (0, u);  Xi' Xi = I/4 for unit q.
inline Matrix43 Xi(const Quaternion& q) {
    Matrix43 m;
    m << -q[1], -q[2], -q[3], //
        q[0], -q[3], q[2],    //
        q[3], q[0], -q[1],    //
        -q[2], q[1], q[0];
    return 0.5 * m;
}

inline Matrix3 cross_matrix(const Vector3& v) {
    Matrix3 m;
    m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
    return m;
}

// d(R_bn(q)' v)/dq: Jacobian of a navigation vector as the body sees it (corrected equation 16).
inline Matrix34 J_body_q(const Quaternion& q, const Vector3& v) {
    const double a = q[0], b = q[1], c = q[2], d = q[3];
    const double p0 = a * v[0] + d * v[1] - c * v[2];
    const double p1 = a * v[1] - d * v[0] + b * v[2];
    const double p2 = a * v[2] + c * v[0] - b * v[1];
    const double p3 = b * v[0] + c * v[1] + d * v[2];
    Matrix34 J;
    J << p0, p3, -p2, p1, //
        p1, p2, p3, -p0,  //
        p2, -p1, p0, p3;
    return 2 * J;
}

// Rotation order z y x. Corrected equation 17: the paper swaps the labels of pitch and roll.
inline Vector3 roll_pitch_yaw(const Quaternion& q) {
    const double s = 2 * (q[0] * q[2] - q[3] * q[1]);
    return {std::atan2(2 * (q[0] * q[1] + q[2] * q[3]), 1 - 2 * (q[1] * q[1] + q[2] * q[2])),
            std::asin(std::fmin(1.0, std::fmax(-1.0, s))),
            std::atan2(2 * (q[0] * q[3] + q[1] * q[2]), 1 - 2 * (q[2] * q[2] + q[3] * q[3]))};
}

inline Quaternion quaternion_from_matrix(const Matrix3& R) {
    const Eigen::Quaterniond e(R);
    return {e.w(), e.x(), e.y(), e.z()};
}

inline double wrap_angle(double a) { return std::remainder(a, 2 * M_PI); }

} // namespace hnav
