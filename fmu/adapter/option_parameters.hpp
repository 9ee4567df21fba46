// A whole option table of the C API as parameters.
#pragma once

#include "adapter/option_row.hpp"

namespace hnav::fmu {

using OptionAt = const hnav_option_info* (*)(std::int32_t);

// One row for each component of each option; the number of the first.
inline int add_options(Table& table, OptionAt option_at, const void* defaults) {
    const int first = table.size();
    for (int k = 0; const hnav_option_info* option = option_at(k); ++k)
        for (int i = 0; i < option->count; ++i) table.add(option_row(*option, defaults, i));
    return first;
}

// What the importer has set goes into the options, which hold the defaults.
inline void take_options(OptionAt option_at, int first, const double* values, const double* written, void* options) {
    int row = first;
    for (int k = 0; const hnav_option_info* option = option_at(k); ++k)
        for (int i = 0; i < option->count; ++i, ++row)
            if (written[row] != 0) set_option(*option, options, i, values[row]);
}

} // namespace hnav::fmu
