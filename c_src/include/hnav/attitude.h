/* Attitude filters: the AHRS, for real sensors, and the HREKF, the paper's filter. hnav.h has an introduction and an example.
 *
 * One object, hnav_filter, serves both: create chooses the model, samples are pushed as they come, advance brings the
 * estimate to a time, and the calls of the section estimate show it. */
#ifndef HNAV_ATTITUDE_H
#define HNAV_ATTITUDE_H

#include "hnav/options/ahrs.h"
#include "hnav/options/hrekf.h"
#include "hnav/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ options */

/* The AHRS has HNAV_PRESET_DEFAULT alone. */
HNAV_API hnav_ahrs_options hnav_ahrs_defaults(hnav_preset preset);
HNAV_API hnav_hrekf_options hnav_hrekf_defaults(hnav_preset preset);

/* Rows 0, 1, ...; null beyond the last. */
HNAV_API const hnav_option_info* hnav_ahrs_option(int32_t index);
HNAV_API const hnav_option_info* hnav_hrekf_option(int32_t index);
HNAV_API const hnav_preset_info* hnav_ahrs_preset(int32_t index);
HNAV_API const hnav_preset_info* hnav_hrekf_preset(int32_t index);

/* ------------------------------------------------------------------------------------------------ life */

/* One type for every attitude filter; the create call chooses the model. */
typedef struct hnav_filter hnav_filter;

/* Makes the paper's filter. On failure *filter is null and the reason stands in message (may be null). */
HNAV_API hnav_status hnav_hrekf_create(hnav_filter** filter, const hnav_hrekf_options* options, char* message,
                                       size_t message_size);
/* Makes the AHRS. */
HNAV_API hnav_status hnav_ahrs_create(hnav_filter** filter, const hnav_ahrs_options* options, char* message, size_t message_size);

/* The same in memory of the caller's, by the closed form alone (solver = HNAV_SOLVER_CLOSED_FORM): nothing is taken from
 * elsewhere, now or later. bytes: at least those that the call before tells for the options, of any alignment; it tells 0 for
 * options that make no filter. The memory is the caller's again when the filter is no longer used. Errors beside those of
 * create: SIZE, UNSUPPORTED (another solver). */
HNAV_API size_t hnav_ahrs_memory_bytes(const hnav_ahrs_options* options);
HNAV_API hnav_status hnav_ahrs_create_in(void* memory, size_t bytes, hnav_filter** filter, const hnav_ahrs_options* options,
                                         char* message, size_t message_size);
HNAV_API size_t hnav_hrekf_memory_bytes(const hnav_hrekf_options* options);
HNAV_API hnav_status hnav_hrekf_create_in(void* memory, size_t bytes, hnav_filter** filter, const hnav_hrekf_options* options,
                                          char* message, size_t message_size);

/* Null is allowed. Of a filter in the caller's memory there is nothing to destroy. */
HNAV_API void hnav_filter_destroy(hnav_filter* filter);

/* Back to the moment after create: no samples, no estimate, counters zero. */
HNAV_API hnav_status hnav_filter_reset(hnav_filter* filter);

/* Forgets the attitude and starts anew with the next samples; keeps the gyro bias and the counters. */
HNAV_API hnav_status hnav_filter_realign(hnav_filter* filter);

/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char* hnav_filter_message(const hnav_filter* filter);

/* ------------------------------------------------------------------------------------------------ samples */

/* In the order in which samples of equal time act. */
typedef enum hnav_sensor {
    HNAV_SENSOR_GYRO = 0,
    HNAV_SENSOR_ACCEL = 1,
    HNAV_SENSOR_MAG = 2,
    HNAV_SENSOR_HEADING = 3
} hnav_sensor;
enum { HNAV_SENSOR_COUNT = 4 };

/* Samples may come in any order within one instant and between two advance calls, and up to horizon_s late after.
 * Samples of equal time are corrected together: rate, force, field, heading. Samples of one sensor that share a stamp, as
 * a FIFO hands them over, are spread over the time since the stamp before; the first burst tells how many there are. A
 * sensor whose stamps run back by more than time_jump_limit_s begins a new time base; a single stamp ten times as far
 * ahead is left out (OK, and counted in hnav_health). Errors: NON_FINITE, ZERO_VECTOR, OUT_OF_RANGE, LATE_SAMPLE, QUEUE_FULL. */
HNAV_API hnav_status hnav_filter_push_gyro(hnav_filter* filter, double t_s, const double rate_b_rad_s[3]);
HNAV_API hnav_status hnav_filter_push_accel(hnav_filter* filter, double t_s, const double force_b_m_s2[3]);
HNAV_API hnav_status hnav_filter_push_mag(hnav_filter* filter, double t_s, const double field_b_tesla[3]);
HNAV_API hnav_status hnav_filter_push_imu(hnav_filter* filter, double t_s, const double rate_b_rad_s[3],
                                          const double force_b_m_s2[3]); /* both or neither */
/* heading_rad: true heading of body x, clockwise from north; sigma_rad: its standard deviation, above 0, of which at least
 * 1e-9 is used. */
HNAV_API hnav_status hnav_filter_push_heading(hnav_filter* filter, double t_s, double heading_rad, double sigma_rad);

/* Uses the samples up to t_s and shows the estimate at t_s. Errors: NON_FINITE, OUT_OF_RANGE, TIME_BACKWARDS; SOLVER: some
 * of the samples led to no usable estimate and were dropped, the others were used. */
HNAV_API hnav_status hnav_filter_advance(hnav_filter* filter, double t_s);
/* The same without the look-ahead, for callers that do not read attitude, rate and covariance at every step: until
 * hnav_filter_advance(filter, t_s) they are those just after the newest sample. The estimate is the same, bit for bit. */
HNAV_API hnav_status hnav_filter_commit(hnav_filter* filter, double t_s);

/* Arrays in, arrays out: n rows, each one instant. A row of accel or mag with a NaN is a missing sample, as is a
 * null pointer; a null output is not written. A reading that push refuses for its value (NON_FINITE, ZERO_VECTOR,
 * OUT_OF_RANGE) is counted and left out. Equal, bit for bit, to push and advance of row after row. */
typedef struct hnav_run_input {
    size_t size;                 /* of this struct; set by the caller */
    const double* t_s;           /* n, not decreasing */
    const double* rate_b_rad_s;  /* n x 3, may be null */
    const double* force_b_m_s2;  /* n x 3, may be null */
    const double* field_b_tesla; /* n x 3, may be null */
} hnav_run_input;

typedef struct hnav_run_output {
    size_t size;                   /* of this struct; set by the caller */
    double* q_nb;                  /* n x 4; NaN before the start */
    double* euler_rad;             /* n x 3: roll, pitch, yaw */
    double* sigma_rad;             /* n x 3: rotation error about the navigation axes */
    double* gyro_bias_rad_s;       /* n x 3 */
    double* gyro_bias_sigma_rad_s; /* n x 3 */
    double* accel_nis;             /* n; NaN where no sample was used */
    double* mag_nis;               /* n */
    uint8_t* ready;                /* n x 2: tilt, heading */
    uint8_t* health;               /* n x 3: hnav_sensor_state of gyro, accel, mag */
} hnav_run_output;

/* rows_done (may be null): rows that are complete; less than n only after an error. */
HNAV_API hnav_status hnav_filter_run(hnav_filter* filter, size_t n, const hnav_run_input* input, const hnav_run_output* output,
                                     size_t* rows_done);

/* The same arrays with hindsight: forward, then twice backwards and forward, each pass started at the end of the one
 * before, the last two fused by their covariances. Every row has an attitude. sigma_rad holds what both passes share. ready
 * is that of the pass which knows the angle better. Between samples by the closed form, whatever the solver. Takes 5 times
 * as long as run by the closed form, and memory for its rows. The filter is reset before and after. Errors: as run;
 * UNSUPPORTED (the HREKF), NOT_STARTED, OUT_OF_MEMORY. */
HNAV_API hnav_status hnav_filter_smooth(hnav_filter* filter, size_t n, const hnav_run_input* input,
                                        const hnav_run_output* output);

/* ------------------------------------------------------------------------------------------------ estimate */

/* Everything below is at the time of the last advance unless it says otherwise. */
typedef struct hnav_attitude {
    size_t size;           /* of this struct; set by the caller */
    double t_s;
    double q_nb[4];
    double euler_rad[3];   /* roll, pitch, yaw of body in navigation axes, rotation order z y x */
    double heading_rad;    /* true heading of body x, clockwise from north, (-pi, pi], whatever the frame */
    double sigma_rad[3];   /* standard deviation of the rotation error about the navigation axes; the third is heading */
    int32_t near_singular; /* pitch beyond 85 deg: roll and yaw are ill defined */
    int32_t tilt_ready;
    int32_t heading_ready;
} hnav_attitude;

/* NOT_STARTED before there is an attitude. */
HNAV_API hnav_status hnav_filter_attitude(const hnav_filter* filter, hnav_attitude* attitude);
/* Known before the start too: zero rate until the first sample, and the bias to start from. */
HNAV_API hnav_status hnav_filter_rate(const hnav_filter* filter, double rate_b_rad_s[3]); /* bias removed */
HNAV_API hnav_status hnav_filter_gyro_bias(const hnav_filter* filter, double bias_b_rad_s[3], double sigma_rad_s[3]);

/* 6 x 6 covariance of (rotation error about the navigation axes in rad, gyro bias error in rad/s); q_true is
 * exp(rotation error / 2) times q_nb. NOT_STARTED. */
HNAV_API hnav_status hnav_filter_covariance(const hnav_filter* filter, double covariance[36]);

/* The estimate just after the newest sample that is not in the future of the last advance. NOT_STARTED. */
typedef struct hnav_posterior {
    size_t size;           /* of this struct; set by the caller */
    double t_s;
    double q_nb[4];
    double gyro_bias_rad_s[3];
    double sigma[6];       /* three rotations about the navigation axes in rad, three biases in rad/s */
    int32_t near_singular; /* as in hnav_attitude */
    int32_t tilt_ready;
    int32_t heading_ready;
    int32_t reserved;      /* 0 */
} hnav_posterior;
HNAV_API hnav_status hnav_filter_posterior(const hnav_filter* filter, hnav_posterior* posterior);

/* What the last used sample of a sensor said. Direction and field are dimensionless, heading is in rad. */
typedef struct hnav_innovation {
    size_t size;        /* of this struct; set by the caller */
    double t_s;
    double value[3];    /* ahrs, force: minus the velocity in m/s, north and east; field: in navigation axes */
    double S[9];        /* its covariance, with the noise that was parametrised (not inflated) */
    double nis;         /* value' S^-1 value */
    double noise_scale; /* trace of the noise used over that parametrised; 1 unless the gate inflated it */
    int32_t dimension;  /* 3; 1 for heading; 2 for the force of the AHRS. The AHRS's S has 2 or 3 rows of 3 */
    int32_t accepted;   /* 0 when the gate inflated the noise or rejected the sample (noise_scale infinite) */
} hnav_innovation;
/* Errors: NO_DATA, OUT_OF_RANGE (the gyroscope has no innovation). */
HNAV_API hnav_status hnav_filter_innovation(const hnav_filter* filter, hnav_sensor sensor, hnav_innovation* innovation);

/* What the filter holds of the magnetic field, just after the newest used sample. */
typedef enum hnav_field_gate {
    HNAV_FIELD_ACCEPTED = 0,
    HNAV_FIELD_REJECTED = 1, /* not used: it lies away from the reference */
    HNAV_FIELD_INFLATED = 2  /* used with inflated noise although it lies away */
} hnav_field_gate;

typedef struct hnav_field {
    size_t size;               /* of this struct; set by the caller */
    double strength_tesla;     /* of the reference; NaN while there is none */
    double dip_rad;
    double latency_s;          /* estimated delay of the magnetometer behind its time stamps (ahrs) */
    double latency_sigma_s;
    double evidence_s;         /* time for which the reference was seen, counted less at rest (ahrs) */
    double heading_trust_s;    /* the same for the heading, through changes of reference (ahrs) */
    int32_t reference_changes; /* references taken after the first (ahrs) */
    int32_t gate;              /* hnav_field_gate of the last field */
    int32_t at_rest;           /* the body lies still (ahrs) */
    int32_t reserved;          /* 0 */
} hnav_field;
HNAV_API hnav_status hnav_filter_field(const hnav_filter* filter, hnav_field* field);

/* Scale and misalignment S of the gyroscope, rate = (I - S) reading - bias, row-major, and the sigma of each; zero in
 * filters that do not estimate it. */
HNAV_API hnav_status hnav_filter_gyro_calibration(const hnav_filter* filter, double matrix[9], double sigma[9]);

typedef struct hnav_diagnostics {
    size_t size;                               /* of this struct; set by the caller */
    double gamma_used;                         /* of the last correction; infinity when off */
    double gamma_margin;                       /* 1 - lmax(L P L') / gamma^2: 1 when off, above 0 always */
    double adapted_bias_walk_rad_s_per_sqrt_s; /* root of the mean of the diagonal of Q on the bias, times one second */
    double newest_sample_s;                    /* time of the newest used sample; NaN if there was none */
    uint64_t used[HNAV_SENSOR_COUNT];          /* samples used, by sensor */
    uint64_t gated[HNAV_SENSOR_COUNT];         /* of those, with inflated noise */
    uint64_t late;                             /* refused: older than the committed estimate */
    uint64_t non_finite;                       /* refused: NaN, infinity, beyond 1e6 in any unit or 1e12 s */
    uint64_t zero;                             /* refused: zero vector */
    uint64_t corrections;
    uint64_t gamma_raised;                     /* corrections whose gamma was infeasible and had to be raised */
    uint64_t covariance_repaired;
    uint64_t solver_rhs_evals;
    uint64_t solver_steps;
    int32_t started;                           /* there is an attitude */
    int32_t waiting;                           /* instants in the queue that are still in the future of the last advance */
    /* Rate at which the last correction and the flow before it make the filter forget: for two estimates with its gains
     * that differ by e, sqrt(e' P^-1 e) falls at least by exp(-rate T), P the covariance after each correction.
     * -ln |L_k^-1 M_k L_k-1| / T_k with P_k = L_k L_k' and M_k = J (I - K_k H_k) Phi_k, the sampled-data form of the
     * paper's Theorem 1 (decay_rate.hpp). 1/s; one correction at a time, hence no certificate: that is `hnav certify`.
     * 0 before the first correction after a start, while P is singular, and in the AHRS, which does not compute it. */
    double decay_rate_1_s;
} hnav_diagnostics;
HNAV_API hnav_status hnav_filter_diagnostics(const hnav_filter* filter, hnav_diagnostics* diagnostics);

/* ------------------------------------------------------------------------------------------------ health */

typedef struct hnav_health {
    size_t size;                                 /* of this struct; set by the caller */
    hnav_sensor_health sensor[HNAV_SENSOR_COUNT];
    uint64_t times_lost; /* the attitude was found wrong, or a gap was too long, and it was found anew */
    uint64_t clock_jumps; /* stamps ran back: a new time base began */
    uint64_t stamps_left_out; /* samples whose stamp lay far ahead of all others */
    int32_t lost; /* the attitude is being found anew: nothing is ready */
    int32_t reserved; /* 0 */
} hnav_health;
HNAV_API hnav_status hnav_filter_health(const hnav_filter* filter, hnav_health* health);

/* ------------------------------------------------------------------------------------------------ save, load */

/* A saved state is numbers only (no solver history, no pointers): load it into any filter made with the same model
 * and options, in this or another process, and it goes on bit for bit. */
HNAV_API hnav_status hnav_filter_state_size(const hnav_filter* filter, size_t* bytes);
HNAV_API hnav_status hnav_filter_save(const hnav_filter* filter, void* buffer, size_t bytes);
/* SIZE, STATE_CORRUPT, STATE_VERSION: the filter is as it was. */
HNAV_API hnav_status hnav_filter_load(hnav_filter* filter, const void* buffer, size_t bytes);

/* The same in a microsecond, for stepping back: for this filter or one of equal options in this program alone. The size is
 * that of the samples that wait or may still be joined by late ones: ask for it each time. A snapshot is not checked bit by
 * bit. STATE_CORRUPT: it is none of such a filter, which is as it was. */
HNAV_API hnav_status hnav_filter_snapshot_size(const hnav_filter* filter, size_t* bytes);
HNAV_API hnav_status hnav_filter_take_snapshot(const hnav_filter* filter, void* buffer, size_t bytes);
HNAV_API hnav_status hnav_filter_restore_snapshot(hnav_filter* filter, const void* buffer, size_t bytes);

/* ------------------------------------------------------------------------------------------------ hybrid view */

/* The same filter for callers that bring their own integrator (FMI Model Exchange): x' = f(x) between events,
 * x+ = jump(x-) at an event. States of the HREKF: q 4 (north-east-down of magnetic north to body, before the
 * interface rotations), gyro bias 3, covariance 28 (upper triangle of the 7 x 7 matrix, row by row). States of the
 * ahrs: q 4, the integral of its rotation matrix since the last correction 9 (column by column), the time since
 * then; from these follows the covariance. Not to be mixed with advance or run, nor, in the HREKF, with the backward
 * gyro hold; the AHRS puts the rate of a sample into the interval before it when it jumps. */
HNAV_API hnav_status hnav_filter_nx(const hnav_filter* filter, int32_t* nx);
/* The state just after the last jump. */
HNAV_API hnav_status hnav_filter_get_x(const hnav_filter* filter, double* x);
/* Sizes to scale tolerances by, from the present sigmas, all positive. */
HNAV_API hnav_status hnav_filter_nominal_x(const hnav_filter* filter, double* nominal_x);
/* Pure: changes nothing. Smooth in t_s and x, also beyond the next event. */
HNAV_API hnav_status hnav_filter_derivative(const hnav_filter* filter, double t_s, const double* x, double* dx);
/* Exact directional derivative of f: out = (df/dx) seed. Pure. */
HNAV_API hnav_status hnav_filter_derivative_along(const hnav_filter* filter, double t_s, const double* x, const double* seed,
                                                  double* out);
/* Time of the earliest waiting sample, infinity if none waits. */
HNAV_API hnav_status hnav_filter_next_event_s(const hnav_filter* filter, double* t_s);
/* Applies the waiting samples of times up to t_s to the state x_minus at t_s and commits. */
HNAV_API hnav_status hnav_filter_jump(hnav_filter* filter, double t_s, const double* x_minus, double* x_plus);
/* Lets attitude, rate, gyro_bias and covariance show x at t_s. Errors of jump and show: NON_FINITE, OUT_OF_RANGE (beyond
 * 1e50, or a quaternion of no length). */
HNAV_API hnav_status hnav_filter_show(hnav_filter* filter, double t_s, const double* x);

/* How what is shown changes with x. */
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
/* Exact derivatives of attitude, rate, gyro_bias and covariance along the direction `seed` of x, at the x that
 * hnav_filter_show lets them show. Of an attitude that has not been found all are 0 but those of the bias. Errors: SIZE. */
HNAV_API hnav_status hnav_filter_shown_along(const hnav_filter* filter, const double* seed, hnav_shown_along* along);

#ifdef __cplusplus
}
#endif

#endif /* HNAV_ATTITUDE_H */
