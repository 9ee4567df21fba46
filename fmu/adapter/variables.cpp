// Getting and setting variables by value references.
#include "adapter/instance.hpp"

#include <cmath>
#include <cstring>
#include <type_traits>

namespace hnav::fmu {

namespace {

const char* type_name(Type type) {
    switch (type) {
    case Type::real: return "real";
    case Type::integer: return "integer";
    case Type::boolean: return "boolean";
    case Type::clock: return "a clock";
    default: return "enumeration";
    }
}

template <class T>
T value_as(double value) {
    if constexpr (std::is_same_v<T, int>) return static_cast<T>(std::fmin(value, 2147483647)); // where 32 bits end
    else return static_cast<T>(value);
}

} // namespace

std::size_t Instance::elements(const unsigned* references, std::size_t n) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < n; ++i) count += static_cast<std::size_t>(slot(references[i]).rows);
    return count;
}

Status Instance::check_array(const unsigned* references, std::size_t n, const void* values, std::size_t n_values) const {
    if (n > 0 && (!references || !values)) return fail("a null pointer came with %zu value references", n);
    if (!model_info.arrays && n != n_values)
        return fail("%zu value references go with %zu values: all variables are scalars", n, n_values);
    if (model_info.arrays && elements(references, n) != n_values)
        return fail("variables of %zu elements go with %zu values", elements(references, n), n_values);
    return Status::ok;
}

Status Instance::refresh(unsigned groups) {
    groups &= stale_;
    if (!groups) return Status::ok;
    if (make_ready() != Status::ok) return Status::error;
    Message why;
    if (!model_->look_ahead(groups, &why)) return fail("%s", why.text);
    if (options_.interface == model_exchange) model_->show(time_s_, states_);
    if (groups & state_group && first_state_ >= 0) {
        double* x = values_ + first_state_;
        if (options_.interface == model_exchange) std::memcpy(x, states_, state_count_ * sizeof(double));
        else model_->get_states(x);
        model_->derivatives(time_s_, x, values_ + first_derivative_);
    }
    model_->refresh(values_, groups);
    stale_ &= ~groups;
    return Status::ok;
}

const Variable* Instance::row_of(unsigned reference) const {
    if (slot(reference).rows > 0) return &table_[slot(reference).row];
    fail("there is no variable with value reference %u", reference);
    return nullptr;
}

const Variable* Instance::row_of(unsigned reference, Type type) const {
    const Variable* row = row_of(reference);
    if (!row || row->type == type) return row;
    fail("%s is %s, not %s", row->name, type_name(row->type), type_name(type));
    return nullptr;
}

template <class T>
Status Instance::get(Type type, const unsigned* references, std::size_t n, T* out) {
    const Slot* const slots = slots_;
    unsigned groups = 0;
    std::size_t rows = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const unsigned reference = references[i];
        if (!slot(reference).is_of(type) && !row_of(reference, type)) return Status::error;
        groups |= slots[reference].group;
        rows += static_cast<std::size_t>(slots[reference].rows);
    }
    if (!allowed(groups ? Call::get_calculated : Call::get_given) || refresh(groups) != Status::ok) return Status::error;
    if (time_row_ >= 0) values_[time_row_] = time_s_;
    const double* const values = values_;
    if (rows == n) { // one each
        for (std::size_t i = 0; i < n; ++i) out[i] = value_as<T>(values[slots[references[i]].row]);
        return Status::ok;
    }
    for (std::size_t i = 0; i < n; ++i) {
        const Slot& of = slots[references[i]];
        for (int k = 0; k < of.rows; ++k) *out++ = value_as<T>(values[of.row + k]);
    }
    return Status::ok;
}

template Status Instance::get(Type, const unsigned*, std::size_t, double*);
template Status Instance::get(Type, const unsigned*, std::size_t, int*);
template Status Instance::get(Type, const unsigned*, std::size_t, std::int64_t*);
template Status Instance::get(Type, const unsigned*, std::size_t, bool*);

// Of what is no input.
Status Instance::check_value(const Variable& v, double value) const {
    if (v.is_state) {
        if (!allowed(Call::set_state)) return Status::error;
        return std::isfinite(value) ? Status::ok : fail("%s = %g is not finite", v.name, value);
    }
    if (v.causality != Causality::parameter) return fail("%s is no parameter or input and cannot be set", v.name);
    if (!allowed(Call::set_parameter)) return Status::error;
    if (v.admits(value)) return Status::ok;
    const auto open = [](double bound, bool is_open) { return is_open || std::isinf(bound); };
    return fail("%s = %g is impossible: it must be in %c%g, %g%c", v.name, value, open(v.min, v.min_is_open) ? '(' : '[', v.min,
                v.max, open(v.max, v.max_is_open) ? ')' : ']');
}

// The same for all rows of a variable. A separate function, because a simulation mostly sets inputs.
template <class T>
__attribute__((noinline)) Status Instance::check_values(unsigned reference, const T* values) const {
    const Slot& of = slots_[reference];
    for (int k = 0; k < of.rows; ++k)
        if (check_value(table_[of.row + k], static_cast<double>(values[k])) != Status::ok) return Status::error;
    return Status::ok;
}

// Rows of states, from values_.
__attribute__((noinline)) void Instance::take_states(const unsigned* references, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
        const Slot& of = slots_[references[i]];
        if (!table_[of.row].is_state) continue;
        std::memcpy(states_ + (of.row - first_state_), values_ + of.row, static_cast<std::size_t>(of.rows) * sizeof(double));
    }
    stale_ = ~0u;
}

template <class T>
Status Instance::set(Type type, const unsigned* references, std::size_t n, const T* in) {
    const T* value = in;
    const Slot* const slots = slots_;
    bool inputs = false, others = false;
    for (std::size_t i = 0; i < n; ++i) {
        const unsigned reference = references[i];
        if (!slot(reference).is_of(type) && !row_of(reference, type)) return Status::error;
        // Inputs are accepted, including NaN: the model refuses and counts invalid samples.
        if (slots[reference].is_input) inputs = true;
        else if (check_values(reference, value) != Status::ok) return Status::error;
        else others = true;
        value += slots[reference].rows;
    }
    if (inputs && !allowed(Call::set_input)) return Status::error;
    // All or nothing: a refused call changes no value.
    double* const values = values_;
    for (std::size_t i = 0; i < n; ++i) {
        const Slot& of = slots[references[i]];
        for (int k = 0; k < of.rows; ++k) values[of.row + k] = static_cast<double>(*in++);
    }
    if (mode_ & (instantiated | initialization)) {
        touched_ = true;
        stale_ = ~0u;
    } else if (others) take_states(references, n);
    return Status::ok;
}

template Status Instance::set(Type, const unsigned*, std::size_t, const double*);
template Status Instance::set(Type, const unsigned*, std::size_t, const int*);
template Status Instance::set(Type, const unsigned*, std::size_t, const std::int64_t*);
template Status Instance::set(Type, const unsigned*, std::size_t, const bool*);

} // namespace hnav::fmu
