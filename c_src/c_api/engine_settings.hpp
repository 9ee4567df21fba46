// The engine settings of the options of solver, horizon and queue, the same in every filter that has them.
#pragma once

#include "base/option_list.hpp"
#include "c_api/message.hpp"
#include "hnav/options/shared.h"
#include "hybrid/filter.hpp"
#include "maths/rotation.hpp"

#include <cmath>

namespace hnav {

// Null pointers, the stamp, the range of every field, and attitudes of zero length.
template <class Options>
hnav_status check_creation(const CallersMessage& caller, hnav_filter** filter, const Options* options, const OptionList& list) {
    hnav_status status = caller.begin(filter, "filter", {{options, "options"}});
    if (status == HNAV_OK) status = caller.check_options(options, list);
    if (status != HNAV_OK) return status;
    for (const Argument& q : {Argument{options->start_q_nb, "start_q_nb"}, Argument{options->q_body_sensor, "q_body_sensor"}})
        if (Quaternion(static_cast<const double*>(q.pointer)).squaredNorm() < 0.01)
            return caller.fail(HNAV_ERROR_OPTION, "%s is no attitude: its length must be at least 0.1", q.name);
    return HNAV_OK;
}

template <class Model, class Options>
typename Filter<Model>::Settings engine_settings(const Options& o, const OptionList& list) {
    typename Filter<Model>::Settings e;
    e.closed_form = o.solver == HNAV_SOLVER_CLOSED_FORM;
    e.propagator.integrator = o.solver == HNAV_SOLVER_ADAMS   ? Integrator::adams
                              : o.solver == HNAV_SOLVER_EULER ? Integrator::euler
                                                              : Integrator::erkstep;
    e.propagator.rtol = o.solver_rtol;
    e.propagator.euler_step_s = o.euler_step_s;
    e.atol = o.solver_atol;
    e.horizon_s = o.horizon_s;
    e.time_jump_limit_s = o.time_jump_limit_s;
    e.queue_capacity = o.queue_capacity + 1; // the base of the chain takes a place
    e.fingerprint = fingerprint(list, &o);
    return e;
}

// Memory that a filter may take. What is above is refused before allocation: a system that overcommits memory would end the process at the
// first use. Chosen: a gibibyte, a quarter of the memory of small machines.
constexpr double max_filter_bytes = 1 << 30;

// The queue_capacity that fits into `left` if `capacity` places take `bytes`; a hundredth is kept for the rest.
inline double capacity_that_fits(int capacity, double bytes, double left) { return std::floor(0.99 * capacity * left / bytes); }

template <class Model>
hnav_status check_memory(const CallersMessage& caller, const Model& model, const typename Filter<Model>::Settings& settings,
                         int queue_capacity) {
    const auto bytes = static_cast<double>(Filter<Model>::bytes(model, settings));
    if (bytes <= max_filter_bytes) return HNAV_OK;
    return caller.fail(HNAV_ERROR_OPTION, "queue_capacity = %d takes %.1f GiB: a filter may take 1 GiB, which holds %.0f",
                       queue_capacity, bytes / max_filter_bytes, capacity_that_fits(queue_capacity, bytes, max_filter_bytes));
}

} // namespace hnav
