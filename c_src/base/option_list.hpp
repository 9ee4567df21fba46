// A list of options inside the library: a row for each field with name, range, default and place; presets as differences from
// the defaults. The lists are generated from c_src/options.
#pragma once

#include "base/small.hpp"
#include "hnav/types.h"

#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace hnav {

// A row without its description; generated from the same fields.
struct ShortRow {
    const char* name;
    const double* default_values;
    double min, max;
    std::uint16_t offset;
    std::uint8_t count, kind, min_is_open, max_is_open;

    constexpr ShortRow(const char* n, const char*, const char*, const char*, const char*, const char* const*, const char* const*,
                       const double* defaults, std::size_t place, double least, double most, int components, int,
                       hnav_option_kind of_kind, int above_min, int below_max, int)
        : name(n),
          default_values(defaults),
          min(least),
          max(most),
          offset(static_cast<std::uint16_t>(place)),
          count(static_cast<std::uint8_t>(components)),
          kind(of_kind),
          min_is_open(above_min != 0),
          max_is_open(below_max != 0) {}
};
using OptionRow = std::conditional_t<small_build, ShortRow, hnav_option_info>;

struct PresetValue {
    int row, component;
    double value;
};

struct Preset {
    hnav_preset_info info;
    const PresetValue* values; // that differ from the defaults
    int count;
};

struct OptionList {
    const char* defaults_call; // that makes the options
    int number;                // distinguishes the lists in stamps
    std::size_t size;          // of the struct
    const OptionRow* rows;
    int count;
    const Preset* presets;
    int preset_count;
};

// Rows 0, 1, ...; null beyond the last.
const OptionRow* option_at(const OptionList& list, int index);
const hnav_preset_info* preset_at(const OptionList& list, int index);

// Fills the struct: size, stamp, and the values of a preset; all zero, including the stamp, for a preset that the list does
// not have.
void set_defaults(const OptionList& list, int preset, void* options);
// As a struct; preset 0 of every list is the default.
template <class Options>
Options made_from(const OptionList& list, int preset = 0) {
    Options options;
    set_defaults(list, preset, &options);
    return options;
}

// The value of one component as a number, whatever its type.
double option_value(const OptionRow& row, const void* options, int component);
void set_option_value(const OptionRow& row, void* options, int component, double value);

// Whether the options come from the list's own call in a version with the same options; if not, what is wrong.
enum class Origin { here, unknown, other_list, other_version };
Origin origin_of(const OptionList& list, const void* options);
// The version in a stamp.
struct Version {
    int major, minor, patch;
};
Version version_of(const void* options);

// The first row whose range the options violate, or null. component: index in an array.
const OptionRow* find_impossible(const OptionList& list, const void* options, int* component, double* value);

// Over the list and all fields: equal options, equal fingerprint.
std::uint64_t fingerprint(const OptionList& list, const void* options);

} // namespace hnav
