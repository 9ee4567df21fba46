/* One filter: the calls that the AHRS, the HREKF, the INS and the observer share. ahrs.h, hrekf.h, ins.h and observer.h make it and
 * have the calls of one of them; those say UNSUPPORTED to the others.
 *
 * Samples are pushed as they come, advance brings the estimate to a time, and the calls of the section estimate show it. */
#ifndef HNAV_FILTER_H
#define HNAV_FILTER_H

#include "hnav/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ life */

typedef struct hnav_filter hnav_filter;

/* Null is allowed. Of a filter in the caller's memory there is nothing to destroy. */
HNAV_API void hnav_filter_destroy(hnav_filter* filter);

/* Back to the moment after create: no samples, no estimate, counters zero. */
HNAV_API hnav_status hnav_filter_reset(hnav_filter* filter);

/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char* hnav_filter_message(const hnav_filter* filter);

/* ------------------------------------------------------------------------------------------------ samples */

/* What a sample is of. AHRS and HREKF: in this order samples of equal time act. */
typedef enum hnav_sensor {
    HNAV_SENSOR_GYRO = 0,
    HNAV_SENSOR_ACCEL = 1,
    HNAV_SENSOR_MAG = 2,
    HNAV_SENSOR_HEADING = 3,
    HNAV_SENSOR_REST = 4, /* from here on: INS */
    HNAV_SENSOR_SPEED = 5,
    HNAV_SENSOR_PRESSURE = 6,
    HNAV_SENSOR_VELOCITY = 7,
    HNAV_SENSOR_POSITION = 8
} hnav_sensor;
enum { HNAV_SENSOR_COUNT = 9 };

/* Samples may come in any order within one instant and between two advance calls, and up to horizon_s late after. Samples of one
 * sensor that share a stamp, as a FIFO hands them over, are spread over the time since the stamp before; the first burst tells how
 * many there are. A sensor whose stamps run back by more than time_jump_limit_s begins a new time base; a single stamp ten times as
 * far ahead is left out (OK, and counted in hnav_health). Errors: NON_FINITE, ZERO_VECTOR, OUT_OF_RANGE (beyond 1e6 in any unit, a
 * sigma that is not positive, a place that does not exist), LATE_SAMPLE, QUEUE_FULL, UNSUPPORTED (the filter has no use for this
 * sensor); the sample is dropped and counted.
 *
 * AHRS and HREKF correct samples of equal time together. The INS takes rate and force together, by push_imu. */
HNAV_API hnav_status hnav_filter_push_gyro(hnav_filter* filter, double t_s, const double rate_b_rad_s[3]);
HNAV_API hnav_status hnav_filter_push_accel(hnav_filter* filter, double t_s, const double force_b_m_s2[3]);
/* Of the INS in any unit: it measures the heading alone, by the option declination_rad; iron in the body is estimated, and of samples
 * that come faster than correction_interval_s some are used. */
HNAV_API hnav_status hnav_filter_push_mag(hnav_filter* filter, double t_s, const double field_b_tesla[3]);
HNAV_API hnav_status hnav_filter_push_imu(hnav_filter* filter, double t_s, const double rate_b_rad_s[3],
                                          const double force_b_m_s2[3]); /* both or neither */
/* heading_rad: heading of body x, clockwise from north; sigma_rad: its standard deviation. AHRS and HREKF: true heading. INS: the option
 * declination_rad is added. */
HNAV_API hnav_status hnav_filter_push_heading(hnav_filter* filter, double t_s, double heading_rad, double sigma_rad);
/* sigma_n_m: north, east, down, as a receiver states it. It is taken for noise, and for the sigma of an error that stays for
 * position_colour_s too. */
HNAV_API hnav_status hnav_filter_push_position(hnav_filter* filter, double t_s, double latitude_rad, double longitude_rad,
                                               double height_m, const double sigma_n_m[3]);
/* down: NaN when it is not known. */
HNAV_API hnav_status hnav_filter_push_velocity(hnav_filter* filter, double t_s, const double velocity_n_m_s[3],
                                               const double sigma_n_m_s[3]);
HNAV_API hnav_status hnav_filter_push_pressure(hnav_filter* filter, double t_s, double pressure_pa, double sigma_pa);
/* Along body x, by wheels; used once the heading is found. */
HNAV_API hnav_status hnav_filter_push_speed(hnav_filter* filter, double t_s, double speed_m_s, double sigma_m_s);
/* The body is known to stand. */
HNAV_API hnav_status hnav_filter_push_rest(hnav_filter* filter, double t_s, double sigma_m_s);

/* Uses the samples up to t_s and shows the estimate at t_s. Errors: NON_FINITE, OUT_OF_RANGE, TIME_BACKWARDS; SOLVER: some
 * of the samples led to no usable estimate and were dropped, the others were used. */
HNAV_API hnav_status hnav_filter_advance(hnav_filter* filter, double t_s);
/* The same without the look-ahead, for callers that do not read the estimate at every step: until hnav_filter_advance(filter, t_s) it is
 * that just after the newest sample. The estimate is the same, bit for bit. */
HNAV_API hnav_status hnav_filter_commit(hnav_filter* filter, double t_s);

/* ------------------------------------------------------------------------------------------------ estimate */

/* Everything below is at the time of the last advance unless it says otherwise. */
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

/* NOT_STARTED before there is an attitude; UNSUPPORTED (this and the next two): the observer. */
HNAV_API hnav_status hnav_filter_attitude(const hnav_filter* filter, hnav_attitude* attitude);
/* Known before the start too: zero rate until the first sample, and the bias to start from. Bias removed. */
HNAV_API hnav_status hnav_filter_rate(const hnav_filter* filter, double rate_b_rad_s[3]);
HNAV_API hnav_status hnav_filter_gyro_bias(const hnav_filter* filter, double bias_b_rad_s[3], double sigma_rad_s[3]);

/* Of the errors, row-major. NOT_STARTED.
 *     AHRS, HREKF  6 x 6: rotation about the navigation axes in rad, gyro bias in rad/s; q_true is exp(rotation / 2) times q_nb
 *     INS          15 x 15: position, velocity (north, east, down), rotation about them, gyro bias, accelerometer bias
 *     observer     N x N */
HNAV_API hnav_status hnav_filter_covariance(const hnav_filter* filter, double* covariance);

/* What the last used sample of a sensor said. Direction and field are dimensionless, headings in rad, positions and velocities of the
 * INS in m and m/s, north east down. */
typedef struct hnav_innovation {
    size_t size; /* of this struct; set by the caller */
    double t_s;
    double value[3]; /* ahrs, force: minus the velocity in m/s, north and east; field: in navigation axes */
    double S[9]; /* its covariance, with the noise that was parametrised (not inflated); INS: the diagonal */
    double nis; /* value' S^-1 value */
    double noise_scale; /* trace of the noise used over that parametrised; 1 unless the gate inflated it */
    int32_t dimension; /* 3; 1 for heading; 2 for the force of the AHRS. The AHRS's S has 2 or 3 rows of 3 */
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
    uint64_t gated[HNAV_SENSOR_COUNT]; /* of those, with inflated noise; INS: or left out, as for want of a heading */
    uint64_t late; /* refused: older than the committed estimate */
    uint64_t non_finite; /* refused: NaN, infinity, beyond 1e6 in any unit or 1e12 s */
    uint64_t zero; /* refused: zero vector */
    uint64_t corrections;
    uint64_t gamma_raised; /* corrections whose gamma was infeasible and had to be raised */
    uint64_t covariance_repaired;
    uint64_t solver_rhs_evals;
    uint64_t solver_steps;
    int32_t started; /* there is an attitude */
    int32_t waiting; /* instants in the queue that are still in the future of the last advance */
    /* Rate at which the last correction and the flow before it make the filter forget: for two estimates with its gains
     * that differ by e, sqrt(e' P^-1 e) falls at least by exp(-rate T), P the covariance after each correction.
     * -ln |L_k^-1 M_k L_k-1| / T_k with P_k = L_k L_k' and M_k = J (I - K_k H_k) Phi_k, the sampled-data form of the
     * paper's Theorem 1 (decay_rate.hpp). 1/s; one correction at a time, hence no certificate: that is `hnav certify`.
     * 0 before the first correction after a start, while P is singular, and in the AHRS, which does not compute it. */
    double decay_rate_1_s;
    /* INS; NaN in the others. */
    double mean_nis; /* over dimension, of the last satellites and rests; above 1 the sigmas are too small */
    double gyro_vibration_rad_s, accel_vibration_m_s2; /* root mean square between neighbouring samples */
} hnav_diagnostics;
HNAV_API hnav_status hnav_filter_diagnostics(const hnav_filter* filter, hnav_diagnostics* diagnostics);

/* ------------------------------------------------------------------------------------------------ health */

typedef struct hnav_health {
    size_t size; /* of this struct; set by the caller */
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
 * and options, in this or another process, and it goes on bit for bit. Refused (UNSUPPORTED) for an observer of an FMU with events
 * that cannot serialise its state: take a snapshot. */
HNAV_API hnav_status hnav_filter_state_size(const hnav_filter* filter, size_t* bytes);
HNAV_API hnav_status hnav_filter_save(const hnav_filter* filter, void* buffer, size_t bytes);
/* SIZE, STATE_CORRUPT, STATE_VERSION: the filter is as it was. */
HNAV_API hnav_status hnav_filter_load(hnav_filter* filter, const void* buffer, size_t bytes);

/* The same in a microsecond, for stepping back: for this filter or one of equal options in this program alone; for this observer
 * alone. The size is that of the samples that wait or may still be joined by late ones: ask for it each time. A snapshot is not
 * checked bit by bit. STATE_CORRUPT: it is none of such a filter, which is as it was. */
HNAV_API hnav_status hnav_filter_snapshot_size(const hnav_filter* filter, size_t* bytes);
HNAV_API hnav_status hnav_filter_take_snapshot(const hnav_filter* filter, void* buffer, size_t bytes);
HNAV_API hnav_status hnav_filter_restore_snapshot(hnav_filter* filter, const void* buffer, size_t bytes);
/* Once for each snapshot of an observer of an FMU, which keeps its own states until then; the others have nothing to release. */
HNAV_API hnav_status hnav_filter_release_snapshot(const hnav_filter* filter, const void* buffer, size_t bytes);

/* ------------------------------------------------------------------------------------------------ hybrid view */

/* The same filter for callers that bring their own integrator (FMI Model Exchange): x' = f(x) between events, x+ = jump(x-) at an
 * event. Not to be mixed with advance or run, nor, in the HREKF, with the backward gyro hold; AHRS and INS put the rate of a sample
 * that is the mean of the interval before it into that interval when they jump. States:
 *     HREKF     q 4 (north-east-down of magnetic north to body, before the interface rotations), gyro bias 3, covariance 28 (upper
 *               triangle of the 7 x 7 matrix, row by row)
 *     AHRS      q 4, the integral of its rotation matrix since the last correction 9 (column by column), the time since then; from
 *               these follows the covariance
 *     INS       in Earth-fixed axes, north-east-down at an anchor near the body: displacement from it in m 3, velocity in m/s 3,
 *               quaternion body to these axes 4. They flow from the tilt on; while the heading is unknown the axes are turned about the
 *               vertical by what is unknown, and an event may turn them or move the anchor. With horizon_s above 0 the filter integrates
 *               inside from event to event as advance does, and x_plus is its estimate whatever x_minus is
 *     observer  the plant's states and the unknown inputs, their rows of the transition matrix since the last jump (row-major, N
 *               columns), the noise that has entered since (upper triangle of N x N, in units that change with jumps), and the time
 *               since. Events of the plant are jumps too, where one of its indicators leaves its domain, above 0 or not, or
 *               next_event_s says so; the estimate is one part then: no hypotheses, and no points where an event has no derivative */
HNAV_API hnav_status hnav_filter_nx(const hnav_filter* filter, int32_t* nx);
/* The state just after the last jump. */
HNAV_API hnav_status hnav_filter_get_x(const hnav_filter* filter, double* x);
/* Sizes to scale tolerances by, from the present sigmas, all positive. */
HNAV_API hnav_status hnav_filter_nominal_x(const hnav_filter* filter, double* nominal_x);
/* Pure: changes nothing. Smooth in t_s and x, also beyond the next event. 0 before there is an estimate. SOLVER: the plant of an observer
 * has no answer there. */
HNAV_API hnav_status hnav_filter_derivative(const hnav_filter* filter, double t_s, const double* x, double* dx);
/* Exact directional derivative of f: out = (df/dx) seed. Pure. UNSUPPORTED: the observer. */
HNAV_API hnav_status hnav_filter_derivative_along(const hnav_filter* filter, double t_s, const double* x, const double* seed,
                                                  double* out);
/* Time of the earliest waiting sample, or of the plant's next event that time brings; infinity without either. */
HNAV_API hnav_status hnav_filter_next_event_s(const hnav_filter* filter, double* t_s);
/* Applies the plant's events at t_s and the waiting samples of times up to t_s to the state x_minus at t_s and commits. SOLVER: they led to
 * no usable estimate and were dropped. x_plus may be x_minus. */
HNAV_API hnav_status hnav_filter_jump(hnav_filter* filter, double t_s, const double* x_minus, double* x_plus);
/* Lets the estimate show x at t_s. Errors of jump and show: NON_FINITE, OUT_OF_RANGE (beyond 1e50, or a quaternion of no length). */
HNAV_API hnav_status hnav_filter_show(hnav_filter* filter, double t_s, const double* x);

#ifdef __cplusplus
}
#endif

#endif /* HNAV_FILTER_H */
