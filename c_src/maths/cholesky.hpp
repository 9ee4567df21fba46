// Factorisation A = L D L' (L unit lower triangular, D diagonal) of matrices with sizes known at compile time. Eigen's uses
// code for large matrices; for the 3 to 7 rows of a correction these loops take a third of its time, and D avoids the square
// roots.
#pragma once

#include "maths/covariance.hpp"
#include "maths/unroll.hpp"

namespace hnav {

template <int n, class R = double>
class Cholesky {
public:
    template <int k>
    using Rows = Eigen::Matrix<R, n, k, k == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

    Cholesky() = default; // of nothing yet
    explicit Cholesky(const Square<n, R>& A) {
        HNAV_UNROLL
        for (int j = 0; j < n; ++j) {
            R scaled[n]; // L_jk D_k
            R d = A(j, j);
            HNAV_UNROLL
            for (int k = 0; k < j; ++k) {
                scaled[k] = L_[j][k] * d_[k];
                d -= L_[j][k] * scaled[k];
            }
            positive_ = positive_ && d > 0; // false for NaN too
            d_[j] = d;
            inverse_d_[j] = 1 / d;
            HNAV_UNROLL
            for (int i = j + 1; i < n; ++i) {
                R sum = A(i, j);
                HNAV_UNROLL
                for (int k = 0; k < j; ++k) sum -= L_[i][k] * scaled[k];
                L_[i][j] = sum * inverse_d_[j];
            }
        }
    }

    bool positive() const { return positive_; }

    // In double: six informations about a gyro bias and about iron have a product beyond the range of a float.
    double determinant() const {
        double product = d_[0];
        for (int i = 1; i < n; ++i) product *= d_[i];
        return product;
    }

    // A^-1 B
    template <int k>
    Rows<k> solve(const Rows<k>& right) const {
        Rows<k> B = forward<k>(right);
        for (int i = 0; i < n; ++i) B.row(i) *= inverse_d_[i];
        HNAV_UNROLL
        for (int i = n - 2; i >= 0; --i) {
            HNAV_UNROLL
            for (int j = i + 1; j < n; ++j) B.row(i) -= L_[j][i] * B.row(j);
        }
        return B;
    }

    // P += B' A^-1 B
    template <int k>
    void add_quadratic_form(const Rows<k>& right, Square<k, R>& P) const {
        const Rows<k> B = forward<k>(right);
        Rows<k> scaled = B;
        for (int i = 0; i < n; ++i) scaled.row(i) *= inverse_d_[i];
        if constexpr (n > 2) {
            P += B.transpose() * scaled;
        } else { // column by column: Eigen would use its code for large matrices
            const Eigen::Matrix<R, k, n> Bt = B.transpose();
            for (int j = 0; j < k; ++j) {
                Eigen::Matrix<R, k, 1> column = scaled(0, j) * Bt.col(0);
                for (int i = 1; i < n; ++i) column += scaled(i, j) * Bt.col(i);
                P.col(j) += column;
            }
        }
    }

    // b' A^-1 b
    R quadratic_form(const Rows<1>& right) const {
        const Rows<1> b = forward<1>(right);
        Rows<1> scaled = b;
        for (int i = 0; i < n; ++i) scaled[i] *= inverse_d_[i];
        return b.dot(scaled);
    }

private:
    // L^-1 B
    template <int k>
    Rows<k> forward(Rows<k> B) const {
        HNAV_UNROLL
        for (int i = 1; i < n; ++i) {
            HNAV_UNROLL
            for (int j = 0; j < i; ++j) B.row(i) -= L_[i][j] * B.row(j);
        }
        return B;
    }

    R L_[n][n]; // below the diagonal
    R d_[n], inverse_d_[n];
    bool positive_ = true;
};

// innovation' S^-1 innovation; 0 where S has no sign.
template <int m, class R>
inline R normalised_square(const Square<m, R>& S, const Eigen::Matrix<R, m, 1>& innovation) {
    const Cholesky<m, R> factor(S);
    return factor.positive() ? factor.quadratic_form(innovation) : 0;
}

} // namespace hnav
