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
    for (int k = 0; k < m; ++k) {
        result.innovation[k] = of.r[k];
        result.variance[k] = of.known(k, k) + given.R[k] / given.scale;
    }
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

// Of three rows.
template <int count, int stride>
void turn_columns(const Matrix3& C, double (*rows)[stride]) {
    using Columns = Eigen::Matrix<double, 3, count, Eigen::RowMajor>;
    Eigen::Map<Columns, 0, Eigen::OuterStride<stride>> columns(*rows);
    columns = Columns(C.lazyProduct(columns));
}

} // namespace

void turn_rows(Covariance& P, int row, const Matrix3& C) {
    with_rows(P.n, [&](auto n) {
        turn_columns<n>(C, P.P + row);
        for (int j = 0; j < n; ++j) {
            const Vector3 line = C * vec(P[j] + row);
            vec(P[j] + row) = line;
        }
    });
    turn_columns<responses>(C, P.response + row);
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
        for (int i = 0; i < n; ++i) {
            const double g0 = c.gain[0][i], g1 = c.gain[1][i], g2 = c.gain[2][i]; // 0 beyond the rows
            if (rows == 1) {
                for (int j = 0; j < n; ++j) P[i][j] -= g0 * c.PHt[0][j];
                for (int j = 0; j < responses; ++j) P.response[i][j] -= g0 * c.HB[0][j];
            } else {
                for (int j = 0; j < n; ++j) P[i][j] -= g0 * c.PHt[0][j] + g1 * c.PHt[1][j] + g2 * c.PHt[2][j];
                for (int j = 0; j < responses; ++j) P.response[i][j] -= g0 * c.HB[0][j] + g1 * c.HB[1][j] + g2 * c.HB[2][j];
            }
        }
        for (int i = 0; i < n; ++i) P[i][i] = std::fmax(P[i][i], least[i]);
    });
}

} // namespace hnav::ins
