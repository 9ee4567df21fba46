// Units as FMI declares them: integer exponents of base units, and factors of the units to display.
#pragma once

namespace hnav::fmu {

struct DisplayUnit {
    const char* name;
    double factor; // displayed = factor x value in the unit
};

struct Unit {
    const char* name;
    // Roots of seconds and hertz have no integer exponents: such a unit is a name without a base.
    bool has_base;
    int kg, m, s, A, rad;
    DisplayUnit display[2]; // ends with a null name
};

constexpr double rad_to_deg = 57.295779513082320877;

constexpr Unit units[] = {
    {"s", true, 0, 0, 1, 0, 0, {{"ms", 1e3}, {}}},
    {"1/s", true, 0, 0, -1, 0, 0, {}},
    {"rad", true, 0, 0, 0, 0, 1, {{"deg", rad_to_deg}, {}}},
    {"rad/s", true, 0, 0, -1, 0, 1, {{"deg/s", rad_to_deg}, {"deg/h", rad_to_deg * 3600}}},
    {"rad/s2", true, 0, 0, -2, 0, 1, {}},
    {"rad2", true, 0, 0, 0, 0, 2, {}},
    {"rad2/s", true, 0, 0, -1, 0, 2, {}},
    {"rad2/s2", true, 0, 0, -2, 0, 2, {}},
    {"m", true, 0, 1, 0, 0, 0, {}},
    {"m/s", true, 0, 1, -1, 0, 0, {}},
    {"m/s2", true, 0, 1, -2, 0, 0, {}},
    {"m/s3", true, 0, 1, -3, 0, 0, {}},
    {"m2/s3", true, 0, 2, -3, 0, 0, {}},
    {"Pa", true, 1, -1, -2, 0, 0, {}},
    {"T", true, 1, 0, -2, -1, 0, {{"uT", 1e6}, {}}},
    {"m/s/sqrt(s)", false, 0, 0, 0, 0, 0, {}},
    {"m/s2/sqrt(s)", false, 0, 0, 0, 0, 0, {}},
    {"T/s", true, 1, 0, -3, -1, 0, {}},
    {"T2.s", true, 2, 0, -3, -2, 0, {}},
    {"rad/sqrt(s)", false, 0, 0, 0, 0, 0, {}},
    {"rad/s/sqrt(s)", false, 0, 0, 0, 0, 0, {}},
    {"rad/s/sqrt(Hz)", false, 0, 0, 0, 0, 0, {}},
    {"m/s/sqrt(Hz)", false, 0, 0, 0, 0, 0, {}},
    {"sqrt(s)", false, 0, 0, 0, 0, 0, {}},
    {"1/sqrt(s)", false, 0, 0, 0, 0, 0, {}},
    {"1/sqrt(Hz)", false, 0, 0, 0, 0, 0, {}},
};

} // namespace hnav::fmu
