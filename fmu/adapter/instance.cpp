#include "adapter/instance.hpp"
#include "adapter/sampling_clock.hpp"

#include <cmath>
#include <cstdarg>
#include <cstring>
#include <initializer_list>
#include <new>
#include <type_traits>

namespace hnav::fmu {

namespace {

const char* type_name(Type type) {
    switch (type) {
    case Type::real: return "real";
    case Type::integer: return "integer";
    case Type::boolean: return "boolean";
    default: return "enumeration";
    }
}

std::uint64_t checksum(const unsigned char* bytes, std::size_t size) {
    std::uint64_t hash = 14695981039346656037ull;
    for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211ull;
    return hash;
}

} // namespace

// ------------------------------------------------------------------------------------------------ making

void Instance::format_token(std::uint64_t token, char* text, std::size_t size) {
    const auto word = [token](int shift, unsigned mask) { return static_cast<unsigned>(token >> shift) & mask; };
    std::snprintf(text, size, "{%08x-%04x-%04x-%04x-%04x%08x}", word(32, 0xffffffffu), word(16, 0xffffu), word(0, 0xffffu),
                  word(48, 0xffffu), word(24, 0xffffu), word(8, 0xffffffffu));
}

Instance* Instance::create(const char* name, const char* token, const Options& options, const Importer& importer) {
    auto* self = new Instance;
    if (!self) return nullptr;
    self->options_ = options;
    self->importer_ = importer;
    if (self->set_up_check(name, token) == Status::ok) return self;
    delete self;
    return nullptr;
}

Status Instance::set_up_check(const char* name, const char* token) {
    std::snprintf(name_, sizeof name_, "%s", name ? name : "");
    model_ = make_model();
    if (!model_) return fail("no memory for the model");
    model_->describe(table_);
    const int nx = model_info.nx;
    values_ = static_cast<double*>(std::calloc(2 * table_.size(), sizeof(double)));
    states_ = static_cast<double*>(std::calloc(nx + 1, sizeof(double)));
    scratch_ = static_cast<double*>(std::calloc(2 * nx + 1, sizeof(double)));
    if (!table_.complete() || !values_ || !states_ || !scratch_) return fail("no memory for the variables");
    if (!name || !*name) return fail("the instance name is missing");
    char expected[64];
    format_token(table_.token(), expected, sizeof expected);
    if (!token || std::strcmp(token, expected) != 0)
        return fail("the token %s is not %s: model description and binary do not belong together", token ? token : "(null)",
                    expected);
    for (int i = table_.size() - 1; i >= 0; --i) {
        if (table_[i].is_state) first_state_ = i;
        if (table_[i].derivative_of >= 0) first_derivative_ = i;
    }
    restart();
    return Status::ok;
}

Instance::~Instance() {
    delete model_;
    std::free(values_);
    std::free(states_);
    std::free(scratch_);
}

void Instance::restart() {
    for (int i = 0; i < table_.size(); ++i) {
        values_[i] = table_[i].start;
        written()[i] = 0;
    }
    model_->clear();
    has_model_ = false;
    mode_ = instantiated;
    stale_ = 0;
    time_s_ = start_s_ = 0;
    stop_s_ = no_bound;
}

Status Instance::fail(const char* format, ...) const {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (importer_.log) importer_.log(*this, Status::error, text);
    return Status::error;
}

bool Instance::allowed(Call call) const {
    const Rule& rule = rule_of(call);
    if (!(rule.interfaces & options_.interface)) {
        fail("%s does not belong to %s", rule.name, options_.interface == co_simulation ? "Co-Simulation" : "Model Exchange");
        return false;
    }
    if (!(rule.modes & mode_)) {
        fail("%s is not allowed in %s", rule.name, mode_name(mode_));
        return false;
    }
    return true;
}

// ------------------------------------------------------------------------------------------------ life

Status Instance::set_up_experiment(double start_s, bool stop_defined, double stop_s) {
    if (!std::isfinite(start_s)) return fail("startTime = %g is not finite", start_s);
    if (stop_defined && !std::isfinite(stop_s)) return fail("stopTime = %g is not finite", stop_s);
    if (stop_defined && stop_s < start_s) return fail("stopTime = %g is before startTime = %g", stop_s, start_s);
    start_s_ = time_s_ = start_s;
    stop_s_ = stop_defined ? stop_s : no_bound;
    return Status::ok;
}

Status Instance::enter_initialization() {
    if (!allowed(Call::enter_initialization)) return Status::error;
    mode_ = initialization;
    return Status::ok;
}

Status Instance::exit_initialization(bool fmi2) {
    if (!allowed(Call::exit_initialization)) return Status::error;
    Message why;
    if (!model_->initialise(values_, written(), start_s_, options_.interface == model_exchange, &why))
        return fail("%s", why.text);
    has_model_ = true;
    stale_ = ~0u;
    if (options_.interface == model_exchange) {
        model_->get_states(states_);
        mode_ = event;
    } else mode_ = !fmi2 && options_.event_mode_used ? event : step;
    return Status::ok;
}

Status Instance::change_mode(Call call, Mode mode) {
    if (!allowed(call)) return Status::error;
    if (call == Call::enter_event_mode && options_.interface == co_simulation && !options_.event_mode_used)
        return fail("EnterEventMode needs eventModeUsed");
    mode_ = mode;
    return Status::ok;
}

Status Instance::terminate() { return change_mode(Call::terminate, terminated); }

Status Instance::reset() {
    if (!allowed(Call::reset)) return Status::error;
    restart();
    return Status::ok;
}

// ------------------------------------------------------------------------------------------------ variables

Status Instance::check_array(const void* references, std::size_t n, const void* values, std::size_t n_values) const {
    if (n != n_values) return fail("%zu value references go with %zu values: all variables are scalars", n, n_values);
    if (n > 0 && (!references || !values)) return fail("a null pointer came with %zu value references", n);
    return Status::ok;
}

void Instance::refresh(unsigned groups) {
    groups &= stale_;
    if (!groups || !has_model_) return;
    if (options_.interface == model_exchange) model_->show(time_s_, states_);
    if (groups & state_group && first_state_ >= 0) {
        double* x = values_ + first_state_;
        if (options_.interface == model_exchange) std::memcpy(x, states_, model_info.nx * sizeof(double));
        else model_->get_states(x);
        model_->derivatives(time_s_, x, values_ + first_derivative_);
    }
    model_->refresh(values_, groups);
    stale_ &= ~groups;
}

template <class T>
Status Instance::get(Type type, const unsigned* references, std::size_t n, T* out) {
    if (!allowed(Call::get_variable)) return Status::error;
    unsigned groups = 0;
    for (std::size_t i = 0; i < n; ++i) {
        if (references[i] >= static_cast<unsigned>(table_.size()))
            return fail("there is no variable with value reference %u", references[i]);
        const Variable& row = table_[references[i]];
        if (row.type != type) return fail("%s is %s, not %s", row.name, type_name(row.type), type_name(type));
        groups |= row.group;
    }
    refresh(groups);
    for (std::size_t i = 0; i < n; ++i) {
        const Variable& row = table_[references[i]];
        double value = row.causality == Causality::independent ? time_s_ : values_[references[i]];
        if constexpr (std::is_same_v<T, int>) value = std::fmin(value, 2147483647); // counts stop where 32 bits end
        out[i] = static_cast<T>(value);
    }
    return Status::ok;
}

template Status Instance::get(Type, const unsigned*, std::size_t, double*);
template Status Instance::get(Type, const unsigned*, std::size_t, int*);
template Status Instance::get(Type, const unsigned*, std::size_t, std::int64_t*);
template Status Instance::get(Type, const unsigned*, std::size_t, bool*);

Status Instance::check_value(int row, double value) const {
    const Variable& v = table_[row];
    switch (v.causality) {
    case Causality::parameter:
        if (!allowed(Call::set_parameter)) return Status::error;
        // A NaN fails this comparison too. Inputs are let through: the model refuses and counts what is no sample.
        if (!(value >= v.min && value <= v.max)) return fail("%s = %g lies outside [%g, %g]", v.name, value, v.min, v.max);
        break;
    case Causality::input:
        if (!allowed(Call::set_input)) return Status::error;
        break;
    default: return fail("%s is no parameter or input and cannot be set", v.name);
    }
    return Status::ok;
}

template <class T>
Status Instance::set(Type type, const unsigned* references, std::size_t n, const T* in) {
    for (std::size_t i = 0; i < n; ++i) {
        if (references[i] >= static_cast<unsigned>(table_.size()))
            return fail("there is no variable with value reference %u", references[i]);
        const Variable& row = table_[references[i]];
        if (row.type != type) return fail("%s is %s, not %s", row.name, type_name(row.type), type_name(type));
        if (check_value(static_cast<int>(references[i]), static_cast<double>(in[i])) != Status::ok) return Status::error;
    }
    // All or nothing: a refused call has changed no value.
    for (std::size_t i = 0; i < n; ++i) {
        values_[references[i]] = static_cast<double>(in[i]);
        written()[references[i]] = 1;
    }
    return Status::ok;
}

template Status Instance::set(Type, const unsigned*, std::size_t, const double*);
template Status Instance::set(Type, const unsigned*, std::size_t, const int*);
template Status Instance::set(Type, const unsigned*, std::size_t, const std::int64_t*);
template Status Instance::set(Type, const unsigned*, std::size_t, const bool*);

// ------------------------------------------------------------------------------------------------ Co-Simulation

Status Instance::do_step(double t_s, double step_s, IntermediateUpdate update, Step* reply) {
    *reply = {};
    reply->last_successful_s = time_s_;
    if (!allowed(Call::do_step)) return Status::error;
    if (!std::isfinite(t_s)) return fail("currentCommunicationPoint = %g is not finite", t_s);
    if (!std::isfinite(step_s) || !(step_s > 0)) return fail("communicationStepSize = %g must be finite and above 0", step_s);
    if (std::fabs(t_s - time_s_) > time_tolerance(time_s_))
        return fail("currentCommunicationPoint = %.17g, but the last step ended at %.17g", t_s, time_s_);
    double end_s = t_s + step_s;
    if (!(end_s > t_s)) return fail("communicationStepSize = %g is lost in rounding at t = %.17g", step_s, t_s);
    if (end_s > stop_s_ + time_tolerance(stop_s_)) return fail("the step to %.17g passes stopTime = %.17g", end_s, stop_s_);

    model_->take_samples(values_, t_s);
    // A sample that falls inside the step is worth an early return to an importer that handles events.
    const double due_s = model_->next_sample_s(values_);
    if (options_.event_mode_used && options_.early_return_allowed && due_s < end_s - time_tolerance(end_s)) {
        end_s = due_s;
        reply->early_return = true;
    }
    Message why;
    if (!model_->advance(end_s, &why)) return fail("%s", why.text);
    time_s_ = end_s;
    stale_ = ~0u;
    reply->event_handling_needed = options_.event_mode_used && due_s <= end_s + time_tolerance(end_s);
    reply->last_successful_s = end_s;
    if (update) { // the importer may read, and no more, while its callback runs
        mode_ = intermediate;
        update(*this, end_s);
        mode_ = step;
    }
    return Status::ok;
}

// ------------------------------------------------------------------------------------------------ events

Status Instance::update_discrete_states(Events* events) {
    *events = {};
    if (!allowed(Call::update_discrete_states)) return Status::error;
    model_->take_samples(values_, time_s_);
    Message why;
    const bool done = options_.interface == model_exchange ? model_->jump(time_s_, states_, &events->states_changed, &why)
                                                           : model_->advance(time_s_, &why);
    if (!done) return fail("%s", why.text);
    stale_ = ~0u;
    const double next = model_->next_sample_s(values_);
    events->next_event_defined = std::isfinite(next);
    events->next_event_s = events->next_event_defined ? next : 0;
    return Status::ok;
}

// ------------------------------------------------------------------------------------------------ Model Exchange

Status Instance::set_time(double t_s) {
    if (!allowed(Call::set_time)) return Status::error;
    if (!std::isfinite(t_s)) return fail("time = %g is not finite", t_s);
    time_s_ = t_s;
    stale_ = ~0u;
    return Status::ok;
}

Status Instance::set_states(const double* x, std::size_t n) {
    if (!allowed(Call::set_continuous_states)) return Status::error;
    if ((!x && n > 0) || n != static_cast<std::size_t>(model_info.nx))
        return fail("there are %d continuous states, not %zu", model_info.nx, n);
    for (std::size_t i = 0; i < n; ++i)
        if (!std::isfinite(x[i])) return fail("continuous state %zu = %g is not finite", i + 1, x[i]);
    if (n > 0) std::memcpy(states_, x, n * sizeof(double));
    stale_ = ~0u;
    return Status::ok;
}

Status Instance::get_states(double* x, std::size_t n) {
    if (!allowed(Call::get_continuous_states)) return Status::error;
    if ((!x && n > 0) || n != static_cast<std::size_t>(model_info.nx))
        return fail("there are %d continuous states, not %zu", model_info.nx, n);
    if (n > 0) std::memcpy(x, states_, n * sizeof(double));
    return Status::ok;
}

Status Instance::get_derivatives(double* dx, std::size_t n) {
    if (!allowed(Call::get_continuous_states)) return Status::error;
    if ((!dx && n > 0) || n != static_cast<std::size_t>(model_info.nx))
        return fail("there are %d continuous states, not %zu", model_info.nx, n);
    if (!has_model_) {
        if (n > 0) std::memset(dx, 0, n * sizeof(double));
        return Status::ok;
    }
    return model_->derivatives(time_s_, states_, dx) ? Status::ok : fail("the derivatives at t = %g are not defined", time_s_);
}

Status Instance::get_nominals(double* nominals, std::size_t n) {
    if (!allowed(Call::get_continuous_states)) return Status::error;
    if ((!nominals && n > 0) || n != static_cast<std::size_t>(model_info.nx))
        return fail("there are %d continuous states, not %zu", model_info.nx, n);
    if (has_model_) model_->get_nominals(nominals);
    else
        for (std::size_t i = 0; i < n; ++i) nominals[i] = 1;
    return Status::ok;
}

Status Instance::completed_integrator_step() { return allowed(Call::completed_integrator_step) ? Status::ok : Status::error; }

// The flow is differentiated exactly. Outputs are smooth functions of the state and are differentiated by central
// differences along the seed.
Status Instance::directional_derivative(const unsigned* unknowns, std::size_t n_unknowns, const unsigned* knowns,
                                        std::size_t n_knowns, const double* seed, double* sensitivity) {
    if (!allowed(Call::directional_derivative)) return Status::error;
    if ((n_unknowns && (!unknowns || !sensitivity)) || (n_knowns && (!knowns || !seed)))
        return fail("GetDirectionalDerivative got a null pointer");
    const int nx = model_info.nx;
    double *direction = scratch_, *along = scratch_ + nx;
    std::memset(direction, 0, nx * sizeof(double));
    for (std::size_t k = 0; k < n_knowns; ++k) {
        const unsigned row = knowns[k];
        if (row >= static_cast<unsigned>(table_.size())) return fail("there is no variable with value reference %u", row);
        if (table_[row].causality == Causality::input) continue; // samples act at events: nothing depends on them here
        if (!table_[row].is_state) return fail("%s is no continuous state or input", table_[row].name);
        direction[row - first_state_] += seed[k];
    }
    if (!has_model_) return fail("GetDirectionalDerivative needs an initialised model");
    refresh(state_group);
    if (nx > 0) model_->derivatives_along(time_s_, values_ + first_state_, direction, along);
    bool outputs = false;
    for (std::size_t k = 0; k < n_unknowns; ++k) {
        const unsigned row = unknowns[k];
        if (row >= static_cast<unsigned>(table_.size())) return fail("there is no variable with value reference %u", row);
        if (table_[row].derivative_of >= 0) sensitivity[k] = along[row - first_derivative_];
        else if (table_[row].causality == Causality::output && table_[row].type == Type::real) outputs = true;
        else return fail("%s is no derivative or real output", table_[row].name);
    }
    if (!outputs || options_.interface != model_exchange) {
        for (std::size_t k = 0; k < n_unknowns; ++k)
            if (table_[unknowns[k]].derivative_of < 0) sensitivity[k] = 0;
        return Status::ok;
    }
    double largest = 0;
    for (int i = 0; i < nx; ++i) largest = std::fmax(largest, std::fabs(direction[i]));
    const double step = largest > 0 ? 1e-6 / largest : 0;
    for (const double sign : {1.0, -1.0}) {
        for (int i = 0; i < nx; ++i) along[i] = states_[i] + sign * step * direction[i];
        model_->show(time_s_, along);
        model_->refresh(values_, ~0u);
        for (std::size_t k = 0; k < n_unknowns; ++k) {
            if (table_[unknowns[k]].derivative_of >= 0) continue;
            if (sign > 0) sensitivity[k] = 0;
            if (step > 0 && table_[unknowns[k]].depends_on != DependsOn::nothing)
                sensitivity[k] += sign * values_[unknowns[k]] / (2 * step);
        }
    }
    stale_ = ~0u;
    return Status::ok;
}

// ------------------------------------------------------------------------------------------------ complete state

// Plain numbers: header, values, the importer's states, the model. Good in another process with the same binary.
struct Instance::Header {
    std::uint64_t magic, checksum;
    // Everything from here on is covered by the checksum.
    std::uint64_t token, bytes;
    std::uint64_t interface, event_mode_used, mode, has_model;
    double time_s, start_s, stop_s;
};

namespace {
constexpr std::uint64_t snapshot_magic = 0x3254415453564e48ull; // "HNVSTAT2"
constexpr std::size_t unchecked_bytes = 2 * sizeof(std::uint64_t); // magic and checksum
} // namespace

std::size_t Instance::snapshot_bytes() const {
    return sizeof(Header) + (2 * table_.size() + model_info.nx) * sizeof(double) + (has_model_ ? model_->state_size() : 0);
}

Status Instance::take_snapshot(Snapshot** snapshot) {
    if (!allowed(Call::fmu_state)) return Status::error;
    if (!snapshot) return fail("GetFMUState got a null pointer");
    const std::size_t bytes = snapshot_bytes();
    if (!*snapshot || (*snapshot)->bytes != bytes) {
        auto* fresh = static_cast<Snapshot*>(std::realloc(*snapshot, sizeof(Snapshot) + bytes));
        if (!fresh) return fail("no memory for the state of the FMU");
        *snapshot = fresh;
        fresh->bytes = bytes;
    }
    auto* place = reinterpret_cast<unsigned char*>(*snapshot + 1);
    Header header{snapshot_magic, 0,       table_.token(), bytes,  options_.interface, options_.event_mode_used, mode_,
                  has_model_,     time_s_, start_s_,       stop_s_};
    std::memcpy(place + sizeof header, values_, 2 * table_.size() * sizeof(double));
    std::memcpy(place + sizeof header + 2 * table_.size() * sizeof(double), states_, model_info.nx * sizeof(double));
    if (has_model_) model_->save(place + bytes - model_->state_size());
    std::memcpy(place, &header, sizeof header);
    header.checksum = checksum(place + unchecked_bytes, bytes - unchecked_bytes);
    std::memcpy(place, &header, sizeof header);
    return Status::ok;
}

Status Instance::restore_snapshot(const Snapshot* snapshot) {
    if (!allowed(Call::fmu_state)) return Status::error;
    if (!snapshot) return fail("SetFMUState got a null pointer");
    const auto* place = reinterpret_cast<const unsigned char*>(snapshot + 1);
    Header header;
    std::memcpy(&header, place, sizeof header);
    if (header.interface != options_.interface || header.event_mode_used != static_cast<std::uint64_t>(options_.event_mode_used))
        return fail("this state was taken from an instance of another interface");
    const double* values = reinterpret_cast<const double*>(place + sizeof header);
    std::memcpy(values_, values, 2 * table_.size() * sizeof(double));
    std::memcpy(states_, values + 2 * table_.size(), model_info.nx * sizeof(double));
    Message why;
    if (header.has_model) {
        const std::size_t used = sizeof header + (2 * table_.size() + model_info.nx) * sizeof(double);
        if (!model_->initialise(values_, written(), header.start_s, options_.interface == model_exchange, &why) ||
            !model_->load(place + used, header.bytes - used)) {
            restart();
            return fail("the state does not fit this instance: %s", why.text);
        }
        std::memcpy(values_, values, table_.size() * sizeof(double));
    } else model_->clear();
    has_model_ = header.has_model != 0;
    mode_ = static_cast<Mode>(header.mode);
    time_s_ = header.time_s;
    start_s_ = header.start_s;
    stop_s_ = header.stop_s;
    stale_ = ~0u;
    return Status::ok;
}

Status Instance::serialise(const Snapshot* snapshot, unsigned char* bytes, std::size_t size) const {
    if (!snapshot || !bytes) return fail("SerializeFMUState got a null pointer");
    if (size < snapshot->bytes) return fail("SerializeFMUState got %zu bytes, the state has %zu", size, snapshot->bytes);
    std::memcpy(bytes, snapshot + 1, snapshot->bytes);
    return Status::ok;
}

Status Instance::deserialise(const unsigned char* bytes, std::size_t size, Snapshot** snapshot) const {
    if (!snapshot || !bytes) return fail("DeserializeFMUState got a null pointer");
    Header header;
    if (size < sizeof header) return fail("a state has more than %zu bytes", size);
    std::memcpy(&header, bytes, sizeof header);
    if (header.magic != snapshot_magic || header.token != table_.token() || header.bytes > size ||
        header.bytes < sizeof header + (2 * table_.size() + model_info.nx) * sizeof(double) ||
        header.checksum != checksum(bytes + unchecked_bytes, header.bytes - unchecked_bytes))
        return fail("these bytes are no state of this FMU, or damaged");
    auto* fresh = static_cast<Snapshot*>(std::malloc(sizeof(Snapshot) + header.bytes));
    if (!fresh) return fail("no memory for the state of the FMU");
    fresh->bytes = header.bytes;
    std::memcpy(fresh + 1, bytes, header.bytes);
    *snapshot = fresh;
    return Status::ok;
}

} // namespace hnav::fmu
