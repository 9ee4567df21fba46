// Between events: the differential equation of attitude, bias and covariance.
#pragma once

#include "attitude/hrekf/model.hpp"

namespace hnav {

// Xi N Xi' = N/4 (|q|^2 I - q q') for white gyro noise of density N
template <class R>
Square<4, R> HrekfModelOf<R>::attitude_noise(const QuaternionR& q) const {
    Square<4, R> Q = R(-0.25) * density_.gyro_psd * q * q.transpose();
    Q.diagonal().array() += R(0.25) * density_.gyro_psd * q.squaredNorm() + density_.quaternion_psd;
    return Q;
}

template <class R>
void HrekfModelOf<R>::flow(const State& s, const R* x, R* dx) const {
    if (!s.started) {
        for (int i = 0; i < nx; ++i) dx[i] = 0;
        return;
    }
    const QuaternionR q(x);
    const Blocks P(x + 7);
    const Square<4, R> A_qq = Omega<R>(turn_rate(s, x));
    const Matrix43Of<R> A_qb = -Xi<R>(q);

    Eigen::Map<QuaternionR>(dx).noalias() = A_qq * q;
    dx[4] = dx[5] = dx[6] = 0;
    Blocks dP;
    const Square<4, R> half = A_qq * P.qq + A_qb * P.qb.transpose();
    dP.qq = half + half.transpose() + attitude_noise(q);
    dP.qb.noalias() = A_qq * P.qb + A_qb * P.bb;
    dP.bb = unpack<3>(s.bias_psd);
    dP.write(dx + 7);
}

// The flow is bilinear in q, u and P, so this is the product rule.
template <class R>
void HrekfModelOf<R>::flow_along(const State& s, const R* x, const R* direction, R* out) const {
    if (!s.started) {
        for (int i = 0; i < nx; ++i) out[i] = 0;
        return;
    }
    const QuaternionR q(x), dq(direction);
    const Blocks P(x + 7), dP(direction + 7);
    const Square<4, R> A_qq = Omega<R>(turn_rate(s, x));
    Square<4, R> dA_qq = Square<4, R>::Zero();
    if (s.has_rate) dA_qq = Omega<R>({-direction[4], -direction[5], -direction[6]});
    const Matrix43Of<R> A_qb = -Xi<R>(q), dA_qb = -Xi<R>(dq);

    Eigen::Map<QuaternionR>(out).noalias() = A_qq * dq + dA_qq * q;
    out[4] = out[5] = out[6] = 0;
    Blocks result;
    const Square<4, R> half = A_qq * dP.qq + dA_qq * P.qq + A_qb * dP.qb.transpose() + dA_qb * P.qb.transpose();
    const Square<4, R> noise_half = R(0.25) * density_.gyro_psd * (q.dot(dq) * Square<4, R>::Identity() - dq * q.transpose());
    result.qq = half + half.transpose() + noise_half + noise_half.transpose();
    result.qb.noalias() = A_qq * dP.qb + dA_qq * P.qb + A_qb * dP.bb + dA_qb * P.bb;
    result.bb.setZero();
    result.write(out + 7);
}

} // namespace hnav
