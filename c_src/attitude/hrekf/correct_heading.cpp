#include "attitude/hrekf/correct_heading.hpp"

namespace hnav {

template void HrekfModelOf<Scalar>::correct_heading(State& s, const Event& event) const;

} // namespace hnav
