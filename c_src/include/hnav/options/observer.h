/* Made by c_src/options/generate.py from observer.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_OBSERVER_H
#define HNAV_OPTIONS_OBSERVER_H

#include <stddef.h>
#include <stdint.h>

/* Time of the start state. */
typedef enum hnav_observer_start {
    HNAV_OBSERVER_START_FIRST_SAMPLE = 0, /* at the first sample, of an input or a sensor */
    HNAV_OBSERVER_START_GIVEN = 1         /* at start_time_s; samples before it are not used */
} hnav_observer_start;

/* Propagation of the covariance. */
typedef enum hnav_observer_propagation {
    HNAV_OBSERVER_PROPAGATION_DERIVATIVES = 0, /* by the derivatives of the plant */
    HNAV_OBSERVER_PROPAGATION_SIGMA_POINTS = 1 /* by 2N points that are taken along, for plants without events */
} hnav_observer_propagation;

/* Options of the observer, the estimator for a plant of one's own. What belongs to the plant, its noise and its sensors,
 * stands in hnav_observer_statistics.
 * Make them with hnav_observer_defaults, then change what you need; hnav_option("observer", i) states all this at run
 * time. */
typedef struct hnav_observer_options {
    size_t size;    /* of this struct in bytes; set by hnav_observer_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    /* ------------------------ start
     * Where the estimate begins. */

    /* Time of the start state: the first sample, or start_time_s.
     * hnav_observer_start, default first_sample. Recordings begin at any time; the state of the plant before is unknown. */
    int32_t start_mode;
    /* Time of the start state in mode given; in the other mode the time at which the plant is first evaluated.
     * [-1e12, 1e12] s, default 0. Where simulations begin. */
    double start_time_s;

    /* ------------------------ timing
     * Samples that come late. */

    /* Largest age of a late sample relative to the newest one.
     * [0, 1e3] s, default 0. Samples are in order; a horizon costs memory and the replay of all events within it. */
    double horizon_s;
    /* Number of events that can wait or be within the horizon.
     * [4, 1e6], default 64. Enough for an advance after every few dozen samples, and little memory. */
    int32_t queue_capacity;

    /* ------------------------ fault
     * Samples and stamps beyond belief. */

    /* A sample is an outlier if it differs from the previous one and from the prediction by more sigmas than this, unless
     * the next one agrees with it; 0 = no test.
     * [0, 1e6], default 10. Far beyond noise and an early bounce; transmission errors are larger. */
    double outlier_sigma;
    /* Time stamps that run back further start a new time base; a single stamp ten times as far ahead is rejected; 0 =
     * never.
     * [0, 1e6] s, default 1. Longer than usual latencies, shorter than usual clock corrections. */
    double time_jump_limit_s;

    /* ------------------------ solver
     * Accuracy between samples. */

    /* Propagation of the covariance: by derivatives, or by sigma points if the plant has none, as with tables and relays;
     * sigma points require a plant without events.
     * hnav_observer_propagation, default derivatives. Derivatives are faster, and accurate if the plant is smooth over a
     * sigma. */
    int32_t propagation;
    /* Relative tolerance of the states; the absolute one is this times the scale of a state.
     * [1e-12, 1e-2], default 1e-7. Far below sensor noise, and for most plants an interval is still one step. */
    double rtol;
    /* Relative tolerance of the transition matrix and of the process noise.
     * [1e-12, 0.1], default 1e-4. Four digits of a sigma are sufficient; the tolerance of the states would double the
     * evaluations of the plant. */
    double covariance_rtol;
    /* Largest number of solver steps in one interval; beyond it the sample is dropped.
     * [10, 1e8], default 20000. A second of computing; a plant that needs more is stiff. */
    int32_t max_steps;

    /* ------------------------ robust
     * Against models that are not quite right. */

    /* Fading memory: before a correction, T after the last, the largest variance in units of the scales grows by exp(rate
     * T), others by less. 0: off.
     * [0, 1e6] 1/s, default 0. Known process noise is preferable. */
    double robust_rate_1_s;
} hnav_observer_options;

#endif /* HNAV_OPTIONS_OBSERVER_H */
