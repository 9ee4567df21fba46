// Whether a state that is modelled as almost constant moves by more than the information that moves it allows. A correction that takes its
// variance from P to P' moves the estimate by a number of variance P - P'; so do many of them, in the sum. A sum that is much larger says that
// the state has stepped, or was never as small as its prior. The likeliest step is P times the sum over its variance (generalised likelihood
// ratio, Willsky and Jones 1976): its square is variance that the state has more.
#pragma once

#include "estimation/consistency.hpp"
#include "maths/square.hpp"

#include <cmath>

namespace hnav {

// Part of a filter's state: doubles only.
struct Constancy {
    static constexpr double memory_s = Consistency::window_s[Consistency::windows - 1];

    double moved, due2; // by corrections, and the variance of that

    void note(double change, double variance_taken, double interval_s) {
        const double kept = std::exp(-interval_s / memory_s);
        moved = kept * moved + change;
        due2 = kept * kept * due2 + std::fmax(0, variance_taken);
    }
    // The variance that a state of this variance has more; 0: none. What was summed is forgotten with it. limit: in sigmas of the sum.
    // smallest: what a wrong linearisation moves the state by; a step is larger. largest: no step is larger, and corrections that could not
    // resolve one of that size are ignored.
    double excess(double variance, double smallest, double largest, double limit) {
        if (!(square(moved) > square(limit) * due2 && square(largest) * due2 > square(variance))) return 0;
        const double step = variance * moved / due2;
        if (!(std::fabs(step) > smallest)) return 0;
        moved = due2 = 0;
        return std::fmax(0, std::fmin(square(step), square(largest) - variance));
    }
};

} // namespace hnav
