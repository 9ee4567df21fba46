#include "maths/modes.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace hnav {

static Modes solved(const Small& A, bool with_vectors) {
    const Eigen::EigenSolver<Small> solver(A, with_vectors);
    if (solver.info() != Eigen::Success)
        return {ComplexVector::Constant(A.rows(), std::nan("")), Small::Zero(A.rows(), A.cols())};
    Modes found{solver.eigenvalues(), {}};
    if (with_vectors) found.vectors = solver.eigenvectors();
    return found;
}

ComplexVector eigenvalues(const Small& A) { return solved(A, false).values; }
Modes modes(const Small& A) { return solved(A, true); }

} // namespace hnav
