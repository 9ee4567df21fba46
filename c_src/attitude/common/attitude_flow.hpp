// The continuous states of AHRS and HREKF between events, at the held rate u: q 4; A 9, the integral of R_bn since the last correction, column
// by column; t 1, its time.
//
//   q' = 1/2 q (x) (0, u), A' = R_bn(q), t' = 1
#pragma once

#include "maths/rotation.hpp"

#include <algorithm>

namespace hnav {

template <class R>
struct AttitudeFlow {
    static constexpr int A = 4, t = 13, nx = 14; // places in x

    // flows: the attitude has started.
    static void derivative(bool flows, const Vector3Of<R>& u, const R* x, R* dx) {
        if (!flows) return std::fill(dx, dx + nx, R(0));
        const QuaternionOf<R> q(x);
        Eigen::Map<QuaternionOf<R>> q_rate(dx);
        q_rate = quaternion_rate<R>(q, u);
        Eigen::Map<Matrix3Of<R>>(dx + A) = rotation_matrix<R>(q);
        dx[t] = 1;
    }

    // The derivative of that along a direction.
    static void along(bool flows, const Vector3Of<R>& u, const R* x, const R* direction, R* out) {
        if (!flows) return std::fill(out, out + nx, R(0));
        const QuaternionOf<R> q(x), dq(direction);
        Eigen::Map<QuaternionOf<R>> q_rate(out);
        q_rate = quaternion_rate<R>(dq, u);
        Eigen::Map<Matrix3Of<R>>(out + A) = rotation_matrix_along<R>(q, dq);
        out[t] = 0;
    }

    // Over an interval, exact, because the rate is held.
    static void exactly(const Vector3Of<R>& u, R T, R* x) {
        const HeldTurn<R> turn(u, T);
        const QuaternionOf<R> q(x);
        Eigen::Map<Matrix3Of<R>>(x + A).noalias() += rotation_matrix<R>(q) * turn.integral;
        Eigen::Map<QuaternionOf<R>> turned(x);
        turned = multiply<R>(q, turn.q);
        x[t] += T;
    }
};

} // namespace hnav
