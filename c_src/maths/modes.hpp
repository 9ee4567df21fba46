// Eigenvalues of matrices with sizes known at run time, compiled once: they take seconds of compile time in each file.
#pragma once

#include "maths/discretise.hpp"

#include <complex>

namespace hnav {

using Complex = std::complex<double>;
using ComplexVector = Eigen::Matrix<Complex, Eigen::Dynamic, 1, 0, max_dimension, 1>;

// Eigenvalues of a square matrix, in no order; the eigenvectors are the columns of vectors. NaN where Eigen's iteration does not
// converge.
struct Modes {
    ComplexVector values;
    Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, 0, max_dimension, max_dimension> vectors;
};
ComplexVector eigenvalues(const Small& A);
Modes modes(const Small& A);

// Eigenvalues of a symmetric matrix, in increasing order; the eigenvectors are the columns of `vectors`, unless that is null.
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_dimension, 1>;
SmallVector symmetric_eigenvalues(const Small& S, Small* vectors);

} // namespace hnav
