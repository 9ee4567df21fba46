#include "base/option_list.hpp"

#include "base/hash.hpp"

#include <cmath>
#include <cstring>

namespace hnav {
namespace {

// The first fields of every struct of options.
struct Head {
    std::size_t size;
    std::uint64_t stamp;
};

// "hnav", number of the list, version.
constexpr std::uint64_t magic = 0x686e6176;

std::uint64_t stamp_of(const OptionList& list) {
    return magic << 32 | static_cast<std::uint64_t>(list.number) << 24 | HNAV_VERSION_MAJOR << 16 | HNAV_VERSION_MINOR << 8 |
           HNAV_VERSION_PATCH;
}

Head head_of(const void* options) {
    Head head;
    std::memcpy(&head, options, sizeof head);
    return head;
}

} // namespace

const OptionRow* option_at(const OptionList& list, int index) {
    return index >= 0 && index < list.count ? &list.rows[index] : nullptr;
}

const hnav_preset_info* preset_at(const OptionList& list, int index) {
    return index >= 0 && index < list.preset_count ? &list.presets[index].info : nullptr;
}

void set_defaults(const OptionList& list, int preset, void* options) {
    std::memset(options, 0, list.size);
    for (int p = 0; p < list.preset_count; ++p) {
        if (list.presets[p].info.value != preset) continue;
        const Head head = {list.size, stamp_of(list)};
        std::memcpy(options, &head, sizeof head);
        for (int k = 0; k < list.count; ++k)
            for (int i = 0; i < list.rows[k].count; ++i)
                set_option_value(list.rows[k], options, i, list.rows[k].default_values[i]);
        for (int v = 0; v < list.presets[p].count; ++v) {
            const PresetValue& differs = list.presets[p].values[v];
            set_option_value(list.rows[differs.row], options, differs.component, differs.value);
        }
    }
}

double option_value(const OptionRow& row, const void* options, int component) {
    const char* field = static_cast<const char*>(options) + row.offset;
    if (row.kind == HNAV_OPTION_REAL) {
        double value;
        std::memcpy(&value, field + component * sizeof value, sizeof value);
        return value;
    }
    std::int32_t value;
    std::memcpy(&value, field + component * sizeof value, sizeof value);
    return value;
}

void set_option_value(const OptionRow& row, void* options, int component, double value) {
    char* field = static_cast<char*>(options) + row.offset;
    if (row.kind == HNAV_OPTION_REAL) {
        std::memcpy(field + component * sizeof value, &value, sizeof value);
        return;
    }
    const auto integer = static_cast<std::int32_t>(value);
    std::memcpy(field + component * sizeof integer, &integer, sizeof integer);
}

Origin origin_of(const OptionList& list, const void* options) {
    const Head head = head_of(options);
    if (head.stamp >> 32 != magic) return Origin::unknown;
    if ((head.stamp >> 24 & 0xff) != (stamp_of(list) >> 24 & 0xff)) return Origin::other_list;
    // A patch release leaves the options unchanged.
    return head.stamp >> 8 == stamp_of(list) >> 8 && head.size == list.size ? Origin::here : Origin::other_version;
}

Version version_of(const void* options) {
    const std::uint64_t stamp = head_of(options).stamp;
    return {static_cast<int>(stamp >> 16 & 0xff), static_cast<int>(stamp >> 8 & 0xff), static_cast<int>(stamp & 0xff)};
}

const OptionRow* find_impossible(const OptionList& list, const void* options, int* component, double* value) {
    for (int k = 0; k < list.count; ++k) {
        const OptionRow& row = list.rows[k];
        for (int i = 0; i < row.count; ++i) {
            const double v = option_value(row, options, i);
            // False for NaN.
            const bool above = row.min_is_open ? v > row.min : v >= row.min;
            const bool below = row.max_is_open ? v < row.max : v <= row.max;
            if (above && below) continue;
            *component = i;
            *value = v;
            return &row;
        }
    }
    return nullptr;
}

std::uint64_t fingerprint(const OptionList& list, const void* options) {
    std::uint64_t result = hash(&list.number, sizeof list.number);
    for (int k = 0; k < list.count; ++k)
        for (int i = 0; i < list.rows[k].count; ++i) {
            const double v = option_value(list.rows[k], options, i);
            result = hash(&v, sizeof v, result);
        }
    return result;
}

} // namespace hnav
