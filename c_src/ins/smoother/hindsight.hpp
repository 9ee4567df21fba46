// What hindsight adds to an estimate of the filter, and how it goes back over one step: mathematics alone. It knows states and steps of
// the filter, and nothing of recordings or of the order in which a smoother goes through them.
#pragma once

#include "ins/model.hpp"

namespace hnav::ins {

// An error of an estimate, in its axes, and the covariance that is left.
struct Hindsight {
    double error[errors];
    Covariance P;
};

// Another state of the same time, with hindsight.
struct Target {
    State state;
    Covariance P;
};

// now: P of the filter just after the correction before the step, and what comes of it. False: the covariance before the samples is not
// positive, and nothing is told.
bool step_back(const Step& step, const Hindsight& after, Hindsight* now);
// What the target is more than a state.
Hindsight seen_from(const State& state, const Target& target);
// Before the samples of a step that led to a state, in the axes before its anchor moved.
Hindsight before_samples(const Step& step, Hindsight h, const State& after);

} // namespace hnav::ins
