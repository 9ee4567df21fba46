// Tests the stated sigma of the tilt by its corrections.
//
// In a filter whose models are valid the corrections are white, and the covariance of each is what it takes out of P (Mehra 1970). So
// their sum over a time has a known variance. An acceleration that lasts longer than the filter allows for turns the horizon by many
// corrections in one direction, and the square of the sum exceeds that variance. The excess is the variance of a tilt error that P does
// not contain, and is added to the output variance, where it changes no gain.
#pragma once

#include "maths/rotation.hpp"

#include <algorithm>
#include <cmath>

namespace hnav {

// Part of a filter's state: numbers of one kind only.
template <class R>
struct TiltExcess {
    // The longest time scale of accelerations, as in lasting_motion.hpp. With a shorter time the variance decays before the
    // horizon is right again; with a longer one the gyro drift contained in P hides the excess.
    static constexpr R memory_s = R(12.5);

    R corrected[2]; // sum of the corrections about north and east, decaying over memory_s, rad
    R expected; // variance of it about one axis, rad^2
    R variance; // the excess, rad^2; grows at once, decays over memory_s

    // T: since the last corrections, s.
    void pass(R T) {
        const R kept = memory_s / (memory_s + T);
        for (R& sum : corrected) sum *= kept;
        expected *= kept * kept;
        variance *= kept;
    }

    // One of the corrections of an instant: about north and east, rad. taken: reduction of the variance of one axis, rad^2.
    void note(const R* correction, R taken) {
        R square = 0;
        for (int i = 0; i < 2; ++i) {
            corrected[i] += correction[i];
            square += corrected[i] * corrected[i] / 2;
        }
        expected += std::max(R(0), taken);
        variance = std::max(variance, square - expected);
    }
};

} // namespace hnav
