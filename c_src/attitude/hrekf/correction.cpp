// Compiled once: eigenvalues and vectors take seconds of compile time wherever they are used.
#include "attitude/hrekf/correction.hpp"

namespace hnav {

template bool repair<6>(Square<6, Scalar>& P);
template class HrekfCorrection<Scalar>;

} // namespace hnav
