// The upper triangle of a covariance, packed column by column: a column is contiguous both there and in the matrix, and is
// moved by loads and stores of a length known at compile time; without Eigen, because one type for each length takes a third of
// the compile time of a filter. For large matrices; in the small build by loops.
#pragma once

#include "base/small.hpp"
#include "maths/covariance.hpp"
#include "maths/unroll.hpp"

#include <utility>

namespace hnav {

// Place of the element i, j, i <= j.
constexpr int place_in_columns(int i, int j) { return j * (j + 1) / 2 + i; }

// Unrolled: the compiler would make a call of the library of a loop.
template <int length, class R>
inline void copy_column(const R* from, R* to) {
    R column[length];
    HNAV_UNROLL
    for (int i = 0; i < length; ++i) column[i] = from[i];
    HNAV_UNROLL
    for (int i = 0; i < length; ++i) to[i] = column[i];
}

template <int n, class R, int... j>
inline void pack_each(const Square<n, R>& P, R* upper, std::integer_sequence<int, j...>) {
    (copy_column<j + 1>(&P.coeffRef(0, j), upper + place_in_columns(0, j)), ...);
}

template <int n, class R>
inline void pack_columns(const Square<n, std::common_type_t<R>>& P, R* upper) {
    if constexpr (small_build) {
        for (int j = 0; j < n; ++j)
            for (int i = 0; i <= j; ++i) *upper++ = P(i, j);
    } else {
        pack_each<n, R>(P, upper, std::make_integer_sequence<int, n>());
    }
}

// A column down to the diagonal, and the row that is its mirror image.
template <int j, int n, class R>
inline void unpack_column(const R* column, Square<n, R>& P) {
    copy_column<j + 1>(column, &P.coeffRef(0, j));
    HNAV_UNROLL
    for (int i = 0; i < j; ++i) P(j, i) = column[i];
}

template <int n, class R, int... j>
inline void unpack_each(const R* upper, Square<n, R>& P, std::integer_sequence<int, j...>) {
    (unpack_column<j>(upper + place_in_columns(0, j), P), ...);
}

template <int n, class R>
inline Square<n, R> unpack_columns(const R* upper) {
    Square<n, R> P;
    if constexpr (small_build) {
        for (int j = 0; j < n; ++j)
            for (int i = 0; i <= j; ++i) P(i, j) = P(j, i) = *upper++;
    } else {
        unpack_each<n, R>(upper, P, std::make_integer_sequence<int, n>());
    }
    return P;
}

} // namespace hnav
