// The covariance from one correction to the next: P(T) = Phi P Phi' + Q.
#include "attitude/ahrs/model.hpp"

namespace hnav {

// Columns of P Phi' for the rotation, and its own block.
struct AhrsModel::Turned {
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

// P <- Phi P Phi' + Q over the time since the last correction.
void AhrsModel::propagate(Covariance& P, const State& s) const {
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
void AhrsModel::forget_declination(State& s, Covariance& P) const {
    if (s.rest.at_rest(options_)) return;
    const R kept = std::exp(-s.x[13] / R(options_.local_declination_s)), sigma = sigma_.declination;
    s.declination *= kept;
    P.row(declination) *= kept;
    P.col(declination) *= kept;
    for (int j = 0; j < step_parts; ++j) s.steps.response[responding * j + declination - rotation] *= kept;
    P(declination, declination) += (1 - kept * kept) * (s.foreign2 + s.field_noise.scale2 * sigma * sigma);
}

} // namespace hnav
