// A state or control of an aircraft, with the names of its variables.
#pragma once

#include "adapter/rows.hpp"

namespace hnav::fmu::aircraft {

struct Quantity {
    const char* name;
    const char* unit;
    const char* display_unit; // "" when it is the unit itself
    const char* noise_unit;   // of a random walk: unit per root second
};

// One row prefix.name for each quantity, in its unit; returns the number of the first. start: one value for each, or null for
// 0.
template <int n>
int add_each(Table& table, const char* prefix, const Quantity (&quantities)[n], const Variable& pattern,
             const double* start = nullptr) {
    const int first = table.size();
    for (int i = 0; i < n; ++i) {
        Variable v = pattern;
        std::snprintf(v.name, sizeof v.name, "%.28s.%.28s", prefix, quantities[i].name);
        if (v.type == Type::real && !*v.unit) {
            v.unit = quantities[i].unit;
            v.display_unit = quantities[i].display_unit;
        }
        if (start) v.start = start[i];
        if (v.field) v.element = i;
        table.add(v);
    }
    return first;
}

// Of a coloured error. field: as in hnav_aircraft_model.
inline Variable time_constant(const char* field, double start_s, const char* text) {
    Variable v = rows::parameter("", "s", start_s, 0, 1e9, text);
    v.min_is_open = true;
    v.field = field;
    return v;
}

} // namespace hnav::fmu::aircraft
