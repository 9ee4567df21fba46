// With sizes that are known at run time only: one instance of each of Eigen's solvers instead of one for each size, in half of the
// compile time.
#include "calibration/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace hnav {
namespace {

constexpr int largest_size = 13;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, largest_size, largest_size>;

template <int n>
VectorOf<n> eigenvalues_of(const SquareOf<n>& S, SquareOf<n>* vectors) {
    const Eigen::SelfAdjointEigenSolver<Square> solver(Square(S), vectors ? Eigen::ComputeEigenvectors : Eigen::EigenvaluesOnly);
    if (vectors) *vectors = solver.eigenvectors();
    return solver.eigenvalues();
}

} // namespace

VectorOf<3> symmetric_eigenvalues(const SquareOf<3>& S, SquareOf<3>* vectors) { return eigenvalues_of(S, vectors); }
VectorOf<10> symmetric_eigenvalues(const SquareOf<10>& S, SquareOf<10>* vectors) { return eigenvalues_of(S, vectors); }
VectorOf<13> symmetric_eigenvalues(const SquareOf<13>& S, SquareOf<13>* vectors) { return eigenvalues_of(S, vectors); }

bool largest_eigenvector(const SquareOf<6>& A, VectorOf<6>* vector) {
    const Eigen::EigenSolver<Square> solver{Square(A)};
    if (solver.info() != Eigen::Success) return false;
    Eigen::Index largest;
    solver.eigenvalues().real().maxCoeff(&largest);
    *vector = solver.eigenvectors().col(largest).real();
    return true;
}

SquareOf<13> solve_symmetric(const SquareOf<13>& A, const SquareOf<13>& B) { return Square(A).ldlt().solve(Square(B)); }
VectorOf<13> solve_symmetric(const SquareOf<13>& A, const VectorOf<13>& B) { return Square(A).ldlt().solve(B); }

} // namespace hnav
