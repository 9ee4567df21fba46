// Model Exchange: the importer's states, and how the model follows them.
#include "adapter/instance.hpp"

#include <cmath>
#include <cstring>

namespace hnav::fmu {

Status Instance::check_states(const double* x, std::size_t n) const {
    if ((x || n == 0) && n == static_cast<std::size_t>(model_info.states.count)) return Status::ok;
    return fail("there are %d continuous states, not %zu", model_info.states.count, n);
}

Status Instance::set_time(double t_s) {
    if (!allowed(Call::set_time)) return Status::error;
    if (!std::isfinite(t_s)) return fail("time = %g is not finite", t_s);
    time_s_ = t_s;
    stale_ = ~0u;
    return Status::ok;
}

Status Instance::set_states(const double* x, std::size_t n) {
    if (!allowed(Call::set_continuous_states)) return Status::error;
    if (check_states(x, n) != Status::ok) return Status::error;
    for (std::size_t i = 0; i < n; ++i)
        if (!std::isfinite(x[i])) return fail("continuous state %zu = %g is not finite", i + 1, x[i]);
    if (n > 0) std::memcpy(states_, x, n * sizeof(double));
    stale_ = ~0u;
    return Status::ok;
}

Status Instance::get_states(double* x, std::size_t n) {
    if (!allowed(Call::get_continuous_states)) return Status::error;
    if (check_states(x, n) != Status::ok) return Status::error;
    if (n > 0) std::memcpy(x, states_, n * sizeof(double));
    return Status::ok;
}

Status Instance::get_derivatives(double* dx, std::size_t n) {
    if (!allowed(Call::get_continuous_states)) return Status::error;
    if (check_states(dx, n) != Status::ok) return Status::error;
    if (!has_model_) {
        if (n > 0) std::memset(dx, 0, n * sizeof(double));
        return Status::ok;
    }
    return model_->derivatives(time_s_, states_, dx) ? Status::ok : fail("the derivatives at t = %g are not defined", time_s_);
}

Status Instance::get_nominals(double* nominals, std::size_t n) {
    if (!allowed(Call::get_continuous_states)) return Status::error;
    if (check_states(nominals, n) != Status::ok) return Status::error;
    if (has_model_) model_->get_nominals(nominals);
    else
        for (std::size_t i = 0; i < n; ++i) nominals[i] = 1;
    return Status::ok;
}

// ------------------------------------------------------------------------------------------------ derivatives

// The flow is differentiated exactly. Outputs are smooth functions of the state and are differentiated by central
// differences along the seed.
Status Instance::directional_derivative(const unsigned* unknowns, std::size_t n_unknowns, const unsigned* knowns,
                                        std::size_t n_knowns, const double* seed, double* sensitivity) {
    if (!allowed(Call::directional_derivative)) return Status::error;
    if ((n_unknowns && (!unknowns || !sensitivity)) || (n_knowns && (!knowns || !seed)))
        return fail("GetDirectionalDerivative got a null pointer");
    double *direction = scratch_, *along = scratch_ + model_info.states.count;
    if (sum_seeds(knowns, n_knowns, seed, direction) != Status::ok) return Status::error;
    // Before there is a model everything shows its start value.
    std::memset(along, 0, model_info.states.count * sizeof(double));
    refresh(state_group);
    if (has_model_ && model_info.states.count > 0) model_->derivatives_along(time_s_, values_ + first_state_, direction, along);
    bool outputs = false;
    if (flow_sensitivity(unknowns, n_unknowns, along, sensitivity, &outputs) != Status::ok) return Status::error;
    if (outputs && has_model_ && options_.interface == model_exchange)
        output_sensitivity(unknowns, n_unknowns, direction, along, sensitivity);
    return Status::ok;
}

// The direction in the space of the states that the seeds of the knowns make together.
Status Instance::sum_seeds(const unsigned* knowns, std::size_t n, const double* seed, double* direction) const {
    std::memset(direction, 0, model_info.states.count * sizeof(double));
    for (std::size_t k = 0; k < n; ++k) {
        const Variable* row = row_of(knowns[k]);
        if (!row) return Status::error;
        if (row->causality == Causality::input) continue; // samples act at events: nothing depends on them here
        if (!row->is_state) return fail("%s is no continuous state or input", row->name);
        direction[static_cast<int>(knowns[k]) - first_state_] += seed[k];
    }
    return Status::ok;
}

// Sensitivities of the unknowns that are derivatives, which change by `along`, and zero for the outputs among them.
Status Instance::flow_sensitivity(const unsigned* unknowns, std::size_t n, const double* along, double* sensitivity,
                                  bool* outputs) const {
    for (std::size_t k = 0; k < n; ++k) {
        const Variable* row = row_of(unknowns[k]);
        if (!row) return Status::error;
        const bool derivative = row->derivative_of >= 0;
        if (!derivative && (row->causality != Causality::output || row->type != Type::real))
            return fail("%s is no derivative or real output", row->name);
        sensitivity[k] = derivative ? along[static_cast<int>(unknowns[k]) - first_derivative_] : 0;
        *outputs = *outputs || !derivative;
    }
    return Status::ok;
}

// x: room for a state.
void Instance::output_sensitivity(const unsigned* unknowns, std::size_t n, const double* direction, double* x,
                                  double* sensitivity) {
    double largest = 0;
    for (int i = 0; i < model_info.states.count; ++i) largest = std::fmax(largest, std::fabs(direction[i]));
    if (!(largest > 0)) return;
    const double step = 1e-6 / largest;
    for (int sign = 1; sign >= -1; sign -= 2) {
        for (int i = 0; i < model_info.states.count; ++i) x[i] = states_[i] + sign * step * direction[i];
        model_->show(time_s_, x);
        model_->refresh(values_, ~0u);
        for (std::size_t k = 0; k < n; ++k) {
            const Variable& row = table_[static_cast<int>(unknowns[k])];
            if (row.derivative_of < 0 && row.depends_on != DependsOn::nothing)
                sensitivity[k] += sign * values_[unknowns[k]] / (2 * step);
        }
    }
    stale_ = ~0u;
}

} // namespace hnav::fmu
