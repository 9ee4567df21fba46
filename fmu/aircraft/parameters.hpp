// Parameters that the plant and the filter of one aircraft share under the same names: the values of the model file, which
// the user can override.
#pragma once

#include "aircraft/data.hpp"

namespace hnav::fmu::aircraft {

struct Parameters {
    int interval, euler_colour, exact_process_noise;
    int process_noise, measurement_sigma, ins_error_sigma, ins_error_time_constant, start, start_sigma;

    void describe(Table& table) {
        using namespace rows;
        interval = table.add(parameter("interval", "s", interval_s, min_period_s, 1e6, "Interval between samples"));
        table.row(interval).display_unit = "ms";
        table.row(interval).field = "interval_s";
        euler_colour =
            table.add(flag("euler_colour", "INS error by 1 - dt/tau, as the paper prints it, in place of exp(-dt/tau)"));
        exact_process_noise = table.add(flag(
            "exact_process_noise",
            "Process noise integrated over the interval, which correlates the states, in place of variance density times interval"));
        process_noise = add_each(table, "process_noise", states,
                                 parameter("", "", 0, 0, 1e9, "White noise that drives the state, standard deviation"),
                                 process_noise_per_sqrt_s);
        for (int i = 0; i < nx; ++i) {
            table.row(process_noise + i).unit = states[i].noise_unit;
            table.row(process_noise + i).display_unit = "";
        }
        measurement_sigma =
            add_each(table, "measurement_sigma", states,
                     parameter("", "", 0, 0, 1e9, "White noise of the channel, standard deviation"), aircraft::measurement_sigma);
        ins_error_sigma = add_each(table, "ins_error_sigma", states,
                                   parameter("", "", 0, 0, 1e9, "Coloured error of the channel, standard deviation"),
                                   aircraft::ins_error_sigma);
        ins_error_time_constant = add_each(
            table, "ins_error_time_constant", states,
            time_constant("accelerometer_error.time_constant_s", 0, "Coloured error of the channel, time constant, above 0"),
            ins_error_time_constant_s);
        start = add_each(table, "start", states, parameter("", "", 0, -1e9, 1e9, "State at the first sample, mean"));
        start_sigma =
            add_each(table, "start_sigma", states, parameter("", "", 0, 0, 1e9, "State at the first sample, standard deviation"),
                     aircraft::start_sigma);
    }

    // values: those of all rows; must outlive the returned model.
    hnav_aircraft_model model(const double* values) const {
        auto m = hnav_sized<hnav_aircraft_model>();
        m.nx = nx;
        m.nu = nu;
        m.interval_s = values[interval];
        m.A_1_s = A_1_s;
        m.B_1_s = B_1_s;
        m.process_noise_per_sqrt_s = values + process_noise;
        m.measurement_sigma = values + measurement_sigma;
        m.accelerometer_error = {values + ins_error_sigma, values + ins_error_time_constant};
        m.start = values + start;
        m.start_sigma = values + start_sigma;
        return m;
    }

    hnav_aircraft_options options(const double* values) const {
        hnav_aircraft_options o = hnav_aircraft_defaults();
        o.euler_colour = values[euler_colour] != 0;
        o.exact_process_noise = values[exact_process_noise] != 0;
        return o;
    }

private:
    static Variable flag(const char* name, const char* text) {
        Variable v = variable(name, Type::boolean, Causality::parameter, Variability::fixed, text);
        v.min = 0;
        v.max = 1;
        return v;
    }
};

} // namespace hnav::fmu::aircraft
