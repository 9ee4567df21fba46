// How the walk of the bias becomes rotation: its noise over the turn that ends at an event.
#include "attitude/hrekf/model.hpp"

namespace hnav {
namespace {

// With G(t) = t I - b(t) U + g(t) U^2, U = [u]x, w = |u|: the coefficients at T and the integrals over [0, T] of
// their products (a = t), which give the integral of G Q G' for any Q.
struct TurnIntegrals {
    using R = Scalar;

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

    // The integral of G G' = (a^2 - b^2 U^2 + 2 a g U^2 + g^2 U^4), U^4 = -w^2 U^2, in axes in which u is n.
    Matrix3Of<R> of_even_walk(const Vector3Of<R>& n, R w2) const {
        const R share = 2 * ag - bb - w2 * gg;
        Matrix3Of<R> sum = share * n * n.transpose();
        sum.diagonal().array() += aa - share * w2;
        return sum;
    }

    // The integral of G Q G' for a symmetric Q.
    Matrix3Of<R> of_walk(const Matrix3Of<R>& U, const Matrix3Of<R>& UU, const Matrix3Of<R>& Q) const {
        const Matrix3Of<R> UQ = U * Q, UUQ = UU * Q, across = UUQ * U;
        return aa * Q - ab * (UQ + UQ.transpose()) + ag * (UUQ + UUQ.transpose()) - bb * UQ * U +
               bg * (across + across.transpose()) + gg * UUQ * UU;
    }
};

} // namespace

// The rate was held since the last event, and A_T - A_t = R_bn(T) G(T - t): the noise of this turn alone is the integral of
// G shape G', seen from the body at its end.
void HrekfModel::take_turn(State& s) const {
    const R T = s.x[Place::t] - s.walk_s;
    if (!(T > 0)) return;
    const Vector3R u = turn_rate(s);
    const R w = u.norm();
    const TurnIntegrals I(w, T);
    const Matrix3R U = cross_matrix<R>(u), R_bn = rotation_matrix<R>(QuaternionR(s.x));
    Matrix3R UU = u * u.transpose();
    UU.diagonal().array() -= w * w;
    Matrix3R noise;
    if (walks_evenly()) noise = I.of_even_walk(R_bn * u, w * w);
    else noise = R_bn * I.of_walk(U, UU, walk_shape(s)) * R_bn.transpose();

    Eigen::Map<Matrix3R> C(s.C);
    const Matrix3R turn = Eigen::Map<const Matrix3R>(s.x + Place::A) - Eigen::Map<const Matrix3R>(s.walk_A);
    if (s.walk_s > 0) {
        const Matrix3R half = turn * walk_shape(s) * (C + R(0.5) * s.walk_s * turn).transpose();
        noise += half + half.transpose();
    }
    C += s.walk_s * turn + R_bn * (R(0.5) * T * T * Matrix3R::Identity() - I.g * U + I.g1 * UU);
    for (int i = 0, k = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) s.N[k++] += noise(i, j);
    std::copy(s.x + Place::A, s.x + Place::A + 9, s.walk_A);
    s.walk_s = s.x[Place::t];
}

} // namespace hnav
