// The variables of the InsErrorFilter FMU: parameters are options of the C API and values of the aircraft's file.
#pragma once

#include "adapter/option_parameters.hpp"
#include "adapter/outputs.hpp"
#include "aircraft/parameters.hpp"

namespace hnav::fmu {

inline constexpr char option_list[] = "ins_error";

using namespace rows;
using aircraft::add_each, aircraft::states, aircraft::controls, aircraft::nx, aircraft::nu;

// Calls of the C API behind the outputs; a step makes only those that are needed.
enum Group { estimate_group, lambda_group, innovation_group, noise_group, status_group };

// The answers behind the outputs.
struct Estimate {
    double t_s;
    double x[nx], sigma[nx];
};
struct ColouredError {
    double lambda[nx], sigma[nx], compensated[nx];
};
struct Innovation {
    double value[nx], nis;
};
struct Noise {
    double scale[nx], fault_probability[nx], bias_fault_probability[nx], process_fault_probability;
};
struct Counts {
    double separability;
    double samples, missed, non_finite, failed;
};

// Rows of inputs and parameters; for vectors, the first row. Outputs: what they show.
struct Variables {
    int z, sample, t_meas, present, u, reset;
    int sampling_mode, options;
    aircraft::Parameters parameters;

    Outputs<Estimate, estimate_group> estimate;
    Outputs<ColouredError, lambda_group> lambda;
    Outputs<Innovation, innovation_group> innovation;
    Outputs<Noise, noise_group> noise;
    Outputs<Counts, status_group> counts;

    void describe(Table& table) {
        table.add(time());
        describe_inputs(table);
        describe_parameters(table);
        describe_estimate(table);
        describe_noise(table);
        describe_counts(table);
    }

private:
    void describe_inputs(Table& table) {
        z = add_each(table, "z", states, input("", "", "", 0, "Measurement of the INS; NaN is a missing channel"));
        sample = table.add(sample_counter("z.sample"));
        t_meas = table.add(sample_time("z.t_meas"));
        u = add_each(table, "u", controls, input("", "", "", 0, "Control that was held since the sample before"));
        present = add_each(table, "present", states, input("", Type::boolean, 1, "False: the channel is missing"));
        reset = table.add(reset_command());
    }

    void describe_parameters(Table& table) {
        sampling_mode = table.add(rows::sampling_mode("What makes held inputs a sample; the period is interval"));
        const hnav_ins_error_options defaults = hnav_ins_error_defaults();
        options = add_options(table, option_of<option_list>, &defaults);
        parameters.describe(table);
    }

    void describe_estimate(Table& table) {
        estimate.add<&Estimate::t_s>(
            table, output("post.t", "s", "",
                          "Time of the sample that the outputs are about: the newest, or the one before it (mdkf, amdkf, lag)"));
        estimate.bind<&Estimate::x>(table, add_each(table, "estimate", states, output("", "", "", "State")));
        estimate.bind<&Estimate::sigma>(table,
                                        add_each(table, "sigma", states, output("", "", "", "Standard deviation of the state")));
        lambda.bind<&ColouredError::lambda>(
            table,
            add_each(table, "lambda", states,
                     output("", "", "",
                            "Coloured error of the channel; forms other than augmented answer measurement minus estimate")));
        lambda.bind<&ColouredError::sigma>(
            table, add_each(table, "lambda_sigma", states, output("", "", "", "Standard deviation of the coloured error")));
        lambda.bind<&ColouredError::compensated>(
            table, add_each(table, "compensated", states,
                            output("", "", "", "Measurement without its coloured error; of a missing channel the estimate")));
        innovation.bind<&Innovation::value>(
            table,
            add_each(table, "innov", states, output("", "", "", "Innovation of the newest sample; 0 where there was none")));
        innovation.add<&Innovation::nis>(
            table,
            output("nis", "", "",
                   "Normalised innovation squared of the newest sample; its expectation is the number of present channels"));
    }

    void describe_noise(Table& table) {
        const int scale = noise.bind<&Noise::scale>(
            table,
            add_each(table, "noise_scale", states, output("", "", "", "Factor on the variance of the channel's white noise")));
        noise.bind<&Noise::fault_probability>(
            table, add_each(table, "fault_probability", states,
                            output("", "", "", "Probability that the channel's noise is above its healthy level")));
        const int bias = noise.bind<&Noise::bias_fault_probability>(
            table,
            add_each(table, "bias_fault_probability", states,
                     output("", "", "", "Probability that the channel's coloured error has jumped; fades once it is learned")));
        noise.add<&Noise::process_fault_probability>(
            table, output("process_fault_probability", "", "",
                          "Probability that state or coloured errors have increased process noise"));
        // Three consecutive vectors, whose rows have the units of the states.
        for (int row = scale; row < bias + nx; ++row) table.row(row).unit = table.row(row).display_unit = "";
        for (int i = 0; i < nx; ++i) table.row(scale + i).start = 1;
    }

    void describe_counts(Table& table) {
        counts.add<&Counts::separability>(
            table, output("separability", "", "",
                          "How differently states and coloured errors move the measurements: below 0.1 they separate poorly"));
        counts.add<&Counts::samples>(table, output("count.samples", Type::integer, "Samples used"));
        counts.add<&Counts::missed>(table,
                                    output("count.missed", Type::integer, "Samples that a coarse communication step lost"));
        counts.add<&Counts::non_finite>(table,
                                        output("count.non_finite", Type::integer,
                                               "Infinite measurements taken as missing, and controls that were no numbers"));
        counts.add<&Counts::failed>(
            table, output("count.failed", Type::integer, "Samples without an answer: the innovation covariance was singular"));
    }
};

} // namespace hnav::fmu
