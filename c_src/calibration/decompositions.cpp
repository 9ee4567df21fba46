#include "calibration/decompositions.hpp"

#include "maths/modes.hpp"

#include <Eigen/Cholesky>

namespace hnav {
namespace {

template <int n>
VectorOf<n> eigenvalues_of(const SquareOf<n>& S, SquareOf<n>* vectors) {
    Small found;
    const SmallVector values = symmetric_eigenvalues(S, vectors ? &found : nullptr);
    if (vectors) *vectors = found;
    return values;
}

} // namespace

VectorOf<3> symmetric_eigenvalues(const SquareOf<3>& S, SquareOf<3>* vectors) { return eigenvalues_of(S, vectors); }
VectorOf<10> symmetric_eigenvalues(const SquareOf<10>& S, SquareOf<10>* vectors) { return eigenvalues_of(S, vectors); }
VectorOf<13> symmetric_eigenvalues(const SquareOf<13>& S, SquareOf<13>* vectors) { return eigenvalues_of(S, vectors); }

bool largest_eigenvector(const SquareOf<6>& A, VectorOf<6>* vector) {
    const Modes of_A = modes(A);
    if (!of_A.values.real().allFinite()) return false;
    Eigen::Index largest;
    of_A.values.real().maxCoeff(&largest);
    *vector = of_A.vectors.col(largest).real();
    return true;
}

SquareOf<13> solve_symmetric(const SquareOf<13>& A, const SquareOf<13>& B) { return Small(A).ldlt().solve(Small(B)); }
VectorOf<13> solve_symmetric(const SquareOf<13>& A, const VectorOf<13>& B) { return Small(A).ldlt().solve(B); }

} // namespace hnav
