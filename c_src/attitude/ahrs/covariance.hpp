// The covariance from one correction to the next: P(T) = Phi P Phi' + Q.
#pragma once

#include "attitude/ahrs/model.hpp"
#include "maths/unroll.hpp"

namespace hnav {

// int (n_g^2 + k^2 |u|^2) dt since the last correction, and what went by in gaps
template <class R>
R AhrsModelOf<R>::rotation_noise(const State& s) const {
    return density_.gyro_psd * s.x[13] + density_.gyro_rate_psd * s.rate_power + s.gap_rotation;
}

// Columns of P Phi' for the rotation, and its own block.
template <class R>
struct AhrsModelOf<R>::Turned {
    Eigen::Matrix<R, errors, 3> columns; // covariance of the error before with the rotation after
    Matrix3R rotation;

    Turned(const Covariance& P, const Matrix3R& G, const Eigen::Map<const Matrix39R>& L) {
        // By columns, here and below: Eigen would use its code for large matrices for products of this size.
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

// The present rotation error from the errors before: theta - L dS - G db.
template <class R>
class AhrsModelOf<R>::RotationNow {
public:
    // Since the last event the rate was constant.
    explicit RotationNow(const State& s) : P_(s.P), G_(s.x + 4), L_(&s.rate_moment) {
        if (s.x[13] == s.turned_s) return;
        std::memcpy(shown_, s.rate_moment, sizeof shown_);
        add_turn(s, shown_);
        L_ = &shown_;
    }
    RotationNow(const RotationNow&) = delete;
    RotationNow& operator=(const RotationNow&) = delete;

    Vector3R variances() const {
        Vector3R v;
        HNAV_UNROLL
        for (int k = 0; k < 3; ++k) v[k] = 2 * times(k, half_of(k)) + P_[packed(rotation + k, rotation + k)];
        return v;
    }

    Matrix3R covariance() const {
        const Half half[] = {half_of(0), half_of(1), half_of(2)};
        Matrix3R C;
        HNAV_UNROLL
        for (int k = 0; k < 3; ++k) {
            HNAV_UNROLL
            for (int i = 0; i <= k; ++i)
                C(i, k) = C(k, i) = times(i, half[k]) + times(k, half[i]) + P_[packed(rotation + i, rotation + k)];
        }
        return C;
    }

    // Rotation by bias.
    Matrix3R with_bias() const {
        const Matrix3R of_bias = bias_block(P_);
        Matrix3R C;
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 3; ++i) {
                R sum = P_[packed(rotation + i, bias + k)];
                for (int j = 0; j < 9; ++j) sum -= L(i, j) * P_[packed(calibration + j, bias + k)];
                for (int j = 0; j < 3; ++j) sum -= G(i, j) * of_bias(j, k);
                C(i, k) = sum;
            }
        return C;
    }

    static Matrix3R bias_block(const R* P) {
        Matrix3R B;
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i <= j; ++i) B(i, j) = B(j, i) = P[packed(bias + i, bias + j)];
        return B;
    }

private:
    using Pair = Eigen::Array<R, 2, 1>;

    // With a = (L, G) and p the errors of calibration and bias, the covariance is M + M' + P_theta, M = a (U a' - P_ptheta) where
    // P_pp = U + U': each pair of errors is visited once. Half is one column of the bracket; the nine calibration errors are processed
    // in pairs (SIMD), the ninth alone.
    struct Half {
        Pair of_S[4];
        R of_S8, of_b[3];
    };

    Half half_of(int k) const {
        constexpr int S8 = calibration + 8;
        const R *a = (*L_)[k], *with_theta = P_ + packed(0, rotation + k);
        Pair of_S[4];
        HNAV_UNROLL
        for (int p = 0; p < 4; ++p) of_S[p] = -Eigen::Map<const Pair>(with_theta + calibration + 2 * p);
        R of_S8 = R(0.5) * a[8] * P_[packed(S8, S8)] - with_theta[S8], of_b[3];
        HNAV_UNROLL
        for (int j = 0; j < 3; ++j) {
            const R g = G(k, j);
            HNAV_UNROLL
            for (int p = 0; p < 4; ++p) of_S[p] += g * two(calibration + 2 * p, bias + j);
            of_S8 += g * P_[packed(S8, bias + j)];
            of_b[j] = R(0.5) * g * P_[packed(bias + j, bias + j)] - P_[packed(rotation, bias + j) + k];
            HNAV_UNROLL
            for (int i = 0; i < j; ++i) of_b[i] += g * P_[packed(bias + i, bias + j)];
        }
        HNAV_UNROLL
        for (int j = 0; j < 9; ++j) {
            HNAV_UNROLL
            for (int p = 0; p < j / 2; ++p) of_S[p] += a[j] * two(calibration + 2 * p, calibration + j);
            if (j == 8) continue;
            // Down to the diagonal, which has half weight; entries below it do not belong to this column.
            const Pair last = two(calibration + j / 2 * 2, calibration + j);
            of_S[j / 2] += a[j] * (j % 2 ? Pair(1, R(0.5)) : Pair(R(0.5), 0)) * last;
        }
        return {{of_S[0], of_S[1], of_S[2], of_S[3]}, of_S8, {of_b[0], of_b[1], of_b[2]}};
    }

    R times(int i, const Half& h) const {
        const R* a = (*L_)[i];
        Pair sum = Eigen::Map<const Pair>(a) * h.of_S[0];
        HNAV_UNROLL
        for (int p = 1; p < 4; ++p) sum += Eigen::Map<const Pair>(a + 2 * p) * h.of_S[p];
        return sum[0] + sum[1] + a[8] * h.of_S8 + G(i, 0) * h.of_b[0] + G(i, 1) * h.of_b[1] + G(i, 2) * h.of_b[2];
    }

    R L(int i, int j) const { return (*L_)[i][j]; }
    R G(int i, int j) const { return G_[3 * j + i]; }
    // Elements i and i + 1 of column j.
    Pair two(int i, int j) const { return Eigen::Map<const Pair>(P_ + packed(i, j)); }

    const R* P_;
    const R* G_;
    const Moment* L_;
    Moment shown_; // at the time of x
};

// P <- Phi P Phi' + Q over the time since the last correction.
template <class R>
void AhrsModelOf<R>::propagate(Covariance& P, const State& s) const {
    const Eigen::Map<const Matrix3R> G(s.x + 4);
    const Eigen::Map<const Matrix39R> L(s.rate_moment[0]);
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

    const R T = s.x[13], lost = R(options_.gap_acceleration_m_s2) * s.force_gap_s;
    const R of_force = MotionNoise<R>::force_density * MotionNoise<R>::force_density * s.force_s;
    diagonal<2>(P, velocity).array() += lost * lost + of_force;
    diagonal<3>(P, rotation).array() += rotation_noise(s);
    diagonal<3>(P, bias).array() += density_.bias_walk_psd * T;
    diagonal<2>(P, reference).array() += density_.reference_psd * s.field_noise.scale2 * T;
}

// The declination is that of the place; it changes when the body moves to other places.
template <class R>
void AhrsModelOf<R>::forget_declination(State& s, Covariance& P) const {
    if (s.rest.at_rest(options_)) return;
    const R kept = std::exp(-s.x[13] / R(options_.local_declination_s)), sigma = sigma_.declination;
    s.declination *= kept;
    P.row(declination) *= kept;
    P.col(declination) *= kept;
    for (int j = 0; j < step_parts; ++j) s.steps.response[responding * j + declination - rotation] *= kept;
    P(declination, declination) += (1 - kept * kept) * (s.foreign2 + s.field_noise.scale2 * sigma * sigma);
}

} // namespace hnav
