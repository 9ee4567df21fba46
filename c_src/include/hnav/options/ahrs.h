/* Made by c_src/options/generate.py from ahrs.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_AHRS_H
#define HNAV_OPTIONS_AHRS_H

#include "hnav/options/shared.h"

#include <stddef.h>
#include <stdint.h>

/* Options of the AHRS, the filter for real sensors. Densities: a quantity that stands for an interval T has variance
 * density^2 / T. Fields are in units of the strength of the reference. The defaults are one setting for all bodies and
 * sensors, found on the recordings of the BROAD benchmark: each of them times or divided by 1.3 changes the mean error
 * there by a few per cent at most.
 * Make them with hnav_ahrs_defaults, then change what you need; hnav_option("ahrs", i) states all this at run time. */
typedef struct hnav_ahrs_options {
    size_t size;    /* of this struct in bytes; set by hnav_ahrs_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    /* ------------------------ noise
     * What the sensors and the motion are taken to be. */

    /* Kind of body: sets the noise of lasting velocities and the test of rest, and switches the robust law off.
     * hnav_body, default any. The kind of body is unknown; with the right word the sigmas of a vehicle are correct from
     * the start on. */
    int32_t body;
    /* Angle random walk: white noise of the gyroscope.
     * [0, 1e3] rad/sqrt(s), default 8.4e-5. Of a usual chip, 5 mdeg/s/sqrt(Hz). */
    double gyro_noise_rad_per_sqrt_s;
    /* Noise of the gyroscope that grows with the rate: density = this x |rate|.
     * [0, 1e3] sqrt(s), default 1.7e-3. In hand motion scale factor and misalignment dominate the white noise; without it
     * the error on BROAD is 1.5 times as large. */
    double gyro_rate_noise_sqrt_s;
    /* Random walk of the gyro bias.
     * [0, 1e3] rad/s/sqrt(s), default 1e-4. Temperature moves the bias more than the walk on the datasheet, which is for a
     * sensor of constant temperature only. */
    double gyro_bias_walk_rad_s_per_sqrt_s;
    /* Bound of the velocity, by which the accelerometer measures the tilt.
     * (0, 1e6] m/s/sqrt(Hz), default 0.36. A hand or a walking person. Smaller values reduce the tilt noise of a body that
     * does not accelerate, larger ones tolerate long accelerations. */
    double velocity_noise_m_s_per_sqrt_hz;
    /* Noise density of the field across the reference, in units of its strength.
     * (0, 1e6] 1/sqrt(Hz), default 0.018. Far above any datasheet: it represents the iron of a room. With larger values
     * the heading follows the gyroscope for longer. */
    double mag_azimuth_noise_per_sqrt_hz;
    /* Noise density of horizontal and vertical intensity, in units of the strength.
     * (0, 1e6] 1/sqrt(Hz), default 0.0125. Iron of a room changes the intensities slightly less than the azimuth. */
    double mag_intensity_noise_per_sqrt_hz;
    /* Factor on the field's variances at rest, where disturbances do not average out.
     * (0, 1e6], default 1.07. At rest all samples have the same disturbance. */
    double mag_rest_factor;
    /* Random walk of the reference field, in units of the strength.
     * [0, 1e3] 1/sqrt(s), default 3.1e-3. The field varies within a room; with a constant reference the error on BROAD is
     * larger. */
    double reference_walk_per_sqrt_s;
    /* Variation of the field's azimuth from place to place, one sigma.
     * (0, 10] rad, default 0.025. A degree and a half, as in the rooms of BROAD; in the open it is less. */
    double local_declination_rad;
    /* Iron that the calibration of the magnetometer leaves, on each axis, in units of the field's strength, one sigma.
     * (0, 1], default 0.01. Half a microtesla, as a good calibration leaves it. With 0.005 or 0.03 the heading of
     * simulated bodies is ready and wrong more often. */
    double residual_iron;
    /* Time that a moving body stays at a place of constant azimuth.
     * (0, 1e9] s, default 60. Of a hand in a room. */
    double local_declination_s;
    /* Sideslip: angle between the horizontal velocity and body x, one sigma; acts with a speed (push_speed).
     * [0, 10] rad, default 0.03. Of tyres in a bend, of an aircraft in a gust, and of a sensor that is mounted a degree
     * off. */
    double speed_slip_rad;

    /* ------------------------ timing
     * What a sample stands for, gaps between samples, late samples. */

    /* forward: a rate holds until the next sample; backward: since the previous sample; instant: it was read at its time.
     * hnav_gyro_hold, default backward. Integrating gyroscopes and averaging FIFOs return the mean over the interval
     * before a sample. */
    int32_t gyro_hold;
    /* Interval between corrections, at the nearest sample; aids correct at once.
     * (0, 1e3] s, default 0.0444. Long for samples, so that corrections cost little, and short for the motion; half of it
     * gains nothing. For no usual rate from 25 to 1000 Hz are two samples equally near, by a twentieth of the samples'
     * interval. */
    double correction_interval_s;
    /* Longest interval that one sample represents; the first sample of a sensor represents none.
     * (0, 1e6] s, default 0.1. Ten times the usual interval; a sample after a longer gap contains no more information. */
    double max_interval_s;
    /* Acceleration of the body in a gap between force samples.
     * [0, 1e6] m/s2, default 2. A brisk movement of a hand. */
    double gap_acceleration_m_s2;
    /* Angular acceleration in a gap between gyro samples, in units of its running RMS.
     * [0, 1e6], default 2.5. A gap may coincide with the fastest part of a turn. */
    double gap_turn_factor;
    /* Time after the last speed (push_speed) after which the velocity is unknown.
     * (0, 1e3] s, default 3. Two samples of a GNSS receiver with 1 Hz may be missing. */
    double max_speed_age_s;
    /* Largest age of a late sample relative to the newest one.
     * [0, 1e3] s, default 0. Samples are in order; a horizon costs memory and the replay of all events within it. */
    double horizon_s;
    /* Number of events that can wait or be within the horizon.
     * [4, 1e6], default 64. Enough for an advance after every few dozen samples, and little memory. */
    int32_t queue_capacity;
    /* Attitude is predicted this far ahead at the present rate.
     * [-1, 1] s, default 0. Attitude is that of the time stamps; the latency of the user's output is unknown. */
    double output_latency_s;

    /* ------------------------ rest
     * When the body is taken to lie still, and what is learnt then. */

    /* Rest: deviation of the rate from its running mean.
     * [0, 1e3] rad/s, default 2 deg. Above the noise of usual gyroscopes, below the tremor of a hand. */
    double rest_rate_rad_s;
    /* Rest: deviation of the specific force from its running mean.
     * [0, 1e6] m/s2, default 0.5. Above the noise of usual accelerometers, below the tremor of a hand. */
    double rest_force_m_s2;
    /* Rest: largest mean rate of an axis that can be a bias.
     * [0, 1e3] rad/s, default 2 deg. Turn-on bias of usual gyroscopes; a slower steady turn would be estimated as bias. */
    double rest_mean_rate_rad_s;
    /* Rest: time within the thresholds.
     * [0, 1e6] s, default 1.5. Longer than the turning points of a movement. */
    double rest_duration_s;
    /* Rest: time constant of the running means.
     * (0, 1e6] s, default 0.5. Averages some dozen samples and follows the end of a movement. */
    double rest_filter_s;
    /* Noise density of the mean rate at rest as a measurement of the bias.
     * (0, 1e3] rad/s/sqrt(Hz), default 2.8e-5. Below the gyroscope's white noise, which the running mean has averaged. */
    double rest_bias_noise_rad_s_per_sqrt_hz;

    /* ------------------------ gate
     * Samples that are rejected or weighed less. */

    /* Deviation of the field's intensities from the reference beyond which it is rejected, in units of the strength.
     * (0, 1e6], default 0.035. Twice the mean deviation within a room; smaller values reject more fields. */
    double mag_gate;
    /* Longest time for which a field is rejected.
     * [0, 1e6] s, default 60. A gyroscope alone holds the heading for about a minute. */
    double mag_gate_max_s;
    /* Longest time for which a field is rejected, in units of the age of the reference.
     * [0, 1e6], default 3. A reference of a few seconds may be wrong itself. */
    double mag_gate_share;
    /* Deviation of the field's azimuth in sigmas beyond which it is rejected, while the heading is ready; 0 = never.
     * [0, 1e6], default 4. A room turns the field by less. Swapped or stuck magnetometer axes turn it by more at the same
     * intensity. */
    double mag_azimuth_gate_sigmas;
    /* Logarithm of the likelihood ratio of a wrong horizon to an accelerating body, from the mean force, above which the
     * horizon is levelled again; 0 = never.
     * [0, 1e12], default 12. No simulated vehicle reaches it; after 10 s of clipped gyroscope it is reached within 8 s. */
    double lost_ratio;
    /* Normalised innovation squared of the heading aid beyond which its noise is inflated; 0 = never.
     * [0, 1e12], default 8.8. 99.7 % of chi square with 1 degree of freedom. */
    double heading_gate_nis;

    /* ------------------------ reference
     * The magnetic field of the place, and when another takes its place. */

    /* Strength and dip of the magnetic field: learnt from the samples of the start, or given.
     * hnav_reference_mode, default learnt. It needs nothing but the samples, and indoors no model of the field holds. */
    int32_t reference_mode;
    /* Strength of the magnetic field, when given.
     * (0, 1e6] T, default 5e-5. A usual field of the Earth in middle latitudes. */
    double reference_strength_tesla;
    /* Dip of the magnetic field below the horizon, when given.
     * [-pi/2, pi/2] rad, default 60 deg. A usual dip in middle northern latitudes. */
    double reference_dip_rad;
    /* Largest relative difference of the field's strength from the given one. A field outside this or the tolerance of the
     * dip may hold a heading; it does not make the heading ready and does not replace the reference.
     * (0, 10], default 0.05. The World Magnetic Model is within 1 % outdoors, a calibrated magnetometer within 3 %. Of
     * false fields that turn the heading by more than 5 deg, 1 to 7 % are within this and the tolerance of the dip. */
    double reference_strength_tolerance;
    /* Largest difference of the field's dip from the given one.
     * (0, 10] rad, default 3 deg. The World Magnetic Model is within 0.5 deg outdoors, horizon and magnetometer within 2
     * deg. */
    double reference_dip_tolerance_rad;
    /* RMS rate above which a field has full weight as evidence.
     * [0, 1e3] rad/s, default 0.35. At this rate a magnet that moves with the body changes its direction visibly. */
    double turning_rad_s;
    /* Weight of evidence below that rate.
     * [0, 1], default 0.35. A body at rest measures the field of one place only. */
    double still_weight;
    /* Difference of intensities up to which fields are one candidate, in units of the strength.
     * (0, 1e6], default 0.17. Five times the gate: a candidate is a mean over places. */
    double candidate_radius;
    /* Averaging time of the candidate.
     * (0, 1e6] s, default 5. Longer than a pass near a piece of iron. */
    double candidate_mean_s;
    /* Evidence with which a candidate replaces a reference that has none.
     * [0, 1e6] s, default 1.6. A false first sample is replaced soon; a single outlier is not enough. */
    double candidate_first_s;
    /* Share of the reference's evidence with which a candidate replaces it.
     * [0, 1e6], default 0.5. A change of place is detected before as much time has passed there; choose more if the place
     * changes often. */
    double candidate_share;
    /* Evidence after which a new field no longer turns the heading.
     * (0, 1e6] s, default 60. The heading then has more evidence than the new field. */
    double trust_s;
    /* Smallest heading error that a new field corrects at once.
     * [0, 10] rad, default 0.13. Smaller errors are removed by the usual corrections. */
    double turn_min_rad;
    /* The same in sigmas of the heading.
     * [0, 1e3], default 3.75. Within its own sigma the heading is consistent. */
    double turn_sigmas;
    /* Standard deviation added to a heading that a new field has turned.
     * [0, 10] rad, default 0.12. The new field may be off by several degrees too. */
    double turn_sigma_rad;

    /* ------------------------ robust
     * The robust law, which works until the horizon is found. */

    /* Robust law while the horizon is not found: off, fixed gamma, relative to the covariance, or by relative entropy.
     * hnav_gamma_mode, default relative. It shortens the convergence from a large initial error, independent of the sample
     * rate. */
    int32_t gamma_mode;
    /* gamma of mode fixed, raised where infeasible.
     * (0, 1e12], default 1. A neutral value: mode fixed has no setting that fits all, so it is to be chosen. */
    double gamma;
    /* rate of mode relative: 1/gamma^2 = (1 - exp(-rate T)) / lmax of the horizon's covariance.
     * [0, 1e6] 1/s, default 0.3. Mild: the velocity model already covers most accelerations. */
    double gamma_relative_rate_1_s;
    /* rate of mode kl: a correction may spend (rate T)^2 nats of relative entropy.
     * [0, 1e6] 1/s, default 0.75. As much inflation as mode relative at 1.5, where one direction has most of the
     * covariance. */
    double gamma_kl_rate_1_s;

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
    /* Time after which the filter starts with an unknown heading if there is no field (triad).
     * [0, 1e6] s, default 1. Far longer than the period of any magnetometer. */
    double start_field_wait_s;
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
     * (0, 10] rad, default 0.08. The body may be accelerating by a tenth of gravity. */
    double start_sigma_tilt_rad;
    /* Standard deviation of the heading at the start.
     * (0, 10] rad, default 0.2. The field of the first samples may be off by eleven degrees, as indoors. */
    double start_sigma_heading_rad;
    /* Standard deviation of the gyro bias at the start.
     * (0, 10] rad/s, default 0.008. A usual turn-on bias of half a degree per second. */
    double start_sigma_bias_rad_s;
    /* Standard deviation of the velocity at the start.
     * (0, 1e3] m/s, default 0.056. A start in a hand. */
    double start_sigma_velocity_m_s;
    /* Standard deviation of the reference at the start and when the gate begins to inflate, in units of the strength.
     * (0, 10], default 0.077. Two gates: error of the first field, or of a field that was rejected for long. */
    double start_sigma_reference;
    /* Standard deviation of the magnetometer's latency at the start.
     * (0, 10] s, default 0.011. Filters and averaging of usual magnetometers delay by 10 to 20 ms, which data sheets do
     * not state. */
    double start_sigma_latency_s;
    /* Latency of the accelerometer at the start, in its sample intervals.
     * [-4, 4], default 0.25. Between an instantaneous reading, 0, and the mean of the interval before it, 0.5; motion
     * makes it observable. */
    double start_accel_latency;
    /* Standard deviation of that latency.
     * (0, 10], default 0.25. An instantaneous reading and a mean over the interval are within one sigma; filtered readings
     * are later. */
    double start_sigma_accel_latency;
    /* Standard deviation of each axis's bias of the accelerometer at the start.
     * (0, 1e3] m/s2, default 0.07. 7 mg, of a usual chip. Where it is more, state it: with 0.2 m/s2 recorded hands with a
     * good sensor have 1.8 deg instead of 1.7, those with such a bias 2.5 instead of 2.8. */
    double start_sigma_accel_bias_m_s2;
    /* Standard deviation of the gyro scale factors at the start.
     * (0, 10], default 2e-3. 0.2 %, of a sensor that was calibrated once; uncalibrated ones have up to 0.01. If it is too
     * small, the stated sigma of the tilt of a turning body is too small. */
    double start_sigma_gyro_scale;
    /* Standard deviation of the gyro misalignments at the start.
     * (0, 10] rad, default 0.56e-3. A third of the scale factor's, as in most calibrated sensors. */
    double start_sigma_gyro_misalignment_rad;

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
     * (0, 10] rad, default 1.5 deg. Half of 3 deg, beyond which an attitude display is wrong. At a limit of 2 deg
     * simulated trains, trams and motorcycles without a word are ready and more than 3 deg off for 15, 9 and 4 % of the
     * time, at 1.5 deg for 10, 4 and 0 %. */
    double ready_tilt_rad;
    /* Heading is ready when its sigma is below this and the samples have provided the information for it.
     * (0, 10] rad, default 5 deg. The field in rooms is wrong by a few degrees, so a smaller sigma would be optimistic. */
    double ready_heading_rad;
    /* And the field has agreed with the reference for this time, with less weight at rest.
     * [0, 1e6] s, default 2.6. A passing disturbance does not agree for so long. */
    double ready_evidence_s;
    /* And nothing has contradicted the reference for this time; once ready, the sigma alone decides.
     * [0, 1e6] s, default 7.5. With it the first heading_ready is wrong in less than 1 of 100 simulated starts with a
     * passing disturbance. */
    double ready_undisturbed_s;

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
     * (0, 1e3] s, default 0.001. For comparison; at 1 ms its error is below that of a usual gyroscope. */
    double euler_step_s;
} hnav_ahrs_options;

#endif /* HNAV_OPTIONS_AHRS_H */
