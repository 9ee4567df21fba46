#include "attitude/hrekf/decay_rate.hpp"

namespace hnav {

template struct ErrorMap<Scalar>;
template double decay_rate<Scalar>(const ErrorMap<Scalar>& e);

} // namespace hnav
