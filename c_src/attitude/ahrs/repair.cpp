// Compiled once: eigenvectors of a matrix of this size take seconds of compile time wherever they are used.
#include "maths/repair.hpp"
#include "attitude/ahrs/state.hpp"
#include "maths/scalar.hpp"

namespace hnav {

template bool repair<AhrsErrors::errors>(Square<AhrsErrors::errors, Scalar>& P);

} // namespace hnav
