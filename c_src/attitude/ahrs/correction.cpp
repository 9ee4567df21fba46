#include "attitude/ahrs/correction.hpp"

namespace hnav {

template void AhrsModelOf<Scalar>::correct(State& s, const Event& event) const;

} // namespace hnav
