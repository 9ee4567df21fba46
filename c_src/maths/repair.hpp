// Repair of a covariance matrix that is indefinite because of rounding or a coarse integrator.
#pragma once

#include "maths/cholesky.hpp"
#include "maths/jacobi.hpp"

#include <algorithm>
#include <limits>

namespace hnav {

// The nearest matrix without negative eigenvalues.
template <int n, class R>
void clip_eigenvalues(Square<n, R>& P) {
    const Jacobi<n, R> jacobi(P);
    const Eigen::Matrix<R, n, 1> values = P.diagonal().cwiseMax(R(0));
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) {
            R sum = 0;
            for (int k = 0; k < n; ++k) sum += values[k] * jacobi.V(i, k) * jacobi.V(j, k);
            P(i, j) = P(j, i) = sum;
        }
}

// A function of its own, so that its factor, as large as the matrix, is off the stack before further calls.
template <int n, class R>
__attribute__((noinline)) bool is_positive(const Square<n, R>& P) {
    return Cholesky<n, R>(P).positive();
}

// A singular covariance is legal (a unit quaternion has no error along itself), so the test is a Cholesky factorisation
// of P + 1e-12 tr(P) I. True when P had to be repaired: negative eigenvalues are set to zero.
template <int n, class R>
bool repair(Square<n, R>& P) {
    constexpr R share = std::max(R(1e-12), 4 * std::numeric_limits<R>::epsilon());
    constexpr R tiny = std::max(R(1e-300), std::numeric_limits<R>::min()); // the zero matrix is legal too
    const R shift = share * P.trace() + tiny;
    const Eigen::Matrix<R, n, 1> variances = P.diagonal();
    P.diagonal().array() += shift;
    const bool positive = is_positive<n, R>(P);
    P.diagonal() = variances;
    if (positive) return false;
    clip_eigenvalues<n, R>(P);
    return true;
}

} // namespace hnav
