// A = L L' and W = L^-1 for run-time sizes: A^-1 = W'W gives solutions, and the diagonal of A^-1, which conditional
// (leave-one-out) innovations need.
#pragma once

#include "maths/matrix_arena.hpp"

#include <cmath>

namespace hnav {

class LowerInverse {
public:
    LowerInverse(MatrixArena& arena, int capacity)
        : capacity_(capacity),
          L_(arena.doubles(capacity * capacity)),
          W_(arena.doubles(capacity * capacity)),
          half_(arena.doubles(capacity)) {}

    // Takes the lower triangle of the leading n x n block. False: A is not positive definite.
    bool factor(const Matrix& A, int n) {
        n_ = n;
        // Row by row: each element needs the rows above it alone.
        for (int i = 0; i < n; ++i) {
            const double* __restrict from = A.data() + i * A.cols();
            double* __restrict row = L_ + i * capacity_;
            double d = from[i];
            for (int j = 0; j < i; ++j) {
                const double* above = L_ + j * capacity_;
                double sum = from[j];
                for (int k = 0; k < j; ++k) sum -= row[k] * above[k];
                row[j] = sum * W_[j * capacity_ + j];
                d -= row[j] * row[j];
            }
            if (!(d > 0)) return false; // NaN too
            W_[i * capacity_ + i] = 1 / std::sqrt(d);
        }
        for (int i = 0; i < n_; ++i) {
            for (int j = 0; j < i; ++j) W(i, j) = 0;
            for (int k = 0; k < i; ++k) {
                const double factor = -L(i, k) * W(i, i);
                for (int j = 0; j <= k; ++j) W(i, j) += factor * W(k, j);
            }
        }
        return true;
    }

    // x = A^-1 b
    void solve(const double* b, double* x) const {
        for (int i = 0; i < n_; ++i) {
            half_[i] = 0;
            for (int j = 0; j <= i; ++j) half_[i] += W(i, j) * b[j];
        }
        for (int j = 0; j < n_; ++j) {
            x[j] = 0;
            for (int i = j; i < n_; ++i) x[j] += W(i, j) * half_[i];
        }
    }

    // (A^-1)_jj
    double inverse_diagonal(int j) const {
        double sum = 0;
        for (int i = j; i < n_; ++i) sum += W(i, j) * W(i, j);
        return sum;
    }

    // (A^-1)_ij
    double inverse(int i, int j) const {
        double sum = 0;
        for (int k = i > j ? i : j; k < n_; ++k) sum += W(k, i) * W(k, j);
        return sum;
    }

private:
    double& L(int i, int j) const { return L_[i * capacity_ + j]; }
    double& W(int i, int j) const { return W_[i * capacity_ + j]; }

    int capacity_;
    int n_ = 0;
    double* L_;
    double* W_;
    double* half_;
};

} // namespace hnav
