// Made by c_src/options/generate.py from vehicle.toml: change that, then ./run generate.
#include "options/lists.hpp"

#include "hnav/options/vehicle.h"

#include <cmath>
#include <cstddef>

// clang-format off
namespace hnav {
namespace {

const char* const vehicle_kind_names[] = {text("car"), text("aircraft"), text("ship"), text("rest"), text("way")};
const char* const vehicle_kind_meanings[] = {
    text("stops, goes and turns as in a town, up to 15 m/s"), text("20 to 90 m/s, banks into its turns, climbs and sinks"),
    text("2 to 9 m/s, in a swell"), text("stands on something that sways by millimetres"),
    text("passes through given points, points where it goes and does not bank"),
};

// Of all rows, one after the other.
constexpr double defaults[] = {
    0, 0, 3.1415926535897931, 1, 0, 0.78539816339744828, 0, 50, 5e-05, 1.0471975511965976, 0, 0, 0,
};

const OptionRow rows[] = {
    {"kind", text("motion"), text(""),
    text("car: stops, goes and turns; aircraft: banks into its turns; ship: slow in a swell; rest: stands; way: through given points"),
    text("The most usual."), vehicle_kind_names, vehicle_kind_meanings, defaults + 0, offsetof(hnav_vehicle_options, kind), 0, 4,
    1, 5, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"heading_rad", text("motion"), text("rad"), text("Heading at the start, clockwise from north"),
    text("North, with heading_unknown_rad any."), nullptr, nullptr, defaults + 1, offsetof(hnav_vehicle_options, heading_rad),
    -6.2831853071795862, 6.2831853071795862, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"heading_unknown_rad", text("motion"), text("rad"),
    text("The heading at the start is off by an angle drawn from seed, uniform within +- this"),
    text("Filters are to find any heading."), nullptr, nullptr, defaults + 2, offsetof(hnav_vehicle_options, heading_unknown_rad),
    0, 3.1415926535897931, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"sway", text("motion"), text(""),
    text("Factor on all that sways: roll and pitch of a car, the swell under a ship, the ground of a body at rest"),
    text("Sizes as usual for each kind; 0: nothing sways, and what rests stands still."), nullptr, nullptr, defaults + 3,
    offsetof(hnav_vehicle_options, sway), 0, 100, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"vibration_m_s2", text("motion"), text("m/s2"),
    text("Vibration as of an engine that idles, 11 to 44 Hz: root mean square of the force ahead and of that along the vertical, and as much turning about both horizontal axes as a metre away would give that"),
    text("The motion alone; 0.2 is that of a car or a ship whose engine idles."), nullptr, nullptr, defaults + 4,
    offsetof(hnav_vehicle_options, vibration_m_s2), 0, 100, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"latitude_rad", text("place"), text("rad"), text("Latitude at the start"), text("Half way to the pole."), nullptr, nullptr,
    defaults + 5, offsetof(hnav_vehicle_options, latitude_rad), -1.5707963267948966, 1.5707963267948966, 1, 0, HNAV_OPTION_REAL,
    0, 0, 0},
    {"longitude_rad", text("place"), text("rad"), text("Longitude at the start"), text("No place is special."), nullptr, nullptr,
    defaults + 6, offsetof(hnav_vehicle_options, longitude_rad), -3.1415926535897931, 3.1415926535897931, 1, 0, HNAV_OPTION_REAL,
    0, 0, 0},
    {"height_m", text("place"), text("m"), text("Height at the start, above the ellipsoid of WGS 84"),
    text("A usual height of land."), nullptr, nullptr, defaults + 7, offsetof(hnav_vehicle_options, height_m), -10000, 100000, 1,
    0, HNAV_OPTION_REAL, 0, 0, 0},
    {"field_strength_tesla", text("place"), text("T"), text("Strength of the magnetic field"),
    text("A usual field of the Earth in middle latitudes."), nullptr, nullptr, defaults + 8,
    offsetof(hnav_vehicle_options, field_strength_tesla), 0, 1, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"field_dip_rad", text("place"), text("rad"), text("Dip of the magnetic field below the horizon"),
    text("A usual dip in middle northern latitudes."), nullptr, nullptr, defaults + 9,
    offsetof(hnav_vehicle_options, field_dip_rad), -1.5707963267948966, 1.5707963267948966, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"declination_rad", text("place"), text("rad"), text("Magnetic declination: the field points this much east of true north"),
    text("True north is magnetic north."), nullptr, nullptr, defaults + 10, offsetof(hnav_vehicle_options, declination_rad),
    -3.1415926535897931, 3.1415926535897931, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"mean_over_s", text("output"), text("s"),
    text("Rate and force are the means over so long before the instant, as sensors that integrate give them; 0: those of the instant"),
    text("The truth of an instant. Give the period of an inertial sensor, else its samples stand for the end of their interval alone."),
    nullptr, nullptr, defaults + 11, offsetof(hnav_vehicle_options, mean_over_s), 0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"seed", text("chance"), text(""), text("Seed of the motion"), text("Any seed is as good as any other."), nullptr, nullptr,
    defaults + 12, offsetof(hnav_vehicle_options, seed), 0, 2147483647, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
};

constexpr Preset presets[] = {
    {{"default", text("The defaults."), 0}, nullptr, 0},
};

} // namespace

const OptionList vehicle_options = {
    "hnav_vehicle_defaults", 10, sizeof(hnav_vehicle_options), rows, 13, presets, 1};

} // namespace hnav
