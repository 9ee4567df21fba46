// What the files of the aids share: correct_by, which they instantiate for their own.
#pragma once

#include "attitude/ahrs/condition.hpp"

namespace hnav {

template <class R>
template <class OneAid>
void AhrsModelOf<R>::correct_by(State& s, Correction& c, const Event& event) const {
    OneAid::correct(*this, s, c, event);
}

} // namespace hnav
