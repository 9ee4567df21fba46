// Parameters that are options of the C API, by the same names.
#pragma once

#include "adapter/rows.hpp"
#include "hnav/hnav.h"

#include <cstring>

namespace hnav::fmu {

using OptionAt = const hnav_option_info* (*)(std::int32_t);

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
    v.choices = {[](const void* of, int k) {
                     const auto* row = static_cast<const hnav_option_info*>(of);
                     return Choice{row->choices[k], row->choice_descriptions[k]};
                 },
                 &option, option.choice_count};
    v.min = option.min;
    v.max = option.max;
    v.start = hnav_option_value(&option, options, component);
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
            if (written[row] != 0) hnav_set_option_value(option, options, i, values[row]);
            values[row] = hnav_option_value(option, options, i);
        }
}

} // namespace hnav::fmu
