/* hnav: hybrid navigation filters, the C API.
 *
 * A filter here is a hybrid system. Between samples its estimate flows: an ODE solver integrates attitude, gyro
 * bias and covariance. At a sample it jumps: the correction. The estimate is stored at sample times only; a request
 * for time t replays the samples that wait, coasts to t on a copy and shows the copy. Hence the same samples give the
 * same bits whatever times are asked for.
 *
 *     hnav_hrekf_options options = hnav_hrekf_defaults(HNAV_PRESET_DEFAULT);
 *     hnav_filter *filter;
 *     hnav_hrekf_create(&filter, &options, NULL, 0);
 *     while (...) {
 *         hnav_filter_push_imu(filter, t_s, rate_b_rad_s, force_b_m_s2);
 *         hnav_filter_push_mag(filter, t_s, field_b_tesla);
 *         hnav_filter_advance(filter, t_s);
 *         hnav_filter_attitude(filter, &attitude);
 *     }
 *     hnav_filter_destroy(filter);
 *
 * Conventions
 *   n    navigation frame: north-east-down, or east-north-up when asked for (option navigation_frame)
 *   b    body frame: the axes of the sensor turned by the mounting rotation q_body_sensor
 *   q    Hamilton quaternion, scalar first, unit length; q_nb turns body vectors into navigation axes
 *   force_b is specific force: a sensor at rest with its z axis down reads (0, 0, -9.81) m/s2
 *   SI units, always; the last words of a name are its unit; matrices are row-major
 *
 * Promises
 *   Every call returns a status. After a failure the estimate is as it was before the call and the object stays
 *   usable; hnav_filter_message tells what was wrong, naming the argument or option.
 *   Memory is taken in create and nowhere else. Objects share nothing; one object serves one thread at a time.
 *   Null arguments, non-finite numbers and impossible options are answered, never followed.
 */
#ifndef HNAV_H
#define HNAV_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32) && defined(HNAV_SHARED)
#  ifdef HNAV_BUILD
#    define HNAV_API __declspec(dllexport)
#  else
#    define HNAV_API __declspec(dllimport)
#  endif
#elif defined(__GNUC__) && defined(HNAV_SHARED)
#  define HNAV_API __attribute__((visibility("default")))
#else
#  define HNAV_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ status */

typedef enum hnav_status {
    HNAV_OK = 0,
    HNAV_ERROR_NULL_ARGUMENT = 1,   /* a pointer that must not be null is */
    HNAV_ERROR_OPTION = 2,          /* an option is impossible; the message names the field */
    HNAV_ERROR_OPTIONS_STAMP = 3,   /* the options were not made by a *_defaults call of this version */
    HNAV_ERROR_OUT_OF_MEMORY = 4,   /* create found no memory */
    HNAV_ERROR_NON_FINITE = 5,      /* NaN or infinity in a sample or time; the sample is dropped and counted */
    HNAV_ERROR_ZERO_VECTOR = 6,     /* a force or field of zero length has no direction; dropped and counted */
    HNAV_ERROR_OUT_OF_RANGE = 7,    /* an argument outside its range (sigma not positive, unknown sensor, time beyond 1e12 s) */
    HNAV_ERROR_LATE_SAMPLE = 8,     /* older than the committed estimate; dropped and counted */
    HNAV_ERROR_QUEUE_FULL = 9,      /* more waiting samples than queue_capacity: advance first */
    HNAV_ERROR_TIME_BACKWARDS = 10, /* advance to a time before the last one */
    HNAV_ERROR_NOT_STARTED = 11,    /* no attitude yet: the start waits for samples */
    HNAV_ERROR_NO_DATA = 12,        /* no sample of this sensor has been used yet */
    HNAV_ERROR_SIZE = 13,           /* a buffer is too small, or not of the size the object needs */
    HNAV_ERROR_STATE_CORRUPT = 14,  /* saved state damaged, of another version, or of a filter with other options */
    HNAV_ERROR_SOLVER = 15,         /* there is no usable answer; the samples that led there were dropped */
    HNAV_ERROR_UNSUPPORTED = 16,    /* this filter cannot do what was asked */
    HNAV_ERROR_ILL_CONDITIONED = 17 /* the data do not determine the answer; the message says what is missing */
} hnav_status;

/* One line of English for a status; never null. */
HNAV_API const char *hnav_status_text(hnav_status status);

/* "MAJOR.MINOR.PATCH" */
HNAV_API const char *hnav_version(void);

/* ------------------------------------------------------------------------------------------------ options */

typedef enum hnav_preset {
    HNAV_PRESET_DEFAULT = 0, /* real sensors, one setting for all */
    HNAV_PRESET_PAPER = 1    /* the source paper's Q and R, two Euler steps per sample at 100 Hz, P0 and gamma fitted */
} hnav_preset;

typedef enum hnav_gyro_hold {
    HNAV_GYRO_HOLD_FORWARD = 0, /* the rate sampled at t_k acts on [t_k, t_k+1): causal, every engine agrees */
    HNAV_GYRO_HOLD_BACKWARD = 1 /* it acts on (t_k-1, t_k]: recordings of integrating gyros */
} hnav_gyro_hold;

typedef enum hnav_gamma_mode {
    HNAV_GAMMA_OFF = 0,      /* gamma infinite: the hybrid extended Kalman filter (HEKF) */
    HNAV_GAMMA_FIXED = 1,    /* the paper's constant gamma */
    HNAV_GAMMA_RELATIVE = 2, /* 1/gamma^2 = rho / lmax(L P L'), rho = 1 - exp(-rate T) */
    HNAV_GAMMA_KL = 3        /* from a tolerance on relative entropy per second (Levy and Nikoukhah 2013) */
} hnav_gamma_mode;

typedef enum hnav_adaptation {
    HNAV_ADAPTATION_OFF = 0,
    HNAV_ADAPTATION_PAPER = 1,    /* Q <- (1 - alpha) Q + alpha K nu nu' K' on the bias block, as printed */
    HNAV_ADAPTATION_CORRECTED = 2 /* divided by the interval, with the covariance terms, annealed, bounded */
} hnav_adaptation;

typedef enum hnav_start_mode {
    HNAV_START_TRIAD = 0,    /* tilt from force, heading from field (or from a heading sample if that comes first) */
    HNAV_START_ATTITUDE = 1, /* start_q_nb, at the first sample */
    HNAV_START_HEADING = 2   /* tilt from force, heading start_heading_rad */
} hnav_start_mode;

typedef enum hnav_reference_mode {
    HNAV_REFERENCE_LEARNT = 0, /* strength and dip of the field from the samples of the start */
    HNAV_REFERENCE_GIVEN = 1   /* reference_strength_tesla and reference_dip_rad */
} hnav_reference_mode;

typedef enum hnav_navigation_frame { HNAV_FRAME_NED = 0, HNAV_FRAME_ENU = 1 } hnav_navigation_frame;

typedef enum hnav_solver {
    HNAV_SOLVER_ERKSTEP = 0,     /* SUNDIALS ARKODE, Dormand-Prince 5(4) */
    HNAV_SOLVER_ADAMS = 1,       /* SUNDIALS CVODE, Adams-Moulton, fixed-point iteration */
    HNAV_SOLVER_CLOSED_FORM = 2, /* exact for a held rate */
    HNAV_SOLVER_EULER = 3        /* the paper's: forward Euler in sub-steps of euler_step_s */
} hnav_solver;

/* Options of the paper's filter (HEKF, HREKF). Make them with hnav_hrekf_defaults, then change what you need.
 * hnav_hrekf_option() tells unit, range and meaning of every field at run time. */
typedef struct hnav_hrekf_options {
    uint64_t cookie; /* set by hnav_hrekf_defaults */

    /* Process noise, as densities: covariance per second is the square. */
    double gyro_noise_rad_per_sqrt_s;         /* angle random walk */
    double gyro_bias_walk_rad_s_per_sqrt_s;   /* rate random walk of the bias */
    double quaternion_noise_per_sqrt_s;       /* on all four components alike: the paper's L = I; 0 otherwise */

    /* Measurement noise, as densities: one sample that stands for an interval T has variance density^2 / T. */
    double accel_noise_per_sqrt_hz; /* of the direction of specific force */
    double mag_noise_per_sqrt_hz;   /* of the field in units of the reference strength */
    double interval_limit_s;        /* longest interval that one sample may stand for; the first stands for none */

    /* Robust law. */
    double gamma;                   /* FIXED */
    double gamma_relative_rate_1_s; /* RELATIVE: rho = 1 - exp(-rate T) */
    double gamma_kl_rate_1_s;       /* KL: nats per second */
    double gamma_weight_attitude;   /* L on the quaternion */
    double gamma_weight_bias;       /* L on the bias */

    /* Robbins-Monro adaptation of the bias walk. */
    double adaptation_gain;                         /* alpha; the floor of the annealed alpha when CORRECTED */
    double adaptation_floor_rad_s_per_sqrt_s;       /* the adapted bias walk stays within these bounds (CORRECTED) */
    double adaptation_cap_rad_s_per_sqrt_s;

    /* Start. */
    double start_q_nb[4];              /* ATTITUDE; in navigation_frame */
    double start_heading_rad;          /* HEADING: true heading of body x, clockwise from north */
    double start_gyro_bias_rad_s[3];
    double start_sigma_tilt_rad;
    double start_sigma_heading_rad;
    double start_sigma_bias_rad_s;

    /* Reference field, when GIVEN. */
    double reference_strength_tesla;
    double reference_dip_rad;          /* positive when the field points down (northern hemisphere) */

    /* Gates: a sample whose normalised innovation squared exceeds the limit is used with inflated noise. 0 = never.
     * They work while tilt (force), or tilt and heading (field, heading) are ready: a gate that rejects for long lets
     * sigma grow until it opens. Set accel_gate_nis to 13.9 (99.7 % of chi square) when the noise above is that of the
     * sensors; the default belongs to the default noise. */
    double accel_gate_nis;
    double mag_gate_nis;
    double heading_gate_nis;

    /* Ready: sigma below this, and at least as much information gained since the start. */
    double ready_tilt_rad;
    double ready_heading_rad;

    /* Interface. */
    double declination_rad;            /* true heading = magnetic heading + declination */
    double q_body_sensor[4];           /* mounting: turns sensor vectors into the body frame */

    /* Integrator. */
    double solver_rtol;
    double solver_atol;                /* relative to the nominal size of each state */
    double euler_step_s;

    /* Late samples. */
    double horizon_s;                  /* how far behind the newest used sample a sample may still come */

    int32_t gyro_hold;                 /* hnav_gyro_hold */
    int32_t gamma_mode;                /* hnav_gamma_mode */
    int32_t adaptation;                /* hnav_adaptation */
    int32_t start_mode;                /* hnav_start_mode */
    int32_t start_samples;             /* samples of each sensor averaged for the start */
    int32_t reference_mode;            /* hnav_reference_mode */
    int32_t navigation_frame;          /* hnav_navigation_frame */
    int32_t solver;                    /* hnav_solver */
    int32_t queue_capacity;            /* instants that may wait, including those within the horizon */
} hnav_hrekf_options;

HNAV_API hnav_hrekf_options hnav_hrekf_defaults(hnav_preset preset);

/* Options of the AHRS, the filter for real sensors; hnav_ahrs_option() tells unit, range and meaning. Fields named
 * as in hnav_hrekf_options mean the same. Densities: a quantity that stands for an interval T has variance density^2 / T.
 * Fields are in units of the strength of the reference. */
typedef struct hnav_ahrs_options {
    uint64_t cookie; /* set by hnav_ahrs_defaults */

    /* Gyroscope. */
    double gyro_noise_rad_per_sqrt_s;
    double gyro_rate_noise_sqrt_s;          /* noise that grows with the rate: density = this x |rate| */
    double gyro_bias_walk_rad_s_per_sqrt_s;

    /* Accelerometer: velocity stays bounded. */
    double velocity_noise_m_s_per_sqrt_hz;
    double unseen_acceleration_m_s2;        /* while samples of force are missing */
    double unseen_turn_factor;              /* while samples of rate are missing, of its usual change */

    /* Magnetometer. */
    double mag_azimuth_noise_per_sqrt_hz;   /* across the reference */
    double mag_intensity_noise_per_sqrt_hz; /* horizontal and vertical intensity */
    double mag_rest_factor;                 /* of both variances at rest, where distortions do not average out */
    double reference_walk_per_sqrt_s;

    double correction_interval_s;           /* samples are gathered and corrected so often, at the sample nearest */
    double interval_limit_s;

    /* Rest. */
    double rest_rate_rad_s;                 /* deviation of the rate from its running mean */
    double rest_force_m_s2;
    double rest_mean_rate_rad_s;            /* on each axis */
    double rest_duration_s;
    double rest_filter_s;                   /* time constant of the running means */
    double rest_bias_noise_rad_s_per_sqrt_hz;

    /* Magnetic reference. */
    double mag_gate;                        /* distance of the intensities */
    double mag_gate_longest_s;
    double mag_gate_share;                  /* a field is refused no longer than this times the time the reference served */
    double turning_rad_s;                   /* evidence counts fully above this root mean square rate */
    double still_weight;                    /* and by this weight below */
    double candidate_radius;
    double candidate_mean_s;
    double candidate_first_s;               /* evidence that replaces a reference without any */
    double candidate_share;                 /* else this share of the reference's evidence */
    double trust_s;                         /* evidence after which a new field no longer turns the heading */
    double turn_least_rad;                  /* least error of heading that a new field corrects at once */
    double turn_sigmas;
    double turn_sigma_rad;                  /* added to a heading that was turned */

    /* Robust law, while heading is not ready. */
    double gamma;
    double gamma_relative_rate_1_s;
    double gamma_kl_rate_1_s;

    /* Start. */
    double start_q_nb[4];
    double start_heading_rad;
    double start_gyro_bias_rad_s[3];
    double start_field_wait_s;              /* start level with an unknown heading if no field has come by then */
    double start_sigma_tilt_rad;
    double start_sigma_heading_rad;
    double start_sigma_bias_rad_s;
    double start_sigma_velocity_m_s;
    double start_sigma_reference;
    double start_sigma_latency_s;           /* of the magnetometer behind its time stamps */
    double start_sigma_gyro_scale;
    double start_sigma_gyro_misalignment_rad;

    double reference_strength_tesla;
    double reference_dip_rad;

    double heading_gate_nis;
    double ready_tilt_rad;
    double ready_heading_rad;
    double ready_evidence_s;                /* and the field has agreed with the reference for so long, */
    double ready_calm_s;                    /* and nothing has spoken against it for so long */

    double declination_rad;
    double q_body_sensor[4];
    double output_latency_s;                /* attitude is shown as it will be this much later at the present rate */

    double solver_rtol;
    double solver_atol;
    double euler_step_s;
    double horizon_s;

    int32_t gyro_hold;
    int32_t gamma_mode;
    int32_t start_mode;
    int32_t start_samples;
    int32_t reference_mode;
    int32_t navigation_frame;
    int32_t solver;
    int32_t queue_capacity;
} hnav_ahrs_options;

/* HNAV_PRESET_DEFAULT is the one preset. */
HNAV_API hnav_ahrs_options hnav_ahrs_defaults(hnav_preset preset);

typedef enum hnav_option_kind { HNAV_OPTION_REAL = 0, HNAV_OPTION_INTEGER = 1, HNAV_OPTION_CHOICE = 2 } hnav_option_kind;

/* One row of the option table: create checks by it, the FMU takes its parameters from it, Python its names. */
typedef struct hnav_option_info {
    const char *name;           /* the field of the options struct */
    const char *unit;           /* "rad", "1/s", ...; "" when it has none */
    const char *description;    /* one sentence */
    const char *const *choices; /* CHOICE: names of 0, 1, ... in the order of the enum; null otherwise */
    size_t offset;              /* of the field in the struct, bytes */
    double min, max;            /* inclusive, for each component */
    int32_t count;              /* components: 1, 3 or 4 */
    int32_t choice_count;
    hnav_option_kind kind;      /* REAL fields are double, the others int32_t */
    int32_t min_is_open;        /* 1 when min itself is excluded */
} hnav_option_info;

/* Rows 0, 1, ...; null beyond the last. */
HNAV_API const hnav_option_info *hnav_hrekf_option(int32_t index);
HNAV_API const hnav_option_info *hnav_ahrs_option(int32_t index);

/* ------------------------------------------------------------------------------------------------ life */

/* One type for every attitude filter; the create call chooses the model. */
typedef struct hnav_filter hnav_filter;

/* Makes the paper's filter. On failure *filter is null and the reason stands in message (may be null). */
HNAV_API hnav_status hnav_hrekf_create(hnav_filter **filter, const hnav_hrekf_options *options,
                                       char *message, size_t message_size);
/* Makes the AHRS. */
HNAV_API hnav_status hnav_ahrs_create(hnav_filter **filter, const hnav_ahrs_options *options,
                                         char *message, size_t message_size);

/* Null is allowed. */
HNAV_API void hnav_filter_destroy(hnav_filter *filter);

/* Back to the moment after create: no samples, no estimate, counters zero. */
HNAV_API hnav_status hnav_filter_reset(hnav_filter *filter);

/* Forgets the attitude and starts anew with the next samples; keeps the gyro bias and the counters. */
HNAV_API hnav_status hnav_filter_realign(hnav_filter *filter);

/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char *hnav_filter_message(const hnav_filter *filter);

/* ------------------------------------------------------------------------------------------------ samples */

/* Samples may come in any order within one instant and between two advance calls, and up to horizon_s late after.
 * Samples of equal time are corrected together: rate, force, field, heading. A second sample of one sensor at the
 * same time follows the first. Errors: NON_FINITE, ZERO_VECTOR, OUT_OF_RANGE, LATE_SAMPLE, QUEUE_FULL. */
HNAV_API hnav_status hnav_filter_push_gyro(hnav_filter *filter, double t_s, const double rate_b_rad_s[3]);
HNAV_API hnav_status hnav_filter_push_accel(hnav_filter *filter, double t_s, const double force_b_m_s2[3]);
HNAV_API hnav_status hnav_filter_push_mag(hnav_filter *filter, double t_s, const double field_b_tesla[3]);
HNAV_API hnav_status hnav_filter_push_imu(hnav_filter *filter, double t_s, const double rate_b_rad_s[3],
                                          const double force_b_m_s2[3]); /* both or neither */
/* heading_rad: true heading of body x, clockwise from north; sigma_rad: its standard deviation, > 0, at least 1e-9 of it is used. */
HNAV_API hnav_status hnav_filter_push_heading(hnav_filter *filter, double t_s, double heading_rad, double sigma_rad);

/* Uses the samples up to t_s and shows the estimate at t_s. Errors: NON_FINITE, OUT_OF_RANGE, TIME_BACKWARDS; SOLVER: some
 * of the samples led to no usable estimate and were dropped, the others were used. */
HNAV_API hnav_status hnav_filter_advance(hnav_filter *filter, double t_s);

/* Arrays in, arrays out: n rows, each one instant. A row of accel or mag with a NaN is a missing sample, as is a
 * null pointer; a null output is not written. Equal, bit for bit, to push and advance of row after row. */
typedef struct hnav_run_input {
    const double *t_s;           /* n, not decreasing */
    const double *rate_b_rad_s;  /* n x 3, may be null */
    const double *force_b_m_s2;  /* n x 3, may be null */
    const double *field_b_tesla; /* n x 3, may be null */
} hnav_run_input;

typedef struct hnav_run_output {
    double *q_nb;               /* n x 4; NaN before the start */
    double *euler_rad;          /* n x 3: roll, pitch, yaw */
    double *sigma_rad;          /* n x 3: rotation error about the navigation axes */
    double *gyro_bias_rad_s;    /* n x 3 */
    double *gyro_bias_sigma_rad_s; /* n x 3 */
    double *accel_nis;          /* n; NaN where no sample was used */
    double *mag_nis;            /* n */
    uint8_t *ready;             /* n x 2: tilt, heading */
} hnav_run_output;

/* rows_done (may be null): rows that are complete; less than n only after an error. */
HNAV_API hnav_status hnav_filter_run(hnav_filter *filter, size_t n, const hnav_run_input *input,
                                     const hnav_run_output *output, size_t *rows_done);

/* The same arrays with hindsight: forward, then twice backwards and forward, each pass started at the end of the one
 * before, the last two fused by their covariances. Every row has an attitude. sigma_rad is that of the fusion, as if the
 * two passes shared nothing: a little small. Takes 5 times as long as run, and memory for its rows. The filter is reset
 * before and after. Errors: as run; UNSUPPORTED (the HREKF), NOT_STARTED, OUT_OF_MEMORY. */
HNAV_API hnav_status hnav_filter_smooth(hnav_filter *filter, size_t n, const hnav_run_input *input,
                                        const hnav_run_output *output);

/* ------------------------------------------------------------------------------------------------ estimate */

typedef enum hnav_sensor {
    HNAV_SENSOR_GYRO = 0,
    HNAV_SENSOR_ACCEL = 1,
    HNAV_SENSOR_MAG = 2,
    HNAV_SENSOR_HEADING = 3
} hnav_sensor;
enum { HNAV_SENSOR_COUNT = 4 };

/* Everything below is at the time of the last advance unless it says otherwise. */
typedef struct hnav_attitude {
    double t_s;
    double q_nb[4];
    double euler_rad[3];  /* roll, pitch, yaw of body in navigation axes, rotation order z y x */
    double heading_rad;   /* true heading of body x, clockwise from north, (-pi, pi], whatever the frame */
    double sigma_rad[3];  /* standard deviation of the rotation error about the navigation axes; the third is heading */
    int32_t near_singular; /* pitch beyond 85 deg: roll and yaw are ill defined */
    int32_t tilt_ready;
    int32_t heading_ready;
} hnav_attitude;

/* NOT_STARTED before there is an attitude. */
HNAV_API hnav_status hnav_filter_attitude(const hnav_filter *filter, hnav_attitude *attitude);
/* Known before the start too: zero rate until the first sample, and the bias to start from. */
HNAV_API hnav_status hnav_filter_rate(const hnav_filter *filter, double rate_b_rad_s[3]); /* bias removed */
HNAV_API hnav_status hnav_filter_gyro_bias(const hnav_filter *filter, double bias_b_rad_s[3], double sigma_rad_s[3]);

/* 6 x 6 covariance of (rotation error about the navigation axes in rad, gyro bias error in rad/s); q_true is
 * exp(rotation error / 2) times q_nb. NOT_STARTED. */
HNAV_API hnav_status hnav_filter_covariance(const hnav_filter *filter, double covariance[36]);

/* The estimate just after the newest sample that is not in the future of the last advance. NOT_STARTED. */
typedef struct hnav_posterior {
    double t_s;
    double q_nb[4];
    double gyro_bias_rad_s[3];
    double sigma[6]; /* three rotations about the navigation axes in rad, three biases in rad/s */
    int32_t near_singular; /* as in hnav_attitude */
    int32_t tilt_ready;
    int32_t heading_ready;
    int32_t reserved;      /* 0 */
} hnav_posterior;
HNAV_API hnav_status hnav_filter_posterior(const hnav_filter *filter, hnav_posterior *posterior);

/* What the last used sample of a sensor said. Direction and field are dimensionless, heading is in rad. */
typedef struct hnav_innovation {
    double t_s;
    double value[3];      /* ahrs, force: minus the velocity in m/s, north and east; field: in navigation axes */
    double S[9];          /* its covariance, with the noise that was parametrised (not inflated) */
    double nis;           /* value' S^-1 value */
    double noise_scale;   /* trace of the noise used over that parametrised; 1 unless the gate inflated it */
    int32_t dimension;    /* 3; 1 for heading; 2 for the force of the AHRS. The AHRS's S has 2 or 3 rows of 3 */
    int32_t accepted;     /* 0 when the gate inflated the noise or refused the sample (noise_scale infinite) */
} hnav_innovation;
/* Errors: NO_DATA, OUT_OF_RANGE (the gyroscope has no innovation). */
HNAV_API hnav_status hnav_filter_innovation(const hnav_filter *filter, hnav_sensor sensor, hnav_innovation *innovation);

/* What the filter holds of the magnetic field, just after the newest used sample. */
typedef enum hnav_field_gate {
    HNAV_FIELD_ACCEPTED = 0,
    HNAV_FIELD_REFUSED = 1, /* not used: it lies away from the reference */
    HNAV_FIELD_GIVEN_IN = 2 /* used with inflated noise although it lies away */
} hnav_field_gate;

typedef struct hnav_field {
    double strength_tesla;   /* of the reference; NaN while there is none */
    double dip_rad;
    double latency_s;        /* estimated delay of the magnetometer behind its time stamps (ahrs) */
    double latency_sigma_s;
    double evidence_s;       /* time for which the reference was seen, counted less at rest (ahrs) */
    double heading_trust_s;  /* the same for the heading, through changes of reference (ahrs) */
    int32_t adopted;         /* references taken after the first (ahrs) */
    int32_t gate;            /* hnav_field_gate of the last field */
    int32_t at_rest;         /* the body lies still (ahrs) */
    int32_t reserved;        /* 0 */
} hnav_field;
HNAV_API hnav_status hnav_filter_field(const hnav_filter *filter, hnav_field *field);

/* Scale and misalignment S of the gyroscope, rate = (I - S) reading - bias, row-major, and the sigma of each; zero in
 * filters that do not estimate it. */
HNAV_API hnav_status hnav_filter_gyro_calibration(const hnav_filter *filter, double matrix[9], double sigma[9]);

typedef struct hnav_filter_status {
    double gamma_used;      /* of the last correction; infinity when off */
    double gamma_margin;    /* 1 - lmax(L P L') / gamma^2: 1 when off, above 0 always */
    double adapted_bias_walk_rad_s_per_sqrt_s; /* root of the mean of the diagonal of Q on the bias, times one second */
    double newest_sample_s; /* time of the newest used sample; NaN if there was none */
    uint64_t used[HNAV_SENSOR_COUNT];       /* samples used, by sensor */
    uint64_t gated[HNAV_SENSOR_COUNT];      /* of those, with inflated noise */
    uint64_t late;          /* refused: older than the committed estimate */
    uint64_t non_finite;    /* refused: NaN, infinity, beyond 1e6 in any unit or 1e12 s */
    uint64_t zero;          /* refused: zero vector */
    uint64_t corrections;
    uint64_t gamma_raised;  /* corrections whose gamma was infeasible and had to be raised */
    uint64_t covariance_repaired;
    uint64_t solver_rhs_evals;
    uint64_t solver_steps;
    int32_t started;        /* there is an attitude */
    int32_t waiting;        /* instants in the queue that are still in the future of the last advance */
    /* Rate at which the last correction and the flow before it make the filter forget: for two estimates with its gains
     * that differ by e, sqrt(e' P^-1 e) falls at least by exp(-rate T), P the covariance after each correction.
     * -ln |L_k^-1 M_k L_k-1| / T_k with P_k = L_k L_k' and M_k = J (I - K_k H_k) Phi_k, the sampled-data form of the
     * paper's Theorem 1 (decay_rate.hpp). 1/s; one correction at a time, hence no certificate: that is `hnav certify`.
     * 0 before the first correction after a start, while P is singular, and in the AHRS, which does not compute it. */
    double decay_rate_1_s;
} hnav_filter_status;
HNAV_API hnav_status hnav_filter_get_status(const hnav_filter *filter, hnav_filter_status *status);

/* ------------------------------------------------------------------------------------------------ save, load */

/* A saved state is numbers only (no solver history, no pointers): load it into any filter made with the same model
 * and options, in this or another process, and it goes on bit for bit. */
HNAV_API hnav_status hnav_filter_state_size(const hnav_filter *filter, size_t *bytes);
HNAV_API hnav_status hnav_filter_save(const hnav_filter *filter, void *buffer, size_t bytes);
/* SIZE, STATE_CORRUPT: the filter is as it was. */
HNAV_API hnav_status hnav_filter_load(hnav_filter *filter, const void *buffer, size_t bytes);

/* ------------------------------------------------------------------------------------------------ hybrid view */

/* The same filter for callers that bring their own integrator (FMI Model Exchange): x' = f(x) between events,
 * x+ = jump(x-) at an event. States of the HREKF: q 4 (north-east-down of magnetic north to body, before the
 * interface rotations), gyro bias 3, covariance 28 (upper triangle of the 7 x 7 matrix, row by row). States of the
 * ahrs: q 4, the integral of its rotation matrix since the last correction 9 (column by column), the time since
 * then; from these follows the covariance. Not to be mixed with advance or run, nor, in the HREKF, with the backward
 * gyro hold; the AHRS puts the rate of a sample into the interval before it when it jumps. */
HNAV_API hnav_status hnav_filter_nx(const hnav_filter *filter, int32_t *nx);
/* The state just after the last jump. */
HNAV_API hnav_status hnav_filter_get_x(const hnav_filter *filter, double *x);
/* Sizes to scale tolerances by, from the present sigmas, all positive. */
HNAV_API hnav_status hnav_filter_nominal_x(const hnav_filter *filter, double *nominal_x);
/* Pure: changes nothing. Smooth in t_s and x, also beyond the next event. */
HNAV_API hnav_status hnav_filter_derivative(const hnav_filter *filter, double t_s, const double *x, double *dx);
/* Exact directional derivative of f: out = (df/dx) seed. Pure. */
HNAV_API hnav_status hnav_filter_derivative_along(const hnav_filter *filter, double t_s, const double *x,
                                                  const double *seed, double *out);
/* Time of the earliest waiting sample, infinity if none waits. */
HNAV_API hnav_status hnav_filter_next_event_s(const hnav_filter *filter, double *t_s);
/* Applies the waiting samples of times up to t_s to the state x_minus at t_s and commits. */
HNAV_API hnav_status hnav_filter_jump(hnav_filter *filter, double t_s, const double *x_minus, double *x_plus);
/* Lets attitude, rate, gyro_bias and covariance show x at t_s. Errors of jump and show: NON_FINITE, OUT_OF_RANGE (beyond
 * 1e50, or a quaternion of no length). */
HNAV_API hnav_status hnav_filter_show(hnav_filter *filter, double t_s, const double *x);

/* ------------------------------------------------------------------------------------------------ coloured INS errors */

/* Estimation of the state of a linear system from measurements with time-correlated errors, such as those of an INS:
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
typedef struct hnav_ins_error_filter hnav_ins_error_filter;

typedef enum hnav_ins_error_form {
    HNAV_INS_ERROR_MDKF = 0,        /* measurement differencing as printed; its estimate is one step late */
    HNAV_INS_ERROR_AMDKF = 1,       /* the same with covariance matching over a window, as printed */
    HNAV_INS_ERROR_DIFFERENCED = 2, /* differencing with the correlation where it belongs; exact when v = 0 */
    HNAV_INS_ERROR_AUGMENTED = 3,   /* lambda as states: optimal */
    HNAV_INS_ERROR_PLAIN = 4        /* Kalman filter that takes lambda for white noise of covariance Lambda0 */
} hnav_ins_error_form;

typedef enum hnav_noise_scaling { /* of Qv, by channel; not for the printed forms */
    HNAV_NOISE_SCALING_NONE = 0,
    HNAV_NOISE_SCALING_PAPER_MATCH = 1, /* innovation covariance matching over a window, never below 1 */
    HNAV_NOISE_SCALING_GATED_MATCH = 2, /* the same behind a chi-square test of conditional innovations */
    HNAV_NOISE_SCALING_HMM = 3          /* a hidden Markov chain over noise levels */
} hnav_noise_scaling;

/* Make them with hnav_ins_error_defaults; hnav_ins_error_option() tells unit, range and meaning at run time. */
typedef struct hnav_ins_error_options {
    uint64_t cookie;                 /* set by hnav_ins_error_defaults */
    double gate_alpha;               /* GATED_MATCH: false alarms per test of a window */
    double hmm_level_ratio;          /* HMM: levels 1, r, r^2, ... of the variance */
    double hmm_fault_probability;    /* healthy to faulty, per step, shared by the faulty levels */
    double hmm_recovery_probability; /* faulty to healthy, per step */
    double hmm_drift_probability;    /* faulty to the neighbouring faulty levels, per step, together */
    int32_t form;                    /* hnav_ins_error_form */
    int32_t noise_scaling;           /* hnav_noise_scaling */
    int32_t window;                  /* M, steps: AMDKF, PAPER_MATCH, GATED_MATCH */
    int32_t hmm_levels;
    int32_t lag;                     /* 1: outputs are of the step before the newest sample, smoothed by it */
    int32_t joseph;                  /* 1: covariance in Joseph's form; the printed forms have none */
} hnav_ins_error_options;

/* AUGMENTED, HMM, no lag, Joseph. */
HNAV_API hnav_ins_error_options hnav_ins_error_defaults(void);

/* Rows 0, 1, ...; null beyond the last. */
HNAV_API const hnav_option_info *hnav_ins_error_option(int32_t index);

/* Row-major matrices, owned by the caller, copied by create. Sizes 1 to 32; nu may be 0. */
typedef struct hnav_ins_error_model {
    int32_t nx, nu, nz, nw, nl;
    /* 0: the matrices are those of one step. Above: A, B, G, Qw and An, Bn, QU belong to dx/dt = A x + B u + G w and
     * dlambda/dt = An lambda + Bn U with spectral densities Qw and QU; they are discretised exactly, u held. */
    double interval_s;
    const double *A;       /* nx x nx */
    const double *B;       /* nx x nu; not read when nu = 0 */
    const double *G;       /* nx x nw; null: the identity */
    const double *H;       /* nz x nx */
    const double *An;      /* nz x nz; null: no coloured errors; Bn, QU and Lambda0 are not read */
    const double *Bn;      /* nz x nl; null: the identity */
    const double *Qw;      /* nw x nw */
    const double *Qv;      /* nz x nz; diagonal unless noise_scaling is NONE */
    const double *QU;      /* nl x nl */
    const double *Lambda0; /* nz x nz; null: the stationary covariance of lambda */
    const double *x0;      /* nx; null: zero */
    const double *P0;      /* nx x nx */
} hnav_ins_error_model;

/* Refused, with a message that names the matrix: sizes out of range (SIZE), null (NULL_ARGUMENT) or non-finite
 * (NON_FINITE) matrices; covariances that are not symmetric or not positive semidefinite, An that lets lambda grow, an
 * unstable mode of A that the measurements do not show (all OPTION). */
HNAV_API hnav_status hnav_ins_error_filter_create(hnav_ins_error_filter **filter, const hnav_ins_error_options *options,
                                                  const hnav_ins_error_model *model, char *message, size_t message_size);
/* Null is allowed. */
HNAV_API void hnav_ins_error_filter_destroy(hnav_ins_error_filter *filter);
/* Back to x0 and P0, no samples, with the present model. */
HNAV_API hnav_status hnav_ins_error_filter_reset(hnav_ins_error_filter *filter);
/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char *hnav_ins_error_filter_message(const hnav_ins_error_filter *filter);
/* What is legal but doubtful about the model, "" if nothing: states and coloured errors that separate poorly. */
HNAV_API const char *hnav_ins_error_filter_warning(const hnav_ins_error_filter *filter);
/* For a mode of A with eigenvalue mu and shape a, |(mu - An) H a| / (|(1 - mu) H a| + |(1 - An) H a|) in units of
 * sigma(lambda); the least over the modes. 0: a mode moves the measurements just as lambda does; 1: nothing like it. */
HNAV_API hnav_status hnav_ins_error_filter_separability(const hnav_ins_error_filter *filter, double *separability);
/* Other matrices of the same sizes from the next step on (time-varying systems): A, B, G, Qw, An, Bn, QU lead to that
 * step, H and Qv are of its sample. x0, P0 and Lambda0 count again at a reset. Errors as of create. */
HNAV_API hnav_status hnav_ins_error_filter_replace_model(hnav_ins_error_filter *filter, const hnav_ins_error_model *model);

/* One step: u (nu) was held since the last step and is not read by the first, whose prior is x0 and P0; z (nz). A channel
 * is missing when its z is NaN, or when present (nz, null for all) is 0 there. Errors: NON_FINITE (u, infinite z), SOLVER
 * (a covariance without its sign, or an estimate without bound). */
HNAV_API hnav_status hnav_ins_error_filter_step(hnav_ins_error_filter *filter, const double *u, const double *z,
                                                const uint8_t *present);

/* Outputs are of the newest step, or of the one before it (MDKF, AMDKF, lag = 1). Null outputs are not written. */
HNAV_API hnav_status hnav_ins_error_filter_estimate(const hnav_ins_error_filter *filter, double *x, double *sigma); /* nx */
HNAV_API hnav_status hnav_ins_error_filter_covariance(const hnav_ins_error_filter *filter, double *P); /* nx x nx */
/* lambda (nz), its sigma, and the compensated measurement z - lambda, NaN where z is missing. Forms other than AUGMENTED
 * have no state lambda and answer z - H x, which is lambda + v. */
HNAV_API hnav_status hnav_ins_error_filter_coloured_error(const hnav_ins_error_filter *filter, double *lambda, double *sigma,
                                                          double *compensated);
/* Of the newest sample: innovation (nz, NaN where there was none), its covariance S (nz x nz) with the noise that was
 * used, and NIS over the present channels. NO_DATA before the first sample. In MDKF and AMDKF S need not be a covariance,
 * and NIS can be negative: so are their equations. */
HNAV_API hnav_status hnav_ins_error_filter_innovation(const hnav_ins_error_filter *filter, double *innovation, double *S,
                                                      double *nis);
/* By channel (nz): factor on Qv (on R in AMDKF), and the probability that it is above 1 (HMM; 0 or 1 by the gate of
 * GATED_MATCH; 0 otherwise). */
HNAV_API hnav_status hnav_ins_error_filter_noise(const hnav_ins_error_filter *filter, double *scale, double *fault_probability);

typedef struct hnav_ins_error_status {
    uint64_t steps;      /* done since create or reset */
    uint64_t shown_step; /* the step, counted from 0, that the outputs are about */
    int32_t nx, nu, nz;
    int32_t estimates_lambda; /* lambda is a state */
} hnav_ins_error_status;
HNAV_API hnav_status hnav_ins_error_filter_get_status(const hnav_ins_error_filter *filter, hnav_ins_error_status *status);

/* Arrays in, arrays out: n rows, each one step. Equal, bit for bit, to step after step. */
typedef struct hnav_ins_error_run_input {
    const double *u;        /* n x nu: row k is the u of step k, held from step k - 1 on; may be null when nu = 0 */
    const double *z;        /* n x nz */
    const uint8_t *present; /* n x nz, may be null */
} hnav_ins_error_run_input;

typedef struct hnav_ins_error_run_output { /* null: not written; row k is what the outputs show after step k */
    double *x, *sigma;                     /* n x nx */
    double *covariance;                    /* n x nx x nx */
    double *lambda, *lambda_sigma, *compensated, *innovation; /* n x nz */
    double *nis;                           /* n */
    double *noise_scale, *fault_probability; /* n x nz */
} hnav_ins_error_run_output;

/* rows_done (may be null): rows that are complete; less than n only after an error. */
HNAV_API hnav_status hnav_ins_error_filter_run(hnav_ins_error_filter *filter, size_t n, const hnav_ins_error_run_input *input,
                                               const hnav_ins_error_run_output *output, size_t *rows_done);

/* As for hnav_filter: numbers only; fits filters made with equal options and model. A model that was replaced since
 * create is not part of it: replace it again after load. */
HNAV_API hnav_status hnav_ins_error_filter_state_size(const hnav_ins_error_filter *filter, size_t *bytes);
HNAV_API hnav_status hnav_ins_error_filter_save(const hnav_ins_error_filter *filter, void *buffer, size_t bytes);
/* SIZE, STATE_CORRUPT: the filter is as it was. */
HNAV_API hnav_status hnav_ins_error_filter_load(hnav_ins_error_filter *filter, const void *buffer, size_t bytes);
/* ------------------------------------------------------------------------------------------------ calibration */

/* Magnetometer calibration from a recording of a sensor that was turned about all axes (a figure of eight in the air),
 * far from iron that does not turn with it: hard iron, soft iron, scale and misalignment, and the rotation between the
 * axes of the field and those of the force. An ellipsoid is fitted (Li and Griffiths 2004), gravity gives the rotation
 * that it leaves open, both are refined together (Kok, Hol, Schon, Gustafsson, Luinge 2012), outliers lose their weight.
 *
 *     corrected = matrix (field - offset)
 *
 * All thresholds are free of units. Make the options with hnav_magnetometer_defaults, then change what you need. */
typedef struct hnav_magnetometer_options {
    uint64_t cookie;              /* set by hnav_magnetometer_defaults */
    double outlier_sigma;         /* beyond this many robust standard deviations a sample is an outlier; [1, 100] */
    double condition_limit;       /* refuse the full fit when condition exceeds it; > 1 */
    double ambiguity_limit;       /* refuse it when ambiguity exceeds it; (0, 1] */
    double coverage_limit;        /* refuse it when coverage is below; [0, 1) */
    double axis_ratio_limit;      /* refuse it when axis_ratio exceeds it; > 1 */
    double direction_sigma_limit_rad; /* do without the rotation, then refuse, when direction_sigma_rad exceeds it; > 0 */
    double force_tolerance;       /* a force is gravity when its length is this near to the median, relative; (0, 1] */
    int32_t samples_least;        /* attitudes needed, and attitudes with gravity for the rotation; >= 13 */
    int32_t robust;               /* 1: outliers lose their weight; 0: plain least squares */
    int32_t allow_hard_iron_only; /* 1: where the full fit is refused, answer with the offset alone */
    int32_t reserved;             /* 0 */
} hnav_magnetometer_options;

HNAV_API hnav_magnetometer_options hnav_magnetometer_defaults(void);

typedef enum hnav_magnetometer_fit {
    HNAV_MAGNETOMETER_FULL = 0,          /* offset and matrix, rotation included */
    HNAV_MAGNETOMETER_NO_ROTATION = 1,   /* none that force shows: matrix symmetric, which turns the field least */
    HNAV_MAGNETOMETER_HARD_IRON_ONLY = 2 /* offset; matrix is the identity */
} hnav_magnetometer_fit;

typedef struct hnav_magnetometer_calibration {
    double offset[3];             /* hard iron, in the unit and axes of the field */
    double matrix[9];             /* row-major, determinant 1: the strength is kept on the mean over all directions */
    double strength;              /* of the corrected field, in its unit */
    double dip_rad;               /* of the field, positive down; NaN without force */
    double residual_before;       /* scatter of |field|, relative, rms over the samples that are no outliers */
    double residual_after;        /* of |corrected| */
    double dip_spread_before_rad; /* robust standard deviation of the angle to gravity; NaN without force */
    double dip_spread_after_rad;
    double outlier_fraction;      /* of the used samples, [0, 1] */
    double coverage;              /* 1: directions spread evenly over the sphere; 0: all in a plane */
    double condition;             /* largest over second smallest eigenvalue of the quadric's scatter; 0: not reached */
    double ambiguity;             /* smallest over second smallest: near 1, another ellipsoid fits as well */
    double axis_ratio;            /* longest over shortest axis of the ellipsoid; of the refused one, or 1 */
    double direction_sigma_rad;   /* standard error of the corrected direction, rms over the sphere; NaN: offset_axes 2 */
    uint64_t samples;             /* rows with a field */
    uint64_t used_samples;        /* of these, rows that saw a new attitude: a rest counts once */
    uint64_t force_samples;       /* of these, rows whose force was taken for gravity */
    int32_t fit;                  /* hnav_magnetometer_fit */
    int32_t offset_axes;          /* 3, or 2 when the samples lie in a plane: across it offset is zero */
} hnav_magnetometer_calibration;

/* field: n x 3, in any unit; force_b_m_s2: n x 3 of the same instants, may be null. A row of three NaN is a missing
 * sample. options: null for the defaults. calibration: written on success only. message (may be null): why the call
 * failed; after a success "", or why the answer is hard iron only.
 * Errors: NULL_ARGUMENT, OPTION, OPTIONS_STAMP, OUT_OF_MEMORY, NON_FINITE, OUT_OF_RANGE, and ILL_CONDITIONED when the
 * samples are too few, do not vary, lie in a plane, cover too little of the sphere or are no ellipsoid. */
HNAV_API hnav_status hnav_calibrate_magnetometer(size_t n, const double *field, const double *force_b_m_s2,
                                                 const hnav_magnetometer_options *options,
                                                 hnav_magnetometer_calibration *calibration,
                                                 char *message, size_t message_size);

#ifdef __cplusplus
}
#endif

#endif /* HNAV_H */
