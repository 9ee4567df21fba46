#include "maths/pseudo_inverse.hpp"

#include <Eigen/QR>

namespace hnav {

Small pseudo_inverse(const Small& A) { return Eigen::CompleteOrthogonalDecomposition<Small>(A).pseudoInverse(); }

} // namespace hnav
