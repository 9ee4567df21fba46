/* Navigation: position, velocity and attitude from rate, force and aids such as GNSS, pressure and wheels; aligned from
 * any heading, in motion or at rest, without a magnetometer.
 *
 *     hnav_ins_options options = hnav_ins_defaults(HNAV_INS_INDUSTRIAL);
 *     hnav_filter* ins;
 *     hnav_attitude attitude = {.size = sizeof attitude};
 *     hnav_navigation now = {.size = sizeof now};
 *     hnav_ins_create(&ins, &options, NULL, 0);
 *     while (...) {
 *         hnav_filter_push_imu(ins, t_s, rate_b_rad_s, force_b_m_s2);
 *         hnav_filter_push_velocity(ins, fix_s, velocity_n_m_s, velocity_sigma_m_s);
 *         hnav_filter_push_position(ins, fix_s, latitude_rad, longitude_rad, height_m, position_sigma_m);
 *         hnav_filter_advance(ins, t_s);
 *         hnav_filter_attitude(ins, &attitude); // heading_rad, sigma_rad, heading_ready
 *         hnav_ins_navigation(ins, &now);       // place, velocity, biases, their sigmas and flags
 *     }
 *     hnav_filter_destroy(ins);
 *
 * Every sample carries the time at which it was valid. It may arrive up to the option horizon_s later. Samples of one time may
 * arrive in any order. n is north-east-down at the place of the body; heights are above the ellipsoid of
 * WGS 84; sigmas are standard deviations. Other conventions and promises: hnav.h; the calls that all filters share: filter.h. */
#ifndef HNAV_INS_H
#define HNAV_INS_H

#include "hnav/filter.h"
#include "hnav/options/ins.h"

#ifdef __cplusplus
extern "C" {
#endif

/* preset: the grade of the inertial sensor, HNAV_INS_CONSUMER, HNAV_INS_INDUSTRIAL, HNAV_INS_TACTICAL or HNAV_INS_NAVIGATION. */
HNAV_API hnav_ins_options hnav_ins_defaults(hnav_ins_preset preset);
/* Errors: NULL_ARGUMENT, OPTION, OPTIONS_STAMP, OUT_OF_MEMORY. message: for the reason, message_size characters; may be null. */
HNAV_API hnav_status hnav_ins_create(hnav_filter** filter, const hnav_ins_options* options, char* message, size_t message_size);

/* ------------------------------------------------------------------------------------------------ estimate */

typedef enum hnav_ins_phase {
    HNAV_INS_PHASE_WAITING = 0, /* for rate and force */
    HNAV_INS_PHASE_LEVELLING = 1, /* estimates the first tilt, or waits for the first fix */
    HNAV_INS_PHASE_ANY_HEADING = 2, /* all states, and the heading as a density on the circle */
    HNAV_INS_PHASE_NAVIGATING = 3
} hnav_ins_phase;

/* At the time of the last advance; between events of a hybrid view position, velocity and attitude are those of x, all else as at
 * the last event. Before there is a tilt all numbers except t_s are NaN. In ANY_HEADING they are those of the most probable
 * heading. */
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
    double heading_second_rad, heading_second_share; /* the second heading hypothesis and its probability; 0: none */
    double latency_s, sigma_latency_s; /* of GNSS behind its stamps */
    int32_t phase; /* hnav_ins_phase */
    /* 1: a small sigma, with as much information from samples. */
    int32_t tilt_ready, heading_ready, velocity_ready, position_ready;
    int32_t at_rest;
    double gyro_scale[3], sigma_gyro_scale[3]; /* relative excess of the gyroscope's reading over the rate */
    /* Protection levels: bounds that the horizontal and vertical position and the heading exceed for less than 1e-3 of the time,
     * from sigmas and the consistency of GNSS. A spoofed position that drifts slowly is not covered. */
    double protection_m[2], protection_heading_rad;
} hnav_navigation;
/* Errors: SIZE. */
HNAV_API hnav_status hnav_ins_navigation(const hnav_filter* filter, hnav_navigation* navigation);

/* Information about the heading since the start by sensor, in nats: half the logarithm of the ratio of variances. */
typedef struct hnav_observed {
    size_t size; /* of this struct; set by the caller */
    double by_rest, by_speed, by_pressure, by_velocity, by_position, by_heading, by_field;
} hnav_observed;
HNAV_API hnav_status hnav_ins_observed(const hnav_filter* filter, hnav_observed* observed);

/* ------------------------------------------------------------------------------------------------ recordings */

/* n rows of the IMU; a row of NaN has no sample. Aids are sorted by their time of arrival, which is their time of validity
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
    const int32_t* aid_sensor; /* aids: hnav_sensor */
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
    double* protection_m; /* x 2: horizontal, vertical */
    double* protection_heading_rad;
    uint8_t* phase;
    uint8_t* ready; /* x 4: tilt, heading, velocity, position */
    uint8_t* at_rest;
} hnav_ins_run_output;

/* Bit for bit as sample by sample. Unusable samples are counted and rejected. rows_done (may be null): rows of input
 * that are complete; less than n only after an error. */
HNAV_API hnav_status hnav_ins_run(hnav_filter* filter, size_t n, const hnav_ins_run_input* input,
                                  const hnav_ins_run_output* output, size_t* rows_done);

/* Smoother: every row from all samples, each at its time of validity however late it arrived; samples that arrived after the last row
 * are not used. If the heading is found later, rows are NAVIGATING from the first sample of rate and force on, heading_second has
 * share 0, and ready requires a small sigma and the filter's flag in this row or a later one. Rows without a later heading, and the
 * last row, are those of the filter. Uses the closed form for any solver; the filter itself is unchanged.
 * Takes some ten times as long as run, 4 MB, and 13 kB for each 256 corrections or 1024 rows.
 * Errors: as of run, OUT_OF_MEMORY. */
HNAV_API hnav_status hnav_ins_smooth(hnav_filter* filter, size_t n, const hnav_ins_run_input* input,
                                     const hnav_ins_run_output* output);

/* ------------------------------------------------------------------------------------------------ hybrid view */

/* Directional derivatives of the flowing part of hnav_navigation by x. */
typedef struct hnav_navigation_along {
    size_t size; /* of this struct; set by the caller */
    double latitude_rad, longitude_rad, height_m;
    double velocity_n_m_s[3];
    double q_nb[4];
    double euler_rad[3];
} hnav_navigation_along;
/* Exact derivatives along the direction `seed` of x, at the x of hnav_filter_show; 0 before there is a tilt, and 0 for the longitude at a
 * pole. Error: SIZE. */
HNAV_API hnav_status hnav_ins_navigation_along(const hnav_filter* filter, const double* seed, hnav_navigation_along* along);

#ifdef __cplusplus
}
#endif

#endif /* HNAV_INS_H */
