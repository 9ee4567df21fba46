// The options of a filter as rows: name, unit, range, meaning. create checks by them, and saved states are stamped by
// them.
#pragma once

#include "hnav/hnav.h"

#include <cstdint>

namespace hnav {

struct OptionTable {
    const hnav_option_info* rows;
    int count;
};

OptionTable hrekf_option_table();
OptionTable ahrs_option_table();
OptionTable ins_error_option_table();

// "hnav", options layout, model
constexpr std::uint64_t hrekf_cookie = 0x686e61760001'0001ull;
constexpr std::uint64_t ahrs_cookie = 0x686e61760001'0002ull;
constexpr std::uint64_t ins_error_cookie = 0x686e61760001'0003ull;

// The first row that the options break, or null. component: which one of an array.
const hnav_option_info* find_impossible(const OptionTable& table, const void* options, int* component, double* value);

// FNV-1a over all fields: equal options, equal fingerprint.
std::uint64_t fingerprint(const OptionTable& table, const void* options);

} // namespace hnav
