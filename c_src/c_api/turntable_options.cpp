// The options of the turntable as rows.
#include "hnav/simulation.h"
#define HNAV_OPTIONS hnav_turntable_options
#include "c_api/option_rows.hpp"

namespace hnav {
namespace {

const char* const motions[] = {"constant", "step", "sine", "triangle"};

#define AXIS(axis)                                                                                                               \
    CHOICE(axis.motion, motions, "Motion: constant angle; step to another angle; sine; triangle to and fro at a constant rate"), \
        REAL(axis.angle_rad, "rad", -4 * pi, 4 * pi, 1, "Angle before start_s, and the middle of sine and triangle"),            \
        REAL(axis.amplitude_rad, "rad", -100 * pi, 100 * pi, 1,                                                                  \
             "Amplitude of sine and triangle, way of the step; negative: the other way first"),                                  \
        ABOVE(axis.rate_rad_s, "rad/s", 0, 1e3, 1, "Rate of step and triangle"),                                                 \
        ABOVE(axis.period_s, "s", 0, 1e6, 1, "Period of the sine"),                                                              \
        REAL(axis.start_s, "s", -1e9, 1e9, 1, "The motion begins here"),                                                         \
        REAL(axis.unknown_rad, "rad", 0, pi, 1, "The axis stands off by an angle drawn from seed, uniform within +- this")

const hnav_option_info turntable_rows[] = {
    AXIS(roll),
    AXIS(pitch),
    AXIS(yaw),
    ABOVE(gravity_m_s2, "m/s2", 0, 1e3, 1, "Gravity"),
    ABOVE(field_strength_tesla, "T", 0, 1, 1, "Strength of the magnetic field"),
    REAL(field_dip_rad, "rad", -pi / 2, pi / 2, 1, "Dip of the magnetic field below the horizon"),
    REAL(declination_rad, "rad", -pi, pi, 1, "Magnetic declination: the field points this much east of true north"),
    INTEGER(seed, 0, 2147483647, "Seed of the unknown angles"),
};

} // namespace

OptionTable turntable_option_table() { return {turntable_rows, sizeof turntable_rows / sizeof *turntable_rows}; }

} // namespace hnav
