// The one line that says what was wrong: kept in an object, or written where the caller of a create call wants it.
#pragma once

#include "base/option_list.hpp"

#include <cstdarg>
#include <cstddef>
#include <cstdio>

// Of a function that takes an object with a KeptMessage and a pointer to something.
#define REQUIRE(object, pointer)                                                                                                 \
    do {                                                                                                                         \
        if (!(object)) return HNAV_ERROR_NULL_ARGUMENT;                                                                          \
        if (!(pointer)) return (object)->fail(HNAV_ERROR_NULL_ARGUMENT, #pointer " is null");                                    \
    } while (0)

namespace hnav {

// The last complaint of an object, which its message call hands out.
template <std::size_t size>
struct KeptMessage {
    mutable char message[size] = "";

    __attribute__((format(printf, 3, 4))) hnav_status fail(hnav_status status, const char* format, ...) const {
        va_list arguments;
        va_start(arguments, format);
        std::vsnprintf(message, size, format, arguments);
        va_end(arguments);
        return status;
    }
};

// The complaint of a create call, in the caller's characters; there may be none of them.
struct CallersMessage {
    char* message;
    std::size_t message_size;

    void clear() const {
        if (message && message_size > 0) message[0] = '\0';
    }

    __attribute__((format(printf, 3, 4))) hnav_status fail(hnav_status status, const char* format, ...) const {
        va_list arguments;
        va_start(arguments, format);
        if (message && message_size > 0) std::vsnprintf(message, message_size, format, arguments);
        va_end(arguments);
        return status;
    }

    // The stamp of the options and the range of every field.
    hnav_status check_options(const void* options, const OptionList& list) const {
        if (const hnav_status status = check_origin(options, list)) return status;
        int component;
        double value;
        const hnav_option_info* row = find_impossible(list, options, &component, &value);
        if (!row) return HNAV_OK;
        char index[16] = "";
        if (row->count > 1) std::snprintf(index, sizeof index, "[%d]", component);
        return fail(HNAV_ERROR_OPTION, "%s%s = %g is impossible: it must be in %c%g, %g%c", row->name, index, value,
                    row->min_is_open ? '(' : '[', row->min, row->max, row->max_is_open ? ')' : ']');
    }

    hnav_status check_origin(const void* options, const OptionList& list) const {
        const Version made = version_of(options);
        switch (origin_of(list, options)) {
        case Origin::here: return HNAV_OK;
        case Origin::other_version:
            return fail(HNAV_ERROR_OPTIONS_STAMP,
                        "options were made by %s of hnav %d.%d.%d, this is hnav %s: make them anew by the library that is used",
                        list.defaults_call, made.major, made.minor, made.patch, hnav_version());
        case Origin::other_list:
            return fail(HNAV_ERROR_OPTIONS_STAMP, "options were made by another call than %s, which this object needs",
                        list.defaults_call);
        default:
            return fail(HNAV_ERROR_OPTIONS_STAMP, "options were not made by %s: begin with what it returns", list.defaults_call);
        }
    }
};

// FNV-1a, byte by byte.
inline std::uint64_t hash(const void* data, std::size_t bytes, std::uint64_t seed = 14695981039346656037ull) {
    for (std::size_t i = 0; i < bytes; ++i) seed = (seed ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211ull;
    return seed;
}

} // namespace hnav
