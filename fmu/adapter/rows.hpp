// Words for writing tables: the kinds of rows that FMUs are made of.
#pragma once

#include "adapter/variable.hpp"

namespace hnav::fmu {

namespace rows {

inline Variable input(const char* name, const char* unit, const char* display, double start, const char* text) {
    Variable v = variable(name, Type::real, Causality::input, Variability::discrete, text);
    v.unit = unit;
    v.display_unit = display;
    v.start = start;
    return v;
}

inline Variable input(const char* name, Type type, double start, const char* text) {
    Variable v = variable(name, type, Causality::input, Variability::discrete, text);
    v.start = start;
    return v;
}

inline Variable output(const char* name, const char* unit, const char* display, unsigned group, Variability variability,
                       DependsOn depends_on, const char* text) {
    Variable v = variable(name, Type::real, Causality::output, variability, text);
    v.unit = unit;
    v.display_unit = display;
    v.group = group;
    v.depends_on = depends_on;
    return v;
}

inline Variable output(const char* name, Type type, unsigned group, const char* text) {
    Variable v = variable(name, type, Causality::output, Variability::discrete, text);
    v.group = group;
    return v;
}

inline Variable parameter(const char* name, const char* unit, double start, double min, double max, const char* text) {
    Variable v = variable(name, Type::real, Causality::parameter, Variability::fixed, text);
    v.unit = unit;
    v.start = start;
    v.min = min;
    v.max = max;
    return v;
}

inline Variable choice(const char* name, const char* const* choices, int count, double start, const char* text) {
    Variable v = variable(name, Type::enumeration, Causality::parameter, Variability::fixed, text);
    v.choices = choices;
    v.choice_count = count;
    v.start = start;
    v.min = 0;
    v.max = count - 1;
    return v;
}

} // namespace rows

} // namespace hnav::fmu
