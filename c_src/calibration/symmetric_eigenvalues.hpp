#pragma once

#include "calibration/decompositions.hpp"

#include <Eigen/Eigenvalues>

namespace hnav {

template <int n>
VectorOf<n> eigenvalues_of(const SquareOf<n>& S, SquareOf<n>* vectors) {
    const Eigen::SelfAdjointEigenSolver<SquareOf<n>> solver(S, vectors ? Eigen::ComputeEigenvectors : Eigen::EigenvaluesOnly);
    if (vectors) *vectors = solver.eigenvectors();
    return solver.eigenvalues();
}

} // namespace hnav
