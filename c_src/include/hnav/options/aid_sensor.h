/* Made by c_src/options/generate.py from aid_sensor.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_AID_SENSOR_H
#define HNAV_OPTIONS_AID_SENSOR_H

#include <stddef.h>
#include <stdint.h>

/* Receiver of satellites: position and velocity of its antenna. */
typedef struct hnav_gnss_options {
    /* Sampling period.
     * [1e-6, 1e6] s, default 0.2. Five fixes a second, as usual receivers give them. */
    double period_s;
    /* A sample is delivered so long after it was taken.
     * [0, 1e6] s, default 0. At once. */
    double latency_s;
    /* The stamp of a sample is this much later than the sample, unknown to its reader; latency_s counts from the stamp on.
     * [0, 10] s, default 0. A stamp that is right. */
    double stamp_error_s;
    /* Probability that a sample is never delivered; 1: the sensor is silent.
     * [0, 1], default 0. All arrive. */
    double dropout;
    /* White noise of the position, horizontal and vertical; the sigma that the sensor states.
     * (0, 1e6] m, default 0.5, 0.5. From fix to fix, of a usual receiver under an open sky. */
    double noise_m[2];
    /* White noise of the velocity, horizontal and vertical; the sigma that the sensor states.
     * (0, 1e6] m/s, default 0.1, 0.1. Of a usual receiver under an open sky. */
    double noise_m_s[2];
    /* Slow error of the position, horizontal and vertical, which the sensor does not state: Gauss-Markov.
     * [0, 1e6] m, default 1.5, 1.5. Of a usual receiver under an open sky. */
    double colour_m[2];
    /* Correlation time of the slow error.
     * [1e-3, 1e6] s, default 60. Minutes. */
    double colour_s;
    /* Place of the antenna from the inertial sensor, in body axes.
     * [-1e3, 1e3] m, default 0, 0, 0. At the sensor. */
    double antenna_b_m[3];
    /* Probability that a fix lies far off.
     * [0, 1], default 0. An open sky. */
    double outlier_probability;
    /* Standard deviation of how far, for the position.
     * [0, 1e6] m, default 20. A reflected signal. */
    double outlier_m;
    /* Standard deviation of how far, for the velocity.
     * [0, 1e6] m/s, default 2. A reflected signal. */
    double outlier_m_s;
    /* No fixes from this time on.
     * [-1e9, 1e9] s, default 0. Does not matter while outage_length_s is 0. */
    double outage_start_s;
    /* For so long; 0: there is no outage.
     * [0, 1e9] s, default 0. An open sky. */
    double outage_length_s;
    /* And again after so long from start to start; 0: once.
     * [0, 1e9] s, default 0. A single tunnel. */
    double outage_every_s;
    /* Positions are off by jump_n_m from this time on.
     * [-1e9, 1e9] s, default 0. Does not matter while jump_n_m is 0. */
    double jump_start_s;
    /* Up to, not including, this time.
     * [-1e9, 1e9] s, default 0. Does not matter while jump_n_m is 0. */
    double jump_stop_s;
    /* How far, north, east, down.
     * [-1e6, 1e6] m, default 0, 0, 0. Nothing happens, even within the window. */
    double jump_n_m[3];
} hnav_gnss_options;

/* Pressure of the air. */
typedef struct hnav_baro_options {
    /* Sampling period.
     * [1e-6, 1e6] s, default 0.1. Of a usual chip. */
    double period_s;
    /* A sample is delivered so long after it was taken.
     * [0, 1e6] s, default 0. At once. */
    double latency_s;
    /* Probability that a sample is never delivered; 1: the sensor is silent.
     * [0, 1], default 0. All arrive. */
    double dropout;
    /* White noise; the sigma that the sensor states.
     * (0, 1e5] Pa, default 5. Of a usual chip: half a metre. */
    double noise_pa;
    /* Standard deviation of the weather at the start, drawn once.
     * [0, 1e5] Pa, default 500. Highs and lows of middle latitudes. */
    double offset_sigma_pa;
    /* How the weather and the air around the body change: Gauss-Markov.
     * [0, 1e5] Pa, default 20. A metre and a half. */
    double colour_pa;
    /* Correlation time of that.
     * [1e-3, 1e6] s, default 1000. A quarter of an hour. */
    double colour_s;
} hnav_baro_options;

/* Speed along body x, by wheels. */
typedef struct hnav_wheel_options {
    /* Sampling period.
     * [1e-6, 1e6] s, default 0.1. As on the bus of a car. */
    double period_s;
    /* A sample is delivered so long after it was taken.
     * [0, 1e6] s, default 0. At once. */
    double latency_s;
    /* Probability that a sample is never delivered; 1: the sensor is silent.
     * [0, 1], default 0. All arrive. */
    double dropout;
    /* White noise; the sigma that the sensor states.
     * (0, 1e3] m/s, default 0.05. Teeth of a wheel that are counted over a period. */
    double noise_m_s;
    /* Standard deviation of the scale factor, drawn once.
     * [0, 1], default 0.01. Tyres wear, and the air in them. */
    double scale_factor_sigma;
    /* Place of the wheels from the inertial sensor, in body axes.
     * [-1e3, 1e3] m, default 0, 0, 0. At the sensor. */
    double wheel_b_m[3];
} hnav_wheel_options;

/* Options of simulated satellites, pressure and wheels; a sensor reads those of its own group.
 * Make them with hnav_aid_sensor_defaults, then change what you need; hnav_option("aid_sensor", i) states all this at run
 * time. */
typedef struct hnav_aid_sensor_options {
    size_t size;    /* of this struct in bytes; set by hnav_aid_sensor_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    hnav_gnss_options gnss; /* receiver of satellites: position and velocity of its antenna */

    hnav_baro_options baro; /* pressure of the air */

    hnav_wheel_options wheel; /* speed along body x, by wheels */

    /* ------------------------ chance
     * What is drawn at random. */

    /* Seed of all that is drawn.
     * [0, 2147483647], default 0. Any seed is as good as any other. */
    int32_t seed;
} hnav_aid_sensor_options;

#endif /* HNAV_OPTIONS_AID_SENSOR_H */
