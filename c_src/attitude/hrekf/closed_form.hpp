// Between events: the flow over an interval in closed form, exact because the rate is held.
#pragma once

#include "attitude/hrekf/model.hpp"

namespace hnav {

// With G(t) = t I - b(t) U + g(t) U^2, U = [u]x, w = |u|: the coefficients at T and the integrals over [0, T] of
// their products (a = t), which give the integral of G Q G' for any Q.
template <class R>
struct TurnIntegrals {
    R b, g, g1; // b(T), g(T) = integral of b, g1 = integral of g
    R aa, ab, ag, bb, bg, gg;

    TurnIntegrals(R w, R T) {
        const R x = w * T, x2 = x * x, T2 = T * T, T3 = T2 * T;
        aa = T3 / 3;
        if (x < R(0.02)) { // the closed forms lose digits: their series instead
            b = T2 * (R(0.5) - x2 / 24 + x2 * x2 / 720);
            g = T3 * (R(1.0 / 6) - x2 / 120 + x2 * x2 / 5040);
            g1 = T2 * T2 * (R(1.0 / 24) - x2 / 720);
            ab = T2 * T2 * (R(1.0 / 8) - x2 / 144 + x2 * x2 / 5760);
            ag = T3 * T2 * (R(1.0 / 30) - x2 / 840);
            bb = T3 * T2 * (R(1.0 / 20) - x2 / 168);
            gg = T3 * T3 * T * (R(1.0 / 252) - x2 / 3240);
        } else {
            const R w2 = w * w, s = std::sin(x), c = std::cos(x), h = std::sin(R(0.5) * x);
            b = 2 * h * h / w2;
            g = (x - s) / (w2 * w);
            g1 = (R(0.5) * x2 - 2 * h * h) / (w2 * w2);
            ab = (R(0.5) * T2 - T * s / w + 2 * h * h / w2) / w2;
            ag = (w * aa - (s - x * c) / w2) / (w2 * w);
            bb = (R(1.5) * T - 2 * s / w + s * c / (2 * w)) / (w2 * w2);
            gg = (w2 * aa - 2 * (s - x * c) / w + R(0.5) * T - s * c / (2 * w)) / (w2 * w2 * w2);
        }
        bg = R(0.5) * g * g; // since g' = b
    }
};

// With r = exp(u T/2) the quaternion turns by right multiplication, q+ = E q, and a bias error b enters through
// Phi_qb = -Xi(q+) G, G = integral of exp(-[u]x t).
template <class R>
void HrekfModelOf<R>::flow_exactly(State& s, double interval_s) const {
    const R T = R(interval_s);
    const Vector3R u = turn_rate(s, s.x);
    const TurnIntegrals<R> I(u.norm(), T);
    const Matrix3R U = cross_matrix<R>(u);
    const Matrix3R UU = U * U;
    const Matrix3R G = T * Matrix3R::Identity() - I.b * U + I.g * UU;
    const Square<4, R> E = right_multiplication<R>(rotation_quaternion<R>(u * T));
    const QuaternionR q_next = E * QuaternionR(s.x);
    const Matrix43Of<R> B = Xi<R>(q_next);
    const Matrix43Of<R> F = -B * G;

    // Phi P Phi'
    const Blocks P(s.x + 7);
    Blocks next;
    const Matrix43Of<R> turned = E * P.qb;
    next.qb.noalias() = turned + F * P.bb;
    const Square<4, R> turned_qq = E * P.qq * E.transpose();
    const Square<4, R> cross = next.qb * F.transpose() + F * turned.transpose();
    next.qq = turned_qq + cross;
    next.bb = P.bb;

    // Noise of the interval, as rotation (theta) and bias: the walk of the bias reaches theta through G.
    const Matrix3R Qb = unpack<3>(s.bias_psd);
    const Matrix3R theta_b = -(R(0.5) * T * T * Qb - I.g * U * Qb + I.g1 * UU * Qb);
    const Matrix3R a = U * Qb, aU = a * U, Ua = U * a, UaU = U * aU;
    const Matrix3R theta_theta = I.aa * Qb - I.ab * (a + a.transpose()) + I.ag * (Ua + Ua.transpose()) - I.bb * aU +
                                 I.bg * (UaU + UaU.transpose()) + I.gg * UaU * U;
    Matrix3R theta = theta_theta;
    theta.diagonal().array() += density_.gyro_psd * T;
    next.qq.noalias() += B * theta * B.transpose();
    next.qq.diagonal().array() += density_.quaternion_psd * T;
    next.qb.noalias() += B * theta_b;
    next.bb += T * Qb;

    put_q(s, q_next);
    next.write(s.x + 7);
}

} // namespace hnav
