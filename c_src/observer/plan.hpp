// The plan of an observer: which variables of an FMU are states, inputs and sensors, with their statistics. It is a text in the
// unpacked FMU, so that this library reads no XML; its author has read modelDescription.xml. Its lines:
//
//     hnav_observer_plan 1                                        first
//     fmi 2                                                       or 3
//     identifier NAME                                             of the model, in Model Exchange
//     token TEXT                                                  GUID or instantiation token
//     binary PATH                                                 from the folder; binaries/*/NAME.*: that for this machine
//     indicators N                                                event indicators that the FMU declares
//     derivatives 1                                               it provides directional derivatives
//     discrete 1                                                  it has discrete variables
//     state_access N                                              0: none, 1: its state can be got and set, 2: and serialised
//     step_done 1                                                 CompletedIntegratorStep is to be called
//     once 1                                                      one instance for each process
//     memoryless 1                                                stated by the user, in spite of indicators
//     never_freed 1                                               it crashes when it is freed
//     cosimulation STEP                                           Co-Simulation, with a usual step in seconds
//     set REFERENCE VALUE                                         before initialisation
//     state REFERENCE DERIVATIVE START SIGMA NOISE NOMINAL READY  in the order of the FMU
//     input REFERENCE DISCRETE START                              a known one; DISCRETE 1: may change at events only
//     unknown REFERENCE START SIGMA NOISE NOMINAL READY TIME_CONSTANT
//     parameter REFERENCE START SIGMA NOISE NOMINAL READY
//     sensor REFERENCE OUTPUT SIGMA GATE                          OUTPUT 1: of that causality, its derivatives are available
//     bound INDEX MIN MAX                                         of an estimated number: states, unknown, parameters
//     depends STATE INDEX ...                                     its derivative: on no other states and unknown inputs, with all such
//                                                                 lines; a state without one: on all
//     logarithmic INDEX                                           of a parameter, by its place among them: by its logarithm
//     end                                                         last
//
// Each may end in a name, after its numbers. A START of nan is the FMU's own value, a READY of inf no limit.
#pragma once

#include "observer/problem.hpp"

#include <bitset>
#include <cmath>
#include <cstdint>

namespace hnav::observer {

constexpr int max_inputs = 128, max_set = 1000, max_path = 1024, max_text = 256;

struct Plan {
    int fmi = 0, indicators = 0;
    int state_access = 0;
    bool derivatives = false, once = false, memoryless = false, never_freed = false, discrete = false, step_done = false;
    double step_s = 0; // of Co-Simulation; 0: Model Exchange
    char identifier[max_text] = "", token[max_text] = "", binary[max_path] = "";
    PlantSizes sizes;

    std::uint32_t state[max_estimated], derivative[max_estimated], input[max_inputs], parameter[max_estimated];
    std::uint32_t sensor[max_channels_used], set[max_set];
    bool input_is_discrete[max_inputs], sensor_is_output[max_channels_used];
    double set_value[max_set];
    int set_count = 0;

    // In the order of what is estimated once the whole has been read.
    double start[max_estimated], start_sigma[max_estimated], noise[max_estimated], nominal[max_estimated];
    double ready_sigma[max_estimated], time_constant_s[max_estimated], input_start[max_inputs];
    double sensor_sigma[max_channels_used], gate_nis[max_channels_used];
    double min[max_estimated], max[max_estimated];
    std::uint8_t logarithmic[max_estimated] = {};
    bool declared[max_estimated] = {}; // rows of dependencies
    std::bitset<max_estimated * max_estimated> dependent;

    Plan() {
        for (int i = 0; i < max_estimated; ++i) {
            min[i] = -HUGE_VAL;
            max[i] = HUGE_VAL;
        }
    }

    Statistics statistics() const {
        return {start,       start_sigma,  noise,    nominal, ready_sigma, time_constant_s,
                input_start, sensor_sigma, gate_nis, min,     max,         logarithmic};
    }

    bool depends(int derivative, int on) const { return !declared[derivative] || dependent[derivative * max_estimated + on]; }

    // From folder/observer.plan. False: why says in which line.
    bool read(const char* folder, Refusal& why);
};

} // namespace hnav::observer
