// Functions that make the rows of the tables.
#pragma once

#include "adapter/model.hpp"
#include "adapter/sampling_clock.hpp"

namespace hnav::fmu::rows {

// The name group.member, with an optional suffix.
class Name {
public:
    Name(const char* group, const char* member, const char* ending = "") {
        std::snprintf(text_, sizeof text_, "%.20s.%.20s%.20s", group, member, ending);
    }
    operator const char*() const { return text_; }

private:
    char text_[64];
};

inline Variable quantity(const char* name, Causality causality, Variability variability, const char* unit, const char* display,
                         const char* text) {
    Variable v = variable(name, Type::real, causality, variability, text);
    v.unit = unit;
    v.display_unit = display;
    return v;
}

// The first row of every table.
inline Variable time() { return quantity("time", Causality::independent, Variability::continuous, "s", "", "Simulation time"); }

inline Variable input(const char* name, const char* unit, const char* display, double start, const char* text) {
    Variable v = quantity(name, Causality::input, Variability::discrete, unit, display, text);
    v.start = start;
    return v;
}

inline Variable input(const char* name, Type type, double start, const char* text) {
    Variable v = variable(name, type, Causality::input, Variability::discrete, text);
    v.start = start;
    return v;
}

// Outputs get their group from the Outputs that they are added to. Discrete outputs:
inline Variable output(const char* name, const char* unit, const char* display, const char* text) {
    return quantity(name, Causality::output, Variability::discrete, unit, display, text);
}

inline Variable output(const char* name, Type type, const char* text) {
    return variable(name, type, Causality::output, Variability::discrete, text);
}

inline Variable output(const char* name, const Choices& choices, const char* text) {
    Variable v = output(name, Type::enumeration, text);
    v.choices = choices;
    return v;
}

// A triggered clock of FMI 3. The value of its row is its number of ticks.
inline Variable clock(const char* name, Causality causality, const char* text) {
    return variable(name, Type::clock, causality, Variability::discrete, text);
}

// Continuous outputs:
inline Variable flow(const char* name, const char* unit, const char* display, DependsOn depends_on, const char* text) {
    Variable v = quantity(name, Causality::output, Variability::continuous, unit, display, text);
    v.depends_on = depends_on;
    return v;
}

inline Variable parameter(const char* name, const char* unit, double start, double min, double max, const char* text) {
    Variable v = quantity(name, Causality::parameter, Variability::fixed, unit, "", text);
    v.start = start;
    v.min = min;
    v.max = max;
    return v;
}

// Its start value is the first choice.
inline Variable choice(const char* name, const Choices& choices, const char* text) {
    Variable v = variable(name, Type::enumeration, Causality::parameter, Variability::fixed, text);
    v.choices = choices;
    v.min = 0;
    v.max = choices.count - 1;
    return v;
}

// ------------------------------------------------------------------------------------------------ of sampled inputs

inline Variable sampling_mode(const char* text) {
    Variable v = choice("sampling_mode", {[](const void*, int k) { return sampling_modes[k]; }, nullptr, 4}, text);
    v.basic = true;
    v.start = automatic;
    return v;
}

inline Variable sample_counter(const char* name) {
    return input(name, Type::integer, 0, "Sample counter: a change marks a new sample (sampling_mode auto or counter)");
}

// The inputs of a sensor that mark a new sample.
inline Variable sample_mark(const char* sensor) {
    return model_info.clocks ? clock(Name(sensor, "tick"), Causality::output, "Ticks when a sample is delivered")
                             : output(Name(sensor, "sample"), Type::integer, "Samples delivered: a change marks a new sample");
}

inline Variable sample_time(const char* name) {
    return input(name, "s", "", 0, "Time at which the sample was measured (sampling_mode auto or counter)");
}

inline Variable reset_command() {
    return input("reset", Type::boolean, 0, "Rising edge: back to the state after initialization");
}

} // namespace hnav::fmu::rows
