#include "attitude/ahrs/correct_heading.hpp"

namespace hnav {

template void AhrsModelOf<Scalar>::correct_heading(State& s, Correction& c, const Event& event) const;

} // namespace hnav
