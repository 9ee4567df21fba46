// The rate at which a correction makes the filter forget: the solver-free figure of the stability certificate.
//
// Two estimates with the same gains and samples differ by e = (d, e_b): d the vector part of e_q (x) q*, in navigation
// axes, e_b the difference of the biases, in body axes. From just after one correction to just after the next
//     flow    d- = d - 1/2 A e_b,   A = integral of R_nb over the interval: in these axes nothing else moves
//     jump    d+ = N(q+)' (I - K_q H_q) N(q-) d- / |q + K nu|,   e_b+ = e_b - K_b H_q N(q-) d-,   N(q) d = (0, d) (x) q
// together e+ = M e. The rate is -ln |L+^-1 M L| / T with P = L L' the filter's covariance after the correction before
// and P+ = L+ L+' after this one: sqrt(e' P^-1 e) falls at least so fast. A correction keeps what that takes; the rate
// itself is computed for who asks. Sampled-data form of Theorem 1 of the paper (hrekf_model.hpp), one P for each correction.
#pragma once

#include "maths/covariance.hpp"
#include "maths/rotation.hpp"

namespace hnav {

// Part of a filter's state: numbers only.
struct ErrorMap {
    double before[21], after[21]; // P and P+ of e, upper triangles
    double M[36];                 // column-major
    double bias_path[9];          // A since the last correction, column-major, s
    double interval_s;            // that M spans
    double flown_to_s;            // end of bias_path
};

// Basis of the quaternion errors across q: N(q) d = (0, d) (x) q; orthonormal for unit q.
inline Matrix43 across(const Quaternion& q) {
    Matrix43 N;
    N << -q[1], -q[2], -q[3], //
        q[0], q[3], -q[2],    //
        -q[3], q[0], q[1],    //
        q[2], -q[1], q[0];
    return N;
}

// Of (d, e_b), from that of (q, b).
inline Square<6> across_covariance(const Matrix43& N, const Square<7>& P) {
    Square<6> C;
    C.topLeftCorner<3, 3>().noalias() = N.transpose() * (P.topLeftCorner<4, 4>() * N).eval();
    C.topRightCorner<3, 3>().noalias() = N.transpose() * P.topRightCorner<4, 3>();
    C.bottomLeftCorner<3, 3>() = C.topRightCorner<3, 3>().transpose();
    C.bottomRightCorner<3, 3>() = P.bottomRightCorner<3, 3>();
    return C;
}

// An attitude was found: no rate until the next correction.
inline void begin_error_map(ErrorMap& e, double t_s, const Quaternion& q, const Square<7>& P) {
    pack<6>(across_covariance(across(q), P), e.after);
    Eigen::Map<Square<6>>(e.M).setIdentity();
    Eigen::Map<Matrix3>(e.bias_path).setZero();
    e.interval_s = 0;
    e.flown_to_s = t_s;
}

// The held rate u brought the attitude to q at t_s: R_nb(t_s - t) = R_nb(t_s) exp(-[u]x t), whatever the integrator.
inline void flow_error_map(ErrorMap& e, double t_s, const Quaternion& q, const Vector3& u) {
    const double T = t_s - e.flown_to_s;
    if (!(T > 0)) return;
    Eigen::Map<Matrix3>(e.bias_path).noalias() += rotation_matrix(q) * HeldTurn(-u, T).integral;
    e.flown_to_s = t_s;
}

// The correction KH = K H_q took the unit quaternion q_minus to q_plus, its sum being `norm` long; P is that after it.
// interval_s: since the correction before; 0 for a second one at the same instant, which joins the first.
inline void jump_error_map(ErrorMap& e, double interval_s, const Eigen::Matrix<double, 7, 4>& KH, const Quaternion& q_minus,
                           const Quaternion& q_plus, double norm, const Square<7>& P) {
    const Matrix43 before = across(q_minus), after = across(q_plus);
    const Eigen::Matrix<double, 7, 3> seen = KH * before;
    Eigen::Matrix<double, 6, 3> D;
    D.topRows<3>().noalias() = after.transpose() * (before - seen.topRows<4>()) / norm;
    D.bottomRows<3>() = -seen.bottomRows<3>();

    Eigen::Map<Square<6>> M(e.M);
    Eigen::Map<Matrix3> path(e.bias_path);
    Square<6> step;
    step.leftCols<3>() = D;
    step.rightCols<3>().noalias() = -0.5 * D * path;
    step.bottomRightCorner<3, 3>().diagonal().array() += 1;
    if (interval_s > 0) {
        M = step;
        for (int i = 0; i < 21; ++i) e.before[i] = e.after[i];
        e.interval_s = interval_s;
    } else {
        M = (step * M).eval();
    }
    pack<6>(across_covariance(after, P), e.after);
    path.setZero();
}

// 1/s; 0 before the first correction and while a covariance is singular. Negative when the gains do not belong to P.
double decay_rate(const ErrorMap& e);

} // namespace hnav
