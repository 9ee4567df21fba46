/* Observer: the states of your own plant from its sensors, with their covariance. The plant is given by callbacks:
 *
 *     x' = f(t, x, u, p) + w,   y = h(t, x, u, p) + v
 *
 *     hnav_plant plant = {.size = sizeof plant, .n_states = 2, .n_outputs = 1, .context = &mine, .derivatives = f, .outputs = h};
 *     hnav_observer_statistics known = {.size = sizeof known, .start = x0, .start_sigma = sigma0, .noise = q, .sensor_sigma = r};
 *     hnav_observer_options options = hnav_observer_defaults();
 *     hnav_filter* observer;
 *     hnav_observer_create(&observer, &options, &plant, &known, message, sizeof message);
 *     while (...) {
 *         hnav_observer_push(observer, 0, t_s, y);
 *         hnav_filter_advance(observer, t_s);
 *         hnav_observer_estimate(observer, x, sigma);
 *     }
 *     hnav_filter_destroy(observer);
 *
 * The estimate X has N numbers: the states, then the unknown inputs, then the parameters. Units are the plant's, times
 * seconds. Between samples SUNDIALS integrates the states and their transition matrix; the samples of an instant correct
 * together (extended Kalman filter, Joseph's form), inputs of that instant before sensors. The same samples give the same bits
 * for any times of output.
 *
 * A plant may have events of its own (hnav_plant.event): indicators that leave their domain, z > 0 or z <= 0, times that it
 * announces, or new inputs. The covariance passes them by the saltation matrix. If an event may or may not have occurred, the
 * estimate splits into up to four hypotheses. */
#ifndef HNAV_OBSERVER_H
#define HNAV_OBSERVER_H

#include "hnav/filter.h"
#include "hnav/options/observer.h"

#ifdef __cplusplus
extern "C" {
#endif

HNAV_API hnav_observer_options hnav_observer_defaults(void);

/* ------------------------------------------------------------------------------------------------ plant */

/* A function of the plant at a point: x (n_states), u (n_inputs), p (n_parameters). It writes values and returns 0; 1 if
 * there is no value at this point (the solver tries a nearer one), as for a number that is not finite; -1 if there is none at
 * all. The same point must give the same values. Must not call the observer that calls it. */
typedef int (*hnav_plant_function)(void* context, double t_s, const double* x, const double* u, const double* p, double* values);
/* The same at several points of one time: x, u, p and values have a row for each. Any other answer than 0: they are asked one by one. */
typedef int (*hnav_plant_points_function)(void* context, int32_t count, double t_s, const double* x, const double* u,
                                          const double* p, double* values);

typedef struct hnav_plant {
    size_t size; /* of this struct; set by the caller */
    int32_t n_states; /* 1 or more */
    int32_t n_inputs; /* all of them */
    int32_t n_unknown_inputs; /* the last of the inputs: not sampled, but estimated */
    int32_t n_parameters; /* estimated ones */
    int32_t n_outputs; /* sensors, 1 or more */
    void* context; /* handed to the functions */
    hnav_plant_function derivatives; /* n_states */
    hnav_plant_function outputs; /* n_outputs */
    /* Derivatives of either by X: n_states x N and n_outputs x N, row-major. Null: differences. create compares them
     * with differences and does not use wrong ones; see hnav_observer_proof. */
    hnav_plant_function derivatives_jacobian;
    hnav_plant_function outputs_jacobian;

    /* Events; null and 0 for a plant without. The values then depend on the arguments only, otherwise also on the discrete
     * state, which only event changes. */
    int32_t n_indicators;
    int32_t n_discrete; /* numbers of the discrete state */
    hnav_plant_function indicators; /* n_indicators */
    /* An event at this point, possibly with new inputs: replaces the states in values (n_states) by those after it and changes
     * the discrete state. It is called several times from the same discrete state, for the saltation matrix of the
     * covariance. */
    hnav_plant_function event;
    double (*next_event_s)(void* context, double t_s); /* time of the next time event, as the last event left it;
                                                          infinite for none. Null: never */
    void (*get_discrete)(void* context, double* discrete);
    void (*set_discrete)(void* context, const double* discrete);

    /* For functions that cost more to call than to evaluate: all points of a Jacobian by differences in one call. The values have to be
     * those of derivatives and outputs. Null: one call for each point. */
    hnav_plant_points_function derivatives_at_points;
    hnav_plant_points_function outputs_at_points;
} hnav_plant;

/* Copied by create. Lengths: N unless stated otherwise. Null selects the default where there is one. */
typedef struct hnav_observer_statistics {
    size_t size; /* of this struct; set by the caller */
    const double* start; /* X at the start; null: zero */
    const double* start_sigma; /* its standard deviations, at least 0; not null */
    const double* noise; /* process noise of X, unit / sqrt(s), at least 0; null: none */
    const double* nominal; /* usual sizes, beside start and start_sigma the scale of tolerances; null: 1 */
    const double* ready_sigma; /* see hnav_observer_info.ready; above 0; infinite and null: no limit */
    const double* time_constant_s; /* n_unknown_inputs: d' = -d / tau + w; 0 and null: random walk */
    const double* input_start; /* known inputs before their first sample; null: zero */
    const double* sensor_sigma; /* n_outputs: white noise of a sample, above 0; not null */
    const double* gate_nis; /* n_outputs: once ready, the variance of a sample of larger NIS is inflated by NIS / gate;
                                      0 and null: never */
    /* Bounds of X. The Gaussian is truncated there: estimate and covariance are the moments of the truncated density, and the plant is
     * not evaluated outside. Infinite and null: none. */
    const double *min, *max;
    const uint8_t*
        logarithmic; /* n_parameters: 1: positive, estimated by its logarithm; start, sigmas, noise and bounds stay those of the
                                   parameter itself, noise as it is at the start. Null: none */
} hnav_observer_statistics;

/* Refused, with a message that names what is wrong: sizes (SIZE; known inputs and sensors together at most 62), null (NULL_ARGUMENT),
 * numbers that are not finite (NON_FINITE) or invalid (OPTION), more than 1 GiB of memory (OPTION; some 1500 numbers), a plant that fails
 * at the start (SOLVER), or one whose values depend on earlier calls (UNSUPPORTED). The plant is evaluated some hundred times within three sigma
 * of its start. */
HNAV_API hnav_status hnav_observer_create(hnav_filter** filter, const hnav_observer_options* options, const hnav_plant* plant,
                                          const hnav_observer_statistics* known, char* message, size_t message_size);
/* The same for an FMU of FMI 2 or 3 in Model Exchange, unpacked into a folder. Beside its modelDescription.xml is observer.plan, a text
 * with the states, inputs and sensors and their statistics (hnav.Plan of the Python package writes it; c_src/observer/plan.hpp lists
 * its lines). An FMU is native code with all rights of the program. An FMU with events must support getting and setting its state.
 * One instance exists at a time: the instance of the derivative check is freed before the next is made. Another observer of the FMU
 * loads a copy of its library, after a trial that two instances do not disturb each other. Further errors: a damaged plan or an FMU that
 * cannot be loaded (OPTION, with its message), a second observer if instances disturb each other or only one may exist (SOLVER), a
 * library built without the headers of FMI (UNSUPPORTED). Memory that the FMU allocates is its own. */
HNAV_API hnav_status hnav_observer_open(hnav_filter** filter, const hnav_observer_options* options, const char* folder,
                                        char* message, size_t message_size);
/* The same; entries of known that are not null replace those of the plan. Lengths are those of the plan. */
HNAV_API hnav_status hnav_observer_open_known(hnav_filter** filter, const hnav_observer_options* options, const char* folder,
                                              const hnav_observer_statistics* known, char* message, size_t message_size);
/* ------------------------------------------------------------------------------------------------ samples */

/* A known input has this value from t_s on; a sensor (output of the plant) measures it at t_s. Errors: OUT_OF_RANGE (no such
 * input or sensor, time), NON_FINITE, LATE_SAMPLE (dropped and counted), QUEUE_FULL. */
HNAV_API hnav_status hnav_observer_push_input(hnav_filter* filter, int32_t input, double t_s, double value);
HNAV_API hnav_status hnav_observer_push(hnav_filter* filter, int32_t sensor, double t_s, double value);

/* ------------------------------------------------------------------------------------------------ estimate */

/* At the time of the last advance; before the first sample the start values. N each; null is not written. */
HNAV_API hnav_status hnav_observer_estimate(const hnav_filter* filter, double* x, double* sigma);
/* As estimate, just after the newest used sample: the same bits for any times of output. */
HNAV_API hnav_status hnav_observer_posterior(const hnav_filter* filter, double* x, double* sigma);

typedef struct hnav_observer_innovation_of {
    size_t size; /* of this struct; set by the caller */
    double innovation; /* of the newest used sample: measured minus predicted */
    double sigma; /* predicted standard deviation of the innovation */
    double nis; /* its normalised square: 1 in the mean */
    double mean_nis; /* over about the last 50 */
    uint64_t samples; /* used */
    uint64_t inflated; /* by the gate */
} hnav_observer_innovation_of;
/* Errors: OUT_OF_RANGE, NO_DATA before its first sample. */
HNAV_API hnav_status hnav_observer_innovation(const hnav_filter* filter, int32_t sensor, hnav_observer_innovation_of* out);

typedef struct hnav_observer_info {
    size_t size; /* of this struct; set by the caller */
    int32_t n_estimated; /* N */
    int32_t begun; /* the estimate has begun */
    /* Every sigma is below its ready_sigma, with as much information from samples as that corresponds to, and the mean NIS of
     * every sensor with samples is within its 99.9 % limits. It ends after three corrections that violate this, or when a sigma
     * grows beyond its limit. */
    int32_t ready;
    int32_t repeatable; /* repeated evaluations of the plant agree bit for bit, and so does the observer */
    double now_s; /* time of the estimate; -infinity before the first advance */
    double newest_s; /* of the newest used sample; -infinity before the first */
    double late_limit_s; /* older samples are refused */
    uint64_t events; /* instants that were used */
    uint64_t corrections; /* those with a sensor */
    uint64_t late, non_finite, dropped; /* samples; instants without a usable estimate */
    uint64_t flow_evaluations, steps; /* of the solver */
    int32_t parts; /* hypotheses of the estimate, which differ in the events that have occurred */
    double largest_part; /* weight of the largest, 0 to 1 */
    uint64_t plant_events; /* events with an effect, of the largest part */
    uint64_t splits;
    uint64_t grazing; /* guards hardly crossed or missed, or crossed with another: sigma points replace derivatives */
    uint64_t chattering; /* events beyond the fiftieth of an interval: the covariance is not propagated through them */
    uint64_t projected; /* corrections that were put back before a guard */
    int32_t n_indicators; /* of the plant */
    int32_t crosses; /* the plant has events of its own */
    uint64_t outliers, stuck; /* samples that were rejected, of all sensors */
    uint64_t stamps_left_out; /* samples rejected because their stamp was far ahead of all others */
    uint64_t clock_jumps; /* new time bases after stamps ran back */
    uint64_t
        held; /* intervals over the rest of which the plant failed: the estimate was held, its covariance was increased, and it was
                      not ready */
} hnav_observer_info;
HNAV_API hnav_status hnav_observer_get_info(const hnav_filter* filter, hnav_observer_info* info);

/* Results of the check of the plant's derivatives, block by block. */
typedef enum hnav_plant_block {
    HNAV_DERIVATIVES_BY_STATES = 0,
    HNAV_DERIVATIVES_BY_UNKNOWN_INPUTS = 1,
    HNAV_DERIVATIVES_BY_PARAMETERS = 2,
    HNAV_OUTPUTS_BY_STATES = 3,
    HNAV_OUTPUTS_BY_UNKNOWN_INPUTS = 4,
    HNAV_OUTPUTS_BY_PARAMETERS = 5
} hnav_plant_block;

typedef struct hnav_observer_block_proof {
    size_t size; /* of this struct; set by the caller */
    int32_t offered; /* by the plant */
    int32_t exact; /* confirmed by differences at five points; otherwise differences are used instead */
    int32_t row, column; /* of the worst element: derivative or output, number of X */
    double stated, measured; /* value of the plant, value by differences */
} hnav_observer_block_proof;
HNAV_API hnav_status hnav_observer_proof(const hnav_filter* filter, hnav_plant_block block, hnav_observer_block_proof* proof);

/* ------------------------------------------------------------------------------------------------ arrays */

/* n rows, each one instant; NaN: no sample. Equal, bit for bit, to push and advance row by row. */
typedef struct hnav_observer_run_input {
    size_t size; /* of this struct; set by the caller */
    const double* t_s; /* n, never running back */
    const double* sensors; /* n x n_outputs */
    const double* inputs; /* n x known inputs; null: no samples of any */
} hnav_observer_run_input;

typedef struct hnav_observer_run_output { /* null: not written */
    size_t size; /* of this struct; set by the caller */
    double *x, *sigma; /* n x N */
    double* covariance; /* n x N x N */
    double *innovation, *innovation_sigma, *nis; /* n x n_outputs, NaN where the row has no sample or it was not used */
    uint8_t* ready; /* n */
    double* log_likelihood; /* n: of the samples of a row, given the previous ones; NaN without a sample */
    uint8_t* parts; /* n: see hnav_observer_info */
    double* plant_events; /* n: events that have occurred, mean of the parts */
    uint8_t* failed; /* n: 0; plus 1: the plant failed and the samples were dropped; plus 2: the estimate was held before it */
} hnav_observer_run_output;

/* A row for which the plant fails is dropped and counted, or the estimate is held before it (see hnav_observer_info.held), and the run
 * continues; hnav_filter_message has the reason of the first. rows_done (may be null): less than n only after an error:
 * NON_FINITE (time, infinite samples), TIME_BACKWARDS. */
HNAV_API hnav_status hnav_observer_run(hnav_filter* filter, size_t n, const hnav_observer_run_input* input,
                                       const hnav_observer_run_output* output, size_t* rows_done);

/* As run, with hindsight: x, sigma and covariance of each row are from all samples, before and after it (Rauch-Tung-Striebel over the
 * whole mixture, through events too). The other outputs are those of the filter, except ready: at this row or a later one. Rows before
 * the start are not smoothed. From the start of the plant; the filter itself is unchanged. Takes about twice as long as run, and
 * 8 (N + 1.5 N^2) bytes a row. Errors: as of run, OUT_OF_MEMORY. */
HNAV_API hnav_status hnav_observer_smooth(hnav_filter* filter, size_t n, const hnav_observer_run_input* input,
                                          const hnav_observer_run_output* output);

/* ------------------------------------------------------------------------------------------------ hybrid view */

/* n_indicators of them (hnav_observer_info) at x; null: at the x of hnav_filter_show. 1 before the estimate has begun.
 * Error: SOLVER (the plant fails there). */
HNAV_API hnav_status hnav_observer_indicators(const hnav_filter* filter, const double* x, double* z);
/* A step of the integrator has ended at x. wants_event: the plant has an event there; call jump. Error: SOLVER (it failed). */
HNAV_API hnav_status hnav_observer_step_done(hnav_filter* filter, const double* x, int32_t* wants_event);
#ifdef __cplusplus
}
#endif

#endif /* HNAV_OBSERVER_H */
