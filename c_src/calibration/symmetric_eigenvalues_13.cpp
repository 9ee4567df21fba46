#include "calibration/symmetric_eigenvalues.hpp"

namespace hnav {

VectorOf<13> symmetric_eigenvalues(const SquareOf<13>& S, SquareOf<13>* vectors) { return eigenvalues_of(S, vectors); }

} // namespace hnav
