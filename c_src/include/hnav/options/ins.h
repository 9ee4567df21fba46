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

/* What is known at the start. */
typedef enum hnav_ins_start {
    HNAV_INS_START_ANY_HEADING = 0, /* nothing: tilt from the first seconds, heading from motion or the rate of the Earth */
    HNAV_INS_START_STATE = 1        /* start_q_nb and start_velocity_n_m_s, with their sigmas */
} hnav_ins_start;

/* Where the first position comes from. */
typedef enum hnav_ins_place {
    HNAV_INS_PLACE_FIX = 0,  /* the first fix of the satellites */
    HNAV_INS_PLACE_GIVEN = 1 /* start_latitude_rad and the like: where no satellite is, as for finding north at rest */
} hnav_ins_place;

/* Options of the navigation filter. Noise is given as densities: a sample that stands for an interval T has variance
 * density^2 / T. The presets are grades of inertial sensors as datasheets have them; what vibration adds is measured.
 * Make them with hnav_ins_defaults, then change what you need; hnav_option("ins", i) states all this at run time. */
typedef struct hnav_ins_options {
    size_t size;    /* of this struct in bytes; set by hnav_ins_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    /* ------------------------ noise
     * What the inertial sensors are taken to be. */

    /* Angle random walk: white noise of the gyroscope.
     * [0, 1e3] rad/sqrt(s), default 2e-4. Of a usual chip, 0.7 deg/sqrt(h). */
    double gyro_noise_rad_per_sqrt_s;
    /* Noise of the gyroscope that grows with the rate: density = this x |rate|.
     * [0, 1e3] sqrt(s), default 3e-3. Scale and misalignment of a third of a per cent. */
    double gyro_rate_noise_sqrt_s;
    /* Random walk of the gyro bias.
     * [0, 1e3] rad/s/sqrt(s), default 2e-5. Temperature moves the bias more than the walk on the datasheet. */
    double gyro_bias_walk_rad_s_per_sqrt_s;
    /* What the axes of the gyroscope are askew by, one sigma: a bias of this x the rate about the other two axes while the
     * body turns alike.
     * [0, 1], default 2e-3. Of a usual chip; errors of scale are states, start_sigma_gyro_scale. */
    double gyro_scale;
    /* Velocity random walk: white noise of the accelerometer.
     * [0, 1e3] m/s/sqrt(s), default 2e-3. Of a usual chip, 0.2 mg/sqrt(Hz). */
    double accel_noise_m_s_per_sqrt_s;
    /* Random walk of the accelerometer bias.
     * [0, 1e3] m/s2/sqrt(s), default 3e-4. As for the gyroscope. */
    double accel_bias_walk_m_s2_per_sqrt_s;
    /* Share of the power between neighbouring samples of rate and force that counts as their noise, where it is above the
     * stated one; 0 = none.
     * [0, 1e3], default 1. Vibration of a vehicle is far above a sensor's own noise, and is between samples what white
     * noise would be. */
    double vibration_share;

    /* ------------------------ aiding
     * Errors of the satellites, of pressure and of wheels. */

    /* Slowly varying error of the satellites' position, horizontal and vertical, one sigma; a fix that states more, or
     * less than a tenth, has what it states; 0: none.
     * [0, 1e4] m, default 1.5, 1.5. Usual for a single receiver, more upwards where satellites are few; corrections by
     * carrier phase and cameras state centimetres. */
    double position_colour_m[2];
    /* Time for which that error stays as it is.
     * (0, 1e6] s, default 60. Usual for the ionosphere and multipath of a body that moves. */
    double position_colour_s;
    /* Slowly varying error of the height by pressure, one sigma.
     * [0, 1e4] m, default 5. Weather and the wind around the body. */
    double pressure_colour_m;
    /* Time for which that error stays as it is.
     * (0, 1e6] s, default 1000. Weather changes in a quarter of an hour. */
    double pressure_colour_s;
    /* Time for which the error of a heading that is pushed stays as it is: more of them within it count as one; 0 = each
     * has its own.
     * [0, 1e6] s, default 60. Iron near a compass stays where it is; two antennas have errors of seconds, but small ones. */
    double heading_colour_s;
    /* Noise of the horizontal field, in parts of it: of the magnetometer, of iron that turns the field, of what stands
     * beside the way.
     * (0, 10], default 0.05. Three degrees: soft iron of a device that is not calibrated. */
    double field_noise;
    /* Time for which that noise stays as it is: more samples within it count as one.
     * [0, 1e6] s, default 10. As long as a vehicle goes straight ahead past the same things. */
    double field_colour_s;
    /* By how much the field of a place points off its declination, one sigma.
     * (0, 4] rad, default 0.2. A declination that is not given, steel in buildings and streets; 0.05 with declination_rad
     * in the open. */
    double field_direction_rad;
    /* Time for which that stays as it is.
     * (0, 1e6] s, default 300. As long as a vehicle stays near a place. */
    double field_direction_s;
    /* A car: noise of the velocity across its wheels and up, used from the time on at which the heading is found; 0 = no
     * car.
     * [0, 1e3] m/s, default 0. What the body is cannot be guessed; 0.1 for a car. */
    double car_across_m_s;

    /* ------------------------ start
     * The start and its uncertainty. */

    /* any_heading: nothing is known; state: attitude and velocity are given.
     * hnav_ins_start, default any_heading. It needs nothing but the samples. */
    int32_t start;
    /* Where the first position comes from: fix, or given.
     * hnav_ins_place, default fix. It needs nothing but the samples. */
    int32_t start_place;
    /* Latitude to start from, when given.
     * [-pi/2, pi/2] rad, default 0. Only start_place given reads it. */
    double start_latitude_rad;
    /* Longitude to start from, when given.
     * [-2 pi, 2 pi] rad, default 0. Only start_place given reads it. */
    double start_longitude_rad;
    /* Height above the ellipsoid to start from, when given.
     * [-1e4, 1e5] m, default 0. Only start_place given reads it. */
    double start_height_m;
    /* Attitude to start from, body to north-east-down, scalar first; normalised on use.
     * [-2, 2], default 1, 0, 0, 0. Level and to the north; only start state reads it. */
    double start_q_nb[4];
    /* Velocity to start from, north, east, down.
     * [-1e4, 1e4] m/s, default 0, 0, 0. At rest; only start state reads it. */
    double start_velocity_n_m_s[3];
    /* Standard deviation of the heading at the start.
     * (0, 10] rad, default 5 deg. Of a compass; only start state reads it. */
    double start_sigma_heading_rad;
    /* Standard deviation of the tilt at the start.
     * (0, 10] rad, default 0.1. Of the tilt that a window of velocities gives, its biases apart: half a degree per second
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
    /* Standard deviation of the accelerometer bias at the start.
     * (0, 1e3] m/s2, default 0.3. Thirty mg, its mounting in the vehicle included. */
    double start_sigma_accel_bias_m_s2;
    /* Standard deviation of the first fix, beside what it says itself.
     * (0, 1e7] m, default 30. A receiver that has just begun may be off by so much; a wide one costs a few fixes. */
    double start_sigma_position_m;
    /* Standard deviation of the satellites' latency behind their stamps.
     * [0, 10] s, default 0.06. Receivers deliver up to a tenth of a second late, where their time of validity is not
     * known. */
    double start_sigma_latency_s;
    /* Standard deviation of the scale of the speed.
     * [0, 1], default 0.05. Worn tyres. */
    double start_sigma_speed_scale;
    /* Standard deviation of the field of iron in the body, in parts of the horizontal field of the Earth; each axis.
     * (0, 100], default 1. Of a telephone or a car that is not calibrated; 0.05 after a calibration, and the heading is
     * found at once. */
    double start_sigma_iron;
    /* Standard deviation of yaw and pitch of the axis of travel in the body.
     * [0, 1] rad, default 0.03. A sensor screwed to a car by eye. */
    double start_sigma_mounting_rad;
    /* Time of the window by which the first tilt is found.
     * (0, 1e3] s, default 5. Long beside the noise of velocities, short beside the drift of gyroscopes; 10 for ships and
     * vibrating aircraft. */
    double level_window_s;
    /* Spread of the heading over the whole circle at which it is taken to be found.
     * (0, 0.3] rad, default 4 deg. All other headings together have a share below 0.0005 then. */
    double heading_found_rad;

    /* ------------------------ rest
     * When the body is taken to stand. */

    /* Rest: root mean square of the rate about its running mean; 0 = rest is never found.
     * [0, 1e3] rad/s, default 1 deg. Above the noise of usual gyroscopes, below the unrest of what moves. */
    double rest_rate_rad_s;
    /* Rest: root mean square of the force about its running mean.
     * [0, 1e3] m/s2, default 0.25. Above the noise of usual accelerometers and an engine that idles, below the unrest of
     * what moves. */
    double rest_force_m_s2;
    /* Rest: within both of them for so long, with a small speed.
     * [0, 1e3] s, default 1. A vehicle that stops swings for a second. */
    double rest_duration_s;
    /* Velocity of a body at rest, one sigma, ten times a second.
     * (0, 1e3] m/s, default 0.02. A vehicle sways on its wheels. */
    double rest_velocity_noise_m_s;
    /* Noise of the rate about the vertical of a body at rest, beside that of the gyroscope.
     * [0, 1e3] rad/sqrt(s), default 2e-4. As much as a usual gyroscope has. */
    double rest_rate_noise_rad_per_sqrt_s;

    /* ------------------------ gate
     * Samples that are rejected or weighed less. */

    /* Normalised innovation squared of three values beyond which their noise is inflated, less for fewer values; 0 =
     * never.
     * [0, 1e12], default 16.3. 99.9 % of chi square with 3 degrees of freedom. */
    double gate_nis;
    /* Positions or velocities beyond the gate for longer are accepted, as a new error of the satellites or a new velocity.
     * (0, 1e9] s, default 15. Longer than most reflections last, short enough to recover. */
    double gate_longest_s;

    /* ------------------------ fault
     * Sensors that saturate, samples and stamps beyond belief. */

    /* Rate at which an axis of the gyroscope saturates; 0 = found out from values that repeat.
     * [0, 1e6] rad/s, default 0. A sensor with noise shows its range by repeating it; one without noise, or a low-pass
     * behind the range, does not. */
    double gyro_range_rad_s;
    /* Specific force at which an axis of the accelerometer saturates; 0 = found out from values that repeat.
     * [0, 1e6] m/s2, default 0. As for the gyroscope. */
    double accel_range_m_s2;
    /* A single sample of the rate further from the last than this, and than ten usual changes, is left out; 0 = none is.
     * [0, 1e6] rad/s, default 8. No recorded movement changes the rate so much from one sample to the next; half of it
     * turns by two degrees at 100 Hz. */
    double outlier_rate_rad_s;
    /* A single sample of the specific force further from the last than this, and than ten usual changes, is left out; 0 =
     * none is.
     * [0, 1e6] m/s2, default 100. Taps on a table change it by so much; less would leave out what the body really felt. */
    double outlier_force_m_s2;
    /* A sensor whose stamps run back further begins a new time base, a single stamp ten times as far ahead is left out; 0
     * = never.
     * [0, 1e6] s, default 1. Longer than samples are late, shorter than a clock is ever set. */
    double time_jump_limit_s;

    /* ------------------------ ready
     * When tilt, heading, velocity and position are called ready. */

    /* Tilt is ready when its sigma is below this and as much information has been gained.
     * (0, 10] rad, default 1 deg. As the heading. */
    double ready_tilt_rad;
    /* Heading is ready when its sigma is below this and as much information has been gained.
     * (0, 10] rad, default 1 deg. In simulated starts of aircraft with sigmas of 2 deg one of a hundred was false, with 1
     * deg none. */
    double ready_heading_rad;
    /* Velocity is ready when its sigma is below this and as much information has been gained.
     * (0, 1e4] m/s, default 0.5. Usual for satellites. */
    double ready_velocity_m_s;
    /* Position is ready when its horizontal sigma is below this and as much information has been gained.
     * (0, 1e7] m, default 5. Usual for satellites. */
    double ready_position_m;
    /* Time for which the sigma of the heading has to stay below its limit.
     * [0, 1e6] s, default 5. An early claim is the likeliest to be wrong. */
    double ready_hold_s;

    /* ------------------------ timing
     * What a sample stands for, gaps, late samples. */

    /* forward: rate and force act until the next sample; backward: since the one before, with coning and sculling.
     * hnav_gyro_hold, default backward. Integrating sensors and averaging FIFOs give the mean over the interval before a
     * sample. */
    int32_t gyro_hold;
    /* The covariance follows so often at the least, and at every aid.
     * (0, 10] s, default 0.0997. Short beside the turns of vehicles, long beside the samples. No usual rate from 25 to
     * 1000 Hz has two samples equally near. */
    double correction_interval_s;
    /* After a longer gap without rate and force the filter starts again.
     * (0, 1e6] s, default 1. A vehicle turns by tens of degrees in a second. */
    double longest_gap_s;
    /* How much older than the newest used sample a sample may be.
     * [0, 1e3] s, default 0. Samples come in order; a horizon costs memory and the replay of all that lies within it. */
    double horizon_s;
    /* Instants that may wait or lie within the horizon.
     * [4, 1e6], default 64. Enough for an advance after every few dozen samples, and little memory. */
    int32_t queue_capacity;

    /* ------------------------ frame
     * Axes and lever arms. */

    /* Antenna of the satellites, from the inertial sensor, in body axes.
     * [-1e3, 1e3] m, default 0, 0, 0. Together with the sensor. */
    double antenna_b_m[3];
    /* Where the speed is measured, from the inertial sensor, in body axes: the middle of the rear axle of a car; 0:
     * unknown by a metre.
     * [-1e3, 1e3] m, default 0, 0, 0. Together with the sensor, as far as it is not measured. */
    double wheel_b_m[3];
    /* Magnetic declination: of headings that are pushed, and of the field of a magnetometer.
     * [-pi, pi] rad, default 0. Headings are taken to be true ones until a declination is given. */
    double declination_rad;
    /* Mounting: turns sensor vectors into the body frame, scalar first; normalised on use.
     * [-2, 2], default 1, 0, 0, 0. Body axes are the sensor's. */
    double q_body_sensor[4];
    /* The axes in which the filter calculates move along when the body is farther away from where they stand.
     * [100, 1e5] m, default 1e4. Small displacements keep their digits. */
    double anchor_distance_m;

    /* ------------------------ solver
     * The integrator between events. */

    /* Integrator between events: SUNDIALS ERKStep, SUNDIALS CVODE Adams, closed form, or forward Euler.
     * hnav_solver, default erkstep. Without history, so that every interval is integrated alike, and exact to solver_rtol
     * for any flow. */
    int32_t solver;
    /* Relative tolerance of ERKStep and Adams.
     * [1e-14, 1e-2], default 1e-8. The integrator's error stays far below that of any sensor. */
    double solver_rtol;
    /* Absolute tolerance of ERKStep and Adams, relative to the nominal size of each state.
     * [1e-20, 1e-2], default 1e-8. As solver_rtol: every state is as exact as its own size asks for. */
    double solver_atol;
    /* Sub-step of Euler.
     * (0, 1e3] s, default 0.005. Steps for comparison; the other integrators need none. */
    double euler_step_s;
} hnav_ins_options;

#endif /* HNAV_OPTIONS_INS_H */
