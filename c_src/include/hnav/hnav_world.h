/* hnav_world: truth and sensor models to drive filters with. Conventions, status codes and promises are those of hnav.h,
 * but for its stability: names here may change between minor versions.
 *
 * Noise is a function of seed, source and sample: equal seeds give equal runs on one machine, whatever else is simulated
 * beside. */
#ifndef HNAV_WORLD_H
#define HNAV_WORLD_H

#include "hnav/hnav.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ aircraft with an INS
 *
 * A linear aircraft whose states an INS reads with white noise v and time-correlated errors lambda:
 *
 *     dx/dt = A x + B u + w                    u held from sample to sample
 *     z(k) = x(k) + v(k) + lambda(k)           k = 0, 1, ... at the times k interval_s
 *
 * lambda is the sum of two first-order Gauss-Markov errors, of the accelerometers and of the gravity model. Units are
 * the model's. Source: Hajiyev and Hacizade, WSEAS Trans. Systems and Control 18, 2023, doi 10.37394/23203.2023.18.51.
 *
 *     hnav_aircraft *aircraft;
 *     hnav_aircraft_options options = hnav_aircraft_defaults();
 *     hnav_aircraft_create(&aircraft, &options, &model, message, sizeof message);
 *     for (;;) {
 *         hnav_aircraft_get_sample(aircraft, &sample);
 *         hnav_aircraft_step(aircraft, NULL);
 *     } */
typedef struct hnav_aircraft hnav_aircraft;

typedef struct hnav_gauss_markov { /* stationary, one process for each channel */
    const double *sigma;           /* nx, standard deviations, >= 0; null: none */
    const double *time_constant_s; /* nx, above 0; not read when sigma is null */
} hnav_gauss_markov;

typedef struct hnav_square_wave { /* amplitude times the sign of sin(2 pi t / period + phase) */
    double amplitude;
    double period_s; /* above 0 */
    double phase_rad;
} hnav_square_wave;

typedef struct hnav_noise_fault { /* samples from start_s to stop_s, both included */
    double start_s, stop_s;
    double factor; /* on the standard deviation of v, >= 0; 1: no fault */
} hnav_noise_fault;

/* Row-major, owned by the caller, copied by create. */
typedef struct hnav_aircraft_model {
    int32_t nx, nu;                         /* 1 to 32, 0 to 32 */
    double interval_s;                      /* between samples, above 0 */
    const double *A_1_s;                    /* nx x nx; no eigenvalue with a real part above 1e-9 1/s */
    const double *B_1_s;                    /* nx x nu; not read when nu = 0 */
    const double *process_noise_per_sqrt_s; /* nx, standard deviations of w per root second, >= 0 */
    const double *measurement_sigma;        /* nx, of v, >= 0 */
    hnav_gauss_markov accelerometer_error, gravity_error;
    const double *start;                    /* nx, mean of x(0); null: zero */
    const double *start_sigma;              /* nx, >= 0 */
    const hnav_square_wave *commands;       /* nu, added to the commands of step; null: none */
    const hnav_noise_fault *faults;         /* nx; null: none */
} hnav_aircraft_model;

typedef struct hnav_aircraft_options {
    uint64_t cookie;             /* set by hnav_aircraft_defaults */
    uint64_t seed;
    int32_t euler_colour;        /* 1: lambda by 1 - dt/tau, as the paper prints; 0: exact, exp(-dt/tau) */
    int32_t exact_process_noise; /* 1: w integrated over the interval, which correlates the states (Van Loan 1978);
                                    0: independent noise of variance density times interval */
} hnav_aircraft_options;

/* Seed 0, exact colour, independent noise. */
HNAV_API hnav_aircraft_options hnav_aircraft_defaults(void);

/* Refused, with a message that names the entry: sizes out of range (SIZE), null (NULL_ARGUMENT) or non-finite
 * (NON_FINITE) entries; numbers out of range, an A that grows, dt/tau of 2 or more in Euler's form (all OPTION). */
HNAV_API hnav_status hnav_aircraft_create(hnav_aircraft **aircraft, const hnav_aircraft_options *options,
                                          const hnav_aircraft_model *model, char *message, size_t message_size);
/* Null is allowed. */
HNAV_API void hnav_aircraft_destroy(hnav_aircraft *aircraft);
/* Back to sample 0 of the same flight. */
HNAV_API hnav_status hnav_aircraft_reset(hnav_aircraft *aircraft);
/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char *hnav_aircraft_message(const hnav_aircraft *aircraft);

/* To the next sample; command (nu, null for zero) is held meanwhile. NON_FINITE: nothing has moved. */
HNAV_API hnav_status hnav_aircraft_step(hnav_aircraft *aircraft, const double *command);

/* Of the present sample; null pointers are not written. */
typedef struct hnav_aircraft_sample {
    uint64_t k;           /* counted from 0 */
    double t_s;           /* k interval_s */
    double *x;            /* nx, truth */
    double *lambda;       /* nx, coloured error, both parts */
    double *z;            /* nx, measurement */
    double *u;            /* nu, controls that were held up to this sample; zero at k = 0 */
    double *noise_factor; /* nx, on the standard deviation of v; 1 without fault */
} hnav_aircraft_sample;
HNAV_API hnav_status hnav_aircraft_get_sample(const hnav_aircraft *aircraft, hnav_aircraft_sample *sample);

/* n samples from the present one on, each a row: command n x nu (null for zero), row k held from sample k to k + 1;
 * arrays of output hold n rows each, k and t_s those of the last. Afterwards the sample after the last row is present. */
HNAV_API hnav_status hnav_aircraft_run(hnav_aircraft *aircraft, size_t n, const double *command, hnav_aircraft_sample *output);

/* The discrete model for hnav_ins_error_filter_create; its pointers belong to the aircraft and live as long. lambda of
 * the filter is the accelerometer error alone: a sum of two such processes is none. */
HNAV_API hnav_status hnav_aircraft_filter_model(const hnav_aircraft *aircraft, hnav_ins_error_model *model);

/* Numbers only; fits aircraft made with equal options and model. */
HNAV_API hnav_status hnav_aircraft_state_size(const hnav_aircraft *aircraft, size_t *bytes);
HNAV_API hnav_status hnav_aircraft_save(const hnav_aircraft *aircraft, void *buffer, size_t bytes);
/* SIZE, STATE_CORRUPT: the aircraft is as it was. */
HNAV_API hnav_status hnav_aircraft_load(hnav_aircraft *aircraft, const void *buffer, size_t bytes);

#ifdef __cplusplus
}
#endif
#endif
