// Whether the sigma of the tilt is true, from the corrections of the tilt.
//
// In a filter whose models are valid the corrections are white, and the covariance of each is what it takes out of P (Mehra 1970). So
// their sum over a time has a known variance. An acceleration that lasts longer than the filter allows for turns the horizon by many
// corrections in one direction, and the square of the sum exceeds that variance. The excess is the variance of a tilt error that P does
// not contain: it is added to the output variance and changes no gain.
#pragma once

#include "maths/rotation.hpp"

#include <cmath>

namespace hnav {

// Part of a filter's state: numbers of one kind only.
template <class R>
struct TiltExcess {
    // The longest time over which accelerations are looked for, as in lasting_motion.hpp. Shorter, the variance ends before the horizon is
    // right again; longer, a gyroscope's drift that P contains hides the excess.
    static constexpr R memory_s = R(12.5);

    R corrected[2]; // sum of the corrections about north and east, fading over memory_s, rad
    R expected; // variance of it about one axis, rad^2
    R variance; // the excess, at once when it grows, fading over memory_s, rad^2

    // correction: about north and east, rad; taken: what it took out of the variance of one axis, rad^2; T: since the last one, s.
    void note(const R* correction, R taken, R T) {
        const R kept = memory_s / (memory_s + T);
        R square = 0;
        for (int i = 0; i < 2; ++i) {
            corrected[i] = kept * corrected[i] + correction[i];
            square += corrected[i] * corrected[i] / 2;
        }
        expected = kept * kept * expected + std::fmax(R(0), taken);
        variance = std::fmax(kept * variance, square - expected);
    }
};

} // namespace hnav
