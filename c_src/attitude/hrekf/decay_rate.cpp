#include "attitude/hrekf/decay_rate.hpp"

namespace hnav {

template struct ErrorMap<double>;
template double decay_rate<double>(const ErrorMap<double>& e);

} // namespace hnav
