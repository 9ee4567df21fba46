/* Made by c_src/options/generate.py from hrekf.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_HREKF_H
#define HNAV_OPTIONS_HREKF_H

#include "hnav/options/shared.h"

#include <stddef.h>
#include <stdint.h>

/* Adaptation of the bias walk from the corrections. */
typedef enum hnav_adaptation {
    HNAV_ADAPTATION_OFF = 0,      /* the bias walk stays as it is set */
    HNAV_ADAPTATION_PAPER = 1,    /* Q <- (1 - alpha) Q + alpha K nu nu' K' on the bias block, as printed */
    HNAV_ADAPTATION_CORRECTED = 2 /* its level, from windows of ten seconds once the start has settled, annealed, bounded */
} hnav_adaptation;

/* Options of the paper's filter (HEKF, HREKF). Noise is given as densities: a sample that stands for an interval T has
 * variance density^2 / T, and process noise adds density^2 per second. The default noise of force and field is far above
 * any datasheet: it stands for the accelerations and the field distortions that the filter does not model.
 * Make them with hnav_hrekf_defaults, then change what you need; hnav_option("hrekf", i) states all this at run time. */
typedef struct hnav_hrekf_options {
    size_t size;    /* of this struct in bytes; set by hnav_hrekf_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    /* ------------------------ noise
     * Process and measurement noise. */

    /* Angle random walk: white noise of the gyroscope.
     * [0, 1e3] rad/sqrt(s), default 1e-2. Far above the datasheet: it keeps the gain large for motion that the filter does
     * not model. */
    double gyro_noise_rad_per_sqrt_s;
    /* Random walk of the gyro bias.
     * [0, 1e3] rad/s/sqrt(s), default 1e-4. Temperature moves the bias more than the walk on the datasheet. */
    double gyro_bias_walk_rad_s_per_sqrt_s;
    /* Additional white noise on all four components of the quaternion alike (the paper's L = I).
     * [0, 1e3] 1/sqrt(s), default 0. The gyro noise already determines the uncertainty of the attitude; noise on the
     * length of a quaternion has no meaning. */
    double quaternion_noise_per_sqrt_s;
    /* Noise density of the direction of specific force; a sample of an interval T has variance density^2/T.
     * (0, 1e6] 1/sqrt(Hz), default 0.115. It represents accelerations of the body; use the datasheet's value for a body
     * that does not accelerate. */
    double accel_noise_per_sqrt_hz;
    /* Noise density of the magnetic field in units of the reference strength.
     * (0, 1e6] 1/sqrt(Hz), default 0.16. It represents the iron of a room; use the datasheet's value for a clean field. */
    double mag_noise_per_sqrt_hz;

    /* ------------------------ timing
     * What a sample stands for, late samples. */

    /* forward: a rate holds until the next sample; backward: since the previous sample (C and Co-Simulation).
     * hnav_gyro_hold, default forward. Causal: C, Co-Simulation and Model Exchange agree. */
    int32_t gyro_hold;
    /* Longest interval that one sample represents; the first sample of a sensor represents none.
     * (0, 1e6] s, default 0.1. Ten times the usual interval; a sample after a longer gap contains no more information. */
    double max_interval_s;
    /* Largest age of a late sample relative to the newest one.
     * [0, 1e3] s, default 0. Samples are in order; a horizon costs memory and the replay of all events within it. */
    double horizon_s;
    /* Number of events that can wait or be within the horizon.
     * [4, 1e6], default 64. Enough for an advance after every few dozen samples, and little memory. */
    int32_t queue_capacity;

    /* ------------------------ robust
     * The robust law. */

    /* Robust law: off (HEKF), fixed gamma, relative to the covariance, or by relative entropy.
     * hnav_gamma_mode, default off. Real sensors mostly have outliers, against which gates help; a finite gamma gives
     * outliers more weight. */
    int32_t gamma_mode;
    /* gamma of mode fixed, raised where infeasible.
     * (0, 1e12], default 1. A neutral value: mode fixed has no setting that fits all, so it is to be chosen. */
    double gamma;
    /* rate of mode relative: 1/gamma^2 = (1 - exp(-rate T)) / lmax(L P L').
     * [0, 1e6] 1/s, default 1.5. The paper preset's, rounded: 1.5 % of the limit for each correction at 100 Hz. */
    double gamma_relative_rate_1_s;
    /* rate of mode kl: a correction may spend (rate T)^2 nats of relative entropy.
     * [0, 1e6] 1/s, default 0.75. As much inflation as mode relative at 1.5, where one direction has most of the
     * covariance. */
    double gamma_kl_rate_1_s;
    /* Weight L of the quaternion in the robust law.
     * [0, 1e6], default 1. The paper's L = I. */
    double gamma_weight_attitude;
    /* Weight L of the gyro bias in the robust law.
     * [0, 1e6], default 1. The paper's L = I. */
    double gamma_weight_bias;

    /* ------------------------ adaptation
     * Robbins-Monro adaptation of the bias walk. */

    /* Robbins-Monro adaptation of the bias walk: off, as printed in the paper, or corrected (experimental).
     * hnav_adaptation, default off. With the right noise it gains nothing and increases the bias error by up to 10 %; as
     * printed it increases the error. */
    int32_t adaptation;
    /* alpha of the adaptation; when corrected, its lower limit.
     * [0, 1], default 0.02. A memory of fifty corrections, or windows of ten seconds when corrected. */
    double adaptation_gain;
    /* The adapted bias walk does not fall below this (corrected).
     * [0, 1e3] rad/s/sqrt(s), default 1e-6. The walk of a very good gyroscope: the bias remains adaptable. */
    double adaptation_min_rad_s_per_sqrt_s;
    /* The adapted bias walk does not exceed this (corrected).
     * [0, 1e3] rad/s/sqrt(s), default 1e-2. A hundred times the default walk: beyond it the bias would follow every
     * movement. */
    double adaptation_max_rad_s_per_sqrt_s;

    /* ------------------------ start
     * The first attitude and its uncertainty. */

    /* Start: triad (force and field), attitude (start_q_nb) or heading (force and start_heading_rad).
     * hnav_start_mode, default triad. It needs nothing but the samples. */
    int32_t start_mode;
    /* Consecutive samples of each sensor that are averaged for the start. Propagated by the gyroscope they must agree
     * within 25 %, and each force must be within 25 % of gravity; after 1 s any samples are accepted. 1 = the first
     * sample, unchecked.
     * [1, 1e6], default 2. The first sample may be wrong, and a second one rarely agrees with it by chance. More samples
     * help only at rest. */
    int32_t start_samples;
    /* Start attitude, body to navigation, scalar first; normalised on use.
     * [-2, 2], default 1, 0, 0, 0. Level and to the north; only start mode attitude reads it. */
    double start_q_nb[4];
    /* Start heading of body x, true, clockwise from north.
     * [-2 pi, 2 pi] rad, default 0. North; only start mode heading reads it. */
    double start_heading_rad;
    /* Start value of the gyro bias.
     * [-10, 10] rad/s, default 0, 0, 0. Nothing is known of the sensor. */
    double start_gyro_bias_rad_s[3];
    /* Standard deviation of the tilt at the start.
     * (0, 10] rad, default 0.1. The body may be accelerating by a tenth of gravity. */
    double start_sigma_tilt_rad;
    /* Standard deviation of the heading at the start.
     * (0, 10] rad, default 0.35. The field of the first samples may be off by twenty degrees, as indoors. */
    double start_sigma_heading_rad;
    /* Standard deviation of the gyro bias at the start.
     * (0, 10] rad/s, default 0.01. A usual turn-on bias of half a degree per second. */
    double start_sigma_bias_rad_s;

    /* ------------------------ reference
     * The magnetic field of the place. */

    /* Strength and dip of the magnetic field: learnt from the samples of the start, or given.
     * hnav_reference_mode, default learnt. It needs nothing but the samples, and indoors no model of the field holds. */
    int32_t reference_mode;
    /* Strength of the magnetic field, when given.
     * (0, 1e6] T, default 5e-5. A usual field of the Earth in middle latitudes. */
    double reference_strength_tesla;
    /* Dip of the magnetic field below the horizon, when given.
     * [-pi/2, pi/2] rad, default 60 deg. A usual dip in middle northern latitudes. */
    double reference_dip_rad;

    /* ------------------------ gate
     * A sample whose normalised innovation squared exceeds its limit is used with inflated noise. Gates work while tilt
     * (force), or tilt and heading (field, heading) are ready: a gate that rejects for long lets sigma grow until it
     * opens. */

    /* Normalised innovation squared of force beyond which its noise is inflated; 0 = never, -1 = by
     * accel_noise_per_sqrt_hz.
     * [-1, 1e12], default -1. By the noise: 0.13 x (0.115 / accel_noise_per_sqrt_hz)^2, within 0.13 and 13.9.
     * Accelerations have heavy tails, so the gate lies far inside the default noise, like the threshold of a Huber loss;
     * it begins at the same innovation when less noise is given, up to 99.7 % of chi square with 3 degrees of freedom. */
    double accel_gate_nis;
    /* Normalised innovation squared of the field beyond which its noise is inflated; 0 = never.
     * [0, 1e12], default 13.9. 99.7 % of chi square with 3 degrees of freedom. */
    double mag_gate_nis;
    /* Normalised innovation squared of the heading aid beyond which its noise is inflated; 0 = never.
     * [0, 1e12], default 8.8. 99.7 % of chi square with 1 degree of freedom. */
    double heading_gate_nis;

    /* ------------------------ fault
     * Sensors that saturate, samples and stamps beyond belief. */

    /* Rate at which an axis of the gyroscope saturates; 0 = detected from repeated values.
     * [0, 1e6] rad/s, default 0. A saturated sensor repeats its limit, unless a low-pass filter follows. */
    double gyro_range_rad_s;
    /* Specific force at which an axis of the accelerometer saturates; 0 = detected from repeated values.
     * [0, 1e6] m/s2, default 0. As for the gyroscope. */
    double accel_range_m_s2;
    /* Field at which an axis of the magnetometer saturates; 0 = unknown.
     * [0, 1e6] T, default 0. Usual ranges are far above the field of the Earth. */
    double mag_range_tesla;
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
     * When tilt and heading are called ready. */

    /* Tilt is ready when its sigma is below this and the samples have provided the information for it.
     * (0, 10] rad, default 2 deg. Sufficient for an attitude display or a levelled heading. */
    double ready_tilt_rad;
    /* Heading is ready when its sigma is below this and the samples have provided the information for it.
     * (0, 10] rad, default 5 deg. The field in rooms is wrong by a few degrees, so a smaller sigma would be optimistic. */
    double ready_heading_rad;

    /* ------------------------ frame
     * Axes of samples and outputs. */

    /* Navigation frame of the outputs and of start_q_nb: north-east-down or east-north-up.
     * hnav_navigation_frame, default ned. The usual frame of navigation. */
    int32_t navigation_frame;
    /* Magnetic declination: true heading = magnetic heading + declination.
     * [-pi, pi] rad, default 0. Unknown place: north is magnetic north until a declination is given. */
    double declination_rad;
    /* Mounting: rotates sensor vectors into body axes, scalar first; normalised on use.
     * [-2, 2], default 1, 0, 0, 0. Body axes are the sensor's. */
    double q_body_sensor[4];

    /* ------------------------ solver
     * The integrator between events. */

    /* Integrator between events: SUNDIALS ERKStep, SUNDIALS CVODE Adams, closed form, or the paper's Euler.
     * hnav_solver, default erkstep. A one-step method: every interval is integrated alike, to solver_rtol. */
    int32_t solver;
    /* Relative tolerance of ERKStep and Adams.
     * [1e-14, 1e-2], default 1e-8. The integrator's error stays far below that of any sensor. */
    double solver_rtol;
    /* Absolute tolerance of ERKStep and Adams, relative to the nominal size of each state.
     * [1e-20, 1e-2], default 1e-8. As solver_rtol, relative to the size of each state. */
    double solver_atol;
    /* Sub-step of Euler.
     * (0, 1e3] s, default 0.005. The paper's two steps for each sample at 100 Hz. */
    double euler_step_s;
} hnav_hrekf_options;

#endif /* HNAV_OPTIONS_HREKF_H */
