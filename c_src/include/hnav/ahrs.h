/* AHRS: attitude and heading from gyroscope, accelerometer and magnetometer. hnav.h has an example, filter.h the calls that all
 * filters share. The HREKF has the calls of the sections recordings and beside the estimate too. */
#ifndef HNAV_AHRS_H
#define HNAV_AHRS_H

#include "hnav/filter.h"
#include "hnav/options/ahrs.h"

#ifdef __cplusplus
extern "C" {
#endif

/* preset: HNAV_PRESET_DEFAULT. */
HNAV_API hnav_ahrs_options hnav_ahrs_defaults(hnav_preset preset);
/* Makes an AHRS. On failure *filter is null and message (may be null) has the reason. */
HNAV_API hnav_status hnav_ahrs_create(hnav_filter** filter, const hnav_ahrs_options* options, char* message, size_t message_size);

/* The same in the caller's memory, without any allocation; requires solver = HNAV_SOLVER_CLOSED_FORM.
 * bytes: at least the result of hnav_ahrs_memory_bytes for the options (0 for invalid options), with any alignment.
 * The caller may reuse the memory when the filter is no longer used.
 * Errors beside those of create: SIZE, UNSUPPORTED (another solver). */
HNAV_API size_t hnav_ahrs_memory_bytes(const hnav_ahrs_options* options);
HNAV_API hnav_status hnav_ahrs_create_in(void* memory, size_t bytes, hnav_filter** filter, const hnav_ahrs_options* options,
                                         char* message, size_t message_size);

/* Initialises the attitude again from the next samples; keeps the gyro bias and the counters. */
HNAV_API hnav_status hnav_filter_realign(hnav_filter* filter);

/* ------------------------------------------------------------------------------------------------ recordings */

/* Arrays in, arrays out: n rows, each one instant. A row of accel or mag with a NaN is a missing sample, as is a null
 * pointer; a null output is not written. A sample that push refuses for its value (NON_FINITE, ZERO_VECTOR, OUT_OF_RANGE)
 * is counted and not used. Equal, bit for bit, to push and advance row by row. */
typedef struct hnav_run_input {
    size_t size; /* of this struct; set by the caller */
    const double* t_s; /* n, not decreasing */
    const double* rate_b_rad_s; /* n x 3, may be null */
    const double* force_b_m_s2; /* n x 3, may be null */
    const double* field_b_tesla; /* n x 3, may be null */
    const double* speed_m_s; /* n, along body x, may be null; NaN: none. AHRS only */
    const double* speed_sigma_m_s; /* n; needed with speed_m_s */
} hnav_run_input;

typedef struct hnav_run_output {
    size_t size; /* of this struct; set by the caller */
    double* q_nb; /* n x 4; NaN before the start */
    double* euler_rad; /* n x 3: roll, pitch, yaw */
    double* sigma_rad; /* n x 3: rotation error about the navigation axes */
    double* gyro_bias_rad_s; /* n x 3 */
    double* gyro_bias_sigma_rad_s; /* n x 3 */
    double* accel_nis; /* n; NaN where no sample was used */
    double* mag_nis; /* n */
    uint8_t* ready; /* n x 2: tilt, heading */
    uint8_t* health; /* n x 3: hnav_sensor_state of gyro, accel, mag */
    uint8_t* accepted; /* n x 2: accel, mag; 1 where a sample of this row corrected with the stated noise */
} hnav_run_output;

/* rows_done (may be null): rows that are complete; less than n only after an error. */
HNAV_API hnav_status hnav_filter_run(hnav_filter* filter, size_t n, const hnav_run_input* input, const hnav_run_output* output,
                                     size_t* rows_done);

/* Smoother on the same arrays: forward, then twice backward and forward, each pass started from the end of the previous
 * one, the last two fused by their covariances. Every row has an attitude. sigma_rad includes errors common to both passes.
 * ready is that of the pass with the smaller sigma. Uses the closed form for any solver. Takes 5 times as long as run with the
 * closed form, and memory for its rows. The filter is reset before and after. Errors: as run;
 * UNSUPPORTED (the HREKF), NOT_STARTED, OUT_OF_MEMORY. */
HNAV_API hnav_status hnav_filter_smooth(hnav_filter* filter, size_t n, const hnav_run_input* input,
                                        const hnav_run_output* output);

/* ------------------------------------------------------------------------------------------------ beside the estimate */

/* The estimate just after the newest sample up to the last advance. Error: NOT_STARTED. */
typedef struct hnav_posterior {
    size_t size; /* of this struct; set by the caller */
    double t_s;
    double q_nb[4];
    double gyro_bias_rad_s[3];
    double sigma[6]; /* three rotations about the navigation axes in rad, three biases in rad/s */
    int32_t near_singular; /* as in hnav_attitude */
    int32_t tilt_ready;
    int32_t heading_ready;
    int32_t reserved; /* 0 */
} hnav_posterior;
HNAV_API hnav_status hnav_filter_posterior(const hnav_filter* filter, hnav_posterior* posterior);

/* The reference field and the gate, just after the newest used sample. */
typedef enum hnav_field_gate {
    HNAV_FIELD_ACCEPTED = 0,
    HNAV_FIELD_REJECTED = 1, /* not used: it deviates from the reference */
    HNAV_FIELD_INFLATED = 2 /* used with inflated noise although it deviates */
} hnav_field_gate;

typedef struct hnav_field {
    size_t size; /* of this struct; set by the caller */
    double strength_tesla; /* of the reference; NaN while there is none */
    double dip_rad;
    double latency_s; /* estimated delay of the magnetometer behind its time stamps (ahrs) */
    double latency_sigma_s;
    double evidence_s; /* time for which the field agreed with the reference, weighted less at rest (ahrs) */
    double heading_trust_s; /* the same for the heading, through changes of reference (ahrs) */
    int32_t reference_changes; /* references taken after the first (ahrs) */
    int32_t gate; /* hnav_field_gate of the last field */
    int32_t at_rest; /* the body lies still (ahrs) */
    int32_t reserved; /* 0 */
} hnav_field;
HNAV_API hnav_status hnav_filter_field(const hnav_filter* filter, hnav_field* field);

/* Scale and misalignment S of the gyroscope, rate = (I - S) reading - bias, row-major, and the sigma of each; zero in
 * filters that do not estimate it. */
HNAV_API hnav_status hnav_filter_gyro_calibration(const hnav_filter* filter, double matrix[9], double sigma[9]);

/* Directional derivatives of the outputs by x. */
typedef struct hnav_shown_along {
    size_t size; /* of this struct; set by the caller */
    double q_nb[4];
    double euler_rad[3];
    double heading_rad;
    double sigma_rad[3];
    double rate_b_rad_s[3];
    double gyro_bias_rad_s[3];
    double gyro_bias_sigma_rad_s[3];
    double covariance[36]; /* of (rotation about the navigation axes, gyro bias), row-major */
} hnav_shown_along;
/* Exact derivatives of attitude, rate, gyro_bias and covariance along the direction `seed` of x, at the x of
 * hnav_filter_show. Before the attitude is initialised all are 0 except those of the bias. Error: SIZE. */
HNAV_API hnav_status hnav_filter_shown_along(const hnav_filter* filter, const double* seed, hnav_shown_along* along);

#ifdef __cplusplus
}
#endif

#endif /* HNAV_AHRS_H */
