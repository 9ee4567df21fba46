// What differs between the attitude filters. A Kind is a KindOf and beside it
//     static constexpr ModelInfo info
//     static constexpr int accel_dimension, accel_unit      of the innovation of force
//     static constexpr bool has_field                       outputs of the magnetic reference and the gyro calibration
//     static constexpr bool reholds                         Model Exchange can take the backward gyro hold
//     static void describe_states(StateRows&)
//     static void keep_on_realign(const double* x, double* replaced)    states that a realignment leaves as they are
#pragma once

#include "adapter/option_parameters.hpp"
#include "adapter/state_rows.hpp"

namespace hnav::fmu {

// The options of a filter and the calls of the C API about them.
template <class Options_, Options_ (*defaults_)(hnav_preset), const char* list,
          hnav_status (*create_)(hnav_filter**, const Options_*, char*, std::size_t)>
struct KindOf {
    using Options = Options_;
    static constexpr OptionAt option = option_of<list>;
    static constexpr auto create = create_;

    // choice: of presets.
    static Options defaults(int choice) { return defaults_(static_cast<hnav_preset>(hnav_preset_of(list, choice)->value)); }

    static Choices presets() { return preset_choices<list>(); }
};

} // namespace hnav::fmu
