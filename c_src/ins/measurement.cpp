#include "ins/measurement.hpp"

#include "estimation/gate.hpp"
#include "maths/cholesky.hpp"

#include <cmath>

namespace hnav::ins {
namespace {

template <int m, int n>
struct Projected {
    Correction& c;
    Square<m> known; // H P H'
    Eigen::Matrix<double, m, 1> r;

    Projected(const Covariance& P, const double* mean, const Measurement& given, Correction& into) : c(into) {
        double seen[m] = {}; // H mean
        known.setZero();
        for (int k = 0; k < m; ++k)
            for (int i = 0; i < n; ++i) {
                const double h = given.H[k][i];
                if (h == 0) continue;
                for (int j = 0; j < n; ++j) c.PHt[k][j] += h * P[i][j];
                for (int j = 0; j < responses; ++j) c.HB[k][j] += h * P.response[i][j];
                seen[k] += h * mean[i];
            }
        for (int k = 0; k < m; ++k) {
            r[k] = given.r[k] - seen[k];
            for (int i = 0; i < n; ++i) {
                if (given.H[k][i] == 0) continue;
                for (int l = 0; l < m; ++l) known(k, l) += given.H[k][i] * c.PHt[l][i];
            }
        }
        symmetrise<m>(known);
    }

    // gain = PHt S^-1, error = gain r
    void solve(const Square<m>& inverse) const {
        for (int k = 0; k < m; ++k) {
            for (int l = 0; l < m; ++l)
                for (int i = 0; i < n; ++i) c.gain[k][i] += inverse(k, l) * c.PHt[l][i];
            for (int i = 0; i < n; ++i) c.error[i] += c.gain[k][i] * r[k];
        }
    }

    // Adds the sample with its stated noise to the evidence for steps, even if it is rejected. excess: its NIS beyond an outlier's.
    void note_steps(const Square<m>& inverse, double excess) const {
        const Eigen::Map<const Eigen::Matrix<double, m, responses, Eigen::RowMajor>> all(c.HB[0]);
        for (int w = 0; w < step_windows; ++w) {
            const Eigen::Matrix<double, m, may_step> one = all.template middleCols<may_step>(w * may_step),
                                                     weighted = inverse * one;
            c.steps[w].excess = excess;
            c.steps[w].add<m>(one, weighted, r);
        }
    }
};

template <int m>
Square<m> inverse_by(const Cholesky<m>& S) {
    Square<m> inverse = S.template solve<m>(Square<m>(Square<m>::Identity()));
    symmetrise<m>(inverse);
    return inverse;
}

template <int m, int n>
Correction correction_by(const Measurement& given, const Covariance& P, const double* mean, double gate_nis) {
    Correction result{};
    const Projected<m, n> of(P, mean, given, result);
    const auto total = [&](double known, double noise) {
        Square<m> S = known * of.known;
        for (int k = 0; k < m; ++k) S(k, k) += noise * given.R[k];
        return Cholesky<m>(S);
    };
    const Cholesky<m> S = total(1, 1);
    result.sound = S.positive();
    if (!result.sound) return result;
    result.nis = of.r.dot(S.template solve<1>(of.r));
    const double over = given.gated ? beyond_gate(result.nis, gate_nis) : 1;
    result.scale = over * over; // redescending
    const Square<m> inverse = inverse_by(S);
    if (m == 3) of.note_steps(inverse, over > 1 ? result.nis - gate_nis : 0);
    of.solve(over > 1 ? inverse_by(total(over, result.scale)) : inverse);
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

Correction correction_by(const Measurement& m, const Covariance& P, const double* mean, double gate_nis) {
    const double gate = gate_for_rows(m.rows, gate_nis);
    Correction c = with_rows(P.n, [&](auto n) {
        if (m.rows == 1) return correction_by<1, n>(m, P, mean, gate);
        return m.rows == 2 ? correction_by<2, n>(m, P, mean, gate) : correction_by<3, n>(m, P, mean, gate);
    });
    if (m.nis >= 0) {
        c.nis = m.nis;
        c.scale = m.scale;
    }
    return c;
}

void reduce(Covariance& P, const Correction& c, int rows) {
    // A difference has the rounding error of its minuend: no variance is allowed to be smaller.
    constexpr double rounding = 1e-14;
    with_rows(P.n, [&](auto n) {
        double least[n];
        for (int i = 0; i < n; ++i) least[i] = rounding * P[i][i];
        for (int k = 0; k < rows; ++k)
            for (int i = 0; i < n; ++i) {
                const double gain = c.gain[k][i];
                if (gain == 0) continue;
                for (int j = 0; j < n; ++j) P[i][j] -= gain * c.PHt[k][j];
                for (int j = 0; j < responses; ++j) P.response[i][j] -= gain * c.HB[k][j];
            }
        for (int i = 0; i < n; ++i) P[i][i] = std::fmax(P[i][i], least[i]);
    });
}

} // namespace hnav::ins
