// Model Exchange: the importer's states and the events of the model.
#include "adapter/instance.hpp"

#include <cmath>
#include <cstring>

namespace hnav::fmu {

Status Instance::check_states(const double* x, std::size_t n) const {
    if ((x || n == 0) && n == static_cast<std::size_t>(state_count_)) return Status::ok;
    return fail("there are %d continuous states, not %zu", state_count_, n);
}

Status Instance::set_time(double t_s) {
    if (!allowed(Call::set_time)) return Status::error;
    if (check_time("time", t_s) != Status::ok) return Status::error;
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
    if (!allowed(Call::get_continuous_states) || check_states(x, n) != Status::ok || make_ready() != Status::ok)
        return Status::error;
    if (n > 0) std::memcpy(x, states_, n * sizeof(double));
    return Status::ok;
}

Status Instance::get_derivatives(double* dx, std::size_t n) {
    if (!allowed(Call::get_continuous_states) || check_states(dx, n) != Status::ok || make_ready() != Status::ok)
        return Status::error;
    return model_->derivatives(time_s_, states_, dx) ? Status::ok : fail("the derivatives at t = %g are not defined", time_s_);
}

Status Instance::get_indicators(double* z, std::size_t n) {
    if (!allowed(Call::get_continuous_states)) return Status::error;
    const int count = model_->indicator_count();
    if (n != static_cast<std::size_t>(count) || (!z && n > 0)) return fail("there are %d event indicators, not %zu", count, n);
    if (make_ready() != Status::ok) return Status::error;
    return model_->indicators(time_s_, states_, z) ? Status::ok : fail("the indicators at t = %g are not defined", time_s_);
}

Status Instance::step_done(bool* wants_event) {
    *wants_event = false;
    if (!allowed(Call::completed_integrator_step)) return Status::error;
    return model_->step_done(time_s_, states_, wants_event) ? Status::ok : fail("the end of a step at t = %g failed", time_s_);
}

Status Instance::get_nominals(double* nominals, std::size_t n) {
    if (!allowed(Call::get_continuous_states) || check_states(nominals, n) != Status::ok || make_ready() != Status::ok)
        return Status::error;
    model_->get_nominals(nominals);
    return Status::ok;
}

// ------------------------------------------------------------------------------------------------ derivatives

// All derivatives are exact. Inputs act at events, so no derivative depends on them.
Status Instance::directional_derivative(const unsigned* unknowns, std::size_t n_unknowns, const unsigned* knowns,
                                        std::size_t n_knowns, const double* seed, std::size_t n_seed, double* sensitivity,
                                        std::size_t n_sensitivity) {
    if (!allowed(Call::directional_derivative)) return Status::error;
    if (!model_info.derivatives) return fail("this FMU offers no directional derivatives");
    if (check_array(unknowns, n_unknowns, sensitivity, n_sensitivity) != Status::ok ||
        check_array(knowns, n_knowns, seed, n_seed) != Status::ok ||
        check_pairs(unknowns, n_unknowns, knowns, n_knowns) != Status::ok || make_ready() != Status::ok)
        return Status::error;
    double* direction = scratch_;
    std::memset(direction, 0, state_count_ * sizeof(double));
    for (std::size_t k = 0; k < n_knowns; ++k) {
        const Slot& known = slots_[knowns[k]];
        for (int i = 0; i < known.rows; ++i, ++seed)
            if (table_[known.row + i].is_state) direction[known.row + i - first_state_] += *seed;
    }
    const double* rows = rows_along(direction);
    for (std::size_t k = 0; k < n_unknowns; ++k) {
        const Slot& unknown = slots_[unknowns[k]];
        for (int i = 0; i < unknown.rows; ++i) *sensitivity++ = rows[unknown.row + i];
    }
    return Status::ok;
}

// One state after another: there are a few tens at most.
Status Instance::adjoint_derivative(const unsigned* unknowns, std::size_t n_unknowns, const unsigned* knowns,
                                    std::size_t n_knowns, const double* seed, std::size_t n_seed, double* sensitivity,
                                    std::size_t n_sensitivity) {
    if (!allowed(Call::adjoint_derivative)) return Status::error;
    if (!model_info.derivatives) return fail("this FMU offers no adjoint derivatives");
    if (check_array(unknowns, n_unknowns, seed, n_seed) != Status::ok ||
        check_array(knowns, n_knowns, sensitivity, n_sensitivity) != Status::ok ||
        check_pairs(unknowns, n_unknowns, knowns, n_knowns) != Status::ok || make_ready() != Status::ok)
        return Status::error;
    for (std::size_t k = 0; k < n_knowns; ++k)
        for (int i = 0; i < slots_[knowns[k]].rows; ++i)
            *sensitivity++ = adjoint_along(slots_[knowns[k]].row + i, unknowns, n_unknowns, seed);
    return Status::ok;
}

// The seeds of the unknowns times their derivatives by the state of a row; 0 for a row that is no state.
double Instance::adjoint_along(int row, const unsigned* unknowns, std::size_t n_unknowns, const double* seed) {
    if (!table_[row].is_state) return 0;
    double* direction = scratch_;
    std::memset(direction, 0, state_count_ * sizeof(double));
    direction[row - first_state_] = 1;
    const double* rows = rows_along(direction);
    double sum = 0;
    for (std::size_t k = 0; k < n_unknowns; ++k) {
        const Slot& unknown = slots_[unknowns[k]];
        for (int i = 0; i < unknown.rows; ++i) sum += *seed++ * rows[unknown.row + i];
    }
    return sum;
}

Status Instance::check_pairs(const unsigned* unknowns, std::size_t n_unknowns, const unsigned* knowns,
                             std::size_t n_knowns) const {
    for (std::size_t k = 0; k < n_knowns; ++k) {
        const Variable* row = row_of(knowns[k]);
        if (!row) return Status::error;
        if (row->causality != Causality::input && !row->is_state) return fail("%s is no continuous state or input", row->name);
    }
    for (std::size_t k = 0; k < n_unknowns; ++k) {
        const Variable* row = row_of(unknowns[k]);
        if (!row) return Status::error;
        // PyFMI requests all outputs, whatever their type: discrete ones do not change with the states.
        if (row->derivative_of < 0 && row->causality != Causality::output)
            return fail("%s is no derivative or output", row->name);
    }
    return Status::ok;
}

// The derivatives of all rows along a direction of the states. The direction is normalised first, so that models do not
// depend on its length.
const double* Instance::rows_along(double* direction) {
    const int nx = state_count_;
    double* rows = scratch_ + nx;
    std::memset(rows, 0, table_.size() * sizeof(double));
    double largest = 0;
    for (int i = 0; i < nx; ++i) largest = std::fmax(largest, std::fabs(direction[i]));
    if (!(largest > 0)) return rows;
    for (int i = 0; i < nx; ++i) direction[i] /= largest;
    model_->show(time_s_, states_);
    model_->derivatives_along(time_s_, states_, direction, rows + first_derivative_);
    model_->rows_along(direction, rows);
    for (int i = 0; i < table_.size(); ++i) rows[i] *= largest;
    return rows;
}

} // namespace hnav::fmu
