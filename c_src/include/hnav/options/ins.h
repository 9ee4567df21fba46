/* Made by c_src/options/generate.py from ins.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_INS_H
#define HNAV_OPTIONS_INS_H

#include "hnav/options/shared.h"

#include <stddef.h>
#include <stdint.h>

/* Grades of inertial sensors. */
typedef enum hnav_ins_preset {
    HNAV_INS_CONSUMER = 0,   /* chips of phones and hobby */
    HNAV_INS_INDUSTRIAL = 1, /* good chips, calibrated */
    HNAV_INS_TACTICAL = 2,   /* fibre-optic gyroscopes, the best of chips */
    HNAV_INS_NAVIGATION = 3  /* ring laser gyroscopes */
} hnav_ins_preset;

/* What is given at the start. */
typedef enum hnav_ins_start {
    HNAV_INS_START_ANY_HEADING = 0, /* nothing: tilt from the first seconds, heading from motion or the rate of the Earth */
    HNAV_INS_START_STATE = 1        /* start_q_nb and start_velocity_n_m_s, with their sigmas */
} hnav_ins_start;

/* Source of the first position. */
typedef enum hnav_ins_place {
    HNAV_INS_PLACE_FIX = 0,  /* the first fix of the satellites */
    HNAV_INS_PLACE_GIVEN = 1 /* start_latitude_rad and the like: where no satellite is, as for finding north at rest */
} hnav_ins_place;

/* Options of the navigation filter. Noise is given as densities: a sample that stands for an interval T has variance
 * density^2 / T. The presets are grades of inertial sensors as in datasheets; vibration is measured and added.
 * Make them with hnav_ins_defaults, then change what you need; hnav_option("ins", i) states all this at run time. */
typedef struct hnav_ins_options {
    size_t size;    /* of this struct in bytes; set by hnav_ins_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    /* ------------------------ noise
     * Noise of the inertial sensors. */

    /* Angle random walk: white noise of the gyroscope.
     * [0, 1e3] rad/sqrt(s), default 2e-4. Of a usual chip, 0.7 deg/sqrt(h). */
    double gyro_noise_rad_per_sqrt_s;
    /* Noise of the gyroscope that grows with the rate: density = this x |rate|.
     * [0, 1e3] sqrt(s), default 3e-3. Scale and misalignment of a third of a per cent. */
    double gyro_rate_noise_sqrt_s;
    /* Random walk of the gyro bias.
     * [0, 1e3] rad/s/sqrt(s), default 2e-5. Temperature moves the bias more than the walk on the datasheet. */
    double gyro_bias_walk_rad_s_per_sqrt_s;
    /* Velocity random walk: white noise of the accelerometer.
     * [0, 1e3] m/s/sqrt(s), default 2e-3. Of a usual chip, 0.2 mg/sqrt(Hz). */
    double accel_noise_m_s_per_sqrt_s;
    /* Scale errors and misalignments of the accelerometer, one sigma: an error of this x the acceleration, as lasting as
     * that.
     * [0, 1], default 1e-3. A tenth of a per cent. Cheap chips have more: state it, with sensor.json. */
    double accel_scale;
    /* Random walk of the accelerometer bias.
     * [0, 1e3] m/s2/sqrt(s), default 3e-4. As for the gyroscope. */
    double accel_bias_walk_m_s2_per_sqrt_s;
    /* Share of the power between neighbouring samples of rate and force that is used as their noise if it exceeds the
     * stated noise; 0 = none.
     * [0, 1e3], default 1. Vibration of a vehicle is far above the sensor noise, and from sample to sample it looks like
     * white noise. */
    double vibration_share;

    /* ------------------------ aiding
     * Errors of GNSS, pressure, wheels and heading aids. */

    /* Kind of body: car sets car_across_m_s if it is 0; the others set nothing, because no option improves their start.
     * hnav_body, default any. The kind of body is unknown. */
    int32_t body;
    /* Slowly varying error of the GNSS position, horizontal and vertical, one sigma; if the stated sigma of a fix is
     * larger, or below a tenth, the stated one is used; 0: none.
     * [0, 1e4] m, default 1.5, 1.5. Usual for a single receiver, vertically more; carrier phase and cameras state
     * centimetres. */
    double position_colour_m[2];
    /* Time for which that error stays as it is.
     * (0, 1e6] s, default 60. Usual for ionosphere and multipath of a moving body. */
    double position_colour_s;
    /* Slowly varying error of the barometric height, one sigma.
     * [0, 1e4] m, default 5. Weather and the wind around the body. */
    double pressure_colour_m;
    /* Time for which that error stays as it is.
     * (0, 1e6] s, default 1000. Weather changes within a quarter of an hour. */
    double pressure_colour_s;
    /* Correlation time of the error of external headings: samples within it have the weight of one; 0 = independent
     * errors.
     * [0, 1e6] s, default 60. Iron near a compass is constant; two antennas have small errors that last for seconds. */
    double heading_colour_s;
    /* Noise of the horizontal field relative to its strength: magnetometer, soft iron, iron beside the road.
     * (0, 10], default 0.05. Three degrees: soft iron of an uncalibrated device. */
    double field_noise;
    /* Correlation time of that noise: samples within it have the weight of one.
     * [0, 1e6] s, default 10. The time that a vehicle needs to pass an object. */
    double field_colour_s;
    /* Deviation of the local field from the declination, one sigma.
     * (0, 4] rad, default 0.2. An unknown declination, steel in buildings and streets; 0.05 with declination_rad in the
     * open. */
    double field_direction_rad;
    /* Correlation time of that deviation.
     * (0, 1e6] s, default 300. The time that a vehicle stays near a place. */
    double field_direction_s;
    /* A car: noise of its velocity sideways and upwards, used when the heading is found; 0 = that of the body: 0.1 for a
     * car, none for others.
     * [0, 1e3] m/s, default 0. The kind of body is unknown; body = car sets it. */
    double car_across_m_s;

    /* ------------------------ start
     * The start and its uncertainty. */

    /* any_heading: attitude and velocity are unknown; state: they are given.
     * hnav_ins_start, default any_heading. It needs nothing but the samples. */
    int32_t start;
    /* Source of the first position: fix, or given.
     * hnav_ins_place, default fix. It needs nothing but the samples. */
    int32_t start_place;
    /* Start latitude, if given.
     * [-pi/2, pi/2] rad, default 0. Only start_place given reads it. */
    double start_latitude_rad;
    /* Start longitude, if given.
     * [-2 pi, 2 pi] rad, default 0. Only start_place given reads it. */
    double start_longitude_rad;
    /* Start height above the ellipsoid, if given.
     * [-1e4, 1e5] m, default 0. Only start_place given reads it. */
    double start_height_m;
    /* Start attitude, body to north-east-down, scalar first; normalised on use.
     * [-2, 2], default 1, 0, 0, 0. Level and to the north; only start state reads it. */
    double start_q_nb[4];
    /* Start velocity, north, east, down.
     * [-1e4, 1e4] m/s, default 0, 0, 0. At rest; only start state reads it. */
    double start_velocity_n_m_s[3];
    /* Standard deviation of the heading at the start.
     * (0, 10] rad, default 5 deg. Of a compass; only start state reads it. */
    double start_sigma_heading_rad;
    /* Standard deviation of the tilt at the start.
     * (0, 10] rad, default 0.1. Of the tilt from a window of velocities, without the effect of biases; 0.5 deg/s of bias
     * turns the window itself. */
    double start_sigma_tilt_rad;
    /* Standard deviation of the horizontal velocity at the start; a fifth of it vertical.
     * (0, 1e4] m/s, default 90. An aircraft, in any direction. */
    double start_sigma_velocity_m_s;
    /* Standard deviation of the gyro bias at the start.
     * (0, 10] rad/s, default 1e-2. Half a degree per second. */
    double start_sigma_gyro_bias_rad_s;
    /* Standard deviation of the scale of each gyroscope; 0 = it is not estimated.
     * [0, 1], default 3e-3. What a factory calibration of a usual chip leaves. */
    double start_sigma_gyro_scale;
    /* Standard deviation of the misalignment of each gyroscope towards another axis; 0 = it is not estimated.
     * [0, 1] rad, default 5e-3. 0.3 deg, of a usual chip: with 0.1 deg the ready headings of the recorded flight have a z2
     * of 3.5 instead of 1.2. */
    double start_sigma_gyro_misalignment_rad;
    /* Standard deviation of the accelerometer bias at the start.
     * (0, 1e3] m/s2, default 0.3. Thirty mg, its mounting in the vehicle included. */
    double start_sigma_accel_bias_m_s2;
    /* Standard deviation of the first fix, in addition to its stated sigma.
     * (0, 1e7] m, default 30. The error of a receiver that has just started; a wider prior costs a few fixes. */
    double start_sigma_position_m;
    /* Standard deviation of the GNSS latency relative to the time stamps.
     * [0, 10] s, default 0.2. Fixes that are stamped when they arrive are 0.05 s to 0.5 s late. */
    double start_sigma_latency_s;
    /* Standard deviation of the scale error of the wheel speed.
     * [0, 1], default 0.05. Worn tyres. */
    double start_sigma_speed_scale;
    /* Standard deviation of the hard iron of the body, relative to the horizontal field of the Earth; each axis.
     * (0, 100], default 1. Of an uncalibrated phone or car; with 0.05, after a calibration, the heading is found at once. */
    double start_sigma_iron;
    /* Standard deviation of yaw and pitch of the axis of travel in the body.
     * [0, 1] rad, default 0.03. A sensor aligned by eye. */
    double start_sigma_mounting_rad;
    /* Time of the window by which the first tilt is found.
     * (0, 1e3] s, default 5. Long enough to average GNSS noise, short enough for the gyro drift; 10 for ships and
     * vibrating aircraft. */
    double level_window_s;
    /* Spread of the heading over the whole circle at which the heading is found.
     * (0, 0.3] rad, default 8 deg. The probability of all other headings is then below 0.002. With 4 deg the heading of
     * consumer ships has z2 3.9 instead of 2.1. */
    double heading_found_rad;

    /* ------------------------ rest
     * Detection of rest. */

    /* Rest: root mean square of the rate about its running mean; 0 = rest is never found.
     * [0, 1e3] rad/s, default 1 deg. Above the noise of usual gyroscopes, below any motion. */
    double rest_rate_rad_s;
    /* Rest: root mean square of the force about its running mean.
     * [0, 1e3] m/s2, default 0.25. Above the noise of usual accelerometers and an idling engine, below any motion. */
    double rest_force_m_s2;
    /* Rest: time within both limits, with a small speed.
     * [0, 1e3] s, default 1. A vehicle swings for a second after it stops. */
    double rest_duration_s;
    /* Velocity of a body at rest, one sigma, per correction (10 Hz).
     * (0, 1e3] m/s, default 0.02. A vehicle sways on its wheels. */
    double rest_velocity_noise_m_s;
    /* Noise of the rate about the vertical of a body at rest, in addition to that of the gyroscope.
     * [0, 1e3] rad/sqrt(s), default 2e-4. As of a usual gyroscope. */
    double rest_rate_noise_rad_per_sqrt_s;

    /* ------------------------ gate
     * Samples that are rejected or down-weighted. */

    /* NIS of three values beyond which their noise is inflated, less for fewer values; 0 = never.
     * [0, 1e12], default 16.3. 99.9 % of chi square with 3 degrees of freedom. */
    double gate_nis;
    /* Positions or velocities that stay beyond the gate for longer are accepted, as a new GNSS error or a new velocity.
     * (0, 1e9] s, default 15. Longer than most reflections last, short enough to recover. */
    double gate_longest_s;

    /* ------------------------ fault
     * Saturation, outliers and jumps of time stamps. */

    /* Rate at which an axis of the gyroscope saturates; 0 = detected from repeated values.
     * [0, 1e6] rad/s, default 0. A saturated sensor repeats its limit, unless a low-pass filter follows. */
    double gyro_range_rad_s;
    /* Specific force at which an axis of the accelerometer saturates; 0 = detected from repeated values.
     * [0, 1e6] m/s2, default 0. As for the gyroscope. */
    double accel_range_m_s2;
    /* A single rate sample that differs from the last by more than this, and by more than ten usual changes, is rejected;
     * 0 = never.
     * [0, 1e6] rad/s, default 8. No recorded movement changes the rate so much from one sample to the next; half of it
     * turns by two degrees at 100 Hz. */
    double outlier_rate_rad_s;
    /* A single force sample that differs from the last by more than this, and by more than ten usual changes, is rejected;
     * 0 = never.
     * [0, 1e6] m/s2, default 100. Taps on a table change it by so much; a smaller value would reject real motion. */
    double outlier_force_m_s2;
    /* Time stamps that run back further start a new time base; a single stamp ten times as far ahead is rejected; 0 =
     * never.
     * [0, 1e6] s, default 1. Longer than usual latencies, shorter than usual clock corrections. */
    double time_jump_limit_s;

    /* ------------------------ ready
     * Limits of the ready flags. */

    /* Tilt is ready when its sigma is below this and the samples have provided the information for it.
     * (0, 10] rad, default 1 deg. As the heading. */
    double ready_tilt_rad;
    /* Heading is ready when its sigma is below this and the samples have provided the information for it.
     * (0, 10] rad, default 1 deg. In simulated starts of aircraft 1 of 100 ready headings was wrong at a limit of 2 deg,
     * none at 1 deg. */
    double ready_heading_rad;
    /* Velocity is ready when its sigma is below this and the samples have provided the information for it.
     * (0, 1e4] m/s, default 0.5. Usual for satellites. */
    double ready_velocity_m_s;
    /* Position is ready when its horizontal sigma is below this and the samples have provided the information for it.
     * (0, 1e7] m, default 5. Usual for satellites. */
    double ready_position_m;
    /* Time for which the sigma of the heading has to stay below its limit.
     * [0, 1e6] s, default 5. Wrong headings are most frequent right after the limit is reached. */
    double ready_hold_s;

    /* ------------------------ timing
     * Hold of samples, gaps, late samples. */

    /* forward: rate and force hold until the next sample; backward: since the previous sample, with coning and sculling;
     * instant: they were read at their time.
     * hnav_gyro_hold, default backward. Integrating sensors and averaging FIFOs return the mean over the interval before a
     * sample. */
    int32_t gyro_hold;
    /* Largest interval between updates of the covariance; it is also updated at every aid.
     * (0, 10] s, default 0.0997. Short for turns of vehicles, long for samples. For no usual rate from 25 to 1000 Hz are
     * two samples equally near. */
    double correction_interval_s;
    /* After a longer gap without rate and force the filter starts again.
     * (0, 1e6] s, default 1. A vehicle turns by tens of degrees in a second. */
    double longest_gap_s;
    /* Largest age of a late sample relative to the newest one.
     * [0, 1e3] s, default 0. Samples are in order; a horizon costs memory and the replay of all events within it. */
    double horizon_s;
    /* Number of events that can wait or be within the horizon.
     * [4, 1e6], default 64. Enough for an advance after every few dozen samples, and little memory. */
    int32_t queue_capacity;

    /* ------------------------ frame
     * Axes and lever arms. */

    /* Position of the GNSS antenna relative to the inertial sensor, body axes.
     * [-1e3, 1e3] m, default 0, 0, 0. At the sensor. */
    double antenna_b_m[3];
    /* Sigma of antenna_b_m, each axis; 0: it is exact.
     * [0, 1e3] m, default 0.3. An antenna that was not measured; several times as far away it is estimated as well. */
    double start_sigma_antenna_m;
    /* Place of the speed measurement relative to the inertial sensor, body axes: the middle of a car's rear axle; 0:
     * unknown within 1 m.
     * [-1e3, 1e3] m, default 0, 0, 0. At the sensor, not measured. */
    double wheel_b_m[3];
    /* Magnetic declination: of external headings, and of the magnetometer.
     * [-pi, pi] rad, default 0. Without it headings are true headings. */
    double declination_rad;
    /* Mounting: rotates sensor vectors into body axes, scalar first; normalised on use.
     * [-2, 2], default 1, 0, 0, 0. Body axes are the sensor's. */
    double q_body_sensor[4];
    /* Distance of the body from the origin of the filter's axes beyond which the origin moves to the body.
     * [100, 1e5] m, default 1e4. Small displacements keep their precision. */
    double anchor_distance_m;

    /* ------------------------ solver
     * The integrator between events. */

    /* Integrator between events: SUNDIALS ERKStep, SUNDIALS CVODE Adams, closed form, or forward Euler.
     * hnav_solver, default erkstep. A one-step method: every interval is integrated alike, to solver_rtol. */
    int32_t solver;
    /* Relative tolerance of ERKStep and Adams.
     * [1e-14, 1e-2], default 1e-8. The integrator's error stays far below that of any sensor. */
    double solver_rtol;
    /* Absolute tolerance of ERKStep and Adams, relative to the nominal size of each state.
     * [1e-20, 1e-2], default 1e-8. As solver_rtol, relative to the size of each state. */
    double solver_atol;
    /* Sub-step of Euler.
     * (0, 1e3] s, default 0.005. Steps for comparison; the other integrators need none. */
    double euler_step_s;
} hnav_ins_options;

#endif /* HNAV_OPTIONS_INS_H */
