// The inputs and the parameter of a sensor whose samples come in: where they stand in the table, and those that all sensors have.
#pragma once

#include "adapter/rows.hpp"

namespace hnav::fmu {

struct SensorRows {
    int value, sample, t_meas, valid, period; // value: the first of those that the push call of the sensor takes

    // What marks samples. valid: whether they are without the importer's word.
    void add_marks(Table& table, const char* sensor, bool valid_at_start) {
        sample = table.add(rows::sample_counter(rows::Name(sensor, "sample")));
        t_meas = table.add(rows::sample_time(rows::Name(sensor, "t_meas")));
        valid =
            table.add(rows::input(rows::Name(sensor, "valid"), Type::boolean, valid_at_start, "False: the sample is not used"));
    }

    void add_period(Table& table, const char* name, double usual_s) {
        Variable v = rows::parameter(name, "s", usual_s, 0, 1e6, "Sampling period (sampling_mode periodic or held); 0: never");
        v.display_unit = "ms";
        v.basic = true;
        period = table.add(v);
    }
};

} // namespace hnav::fmu
