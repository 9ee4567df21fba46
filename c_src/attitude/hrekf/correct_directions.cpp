#include "attitude/hrekf/correct_directions.hpp"

namespace hnav {

template void HrekfModelOf<Scalar>::correct_directions(State& s, const Event& event) const;

} // namespace hnav
