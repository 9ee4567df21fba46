// A linear aircraft between samples:
//
//   dx/dt = A x + B u + w,   u held from sample to sample
//   x(k) = Ad x(k-1) + Bd u(k-1) + w(k-1),   w ~ (0, Qw)
//
// Ad and Bd are exact. Qw is the variance density of w times the interval (sampled), or the exact integral of continuous
// white noise, which correlates the states (Van Loan 1978, see maths/discretise.hpp).
#pragma once

#include "maths/modes.hpp"

namespace hnav {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, max_dimension, max_dimension>;

struct LinearAircraft {
    RowMajor A, B, Qw; // of one interval
    RowMajor factor;   // lower triangle, factor factor' = Qw

    // A n x n, B n x m, density n (standard deviations per root second), row-major.
    void assign(int n, int m, const double* A_1_s, const double* B_1_s, const double* density, double interval_s,
                bool exact_noise) {
        Small flow(n, n), control(n, m), noise = Small::Zero(n, n);
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) flow(i, j) = A_1_s[i * n + j];
            for (int j = 0; j < m; ++j) control(i, j) = B_1_s[i * m + j];
            noise(i, i) = density[i] * density[i];
        }
        const Discrete d = discretise(flow, control, noise, interval_s);
        A = d.A;
        B = d.B;
        Qw = noise * interval_s;
        if (exact_noise) Qw = d.Q;
        factorise();
    }

    // The eigenvalue of A with the largest real part, 1/s.
    static Complex fastest_growth(int n, const double* A_1_s) {
        Small flow(n, n);
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) flow(i, j) = A_1_s[i * n + j];
        const ComplexVector values = eigenvalues(flow);
        Complex worst = values[0];
        for (int i = 1; i < n; ++i)
            if (values[i].real() > worst.real()) worst = values[i];
        return worst;
    }

private:
    // Cholesky, where a state without noise of its own has an empty column.
    void factorise() {
        const Eigen::Index n = Qw.rows();
        factor = RowMajor::Zero(n, n);
        for (Eigen::Index j = 0; j < n; ++j) {
            const double left = Qw(j, j) - factor.row(j).head(j).squaredNorm();
            if (!(left > 1e-15 * Qw(j, j))) continue;
            factor(j, j) = std::sqrt(left);
            for (Eigen::Index i = j + 1; i < n; ++i)
                factor(i, j) = (Qw(i, j) - factor.row(i).head(j).dot(factor.row(j).head(j))) / factor(j, j);
        }
    }
};

} // namespace hnav
