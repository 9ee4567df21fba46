// Compiled once: eigenvectors of a 20 x 20 matrix take seconds of compile time wherever they are used.
#include "maths/repair.hpp"
#include "maths/scalar.hpp"

namespace hnav {

template bool repair<20>(Square<20, Scalar>& P);

} // namespace hnav
