/* Coloured INS errors: the state of a linear system from measurements with time-correlated errors, such as those of an INS:
 *
 *     x(k) = A x(k-1) + B u(k-1) + G w(k-1)            w ~ (0, Qw)
 *     z(k) = H x(k) + v(k) + lambda(k)                 v ~ (0, Qv)
 *     lambda(k) = An lambda(k-1) + Bn U(k-1)           U ~ (0, QU), lambda(0) ~ (0, Lambda0)
 *
 *     hnav_ins_error_options options = hnav_ins_error_defaults();
 *     hnav_ins_error_filter *filter;
 *     hnav_ins_error_filter_create(&filter, &options, &model, message, sizeof message);
 *     while (...) {
 *         hnav_ins_error_filter_step(filter, u, z, NULL);
 *         hnav_ins_error_filter_estimate(filter, x, sigma);
 *     }
 *
 * Units are the model's. Source of the printed forms: Hajiyev and Hacizade, WSEAS Trans. Systems and Control 18, 2023,
 * doi 10.37394/23203.2023.18.51. */
#ifndef HNAV_INS_ERROR_H
#define HNAV_INS_ERROR_H

#include "hnav/options/ins_error.h"
#include "hnav/types.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct hnav_ins_error_filter hnav_ins_error_filter;

/* AUGMENTED, JOINT, no lag, Joseph. */
HNAV_API hnav_ins_error_options hnav_ins_error_defaults(void);

/* Row-major matrices, owned by the caller, copied by create. Sizes 1 to 32; nu may be 0. */
typedef struct hnav_ins_error_model {
    size_t size;           /* of this struct; set by the caller */
    int32_t nx, nu, nz, nw, nl;
    /* 0: the matrices are those of one step. Above: A, B, G, Qw and An, Bn, QU belong to dx/dt = A x + B u + G w and
     * dlambda/dt = An lambda + Bn U with spectral densities Qw and QU; they are discretised exactly, u held. */
    double interval_s;
    const double* A;       /* nx x nx */
    const double* B;       /* nx x nu; not read when nu = 0 */
    const double* G;       /* nx x nw; null: the identity */
    const double* H;       /* nz x nx */
    const double* An;      /* nz x nz; null: no coloured errors; Bn, QU and Lambda0 are not read */
    const double* Bn;      /* nz x nl; null: the identity */
    const double* Qw;      /* nw x nw */
    const double* Qv;      /* nz x nz; diagonal unless noise_scaling is NONE */
    const double* QU;      /* nl x nl */
    const double* Lambda0; /* nz x nz; null: the stationary covariance of lambda */
    const double* x0;      /* nx; null: zero */
    const double* P0;      /* nx x nx */
} hnav_ins_error_model;

/* Refused, with a message that names the matrix: sizes out of range (SIZE), null (NULL_ARGUMENT) or non-finite
 * (NON_FINITE) matrices; covariances that are not symmetric or not positive semidefinite, An that lets lambda grow, an
 * unstable mode of A that is not observable (all OPTION). */
HNAV_API hnav_status hnav_ins_error_filter_create(hnav_ins_error_filter** filter, const hnav_ins_error_options* options,
                                                  const hnav_ins_error_model* model, char* message, size_t message_size);
/* Null is allowed. */
HNAV_API void hnav_ins_error_filter_destroy(hnav_ins_error_filter* filter);
/* Restores x0 and P0, no samples, with the present model. */
HNAV_API hnav_status hnav_ins_error_filter_reset(hnav_ins_error_filter* filter);
/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char* hnav_ins_error_filter_message(const hnav_ins_error_filter* filter);
/* A warning about the model, "" if there is none: states and coloured errors that are hard to separate. */
HNAV_API const char* hnav_ins_error_filter_warning(const hnav_ins_error_filter* filter);
/* For a mode of A with eigenvalue mu and shape a, |(mu - An) H a| / (|(1 - mu) H a| + |(1 - An) H a|) in units of
 * sigma(lambda); the least over the modes. 0: a mode changes the measurements as lambda does; 1: it is separable. */
HNAV_API hnav_status hnav_ins_error_filter_separability(const hnav_ins_error_filter* filter, double* separability);
/* Other matrices of the same sizes from the next step on (time-varying systems): A, B, G, Qw, An, Bn, QU lead to that
 * step, H and Qv are of its sample. x0, P0 and Lambda0 count again at a reset. Errors as of create. */
HNAV_API hnav_status hnav_ins_error_filter_replace_model(hnav_ins_error_filter* filter, const hnav_ins_error_model* model);

/* One step: u (nu) was held since the last step and is not read by the first, whose prior is x0 and P0; z (nz). A channel
 * is missing when its z is NaN, or when present (nz, null for all) is 0 there. Errors: NON_FINITE (u, infinite z), SOLVER
 * (a covariance that is singular or negative, or an unbounded estimate). */
HNAV_API hnav_status hnav_ins_error_filter_step(hnav_ins_error_filter* filter, const double* u, const double* z,
                                                const uint8_t* present);

/* Outputs are of the newest step, or of the one before it (MDKF, AMDKF, lag = 1). Null outputs are not written. */
HNAV_API hnav_status hnav_ins_error_filter_estimate(const hnav_ins_error_filter* filter, double* x, double* sigma); /* nx */
HNAV_API hnav_status hnav_ins_error_filter_covariance(const hnav_ins_error_filter* filter, double* P); /* nx x nx */
/* lambda (nz), its sigma, and the compensated measurement z - lambda, NaN where z is missing. Forms other than AUGMENTED
 * have no state lambda and return z - H x, which is lambda + v. */
HNAV_API hnav_status hnav_ins_error_filter_coloured_error(const hnav_ins_error_filter* filter, double* lambda, double* sigma,
                                                          double* compensated);
/* Of the newest sample: innovation (nz, NaN where there was none), its covariance S (nz x nz) with the noise that was
 * used, and NIS over the present channels. NO_DATA before the first sample. In MDKF and AMDKF S need not be a covariance,
 * and NIS can be negative, by their equations as printed. */
HNAV_API hnav_status hnav_ins_error_filter_innovation(const hnav_ins_error_filter* filter, double* innovation, double* S,
                                                      double* nis);
/* By channel (nz): factor on Qv (on R in AMDKF), and the probability that its noise has a fault (JOINT, HMM; 0 or 1 by the
 * gate of GATED_MATCH; 0 otherwise). */
HNAV_API hnav_status hnav_ins_error_filter_noise(const hnav_ins_error_filter* filter, double* scale, double* fault_probability);

/* Fault probabilities. noise, bias: by channel (nz), white noise above Qv, as above, and a jump of the coloured error; the
 * latter decays by 7 % a step once the filter has estimated the jump. process: process noise of state or coloured errors
 * above Qw or QU. bias and process are 0 unless the scaling is JOINT and the form AUGMENTED. */
HNAV_API hnav_status hnav_ins_error_filter_faults(const hnav_ins_error_filter* filter, double* noise, double* bias,
                                                  double* process);

typedef struct hnav_ins_error_info {
    size_t size;              /* of this struct; set by the caller */
    uint64_t steps;           /* done since create or reset */
    uint64_t shown_step;      /* step of the outputs, counted from 0 */
    int32_t nx, nu, nz;
    int32_t estimates_lambda; /* lambda is a state */
} hnav_ins_error_info;
HNAV_API hnav_status hnav_ins_error_filter_info(const hnav_ins_error_filter* filter, hnav_ins_error_info* info);

/* Arrays in, arrays out: n rows, each one step. Equal, bit for bit, to step after step. */
typedef struct hnav_ins_error_run_input {
    size_t size;            /* of this struct; set by the caller */
    const double* u;        /* n x nu: row k is the u of step k, held from step k - 1 on; may be null when nu = 0 */
    const double* z;        /* n x nz */
    const uint8_t* present; /* n x nz, may be null */
} hnav_ins_error_run_input;

typedef struct hnav_ins_error_run_output { /* null: not written; row k has the outputs after step k */
    size_t size;                                              /* of this struct; set by the caller */
    double *x, *sigma;                                        /* n x nx */
    double* covariance;                                       /* n x nx x nx */
    double *lambda, *lambda_sigma, *compensated, *innovation; /* n x nz */
    double* nis;                                              /* n */
    double *noise_scale, *fault_probability;                  /* n x nz */
    double* bias_fault_probability;                           /* n x nz */
    double* process_fault_probability;                        /* n */
} hnav_ins_error_run_output;

/* rows_done (may be null): rows that are complete; less than n only after an error. */
HNAV_API hnav_status hnav_ins_error_filter_run(hnav_ins_error_filter* filter, size_t n, const hnav_ins_error_run_input* input,
                                               const hnav_ins_error_run_output* output, size_t* rows_done);

/* As for hnav_filter: numbers only; fits filters made with equal options and model. A model that was replaced since
 * create is not part of it: replace it again after load. */
HNAV_API hnav_status hnav_ins_error_filter_state_size(const hnav_ins_error_filter* filter, size_t* bytes);
HNAV_API hnav_status hnav_ins_error_filter_save(const hnav_ins_error_filter* filter, void* buffer, size_t bytes);
/* Errors: SIZE, STATE_CORRUPT, STATE_VERSION; the filter is then unchanged. */
HNAV_API hnav_status hnav_ins_error_filter_load(hnav_ins_error_filter* filter, const void* buffer, size_t bytes);

#ifdef __cplusplus
}
#endif

#endif /* HNAV_INS_ERROR_H */
