// What the options of solver, horizon and queue mean to the engine: the same in every filter that has them.
#pragma once

#include "base/option_list.hpp"
#include "hnav/options/shared.h"
#include "hybrid/filter.hpp"

namespace hnav {

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

} // namespace hnav
