#include "attitude/ahrs/correction.hpp"

#include "attitude/ahrs/correct_field.hpp"
#include "attitude/ahrs/correct_rest.hpp"
#include "attitude/ahrs/correct_velocity.hpp"

namespace hnav {

template void AhrsModelOf<Scalar>::correct(State& s, const Event& event) const;

} // namespace hnav
