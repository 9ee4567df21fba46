// What keeps a covariance matrix one when rounding or a coarse integrator has made it indefinite.
#pragma once

#include "maths/cholesky.hpp"

#include <Eigen/Eigenvalues>

namespace hnav {

// A singular covariance is legal (a unit quaternion has no error along itself), so the test is a Cholesky factorisation
// of P + 1e-12 tr(P) I. True when P had to be repaired: negative eigenvalues are set to zero.
template <int n>
bool repair(Square<n>& P) {
    const double shift = 1e-12 * P.trace() + 1e-300; // the zero matrix is legal too
    Square<n> shifted = P;
    shifted.diagonal().array() += shift;
    if (Cholesky<n>(shifted).positive()) return false;
    const Eigen::SelfAdjointEigenSolver<Square<n>> eigen(P);
    P = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
    symmetrise<n>(P);
    return true;
}

} // namespace hnav
