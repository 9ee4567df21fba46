// Blocks of a matrix with sizes known at compile time. The same as Eigen's members of these names, which in a template on the
// scalar would be written A.template middleCols<n>(first).
#pragma once

#include <Eigen/Core>

namespace hnav {

template <int n, class Matrix>
inline auto rows(Matrix& A, int first) {
    return A.template middleRows<n>(first);
}

template <int n, class Matrix>
inline auto columns(Matrix& A, int first) {
    return A.template middleCols<n>(first);
}

template <int m, int n, class Matrix>
inline auto block(Matrix& A, int row, int column) {
    return A.template block<m, n>(row, column);
}

// n elements of the diagonal.
template <int n, class Matrix>
inline auto diagonal(Matrix& A, int first) {
    return A.diagonal().template segment<n>(first);
}

template <int n, class Vector>
inline auto segment(Vector& v, int first) {
    return v.template segment<n>(first);
}

} // namespace hnav
