// The options of truth and sensor models as rows, and the stamps of their layouts.
#pragma once

#include "c_api/option_table.hpp"
#include "hnav/simulation.h"

namespace hnav {

OptionTable turntable_option_table();
OptionTable imu_mag_sensor_option_table();

// "hnav", options layout 1, plant
constexpr std::uint64_t turntable_cookie = 0x686e61760001'0201ull;
constexpr std::uint64_t imu_mag_sensor_cookie = 0x686e61760001'0202ull;

} // namespace hnav
