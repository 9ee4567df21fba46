/* Navigation: position, velocity and attitude from rate, force and aids such as satellites, pressure and wheels; aligned from
 * any heading, in motion or at rest, without a magnetometer.
 *
 *     hnav_ins_options options = hnav_ins_defaults(HNAV_INS_INDUSTRIAL);
 *     hnav_ins* ins;
 *     hnav_navigation now = {.size = sizeof now};
 *     hnav_ins_create(&ins, &options, NULL, 0);
 *     while (...) {
 *         hnav_ins_push_imu(ins, t_s, rate_b_rad_s, force_b_m_s2);
 *         hnav_ins_push_velocity(ins, fix_s, velocity_n_m_s, velocity_sigma_m_s);
 *         hnav_ins_push_position(ins, fix_s, latitude_rad, longitude_rad, height_m, position_sigma_m);
 *         hnav_ins_advance(ins, t_s);
 *         hnav_ins_navigation(ins, &now);
 *     }
 *
 * Every sample carries the time at which it was valid; it may come later by the option horizon_s, and the filter goes back. Samples
 * of one time may come in any order. n is north-east-down at the place of the body; heights are above the ellipsoid of
 * WGS 84; sigmas are standard deviations. Other conventions and promises: hnav.h. */
#ifndef HNAV_INS_H
#define HNAV_INS_H

#include "hnav/options/ins.h"
#include "hnav/types.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct hnav_ins hnav_ins;

/* ------------------------------------------------------------------------------------------------ options */

HNAV_API hnav_ins_options hnav_ins_defaults(hnav_ins_preset preset);
/* Rows 0, 1, ...; null beyond the last. */
HNAV_API const hnav_option_info* hnav_ins_option(int32_t index);
HNAV_API const hnav_preset_info* hnav_ins_preset_info(int32_t index);

/* ------------------------------------------------------------------------------------------------ life */

/* Errors: NULL_ARGUMENT, OPTION, OPTIONS_STAMP, OUT_OF_MEMORY. message: for the reason, message_size characters; may be null. */
HNAV_API hnav_status hnav_ins_create(hnav_ins** ins, const hnav_ins_options* options, char* message, size_t message_size);
/* Null is allowed. */
HNAV_API void hnav_ins_destroy(hnav_ins* ins);
/* Back to the moment after create. */
HNAV_API hnav_status hnav_ins_reset(hnav_ins* ins);
/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char* hnav_ins_message(const hnav_ins* ins);

/* ------------------------------------------------------------------------------------------------ samples */

/* What a sample is of. */
typedef enum hnav_ins_sensor {
    HNAV_INS_IMU = 0,
    HNAV_INS_REST = 1,
    HNAV_INS_SPEED = 2,
    HNAV_INS_PRESSURE = 3,
    HNAV_INS_VELOCITY = 4,
    HNAV_INS_POSITION = 5,
    HNAV_INS_HEADING = 6,
    HNAV_INS_MAG = 7,
    HNAV_INS_SENSOR_COUNT = 8
} hnav_ins_sensor;

/* A sample acts at the next advance that reaches its time. Errors of all of them: NON_FINITE, OUT_OF_RANGE (sigmas that are not
 * positive, places that do not exist, numbers beyond 1e6), LATE_SAMPLE, QUEUE_FULL; the sample is dropped and counted. */
HNAV_API hnav_status hnav_ins_push_imu(hnav_ins* ins, double t_s, const double rate_b_rad_s[3], const double force_b_m_s2[3]);
/* sigma_n_m: as a receiver states it. It is taken for noise, and for the sigma of an error that stays for position_colour_s too. */
HNAV_API hnav_status hnav_ins_push_position(hnav_ins* ins, double t_s, double latitude_rad, double longitude_rad, double height_m,
                                            const double sigma_n_m[3]);
/* down: NaN when it is not known. */
HNAV_API hnav_status hnav_ins_push_velocity(hnav_ins* ins, double t_s, const double velocity_n_m_s[3],
                                            const double sigma_n_m_s[3]);
HNAV_API hnav_status hnav_ins_push_pressure(hnav_ins* ins, double t_s, double pressure_pa, double sigma_pa);
/* Along body x, by wheels; used once the heading is found. */
HNAV_API hnav_status hnav_ins_push_speed(hnav_ins* ins, double t_s, double speed_m_s, double sigma_m_s);
/* The body is known to stand. */
HNAV_API hnav_status hnav_ins_push_rest(hnav_ins* ins, double t_s, double sigma_m_s);
/* Of body x, clockwise from north; the option declination_rad is added. */
HNAV_API hnav_status hnav_ins_push_heading(hnav_ins* ins, double t_s, double heading_rad, double sigma_rad);
/* Field of a magnetometer, in any unit, in sensor axes: it tells of the heading alone, by the option declination_rad. Iron in the body
 * is estimated. Of samples that come faster than correction_interval_s some are used. ZERO_VECTOR: a sensor that is off. */
HNAV_API hnav_status hnav_ins_push_mag(hnav_ins* ins, double t_s, const double field_b[3]);

/* Uses the samples up to t_s and shows the estimate there. Errors: NON_FINITE, OUT_OF_RANGE, TIME_BACKWARDS, SOLVER (samples
 * that led to no usable estimate were dropped). */
HNAV_API hnav_status hnav_ins_advance(hnav_ins* ins, double t_s);

/* ------------------------------------------------------------------------------------------------ estimate */

typedef enum hnav_ins_phase {
    HNAV_INS_PHASE_WAITING = 0, /* for rate and force */
    HNAV_INS_PHASE_LEVELLING = 1, /* the first tilt is being found, or the first fix waited for */
    HNAV_INS_PHASE_ANY_HEADING = 2, /* everything but the heading is estimated, and what there is to know of it */
    HNAV_INS_PHASE_NAVIGATING = 3
} hnav_ins_phase;

/* At the time of the last advance. Before there is a tilt all numbers but t_s are NaN. In ANY_HEADING they are those of the
 * likeliest heading. */
typedef struct hnav_navigation {
    size_t size; /* of this struct; set by the caller */
    double t_s;
    double latitude_rad, longitude_rad, height_m;
    double velocity_n_m_s[3];
    double q_nb[4];
    double euler_rad[3]; /* roll, pitch, yaw; yaw is the true heading of body x */
    double position_e_m[3], velocity_e_m_s[3]; /* Earth-centred, Earth-fixed */
    double gyro_bias_rad_s[3], accel_bias_m_s2[3];
    double sigma_position_m[3], sigma_velocity_m_s[3]; /* north, east, down */
    double sigma_rotation_rad[3]; /* about north, east, down; the third is heading: its spread over the whole circle */
    double sigma_gyro_bias_rad_s[3], sigma_accel_bias_m_s2[3];
    double heading_second_rad, heading_second_share; /* the strongest other heading and its probability; share 0: there is none */
    double latency_s, sigma_latency_s; /* of the satellites behind their stamps */
    int32_t phase; /* hnav_ins_phase */
    /* Known: a small sigma that was earned from samples. */
    int32_t tilt_ready, heading_ready, velocity_ready, position_ready;
    int32_t at_rest;
    double gyro_scale[3], sigma_gyro_scale[3]; /* how much more than the rate each gyroscope shows, in parts of it */
} hnav_navigation;
/* Errors: SIZE. */
HNAV_API hnav_status hnav_ins_navigation(const hnav_ins* ins, hnav_navigation* navigation);

/* Of errors of position, velocity (north, east, down), rotation about them, gyro bias, accelerometer bias; row-major, 15 x 15.
 * NOT_STARTED before there is a tilt. */
HNAV_API hnav_status hnav_ins_covariance(const hnav_ins* ins, double covariance[225]);

/* Nats gained about the heading since the start, by what brought them: half the logarithm of the ratio of variances. */
typedef struct hnav_observed {
    size_t size; /* of this struct; set by the caller */
    double by_rest, by_speed, by_pressure, by_velocity, by_position, by_heading, by_field;
} hnav_observed;
HNAV_API hnav_status hnav_ins_observed(const hnav_ins* ins, hnav_observed* observed);

/* What the last used sample of a sensor said. */
typedef struct hnav_ins_innovation {
    size_t size; /* of this struct; set by the caller */
    double t_s;
    double value[3]; /* measured minus expected, of which the first `dimension` count: m, m/s or rad, north east down */
    double variance[3]; /* of each */
    double nis; /* normalised innovation squared: about `dimension` on average when model and noise are right */
    double noise_scale; /* above 1: the gate inflated the noise */
    int32_t dimension;
    int32_t reserved; /* 0 */
} hnav_ins_innovation;
/* Errors: SIZE, OUT_OF_RANGE, NO_DATA. */
HNAV_API hnav_status hnav_ins_last_innovation(const hnav_ins* ins, hnav_ins_sensor sensor, hnav_ins_innovation* innovation);

typedef struct hnav_ins_diagnostics {
    size_t size; /* of this struct; set by the caller */
    double newest_sample_s; /* NaN when there was none */
    double mean_nis; /* over dimension, of the last satellites and rests; above 1 the sigmas are too small */
    double gyro_vibration_rad_s, accel_vibration_m_s2; /* root mean square between neighbouring samples */
    uint64_t used[HNAV_INS_SENSOR_COUNT]; /* samples, by hnav_ins_sensor */
    uint64_t inflated[HNAV_INS_SENSOR_COUNT]; /* of those, with inflated noise, or left out: no heading yet, another field */
    uint64_t late, non_finite; /* samples refused */
    uint64_t times_lost; /* the start or the search for the heading began anew: a gap, gyroscopes that drifted too far */
    uint64_t corrections, solver_rhs_evals, solver_steps;
} hnav_ins_diagnostics;
HNAV_API hnav_status hnav_ins_get_diagnostics(const hnav_ins* ins, hnav_ins_diagnostics* diagnostics);

/* How each sensor does. Rate and force come in one sample: unit has both, and the entry of HNAV_INS_IMU what its stamps show. */
typedef struct hnav_ins_health {
    size_t size; /* of this struct; set by the caller */
    hnav_sensor_health unit[2]; /* gyroscope, accelerometer */
    hnav_sensor_health sensor[HNAV_INS_SENSOR_COUNT]; /* by hnav_ins_sensor */
    uint64_t times_lost; /* as in the diagnostics */
    uint64_t clock_jumps; /* stamps ran back: a new time base began */
    uint64_t stamps_left_out; /* samples whose stamp lay far ahead of all others */
} hnav_ins_health;
HNAV_API hnav_status hnav_ins_get_health(const hnav_ins* ins, hnav_ins_health* health);

/* ------------------------------------------------------------------------------------------------ recordings */

/* n rows of the IMU; a row of NaN has no sample. Aids are sorted by the time at which they came, which is their time of validity
 * when aid_received_s is null. aid_value: 6 for each, as the push calls have them:
 *     position  latitude, longitude in rad, height; sigma north, east, down
 *     velocity  north, east, down; sigmas          speed, pressure, heading  value, sigma
 *     rest      sigma                              mag  3, in sensor axes */
typedef struct hnav_ins_run_input {
    size_t size; /* of this struct; set by the caller */
    const double* t_s; /* n */
    const double* rate_b_rad_s; /* n x 3 */
    const double* force_b_m_s2; /* n x 3 */
    size_t aids;
    const double* aid_t_s; /* aids */
    const double* aid_received_s; /* aids, or null */
    const int32_t* aid_sensor; /* aids: hnav_ins_sensor */
    const double* aid_value; /* aids x 6 */
} hnav_ins_run_input;

/* Null: not written. */
typedef struct hnav_ins_run_output {
    size_t size; /* of this struct; set by the caller */
    size_t every; /* a row of output for each so many rows of input, the last of them; 0 for 1 */
    double* t_s;
    double* place; /* x 3: latitude, longitude in rad, height in m */
    double* velocity_n_m_s; /* x 3 */
    double* q_nb; /* x 4 */
    double* sigma_position_m; /* x 3 */
    double* sigma_velocity_m_s; /* x 3 */
    double* sigma_rotation_rad; /* x 3 */
    double* gyro_bias_rad_s; /* x 3 */
    double* accel_bias_m_s2; /* x 3 */
    double* heading_second; /* x 2: heading in rad, share */
    uint8_t* phase;
    uint8_t* ready; /* x 4: tilt, heading, velocity, position */
    uint8_t* at_rest;
} hnav_ins_run_output;

/* Bit for bit as sample by sample. Samples that cannot be used are counted and left out. rows_done (may be null): rows of input
 * that are complete; less than n only after an error. */
HNAV_API hnav_status hnav_ins_run(hnav_ins* ins, size_t n, const hnav_ins_run_input* input, const hnav_ins_run_output* output,
                                  size_t* rows_done);

/* With hindsight: every row from all samples, before it and after it, each at its time of validity however late it came; those that
 * came after the last row are not used. From the first sample of rate and force on, as soon as the heading has been found later:
 * phase is NAVIGATING there, heading_second has share 0, and ready means a small sigma, if the filter earned the flag in this row
 * or a later one. Rows of which nothing later tells the heading are those of the filter, and so is the last one. By the closed form,
 * whatever solver is; the filter itself stays as it is. Takes some ten times as long as run, 4 MB, and 13 kB for each 256
 * corrections or 1024 rows. Errors: as of run, OUT_OF_MEMORY. */
HNAV_API hnav_status hnav_ins_smooth(hnav_ins* ins, size_t n, const hnav_ins_run_input* input, const hnav_ins_run_output* output);

/* ------------------------------------------------------------------------------------------------ hybrid view */

/* The same filter for callers that bring their own integrator (FMI Model Exchange): x' = f(x) between events, x+ = jump(x-) at an
 * event. States in Earth-fixed axes, north-east-down at an anchor near the body: displacement from it in m 3, velocity in m/s 3,
 * quaternion body to these axes 4. They flow from the tilt on; while the heading is unknown the axes are turned about the vertical
 * by what is unknown, and an event may turn them or move the anchor. Between events navigation tells place, velocity and attitude
 * of x, and all else as at the last event. With horizon_s above 0, when late samples are taken, the filter integrates inside from event
 * to event as advance does, and x_plus is its estimate whatever x_minus is. Not to be mixed with advance, run or smooth. */
HNAV_API hnav_status hnav_ins_nx(const hnav_ins* ins, int32_t* nx);
/* The state just after the last jump. */
HNAV_API hnav_status hnav_ins_get_x(const hnav_ins* ins, double* x);
/* Sizes to scale tolerances by: 1. */
HNAV_API hnav_status hnav_ins_nominal_x(const hnav_ins* ins, double* nominal_x);
/* Pure: changes nothing. Smooth in x and the same at all t_s, also beyond the next event. */
HNAV_API hnav_status hnav_ins_derivative(const hnav_ins* ins, double t_s, const double* x, double* dx);
/* Exact directional derivative of f: out = (df/dx) seed. Pure. */
HNAV_API hnav_status hnav_ins_derivative_along(const hnav_ins* ins, double t_s, const double* x, const double* seed, double* out);
/* Time of the earliest waiting sample, infinity if none waits. */
HNAV_API hnav_status hnav_ins_next_event_s(const hnav_ins* ins, double* t_s);
/* Applies the waiting samples of times up to t_s to the state x_minus at t_s and commits. A rate that is the mean of the interval
 * before it is put into that interval here. SOLVER: they led to no usable estimate and were dropped. */
HNAV_API hnav_status hnav_ins_jump(hnav_ins* ins, double t_s, const double* x_minus, double* x_plus);
/* Lets navigation show x at t_s. Errors of jump and show: NON_FINITE, OUT_OF_RANGE (beyond 1e50, or a quaternion of no length). */
HNAV_API hnav_status hnav_ins_show(hnav_ins* ins, double t_s, const double* x);

/* How what flows of hnav_navigation changes with x. */
typedef struct hnav_navigation_along {
    size_t size; /* of this struct; set by the caller */
    double latitude_rad, longitude_rad, height_m;
    double velocity_n_m_s[3];
    double q_nb[4];
    double euler_rad[3];
} hnav_navigation_along;
/* Exact derivatives along the direction `seed` of x, at the x that hnav_ins_show lets it show; 0 before there is a tilt. At a pole
 * the longitude has none, and is answered by 0. Errors: SIZE. */
HNAV_API hnav_status hnav_ins_navigation_along(const hnav_ins* ins, const double* seed, hnav_navigation_along* along);

/* ------------------------------------------------------------------------------------------------ save and load */

/* Numbers only; fits filters made with equal options, which go on bit for bit. */
HNAV_API hnav_status hnav_ins_state_size(const hnav_ins* ins, size_t* bytes);
HNAV_API hnav_status hnav_ins_save(const hnav_ins* ins, void* buffer, size_t bytes);
/* SIZE, STATE_CORRUPT, STATE_VERSION: the filter is as it was. */
HNAV_API hnav_status hnav_ins_load(hnav_ins* ins, const void* buffer, size_t bytes);

#ifdef __cplusplus
}
#endif

#endif /* HNAV_INS_H */
