// The reason why something that a caller gave is refused.
#pragma once

#include <cstdarg>
#include <cstdio>

namespace hnav {

struct Refusal {
    enum Kind { null, size, non_finite, impossible, plant } kind = impossible;
    char text[320] = "";

    // Always false.
    __attribute__((format(printf, 3, 4))) bool refuse(Kind why, const char* format, ...) {
        kind = why;
        va_list arguments;
        va_start(arguments, format);
        std::vsnprintf(text, sizeof text, format, arguments);
        va_end(arguments);
        return false;
    }
};

} // namespace hnav
