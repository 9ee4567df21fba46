// The covariance from one correction to the next: P(t) = Phi P Phi' + noise.
//
// The 7 x 7 covariance of (q, b) has 22 numbers that are not zero. With the error of the unit quaternion written as
// dq = (l, theta / 2) (x) q, theta the rotation error about the navigation axes and l that of the length,
//     theta' = -R_bn db + noise,   l' = noise,   db' = noise:
// the length stays uncorrelated with the rest, because it starts at zero after each return to the unit sphere. So
//     theta(t) = theta - A db,   A = int R_bn dt,   Phi = [I, -A; 0, I],
// and with the walk Q_b = level shape of the bias its noise is
//     bias, bias  t Q_b      rotation, bias  -C Q_b,  C = int R_bn t dt
//     rotation, rotation  level N,  N' = R_bn shape C' + C shape R_bn'.
// The shape is I, unless the walk is adapted as printed in the paper. C and N are exact at events, for the rate is held between
// them (bias_walk.hpp). After the last event, where the covariance is shown and corrects nothing, C is extrapolated by the mean
// time and N is held: a polynomial of second degree in the states, which the derivatives of outputs rely on (c_api/shown_along.hpp).
// White noise of the gyroscope of density n adds n t to the rotation; the paper's noise of density p on all four components of q
// adds 4 p t to it, and p t to the variance of the length.
#include "attitude/hrekf/model.hpp"
#include "maths/unroll.hpp"

namespace hnav {

HrekfModel::Covariance HrekfModel::covariance(const State& s) const {
    Covariance P = unpack<6>(s.P);
    const R t = s.x[Place::t];
    if (t == 0) return P;
    const Eigen::Map<const Matrix3R> A(s.x + Place::A);
    Matrix3R C = Eigen::Map<const Matrix3R>(s.C);
    if (t != s.walk_s) C += R(0.5) * (t + s.walk_s) * (A - Eigen::Map<const Matrix3R>(s.walk_A));
    const Matrix3R theta_b = block<3, 3>(P, 0, 3), turned = theta_b - A * block<3, 3>(P, 3, 3);
    const R level = walk_level(s), white = (density_.gyro_psd + 4 * density_.quaternion_psd) * t;
    const R* N = s.N;
    HNAV_UNROLL
    for (int i = 0; i < 3; ++i) {
        P(i, i) += white;
        HNAV_UNROLL
        for (int j = i; j < 3; ++j) {
            R sum = P(i, j) + level * *N++;
            HNAV_UNROLL
            for (int k = 0; k < 3; ++k) sum -= A(i, k) * theta_b(j, k) + turned(i, k) * A(j, k);
            P(i, j) = P(j, i) = sum;
        }
    }
    const Matrix3R walked = turned - level * (walks_evenly() ? C : Matrix3R(C * walk_shape(s)));
    block<3, 3>(P, 0, 3) = walked;
    block<3, 3>(P, 3, 0) = walked.transpose();
    block<3, 3>(P, 3, 3) = bias_covariance(s);
    return P;
}

} // namespace hnav
