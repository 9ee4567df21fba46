// Eigenvalues of matrices with sizes known at run time, compiled once: they take seconds of compile time in each file.
#pragma once

#include "maths/discretise.hpp"

#include <complex>

namespace hnav {

using Complex = std::complex<double>;
using ComplexVector = Eigen::Matrix<Complex, Eigen::Dynamic, 1, 0, max_dimension, 1>;

// Of a square matrix, in no order; the eigenvectors are the columns of vectors.
struct Modes {
    ComplexVector values;
    Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, 0, max_dimension, max_dimension> vectors;
};
ComplexVector eigenvalues(const Small& A);
Modes modes(const Small& A);

// Of a symmetric matrix.
double smallest_eigenvalue(const Small& S);

} // namespace hnav
