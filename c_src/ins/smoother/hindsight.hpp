// Mathematics of one backward step of the smoother. It depends on states and steps of the filter, not on recordings or on the order in
// which the smoother processes them.
#pragma once

#include "ins/model.hpp"

namespace hnav::ins {

// Smoothed minus filtered estimate, in the axes of the filtered one, and the smoothed covariance.
struct Hindsight {
    double error[errors];
    Covariance P;
};

// A smoothed state of the same time with another point of linearisation.
struct Target {
    State state;
    Covariance P;
};

// now: in, P of the filter just after the correction before the step; out, the smoothed error and covariance. Returns false if the
// covariance before the samples is not positive definite.
bool step_back(const Step& step, const Hindsight& after, Hindsight* now);
// The target as an error of a state.
Hindsight seen_from(const State& state, const Target& target);
// Whether hindsight is of use: with more samples it is sharper than the filter, and where the fixes are, unless inconsistencies have enlarged
// it one after another. Without this limit the positions of an aircraft whose gyroscope steps are 2 km off, with it 2 m.
bool is_of_use(const State& filtered, const Hindsight& h);
// Whether hindsight is where the filter expected it: beyond that an error has stepped, or the linearisation is another one.
bool is_expected(const State& filtered, const Hindsight& h, int row, int rows);
// The error before the samples of the step that led to the state `after`, in the axes before its anchor moved.
Hindsight before_samples(const Step& step, Hindsight h, const State& after);

} // namespace hnav::ins
