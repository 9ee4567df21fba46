// Made by c_src/options/generate.py from the lists: change that, then ./run generate.
#pragma once

#include "base/option_list.hpp"
#include "base/small.hpp"

namespace hnav {

extern const OptionList ahrs_options;
extern const OptionList hrekf_options;
extern const OptionList ins_options;
extern const OptionList ins_error_options;
extern const OptionList magnetometer_options;
extern const OptionList turntable_options;
extern const OptionList imu_mag_sensor_options;
extern const OptionList vehicle_options;
extern const OptionList aid_sensor_options;
extern const OptionList aircraft_options;
extern const OptionList observer_options;

// Descriptions for a reader; the small build has no room for them.
constexpr const char* text(const char* description) { return small_build ? "" : description; }

} // namespace hnav
