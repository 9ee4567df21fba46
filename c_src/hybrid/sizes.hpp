// Sizes of a model's events and states: known at compile time, which saves memory and time, or at creation.
#pragma once

#include "base/small.hpp"
#include "hybrid/event.hpp"

namespace hnav {

// The state of a model with sizes known at run time: its numbers begin here, continuous states first.
class RuntimeState {
public:
    double* x() { return reinterpret_cast<double*>(this); }
    const double* x() const { return reinterpret_cast<const double*>(this); }

private:
    [[maybe_unused]] double first_;
};

template <class Event_, class State_>
struct FixedSizes {
    using Event = Event_;
    using State = State_;
    // Number of states, whatever the number of events; 0: each event has its own. Three suffice for an open event, the base
    // before it, and the state being computed or shown.
    static constexpr int states = small_build ? 3 : 0;
    static_assert(sizeof(Event) % 8 == 0 && sizeof(State) % 8 == 0, "events and states are saved as 8-byte numbers");

    static constexpr std::size_t event_bytes() { return sizeof(Event); }
    static constexpr std::size_t state_bytes() { return sizeof(State); }
    static void clear(Event& event, double t_s) {
        event = {};
        event.t_s = t_s;
    }
};

struct RuntimeSizes {
    using Event = RuntimeEvent;
    using State = RuntimeState;
    static constexpr int states = 0;

    int channels = 0, values = 0;
    std::size_t state = 0;

    std::size_t event_bytes() const { return Event::bytes(channels, values); }
    std::size_t state_bytes() const { return state; }
    void clear(Event& event, double t_s) const {
        std::memset(static_cast<void*>(&event), 0, event_bytes());
        event.t_s = t_s;
        event.values = static_cast<std::uint64_t>(values);
    }
};

} // namespace hnav
