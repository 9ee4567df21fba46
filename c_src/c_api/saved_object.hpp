// Calls of objects that can be reset, saved and loaded. An object whose state is one row of numbers has
//     void reset()
//     SavedState saved() const           the format of its states
//     const void* numbers() const        its state
//     bool assign(const void* numbers)   takes a state of another one; false, without any change, for numbers that are none
#pragma once

#include "base/saved_state.hpp"
#include "c_api/message.hpp"

#include <cstring>

namespace hnav {

template <class Object>
hnav_status reset_object(Object* object) {
    if (!object) return HNAV_ERROR_NULL_ARGUMENT;
    object->reset();
    return HNAV_OK;
}

// Checks that a buffer has the size of a saved state.
template <class Object>
hnav_status save_status(const Object& object, std::size_t bytes, std::size_t needed) {
    if (bytes >= needed) return HNAV_OK;
    return object.fail(HNAV_ERROR_SIZE, "buffer has %zu bytes, the state needs %zu", bytes, needed);
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

template <class Object>
hnav_status give_state_size(const Object* object, std::size_t* bytes) {
    REQUIRE(object, bytes);
    *bytes = object->saved().bytes();
    return HNAV_OK;
}

template <class Object>
hnav_status save_object(const Object* object, void* buffer, std::size_t bytes) {
    REQUIRE(object, buffer);
    const SavedState saved = object->saved();
    if (const hnav_status status = save_status(*object, bytes, saved.bytes())) return status;
    std::memcpy(saved.numbers(buffer), object->numbers(), saved.numbers_bytes);
    saved.seal(buffer);
    return HNAV_OK;
}

template <class Object>
hnav_status load_object(Object* object, const void* buffer, std::size_t bytes, const char* what) {
    REQUIRE(object, buffer);
    const SavedState saved = object->saved();
    LoadOutcome outcome = saved.check(buffer, bytes);
    if (outcome == LoadOutcome::ok && !object->assign(saved.numbers(buffer))) outcome = LoadOutcome::damaged;
    return load_status(*object, outcome, what, bytes, saved.bytes());
}

} // namespace hnav
