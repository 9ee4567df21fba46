/* Made by c_src/options/generate.py from observer.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_OBSERVER_H
#define HNAV_OPTIONS_OBSERVER_H

#include <stddef.h>
#include <stdint.h>

/* When the plant is in its start state. */
typedef enum hnav_observer_start {
    HNAV_OBSERVER_START_FIRST_SAMPLE = 0, /* at the first sample, of an input or a sensor */
    HNAV_OBSERVER_START_GIVEN = 1         /* at start_time_s; samples before it are not used */
} hnav_observer_start;

/* How the covariance goes from sample to sample. */
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

    /* When the plant is in its start state: at the first sample, or at start_time_s.
     * hnav_observer_start, default first_sample. Recordings begin at any time; whatever the plant did before is not known. */
    int32_t start_mode;
    /* Time of the start state in mode given; in the other mode the time at which the plant is asked for its first answers.
     * [-1e12, 1e12] s, default 0. Where simulations begin. */
    double start_time_s;

    /* ------------------------ timing
     * Samples that come late. */

    /* How much older than the newest used sample a sample may be.
     * [0, 1e3] s, default 0. Samples come in order; a horizon costs memory and the replay of all that lies within it. */
    double horizon_s;
    /* Instants that may wait or lie within the horizon.
     * [4, 1e6], default 64. Enough for an advance after every few dozen samples, and little memory. */
    int32_t queue_capacity;

    /* ------------------------ fault
     * Samples and stamps beyond belief. */

    /* A sample is an outlier if it differs from the one before and from what is expected by more sigmas than this, unless
     * the next one agrees with it; 0 = none is looked for.
     * [0, 1e6], default 10. Far beyond what noise or a bounce that comes early does; an error of a transmission is larger. */
    double outlier_sigma;
    /* A sensor whose stamps run back further begins a new time base, a single stamp ten times as far ahead is left out; 0
     * = never.
     * [0, 1e6] s, default 1. Longer than samples are late, shorter than a clock is ever set. */
    double time_jump_limit_s;

    /* ------------------------ solver
     * Accuracy between samples. */

    /* How the covariance goes from sample to sample: by derivatives, or by sigma points where the plant has none, as with
     * tables and relays; these are for plants without events.
     * hnav_observer_propagation, default derivatives. Derivatives are faster, and right where the plant is smooth over a
     * sigma. */
    int32_t propagation;
    /* Relative tolerance of the states; the absolute one is this times the scale of a state.
     * [1e-12, 1e-2], default 1e-7. Far below what sensors measure, and an interval is still one step of most plants. */
    double rtol;
    /* The same of the transition matrix and of the noise that enters.
     * [1e-12, 0.1], default 1e-4. A sigma is wanted to four digits; with one tolerance for all the plant would be asked
     * twice as often. */
    double covariance_rtol;
    /* Steps of the solver in one interval, beyond which its sample is dropped.
     * [10, 1e8], default 20000. A second of computing; a plant that needs more is stiff. */
    int32_t max_steps;

    /* ------------------------ robust
     * Against models that are not quite right. */

    /* The largest variance, in units of the scales, grows by the factor exp(rate T) before a correction that comes T after
     * the last, others by less: what is long past is forgotten. 0: off.
     * [0, 1e6] 1/s, default 0. Noise that is known is better than what is forgotten without a reason. */
    double robust_rate_1_s;
} hnav_observer_options;

#endif /* HNAV_OPTIONS_OBSERVER_H */
