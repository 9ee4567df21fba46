// Eigenvalues of a small symmetric matrix, in ascending order.
#pragma once

#include "maths/covariance.hpp"

#include <Eigen/Eigenvalues>

namespace hnav {

// The steps of Eigen's SelfAdjointEigenSolver. Called as a whole it would bring its code for eigenvectors along, which
// takes five times as long to compile as all of this. Reads the lower triangle.
template <int n, class R = double>
Eigen::Matrix<R, n, 1> eigenvalues(const Square<n, std::common_type_t<R>>& A) {
    const Square<n, R> lower = A.template triangularView<Eigen::Lower>();
    const R largest = lower.cwiseAbs().maxCoeff();
    const R scale = largest == 0 ? 1 : largest; // with elements within [-1, 1] no square overflows
    const Eigen::Tridiagonalization<Square<n, R>> tridiagonal(lower / scale);
    Eigen::SelfAdjointEigenSolver<Square<n, R>> solver;
    solver.computeFromTridiagonal(tridiagonal.diagonal(), tridiagonal.subDiagonal(), Eigen::EigenvaluesOnly);
    return solver.eigenvalues() * scale;
}

} // namespace hnav
