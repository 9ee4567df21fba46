// Words for writing option tables: a row is the field of the options struct, its unit, its range and its meaning.
// Include it once, after defining HNAV_OPTIONS as the name of the struct.
#include "api/option_table.hpp"

#include <cstddef>

namespace hnav {
namespace {

constexpr double pi = 3.14159265358979323846;

[[maybe_unused]] const char* const gyro_holds[] = {"forward", "backward"};
[[maybe_unused]] const char* const gamma_modes[] = {"off", "fixed", "relative", "kl"};
[[maybe_unused]] const char* const adaptations[] = {"off", "paper", "corrected"};
[[maybe_unused]] const char* const start_modes[] = {"triad", "attitude", "heading"};
[[maybe_unused]] const char* const reference_modes[] = {"learnt", "given"};
[[maybe_unused]] const char* const navigation_frames[] = {"ned", "enu"};
[[maybe_unused]] const char* const solvers[] = {"erkstep", "adams", "closed_form", "euler"};

} // namespace
} // namespace hnav

#define FIELD(name) #name
#define AT(name) offsetof(HNAV_OPTIONS, name)
// [min, max]
#define REAL(name, unit, min, max, count, text) \
    { FIELD(name), unit, text, nullptr, AT(name), min, max, count, 0, HNAV_OPTION_REAL, 0 }
// (min, max]
#define ABOVE(name, unit, min, max, count, text) \
    { FIELD(name), unit, text, nullptr, AT(name), min, max, count, 0, HNAV_OPTION_REAL, 1 }
#define INTEGER(name, min, max, text) \
    { FIELD(name), "", text, nullptr, AT(name), min, max, 1, 0, HNAV_OPTION_INTEGER, 0 }
#define CHOICE(name, list, text)                                                                                     \
    {                                                                                                                \
        FIELD(name), "", text, list, AT(name), 0, sizeof list / sizeof *list - 1, 1, sizeof list / sizeof *list,     \
            HNAV_OPTION_CHOICE, 0                                                                                    \
    }
