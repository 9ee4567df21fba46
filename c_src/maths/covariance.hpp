// Covariance matrices: symmetric, packed without loss.
#pragma once

#include <Eigen/Core>

namespace hnav {

template <int n>
using Square = Eigen::Matrix<double, n, n>;

// Upper triangle, row by row: n (n + 1) / 2 numbers.
template <int n>
inline void pack(const Square<n>& P, double* upper) {
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) *upper++ = P(i, j);
}

template <int n>
inline Square<n> unpack(const double* upper) {
    Square<n> P;
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) P(i, j) = P(j, i) = *upper++;
    return P;
}

template <int n>
inline void symmetrise(Square<n>& P) {
    for (int i = 0; i < n; ++i)
        for (int j = i + 1; j < n; ++j) P(i, j) = P(j, i) = 0.5 * (P(i, j) + P(j, i));
}

} // namespace hnav
