// The C boundary of options: fields by name, tables, and the defaults of all but the attitude filters.
#include "base/option_list.hpp"
#include "hnav/hnav.h"
#include "options/lists.hpp"

#include <cmath>
#include <cstring>

using hnav::made_from;

namespace {

const struct {
    const char* name;
    const hnav::OptionList& list;
} lists[] = {
    {"ahrs", hnav::ahrs_options},
    {"hrekf", hnav::hrekf_options},
    {"ins", hnav::ins_options},
    {"ins_error", hnav::ins_error_options},
    {"observer", hnav::observer_options},
    {"magnetometer", hnav::magnetometer_options},
    {"turntable", hnav::turntable_options},
    {"imu_mag_sensor", hnav::imu_mag_sensor_options},
    {"vehicle", hnav::vehicle_options},
    {"aid_sensor", hnav::aid_sensor_options},
    {"aircraft", hnav::aircraft_options},
};

// Null for an unknown list.
const hnav::OptionList* list_of(const char* name) {
    for (const auto& known : lists)
        if (name && std::strcmp(name, known.name) == 0) return &known.list;
    return nullptr;
}

bool has_component(const hnav_option_info* row, int component) { return component >= 0 && component < row->count; }

} // namespace

extern "C" {

hnav_ins_error_options hnav_ins_error_defaults(void) { return made_from<hnav_ins_error_options>(hnav::ins_error_options); }

hnav_magnetometer_options hnav_magnetometer_defaults(void) {
    return made_from<hnav_magnetometer_options>(hnav::magnetometer_options);
}

hnav_turntable_options hnav_turntable_defaults(void) { return made_from<hnav_turntable_options>(hnav::turntable_options); }

hnav_imu_mag_sensor_options hnav_imu_mag_sensor_defaults(void) {
    return made_from<hnav_imu_mag_sensor_options>(hnav::imu_mag_sensor_options);
}

hnav_vehicle_options hnav_vehicle_defaults(void) { return made_from<hnav_vehicle_options>(hnav::vehicle_options); }

hnav_aid_sensor_options hnav_aid_sensor_defaults(void) { return made_from<hnav_aid_sensor_options>(hnav::aid_sensor_options); }

hnav_aircraft_options hnav_aircraft_defaults(void) { return made_from<hnav_aircraft_options>(hnav::aircraft_options); }

hnav_observer_options hnav_observer_defaults(void) { return made_from<hnav_observer_options>(hnav::observer_options); }

const hnav_option_info* hnav_option(const char* of, int32_t index) {
    const hnav::OptionList* list = list_of(of);
    return list ? hnav::option_at(*list, index) : nullptr;
}

const hnav_preset_info* hnav_preset_of(const char* of, int32_t index) {
    const hnav::OptionList* list = list_of(of);
    return list ? hnav::preset_at(*list, index) : nullptr;
}

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
