// Inputs and parameters of an FMU of an attitude filter. Apart from the sampling, parameters are options of the C API.
#pragma once

#include "adapter/option_parameters.hpp"
#include "adapter/sensor_rows.hpp"

namespace hnav::fmu {

// Their rows in the table. sensors: those that the FMU has inputs for, the first of hnav_sensor.
template <int sensors>
struct Inputs {
    static constexpr const char* periods[] = {"gyro.period", "accel.period", "mag.period", "aid.period", "wheel.period"};
    static constexpr const char* counters[] = {"gyro.sample", "accel.sample", "mag.sample", "aid.sample", "wheel.sample"};
    SensorRows sensor[sensors]; // value: three components; of an aid: its value, sigma
    int reset, realign;
    int preset; // -1: there is one set of defaults, and no choice
    int sampling_mode; // -1: clocks tick
    int options; // the first of them

    template <class Kind>
    void describe(Table& table) {
        for (int s = 0; s < sensors; ++s) describe_sensor(table, s);
        sensor[HNAV_SENSOR_GYRO].also = sensor[HNAV_SENSOR_ACCEL].value;
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
            const char *sigma = nullptr, *sigma_text = nullptr; // of an aid
            double sigma_start = 0;
        };
        static constexpr Described described[] = {
            {"gyro", "rate", "rad/s", "deg/s", "Angular rate in sensor axes", {0, 0, 0}},
            {"accel",
             "force",
             "m/s2",
             "",
             "Specific force in sensor axes; at rest with z down it is (0, 0, -9.81)",
             {0, 0, -9.80665}},
            {"mag", "field", "T", "uT", "Magnetic field in sensor axes", {2e-5, 0, 4.5e-5}},
            {"aid",
             "heading",
             "rad",
             "deg",
             "True heading of body x, clockwise from north",
             {0, 0, 0},
             "heading_sigma",
             "Standard deviation of the heading",
             0.05},
            {"wheel",
             "speed",
             "m/s",
             "",
             "Speed along body x, by GNSS, wheels or airspeed, of a body that moves where body x points",
             {0, 0, 0},
             "sigma",
             "Standard deviation of the speed",
             0.1},
        };
        const Described& d = described[s];
        const bool aid = d.sigma;
        SensorRows& at = sensor[s];
        const Variable v = rows::input(rows::Name(d.prefix, d.value), d.unit, d.display, 0, d.text);
        at.value = aid ? table.add(v) : table.add_vector(v, 3);
        if (aid) table.add(rows::input(rows::Name(d.prefix, d.sigma), d.unit, d.display, d.sigma_start, d.sigma_text));
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
