// The one-line message of a failure: kept in an object, or written into the buffer of a create call.
#pragma once

#include "base/option_list.hpp"
#include "base/refusal.hpp"
#include "base/saved_state.hpp"
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

// Checks that a buffer has the size of a saved state.
template <class Object>
hnav_status save_status(const Object& object, std::size_t bytes, std::size_t needed) {
    if (bytes >= needed) return HNAV_OK;
    return object.fail(HNAV_ERROR_SIZE, "buffer has %zu bytes, the state needs %zu", bytes, needed);
}

// Saves an object whose state is one row of numbers.
template <class Object>
hnav_status save_numbers(const Object& object, const SavedState& saved, const void* numbers, void* buffer, std::size_t bytes) {
    if (const hnav_status status = save_status(object, bytes, saved.bytes())) return status;
    std::memcpy(saved.numbers(buffer), numbers, saved.numbers_bytes);
    saved.seal(buffer);
    return HNAV_OK;
}

// Status and message of a load call; what: the object in a word, needed: bytes of its state.
template <class Object>
hnav_status load_status(const Object& object, LoadOutcome outcome, const char* what, std::size_t bytes, std::size_t needed) {
    switch (outcome) {
    case LoadOutcome::ok: return HNAV_OK;
    case LoadOutcome::size:
        return object.fail(HNAV_ERROR_SIZE, "buffer has %zu bytes, a saved state of this %s has %zu", bytes, what, needed);
    case LoadOutcome::other_version:
        return object.fail(HNAV_ERROR_STATE_VERSION,
                           "the state was saved by a version of hnav whose states hnav %s does not read", hnav_version());
    case LoadOutcome::other_object:
        return object.fail(HNAV_ERROR_STATE_CORRUPT,
                           "the state is whole, but was saved by another %s: its model or options differ", what);
    default: return object.fail(HNAV_ERROR_STATE_CORRUPT, "the state is damaged: its checksum does not fit");
    }
}

// Loads an object whose state is one row of numbers, of which every one is valid.
template <class Object>
hnav_status load_into(const Object& object, const SavedState& saved, void* numbers, const void* buffer, std::size_t bytes,
                      const char* what) {
    const LoadOutcome outcome = saved.check(buffer, bytes);
    if (outcome == LoadOutcome::ok) std::memcpy(numbers, saved.numbers(buffer), saved.numbers_bytes);
    return load_status(object, outcome, what, bytes, saved.bytes());
}

// The same of numbers that may be invalid. assign: accepts them, or returns false.
template <class State, class Object, class Assign>
hnav_status load_numbers(const Object& object, const SavedState& saved, const void* buffer, std::size_t bytes, const char* what,
                         Assign assign) {
    LoadOutcome outcome = saved.check(buffer, bytes);
    if (outcome == LoadOutcome::ok) {
        State state;
        std::memcpy(&state, saved.numbers(buffer), sizeof state);
        if (!assign(state)) outcome = LoadOutcome::damaged;
    }
    return load_status(object, outcome, what, bytes, saved.bytes());
}

} // namespace hnav
