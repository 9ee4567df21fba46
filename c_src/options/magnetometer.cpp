// Made by c_src/options/generate.py from magnetometer.toml: change that, then ./run generate.
#include "options/lists.hpp"

#include "hnav/options/magnetometer.h"

#include <cmath>
#include <cstddef>

// clang-format off
namespace hnav {
namespace {

// Of all rows, one after the other.
constexpr double defaults[] = {
    1, 3, 0.05, 50, 0.017453292519943295, 0, 1000, 0.1, 0.05, 3,
};

const OptionRow rows[] = {
    {"robust", text("robust"), text(""), text("1: outliers lose their weight; 0: plain least squares"),
    text("5 % of outliers make the direction error of plain least squares four times as large."), nullptr, nullptr, defaults + 0,
    offsetof(hnav_magnetometer_options, robust), 0, 1, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
    {"outlier_sigma", text("robust"), text(""), text("Beyond this many robust standard deviations a sample is an outlier"),
    text("One good sample in four hundred loses its weight."), nullptr, nullptr, defaults + 1,
    offsetof(hnav_magnetometer_options, outlier_sigma), 1, 100, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"force_tolerance", text("robust"), text(""), text("A force is gravity when its length is this near to the median, relative"),
    text("Accelerations of half a metre per second squared are let through, swings of the arm are not."), nullptr, nullptr,
    defaults + 2, offsetof(hnav_magnetometer_options, force_tolerance), 0, 1, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"min_samples", text("limits"), text(""),
    text("Attitudes needed, and attitudes with gravity for the rotation; at least 13, the number of unknowns"),
    text("Four samples for each unknown."), nullptr, nullptr, defaults + 3, offsetof(hnav_magnetometer_options, min_samples), 13,
    2147483647, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
    {"max_direction_sigma_rad", text("limits"), text("rad"),
    text("Do without the rotation, then refuse, when nine of ten errors are not sure to be smaller than this"),
    text("A chip as it comes is good to a degree or two. The error of a rotation that was given up is stated beside, and may be larger."),
    nullptr, nullptr, defaults + 4, offsetof(hnav_magnetometer_options, max_direction_sigma_rad), 0, INFINITY, 1, 0,
    HNAV_OPTION_REAL, 1, 0, 0},
    {"allow_hard_iron_only", text("limits"), text(""), text("1: where the full fit is refused, answer with the offset alone"),
    text("An offset alone is another answer than was asked for."), nullptr, nullptr, defaults + 5,
    offsetof(hnav_magnetometer_options, allow_hard_iron_only), 0, 1, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
    {"max_condition", text("limits"), text(""), text("Refuse the full fit when condition exceeds this"),
    text("Turning about one axis only gives more, and would be fitted with an error of tens of degrees."), nullptr, nullptr,
    defaults + 6, offsetof(hnav_magnetometer_options, max_condition), 1, INFINITY, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"max_ambiguity", text("limits"), text(""), text("Refuse the full fit when ambiguity exceeds this"),
    text("The next best ellipsoid must be ten times worse."), nullptr, nullptr, defaults + 7,
    offsetof(hnav_magnetometer_options, max_ambiguity), 0, 1, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"min_coverage", text("limits"), text(""), text("Refuse the full fit when coverage is below this"),
    text("A cone of directions around one axis has less."), nullptr, nullptr, defaults + 8,
    offsetof(hnav_magnetometer_options, min_coverage), 0, 1, 1, 0, HNAV_OPTION_REAL, 0, 1, 1},
    {"max_axis_ratio", text("limits"), text(""), text("Refuse the full fit when axis_ratio exceeds this"),
    text("No usual iron stretches a field so far: the data are of several places."), nullptr, nullptr, defaults + 9,
    offsetof(hnav_magnetometer_options, max_axis_ratio), 1, INFINITY, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
};

constexpr Preset presets[] = {
    {{"default", text("The defaults."), 0}, nullptr, 0},
};

} // namespace

const OptionList magnetometer_options = {
    "hnav_magnetometer_defaults", 5, sizeof(hnav_magnetometer_options), rows, 10, presets, 1};

} // namespace hnav
