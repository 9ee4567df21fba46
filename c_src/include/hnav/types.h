/* What every header of hnav begins with: status codes, version, the sensors, the choices that filters share, and the
 * description of an option. */
#ifndef HNAV_TYPES_H
#define HNAV_TYPES_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32) && defined(HNAV_SHARED)
#ifdef HNAV_BUILD
#define HNAV_API __declspec(dllexport)
#else
#define HNAV_API __declspec(dllimport)
#endif
#elif defined(__GNUC__) && defined(HNAV_SHARED)
#define HNAV_API __attribute__((visibility("default")))
#else
#define HNAV_API
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
HNAV_API const char* hnav_status_text(hnav_status status);

/* "MAJOR.MINOR.PATCH" */
HNAV_API const char* hnav_version(void);

/* ------------------------------------------------------------------------------------------------ choices that filters share */

typedef enum hnav_sensor {
    HNAV_SENSOR_GYRO = 0,
    HNAV_SENSOR_ACCEL = 1,
    HNAV_SENSOR_MAG = 2,
    HNAV_SENSOR_HEADING = 3
} hnav_sensor;
enum { HNAV_SENSOR_COUNT = 4 };

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

/* ------------------------------------------------------------------------------------------------ options */

typedef enum hnav_preset {
    HNAV_PRESET_DEFAULT = 0, /* real sensors, one setting for all */
    HNAV_PRESET_PAPER = 1    /* the source paper's Q and R, two Euler steps per sample at 100 Hz, P0 and gamma fitted */
} hnav_preset;

typedef enum hnav_option_kind { HNAV_OPTION_REAL = 0, HNAV_OPTION_INTEGER = 1, HNAV_OPTION_CHOICE = 2 } hnav_option_kind;

/* One row of the option table: create checks by it, the FMU takes its parameters from it, Python its names. */
typedef struct hnav_option_info {
    const char* name;           /* the field of the options struct */
    const char* unit;           /* "rad", "1/s", ...; "" when it has none */
    const char* description;    /* one sentence */
    const char* const* choices; /* CHOICE: names of 0, 1, ... in the order of the enum; null otherwise */
    size_t offset;              /* of the field in the struct, bytes */
    double min, max;            /* inclusive, for each component */
    int32_t count;              /* components: 1, 3 or 4 */
    int32_t choice_count;
    hnav_option_kind kind;      /* REAL fields are double, the others int32_t */
    int32_t min_is_open;        /* 1 when min itself is excluded */
} hnav_option_info;

#ifdef __cplusplus
}
#endif

#endif /* HNAV_TYPES_H */
