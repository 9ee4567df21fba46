// Parameters for the options of the C API, named GROUP.NAME so that importers show a tree. Options that most users set are
// first.
#pragma once

#include "adapter/rows.hpp"
#include "hnav/hnav.h"

#include <cstring>

namespace hnav::fmu {

using OptionAt = const hnav_option_info* (*)(std::int32_t);

// The rows of an option list, by its name.
template <const char* list>
const hnav_option_info* option_of(std::int32_t index) {
    return hnav_option(list, index);
}

// The name of a parameter. The option's name already includes a nested struct; a group with one option is no branch of the
// tree.
inline void write_name(OptionAt option_at, const hnav_option_info& option, Variable* v) {
    int in_group = 0;
    for (int k = 0; const hnav_option_info* other = option_at(k); ++k) in_group += !std::strcmp(other->group, option.group);
    const bool bare = in_group == 1 || std::strchr(option.name, '.');
    std::snprintf(v->name, sizeof v->name, "%.20s%s%.38s", bare ? "" : option.group, bare ? "" : ".", option.name);
}

// The row of one component, its start value taken from options.
inline Variable option_row(OptionAt option_at, const hnav_option_info& option, const void* options, int component) {
    Variable v = variable("", Type::real, Causality::parameter, Variability::fixed, option.description);
    write_name(option_at, option, &v);
    const std::size_t length = std::strlen(v.name);
    if (option.count > 1) std::snprintf(v.name + length, sizeof v.name - length, "[%d]", component + 1);
    if (option.kind == HNAV_OPTION_INTEGER) v.type = Type::integer;
    if (option.kind == HNAV_OPTION_CHOICE) v.type = Type::enumeration;
    v.basic = !option.advanced;
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
    v.min_is_open = option.min_is_open != 0;
    v.max_is_open = option.max_is_open != 0;
    v.field = option.name;
    v.start = hnav_option_value(&option, options, component);
    return v;
}

// The presets of an option list.
template <const char* list>
Choices preset_choices() {
    int count = 0;
    while (hnav_preset_of(list, count)) ++count;
    return {[](const void*, int k) {
                const hnav_preset_info* preset = hnav_preset_of(list, k);
                return Choice{preset->name, preset->description};
            },
            nullptr, count};
}

// Calls visit(option, component) in the order of the rows.
template <class Visit>
void each_component(OptionAt option_at, Visit visit) {
    for (int advanced = 0; advanced <= 1; ++advanced)
        for (int k = 0; const hnav_option_info* option = option_at(k); ++k)
            for (int i = 0; i < option->count && (option->advanced != 0) == (advanced != 0); ++i) visit(*option, i);
}

// Appends one row for each component of each option; returns the number of the first.
inline int add_options(Table& table, OptionAt option_at, const void* defaults) {
    const int first = table.size();
    each_component(option_at,
                   [&](const hnav_option_info& option, int i) { table.add(option_row(option_at, option, defaults, i)); });
    return first;
}

// Values that differ from their start values are written into the options, which hold defaults or a preset. Some importers
// write all parameters, others only the changed ones: both give the same options.
inline void take_options(OptionAt option_at, int first, const double* values, void* options) {
    const double* value = values + first;
    each_component(option_at, [&](const hnav_option_info& option, int i) {
        if (*value != option.default_values[i]) hnav_set_option_value(&option, options, i, *value);
        ++value;
    });
}

} // namespace hnav::fmu
