// The decompositions of the fits, compiled once: they take most of the compile time.
#pragma once

#include <Eigen/Core>

namespace hnav {

template <int n>
using SquareOf = Eigen::Matrix<double, n, n>;
template <int n>
using VectorOf = Eigen::Matrix<double, n, 1>;

// Eigenvalues of a symmetric matrix in increasing order, and its eigenvectors, the columns of `vectors` (may be null).
VectorOf<3> symmetric_eigenvalues(const SquareOf<3>& S, SquareOf<3>* vectors);
VectorOf<10> symmetric_eigenvalues(const SquareOf<10>& S, SquareOf<10>* vectors);
VectorOf<13> symmetric_eigenvalues(const SquareOf<13>& S, SquareOf<13>* vectors);

// The eigenvector of the eigenvalue with the largest real part. False if there is none.
bool largest_eigenvector(const SquareOf<6>& A, VectorOf<6>* vector);

// A^-1 B of a symmetric A by L D L'.
VectorOf<13> solve_symmetric(const SquareOf<13>& A, const VectorOf<13>& B);
SquareOf<13> solve_symmetric(const SquareOf<13>& A, const SquareOf<13>& B);

} // namespace hnav
