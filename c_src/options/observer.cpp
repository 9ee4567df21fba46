// Made by c_src/options/generate.py from observer.toml: change that, then ./run generate.
#include "options/lists.hpp"

#include "hnav/options/observer.h"

#include <cmath>
#include <cstddef>

// clang-format off
namespace hnav {
namespace {

const char* const observer_start_names[] = {text("first_sample"), text("given")};
const char* const observer_start_meanings[] = {
    text("at the first sample, of an input or a sensor"), text("at start_time_s; samples before it are not used"),
};
const char* const observer_propagation_names[] = {text("derivatives"), text("sigma_points")};
const char* const observer_propagation_meanings[] = {
    text("by the derivatives of the plant"), text("by 2N points that are taken along, for plants without events"),
};

// Of all rows, one after the other.
constexpr double defaults[] = {
    0, 0, 0, 64, 10, 1, 0, 1e-07, 0.0001, 20000, 0,
};

const OptionRow rows[] = {
    {"start_mode", text("start"), text(""), text("Time of the start state: the first sample, or start_time_s"),
    text("Recordings begin at any time; the state of the plant before is unknown."),
    observer_start_names, observer_start_meanings, defaults + 0, offsetof(hnav_observer_options, start_mode), 0, 1, 1, 2,
    HNAV_OPTION_CHOICE, 0, 0, 0},
    {"start_time_s", text("start"), text("s"),
    text("Time of the start state in mode given; in the other mode the time at which the plant is first evaluated"),
    text("Where simulations begin."), nullptr, nullptr, defaults + 1, offsetof(hnav_observer_options, start_time_s), -1e+12,
    1e+12, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"horizon_s", text("timing"), text("s"), text("Largest age of a late sample relative to the newest one"),
    text("Samples are in order; a horizon costs memory and the replay of all events within it."), nullptr, nullptr, defaults + 2,
    offsetof(hnav_observer_options, horizon_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"queue_capacity", text("timing"), text(""), text("Number of events that can wait or be within the horizon"),
    text("Enough for an advance after every few dozen samples, and little memory."), nullptr, nullptr, defaults + 3,
    offsetof(hnav_observer_options, queue_capacity), 4, 1e+06, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"outlier_sigma", text("fault"), text(""),
    text("A sample is an outlier if it differs from the previous one and from the prediction by more sigmas than this, unless the next one agrees with it; 0 = no test"),
    text("Far beyond noise and an early bounce; transmission errors are larger."), nullptr, nullptr, defaults + 4,
    offsetof(hnav_observer_options, outlier_sigma), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"time_jump_limit_s", text("fault"), text("s"),
    text("Time stamps that run back further start a new time base; a single stamp ten times as far ahead is rejected; 0 = never"),
    text("Longer than usual latencies, shorter than usual clock corrections."), nullptr, nullptr, defaults + 5,
    offsetof(hnav_observer_options, time_jump_limit_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"propagation", text("solver"), text(""),
    text("Propagation of the covariance: by derivatives, or by sigma points if the plant has none, as with tables and relays; sigma points require a plant without events"),
    text("Derivatives are faster, and accurate if the plant is smooth over a sigma."),
    observer_propagation_names, observer_propagation_meanings, defaults + 6, offsetof(hnav_observer_options, propagation), 0, 1,
    1, 2, HNAV_OPTION_CHOICE, 0, 0, 1},
    {"rtol", text("solver"), text(""),
    text("Relative tolerance of the states; the absolute one is this times the scale of a state"),
    text("Far below sensor noise, and for most plants an interval is still one step."), nullptr, nullptr, defaults + 7,
    offsetof(hnav_observer_options, rtol), 1e-12, 0.01, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"covariance_rtol", text("solver"), text(""), text("Relative tolerance of the transition matrix and of the process noise"),
    text("Four digits of a sigma are sufficient; the tolerance of the states would double the evaluations of the plant."),
    nullptr, nullptr, defaults + 8, offsetof(hnav_observer_options, covariance_rtol), 1e-12, 0.1, 1, 0, HNAV_OPTION_REAL, 0, 0,
    1},
    {"max_steps", text("solver"), text(""),
    text("Largest number of solver steps in one interval; beyond it the sample is dropped"),
    text("A second of computing; a plant that needs more is stiff."), nullptr, nullptr, defaults + 9,
    offsetof(hnav_observer_options, max_steps), 10, 1e+08, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"robust_rate_1_s", text("robust"), text("1/s"),
    text("Fading memory: before a correction, T after the last, the largest variance in units of the scales grows by exp(rate T), others by less. 0: off"),
    text("Known process noise is preferable."), nullptr, nullptr, defaults + 10, offsetof(hnav_observer_options, robust_rate_1_s),
    0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
};

constexpr Preset presets[] = {
    {{"default", text("The defaults."), 0}, nullptr, 0},
};

} // namespace

const OptionList observer_options = {
    "hnav_observer_defaults", 8, sizeof(hnav_observer_options), rows, 11, presets, 1};

} // namespace hnav
