// Shared by the files of the aids: correct_by, which each of them instantiates.
#pragma once

#include "attitude/ahrs/condition.hpp"

namespace hnav {

template <class R>
template <class OneAid>
void AhrsModelOf<R>::correct_by(State& s, Correction& c, const Event& event) const {
    OneAid::correct(*this, s, c, event);
}

} // namespace hnav
