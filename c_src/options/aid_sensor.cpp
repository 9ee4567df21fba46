// Made by c_src/options/generate.py from aid_sensor.toml: change that, then ./run generate.
#include "options/lists.hpp"

#include "hnav/options/aid_sensor.h"

#include <cmath>
#include <cstddef>

// clang-format off
namespace hnav {
namespace {

// Of all rows, one after the other.
constexpr double defaults[] = {
    0.2, 0, 0, 0, 0.5, 0.5, 0.1, 0.1, 1.5, 1.5, 60, 0, 0, 0, 0, 20, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0, 0, 5, 500, 20, 1000, 0.1,
    0, 0, 0.05, 0.01, 0, 0, 0, 0,
};

const OptionRow rows[] = {
    {"gnss.period_s", text("gnss"), text("s"), text("Sampling period"),
    text("Five fixes a second, as usual receivers give them."), nullptr, nullptr, defaults + 0,
    offsetof(hnav_aid_sensor_options, gnss.period_s), 1e-06, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gnss.latency_s", text("gnss"), text("s"), text("A sample is delivered so long after it was taken"), text("At once."),
    nullptr, nullptr, defaults + 1, offsetof(hnav_aid_sensor_options, gnss.latency_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gnss.stamp_error_s", text("gnss"), text("s"),
    text("The stamp of a sample is this much later than the sample, unknown to its reader; latency_s counts from the stamp on"),
    text("A stamp that is right."), nullptr, nullptr, defaults + 2, offsetof(hnav_aid_sensor_options, gnss.stamp_error_s), 0, 10,
    1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gnss.dropout", text("gnss"), text(""), text("Probability that a sample is never delivered; 1: the sensor is silent"),
    text("All arrive."), nullptr, nullptr, defaults + 3, offsetof(hnav_aid_sensor_options, gnss.dropout), 0, 1, 1, 0,
    HNAV_OPTION_REAL, 0, 0, 1},
    {"gnss.noise_m", text("gnss"), text("m"),
    text("White noise of the position, horizontal and vertical; the sigma that the sensor states"),
    text("From fix to fix, of a usual receiver under an open sky."), nullptr, nullptr, defaults + 4,
    offsetof(hnav_aid_sensor_options, gnss.noise_m), 0, 1e+06, 2, 0, HNAV_OPTION_REAL, 1, 0, 0},
    {"gnss.noise_m_s", text("gnss"), text("m/s"),
    text("White noise of the velocity, horizontal and vertical; the sigma that the sensor states"),
    text("Of a usual receiver under an open sky."), nullptr, nullptr, defaults + 6,
    offsetof(hnav_aid_sensor_options, gnss.noise_m_s), 0, 1e+06, 2, 0, HNAV_OPTION_REAL, 1, 0, 0},
    {"gnss.colour_m", text("gnss"), text("m"),
    text("Slow error of the position, horizontal and vertical, which the sensor does not state: Gauss-Markov"),
    text("Of a usual receiver under an open sky."), nullptr, nullptr, defaults + 8,
    offsetof(hnav_aid_sensor_options, gnss.colour_m), 0, 1e+06, 2, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gnss.colour_s", text("gnss"), text("s"), text("Correlation time of the slow error"), text("Minutes."), nullptr, nullptr,
    defaults + 10, offsetof(hnav_aid_sensor_options, gnss.colour_s), 0.001, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gnss.antenna_b_m", text("gnss"), text("m"), text("Place of the antenna from the inertial sensor, in body axes"),
    text("At the sensor."), nullptr, nullptr, defaults + 11, offsetof(hnav_aid_sensor_options, gnss.antenna_b_m), -1000, 1000, 3,
    0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gnss.outlier_probability", text("gnss"), text(""), text("Probability that a fix lies far off"), text("An open sky."),
    nullptr, nullptr, defaults + 14, offsetof(hnav_aid_sensor_options, gnss.outlier_probability), 0, 1, 1, 0, HNAV_OPTION_REAL, 0,
    0, 1},
    {"gnss.outlier_m", text("gnss"), text("m"), text("Standard deviation of how far, for the position"),
    text("A reflected signal."), nullptr, nullptr, defaults + 15, offsetof(hnav_aid_sensor_options, gnss.outlier_m), 0, 1e+06, 1,
    0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gnss.outlier_m_s", text("gnss"), text("m/s"), text("Standard deviation of how far, for the velocity"),
    text("A reflected signal."), nullptr, nullptr, defaults + 16, offsetof(hnav_aid_sensor_options, gnss.outlier_m_s), 0, 1e+06,
    1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gnss.outage_start_s", text("gnss"), text("s"), text("No fixes from this time on"),
    text("Does not matter while outage_length_s is 0."), nullptr, nullptr, defaults + 17,
    offsetof(hnav_aid_sensor_options, gnss.outage_start_s), -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gnss.outage_length_s", text("gnss"), text("s"), text("For so long; 0: there is no outage"), text("An open sky."),
    nullptr, nullptr, defaults + 18, offsetof(hnav_aid_sensor_options, gnss.outage_length_s), 0, 1e+09, 1, 0, HNAV_OPTION_REAL, 0,
    0, 0},
    {"gnss.outage_every_s", text("gnss"), text("s"), text("And again after so long from start to start; 0: once"),
    text("A single tunnel."), nullptr, nullptr, defaults + 19, offsetof(hnav_aid_sensor_options, gnss.outage_every_s), 0, 1e+09,
    1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gnss.jump_start_s", text("gnss"), text("s"), text("Positions are off by jump_n_m from this time on"),
    text("Does not matter while jump_n_m is 0."), nullptr, nullptr, defaults + 20,
    offsetof(hnav_aid_sensor_options, gnss.jump_start_s), -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gnss.jump_stop_s", text("gnss"), text("s"), text("Up to, not including, this time"),
    text("Does not matter while jump_n_m is 0."), nullptr, nullptr, defaults + 21,
    offsetof(hnav_aid_sensor_options, gnss.jump_stop_s), -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gnss.jump_n_m", text("gnss"), text("m"), text("How far, north, east, down"),
    text("Nothing happens, even within the window."), nullptr, nullptr, defaults + 22,
    offsetof(hnav_aid_sensor_options, gnss.jump_n_m), -1e+06, 1e+06, 3, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"baro.period_s", text("baro"), text("s"), text("Sampling period"), text("Of a usual chip."), nullptr, nullptr, defaults + 25,
    offsetof(hnav_aid_sensor_options, baro.period_s), 1e-06, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"baro.latency_s", text("baro"), text("s"), text("A sample is delivered so long after it was taken"), text("At once."),
    nullptr, nullptr, defaults + 26, offsetof(hnav_aid_sensor_options, baro.latency_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0,
    0},
    {"baro.dropout", text("baro"), text(""), text("Probability that a sample is never delivered; 1: the sensor is silent"),
    text("All arrive."), nullptr, nullptr, defaults + 27, offsetof(hnav_aid_sensor_options, baro.dropout), 0, 1, 1, 0,
    HNAV_OPTION_REAL, 0, 0, 1},
    {"baro.noise_pa", text("baro"), text("Pa"), text("White noise; the sigma that the sensor states"),
    text("Of a usual chip: half a metre."), nullptr, nullptr, defaults + 28, offsetof(hnav_aid_sensor_options, baro.noise_pa), 0,
    100000, 1, 0, HNAV_OPTION_REAL, 1, 0, 0},
    {"baro.offset_sigma_pa", text("baro"), text("Pa"), text("Standard deviation of the weather at the start, drawn once"),
    text("Highs and lows of middle latitudes."), nullptr, nullptr, defaults + 29,
    offsetof(hnav_aid_sensor_options, baro.offset_sigma_pa), 0, 100000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"baro.colour_pa", text("baro"), text("Pa"), text("How the weather and the air around the body change: Gauss-Markov"),
    text("A metre and a half."), nullptr, nullptr, defaults + 30, offsetof(hnav_aid_sensor_options, baro.colour_pa), 0, 100000, 1,
    0, HNAV_OPTION_REAL, 0, 0, 1},
    {"baro.colour_s", text("baro"), text("s"), text("Correlation time of that"), text("A quarter of an hour."), nullptr, nullptr,
    defaults + 31, offsetof(hnav_aid_sensor_options, baro.colour_s), 0.001, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"wheel.period_s", text("wheel"), text("s"), text("Sampling period"), text("As on the bus of a car."), nullptr, nullptr,
    defaults + 32, offsetof(hnav_aid_sensor_options, wheel.period_s), 1e-06, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"wheel.latency_s", text("wheel"), text("s"), text("A sample is delivered so long after it was taken"), text("At once."),
    nullptr, nullptr, defaults + 33, offsetof(hnav_aid_sensor_options, wheel.latency_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0,
    0},
    {"wheel.dropout", text("wheel"), text(""), text("Probability that a sample is never delivered; 1: the sensor is silent"),
    text("All arrive."), nullptr, nullptr, defaults + 34, offsetof(hnav_aid_sensor_options, wheel.dropout), 0, 1, 1, 0,
    HNAV_OPTION_REAL, 0, 0, 1},
    {"wheel.noise_m_s", text("wheel"), text("m/s"), text("White noise; the sigma that the sensor states"),
    text("Teeth of a wheel that are counted over a period."), nullptr, nullptr, defaults + 35,
    offsetof(hnav_aid_sensor_options, wheel.noise_m_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 0},
    {"wheel.scale_factor_sigma", text("wheel"), text(""), text("Standard deviation of the scale factor, drawn once"),
    text("Tyres wear, and the air in them."), nullptr, nullptr, defaults + 36,
    offsetof(hnav_aid_sensor_options, wheel.scale_factor_sigma), 0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"wheel.wheel_b_m", text("wheel"), text("m"), text("Place of the wheels from the inertial sensor, in body axes"),
    text("At the sensor."), nullptr, nullptr, defaults + 37, offsetof(hnav_aid_sensor_options, wheel.wheel_b_m), -1000, 1000, 3,
    0, HNAV_OPTION_REAL, 0, 0, 1},
    {"seed", text("chance"), text(""), text("Seed of all that is drawn"), text("Any seed is as good as any other."),
    nullptr, nullptr, defaults + 40, offsetof(hnav_aid_sensor_options, seed), 0, 2147483647, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
};

constexpr Preset presets[] = {
    {{"default", text("The defaults."), 0}, nullptr, 0},
};

} // namespace

const OptionList aid_sensor_options = {
    "hnav_aid_sensor_defaults", 11, sizeof(hnav_aid_sensor_options), rows, 32, presets, 1};

} // namespace hnav
