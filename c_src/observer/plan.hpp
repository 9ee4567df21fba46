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

#include <cstddef>
#include <cstdint>
#include <cstdio>

namespace hnav::observer {

constexpr int max_path = 1024, max_text = 256;

struct PlanHead {
    int fmi = 0, indicators = 0;
    int state_access = 0;
    bool derivatives = false, once = false, memoryless = false, never_freed = false, discrete = false, step_done = false;
    double step_s = 0; // of Co-Simulation; 0: Model Exchange
    char identifier[max_text] = "", token[max_text] = "", binary[max_path] = "";
    PlantSizes sizes;
    int set_count = 0;
};

// In one block: as long as there are states, sensors and so on; start to max of all that is estimated.
struct PlanRows {
    std::uint32_t *state, *derivative, *input, *parameter, *sensor, *set;
    double *set_value, *start, *start_sigma, *noise, *nominal, *ready_sigma, *min, *max;
    double *time_constant_s, *input_start, *sensor_sigma, *gate_nis;
    std::uint8_t *input_is_discrete, *sensor_is_output, *logarithmic;
    std::uint8_t *declared, *dependent; // states with lines of dependencies; states x what moves
};

struct Plan : PlanHead, PlanRows {
    Plan() : PlanHead(), PlanRows() {}
    ~Plan();
    Plan(const Plan&) = delete;
    Plan& operator=(const Plan&) = delete;
    // False: no memory.
    bool copy(const Plan& from);

    Statistics statistics() const {
        return {sizeof(Statistics), start,        start_sigma, noise, nominal, ready_sigma, time_constant_s,
                input_start,        sensor_sigma, gate_nis,    min,   max,     logarithmic};
    }

    bool depends(int row, int on) const { return !declared[row] || dependent[row * (sizes.states + sizes.unknown_inputs) + on]; }

    // From folder/observer.plan. False: why says in which line.
    bool read(const char* folder, Refusal& why);

private:
    bool make_rows(std::FILE* file, Refusal& why);
    bool read_lines(std::FILE* file, Refusal& why);
    bool take_rows(); // as many as sizes and set_count have it
    std::size_t place_rows(void* block);

    void* block_ = nullptr;
    std::size_t bytes_ = 0;
};

} // namespace hnav::observer
