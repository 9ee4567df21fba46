// The covariance from one correction to the next: P(T) = Phi P Phi' + Q.
#pragma once

#include "attitude/ahrs/model.hpp"
#include "base/small.hpp"

namespace hnav {

// int (n_g^2 + k^2 |u|^2) dt since the last correction, and what went by in gaps
template <class R>
R AhrsModelOf<R>::rotation_noise(const State& s) const {
    return settings_.gyro_psd * s.x[13] + settings_.gyro_rate_psd * s.rate_power + s.gap_rotation;
}

// Columns of P Phi' for the rotation, and its own block.
template <class R>
struct AhrsModelOf<R>::Turned {
    Eigen::Matrix<R, errors, 3> columns; // covariance of the error before with the rotation after
    Matrix3R rotation;

    Turned(const Covariance& P, const Matrix3R& G, const Matrix39R& L) {
        // Column by column, here and below: Eigen would send products of this size through code for large matrices.
        for (int i = 0; i < 3; ++i) {
            Vector column = P.col(Row::rotation + i);
            for (int j = 0; j < 3; ++j) column -= G(i, j) * P.col(bias + j);
            for (int j = 0; j < 9; ++j) column -= L(i, j) * P.col(calibration + j);
            columns.col(i) = column;
        }
        rotation = rows<3>(columns, Row::rotation);
        rotation -= G.lazyProduct(rows<3>(columns, bias));
        rotation -= L.lazyProduct(rows<9>(columns, calibration));
    }
};

// The rotation error of now by the errors of before that it depends on: theta - L dS - G db.
template <class R>
struct AhrsModelOf<R>::RotationNow {
    using Vector9R = Eigen::Matrix<R, 9, 1>;
    Eigen::Matrix<R, 9, 3> by_calibration; // -L', one column for each angle
    Matrix3R by_bias;                      // -G'

    RotationNow(const Matrix3R& G, const Moment& moment) : by_bias(-G.transpose()) {
        for (int l = 0; l < 3; ++l)
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 3; ++k) by_calibration(3 * l + j, k) = -moment[j][3 * l + k];
    }

    // M + M' with M = a' (P_SS a / 2 + P_Sb g + P_S theta) + g' (P_bb g / 2 + P_b theta) + P_theta theta / 2, where a and g are
    // what stands above: each pair of errors is met once.
    Matrix3R covariance(const R* P) const {
        Matrix3R M;
        for (int k = 0; k < 3; ++k) {
            Vector9R of_S = half_of(P, by_calibration.col(k), std::make_integer_sequence<int, 9>());
            of_S += upper<9>(P, calibration, rotation + k) + by_bias(0, k) * upper<9>(P, calibration, bias) +
                    by_bias(1, k) * upper<9>(P, calibration, bias + 1) + by_bias(2, k) * upper<9>(P, calibration, bias + 2);
            Vector3R of_b;
            for (int j = 0; j < 3; ++j) of_b[j] = P[packed(rotation + k, bias + j)];
            of_b += R(0.5) * bias_block(P) * by_bias.col(k);
            for (int i = 0; i < 3; ++i)
                M(i, k) = by_calibration.col(i).dot(of_S) + by_bias.col(i).dot(of_b) + R(0.5) * at(P, rotation + i, rotation + k);
        }
        return M + M.transpose();
    }

    // Rotation by bias.
    Matrix3R with_bias(const R* P) const {
        Matrix3R C;
        for (int k = 0; k < 3; ++k) {
            const auto of_S = upper<9>(P, calibration, bias + k);
            const Vector3R of_b = bias_block(P).col(k);
            for (int i = 0; i < 3; ++i)
                C(i, k) = by_calibration.col(i).dot(of_S) + by_bias.col(i).dot(of_b) + P[packed(rotation + i, bias + k)];
        }
        return C;
    }

    static Matrix3R bias_block(const R* P) {
        Matrix3R B;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) B(i, j) = at(P, bias + i, bias + j);
        return B;
    }

private:
    static R at(const R* P, int i, int j) { return P[i < j ? packed(i, j) : packed(j, i)]; }

    // n elements of column j from row i on.
    template <int n>
    static Eigen::Map<const Eigen::Matrix<R, n, 1>> upper(const R* P, int i, int j) {
        return Eigen::Map<const Eigen::Matrix<R, n, 1>>(P + packed(i, j));
    }

    // What a' P_SS a is half of, if multiplied by a': columns of the upper triangle with half of the diagonal, times a.
    template <class Column, int... j>
    static Vector9R half_of(const R* P, const Column& a, std::integer_sequence<int, j...>) {
        Vector9R half;
        ((half[j] = upper<j + 1>(P, calibration, calibration + j).dot(a.template head<j + 1>()) -
                    R(0.5) * a[j] * P[packed(calibration + j, calibration + j)]),
         ...);
        return half;
    }
};

// P <- Phi P Phi' + Q over the time since the last correction.
template <class R>
void AhrsModelOf<R>::propagate(Covariance& P, const State& s) const {
    const Eigen::Map<const Matrix3R> G(s.x + 4);
    const Matrix39R L = by_calibration(s.rate_moment);
    const Turned turned(P, G, L);

    // v_N -= g T theta_E, v_E += g T theta_N, with the mean of theta before and after; and dv = -int R_bn df - swept dl.
    const R half = R(0.5 * gravity_m_s2) * s.force_s;
    Eigen::Matrix<R, errors, 2> v = columns<2>(P, velocity); // of the error before with v after
    v.col(0) -= half * (P.col(rotation + 1) + turned.columns.col(1));
    v.col(1) += half * (P.col(rotation) + turned.columns.col(0));
    const R forced = s.x[13] > 0 ? s.force_s / s.x[13] : 0;
    for (int i = 0; i < 2; ++i) {
        Vector column = v.col(i) - s.swept_velocity[i] * P.col(force_latency);
        for (int j = 0; j < 3; ++j) column -= forced * G(i, j) * P.col(force_bias + j);
        v.col(i) = column;
    }
    Eigen::Matrix<R, 3, 2> theta_v = rows<3>(v, rotation); // theta after, v after
    theta_v -= G.lazyProduct(rows<3>(v, bias));
    theta_v -= L.lazyProduct(rows<9>(v, calibration));
    Matrix2R v_v = rows<2>(v, velocity);
    v_v.row(0) -= half * (v.row(rotation + 1) + theta_v.row(1));
    v_v.row(1) += half * (v.row(rotation) + theta_v.row(0));
    for (int i = 0; i < 2; ++i) {
        v_v.row(i) -= s.swept_velocity[i] * v.row(force_latency);
        for (int j = 0; j < 3; ++j) v_v.row(i) -= forced * G(i, j) * v.row(force_bias + j);
    }

    columns<3>(P, rotation) = turned.columns;
    rows<3>(P, rotation) = turned.columns.transpose();
    columns<2>(P, velocity) = v;
    rows<2>(P, velocity) = v.transpose();
    block<3, 3>(P, rotation, rotation) = turned.rotation;
    block<3, 2>(P, rotation, velocity) = theta_v;
    block<2, 3>(P, velocity, rotation) = theta_v.transpose();
    block<2, 2>(P, velocity, velocity) = v_v;

    const R T = s.x[13], lost = settings_.gap_acceleration_m_s2 * s.force_gap_s;
    const R of_force = MotionNoise<R>::force_density * MotionNoise<R>::force_density * s.force_s;
    diagonal<2>(P, velocity).array() += lost * lost + of_force;
    diagonal<3>(P, rotation).array() += rotation_noise(s);
    diagonal<3>(P, bias).array() += settings_.bias_walk_psd * T;
    diagonal<2>(P, reference).array() += settings_.reference_psd * s.field_noise.scale2 * T;
}

// The azimuth of the field is that of the place, and a body that moves comes to other places.
template <class R>
void AhrsModelOf<R>::forget_declination(State& s, Covariance& P) const {
    if (s.rest.at_rest(settings_.rest)) return;
    const R kept = std::exp(-s.x[13] / settings_.declination_s), sigma = settings_.sigma.declination;
    s.declination *= kept;
    P.row(declination) *= kept;
    P.col(declination) *= kept;
    P(declination, declination) += (1 - kept * kept) * s.field_noise.scale2 * sigma * sigma;
}

} // namespace hnav
