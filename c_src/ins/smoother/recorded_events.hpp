// A recording as the filter meets it, event after event, and what one event does to a state. Every way through a recording, there and
// once more, goes by these, so that they all lead to the same bits.
#pragma once

#include "ins/smoother/smoother.hpp"

#include <cstddef>

namespace hnav::ins {

// How far a way has come: the first row and the first aid that are left.
struct Place {
    std::size_t row, aid;
};

// The next event up to the time of the row, whose own sample of rate and force acts with the first event of its time; false: there
// is none.
bool next_event(Recording& recording, Place& p, std::size_t row, Event* event);
// As Filter does it: an event that leads to no sound state is left out.
void step_over(const Model& model, State& s, const Event& event);
// Brings a state to a time after its last event; answers how far that is.
double look_ahead(const Model& model, double to_s, State& s);

} // namespace hnav::ins
