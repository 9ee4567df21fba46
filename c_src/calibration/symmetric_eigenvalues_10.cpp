#include "calibration/symmetric_eigenvalues.hpp"

namespace hnav {

VectorOf<3> symmetric_eigenvalues(const SquareOf<3>& S, SquareOf<3>* vectors) { return eigenvalues_of(S, vectors); }
VectorOf<10> symmetric_eigenvalues(const SquareOf<10>& S, SquareOf<10>* vectors) { return eigenvalues_of(S, vectors); }

} // namespace hnav
