// What differs between the attitude filters. A Kind is a KindOf and beside it
//     static constexpr ModelInfo info
//     static constexpr int accel_dimension, accel_unit      of the innovation of force
//     static constexpr int sensors                          that have inputs, the first of hnav_sensor
//     static constexpr bool has_field                       outputs of the magnetic reference and the gyro calibration
//     static constexpr bool reholds                         Model Exchange can take the backward gyro hold
#pragma once

#include "adapter/option_parameters.hpp"
#include "adapter/state_rows.hpp"

namespace hnav::fmu {

// The options of a filter and their calls in the C API.
template <class Options_, Options_ (*defaults_)(hnav_preset), const char* list,
          hnav_status (*create_)(hnav_filter**, const Options_*, char*, std::size_t)>
struct KindOf {
    using Options = Options_;
    static constexpr OptionAt option = option_of<list>;
    static constexpr auto create = create_;

    // choice: of presets.
    static Options defaults(int choice) { return defaults_(static_cast<hnav_preset>(hnav_preset_of(list, choice)->value)); }

    static Choices presets() { return preset_choices<list>(); }

    static void describe_states(StateRows& states) {
        states.add_attitude("Attitude, body to north-east-down of magnetic north");
        char name[32];
        for (int j = 1; j <= 3; ++j)
            for (int i = 1; i <= 3; ++i) {
                std::snprintf(name, sizeof name, "state.G[%d,%d]", i, j);
                states.add(name, "s", 0, DependsOn::first_states,
                           "Integral of the rotation matrix since the last correction: how bias becomes rotation");
            }
        states.add("state.clock", "s", 0, DependsOn::nothing, "Time since the last correction");
    }
};

} // namespace hnav::fmu
