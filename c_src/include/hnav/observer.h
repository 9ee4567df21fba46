/* Observer: the states of a plant of one's own from its sensors, with their uncertainty. The plant is given by callbacks:
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
 * What is estimated, X, has N numbers: the states, then the unknown inputs, then the parameters. Units are the plant's, times
 * seconds. Between samples SUNDIALS integrates the states and their transition matrix; the samples of an instant correct
 * together (extended Kalman filter, Joseph's form), inputs of that instant before sensors. The same samples give the same bits
 * whatever times are asked for.
 *
 * A plant may have events of its own (hnav_plant.event): indicators that leave their domain, z > 0 or z <= 0, times that it names,
 * inputs that it acts on. The covariance goes through them by the saltation matrix, and where the samples do not tell whether one
 * has been, the estimate splits into up to four parts that differ in it. */
#ifndef HNAV_OBSERVER_H
#define HNAV_OBSERVER_H

#include "hnav/filter.h"
#include "hnav/options/observer.h"

#ifdef __cplusplus
extern "C" {
#endif

HNAV_API hnav_observer_options hnav_observer_defaults(void);

/* ------------------------------------------------------------------------------------------------ plant */

/* A function of the plant at a point: x (n_states), u (n_inputs), p (n_parameters). It writes values and answers 0; 1 when
 * there is no answer at this point (the solver tries a nearer one), as for a number that is not finite; -1 when there is none at
 * all. The same point must have the same answer. Must not call the observer that asks it. */
typedef int (*hnav_plant_function)(void* context, double t_s, const double* x, const double* u, const double* p, double* values);

typedef struct hnav_plant {
    size_t size;              /* of this struct; set by the caller */
    int32_t n_states;         /* 1 or more */
    int32_t n_inputs;         /* all of them */
    int32_t n_unknown_inputs; /* the last of the inputs: nobody samples them, they are estimated */
    int32_t n_parameters;     /* that are estimated */
    int32_t n_outputs;        /* sensors, 1 or more */
    void* context;            /* handed to the functions */
    hnav_plant_function derivatives; /* n_states */
    hnav_plant_function outputs;     /* n_outputs */
    /* Derivatives of either by X: n_states x N and n_outputs x N, row-major. Null: differences. What create does not find
     * confirmed by differences is not used; hnav_observer_proof tells. */
    hnav_plant_function derivatives_jacobian;
    hnav_plant_function outputs_jacobian;

    /* Events; null and 0 for a plant without. Then its answers depend on nothing but what it is given; otherwise on its discrete
     * state besides, which event changes and nothing else. */
    int32_t n_indicators;
    int32_t n_discrete; /* numbers of the discrete state */
    hnav_plant_function indicators; /* n_indicators */
    /* An event at this point, with inputs that are new there, if any: writes the states after it (n_states; they stand there
     * before it) and changes the discrete state. Asked as often as a matrix of its effects needs, each time from the same
     * discrete state. */
    hnav_plant_function event;
    double (*next_event_s)(void* context, double t_s); /* time of the next event that time brings, as the last event left it;
                                                          infinite for none. Null: never */
    void (*get_discrete)(void* context, double* discrete);
    void (*set_discrete)(void* context, const double* discrete);
} hnav_plant;

/* Copied by create. Lengths: N unless said otherwise. Null where a default stands for it. */
typedef struct hnav_observer_statistics {
    size_t size; /* of this struct; set by the caller */
    const double* start; /* X at the start; null: zero */
    const double* start_sigma; /* its standard deviations, at least 0; not null */
    const double* noise; /* white noise that drives X, unit / sqrt(s), at least 0; null: none */
    const double* nominal; /* usual sizes, beside start and start_sigma the scale of tolerances; null: 1 */
    const double* ready_sigma; /* see hnav_observer_info.ready; above 0; infinite and null: no limit */
    const double* time_constant_s; /* n_unknown_inputs: d' = -d / tau + w; 0 and null: random walk */
    const double* input_start; /* known inputs before their first sample; null: zero */
    const double* sensor_sigma; /* n_outputs: white noise of a sample, above 0; not null */
    const double* gate_nis; /* n_outputs: once ready, the variance of a sample of larger NIS is inflated by NIS / gate;
                                      0 and null: never */
    /* Bounds of X. Its Gaussian is cut there: estimate and covariance are the moments of what is left, and the plant is not asked
     * beyond. Infinite and null: none. */
    const double *min, *max;
    const uint8_t*
        logarithmic; /* n_parameters: 1: positive, estimated by its logarithm; start, sigmas, noise and bounds stay those of the
                                   parameter itself, noise as it is at the start. Null: none */
} hnav_observer_statistics;

/* Refused, with a message that names what is wrong: sizes (SIZE; N at most 64, known inputs and sensors together at most 62),
 * null (NULL_ARGUMENT), numbers that are not finite (NON_FINITE) or impossible (OPTION), a plant without an answer at the start
 * (SOLVER), or one that remembers what it was asked (UNSUPPORTED). The plant is asked some hundred times: in three sigma of
 * its start. */
HNAV_API hnav_status hnav_observer_create(hnav_filter** filter, const hnav_observer_options* options, const hnav_plant* plant,
                                          const hnav_observer_statistics* known, char* message, size_t message_size);
/* The same for an FMU of FMI 2 or 3 in Model Exchange, unpacked into a folder, where a plan stands beside its modelDescription.xml:
 * observer.plan, a text that says which variables are states, inputs and sensors, and what is known of them (hnav.Plan of the
 * Python package writes it; c_src/observer/plan.hpp lists its lines). FMUs are native code: one runs with all rights of the
 * program. One with events has to let its state be got and set. One instance lives at a time: that of the proof is freed before the next is made.
 * Another observer of the FMU loads a copy of its library, after a trial whether two leave each other alone. Refused besides: a plan that is damaged or
 * an FMU that cannot be loaded (OPTION, with its sentence), a second observer where two instances disturb each other or there may be one (SOLVER), a library built without the headers of FMI (UNSUPPORTED). Memory that
 * the FMU takes is the FMU's. */
HNAV_API hnav_status hnav_observer_open(hnav_filter** filter, const hnav_observer_options* options, const char* folder,
                                        char* message, size_t message_size);
/* The same, where what known has that is not null stands in place of what the plan says. Lengths as the plan has them. */
HNAV_API hnav_status hnav_observer_open_known(hnav_filter** filter, const hnav_observer_options* options, const char* folder,
                                              const hnav_observer_statistics* known, char* message, size_t message_size);
/* ------------------------------------------------------------------------------------------------ samples */

/* A known input has this value from t_s on; a sensor (output of the plant) reads it at t_s. Errors: OUT_OF_RANGE (no such
 * input or sensor, time), NON_FINITE, LATE_SAMPLE (dropped and counted), QUEUE_FULL. */
HNAV_API hnav_status hnav_observer_push_input(hnav_filter* filter, int32_t input, double t_s, double value);
HNAV_API hnav_status hnav_observer_push(hnav_filter* filter, int32_t sensor, double t_s, double value);

/* ------------------------------------------------------------------------------------------------ estimate */

/* At the time of the last advance; before the first sample that of the start. N each; null is not written. */
HNAV_API hnav_status hnav_observer_estimate(const hnav_filter* filter, double* x, double* sigma);
/* As estimate, just after the newest used sample: the same bits whatever times are asked for. */
HNAV_API hnav_status hnav_observer_posterior(const hnav_filter* filter, double* x, double* sigma);

typedef struct hnav_observer_innovation_of {
    size_t size; /* of this struct; set by the caller */
    double innovation; /* of the newest used sample: measured minus expected */
    double sigma; /* that it was expected to have */
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
    /* Every sigma is below its ready_sigma, by samples that brought as much information as that stands for, and the mean NIS of
     * every sensor that was heard lies where 99.9 % of such means do. Three corrections that deny it end it, and so does a sigma
     * that has grown beyond its limit since. */
    int32_t ready;
    int32_t repeatable; /* the plant answers bit for bit the same: so does the observer */
    double now_s; /* of what is shown; -infinity before the first advance */
    double newest_s; /* of the newest used sample; -infinity before the first */
    double late_limit_s; /* older samples are refused */
    uint64_t events; /* instants that were used */
    uint64_t corrections; /* those with a sensor */
    uint64_t late, non_finite, dropped; /* samples; instants that led to no estimate */
    uint64_t flow_evaluations, steps; /* of the solver */
    int32_t parts; /* into which the estimate is split: they differ in the events that have been */
    double largest_part; /* weight of the largest, 0 to 1 */
    uint64_t plant_events; /* that changed something, as the largest part has them */
    uint64_t splits;
    uint64_t grazing; /* guards hardly crossed or missed, or crossed with another: points go there in place of derivatives */
    uint64_t chattering; /* events beyond the fiftieth of an interval: the covariance does not go through them */
    uint64_t projected; /* corrections that were put back before a guard */
    int32_t n_indicators; /* of the plant */
    int32_t crosses; /* the plant has events of its own */
    uint64_t outliers, stuck; /* samples that were rejected, of all sensors */
    uint64_t stamps_left_out; /* samples whose stamp lay far ahead of all others */
    uint64_t clock_jumps; /* stamps ran back: a new time base began */
    uint64_t
        held; /* intervals for the rest of which the plant had no answer: the estimate was held there, its covariance has grown by what
                      was missed, and it was not ready */
} hnav_observer_info;
HNAV_API hnav_status hnav_observer_get_info(const hnav_filter* filter, hnav_observer_info* info);

/* What became of the derivatives that the plant offers, block by block. */
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
    double told, measured; /* there: by the plant, by differences */
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
    double* log_likelihood; /* n: of the samples of a row, given those before; NaN where there was none */
    uint8_t* parts; /* n: see hnav_observer_info */
    double* plant_events; /* n: events that have been, the mean of the parts */
} hnav_observer_run_output;

/* A row that the plant has no answer for is dropped and counted, or the estimate is held before it (see hnav_observer_info.held), and the
 * next one goes on; hnav_filter_message tells why the first was. rows_done (may be null): less than n
 * only after an error: NON_FINITE (time, infinite samples), TIME_BACKWARDS. */
HNAV_API hnav_status hnav_observer_run(hnav_filter* filter, size_t n, const hnav_observer_run_input* input,
                                       const hnav_observer_run_output* output, size_t* rows_done);

/* ------------------------------------------------------------------------------------------------ hybrid view */

/* n_indicators of them (hnav_observer_info) at x; null: where it is shown. 1 before the estimate has begun. SOLVER: the plant has no answer
 * there. */
HNAV_API hnav_status hnav_observer_indicators(const hnav_filter* filter, const double* x, double* z);
/* A step of the integrator has come to x. wants_event: the plant has an event there, so jump is to be called. SOLVER: it failed. */
HNAV_API hnav_status hnav_observer_step_done(hnav_filter* filter, const double* x, int32_t* wants_event);
#ifdef __cplusplus
}
#endif

#endif /* HNAV_OBSERVER_H */
