#include "attitude/hrekf/decay_rate.hpp"

namespace hnav {

template double decay_rate<Scalar>(const ErrorMap<Scalar>& e, const Scalar* P);

} // namespace hnav
