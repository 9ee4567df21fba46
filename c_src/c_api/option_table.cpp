#include "c_api/option_table.hpp"

#include <cmath>
#include <cstring>

namespace hnav {
namespace {

double component_of(const hnav_option_info& row, const void* options, int i) {
    const char* field = static_cast<const char*>(options) + row.offset;
    if (row.kind == HNAV_OPTION_REAL) {
        double value;
        std::memcpy(&value, field + i * sizeof value, sizeof value);
        return value;
    }
    std::int32_t value;
    std::memcpy(&value, field + i * sizeof value, sizeof value);
    return value;
}

} // namespace

const hnav_option_info* find_impossible(const OptionTable& table, const void* options, int* component, double* value) {
    for (int k = 0; k < table.count; ++k) {
        const hnav_option_info& row = table.rows[k];
        for (int i = 0; i < row.count; ++i) {
            const double v = component_of(row, options, i);
            const bool inside = v <= row.max && (row.min_is_open ? v > row.min : v >= row.min); // false for NaN
            if (inside) continue;
            *component = i;
            *value = v;
            return &row;
        }
    }
    return nullptr;
}

std::uint64_t fingerprint(const OptionTable& table, const void* options) {
    std::uint64_t hash = 14695981039346656037ull;
    for (int k = 0; k < table.count; ++k)
        for (int i = 0; i < table.rows[k].count; ++i) {
            const double v = component_of(table.rows[k], options, i);
            std::uint64_t word;
            std::memcpy(&word, &v, sizeof word);
            hash = (hash ^ word) * 1099511628211ull;
        }
    return hash;
}

} // namespace hnav
