/* Common part of all headers: status codes, version, the sensors, and the description of an option. */
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
    HNAV_ERROR_NULL_ARGUMENT = 1,    /* a required pointer is null */
    HNAV_ERROR_OPTION = 2,           /* an invalid option; the message names the field */
    HNAV_ERROR_OPTIONS_STAMP = 3,    /* the options were not made by a *_defaults call of this version */
    HNAV_ERROR_OUT_OF_MEMORY = 4,    /* create could not allocate memory */
    HNAV_ERROR_NON_FINITE = 5,       /* NaN or infinity in a sample or time; the sample is dropped and counted */
    HNAV_ERROR_ZERO_VECTOR = 6,      /* a force or field of zero length has no direction; dropped and counted */
    HNAV_ERROR_OUT_OF_RANGE = 7, /* an argument outside its range (sigma not positive, unknown sensor, time beyond 1e12 s) */
    HNAV_ERROR_LATE_SAMPLE = 8, /* older than the committed estimate; dropped and counted */
    HNAV_ERROR_QUEUE_FULL = 9, /* more waiting samples than queue_capacity: advance first */
    HNAV_ERROR_TIME_BACKWARDS = 10, /* advance to a time before the last one */
    HNAV_ERROR_NOT_STARTED = 11, /* no attitude yet: waiting for samples */
    HNAV_ERROR_NO_DATA = 12, /* no sample of this sensor has been used yet */
    HNAV_ERROR_SIZE = 13, /* unknown size of a buffer or a struct */
    HNAV_ERROR_STATE_CORRUPT = 14, /* saved state damaged, or of another object: its model or options differ; see the message */
    HNAV_ERROR_SOLVER = 15, /* no usable estimate; the samples concerned were dropped */
    HNAV_ERROR_UNSUPPORTED = 16, /* not supported by this filter */
    HNAV_ERROR_ILL_CONDITIONED = 17, /* the data do not determine the answer; the message says what is missing */
    HNAV_ERROR_STATE_VERSION = 18 /* saved state of an incompatible version of hnav */
} hnav_status;

/* One line of English for a status; never null. */
HNAV_API const char* hnav_status_text(hnav_status status);

/* ------------------------------------------------------------------------------------------------ version */

/* Of these headers; within one minor version, structs stay as they are. */
#define HNAV_VERSION_MAJOR 0
#define HNAV_VERSION_MINOR 2
#define HNAV_VERSION_PATCH 0
#define HNAV_VERSION_TEXT_OF(major, minor, patch) #major "." #minor "." #patch
#define HNAV_VERSION_TEXT(major, minor, patch) HNAV_VERSION_TEXT_OF(major, minor, patch)
#define HNAV_VERSION HNAV_VERSION_TEXT(HNAV_VERSION_MAJOR, HNAV_VERSION_MINOR, HNAV_VERSION_PATCH) /* "MAJOR.MINOR.PATCH" */

/* "MAJOR.MINOR.PATCH" of the library that is linked. */
HNAV_API const char* hnav_version(void);

/* ------------------------------------------------------------------------------------------------ structs that grow */

/* A struct that a call reads or fills begins with its size, as the caller's compiler sees it:
 *
 *     hnav_attitude attitude = {.size = sizeof attitude};
 *     hnav_filter_attitude(filter, &attitude);
 *
 * Later versions may add fields at its end. A call writes no more than the caller's size and treats the fields beyond it as
 * zero, so that a program works with a newer library. A size of no version is refused with
 * HNAV_ERROR_SIZE. In C++: auto attitude = hnav_sized<hnav_attitude>(); */
#ifdef __cplusplus
} // extern "C"
template <class Struct>
Struct hnav_sized() {
    Struct made = Struct();
    made.size = sizeof made;
    return made;
}
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ options */

/* Each create call takes a struct hnav_..._options of hnav/options. A defaults call fills it; then change fields by
 * name:
 *
 *     hnav_ahrs_options options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
 *     options.declination_rad = 0.061;
 *
 * Programs that get the names at run time, such as readers of settings, use the rows of hnav_option. */

typedef enum hnav_option_kind { HNAV_OPTION_REAL = 0, HNAV_OPTION_INTEGER = 1, HNAV_OPTION_CHOICE = 2 } hnav_option_kind;

/* One option: source of the checks in create, the FMU's parameter and the name in Python. The library owns the rows. */
typedef struct hnav_option_info {
    const char* name; /* the field of the options struct; "yaw.motion" for one of a struct inside */
    const char* group; /* "noise", "start", ... */
    const char* unit; /* "rad", "1/s", ...; "" when it has none */
    const char* description; /* one sentence */
    const char* reason; /* why the default is what it is */
    const char* const* choices; /* CHOICE: names of 0, 1, ... in the order of the enum; null otherwise */
    const char* const* choice_descriptions; /* what each of them means */
    const double* default_values; /* count of them, of the first preset; of a choice its number */
    size_t offset; /* of the field in the struct, bytes */
    double min, max; /* for each component */
    int32_t count; /* components: 1, or the length of an array */
    int32_t choice_count;
    hnav_option_kind kind; /* REAL fields are double, the others int32_t */
    int32_t min_is_open, max_is_open; /* 1 when min or max itself is excluded */
    int32_t advanced; /* 0 for the dozen to look at first */
} hnav_option_info;

/* A set of values that a defaults call can fill in. */
typedef struct hnav_preset_info {
    const char* name; /* "default", "paper" */
    const char* description; /* one sentence */
    int32_t value; /* of hnav_preset */
} hnav_preset_info;

/* Rows 0, 1, ... of an option list; null beyond the last, and for a list that is none. of: "ahrs", "hrekf", "ins", "ins_error", "observer",
 * "magnetometer", "turntable", "imu_mag_sensor", "vehicle", "aid_sensor", "aircraft". */
HNAV_API const hnav_option_info* hnav_option(const char* of, int32_t index);
/* The presets of a list likewise. */
HNAV_API const hnav_preset_info* hnav_preset_of(const char* of, int32_t index);

/* One component of an option as a number, whatever its kind; NaN when the row has no such component or a pointer is null.
 * options: a struct of the options that the row is of. */
HNAV_API double hnav_option_value(const hnav_option_info* row, const void* options, int32_t component);
/* Errors: NULL_ARGUMENT; OUT_OF_RANGE when the row has no such component. create checks the
 * value. */
HNAV_API hnav_status hnav_set_option_value(const hnav_option_info* row, void* options, int32_t component, double value);

/* ------------------------------------------------------------------------------------------------ health */

/* State of a sensor. Stuck and saturated samples and outliers are rejected. Stuck and saturated rates are used, since there
 * is no other measurement of the rotation, and the sigma of the attitude grows by the turn that may be missing. */
typedef enum hnav_sensor_state {
    HNAV_SENSOR_STATE_OK = 0,
    HNAV_SENSOR_STATE_LATE = 1, /* within the last second a sample was refused: older than the committed estimate */
    HNAV_SENSOR_STATE_OUTLIER = 2, /* within the last second a sample deviated strongly from its neighbours */
    HNAV_SENSOR_STATE_STUCK = 3, /* an axis repeats one value although the body moves */
    HNAV_SENSOR_STATE_SATURATED = 4, /* an axis is at the end of its range */
    HNAV_SENSOR_STATE_MISSING = 5 /* no sample yet, or none for a second and ten of its usual intervals */
} hnav_sensor_state;

typedef struct hnav_sensor_health {
    double since_s; /* time at which the state began; NaN if it holds since the first sample */
    uint64_t outliers; /* samples so far */
    uint64_t stuck;
    uint64_t saturated;
    uint64_t late;
    uint64_t left_out; /* accepted by push and not used: outliers, stuck, saturated, stamps far ahead */
    int32_t state; /* hnav_sensor_state */
    int32_t axes; /* stuck or saturated now: bit 0 for x, 1 for y, 2 for z of the sensor's axes turned to the body */
} hnav_sensor_health;

#ifdef __cplusplus
}
#endif

#endif /* HNAV_TYPES_H */
