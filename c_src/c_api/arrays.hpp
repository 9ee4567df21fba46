// Rows of the caller's arrays. Null: not given, or not requested. A missing sample has NaN in all its components.
#pragma once

#include "c_api/message.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>

namespace hnav {

template <class Number>
Number* row(Number* rows, std::size_t i, std::size_t width) {
    return rows ? rows + i * width : nullptr;
}

inline bool is_missing(const double* v) { return !v || (std::isnan(v[0]) && std::isnan(v[1]) && std::isnan(v[2])); }

inline void copy(const double* from, int count, double* to) {
    if (to) std::copy(from, from + count, to);
}

// A vector or a quaternion.
template <class Vector>
void store(const Vector& v, double* out) {
    for (int i = 0; i < v.size(); ++i) out[i] = v[i];
}

// Whether the caller's numbers are finite and not larger than a limit. name: of the argument in the message.
template <class Object>
hnav_status check_numbers(const Object& object, const char* name, const double* value, int count, double largest) {
    for (int i = 0; i < count; ++i) {
        if (std::fabs(value[i]) <= largest && std::isfinite(value[i])) continue;
        char index[16] = "";
        if (count > 1) std::snprintf(index, sizeof index, "[%d]", i);
        if (!std::isfinite(value[i])) return object.fail(HNAV_ERROR_NON_FINITE, "%s%s = %g is not finite", name, index, value[i]);
        return object.fail(HNAV_ERROR_OUT_OF_RANGE, "%s%s = %g lies beyond %g", name, index, value[i], largest);
    }
    return HNAV_OK;
}

// The message of a failure in row i of a recording.
template <class Object>
hnav_status in_row(Object* f, hnav_status status, std::size_t i) {
    char reason[sizeof f->message];
    std::memcpy(reason, f->message, sizeof reason);
    return f->fail(status, "row %zu: %.280s", i, reason);
}

} // namespace hnav
