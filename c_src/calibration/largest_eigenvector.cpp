#include "calibration/decompositions.hpp"

#include <Eigen/Eigenvalues>

namespace hnav {

bool largest_eigenvector(const SquareOf<6>& A, VectorOf<6>* vector) {
    const Eigen::EigenSolver<SquareOf<6>> solver(A);
    if (solver.info() != Eigen::Success) return false;
    Eigen::Index largest;
    solver.eigenvalues().real().maxCoeff(&largest);
    *vector = solver.eigenvectors().col(largest).real();
    return true;
}

} // namespace hnav
