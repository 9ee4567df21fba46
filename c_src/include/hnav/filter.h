/* One filter: the calls that the AHRS, the HREKF, the INS and the observer share. ahrs.h, hrekf.h, ins.h and observer.h have the create
 * calls, and calls of one of them, which return UNSUPPORTED for the others.
 *
 * Push samples as they arrive; advance computes the estimate at a time; the calls of the section estimate return it. */
#ifndef HNAV_FILTER_H
#define HNAV_FILTER_H

#include "hnav/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ life */

typedef struct hnav_filter hnav_filter;

/* Null is allowed. A filter in the caller's memory needs no call. */
HNAV_API void hnav_filter_destroy(hnav_filter* filter);

/* Restores the state after create: no samples, no estimate, counters zero. */
HNAV_API hnav_status hnav_filter_reset(hnav_filter* filter);

/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char* hnav_filter_message(const hnav_filter* filter);

/* ------------------------------------------------------------------------------------------------ samples */

/* Sensor of a sample. In AHRS and HREKF, samples of equal time act in this order. */
typedef enum hnav_sensor {
    HNAV_SENSOR_GYRO = 0,
    HNAV_SENSOR_ACCEL = 1,
    HNAV_SENSOR_MAG = 2,
    HNAV_SENSOR_HEADING = 3,
    HNAV_SENSOR_SPEED = 4, /* AHRS and INS */
    HNAV_SENSOR_REST = 5, /* from here on: INS */
    HNAV_SENSOR_PRESSURE = 6,
    HNAV_SENSOR_VELOCITY = 7,
    HNAV_SENSOR_POSITION = 8
} hnav_sensor;
enum { HNAV_SENSOR_COUNT = 9 };

/* Samples may arrive in any order within one instant and between two advance calls, and up to horizon_s late after. Samples of one
 * sensor with the same stamp (a FIFO) are spread over the time since the previous stamp; the first burst determines their number. A
 * sensor whose stamps run back by more than time_jump_limit_s begins a new time base. A single stamp ten times as far ahead is
 * rejected (OK, counted in hnav_health). Errors: NON_FINITE, ZERO_VECTOR, OUT_OF_RANGE (rates beyond 1e4 rad/s, others beyond 1e6
 * in any unit, a sigma that is not positive, a place that does not exist), LATE_SAMPLE, QUEUE_FULL, UNSUPPORTED (the filter does
 * not use this sensor); the sample is dropped and counted.
 *
 * AHRS and HREKF correct by samples of equal time together. The INS takes rate and force together, by push_imu. */
HNAV_API hnav_status hnav_filter_push_gyro(hnav_filter* filter, double t_s, const double rate_b_rad_s[3]);
HNAV_API hnav_status hnav_filter_push_accel(hnav_filter* filter, double t_s, const double force_b_m_s2[3]);
/* INS: any unit; the field corrects the heading only (option declination_rad), iron in the body is estimated, and at most one sample for
 * each correction_interval_s is used. */
HNAV_API hnav_status hnav_filter_push_mag(hnav_filter* filter, double t_s, const double field_b_tesla[3]);
HNAV_API hnav_status hnav_filter_push_imu(hnav_filter* filter, double t_s, const double rate_b_rad_s[3],
                                          const double force_b_m_s2[3]); /* both or neither */
/* heading_rad: heading of body x, clockwise from north; sigma_rad: its standard deviation. AHRS and HREKF: true heading. INS: the option
 * declination_rad is added. */
HNAV_API hnav_status hnav_filter_push_heading(hnav_filter* filter, double t_s, double heading_rad, double sigma_rad);
/* sigma_n_m: north, east, down, as stated by the receiver: sigma of white noise, and of a slowly varying error with the time
 * constant position_colour_s. */
HNAV_API hnav_status hnav_filter_push_position(hnav_filter* filter, double t_s, double latitude_rad, double longitude_rad,
                                               double height_m, const double sigma_n_m[3]);
/* Velocity down: NaN if it is not measured. */
HNAV_API hnav_status hnav_filter_push_velocity(hnav_filter* filter, double t_s, const double velocity_n_m_s[3],
                                               const double sigma_n_m_s[3]);
HNAV_API hnav_status hnav_filter_push_pressure(hnav_filter* filter, double t_s, double pressure_pa, double sigma_pa);
/* Speed along body x. INS: of wheels; used once the heading has been found. AHRS: by GNSS, wheels or airspeed, of a body that moves where
 * body x points (options speed_slip_rad, max_speed_age_s), beyond 1e4 m/s OUT_OF_RANGE; its accelerations then do not tilt the horizon. */
HNAV_API hnav_status hnav_filter_push_speed(hnav_filter* filter, double t_s, double speed_m_s, double sigma_m_s);
/* The body is at rest. */
HNAV_API hnav_status hnav_filter_push_rest(hnav_filter* filter, double t_s, double sigma_m_s);

/* Uses the samples up to t_s and predicts the estimate to t_s. Errors: NON_FINITE, OUT_OF_RANGE, TIME_BACKWARDS; SOLVER: samples
 * without a usable estimate were dropped, the others were used. */
HNAV_API hnav_status hnav_filter_advance(hnav_filter* filter, double t_s);
/* The same without the prediction to t_s, for callers that do not read the estimate at every step. Until hnav_filter_advance(filter, t_s)
 * the estimate is that just after the newest sample. Later estimates are the same, bit for bit. */
HNAV_API hnav_status hnav_filter_commit(hnav_filter* filter, double t_s);

/* ------------------------------------------------------------------------------------------------ estimate */

/* Everything below is at the time of the last advance unless stated otherwise. */
typedef struct hnav_attitude {
    size_t size; /* of this struct; set by the caller */
    double t_s;
    double q_nb[4];
    double euler_rad[3]; /* roll, pitch, yaw of body in navigation axes, rotation order z y x */
    double heading_rad; /* true heading of body x, clockwise from north, (-pi, pi], whatever the frame */
    double sigma_rad[3]; /* standard deviation of the rotation error about the navigation axes; the third is heading */
    int32_t near_singular; /* pitch beyond 85 deg: roll and yaw are ill defined */
    int32_t tilt_ready;
    int32_t heading_ready;
} hnav_attitude;

/* Errors: NOT_STARTED before the attitude is initialised; UNSUPPORTED for the observer (also the next two). */
HNAV_API hnav_status hnav_filter_attitude(const hnav_filter* filter, hnav_attitude* attitude);
/* Rate minus bias, and bias; before the start zero rate and the start value of the bias. */
HNAV_API hnav_status hnav_filter_rate(const hnav_filter* filter, double rate_b_rad_s[3]);
HNAV_API hnav_status hnav_filter_gyro_bias(const hnav_filter* filter, double bias_b_rad_s[3], double sigma_rad_s[3]);

/* Covariance of the errors, row-major. Error: NOT_STARTED.
 *     AHRS, HREKF  6 x 6: rotation about the navigation axes in rad, gyro bias in rad/s; q_true is exp(rotation / 2) times q_nb
 *     INS          15 x 15: position, velocity (north, east, down), rotation about them, gyro bias, accelerometer bias
 *     observer     N x N */
HNAV_API hnav_status hnav_filter_covariance(const hnav_filter* filter, double* covariance);

/* Innovation of the last used sample of a sensor. Direction and field are dimensionless, headings in rad, positions and velocities of the
 * INS in m and m/s, north, east, down. */
typedef struct hnav_innovation {
    size_t size; /* of this struct; set by the caller */
    double t_s;
    double value[3]; /* ahrs, force and speed: of the velocity in m/s, north and east; field: in navigation axes */
    double S[9]; /* its covariance, with the stated noise (not inflated); INS: the diagonal */
    double nis; /* value' S^-1 value */
    double noise_scale; /* trace of the noise used over that of the stated noise; 1 unless the gate inflated it */
    int32_t dimension; /* 3; 1 for heading; 2 for force and speed of the AHRS, whose S has 2 or 3 rows of 3 */
    int32_t accepted; /* 0 when the gate inflated the noise or rejected the sample (noise_scale infinite) */
} hnav_innovation;
/* Errors: NO_DATA, OUT_OF_RANGE (the gyroscope has none), UNSUPPORTED (the observer has hnav_observer_innovation). */
HNAV_API hnav_status hnav_filter_innovation(const hnav_filter* filter, hnav_sensor sensor, hnav_innovation* innovation);

typedef struct hnav_diagnostics {
    size_t size; /* of this struct; set by the caller */
    double gamma_used; /* of the last correction; infinity when off */
    double gamma_margin; /* 1 - lmax(L P L') / gamma^2: 1 when off, above 0 always */
    double adapted_bias_walk_rad_s_per_sqrt_s; /* root of the mean of the diagonal of Q on the bias, times one second */
    double newest_sample_s; /* time of the newest used sample; NaN if there was none */
    uint64_t used[HNAV_SENSOR_COUNT]; /* samples used, by sensor */
    uint64_t gated[HNAV_SENSOR_COUNT]; /* of those, with inflated noise; INS: or rejected, for example without a heading */
    uint64_t late; /* refused: older than the committed estimate */
    uint64_t non_finite; /* refused: NaN, infinity, rates beyond 1e4 rad/s, others beyond 1e6 in any unit, 1e12 s */
    uint64_t zero; /* refused: zero vector */
    uint64_t corrections;
    uint64_t gamma_raised; /* corrections whose gamma was infeasible and was raised */
    uint64_t covariance_repaired;
    uint64_t solver_rhs_evals;
    uint64_t solver_steps;
    int32_t started; /* there is an attitude */
    int32_t waiting; /* instants in the queue after the time of the last advance */
    /* Decay rate of an error by the last correction and the flow before it, 1/s: for two estimates with its gains that
     * differ by e, sqrt(e' P^-1 e) falls at least by exp(-rate T), P being the covariance after each correction.
     * -ln |L_k^-1 M_k L_k-1| / T_k with P_k = L_k L_k' and M_k = J (I - K_k H_k) Phi_k, the sampled-data form of the
     * paper's Theorem 1 (decay_rate.hpp). It is a value for one correction, not a certificate (`hnav certify`).
     * 0 before the first correction after a start, while P is singular, and in the AHRS, which does not compute it. */
    double decay_rate_1_s;
    /* INS; NaN in the others. */
    double mean_nis; /* over dimension, of recent GNSS samples and rests; above 1 the sigmas are too small */
    double gyro_vibration_rad_s, accel_vibration_m_s2; /* root mean square between neighbouring samples */
} hnav_diagnostics;
HNAV_API hnav_status hnav_filter_diagnostics(const hnav_filter* filter, hnav_diagnostics* diagnostics);

/* ------------------------------------------------------------------------------------------------ health */

typedef struct hnav_health {
    size_t size; /* of this struct; set by the caller */
    hnav_sensor_health sensor[HNAV_SENSOR_COUNT];
    uint64_t times_lost; /* initialisations of the attitude after it was lost: contradicted by the force, or a long gap */
    uint64_t clock_jumps; /* new time bases after stamps ran back */
    uint64_t stamps_left_out; /* samples rejected because their stamp was far ahead of all others */
    int32_t lost; /* the attitude is being initialised again: nothing is ready */
    int32_t reserved; /* 0 */
} hnav_health;
HNAV_API hnav_status hnav_filter_health(const hnav_filter* filter, hnav_health* health);

/* ------------------------------------------------------------------------------------------------ save, load */

/* A saved state contains numbers only (no solver history, no pointers). Any filter with the same model and options, in this
 * or another process, can load it and continues bit for bit. Refused (UNSUPPORTED) for an observer of an FMU with events
 * that cannot serialise its state: take a snapshot. */
HNAV_API hnav_status hnav_filter_state_size(const hnav_filter* filter, size_t* bytes);
HNAV_API hnav_status hnav_filter_save(const hnav_filter* filter, void* buffer, size_t bytes);
/* Errors: SIZE, STATE_CORRUPT, STATE_VERSION; the filter is then unchanged. */
HNAV_API hnav_status hnav_filter_load(hnav_filter* filter, const void* buffer, size_t bytes);

/* Snapshots take about a microsecond and serve to step back. They are valid in this process, for this filter or one with equal options;
 * those of an observer for that observer only. Their size depends on the waiting samples and on those that late ones may still join:
 * query it each time. A snapshot has no checksum, and that the options are equal is not checked: hnav_filter_load checks both. Error:
 * STATE_CORRUPT (not of such a filter, which is then unchanged). */
HNAV_API hnav_status hnav_filter_snapshot_size(const hnav_filter* filter, size_t* bytes);
HNAV_API hnav_status hnav_filter_take_snapshot(const hnav_filter* filter, void* buffer, size_t bytes);
HNAV_API hnav_status hnav_filter_restore_snapshot(hnav_filter* filter, const void* buffer, size_t bytes);
/* Call it once for each snapshot of an observer of an FMU: the FMU keeps its state until then. No effect for other filters. */
HNAV_API hnav_status hnav_filter_release_snapshot(const hnav_filter* filter, const void* buffer, size_t bytes);

/* ------------------------------------------------------------------------------------------------ hybrid view */

/* The same filter for callers that bring their own integrator (FMI Model Exchange): x' = f(x) between events, x+ = jump(x-) at an
 * event. Not to be combined with advance or run, nor, in the HREKF, with the backward gyro hold. AHRS and INS apply the rate of a
 * backward sample to the interval before it at the jump. States:
 *     AHRS, HREKF
 *               q 4 (north-east-down of magnetic north to body, before the interface rotations),
 *               the integral of its rotation matrix since the last correction 9 (column by column), the time since then; they
 *               determine the covariance
 *     INS       in Earth-fixed axes, north-east-down at an anchor near the body: displacement from it in m 3, velocity in m/s 3,
 *               quaternion body to these axes 4. They flow once there is a tilt. While the heading is unknown, the axes are turned
 *               about the vertical by the unknown angle; an event may turn them or move the anchor. With horizon_s above 0 the filter
 *               integrates inside from event to event as advance does, and x_plus is its estimate for any x_minus
 *     observer  the plant's states and the unknown inputs, their rows of the transition matrix since the last jump (row-major, N
 *               columns), the accumulated process noise (upper triangle of N x N, in units that change with jumps), and the time
 *               since. Events of the plant are jumps too: where one of its indicators leaves its domain (above 0 or not), or at
 *               next_event_s. The estimate is then a single Gaussian, without hypotheses and sigma points */
HNAV_API hnav_status hnav_filter_nx(const hnav_filter* filter, int32_t* nx);
/* The state just after the last jump. */
HNAV_API hnav_status hnav_filter_get_x(const hnav_filter* filter, double* x);
/* Scales for tolerances, from the present sigmas, all positive. */
HNAV_API hnav_status hnav_filter_nominal_x(const hnav_filter* filter, double* nominal_x);
/* Changes no state. Smooth in t_s and x, also beyond the next event. 0 before there is an estimate. Error: SOLVER (the plant of an observer
 * has no answer there). */
HNAV_API hnav_status hnav_filter_derivative(const hnav_filter* filter, double t_s, const double* x, double* dx);
/* Exact directional derivative of f: out = (df/dx) seed. Changes no state. Error: UNSUPPORTED (observer). */
HNAV_API hnav_status hnav_filter_derivative_along(const hnav_filter* filter, double t_s, const double* x, const double* seed,
                                                  double* out);
/* Time of the earliest waiting sample or of the plant's next time event; infinity without either. */
HNAV_API hnav_status hnav_filter_next_event_s(const hnav_filter* filter, double* t_s);
/* Applies the plant's events at t_s and the waiting samples of times up to t_s to the state x_minus at t_s and commits. Error: SOLVER
 * (no usable estimate; they were dropped). x_plus may be x_minus. */
HNAV_API hnav_status hnav_filter_jump(hnav_filter* filter, double t_s, const double* x_minus, double* x_plus);
/* Sets x at t_s for the section estimate. Errors of jump and show: NON_FINITE, OUT_OF_RANGE (beyond 1e50, or a zero quaternion). */
HNAV_API hnav_status hnav_filter_show(hnav_filter* filter, double t_s, const double* x);

#ifdef __cplusplus
}
#endif

#endif /* HNAV_FILTER_H */
