// The one-line message of a failure: kept in an object, or written into the buffer of a create call.
#pragma once

#include "base/option_list.hpp"
#include "base/refusal.hpp"
#include "base/small.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <type_traits>

// For a function with an object that has a KeptMessage, and a pointer.
#define REQUIRE(object, pointer)                                                                                                 \
    do {                                                                                                                         \
        if (!(object)) return HNAV_ERROR_NULL_ARGUMENT;                                                                          \
        if (!(pointer)) return (object)->fail(HNAV_ERROR_NULL_ARGUMENT, #pointer " is null");                                    \
    } while (0)

// The same for a number that must be finite.
#define REQUIRE_FINITE(object, number)                                                                                           \
    do {                                                                                                                         \
        if (!std::isfinite(number))                                                                                              \
            return (object)->fail(HNAV_ERROR_NON_FINITE, #number " = %g is not finite", static_cast<double>(number));            \
    } while (0)

namespace hnav {

// The last message of an object, returned by its message call. Numbers in a message need printf, half as large as a filter:
// the small build has the text of the status.
template <std::size_t size>
struct KeptMessage {
    mutable std::conditional_t<small_build, const char*, char[size]> message = "";

    HNAV_SMALL_INLINE __attribute__((format(printf, 3, 4))) hnav_status fail(hnav_status status, const char* format, ...) const {
        if constexpr (small_build) {
            message = hnav_status_text(status);
        } else {
            va_list arguments;
            va_start(arguments, format);
            std::vsnprintf(message, size, format, arguments);
            va_end(arguments);
        }
        return status;
    }
};

inline hnav_status status_of(const Refusal& why) {
    switch (why.kind) {
    case Refusal::null: return HNAV_ERROR_NULL_ARGUMENT;
    case Refusal::size: return HNAV_ERROR_SIZE;
    case Refusal::non_finite: return HNAV_ERROR_NON_FINITE;
    case Refusal::plant: return HNAV_ERROR_SOLVER;
    default: return HNAV_ERROR_OPTION;
    }
}

// A pointer of the caller, by its name.
struct Argument {
    const void* pointer;
    const char* name;
};

// The message of a create call, in the caller's buffer, which may be null.
struct CallersMessage {
    char* message;
    std::size_t message_size;

    void clear() const {
        if (message && message_size > 0) message[0] = '\0';
    }

    HNAV_SMALL_INLINE __attribute__((format(printf, 3, 4))) hnav_status fail(hnav_status status, const char* format, ...) const {
        if constexpr (small_build) {
            say(status);
        } else {
            va_list arguments;
            va_start(arguments, format);
            if (message && message_size > 0) std::vsnprintf(message, message_size, format, arguments);
            va_end(arguments);
        }
        return status;
    }

    // The beginning of a create call: there is no object yet. Refuses null pointers.
    template <class Handle>
    hnav_status begin(Handle** object, const char* name, std::initializer_list<Argument> given) const {
        clear();
        if (!object) return fail(HNAV_ERROR_NULL_ARGUMENT, "%s is null", name);
        *object = nullptr;
        for (const Argument& one : given)
            if (!one.pointer) return fail(HNAV_ERROR_NULL_ARGUMENT, "%s is null", one.name);
        return HNAV_OK;
    }

    hnav_status refuse(const Refusal& why) const { return fail(status_of(why), "%s", why.text); }

    // The stamp of the options and the range of every field.
    hnav_status check_options(const void* options, const OptionList& list) const {
        if (const hnav_status status = check_origin(options, list)) return status;
        int component;
        double value;
        const OptionRow* row = find_impossible(list, options, &component, &value);
        if (!row) return HNAV_OK;
        if constexpr (small_build) {
            fail(HNAV_ERROR_OPTION, "an option");
            append(": ");
            append(row->name);
            return HNAV_ERROR_OPTION;
        }
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
                        "options were made by %s of hnav %d.%d.%d, this is hnav %s: make them with the linked library",
                        list.defaults_call, made.major, made.minor, made.patch, hnav_version());
        case Origin::other_list:
            return fail(HNAV_ERROR_OPTIONS_STAMP, "options were made by another call than %s, which this object needs",
                        list.defaults_call);
        default:
            return fail(
                HNAV_ERROR_OPTIONS_STAMP,
                "options were not made by %s, or its preset does not exist: begin with what it returns for an existing one",
                list.defaults_call);
        }
    }

private:
    // Without printf.
    void say(hnav_status status) const {
        clear();
        append(hnav_status_text(status));
    }
    // Truncated to the buffer.
    void append(const char* text) const {
        if (!message || message_size == 0) return;
        const std::size_t used = std::strlen(message), count = std::min(std::strlen(text), message_size - 1 - used);
        std::memcpy(message + used, text, count);
        message[used + count] = '\0';
    }
};

} // namespace hnav
