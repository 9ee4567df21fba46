// What keeps a covariance matrix one when rounding or a coarse integrator has made it indefinite.
#pragma once

#include "maths/cholesky.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>

namespace hnav {

// A singular covariance is legal (a unit quaternion has no error along itself), so the test is a Cholesky factorisation
// of P + 1e-12 tr(P) I. True when P had to be repaired: negative eigenvalues are set to zero.
template <int n, class R>
bool repair(Square<n, R>& P) {
    constexpr R share = std::max(R(1e-12), 4 * std::numeric_limits<R>::epsilon());
    constexpr R tiny = std::max(R(1e-300), std::numeric_limits<R>::min()); // the zero matrix is legal too
    const R shift = share * P.trace() + tiny;
    Square<n, R> shifted = P;
    shifted.diagonal().array() += shift;
    if (Cholesky<n, R>(shifted).positive()) return false;
    const Eigen::SelfAdjointEigenSolver<Square<n, R>> eigen(P);
    P = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
    symmetrise<n>(P);
    return true;
}

} // namespace hnav
