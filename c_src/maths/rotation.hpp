// The convention of the whole library.
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

#include "maths/covariance.hpp"

#include <Eigen/Geometry> // cross
#include <cmath>
#include <type_traits>

namespace hnav {

template <class R>
using Vector3Of = Eigen::Matrix<R, 3, 1>;
template <class R>
using Matrix3Of = Eigen::Matrix<R, 3, 3>;
template <class R>
using QuaternionOf = Eigen::Matrix<R, 4, 1>; // [q0 q1 q2 q3]
template <class R>
using Matrix43Of = Eigen::Matrix<R, 4, 3>;
template <class R>
using Matrix34Of = Eigen::Matrix<R, 3, 4>;

using Vector3 = Vector3Of<double>;
using Matrix3 = Matrix3Of<double>;
using Quaternion = QuaternionOf<double>;
using Matrix43 = Matrix43Of<double>;
using Matrix34 = Matrix34Of<double>;

// Functions here take their scalar from <R>, double unless said otherwise, and not from their arguments, which may be
// expressions: in Vector3Of<Exactly<R>> the compiler does not look for R.
template <class R>
using Exactly = std::common_type_t<R>;

template <class R = double>
inline QuaternionOf<R> multiply(const QuaternionOf<Exactly<R>>& a, const QuaternionOf<Exactly<R>>& b) {
    return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

template <class R = double>
inline QuaternionOf<R> conjugate(const QuaternionOf<Exactly<R>>& q) {
    return {q[0], -q[1], -q[2], -q[3]};
}

// Body to navigation, quadratic in q: not normalised, so that its derivative is exact off the unit sphere too.
template <class R = double>
inline Matrix3Of<R> rotation_matrix(const QuaternionOf<Exactly<R>>& q) {
    const R a = q[0], b = q[1], c = q[2], d = q[3];
    Matrix3Of<R> m;
    m << a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c), //
        2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b),  //
        2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d;
    return m;
}

// rotation_matrix(q) v without the matrix.
template <class R = double>
inline Vector3Of<R> rotate(const QuaternionOf<Exactly<R>>& q, const Vector3Of<Exactly<R>>& v) {
    const Vector3Of<R> r(q[1], q[2], q[3]);
    return (q[0] * q[0] - r.squaredNorm()) * v + 2 * (r.dot(v) * r + q[0] * r.cross(v));
}

// The derivative of rotation_matrix along dq. A quadratic's derivative is the difference of two values, exactly.
template <class R = double>
inline Matrix3Of<R> rotation_matrix_along(const QuaternionOf<Exactly<R>>& q, const QuaternionOf<Exactly<R>>& dq) {
    return R(0.5) * (rotation_matrix<R>(q + dq) - rotation_matrix<R>(q - dq));
}

// exp of half a rotation vector: the quaternion of the rotation phi.
template <class R = double>
inline QuaternionOf<R> rotation_quaternion(const Vector3Of<Exactly<R>>& phi) {
    const R angle2 = phi.squaredNorm();
    const R angle = std::sqrt(angle2);
    // sin(angle/2)/angle by its series where the quotient would lose digits
    const R s = angle > R(1e-4) ? std::sin(R(0.5) * angle) / angle : R(0.5) - angle2 / 48;
    return {std::cos(R(0.5) * angle), s * phi[0], s * phi[1], s * phi[2]};
}

// A turn at the constant body rate u over T seconds: its quaternion exp(u T / 2), and the integral of its rotation matrix,
//     integral over [0, T] of exp([u]x t) dt = T I + b [u]x + g [u]x^2,  b = (1 - cos x)/w^2, g = (x - sin x)/w^3, x = w T.
// T may be negative: the inverse rotation.
template <class R = double>
struct HeldTurn {
    QuaternionOf<R> q;
    Matrix3Of<R> integral;

    HeldTurn(const Vector3Of<R>& u, R T) {
        const R w2 = u.squaredNorm(), x2 = w2 * T * T;
        R c, s, b, g;        // cos(x/2), T sin(x/2)/x
        if (x2 < R(0.01)) { // series, exact to rounding: the quotients would lose digits
            const R y = R(0.25) * x2;
            c = 1 - y * (R(1.0 / 2) - y * (R(1.0 / 24) - y * (R(1.0 / 720) - y / 40320)));
            s = R(0.5) * T * (1 - y * (R(1.0 / 6) - y * (R(1.0 / 120) - y * (R(1.0 / 5040) - y / 362880))));
            b = T * T * (R(1.0 / 2) - x2 * (R(1.0 / 24) - x2 * (R(1.0 / 720) - x2 * (R(1.0 / 40320) - x2 / 3628800))));
            g = T * T * T * (R(1.0 / 6) - x2 * (R(1.0 / 120) - x2 * (R(1.0 / 5040) - x2 * (R(1.0 / 362880) - x2 / 39916800))));
        } else {
            const R w = std::sqrt(w2), half = R(0.5) * w * T, sin_half = std::sin(half);
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
template <class R = double>
inline Vector3Of<R> rotation_vector(const QuaternionOf<Exactly<R>>& q) {
    const R sine = q.template tail<3>().norm();
    const R angle = 2 * std::atan2(sine, std::fabs(q[0]));
    const R scale = sine > R(1e-8) ? angle / sine : 2;
    return (q[0] < 0 ? -scale : scale) * q.template tail<3>();
}

// Xi(q) u = 1/2 q (x) (0, u);  Xi' Xi = I/4 for unit q.
template <class R = double>
inline Matrix43Of<R> Xi(const QuaternionOf<Exactly<R>>& q) {
    Matrix43Of<R> m;
    m << -q[1], -q[2], -q[3], //
        q[0], -q[3], q[2],    //
        q[3], q[0], -q[1],    //
        -q[2], q[1], q[0];
    return R(0.5) * m;
}

// The same product, for one vector.
template <class R = double>
inline QuaternionOf<R> quaternion_rate(const QuaternionOf<Exactly<R>>& q, const Vector3Of<Exactly<R>>& u) {
    const R a = R(0.5) * u[0], b = R(0.5) * u[1], c = R(0.5) * u[2];
    return {-q[1] * a - q[2] * b - q[3] * c, q[0] * a - q[3] * b + q[2] * c, q[3] * a + q[0] * b - q[1] * c,
            -q[2] * a + q[1] * b + q[0] * c};
}

// Omega(u) q = 1/2 q (x) (0, u): the same product, as a matrix on q.
template <class R = double>
inline Square<4, R> Omega(const Vector3Of<Exactly<R>>& u) {
    Square<4, R> m;
    m << 0, -u[0], -u[1], -u[2], //
        u[0], 0, u[2], -u[1],    //
        u[1], -u[2], 0, u[0],    //
        u[2], u[1], -u[0], 0;
    return R(0.5) * m;
}

// across(q) d = (0, d) (x) q: a basis of the errors across q, orthonormal for unit q.
template <class R = double>
inline Matrix43Of<R> across(const QuaternionOf<Exactly<R>>& q) {
    Matrix43Of<R> m;
    m << -q[1], -q[2], -q[3], //
        q[0], q[3], -q[2],    //
        -q[3], q[0], q[1],    //
        q[2], -q[1], q[0];
    return m;
}

template <class R = double>
inline Matrix3Of<R> cross_matrix(const Vector3Of<Exactly<R>>& v) {
    Matrix3Of<R> m;
    m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
    return m;
}

// d(R_bn(q)' v)/dq: Jacobian of a navigation vector as the body sees it (corrected equation 16).
template <class R = double>
inline Matrix34Of<R> J_body_q(const QuaternionOf<Exactly<R>>& q, const Vector3Of<Exactly<R>>& v) {
    const R a = q[0], b = q[1], c = q[2], d = q[3];
    const R p0 = a * v[0] + d * v[1] - c * v[2];
    const R p1 = a * v[1] - d * v[0] + b * v[2];
    const R p2 = a * v[2] + c * v[0] - b * v[1];
    const R p3 = b * v[0] + c * v[1] + d * v[2];
    Matrix34Of<R> J;
    J << p0, p3, -p2, p1, //
        p1, p2, p3, -p0,  //
        p2, -p1, p0, p3;
    return 2 * J;
}

// Rotation order z y x. Corrected equation 17: the paper swaps the labels of pitch and roll.
template <class R = double>
inline Vector3Of<R> roll_pitch_yaw(const QuaternionOf<Exactly<R>>& q) {
    const R s = 2 * (q[0] * q[2] - q[3] * q[1]);
    return {std::atan2(2 * (q[0] * q[1] + q[2] * q[3]), 1 - 2 * (q[1] * q[1] + q[2] * q[2])),
            std::asin(std::fmin(R(1), std::fmax(R(-1), s))),
            std::atan2(2 * (q[0] * q[3] + q[1] * q[2]), 1 - 2 * (q[2] * q[2] + q[3] * q[3]))};
}

// Its derivative along dq at the unit quaternion q; that of a pitch of 90 degrees has no limit and is answered by 0.
template <class R = double>
inline Vector3Of<R> roll_pitch_yaw_along(const QuaternionOf<Exactly<R>>& q, const QuaternionOf<Exactly<R>>& dq) {
    const auto product = [&](int i, int j) { return 2 * q[i] * q[j]; };
    const auto along = [&](int i, int j) { return 2 * (dq[i] * q[j] + q[i] * dq[j]); };
    const auto angle = [](R y, R x, R dy, R dx) { return (x * dy - y * dx) / (x * x + y * y); }; // of atan2(y, x)
    const R s = product(0, 2) - product(3, 1), cosine2 = 1 - s * s;
    return {angle(product(0, 1) + product(2, 3), 1 - product(1, 1) - product(2, 2), along(0, 1) + along(2, 3),
                  -along(1, 1) - along(2, 2)),
            cosine2 > 0 ? (along(0, 2) - along(3, 1)) / std::sqrt(cosine2) : R(0),
            angle(product(0, 3) + product(1, 2), 1 - product(2, 2) - product(3, 3), along(0, 3) + along(1, 2),
                  -along(2, 2) - along(3, 3))};
}

template <class R = double>
inline QuaternionOf<R> quaternion_from_matrix(const Matrix3Of<Exactly<R>>& m) {
    const Eigen::Quaternion<R> e(m);
    return {e.w(), e.x(), e.y(), e.z()};
}

template <class R>
inline R wrap_angle(R a) {
    return std::remainder(a, R(2 * M_PI));
}

} // namespace hnav
