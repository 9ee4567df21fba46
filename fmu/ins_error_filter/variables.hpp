// The variables of the InsErrorFilter FMU: parameters are the options of the C API and what the aircraft's file says.
#pragma once

#include "adapter/option_row.hpp"
#include "adapter/sampling.hpp"
#include "aircraft/parameters.hpp"

#include <initializer_list>

namespace hnav::fmu {

// Parts of the filter that outputs are read from, so that a step costs only what is asked for.
enum Group : unsigned { estimate_group = 1, lambda_group = 2, innovation_group = 4, noise_group = 8, status_group = 16 };

// Where the variables stand in the table; of vectors, the first row.
struct Places {
    int z, sample, t_meas, present, u, reset;
    int sampling_mode, options;
    aircraft::Parameters parameters;

    int post_t, estimate, sigma;
    int lambda, lambda_sigma, compensated;
    int innovation, nis;
    int noise_scale, fault_probability;
    int separability, samples, missed, non_finite, failed;

    void describe(Table& table) {
        using namespace rows;
        using aircraft::add_each, aircraft::states, aircraft::controls;
        constexpr auto held = Variability::discrete;
        constexpr auto none = DependsOn::nothing;

        Variable time = variable("time", Type::real, Causality::independent, Variability::continuous, "Simulation time");
        time.unit = "s";
        table.add(time);

        z = add_each(table, "z", states, input("", "", "", 0, "Measurement of the INS; NaN is a missing channel"));
        sample =
            table.add(input("z.sample", Type::integer, 0, "Sample counter: a change marks a new sample (sampling_mode counter)"));
        t_meas = table.add(input("z.t_meas", "s", "ms", 0, "Time at which the sample was measured (sampling_mode counter)"));
        u = add_each(table, "u", controls, input("", "", "", 0, "Control that was held since the sample before"));
        present = add_each(table, "present", states, input("", Type::boolean, 1, "False: the channel is missing"));
        reset = table.add(input("reset", Type::boolean, 0, "Rising edge: back to the state after initialization"));

        sampling_mode =
            table.add(choice("sampling_mode", sampling_modes, 2, periodic,
                             "periodic: inputs are sampled every interval; counter: when the sample counter changes"));
        const hnav_ins_error_options defaults = hnav_ins_error_defaults();
        options = table.size();
        for (int k = 0; const hnav_option_info* option = hnav_ins_error_option(k); ++k)
            table.add(option_row(*option, &defaults, 0));
        parameters.describe(table);

        post_t = table.add(
            output("post.t", "s", "ms", estimate_group, held, none,
                   "Time of the sample that the outputs are about: the newest, or the one before it (mdkf, amdkf, lag)"));
        estimate = add_each(table, "estimate", states, output("", "", "", estimate_group, held, none, "State"));
        sigma =
            add_each(table, "sigma", states, output("", "", "", estimate_group, held, none, "Standard deviation of the state"));
        lambda = add_each(table, "lambda", states,
                          output("", "", "", lambda_group, held, none,
                                 "Coloured error of the channel; forms other than augmented answer measurement minus estimate"));
        lambda_sigma = add_each(table, "lambda_sigma", states,
                                output("", "", "", lambda_group, held, none, "Standard deviation of the coloured error"));
        compensated = add_each(table, "compensated", states,
                               output("", "", "", lambda_group, held, none,
                                      "Measurement without its coloured error; of a missing channel the estimate"));
        innovation =
            add_each(table, "innov", states,
                     output("", "", "", innovation_group, held, none, "Innovation of the newest sample; 0 where there was none"));
        nis = table.add(
            output("nis", "", "", innovation_group, held, none,
                   "Normalised innovation squared of the newest sample; its expectation is the number of present channels"));
        noise_scale =
            add_each(table, "noise_scale", states,
                     output("", "", "", noise_group, held, none, "Factor on the variance of the channel's white noise"));
        fault_probability = add_each(
            table, "fault_probability", states,
            output("", "", "", noise_group, held, none, "Probability that the channel's noise is above its healthy level"));
        for (int i = 0; i < aircraft::nx; ++i) {
            for (int row : {noise_scale + i, fault_probability + i}) table.row(row).unit = table.row(row).display_unit = "";
            table.row(noise_scale + i).start = 1;
        }
        separability =
            table.add(output("separability", "", "", status_group, held, none,
                             "How differently states and coloured errors move the measurements: below 0.1 they separate poorly"));
        samples = table.add(output("count.samples", Type::integer, status_group, "Samples used"));
        missed = table.add(output("count.missed", Type::integer, status_group, "Samples that a coarse communication step lost"));
        non_finite = table.add(output("count.non_finite", Type::integer, status_group,
                                      "Infinite measurements taken as missing, and controls that were no numbers"));
        failed = table.add(output("count.failed", Type::integer, status_group,
                                  "Samples without an answer: the innovation covariance was singular"));
    }
};

} // namespace hnav::fmu
