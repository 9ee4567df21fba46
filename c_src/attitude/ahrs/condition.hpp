// Shared by the corrections: the update by rows of a sensor.
#pragma once

#include "attitude/ahrs/model.hpp"
#include "base/small.hpp"
#include "maths/unroll.hpp"

#include <algorithm>
#include <utility>

namespace hnav {

// S^-1 times the response of rows.
template <int m>
AhrsModel::Response<m> AhrsModel::weighted(const Cholesky<m, R>& S, const Response<m>& stepped) {
    Response<m> out;
    for (int j = 0; j < step_parts; ++j) out.col(j) = S.template solve<1>(stepped.col(j));
    return out;
}

// Corrects the errors from row `first` on by m rows H, with PHt = P H' and S = H P H' + noise. Rows before `first` are consider states
// (Schmidt): P_ij -= PHt_i S^-1 PHt_j' unless both i and j are such. Only the upper triangle of P is updated. There is no correction if
// rounding has made S indefinite, as by values of very different magnitudes. evidence: of a step of the gyro bias, to which the innovation
// is added; null: none. To such a step the errors between velocity and rotation, of sensors, do not respond within a window.
// withheld: share of a correction by a velocity that the accelerometer's bias is not given (turning_force.hpp).
template <int m, int first>
void AhrsModel::condition(Correction& c, const Eigen::Matrix<R, errors, m>& PHt, const Square<m, R>& S,
                          const Eigen::Matrix<R, m, 1>& innovation, const Response<m>& stepped, Evidence* evidence, R withheld) {
    static_assert(first == 0 || first == considered);
    constexpr int rest = errors - first;
    const Cholesky<m, R> factor(S);
    if (!factor.positive()) {
        c.sound = false;
        return;
    }
    const Eigen::Matrix<R, m, rest> Kt = factor.template solve<rest>(rows<rest>(PHt, first).transpose());
    segment<rest>(c.error, first).noalias() += Kt.transpose() * innovation;
    if (evidence) evidence->add(stepped, weighted<m>(factor, stepped), innovation);
    constexpr int last = std::min(rest, errors - rotation);
    for (int j = 0; j < step_parts; ++j)
        for (int k = 0; k < m; ++k) {
            c.response.col(j).template tail<last>() -= stepped(k, j) * Kt.row(k).template tail<last>().transpose();
            if constexpr (first == 0) c.velocity_response.col(j) -= stepped(k, j) * Kt.row(k).template head<2>().transpose();
        }
    if constexpr (m == 2) withhold(c, PHt, Kt, innovation, withheld);
    take_out<m, first>(c.P, PHt, Kt, std::make_integer_sequence<int, rest>());
}

// Adds before a correction by a velocity what it will take too much from the accelerometer's bias and its variance.
inline void AhrsModel::withhold(Correction& c, const Eigen::Matrix<R, errors, 2>& PHt, const Eigen::Matrix<R, 2, errors>& Kt,
                                const Vector2R& innovation, R share) {
    HNAV_UNROLL
    for (int j = force_bias; j < force_bias + 3; ++j) {
        const Vector2R gain = share * Kt.col(j), kept = share * gain;
        c.error[j] -= gain.dot(innovation);
        HNAV_UNROLL
        for (int i = force_bias; i <= j; ++i) c.P(i, j) += kept[0] * PHt(i, 0) + kept[1] * PHt(i, 1);
    }
}

// P_ij -= PHt_i K_j for the columns from `first` on, down to the diagonal. Loops have compile-time lengths except in the small build.
template <int m, int first, int... after_first>
void AhrsModel::take_out(Covariance& P, const Eigen::Matrix<R, errors, m>& PHt, const Eigen::Matrix<R, m, errors - first>& Kt,
                         std::integer_sequence<int, after_first...>) {
    if constexpr (small_build) {
        for (int j = first; j < errors; ++j)
            for (int i = 0; i <= j; ++i)
                for (int k = 0; k < m; ++k) P(i, j) -= Kt(k, j - first) * PHt(i, k);
    } else {
        (take_out_of_column<m, first, first + after_first>(P, PHt, Kt), ...);
    }
}

template <int m, int first, int j>
void AhrsModel::take_out_of_column(Covariance& P, const Eigen::Matrix<R, errors, m>& PHt,
                                   const Eigen::Matrix<R, m, errors - first>& Kt) {
    // By elements: one type of Eigen for each height and sensor takes a quarter of the compile time of all corrections.
    constexpr int height = j + 1;
    R column[height];
    std::copy_n(&P.coeffRef(0, j), height, column);
    for (int k = 0; k < m; ++k) {
        const R gain = Kt(k, j - first);
        const R* from = &PHt.coeffRef(0, k);
        for (int i = 0; i < height; ++i) column[i] -= gain * from[i];
    }
    std::copy_n(column, height, &P.coeffRef(0, j));
}

} // namespace hnav
