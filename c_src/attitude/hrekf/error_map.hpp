// How the difference of two estimates goes over one correction: what the decay rate (decay_rate.hpp) is computed from.
//
// Two estimates with the same gains and samples differ by e = (d, e_b): d the vector part of e_q (x) q*, in navigation
// axes, e_b the difference of the biases, in body axes. From just after one correction to just after the next
//     flow    d- = d - 1/2 A e_b,   A = integral of R_nb over the interval: in these axes nothing else moves
//     jump    d+ = N(q+)' (I - K_q H_q) N(q-) d- / |q + K nu|,   e_b+ = e_b - K_b H_q N(q-) d-,   N(q) d = (0, d) (x) q
// together e+ = M e.
#pragma once

#include "maths/blocks.hpp"
#include "maths/rotation.hpp"
#include "maths/scalar.hpp"

namespace hnav {

// Part of a filter's state: numbers only.
template <class R>
struct ErrorMap {
    // After the correction before and after this one: q, and the upper triangle of the covariance of (q, b).
    struct Corrected {
        R q[4], P[28];
    } before, after;
    R M[36];                 // column-major
    R bias_path[9];          // A since the last correction, column-major, s
    double interval_s;       // that M spans
    double flown_to_s;       // end of bias_path

    // An attitude was found: no rate until the next correction.
    void begin(double t_s, const QuaternionOf<R>& q, const R* P);

    // The held rate u brought the attitude to q at t_s: R_nb(t_s - t) = R_nb(t_s) exp(-[u]x t), whatever the integrator.
    void flow(double t_s, const QuaternionOf<R>& q, const Vector3Of<R>& u);

    // The correction KHN = K H_q N(q_minus) took the unit quaternion q_minus to q_plus, its sum being `norm` long; P, an upper
    // triangle, is that after it.
    // since_s: the correction before; 0 for a second one at the same instant, which joins the first.
    void jump(double since_s, const Eigen::Matrix<R, 7, 3>& KHN, const QuaternionOf<R>& q_minus, const QuaternionOf<R>& q_plus,
              R norm, const R* P);

private:
    void keep(const QuaternionOf<R>& q, const R* P) {
        for (int i = 0; i < 4; ++i) after.q[i] = q[i];
        for (int i = 0; i < 28; ++i) after.P[i] = P[i];
    }
};

extern template struct ErrorMap<Scalar>; // decay_rate.cpp

// The covariance of (d, e_b), from that of (q, b).
template <class R>
inline Square<6, R> error_map_covariance(const typename ErrorMap<R>::Corrected& corrected) {
    const Matrix43Of<R> N = across<R>(QuaternionOf<R>(corrected.q));
    const Square<7, R> P = unpack<7>(corrected.P);
    Square<6, R> C;
    block<3, 3>(C, 0, 0).noalias() = N.transpose() * (block<4, 4>(P, 0, 0) * N).eval();
    block<3, 3>(C, 0, 3).noalias() = N.transpose() * block<4, 3>(P, 0, 4);
    block<3, 3>(C, 3, 0) = block<3, 3>(C, 0, 3).transpose();
    block<3, 3>(C, 3, 3) = block<3, 3>(P, 4, 4);
    return C;
}

template <class R>
void ErrorMap<R>::begin(double t_s, const QuaternionOf<R>& q, const R* P) {
    keep(q, P);
    Eigen::Map<Square<6, R>>(M).setIdentity();
    Eigen::Map<Matrix3Of<R>>(bias_path).setZero();
    interval_s = 0;
    flown_to_s = t_s;
}

template <class R>
void ErrorMap<R>::flow(double t_s, const QuaternionOf<R>& q, const Vector3Of<R>& u) {
    const R T = R(t_s - flown_to_s);
    if (!(T > 0)) return;
    Eigen::Map<Matrix3Of<R>>(bias_path).noalias() += rotation_matrix<R>(q) * HeldTurn<R>(-u, T).integral;
    flown_to_s = t_s;
}

template <class R>
void ErrorMap<R>::jump(double since_s, const Eigen::Matrix<R, 7, 3>& KHN, const QuaternionOf<R>& q_minus,
                       const QuaternionOf<R>& q_plus, R norm, const R* P) {
    Eigen::Matrix<R, 6, 3> D;
    rows<3>(D, 0).noalias() = across<R>(q_plus).transpose() * (across<R>(q_minus) - rows<4>(KHN, 0)) / norm;
    rows<3>(D, 3) = -rows<3>(KHN, 4);

    Eigen::Map<Square<6, R>> map(M);
    Eigen::Map<Matrix3Of<R>> path(bias_path);
    Square<6, R> step;
    columns<3>(step, 0) = D;
    columns<3>(step, 3).noalias() = R(-0.5) * D * path;
    diagonal<3>(step, 3).array() += 1;
    if (since_s > 0) {
        map = step;
        before = after;
        interval_s = since_s;
    } else {
        map = (step * map).eval();
    }
    keep(q_plus, P);
    path.setZero();
}

} // namespace hnav
