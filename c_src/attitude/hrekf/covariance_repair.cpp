// Compiled once: eigenvectors of a 7 x 7 matrix take seconds of compile time wherever they are used.
#include "maths/repair.hpp"

namespace hnav {

template bool repair<7>(Square<7>& P);

} // namespace hnav
