// The inputs and the parameter of a sampled sensor: their rows, and the inputs that all sensors have.
#pragma once

#include "adapter/model.hpp"
#include "adapter/rows.hpp"

namespace hnav::fmu {

struct SensorRows {
    int value, sample, t_meas; // value: the first row of those that the sensor's push call takes
    int valid = -1, period = -1; // none where a clock ticks
    int also = -1; // first of three more values that change with these: a rate may be constant, rate and force are not

    int count() const { return sample - value; }

    // The inputs that mark samples; they follow the value. valid: the start value of the valid flag.
    void add_marks(Table& table, const char* sensor, bool valid_at_start) {
        if (model_info.clocks) {
            sample = table.add(rows::clock(rows::Name(sensor, "tick"), Causality::input, "Ticks when there is a new sample"));
            t_meas = table.add(rows::input(rows::Name(sensor, "t_meas"), "s", "", 0, "Time at which the sample was measured"));
            table.put_on_clock(sample, value, t_meas);
            return;
        }
        sample = table.add(rows::sample_counter(rows::Name(sensor, "sample")));
        t_meas = table.add(rows::sample_time(rows::Name(sensor, "t_meas")));
        valid =
            table.add(rows::input(rows::Name(sensor, "valid"), Type::boolean, valid_at_start, "False: the sample is not used"));
    }

    void add_period(Table& table, const char* name, double usual_s) {
        if (model_info.clocks) return;
        Variable v =
            rows::parameter(name, "s", usual_s, 0, 1e6, "Sampling period (sampling_mode auto, periodic or held); 0: never");
        v.display_unit = "ms";
        v.basic = true;
        period = table.add(v);
    }
};

} // namespace hnav::fmu
