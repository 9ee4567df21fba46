// Structs that begin with their size (hnav/types.h): the caller may have been compiled when they had fewer fields.
#pragma once

#include "c_api/message.hpp"

#include <cstring>

// REQUIRE of a pointer to a struct of a type with a size field.
#define REQUIRE_STRUCT(object, pointer, type)                                                                                    \
    do {                                                                                                                         \
        REQUIRE(object, pointer);                                                                                                \
        if (const hnav_status unknown = hnav::check_size(*(object), *(pointer), #pointer, #type)) return unknown;                \
    } while (0)

namespace hnav {

// The size of a struct when it was first published. A struct with fields added later has this size stated
// here.
template <class Struct>
inline constexpr std::size_t first_size = sizeof(Struct);

// object: takes the error message. name: of the argument in that message.
template <class Object, class Struct>
hnav_status check_size(const Object& object, const Struct& given, const char* name, const char* type) {
    if (given.size >= first_size<Struct> && given.size <= sizeof(Struct)) return HNAV_OK;
    return object.fail(HNAV_ERROR_SIZE, "%s.size = %zu is no size of %s: begin with %s %s = {.size = sizeof %s}", name,
                       given.size, type, type, name, name);
}

// The caller's struct; later fields are zero.
template <class Struct>
Struct take_in(const Struct& given) {
    Struct whole{};
    std::memcpy(&whole, &given, given.size);
    return whole;
}

// A result, up to the size of the caller's struct: the end of a call without failure.
template <class Struct>
hnav_status hand_out(Struct result, Struct* to) {
    result.size = to->size;
    std::memcpy(to, &result, to->size);
    return HNAV_OK;
}

} // namespace hnav
