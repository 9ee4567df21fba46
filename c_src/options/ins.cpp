// Made by c_src/options/generate.py from ins.toml: change that, then ./run generate.
#include "options/choices.hpp"

#include "hnav/options/ins.h"

#include <cmath>
#include <cstddef>

// clang-format off
namespace hnav {
namespace {

const char* const ins_start_names[] = {text("any_heading"), text("state")};
const char* const ins_start_meanings[] = {
    text("nothing: tilt from the first seconds, heading from motion or the rate of the Earth"),
    text("start_q_nb and start_velocity_n_m_s, with their sigmas"),
};
const char* const ins_place_names[] = {text("fix"), text("given")};
const char* const ins_place_meanings[] = {
    text("the first fix of the satellites"),
    text("start_latitude_rad and the like: where no satellite is, as for finding north at rest"),
};

// Of all rows, one after the other.
constexpr double defaults[] = {
    0.0002, 0.003, 2e-05, 0.002, 0.001, 0.0003, 1, 0, 1.5, 1.5, 60, 5, 1000, 60, 0.05, 10, 0.2, 300, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0,
    0, 0, 0, 0.087266462599716474, 0.1, 90, 0.01, 0.003, 0.005, 0.3, 30, 0.2, 0.05, 1, 0.03, 5, 0.13962634015954636,
    0.017453292519943295, 0.25, 1, 0.02, 0.0002, 16.3, 15, 0, 0, 8, 100, 1, 0.017453292519943295, 0.017453292519943295, 0.5, 5, 5,
    1, 0.0997, 1, 0, 64, 0, 0, 0, 0.3, 0, 0, 0, 0, 1, 0, 0, 0, 10000, 0, 1e-08, 1e-08, 0.005,
};

const OptionRow rows[] = {
    {"gyro_noise_rad_per_sqrt_s", text("noise"), text("rad/sqrt(s)"), text("Angle random walk: white noise of the gyroscope"),
    text("Of a usual chip, 0.7 deg/sqrt(h)."), nullptr, nullptr, defaults + 0,
    offsetof(hnav_ins_options, gyro_noise_rad_per_sqrt_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gyro_rate_noise_sqrt_s", text("noise"), text("sqrt(s)"),
    text("Noise of the gyroscope that grows with the rate: density = this x |rate|"),
    text("Scale and misalignment of a third of a per cent."), nullptr, nullptr, defaults + 1,
    offsetof(hnav_ins_options, gyro_rate_noise_sqrt_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro_bias_walk_rad_s_per_sqrt_s", text("noise"), text("rad/s/sqrt(s)"), text("Random walk of the gyro bias"),
    text("Temperature moves the bias more than the walk on the datasheet."), nullptr, nullptr, defaults + 2,
    offsetof(hnav_ins_options, gyro_bias_walk_rad_s_per_sqrt_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"accel_noise_m_s_per_sqrt_s", text("noise"), text("m/s/sqrt(s)"),
    text("Velocity random walk: white noise of the accelerometer"), text("Of a usual chip, 0.2 mg/sqrt(Hz)."), nullptr, nullptr,
    defaults + 3, offsetof(hnav_ins_options, accel_noise_m_s_per_sqrt_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"accel_scale", text("noise"), text(""),
    text("Scale errors and misalignments of the accelerometer, one sigma: an error of this x the acceleration, as lasting as that"),
    text("A tenth of a per cent. Cheap chips have more: state it, with sensor.json."), nullptr, nullptr, defaults + 4,
    offsetof(hnav_ins_options, accel_scale), 0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel_bias_walk_m_s2_per_sqrt_s", text("noise"), text("m/s2/sqrt(s)"), text("Random walk of the accelerometer bias"),
    text("As for the gyroscope."), nullptr, nullptr, defaults + 5, offsetof(hnav_ins_options, accel_bias_walk_m_s2_per_sqrt_s), 0,
    1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"vibration_share", text("noise"), text(""),
    text("Share of the power between neighbouring samples of rate and force that is used as their noise if it exceeds the stated noise; 0 = none"),
    text("Vibration of a vehicle is far above the sensor noise, and from sample to sample it looks like white noise."),
    nullptr, nullptr, defaults + 6, offsetof(hnav_ins_options, vibration_share), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"body", text("aiding"), text(""),
    text("Kind of body: car sets car_across_m_s if it is 0; the others set nothing, because no option improves their start"),
    text("The kind of body is unknown."), body_names, body_meanings, defaults + 7, offsetof(hnav_ins_options, body), 0, 6, 1, 7,
    HNAV_OPTION_CHOICE, 0, 0, 0},
    {"position_colour_m", text("aiding"), text("m"),
    text("Slowly varying error of the GNSS position, horizontal and vertical, one sigma; if the stated sigma of a fix is larger, or below a tenth, the stated one is used; 0: none"),
    text("Usual for a single receiver, vertically more; carrier phase and cameras state centimetres."), nullptr, nullptr,
    defaults + 8, offsetof(hnav_ins_options, position_colour_m), 0, 10000, 2, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"position_colour_s", text("aiding"), text("s"), text("Time for which that error stays as it is"),
    text("Usual for ionosphere and multipath of a moving body."), nullptr, nullptr, defaults + 10,
    offsetof(hnav_ins_options, position_colour_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"pressure_colour_m", text("aiding"), text("m"), text("Slowly varying error of the barometric height, one sigma"),
    text("Weather and the wind around the body."), nullptr, nullptr, defaults + 11, offsetof(hnav_ins_options, pressure_colour_m),
    0, 10000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"pressure_colour_s", text("aiding"), text("s"), text("Time for which that error stays as it is"),
    text("Weather changes within a quarter of an hour."), nullptr, nullptr, defaults + 12,
    offsetof(hnav_ins_options, pressure_colour_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"heading_colour_s", text("aiding"), text("s"),
    text("Correlation time of the error of external headings: samples within it have the weight of one; 0 = independent errors"),
    text("Iron near a compass is constant; two antennas have small errors that last for seconds."), nullptr, nullptr,
    defaults + 13, offsetof(hnav_ins_options, heading_colour_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"field_noise", text("aiding"), text(""),
    text("Noise of the horizontal field relative to its strength: magnetometer, soft iron, iron beside the road"),
    text("Three degrees: soft iron of an uncalibrated device."), nullptr, nullptr, defaults + 14,
    offsetof(hnav_ins_options, field_noise), 0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"field_colour_s", text("aiding"), text("s"),
    text("Correlation time of that noise: samples within it have the weight of one"),
    text("The time that a vehicle needs to pass an object."), nullptr, nullptr, defaults + 15,
    offsetof(hnav_ins_options, field_colour_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"field_direction_rad", text("aiding"), text("rad"), text("Deviation of the local field from the declination, one sigma"),
    text("An unknown declination, steel in buildings and streets; 0.05 with declination_rad in the open."), nullptr, nullptr,
    defaults + 16, offsetof(hnav_ins_options, field_direction_rad), 0, 4, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"field_direction_s", text("aiding"), text("s"), text("Correlation time of that deviation"),
    text("The time that a vehicle stays near a place."), nullptr, nullptr, defaults + 17,
    offsetof(hnav_ins_options, field_direction_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"car_across_m_s", text("aiding"), text("m/s"),
    text("A car: noise of its velocity sideways and upwards, used when the heading is found; 0 = that of the body: 0.1 for a car, none for others"),
    text("The kind of body is unknown; body = car sets it."), nullptr, nullptr, defaults + 18,
    offsetof(hnav_ins_options, car_across_m_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"start", text("start"), text(""), text("any_heading: attitude and velocity are unknown; state: they are given"),
    text("It needs nothing but the samples."), ins_start_names, ins_start_meanings, defaults + 19,
    offsetof(hnav_ins_options, start), 0, 1, 1, 2, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"start_place", text("start"), text(""), text("Source of the first position: fix, or given"),
    text("It needs nothing but the samples."), ins_place_names, ins_place_meanings, defaults + 20,
    offsetof(hnav_ins_options, start_place), 0, 1, 1, 2, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"start_latitude_rad", text("start"), text("rad"), text("Start latitude, if given"), text("Only start_place given reads it."),
    nullptr, nullptr, defaults + 21, offsetof(hnav_ins_options, start_latitude_rad), -1.5707963267948966, 1.5707963267948966, 1,
    0, HNAV_OPTION_REAL, 0, 0, 0},
    {"start_longitude_rad", text("start"), text("rad"), text("Start longitude, if given"),
    text("Only start_place given reads it."), nullptr, nullptr, defaults + 22, offsetof(hnav_ins_options, start_longitude_rad),
    -6.2831853071795862, 6.2831853071795862, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"start_height_m", text("start"), text("m"), text("Start height above the ellipsoid, if given"),
    text("Only start_place given reads it."), nullptr, nullptr, defaults + 23, offsetof(hnav_ins_options, start_height_m), -10000,
    100000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_q_nb", text("start"), text(""), text("Start attitude, body to north-east-down, scalar first; normalised on use"),
    text("Level and to the north; only start state reads it."), nullptr, nullptr, defaults + 24,
    offsetof(hnav_ins_options, start_q_nb), -2, 2, 4, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_velocity_n_m_s", text("start"), text("m/s"), text("Start velocity, north, east, down"),
    text("At rest; only start state reads it."), nullptr, nullptr, defaults + 28,
    offsetof(hnav_ins_options, start_velocity_n_m_s), -10000, 10000, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_sigma_heading_rad", text("start"), text("rad"), text("Standard deviation of the heading at the start"),
    text("Of a compass; only start state reads it."), nullptr, nullptr, defaults + 31,
    offsetof(hnav_ins_options, start_sigma_heading_rad), 0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_tilt_rad", text("start"), text("rad"), text("Standard deviation of the tilt at the start"),
    text("Of the tilt from a window of velocities, without the effect of biases; 0.5 deg/s of bias turns the window itself."),
    nullptr, nullptr, defaults + 32, offsetof(hnav_ins_options, start_sigma_tilt_rad), 0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_velocity_m_s", text("start"), text("m/s"),
    text("Standard deviation of the horizontal velocity at the start; a fifth of it vertical"),
    text("An aircraft, in any direction."), nullptr, nullptr, defaults + 33, offsetof(hnav_ins_options, start_sigma_velocity_m_s),
    0, 10000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_gyro_bias_rad_s", text("start"), text("rad/s"), text("Standard deviation of the gyro bias at the start"),
    text("Half a degree per second."), nullptr, nullptr, defaults + 34, offsetof(hnav_ins_options, start_sigma_gyro_bias_rad_s),
    0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 0},
    {"start_sigma_gyro_scale", text("start"), text(""),
    text("Standard deviation of the scale of each gyroscope; 0 = it is not estimated"),
    text("What a factory calibration of a usual chip leaves."), nullptr, nullptr, defaults + 35,
    offsetof(hnav_ins_options, start_sigma_gyro_scale), 0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"start_sigma_gyro_misalignment_rad", text("start"), text("rad"),
    text("Standard deviation of the misalignment of each gyroscope towards another axis; 0 = it is not estimated"),
    text("0.3 deg, of a usual chip: with 0.1 deg the ready headings of the recorded flight have a z2 of 3.5 instead of 1.2."),
    nullptr, nullptr, defaults + 36, offsetof(hnav_ins_options, start_sigma_gyro_misalignment_rad), 0, 1, 1, 0, HNAV_OPTION_REAL,
    0, 0, 1},
    {"start_sigma_accel_bias_m_s2", text("start"), text("m/s2"),
    text("Standard deviation of the accelerometer bias at the start"), text("Thirty mg, its mounting in the vehicle included."),
    nullptr, nullptr, defaults + 37, offsetof(hnav_ins_options, start_sigma_accel_bias_m_s2), 0, 1000, 1, 0, HNAV_OPTION_REAL, 1,
    0, 1},
    {"start_sigma_position_m", text("start"), text("m"),
    text("Standard deviation of the first fix, in addition to its stated sigma"),
    text("The error of a receiver that has just started; a wider prior costs a few fixes."), nullptr, nullptr, defaults + 38,
    offsetof(hnav_ins_options, start_sigma_position_m), 0, 1e+07, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_latency_s", text("start"), text("s"),
    text("Standard deviation of the GNSS latency relative to the time stamps"),
    text("Fixes that are stamped when they arrive are 0.05 s to 0.5 s late."), nullptr, nullptr, defaults + 39,
    offsetof(hnav_ins_options, start_sigma_latency_s), 0, 10, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"start_sigma_speed_scale", text("start"), text(""), text("Standard deviation of the scale error of the wheel speed"),
    text("Worn tyres."), nullptr, nullptr, defaults + 40, offsetof(hnav_ins_options, start_sigma_speed_scale), 0, 1, 1, 0,
    HNAV_OPTION_REAL, 0, 0, 1},
    {"start_sigma_iron", text("start"), text(""),
    text("Standard deviation of the hard iron of the body, relative to the horizontal field of the Earth; each axis"),
    text("Of an uncalibrated phone or car; with 0.05, after a calibration, the heading is found at once."), nullptr, nullptr,
    defaults + 41, offsetof(hnav_ins_options, start_sigma_iron), 0, 100, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"start_sigma_mounting_rad", text("start"), text("rad"),
    text("Standard deviation of yaw and pitch of the axis of travel in the body"), text("A sensor aligned by eye."),
    nullptr, nullptr, defaults + 42, offsetof(hnav_ins_options, start_sigma_mounting_rad), 0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"level_window_s", text("start"), text("s"), text("Time of the window by which the first tilt is found"),
    text("Long enough to average GNSS noise, short enough for the gyro drift; 10 for ships and vibrating aircraft."),
    nullptr, nullptr, defaults + 43, offsetof(hnav_ins_options, level_window_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"heading_found_rad", text("start"), text("rad"),
    text("Spread of the heading over the whole circle at which the heading is found"),
    text("The probability of all other headings is then below 0.002. With 4 deg the heading of consumer ships has z2 3.9 instead of 2.1."),
    nullptr, nullptr, defaults + 44, offsetof(hnav_ins_options, heading_found_rad), 0, 0.3, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"rest_rate_rad_s", text("rest"), text("rad/s"),
    text("Rest: root mean square of the rate about its running mean; 0 = rest is never found"),
    text("Above the noise of usual gyroscopes, below any motion."), nullptr, nullptr, defaults + 45,
    offsetof(hnav_ins_options, rest_rate_rad_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"rest_force_m_s2", text("rest"), text("m/s2"), text("Rest: root mean square of the force about its running mean"),
    text("Above the noise of usual accelerometers and an idling engine, below any motion."), nullptr, nullptr, defaults + 46,
    offsetof(hnav_ins_options, rest_force_m_s2), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"rest_duration_s", text("rest"), text("s"), text("Rest: time within both limits, with a small speed"),
    text("A vehicle swings for a second after it stops."), nullptr, nullptr, defaults + 47,
    offsetof(hnav_ins_options, rest_duration_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"rest_velocity_noise_m_s", text("rest"), text("m/s"), text("Velocity of a body at rest, one sigma, per correction (10 Hz)"),
    text("A vehicle sways on its wheels."), nullptr, nullptr, defaults + 48, offsetof(hnav_ins_options, rest_velocity_noise_m_s),
    0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"rest_rate_noise_rad_per_sqrt_s", text("rest"), text("rad/sqrt(s)"),
    text("Noise of the rate about the vertical of a body at rest, in addition to that of the gyroscope"),
    text("As of a usual gyroscope."), nullptr, nullptr, defaults + 49, offsetof(hnav_ins_options, rest_rate_noise_rad_per_sqrt_s),
    0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gate_nis", text("gate"), text(""),
    text("NIS of three values beyond which their noise is inflated, less for fewer values; 0 = never"),
    text("99.9 % of chi square with 3 degrees of freedom."), nullptr, nullptr, defaults + 50,
    offsetof(hnav_ins_options, gate_nis), 0, 1e+12, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gate_longest_s", text("gate"), text("s"),
    text("Positions or velocities that stay beyond the gate for longer are accepted, as a new GNSS error or a new velocity"),
    text("Longer than most reflections last, short enough to recover."), nullptr, nullptr, defaults + 51,
    offsetof(hnav_ins_options, gate_longest_s), 0, 1e+09, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"gyro_range_rad_s", text("fault"), text("rad/s"),
    text("Rate at which an axis of the gyroscope saturates; 0 = detected from repeated values"),
    text("A saturated sensor repeats its limit, unless a low-pass filter follows."), nullptr, nullptr, defaults + 52,
    offsetof(hnav_ins_options, gyro_range_rad_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"accel_range_m_s2", text("fault"), text("m/s2"),
    text("Specific force at which an axis of the accelerometer saturates; 0 = detected from repeated values"),
    text("As for the gyroscope."), nullptr, nullptr, defaults + 53, offsetof(hnav_ins_options, accel_range_m_s2), 0, 1e+06, 1, 0,
    HNAV_OPTION_REAL, 0, 0, 1},
    {"outlier_rate_rad_s", text("fault"), text("rad/s"),
    text("A single rate sample that differs from the last by more than this, and by more than ten usual changes, is rejected; 0 = never"),
    text("No recorded movement changes the rate so much from one sample to the next; half of it turns by two degrees at 100 Hz."),
    nullptr, nullptr, defaults + 54, offsetof(hnav_ins_options, outlier_rate_rad_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"outlier_force_m_s2", text("fault"), text("m/s2"),
    text("A single force sample that differs from the last by more than this, and by more than ten usual changes, is rejected; 0 = never"),
    text("Taps on a table change it by so much; a smaller value would reject real motion."), nullptr, nullptr, defaults + 55,
    offsetof(hnav_ins_options, outlier_force_m_s2), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"time_jump_limit_s", text("fault"), text("s"),
    text("Time stamps that run back further start a new time base; a single stamp ten times as far ahead is rejected; 0 = never"),
    text("Longer than usual latencies, shorter than usual clock corrections."), nullptr, nullptr, defaults + 56,
    offsetof(hnav_ins_options, time_jump_limit_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"ready_tilt_rad", text("ready"), text("rad"),
    text("Tilt is ready when its sigma is below this and the samples have provided the information for it"),
    text("As the heading."), nullptr, nullptr, defaults + 57, offsetof(hnav_ins_options, ready_tilt_rad), 0, 10, 1, 0,
    HNAV_OPTION_REAL, 1, 0, 1},
    {"ready_heading_rad", text("ready"), text("rad"),
    text("Heading is ready when its sigma is below this and the samples have provided the information for it"),
    text("In simulated starts of aircraft 1 of 100 ready headings was wrong at a limit of 2 deg, none at 1 deg."),
    nullptr, nullptr, defaults + 58, offsetof(hnav_ins_options, ready_heading_rad), 0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 0},
    {"ready_velocity_m_s", text("ready"), text("m/s"),
    text("Velocity is ready when its sigma is below this and the samples have provided the information for it"),
    text("Usual for satellites."), nullptr, nullptr, defaults + 59, offsetof(hnav_ins_options, ready_velocity_m_s), 0, 10000, 1,
    0, HNAV_OPTION_REAL, 1, 0, 1},
    {"ready_position_m", text("ready"), text("m"),
    text("Position is ready when its horizontal sigma is below this and the samples have provided the information for it"),
    text("Usual for satellites."), nullptr, nullptr, defaults + 60, offsetof(hnav_ins_options, ready_position_m), 0, 1e+07, 1, 0,
    HNAV_OPTION_REAL, 1, 0, 1},
    {"ready_hold_s", text("ready"), text("s"), text("Time for which the sigma of the heading has to stay below its limit"),
    text("Wrong headings are most frequent right after the limit is reached."), nullptr, nullptr, defaults + 61,
    offsetof(hnav_ins_options, ready_hold_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro_hold", text("timing"), text(""),
    text("forward: rate and force hold until the next sample; backward: since the previous sample, with coning and sculling; instant: they were read at their time"),
    text("Integrating sensors and averaging FIFOs return the mean over the interval before a sample."),
    gyro_hold_names, gyro_hold_meanings, defaults + 62, offsetof(hnav_ins_options, gyro_hold), 0, 2, 1, 3, HNAV_OPTION_CHOICE, 0,
    0, 0},
    {"correction_interval_s", text("timing"), text("s"),
    text("Largest interval between updates of the covariance; it is also updated at every aid"),
    text("Short for turns of vehicles, long for samples. For no usual rate from 25 to 1000 Hz are two samples equally near."),
    nullptr, nullptr, defaults + 63, offsetof(hnav_ins_options, correction_interval_s), 0, 10, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"longest_gap_s", text("timing"), text("s"), text("After a longer gap without rate and force the filter starts again"),
    text("A vehicle turns by tens of degrees in a second."), nullptr, nullptr, defaults + 64,
    offsetof(hnav_ins_options, longest_gap_s), 0, 1e+06, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
    {"horizon_s", text("timing"), text("s"), text("Largest age of a late sample relative to the newest one"),
    text("Samples are in order; a horizon costs memory and the replay of all events within it."), nullptr, nullptr, defaults + 65,
    offsetof(hnav_ins_options, horizon_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"queue_capacity", text("timing"), text(""), text("Number of events that can wait or be within the horizon"),
    text("Enough for an advance after every few dozen samples, and little memory."), nullptr, nullptr, defaults + 66,
    offsetof(hnav_ins_options, queue_capacity), 4, 1e+06, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"antenna_b_m", text("frame"), text("m"), text("Position of the GNSS antenna relative to the inertial sensor, body axes"),
    text("At the sensor."), nullptr, nullptr, defaults + 67, offsetof(hnav_ins_options, antenna_b_m), -1000, 1000, 3, 0,
    HNAV_OPTION_REAL, 0, 0, 0},
    {"start_sigma_antenna_m", text("frame"), text("m"), text("Sigma of antenna_b_m, each axis; 0: it is exact"),
    text("An antenna that was not measured; several times as far away it is estimated as well."), nullptr, nullptr, defaults + 70,
    offsetof(hnav_ins_options, start_sigma_antenna_m), 0, 1000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"wheel_b_m", text("frame"), text("m"),
    text("Place of the speed measurement relative to the inertial sensor, body axes: the middle of a car's rear axle; 0: unknown within 1 m"),
    text("At the sensor, not measured."), nullptr, nullptr, defaults + 71, offsetof(hnav_ins_options, wheel_b_m), -1000, 1000, 3,
    0, HNAV_OPTION_REAL, 0, 0, 1},
    {"declination_rad", text("frame"), text("rad"), text("Magnetic declination: of external headings, and of the magnetometer"),
    text("Without it headings are true headings."), nullptr, nullptr, defaults + 74, offsetof(hnav_ins_options, declination_rad),
    -3.1415926535897931, 3.1415926535897931, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"q_body_sensor", text("frame"), text(""),
    text("Mounting: rotates sensor vectors into body axes, scalar first; normalised on use"), text("Body axes are the sensor's."),
    nullptr, nullptr, defaults + 75, offsetof(hnav_ins_options, q_body_sensor), -2, 2, 4, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"anchor_distance_m", text("frame"), text("m"),
    text("Distance of the body from the origin of the filter's axes beyond which the origin moves to the body"),
    text("Small displacements keep their precision."), nullptr, nullptr, defaults + 79,
    offsetof(hnav_ins_options, anchor_distance_m), 100, 100000, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"solver", text("solver"), text(""),
    text("Integrator between events: SUNDIALS ERKStep, SUNDIALS CVODE Adams, closed form, or forward Euler"),
    text("A one-step method: every interval is integrated alike, to solver_rtol."), solver_names, solver_meanings, defaults + 80,
    offsetof(hnav_ins_options, solver), 0, 3, 1, 4, HNAV_OPTION_CHOICE, 0, 0, 0},
    {"solver_rtol", text("solver"), text(""), text("Relative tolerance of ERKStep and Adams"),
    text("The integrator's error stays far below that of any sensor."), nullptr, nullptr, defaults + 81,
    offsetof(hnav_ins_options, solver_rtol), 1e-14, 0.01, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"solver_atol", text("solver"), text(""),
    text("Absolute tolerance of ERKStep and Adams, relative to the nominal size of each state"),
    text("As solver_rtol, relative to the size of each state."), nullptr, nullptr, defaults + 82,
    offsetof(hnav_ins_options, solver_atol), 1e-20, 0.01, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"euler_step_s", text("solver"), text("s"), text("Sub-step of Euler"),
    text("Steps for comparison; the other integrators need none."), nullptr, nullptr, defaults + 83,
    offsetof(hnav_ins_options, euler_step_s), 0, 1000, 1, 0, HNAV_OPTION_REAL, 1, 0, 1},
};

// Row, component, value.
constexpr PresetValue industrial_values[] = {
    {0, 0, 5e-05}, // gyro_noise_rad_per_sqrt_s
    {1, 0, 0.0001}, // gyro_rate_noise_sqrt_s
    {30, 0, 0.0005}, // start_sigma_gyro_misalignment_rad
    {4, 0, 0.0003}, // accel_scale
    {2, 0, 2e-06}, // gyro_bias_walk_rad_s_per_sqrt_s
    {3, 0, 0.0006}, // accel_noise_m_s_per_sqrt_s
    {5, 0, 3e-05}, // accel_bias_walk_m_s2_per_sqrt_s
    {28, 0, 0.001}, // start_sigma_gyro_bias_rad_s
    {26, 0, 0.03}, // start_sigma_tilt_rad
    {29, 0, 0.0003}, // start_sigma_gyro_scale
    {31, 0, 0.03}, // start_sigma_accel_bias_m_s2
};

// Row, component, value.
constexpr PresetValue tactical_values[] = {
    {0, 0, 3e-05}, // gyro_noise_rad_per_sqrt_s
    {1, 0, 0.0001}, // gyro_rate_noise_sqrt_s
    {30, 0, 0.0003}, // start_sigma_gyro_misalignment_rad
    {4, 0, 0.0001}, // accel_scale
    {2, 0, 1e-07}, // gyro_bias_walk_rad_s_per_sqrt_s
    {6, 0, 0.1}, // vibration_share
    {3, 0, 0.0005}, // accel_noise_m_s_per_sqrt_s
    {5, 0, 5e-06}, // accel_bias_walk_m_s2_per_sqrt_s
    {28, 0, 5e-06}, // start_sigma_gyro_bias_rad_s
    {26, 0, 0.03}, // start_sigma_tilt_rad
    {29, 0, 0.0003}, // start_sigma_gyro_scale
    {31, 0, 0.01}, // start_sigma_accel_bias_m_s2
};

// Row, component, value.
constexpr PresetValue navigation_values[] = {
    {0, 0, 6e-07}, // gyro_noise_rad_per_sqrt_s
    {1, 0, 1e-05}, // gyro_rate_noise_sqrt_s
    {30, 0, 3e-06}, // start_sigma_gyro_misalignment_rad
    {4, 0, 1e-05}, // accel_scale
    {2, 0, 1e-10}, // gyro_bias_walk_rad_s_per_sqrt_s
    {3, 0, 0.0001}, // accel_noise_m_s_per_sqrt_s
    {5, 0, 1e-07}, // accel_bias_walk_m_s2_per_sqrt_s
    {28, 0, 4.8e-08}, // start_sigma_gyro_bias_rad_s
    {26, 0, 0.03}, // start_sigma_tilt_rad
    {29, 0, 1e-05}, // start_sigma_gyro_scale
    {31, 0, 0.0005}, // start_sigma_accel_bias_m_s2
    {43, 0, 1e-05}, // rest_rate_noise_rad_per_sqrt_s
    {6, 0, 0}, // vibration_share
};

constexpr Preset presets[] = {
    {{"consumer", text("MEMS of phones and hobby boards: 0.7 deg/sqrt(h), 0.5 deg/s at the start."), 0}, nullptr, 0},
    {{"industrial", text("Calibrated MEMS: 0.17 deg/sqrt(h), 200 deg/h at the start."), 1}, industrial_values, 11},
    {{"tactical", text("Fibre-optic gyroscopes or the best MEMS: 0.1 deg/sqrt(h), 1 deg/h."), 2}, tactical_values, 12},
    {{"navigation", text("Ring laser gyroscopes: 0.002 deg/sqrt(h), 0.01 deg/h; finds north at rest."), 3}, navigation_values, 13},
};

} // namespace

const OptionList ins_options = {
    "hnav_ins_defaults", 9, sizeof(hnav_ins_options), rows, 71, presets, 4};

} // namespace hnav
