// Made by c_src/options/generate.py from turntable.toml: change that, then ./run generate.
#include "options/lists.hpp"

#include "hnav/options/turntable.h"

#include <cmath>
#include <cstddef>

// clang-format off
namespace hnav {
namespace {

const char* const motion_names[] = {text("constant"), text("step"), text("sine"), text("triangle")};
const char* const motion_meanings[] = {
    text("angle_rad"), text("from start_s it turns by amplitude_rad at rate_rad_s, then stands"),
    text("from start_s: angle_rad + amplitude_rad sin(2 pi (t - start_s)/period_s)"),
    text("from start_s to and fro between angle_rad +- amplitude_rad at rate_rad_s"),
};

// Of all rows, one after the other.
constexpr double defaults[] = {
    0, 0, 0, 0.17453292519943295, 10, 0, 0, 0, 0, 0, 0.17453292519943295, 10, 0, 0, 3, 0, 1.0471975511965976, 0.17453292519943295,
    10, 0, 0, 9.80665, 5e-05, 1.0471975511965976, 0, 0,
};

const OptionRow rows[] = {
    {"roll.motion", text("roll"), text(""),
    text("Motion: constant angle; step to another angle; sine; triangle to and fro at a constant rate"),
    text("The axis is locked."), motion_names, motion_meanings, defaults + 0, offsetof(hnav_turntable_options, roll.motion), 0, 3,
    1, 4, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"roll.angle_rad", text("roll"), text("rad"), text("Angle before start_s, and the middle of sine and triangle"),
    text("Level, to the north."), nullptr, nullptr, defaults + 1, offsetof(hnav_turntable_options, roll.angle_rad),
    -12.566370614359172, 12.566370614359172, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"roll.amplitude_rad", text("roll"), text("rad"),
    text("Amplitude of sine and triangle, way of the step; negative: the other way first"), text("No motion."), nullptr, nullptr,
    defaults + 2, offsetof(hnav_turntable_options, roll.amplitude_rad), -314.15926535897933, 314.15926535897933, 1, 0,
    HNAV_OPTION_REAL, 0, 0, 0},
    {"roll.rate_rad_s", text("roll"), text("rad/s"), text("Rate of step and triangle"), text("The paper's rate of yaw."),
    nullptr, nullptr, defaults + 3, offsetof(hnav_turntable_options, roll.rate_rad_s), 1e-09, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0,
    0},
    {"roll.period_s", text("roll"), text("s"), text("Period of the sine"), text("A slow swing."), nullptr, nullptr, defaults + 4,
    offsetof(hnav_turntable_options, roll.period_s), 1e-06, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"roll.start_s", text("roll"), text("s"), text("The motion begins here"), text("From the beginning."), nullptr, nullptr,
    defaults + 5, offsetof(hnav_turntable_options, roll.start_s), -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"roll.unknown_rad", text("roll"), text("rad"),
    text("The axis stands off by an angle drawn from seed, uniform within +- this"), text("Nothing is unknown."),
    nullptr, nullptr, defaults + 6, offsetof(hnav_turntable_options, roll.unknown_rad), 0, 3.1415926535897931, 1, 0,
    HNAV_OPTION_REAL, 0, 0, 1},
    {"pitch.motion", text("pitch"), text(""),
    text("Motion: constant angle; step to another angle; sine; triangle to and fro at a constant rate"),
    text("The axis is locked."), motion_names, motion_meanings, defaults + 7, offsetof(hnav_turntable_options, pitch.motion), 0,
    3, 1, 4, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"pitch.angle_rad", text("pitch"), text("rad"), text("Angle before start_s, and the middle of sine and triangle"),
    text("Level, to the north."), nullptr, nullptr, defaults + 8, offsetof(hnav_turntable_options, pitch.angle_rad),
    -12.566370614359172, 12.566370614359172, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"pitch.amplitude_rad", text("pitch"), text("rad"),
    text("Amplitude of sine and triangle, way of the step; negative: the other way first"), text("No motion."), nullptr, nullptr,
    defaults + 9, offsetof(hnav_turntable_options, pitch.amplitude_rad), -314.15926535897933, 314.15926535897933, 1, 0,
    HNAV_OPTION_REAL, 0, 0, 0},
    {"pitch.rate_rad_s", text("pitch"), text("rad/s"), text("Rate of step and triangle"), text("The paper's rate of yaw."),
    nullptr, nullptr, defaults + 10, offsetof(hnav_turntable_options, pitch.rate_rad_s), 1e-09, 1000, 1, 0, HNAV_OPTION_REAL, 0,
    0, 0},
    {"pitch.period_s", text("pitch"), text("s"), text("Period of the sine"), text("A slow swing."), nullptr, nullptr,
    defaults + 11, offsetof(hnav_turntable_options, pitch.period_s), 1e-06, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"pitch.start_s", text("pitch"), text("s"), text("The motion begins here"), text("From the beginning."), nullptr, nullptr,
    defaults + 12, offsetof(hnav_turntable_options, pitch.start_s), -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"pitch.unknown_rad", text("pitch"), text("rad"),
    text("The axis stands off by an angle drawn from seed, uniform within +- this"), text("Nothing is unknown."),
    nullptr, nullptr, defaults + 13, offsetof(hnav_turntable_options, pitch.unknown_rad), 0, 3.1415926535897931, 1, 0,
    HNAV_OPTION_REAL, 0, 0, 1},
    {"yaw.motion", text("yaw"), text(""),
    text("Motion: constant angle; step to another angle; sine; triangle to and fro at a constant rate"), text("The paper's yaw."),
    motion_names, motion_meanings, defaults + 14, offsetof(hnav_turntable_options, yaw.motion), 0, 3, 1, 4, HNAV_OPTION_CHOICE, 0,
    0, 0},
    {"yaw.angle_rad", text("yaw"), text("rad"), text("Angle before start_s, and the middle of sine and triangle"),
    text("Level, to the north."), nullptr, nullptr, defaults + 15, offsetof(hnav_turntable_options, yaw.angle_rad),
    -12.566370614359172, 12.566370614359172, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"yaw.amplitude_rad", text("yaw"), text("rad"),
    text("Amplitude of sine and triangle, way of the step; negative: the other way first"), text("The paper's yaw."),
    nullptr, nullptr, defaults + 16, offsetof(hnav_turntable_options, yaw.amplitude_rad), -314.15926535897933, 314.15926535897933,
    1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"yaw.rate_rad_s", text("yaw"), text("rad/s"), text("Rate of step and triangle"), text("The paper's rate of yaw."),
    nullptr, nullptr, defaults + 17, offsetof(hnav_turntable_options, yaw.rate_rad_s), 1e-09, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0,
    0},
    {"yaw.period_s", text("yaw"), text("s"), text("Period of the sine"), text("A slow swing."), nullptr, nullptr, defaults + 18,
    offsetof(hnav_turntable_options, yaw.period_s), 1e-06, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"yaw.start_s", text("yaw"), text("s"), text("The motion begins here"), text("From the beginning."), nullptr, nullptr,
    defaults + 19, offsetof(hnav_turntable_options, yaw.start_s), -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"yaw.unknown_rad", text("yaw"), text("rad"), text("The axis stands off by an angle drawn from seed, uniform within +- this"),
    text("Nothing is unknown."), nullptr, nullptr, defaults + 20, offsetof(hnav_turntable_options, yaw.unknown_rad), 0,
    3.1415926535897931, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gravity_m_s2", text("place"), text("m/s2"), text("Gravity"), text("Standard gravity."), nullptr, nullptr, defaults + 21,
    offsetof(hnav_turntable_options, gravity_m_s2), 0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"field_strength_tesla", text("place"), text("T"), text("Strength of the magnetic field"),
    text("A usual field of the Earth in middle latitudes."), nullptr, nullptr, defaults + 22,
    offsetof(hnav_turntable_options, field_strength_tesla), 0, 1, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"field_dip_rad", text("place"), text("rad"), text("Dip of the magnetic field below the horizon"),
    text("A usual dip in middle northern latitudes."), nullptr, nullptr, defaults + 23,
    offsetof(hnav_turntable_options, field_dip_rad), -1.5707963267948966, 1.5707963267948966, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"declination_rad", text("place"), text("rad"), text("Magnetic declination: the field points this much east of true north"),
    text("True north is magnetic north."), nullptr, nullptr, defaults + 24, offsetof(hnav_turntable_options, declination_rad),
    -3.1415926535897931, 3.1415926535897931, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"seed", text("chance"), text(""), text("Seed of the unknown angles"), text("Any seed is as good as any other."),
    nullptr, nullptr, defaults + 25, offsetof(hnav_turntable_options, seed), 0, 2147483647, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
};

constexpr Preset presets[] = {
    {{"default", text("The defaults."), 0}, nullptr, 0},
};

} // namespace

const OptionList turntable_options = {
    "hnav_turntable_defaults", 4, sizeof(hnav_turntable_options), rows, 26, presets, 1};

} // namespace hnav
