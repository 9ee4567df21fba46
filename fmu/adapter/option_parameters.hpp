// Parameters that are options of the C API, by the same names.
#pragma once

#include "adapter/rows.hpp"
#include "hnav/hnav.h"

#include <cstring>

namespace hnav::fmu {

using OptionAt = const hnav_option_info* (*)(std::int32_t);

// The value of one component of an option.
inline double option_value(const hnav_option_info& option, const void* options, int component) {
    const char* field = static_cast<const char*>(options) + option.offset;
    if (option.kind == HNAV_OPTION_REAL) {
        double value;
        std::memcpy(&value, field + component * sizeof value, sizeof value);
        return value;
    }
    std::int32_t value;
    std::memcpy(&value, field, sizeof value);
    return value;
}

inline void set_option(const hnav_option_info& option, void* options, int component, double value) {
    char* field = static_cast<char*>(options) + option.offset;
    if (option.kind == HNAV_OPTION_REAL) {
        std::memcpy(field + component * sizeof value, &value, sizeof value);
        return;
    }
    const auto integer = static_cast<std::int32_t>(value);
    std::memcpy(field, &integer, sizeof integer);
}

// The row of one component, its start value taken from options.
inline Variable option_row(const hnav_option_info& option, const void* options, int component) {
    Variable v = variable(option.name, Type::real, Causality::parameter, Variability::fixed, option.description);
    if (option.count > 1) std::snprintf(v.name, sizeof v.name, "%.50s[%d]", option.name, component + 1);
    if (option.kind == HNAV_OPTION_INTEGER) v.type = Type::integer;
    if (option.kind == HNAV_OPTION_CHOICE) v.type = Type::enumeration;
    v.unit = option.unit;
    if (!std::strcmp(option.unit, "rad")) v.display_unit = "deg";
    if (!std::strcmp(option.unit, "rad/s")) v.display_unit = "deg/s";
    if (!std::strcmp(option.unit, "T")) v.display_unit = "uT";
    v.choices = option.choices;
    v.choice_count = option.choice_count;
    v.min = option.min;
    v.max = option.max;
    v.start = option_value(option, options, component);
    return v;
}

// A whole option table: one row for each component of each option; the number of the first.
inline int add_options(Table& table, OptionAt option_at, const void* defaults) {
    const int first = table.size();
    for (int k = 0; const hnav_option_info* option = option_at(k); ++k)
        for (int i = 0; i < option->count; ++i) table.add(option_row(*option, defaults, i));
    return first;
}

// What the importer has set goes into the options, which hold defaults; the other rows show what these are.
inline void take_options(OptionAt option_at, int first, double* values, const double* written, void* options) {
    int row = first;
    for (int k = 0; const hnav_option_info* option = option_at(k); ++k)
        for (int i = 0; i < option->count; ++i, ++row) {
            if (written[row] != 0) set_option(*option, options, i, values[row]);
            values[row] = option_value(*option, options, i);
        }
}

} // namespace hnav::fmu
