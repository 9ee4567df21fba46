// Version and status texts of the library.
#include "hnav/types.h"

extern "C" {

const char* hnav_version(void) { return HNAV_VERSION; }

const char* hnav_status_text(hnav_status status) {
    static constexpr const char* texts[] = {
        "ok",
        "a pointer that must not be null is null",
        "an option is impossible",
        "the options were not made by a defaults call of this version",
        "out of memory",
        "a number is not finite",
        "a vector of zero length has no direction",
        "an argument is out of range",
        "the sample is older than the committed estimate",
        "the queue of waiting samples is full",
        "time runs backwards",
        "there is no attitude yet",
        "no sample of this sensor has been used yet",
        "a buffer has the wrong size",
        "the saved state is damaged or belongs to another object",
        "there is no usable answer",
        "this filter cannot do what was asked",
        "the data do not determine the answer",
        "the saved state is of another version of hnav",
    };
    static_assert(sizeof texts / sizeof *texts == HNAV_ERROR_STATE_VERSION + 1);
    const bool known = status >= HNAV_OK && status <= HNAV_ERROR_STATE_VERSION;
    return known ? texts[status] : "unknown status";
}

} // extern "C"
