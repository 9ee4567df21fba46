// How fast the rate changes tells how far off the turn may be while samples of it are missing: after T seconds to within
// a T^2 / 2 by the last rate, and to a T^2 / 8 by the mean of the last and the next, with an angular acceleration a as it was
// before.
#pragma once

#include "signals/sampling.hpp"
#include "maths/rotation.hpp"

namespace hnav {

// Part of a filter's state: a number.
template <class R>
struct RateChange {
    R power; // running mean square of the change per second, of one axis

    void note(const Vector3Of<R>& change, R interval_s) {
        constexpr R memory_s = 2; // longer than a swing of the arm
        const R square = change.squaredNorm() / (3 * interval_s * interval_s);
        power += interval_s / (interval_s + memory_s) * (square - power);
    }

    // Of the rotation about an axis. ended: the sample after the gap is there. factor: of the usual change.
    R gap_variance(R gap_s, bool ended, R factor) const {
        const R share = (ended ? R(0.125) : R(0.5)) * factor * gap_s * gap_s;
        return share * share * power;
    }

    // The same when an estimate is shown silence_s after its newest event; usual_s: between two samples of the rate.
    R silence_variance(double silence_s, double usual_s, R factor) const {
        constexpr R any_angle = R(M_PI * M_PI / 3);
        return is_gap(silence_s, usual_s) ? std::fmin(any_angle, gap_variance(R(silence_s), false, factor)) : 0;
    }
};

} // namespace hnav
