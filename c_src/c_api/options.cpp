// The C boundary of options: fields by name, tables, and the defaults of all but the attitude filters.
#include "base/option_list.hpp"
#include "hnav/hnav.h"
#include "options/lists.hpp"

#include <cmath>

using hnav::made_from;

namespace {

bool has_component(const hnav_option_info* row, int component) { return component >= 0 && component < row->count; }

} // namespace

extern "C" {

const hnav_option_info* hnav_ahrs_option(int32_t index) { return hnav::option_at(hnav::ahrs_options, index); }
const hnav_preset_info* hnav_ahrs_preset(int32_t index) { return hnav::preset_at(hnav::ahrs_options, index); }
const hnav_option_info* hnav_hrekf_option(int32_t index) { return hnav::option_at(hnav::hrekf_options, index); }
const hnav_preset_info* hnav_hrekf_preset(int32_t index) { return hnav::preset_at(hnav::hrekf_options, index); }

hnav_ins_error_options hnav_ins_error_defaults(void) { return made_from<hnav_ins_error_options>(hnav::ins_error_options); }
const hnav_option_info* hnav_ins_error_option(int32_t index) { return hnav::option_at(hnav::ins_error_options, index); }

hnav_magnetometer_options hnav_magnetometer_defaults(void) {
    return made_from<hnav_magnetometer_options>(hnav::magnetometer_options);
}
const hnav_option_info* hnav_magnetometer_option(int32_t index) { return hnav::option_at(hnav::magnetometer_options, index); }

hnav_turntable_options hnav_turntable_defaults(void) { return made_from<hnav_turntable_options>(hnav::turntable_options); }
const hnav_option_info* hnav_turntable_option(int32_t index) { return hnav::option_at(hnav::turntable_options, index); }

hnav_imu_mag_sensor_options hnav_imu_mag_sensor_defaults(void) {
    return made_from<hnav_imu_mag_sensor_options>(hnav::imu_mag_sensor_options);
}
const hnav_option_info* hnav_imu_mag_sensor_option(int32_t index) { return hnav::option_at(hnav::imu_mag_sensor_options, index); }

hnav_vehicle_options hnav_vehicle_defaults(void) { return made_from<hnav_vehicle_options>(hnav::vehicle_options); }
const hnav_option_info* hnav_vehicle_option(int32_t index) { return hnav::option_at(hnav::vehicle_options, index); }

hnav_aid_sensor_options hnav_aid_sensor_defaults(void) { return made_from<hnav_aid_sensor_options>(hnav::aid_sensor_options); }
const hnav_option_info* hnav_aid_sensor_option(int32_t index) { return hnav::option_at(hnav::aid_sensor_options, index); }

hnav_aircraft_options hnav_aircraft_defaults(void) { return made_from<hnav_aircraft_options>(hnav::aircraft_options); }
const hnav_option_info* hnav_aircraft_option(int32_t index) { return hnav::option_at(hnav::aircraft_options, index); }

hnav_observer_options hnav_observer_defaults(void) { return made_from<hnav_observer_options>(hnav::observer_options); }
const hnav_option_info* hnav_observer_option(int32_t index) { return hnav::option_at(hnav::observer_options, index); }

double hnav_option_value(const hnav_option_info* row, const void* options, int32_t component) {
    return row && options && has_component(row, component) ? hnav::option_value(*row, options, component) : std::nan("");
}

hnav_status hnav_set_option_value(const hnav_option_info* row, void* options, int32_t component, double value) {
    if (!row || !options) return HNAV_ERROR_NULL_ARGUMENT;
    if (!has_component(row, component)) return HNAV_ERROR_OUT_OF_RANGE;
    hnav::set_option_value(*row, options, component, value);
    return HNAV_OK;
}

} // extern "C"
