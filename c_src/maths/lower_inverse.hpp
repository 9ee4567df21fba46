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
        for (int j = 0; j < n; ++j) {
            double d = A(j, j);
            for (int k = 0; k < j; ++k) d -= L(j, k) * L(j, k);
            if (!(d > 0)) return false; // NaN too
            const double inverse_root = 1 / std::sqrt(d);
            W(j, j) = inverse_root;
            for (int i = j + 1; i < n; ++i) {
                double sum = A(i, j);
                for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
                L(i, j) = sum * inverse_root;
            }
        }
        for (int i = 0; i < n; ++i) {
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

    // Of A.
    double log_determinant() const {
        double sum = 0;
        for (int j = 0; j < n_; ++j) sum -= 2 * std::log(W(j, j));
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
