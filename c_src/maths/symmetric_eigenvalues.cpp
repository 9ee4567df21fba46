#include "maths/modes.hpp"

#include <Eigen/Eigenvalues>

namespace hnav {

SmallVector symmetric_eigenvalues(const Small& S, Small* vectors) {
    const Eigen::SelfAdjointEigenSolver<Small> solver(S, vectors ? Eigen::ComputeEigenvectors : Eigen::EigenvaluesOnly);
    if (vectors) *vectors = solver.eigenvectors();
    return solver.eigenvalues();
}

} // namespace hnav
