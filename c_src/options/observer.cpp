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
    text("at the first sample, of an input or a sensor"),
    text("at start_time_s; samples before it are not used"),
};
const char* const observer_propagation_names[] = {text("derivatives"), text("sigma_points")};
const char* const observer_propagation_meanings[] = {
    text("by the derivatives of the plant"),
    text("by 2N points that are taken along, for plants without events"),
};

constexpr double defaults[] = {
    0, // start_mode
    0, // start_time_s
    0, // horizon_s
    64, // queue_capacity
    10, // outlier_sigma
    1, // time_jump_limit_s
    0, // propagation
    1e-07, // rtol
    0.0001, // covariance_rtol
    20000, // max_steps
    0, // robust_rate_1_s
};

const OptionRow rows[] = {
    {"start_mode", text("start"), text(""),
     text("When the plant is in its start state: at the first sample, or at start_time_s"),
     text("Recordings begin at any time; whatever the plant did before is not known."),
     observer_start_names, observer_start_meanings, defaults + 0, offsetof(hnav_observer_options, start_mode),
     0, 1, 1, 2, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"start_time_s", text("start"), text("s"),
     text("Time of the start state in mode given; in the other mode the time at which the plant is asked for its first answers"),
     text("Where simulations begin."),
     nullptr, nullptr, defaults + 1, offsetof(hnav_observer_options, start_time_s),
     -1e+12, 1e+12, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"horizon_s", text("timing"), text("s"),
     text("How much older than the newest used sample a sample may be"),
     text("Samples come in order; a horizon costs memory and the replay of all that lies within it."),
     nullptr, nullptr, defaults + 2, offsetof(hnav_observer_options, horizon_s),
     0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"queue_capacity", text("timing"), text(""),
     text("Instants that may wait or lie within the horizon"),
     text("Enough for an advance after every few dozen samples, and little memory."),
     nullptr, nullptr, defaults + 3, offsetof(hnav_observer_options, queue_capacity),
     4, 1e+06, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"outlier_sigma", text("fault"), text(""),
     text("A sample is an outlier if it differs from the one before and from what is expected by more sigmas than this, unless the next one agrees with it; 0 = none is looked for"),
     text("Far beyond what noise or a bounce that comes early does; an error of a transmission is larger."),
     nullptr, nullptr, defaults + 4, offsetof(hnav_observer_options, outlier_sigma),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"time_jump_limit_s", text("fault"), text("s"),
     text("A sensor whose stamps run back further begins a new time base, a single stamp ten times as far ahead is left out; 0 = never"),
     text("Longer than samples are late, shorter than a clock is ever set."),
     nullptr, nullptr, defaults + 5, offsetof(hnav_observer_options, time_jump_limit_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"propagation", text("solver"), text(""),
     text("How the covariance goes from sample to sample: by derivatives, or by sigma points where the plant has none, as with tables and relays; these are for plants without events"),
     text("Derivatives are faster, and right where the plant is smooth over a sigma."),
     observer_propagation_names, observer_propagation_meanings, defaults + 6, offsetof(hnav_observer_options, propagation),
     0, 1, 1, 2, HNAV_OPTION_CHOICE, 0, 0, 1},
    {"rtol", text("solver"), text(""),
     text("Relative tolerance of the states; the absolute one is this times the scale of a state"),
     text("Far below what sensors measure, and an interval is still one step of most plants."),
     nullptr, nullptr, defaults + 7, offsetof(hnav_observer_options, rtol),
     1e-12, 0.01, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"covariance_rtol", text("solver"), text(""),
     text("The same of the transition matrix and of the noise that enters"),
     text("A sigma is wanted to four digits; with one tolerance for all the plant would be asked twice as often."),
     nullptr, nullptr, defaults + 8, offsetof(hnav_observer_options, covariance_rtol),
     1e-12, 0.1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"max_steps", text("solver"), text(""),
     text("Steps of the solver in one interval, beyond which its sample is dropped"),
     text("A second of computing; a plant that needs more is stiff."),
     nullptr, nullptr, defaults + 9, offsetof(hnav_observer_options, max_steps),
     10, 1e+08, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"robust_rate_1_s", text("robust"), text("1/s"),
     text("The largest variance, in units of the scales, grows by the factor exp(rate T) before a correction that comes T after the last, others by less: what is long past is forgotten. 0: off"),
     text("Noise that is known is better than what is forgotten without a reason."),
     nullptr, nullptr, defaults + 10, offsetof(hnav_observer_options, robust_rate_1_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
};

constexpr Preset presets[] = {
    {{"default", text("The defaults."), 0}, nullptr, 0},
};

} // namespace

const OptionList observer_options = {
    "hnav_observer_defaults", 8, sizeof(hnav_observer_options), rows, 11, presets, 1};

} // namespace hnav
