// Made by c_src/options/generate.py from aircraft.toml: change that, then ./run generate.
#include "options/lists.hpp"

#include "hnav/options/aircraft.h"

#include <cmath>
#include <cstddef>

// clang-format off
namespace hnav {
namespace {

// Of all rows, one after the other.
constexpr double defaults[] = {
    0, 0, 0,
};

const OptionRow rows[] = {
    {"seed", text("chance"), text(""), text("Seed of everything random"), text("Any seed is as good as any other."),
    nullptr, nullptr, defaults + 0, offsetof(hnav_aircraft_options, seed), 0, 2147483647, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
    {"euler_colour", text("discretisation"), text(""),
    text("1: lambda by 1 - dt/tau, as the paper prints; 0: exact, exp(-dt/tau)"), text("Exact."), nullptr, nullptr, defaults + 1,
    offsetof(hnav_aircraft_options, euler_colour), 0, 1, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
    {"exact_process_noise", text("discretisation"), text(""),
    text("1: w integrated over the interval, which correlates the states (Van Loan 1978); 0: independent noise of variance density times interval"),
    text("The setting of the comparison table."), nullptr, nullptr, defaults + 2,
    offsetof(hnav_aircraft_options, exact_process_noise), 0, 1, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
};

constexpr Preset presets[] = {
    {{"default", text("The defaults."), 0}, nullptr, 0},
};

} // namespace

const OptionList aircraft_options = {
    "hnav_aircraft_defaults", 6, sizeof(hnav_aircraft_options), rows, 3, presets, 1};

} // namespace hnav
