// The events of a recording, and the filter's step over one event. All passes over a recording use these functions, so that they
// produce the same bits.
#pragma once

#include "ins/smoother/smoother.hpp"

#include <cstddef>

namespace hnav::ins {

// The next row and the next aid of a pass.
struct Place {
    std::size_t row, aid;
};

// The next event up to the time of the row. The row's own IMU sample belongs to the first event of its time. Returns false if there is
// none.
bool next_event(Recording& recording, Place& p, std::size_t row, Event* event);
// As in Filter: an event that leads to an unsound state is ignored.
void step_over(const Model& model, State& s, const Event& event);
// Propagates a state to a time after its last event. Returns the interval in s.
double look_ahead(const Model& model, double to_s, State& s);

} // namespace hnav::ins
