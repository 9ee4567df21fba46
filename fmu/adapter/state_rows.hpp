// The continuous states of Model Exchange as rows: first the values, then the derivatives, in the same order.
#pragma once

#include "adapter/model.hpp"

#include <cstring>

namespace hnav::fmu {

class StateRows {
public:
    // describe(StateRows&) adds the states.
    template <class Describe>
    static void add_to(Table& table, Describe describe) {
        const int first = table.size();
        StateRows states(table, false, first), derivatives(table, true, first);
        describe(states);
        describe(derivatives);
    }

    // depends_on: the dependency of the derivative.
    void add(const char* name, const char* unit, double start, DependsOn depends_on, const char* text) {
        Variable v = variable(name, Type::real, Causality::local, Variability::continuous, text);
        if (derivatives_) std::snprintf(v.name, sizeof v.name, "der(%.50s)", name);
        v.unit = derivatives_ ? per_second(unit) : unit;
        v.group = state_group;
        v.depends_on = derivatives_ ? depends_on : DependsOn::nothing;
        v.is_state = !derivatives_;
        v.start = derivatives_ ? 0 : start;
        v.derivative_of = derivatives_ ? first_state_ + count_ : -1;
        table_.add(v);
        ++count_;
    }

    // The attitude state.q[1] ... state.q[4].
    void add_attitude(const char* text, DependsOn depends_on = DependsOn::first_states) {
        char name[32];
        for (int i = 1; i <= 4; ++i) {
            std::snprintf(name, sizeof name, "state.q[%d]", i);
            add(name, "", i == 1, depends_on, text);
        }
    }

private:
    static const char* per_second(const char* unit) {
        if (!*unit) return "1/s";
        if (!std::strcmp(unit, "rad/s")) return "rad/s2";
        if (!std::strcmp(unit, "m")) return "m/s";
        if (!std::strcmp(unit, "m/s")) return "m/s2";
        return ""; // of seconds
    }

    StateRows(Table& table, bool derivatives, int first_state)
        : table_(table), derivatives_(derivatives), first_state_(first_state) {}

    Table& table_;
    bool derivatives_;
    int first_state_;
    int count_ = 0;
};

} // namespace hnav::fmu
