// The motion of a turntable from its options.
#pragma once

#include "hnav/simulation.h"
#include "simulation/motion.hpp"
#include "simulation/random.hpp"
#include "simulation/streams.hpp"

namespace hnav {

// chance, in [0, 1): the position of the axis in the unknown part of its angle.
inline AxisMotion axis_of(const hnav_axis_options& o, double chance) {
    AxisMotion axis;
    axis.kind = static_cast<Motion>(o.motion);
    axis.angle_rad = o.angle_rad + o.unknown_rad * (2 * chance - 1);
    axis.amplitude_rad = o.amplitude_rad;
    axis.rate_rad_s = o.rate_rad_s;
    axis.period_s = o.period_s;
    axis.start_s = o.start_s;
    return axis;
}

inline TurntableMotion turntable_of(const hnav_turntable_options& o) {
    TurntableMotion motion;
    const RandomStream random(static_cast<std::uint64_t>(o.seed), streams::turntable);
    const hnav_axis_options* axes[] = {&o.roll, &o.pitch, &o.yaw};
    for (int i = 0; i < 3; ++i) motion.axes[i] = axis_of(*axes[i], random.uniform(static_cast<std::uint64_t>(i)));
    motion.force_n = {0, 0, -o.gravity_m_s2};
    const double dip = o.field_dip_rad, declination = o.declination_rad;
    motion.field_n = o.field_strength_tesla *
                     Vector3(std::cos(dip) * std::cos(declination), std::cos(dip) * std::sin(declination), std::sin(dip));
    return motion;
}

} // namespace hnav
