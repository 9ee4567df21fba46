// Inputs and parameters of the Ins FMU. Apart from the sampling, parameters are options of the C API.
#pragma once

#include "adapter/option_parameters.hpp"
#include "adapter/sensor_rows.hpp"

namespace hnav::fmu {

inline constexpr char option_list[] = "ins";

// In the order in which the samples of one communication point are taken: the force before the rate, because they are pushed
// together.
enum InsInput { in_accel, in_gyro, in_position, in_velocity, in_pressure, in_speed, in_heading, in_mag, ins_inputs };

struct InsInputs {
    static constexpr const char* periods[ins_inputs] = {"accel.period", "gyro.period",  "gnss.period", "gnssvel.period",
                                                        "baro.period",  "wheel.period", "aid.period",  "mag.period"};
    static constexpr const char* counters[ins_inputs] = {"accel.sample", "gyro.sample",  "gnss.sample", "gnssvel.sample",
                                                         "baro.sample",  "wheel.sample", "aid.sample",  "mag.sample"};
    SensorRows sensor[ins_inputs]; // sigmas behind the value
    int reset, preset, sampling_mode, options;

    void describe(Table& table) {
        vector(table, in_gyro, "gyro", "rate", "rad/s", "deg/s", "Angular rate in sensor axes");
        vector(table, in_accel, "accel", "force", "m/s2", "",
               "Specific force in sensor axes; at rest with z down it is (0, 0, -9.81)");
        table.row(sensor[in_accel].value + 2).start = -9.80665;
        sensor[in_gyro].also = sensor[in_accel].value;
        describe_satellites(table);
        scalar(table, in_pressure, "baro", "pressure", "sigma", "Pa", "", 101325, 20, "Pressure of the air");
        scalar(table, in_speed, "wheel", "speed", "sigma", "m/s", "", 0, 0.1, "Speed along body x, by wheels");
        scalar(table, in_heading, "aid", "heading", "heading_sigma", "rad", "deg", 0, 0.05,
               "Heading of body x, clockwise from north");
        vector(table, in_mag, "mag", "field", "T", "uT", "Magnetic field in sensor axes; another unit does as well");
        reset = table.add(rows::reset_command());
        Variable v = rows::choice("preset", preset_choices<option_list>(),
                                  "Grade of the sensors; parameters that differ from their start values override it");
        v.basic = true;
        preset = table.add(v);
        describe_sampling(table);
        const hnav_ins_options defaults = hnav_ins_defaults(static_cast<hnav_ins_preset>(hnav_preset_of("ins", 0)->value));
        options = add_options(table, option_of<option_list>, &defaults);
    }

private:
    void describe_satellites(Table& table) {
        using namespace rows;
        const int place = table.add(input("gnss.latitude", "rad", "deg", 0, "Latitude of the antenna"));
        table.add(input("gnss.longitude", "rad", "deg", 0, "Longitude of the antenna"));
        table.add(input("gnss.height", "m", "", 0, "Height of the antenna above the ellipsoid of WGS 84"));
        sigmas(table, "gnss.sigma", "m", 2, 4);
        marks(table, in_position, "gnss", place);
        const int velocity =
            table.add_vector(input("gnssvel.velocity", "m/s", "", 0, "Velocity of the antenna, north, east, down"), 3);
        sigmas(table, "gnssvel.sigma", "m/s", 0.2, 0.2);
        marks(table, in_velocity, "gnssvel", velocity);
    }

    static void sigmas(Table& table, const char* name, const char* unit, double horizontal, double vertical) {
        const int at = table.add_vector(rows::input(name, unit, "", horizontal, "Standard deviations north, east, down"), 3);
        table.row(at + 2).start = vertical;
    }

    void vector(Table& table, int s, const char* prefix, const char* name, const char* unit, const char* display,
                const char* text) {
        const Variable v = rows::input(rows::Name(prefix, name), unit, display, 0, text);
        marks(table, s, prefix, table.add_vector(v, 3));
    }

    void scalar(Table& table, int s, const char* prefix, const char* name, const char* sigma, const char* unit,
                const char* display, double start, double start_sigma, const char* text) {
        const int at = table.add(rows::input(rows::Name(prefix, name), unit, display, start, text));
        table.add(rows::input(rows::Name(prefix, sigma), unit, display, start_sigma, "Its standard deviation"));
        marks(table, s, prefix, at);
    }

    void marks(Table& table, int s, const char* prefix, int value) {
        sensor[s].value = value;
        sensor[s].add_marks(table, prefix, s == in_gyro || s == in_accel);
    }

    void describe_sampling(Table& table) {
        sampling_mode = model_info.clocks ? -1 : table.add(rows::sampling_mode("What makes held inputs a sample"));
        constexpr double usual_s[ins_inputs] = {0.01, 0.01, 1, 1, 0.1, 0.1, 0.1, 0.1};
        for (int s = 0; s < ins_inputs; ++s) sensor[s].add_period(table, periods[s], usual_s[s]);
    }
};

} // namespace hnav::fmu
