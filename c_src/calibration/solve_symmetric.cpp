#include "calibration/decompositions.hpp"

#include <Eigen/Cholesky>

namespace hnav {

VectorOf<13> solve_symmetric(const SquareOf<13>& A, const VectorOf<13>& B) { return A.ldlt().solve(B); }
SquareOf<13> solve_symmetric(const SquareOf<13>& A, const SquareOf<13>& B) { return A.ldlt().solve(B); }

} // namespace hnav
