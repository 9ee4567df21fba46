// Covariance matrices: symmetric, packed without loss. Of any scalar R, double unless said otherwise.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <type_traits>

namespace hnav {

template <int n, class R = double>
using Square = Eigen::Matrix<R, n, n>;

// The upper triangle, row by row: n (n + 1) / 2 numbers. P may be an expression, so the scalar is that of the triangle.
template <int n, class R>
inline void pack(const Square<n, std::common_type_t<R>>& P, R* upper) {
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) *upper++ = P(i, j);
}

template <int n, class R>
inline Square<n, R> unpack(const R* upper) {
    Square<n, R> P;
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) P(i, j) = P(j, i) = *upper++;
    return P;
}

template <int n, class R>
inline void symmetrise(Square<n, R>& P) {
    for (int i = 0; i < n; ++i)
        for (int j = i + 1; j < n; ++j) P(i, j) = P(j, i) = R(0.5) * (P(i, j) + P(j, i));
}

// A variance beside others of its kind. Rounding of the largest, or a coarse integrator such as Euler's, may make it zero or
// negative: the result is at least the rounding, and at least the absolute value. No sigma is therefore 0.
template <class Vector>
inline typename Vector::PlainObject honest_variances(const Eigen::MatrixBase<Vector>& variances) {
    using R = typename Vector::Scalar;
    const typename Vector::PlainObject size = variances.cwiseAbs();
    return size.cwiseMax(std::max(std::numeric_limits<R>::min(), std::numeric_limits<R>::epsilon() * size.sum()));
}

} // namespace hnav
