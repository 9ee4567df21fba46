// Inputs and parameters of an FMU of an attitude filter. Apart from the sampling, parameters are options of the C API.
#pragma once

#include "adapter/option_parameters.hpp"
#include "adapter/sensor_rows.hpp"

namespace hnav::fmu {

// Their rows in the table.
struct Inputs {
    static constexpr int sensors = HNAV_SENSOR_HEADING + 1; // sensors that the FMU has inputs for
    static constexpr const char* periods[sensors] = {"gyro.period", "accel.period", "mag.period", "aid.period"};
    static constexpr const char* counters[sensors] = {"gyro.sample", "accel.sample", "mag.sample", "aid.sample"};
    SensorRows sensor[sensors]; // value: three components; of the heading aid: heading, sigma
    int reset, realign;
    int preset; // -1: there is one set of defaults, and no choice
    int sampling_mode; // -1: clocks tick
    int options; // the first of them

    template <class Kind>
    void describe(Table& table) {
        for (int s = 0; s < sensors; ++s) describe_sensor(table, s);
        reset = table.add(rows::reset_command());
        realign = table.add(
            rows::input("realign", Type::boolean, 0, "Rising edge: forget the attitude and start again, keep the gyro bias"));
        const Choices presets = Kind::presets();
        preset = -1;
        if (presets.count > 1) {
            Variable v =
                rows::choice("preset", presets, "Set of defaults; parameters that differ from their start values override it");
            v.basic = true;
            preset = table.add(v);
        }
        describe_sampling(table);
        const typename Kind::Options defaults = Kind::defaults(0);
        options = add_options(table, Kind::option, &defaults);
    }

private:
    void describe_sensor(Table& table, int s) {
        struct Described {
            const char *prefix, *value, *unit, *display, *text;
            double start[3];
        };
        constexpr Described described[] = {
            {"gyro", "rate", "rad/s", "deg/s", "Angular rate in sensor axes", {0, 0, 0}},
            {"accel",
             "force",
             "m/s2",
             "",
             "Specific force in sensor axes; at rest with z down it is (0, 0, -9.81)",
             {0, 0, -9.80665}},
            {"mag", "field", "T", "uT", "Magnetic field in sensor axes", {2e-5, 0, 4.5e-5}},
            {"aid", "heading", "rad", "deg", "True heading of body x, clockwise from north", {0, 0, 0}},
        };
        const Described& d = described[s];
        const bool aid = s == HNAV_SENSOR_HEADING;
        SensorRows& at = sensor[s];
        const Variable v = rows::input(rows::Name(d.prefix, d.value), d.unit, d.display, 0, d.text);
        at.value = aid ? table.add(v) : table.add_vector(v, 3);
        if (aid)
            table.add(
                rows::input(rows::Name(d.prefix, "heading_sigma"), "rad", "deg", 0.05, "Standard deviation of the heading"));
        else
            for (int i = 0; i < 3; ++i) table.row(at.value + i).start = d.start[i];
        at.add_marks(table, d.prefix, !aid);
    }

    void describe_sampling(Table& table) {
        sampling_mode = model_info.clocks ? -1 : table.add(rows::sampling_mode("What makes held inputs a sample"));
        for (int s = 0; s < sensors; ++s) sensor[s].add_period(table, periods[s], 0.01);
    }
};

} // namespace hnav::fmu
