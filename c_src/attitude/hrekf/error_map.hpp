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
    R before[21], after[21]; // P and P+ of e, upper triangles
    R M[36];                 // column-major
    R bias_path[9];          // A since the last correction, column-major, s
    double interval_s;       // that M spans
    double flown_to_s;       // end of bias_path

    // An attitude was found: no rate until the next correction.
    void begin(double t_s, const QuaternionOf<R>& q, const Square<7, R>& P);

    // The held rate u brought the attitude to q at t_s: R_nb(t_s - t) = R_nb(t_s) exp(-[u]x t), whatever the integrator.
    void flow(double t_s, const QuaternionOf<R>& q, const Vector3Of<R>& u);

    // The correction KH = K H_q took the unit quaternion q_minus to q_plus, its sum being `norm` long; P is that after it.
    // since_s: the correction before; 0 for a second one at the same instant, which joins the first.
    void jump(double since_s, const Eigen::Matrix<R, 7, 4>& KH, const QuaternionOf<R>& q_minus, const QuaternionOf<R>& q_plus,
              R norm, const Square<7, R>& P);
};

extern template struct ErrorMap<Scalar>; // decay_rate.cpp

// Of (d, e_b), from that of (q, b).
template <class R>
inline Square<6, R> error_map_covariance(const Matrix43Of<R>& N, const Square<7, R>& P) {
    Square<6, R> C;
    block<3, 3>(C, 0, 0).noalias() = N.transpose() * (block<4, 4>(P, 0, 0) * N).eval();
    block<3, 3>(C, 0, 3).noalias() = N.transpose() * block<4, 3>(P, 0, 4);
    block<3, 3>(C, 3, 0) = block<3, 3>(C, 0, 3).transpose();
    block<3, 3>(C, 3, 3) = block<3, 3>(P, 4, 4);
    return C;
}

template <class R>
void ErrorMap<R>::begin(double t_s, const QuaternionOf<R>& q, const Square<7, R>& P) {
    pack<6>(error_map_covariance<R>(across<R>(q), P), after);
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
void ErrorMap<R>::jump(double since_s, const Eigen::Matrix<R, 7, 4>& KH, const QuaternionOf<R>& q_minus,
                       const QuaternionOf<R>& q_plus, R norm, const Square<7, R>& P) {
    const Matrix43Of<R> N_minus = across<R>(q_minus), N_plus = across<R>(q_plus);
    const Eigen::Matrix<R, 7, 3> seen = KH * N_minus;
    Eigen::Matrix<R, 6, 3> D;
    rows<3>(D, 0).noalias() = N_plus.transpose() * (N_minus - rows<4>(seen, 0)) / norm;
    rows<3>(D, 3) = -rows<3>(seen, 4);

    Eigen::Map<Square<6, R>> map(M);
    Eigen::Map<Matrix3Of<R>> path(bias_path);
    Square<6, R> step;
    columns<3>(step, 0) = D;
    columns<3>(step, 3).noalias() = R(-0.5) * D * path;
    diagonal<3>(step, 3).array() += 1;
    if (since_s > 0) {
        map = step;
        for (int i = 0; i < 21; ++i) before[i] = after[i];
        interval_s = since_s;
    } else {
        map = (step * map).eval();
    }
    pack<6>(error_map_covariance<R>(N_plus, P), after);
    path.setZero();
}

} // namespace hnav
