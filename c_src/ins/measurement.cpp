#include "ins/measurement.hpp"

#include "estimation/gate.hpp"
#include "maths/cholesky.hpp"

#include <cmath>

namespace hnav::ins {
namespace {

template <int m, int n>
struct Projected {
    alignas(16) double PHt[m][row_length] = {}, HB[m][responses] = {};
    Square<m> known; // H P H'
    Eigen::Matrix<double, m, 1> r;

    Projected(const Covariance& P, const double* mean, const Measurement& given) {
        for (int k = 0; k < m; ++k)
            for (int i = 0; i < n; ++i) {
                if (given.H[k][i] == 0) continue;
                for (int j = 0; j < n; ++j) PHt[k][j] += given.H[k][i] * P[i][j];
                for (int j = 0; j < responses; ++j) HB[k][j] += given.H[k][i] * P.response[i][j];
            }
        for (int k = 0; k < m; ++k) {
            r[k] = given.r[k] - dot(given.H[k], mean);
            for (int l = 0; l < m; ++l) known(k, l) = dot(given.H[k], PHt[l]);
        }
        symmetrise<m>(known);
    }

    static double dot(const double* a, const double* b) {
        double sum = 0;
        for (int i = 0; i < n; ++i) sum += a[i] * b[i];
        return sum;
    }

    // P <- P - PHt S^-1 PHt', error = PHt S^-1 r
    void update(const Cholesky<m>& S, Covariance& P, Correction& c) const {
        Square<m> inverse = S.template solve<m>(Square<m>(Square<m>::Identity()));
        symmetrise<m>(inverse);
        if (m == 3) note_steps(inverse, c);
        for (int k = 0; k < m; ++k) {
            alignas(16) double gain[row_length] = {};
            for (int l = 0; l < m; ++l)
                for (int i = 0; i < n; ++i) gain[i] += inverse(k, l) * PHt[l][i];
            for (int i = 0; i < n; ++i) {
                c.error[i] += gain[i] * r[k];
                if (gain[i] == 0) continue;
                for (int j = 0; j < n; ++j) P[i][j] -= gain[i] * PHt[k][j];
                for (int j = 0; j < responses; ++j) P.response[i][j] -= gain[i] * HB[k][j];
            }
        }
    }

    void note_steps(const Square<m>& inverse, Correction& c) const {
        const Eigen::Map<const Eigen::Matrix<double, m, responses, Eigen::RowMajor>> all(HB[0]);
        for (int w = 0; w < step_windows; ++w) {
            const Eigen::Matrix<double, m, may_step> one = all.template middleCols<may_step>(w * may_step),
                                                     weighted = inverse * one;
            Eigen::Map<Square<may_step>>(c.steps[w].information) = one.transpose() * weighted;
            Eigen::Map<Eigen::Matrix<double, may_step, 1>>(c.steps[w].sum) = weighted.transpose() * r;
        }
    }
};

template <int m, int n>
Correction correct(Covariance& P, const double* mean, const Measurement& given, double gate_nis) {
    const Projected<m, n> of(P, mean, given);
    const auto total = [&](double known, double noise) {
        Square<m> S = known * of.known;
        for (int k = 0; k < m; ++k) S(k, k) += noise * given.R[k];
        return Cholesky<m>(S);
    };
    Correction result{};
    Cholesky<m> S = total(1, 1);
    result.sound = S.positive();
    if (!result.sound) return result;
    result.nis = of.r.dot(S.template solve<1>(of.r));
    const double over = given.gated ? beyond_gate(result.nis, gate_nis) : 1;
    result.scale = over * over; // redescending
    if (over > 1) S = total(over, result.scale);
    of.update(S, P, result);
    return result;
}

} // namespace

void turn_rows(Covariance& P, int row, const Matrix3& C) {
    const auto turn_columns = [&C](int count, double* a, double* b, double* c) {
        for (int j = 0; j < count; ++j) {
            const Vector3 column = C * Vector3(a[j], b[j], c[j]);
            a[j] = column[0];
            b[j] = column[1];
            c[j] = column[2];
        }
    };
    turn_columns(P.n, P[row], P[row + 1], P[row + 2]);
    turn_columns(responses, P.response[row], P.response[row + 1], P.response[row + 2]);
    for (int j = 0; j < P.n; ++j) {
        const Vector3 line = C * vec(P[j] + row);
        vec(P[j] + row) = line;
    }
}

Correction corrected(Covariance& P, const double* mean, const Measurement& m, double gate_nis) {
    const double gate = gate_for_rows(m.rows, gate_nis);
    Correction c = with_rows(P.n, [&](auto n) {
        if (m.rows == 1) return correct<1, n>(P, mean, m, gate);
        return m.rows == 2 ? correct<2, n>(P, mean, m, gate) : correct<3, n>(P, mean, m, gate);
    });
    if (m.nis >= 0) {
        c.nis = m.nis;
        c.scale = m.scale;
    }
    return c;
}

} // namespace hnav::ins
