// What the create calls of truth and sensor models share: checks of the options, with one line that names the field.
#pragma once

#include "api/option_table.hpp"
#include "hnav/hnav_world.h"

#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <limits>

namespace hnav {

OptionTable turntable_option_table();
OptionTable imu_mag_sensor_option_table();

// "hnav", options layout 1, plant
constexpr std::uint64_t turntable_cookie = 0x686e61760001'0201ull;
constexpr std::uint64_t imu_mag_sensor_cookie = 0x686e61760001'0202ull;

struct WorldCreation {
    char* message;
    std::size_t message_size;

    __attribute__((format(printf, 3, 4))) hnav_status fail(hnav_status status, const char* format, ...) const {
        va_list arguments;
        va_start(arguments, format);
        if (message && message_size > 0) std::vsnprintf(message, message_size, format, arguments);
        va_end(arguments);
        return status;
    }

    // stamp: the cookie of the options; defaults: the call that sets it.
    hnav_status check(const void* options, std::uint64_t stamp, std::uint64_t cookie, const char* defaults, const OptionTable& table) const {
        if (stamp != cookie) return fail(HNAV_ERROR_OPTIONS_STAMP, "options were not made by %s of hnav %s", defaults, hnav_version());
        int component;
        double value;
        const hnav_option_info* row = find_impossible(table, options, &component, &value);
        if (!row) return HNAV_OK;
        char index[16] = "";
        if (row->count > 1) std::snprintf(index, sizeof index, "[%d]", component);
        return fail(HNAV_ERROR_OPTION, "%s%s = %g is impossible: it must be in %c%g, %g]", row->name, index, value,
                    row->min_is_open ? '(' : '[', row->min, row->max);
    }
};

} // namespace hnav
