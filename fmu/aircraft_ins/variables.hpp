// The variables of the AircraftIns FMU: its outputs have the names of the InsErrorFilter's inputs.
#pragma once

#include "adapter/outputs.hpp"
#include "aircraft/parameters.hpp"

namespace hnav::fmu {

using namespace rows;
using aircraft::add_each, aircraft::states, aircraft::controls, aircraft::nx, aircraft::nu;

enum Group { sample_group, status_group };

// The newest sample of the plant.
struct Sample {
    double number, t_s; // counted from 1
    double z[nx], u[nu], x[nx], lambda[nx], fault[nx];
};
struct Counts {
    double non_finite;
};

// Rows of inputs and parameters; for vectors, the first row. Outputs: what they show.
struct Variables {
    int command;
    int seed;
    aircraft::Parameters parameters;
    int gravity_sigma, gravity_time_constant;
    int amplitude, period, phase;
    int fault_start, fault_stop, fault_factor;

    Outputs<Sample, sample_group> sample;
    Outputs<Counts, status_group> counts;

    void describe(Table& table) {
        table.add(time());
        command = add_each(
            table, "command", controls,
            input(
                "", "", "", 0,
                "Control, added to the built-in square wave; taken at the first point at or after a sample and held to the next"));
        Variable number = variable("seed", Type::integer, Causality::parameter, Variability::fixed,
                                   "Seed of the noise: equal seeds give equal flights");
        number.min = 0;
        number.max = 2147483647;
        seed = table.add(number);
        parameters.describe(table);
        describe_gravity(table);
        describe_commands(table);
        describe_faults(table);
        describe_outputs(table);
    }

private:
    void describe_gravity(Table& table) {
        gravity_sigma = add_each(
            table, "gravity_error_sigma", states,
            parameter("", "", 0, 0, 1e9, "Second coloured error of the channel, from the gravity model, standard deviation"));
        gravity_time_constant = add_each(table, "gravity_error_time_constant", states,
                                         aircraft::time_constant("gravity_error.time_constant_s", 200,
                                                                 "Second coloured error of the channel, time constant, above 0"));
    }

    void describe_commands(Table& table) {
        amplitude = add_each(table, "command_amplitude", controls,
                             parameter("", "", 0, -1e9, 1e9, "Amplitude of the built-in square wave; 0 turns it off"));
        period = add_each(table, "command_period", controls,
                          parameter("", "s", 0, 0, 1e9, "Period of the built-in square wave, above 0"));
        phase = add_each(table, "command_phase", controls,
                         parameter("", "rad", 0, -1e9, 1e9,
                                   "Phase of the built-in square wave, which is positive while sin(2 pi t / period + phase) is"));
        for (int j = 0; j < nu; ++j) {
            table.row(amplitude + j).start = aircraft::commands[j].amplitude;
            table.row(period + j).start = aircraft::commands[j].period_s;
            table.row(period + j).min_is_open = true;
            table.row(phase + j).start = aircraft::commands[j].phase_rad;
            table.row(phase + j).display_unit = "deg";
        }
    }

    void describe_faults(Table& table) {
        fault_start = add_each(table, "fault_start", states,
                               parameter("", "s", 0, -1e9, 1e9, "First time of a noise fault of the channel, after the start"));
        fault_stop = add_each(table, "fault_stop", states, parameter("", "s", 0, -1e9, 1e9, "Last time of the noise fault"));
        fault_factor = add_each(
            table, "fault_factor", states,
            parameter("", "", 1, 0, 1e9, "Factor on the standard deviation of the channel's white noise meanwhile; 1: no fault"));
        for (int i = 0; i < nx; ++i) {
            table.row(fault_start + i).start = aircraft::faults[i].start_s;
            table.row(fault_stop + i).start = aircraft::faults[i].stop_s;
            table.row(fault_factor + i).start = aircraft::faults[i].factor;
            table.row(fault_factor + i).unit = table.row(fault_factor + i).display_unit = "";
        }
    }

    void describe_outputs(Table& table) {
        sample.bind<&Sample::z>(
            table,
            add_each(table, "z", states, output("", "", "", "Measurement of the INS: truth, coloured error and white noise")));
        sample.add<&Sample::number>(table, output("z.sample", Type::integer, "Number of the newest sample, counted from 1"));
        sample.add<&Sample::t_s>(table, output("z.t_meas", "s", "", "Time of the newest sample"));
        sample.bind<&Sample::u>(
            table, add_each(table, "u", controls, output("", "", "", "Control that was held up to the newest sample")));
        sample.bind<&Sample::x>(table, add_each(table, "truth", states, output("", "", "", "State at the newest sample")));
        sample.bind<&Sample::lambda>(
            table, add_each(table, "lambda", states, output("", "", "", "Coloured error in the newest sample, both parts")));
        sample.bind<&Sample::fault>(
            table, add_each(table, "fault", states, output("", Type::boolean, "The noise of the channel is at fault")));
        counts.add<&Counts::non_finite>(
            table, output("count.non_finite", Type::integer, "Commands that were no numbers: the one before was held on"));
    }
};

} // namespace hnav::fmu
