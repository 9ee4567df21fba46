// Life, Co-Simulation and events. Variables, Model Exchange and the complete state have files of their own.
#include "adapter/instance.hpp"
#include "adapter/arrays.hpp"
#include "adapter/float_traps.hpp"
#include "adapter/sampling_clock.hpp"

#include <cmath>
#include <cstdarg>
#include <cstring>
#include <initializer_list>

namespace hnav::fmu {

// ------------------------------------------------------------------------------------------------ making

void Instance::format_token(std::uint64_t token, char* text, std::size_t size) {
    const auto word = [token](int shift, unsigned mask) { return static_cast<unsigned>(token >> shift) & mask; };
    std::snprintf(text, size, "{%08x-%04x-%04x-%04x-%04x%08x}", word(32, 0xffffffffu), word(16, 0xffffu), word(0, 0xffffu),
                  word(48, 0xffffu), word(24, 0xffffu), word(8, 0xffffffffu));
}

Instance* Instance::create(const char* name, const char* token, const Options& options, const Importer& importer) {
    const WithoutFloatTraps quiet;
    auto* self = new Instance;
    if (!self) return nullptr;
    self->options_ = options;
    self->importer_ = importer;
    self->set_logging(options.logging_on);
    if (self->set_up_check(name, token) == Status::ok) return self;
    delete self;
    return nullptr;
}

Status Instance::make_table() {
    model_ = make_model();
    if (!model_) return fail("no memory for the model");
    Message why;
    if (!model_->open(options_.resources ? options_.resources : "", &why)) return fail("%s", why.text);
    model_->describe(table_);
    const int nx = state_count_ = model_->state_count();
    values_ = static_cast<double*>(std::calloc(table_.size() + max_clocks, sizeof(double)));
    states_ = static_cast<double*>(std::calloc(nx + 1, sizeof(double)));
    scratch_ = static_cast<double*>(std::calloc(nx + table_.size() + 1, sizeof(double)));
    slots_ = static_cast<Slot*>(std::calloc(table_.size() + 1, sizeof(Slot)));
    if (!table_.complete() || !values_ || !states_ || !scratch_ || !slots_) return fail("no memory for the variables");
    index_table();
    return Status::ok;
}

// Rows by their function, and slots by value reference, which begin with 1.
void Instance::index_table() {
    slot_count_ = 1;
    for (int i = 0; i < table_.size(); ++i) {
        const Variable& row = table_[i];
        const int rows = model_info.arrays ? rows_of_variable(table_, i) : 1;
        if (rows > 0) slots_[slot_count_++] = {i, rows, row.group, row.type, row.causality == Causality::input};
        if (row.type == Type::clock && clock_count_ < max_clocks) clock_row_[clock_count_++] = i;
        if (row.causality == Causality::independent) time_row_ = i;
        if (row.is_state && first_state_ < 0) first_state_ = i;
        if (row.derivative_of >= 0 && first_derivative_ < 0) first_derivative_ = i;
    }
}

Status Instance::set_up_check(const char* name, const char* token) {
    std::snprintf(name_, sizeof name_, "%s", name ? name : "");
    const Status made = make_table();
    options_.resources = nullptr; // the importer's
    if (made != Status::ok) return made;
    if (!name || !*name) return fail("the instance name is missing");
    token_ = table_.token(model_info.arrays);
    char expected[64];
    format_token(token_, expected, sizeof expected);
    if (!token || std::strcmp(token, expected) != 0)
        return fail("the token %s is not %s: model description and binary do not belong together", token ? token : "(null)",
                    expected);
    restart();
    return Status::ok;
}

Instance::~Instance() {
    delete model_;
    std::free(values_);
    std::free(states_);
    std::free(scratch_);
    std::free(slots_);
}

void Instance::restart() {
    for (int i = 0; i < table_.size(); ++i) values_[i] = table_[i].start;
    std::memset(seen_ticks(), 0, max_clocks * sizeof(double));
    model_->clear();
    has_model_ = false;
    mode_ = instantiated;
    said_lost_ = said_sparse_ = said_mistaken_ = said_repeated_ = judged_ = false;
    said_implausible_ = nullptr;
    for (bool& said : said_refused_) said = false;
    touched_ = true;
    stale_ = ~0u;
    time_s_ = start_s_ = 0;
    stop_s_ = no_bound;
}

// ------------------------------------------------------------------------------------------------ log

const char* Instance::category(Status status) {
    constexpr const char* names[] = {"logEvents", "logStatusWarning", "logStatusError"};
    return names[static_cast<int>(status)];
}

void Instance::set_logging(bool on) {
    logged_[static_cast<int>(Status::ok)] = on;
    logged_[static_cast<int>(Status::warning)] = logged_[static_cast<int>(Status::error)] = true;
}

Status Instance::set_debug_logging(bool on, std::size_t n, const char* const* categories) {
    if (!allowed(Call::set_debug_logging)) return Status::error;
    if (n == 0) set_logging(on);
    if (n > 0 && !categories) return fail("SetDebugLogging got a null pointer");
    for (std::size_t i = 0; i < n; ++i) {
        int known = 0;
        for (const Status status : {Status::ok, Status::warning, Status::error})
            if (categories[i] && !std::strcmp(categories[i], category(status))) {
                logged_[static_cast<int>(status)] = on;
                known = 1;
            }
        if (!known) return fail("there is no log category %s", categories[i] ? categories[i] : "(null)");
    }
    return Status::ok;
}

void Instance::say(Status status, const char* format, va_list arguments) const {
    if (!importer_.log || !logged_[static_cast<int>(status)]) return;
    char text[512], shown[640] = "";
    std::vsnprintf(text, sizeof text, format, arguments);
    table_.name_fields(text, shown, sizeof shown);
    importer_.log(*this, status, shown);
}

Status Instance::fail(const char* format, ...) const {
    va_list arguments;
    va_start(arguments, format);
    say(Status::error, format, arguments);
    va_end(arguments);
    return Status::error;
}

void Instance::warn(const char* format, ...) const {
    va_list arguments;
    va_start(arguments, format);
    say(Status::warning, format, arguments);
    va_end(arguments);
}

void Instance::note(const char* format, ...) const {
    va_list arguments;
    va_start(arguments, format);
    say(Status::ok, format, arguments);
    va_end(arguments);
}

bool Instance::refuse(const Rule& rule) const {
    if (rule.interfaces & options_.interface) fail("%s is not allowed in %s", rule.name, mode_name(mode_));
    else fail("%s does not belong to %s", rule.name, options_.interface == co_simulation ? "Co-Simulation" : "Model Exchange");
    return false;
}

// ------------------------------------------------------------------------------------------------ life

Status Instance::check_time(const char* name, double t_s) const {
    constexpr double max_time_s = 1e12; // as in the library: no clock counts so far in seconds
    if (!std::isfinite(t_s)) return fail("%s = %g is not finite", name, t_s);
    if (std::fabs(t_s) > max_time_s) return fail("%s = %g s lies beyond %g s", name, t_s, max_time_s);
    return Status::ok;
}

Status Instance::set_up_experiment(double start_s, bool stop_defined, double stop_s) {
    if (!allowed(Call::enter_initialization)) return Status::error;
    if (check_time("startTime", start_s) != Status::ok) return Status::error;
    if (stop_defined && check_time("stopTime", stop_s) != Status::ok) return Status::error;
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

// Hash of all values that a model is created from.
std::uint64_t Instance::parameter_hash() const {
    Hash hash;
    const auto add = [&hash](const double& value) {
        const auto* bytes = reinterpret_cast<const unsigned char*>(&value);
        for (std::size_t i = 0; i < sizeof value; ++i) hash.add(bytes[i]);
    };
    add(start_s_);
    for (int i = 0; i < table_.size(); ++i)
        if (table_[i].causality == Causality::parameter) add(values_[i]);
    return hash.value;
}

// Creates the model at the first query in initialization mode, and again when a value that it is created from has changed.
// Importers read outputs in this mode and connect them (PyFMI's Master, OMSimulator); a plant is slow to load.
Status Instance::make_ready() {
    if (!touched_) return Status::ok;
    const std::uint64_t parameters = parameter_hash();
    if (!has_model_ || parameters != parameters_) {
        Message why;
        has_model_ = model_->initialise(values_, start_s_, options_.interface == model_exchange, &why);
        if (!has_model_) return fail("%s", why.text);
        parameters_ = parameters;
    }
    model_->begin(values_);
    if (options_.interface == model_exchange) model_->get_states(states_);
    touched_ = false;
    stale_ = ~0u;
    return Status::ok;
}

Status Instance::exit_initialization(bool fmi2) {
    if (!allowed(Call::exit_initialization) || make_ready() != Status::ok) return Status::error;
    seen_s_ = start_s_;
    note("initialised at t = %g s", start_s_);
    if (options_.interface == model_exchange) mode_ = event;
    else mode_ = !fmi2 && options_.event_mode_used ? event : step;
    for (int k = 0; k < clock_count_ && mode_ == step; ++k)
        if (table_[clock_row_[k]].causality == Causality::input) {
            warn(
                "samples come by clocks, which tick in event mode alone, and so there will be none: instantiate with eventModeUsed = "
                "true, or take the archive whose name does not end with Clocks");
            break;
        }
    return Status::ok;
}

Status Instance::change_mode(Call call, Mode mode) {
    if (!allowed(call)) return Status::error;
    if (call == Call::enter_event_mode && options_.interface == co_simulation && !options_.event_mode_used)
        return fail("EnterEventMode needs eventModeUsed");
    mode_ = mode;
    return Status::ok;
}

Status Instance::terminate() {
    if (change_mode(Call::terminate, terminated) != Status::ok) return Status::error;
    note("terminated at t = %.17g s", time_s_);
    return Status::ok;
}

Status Instance::reset() {
    if (!allowed(Call::reset)) return Status::error;
    restart();
    note("reset");
    return Status::ok;
}

// ------------------------------------------------------------------------------------------------ samples

// Called at a communication point or event. Lost samples are logged once; count.missed continues to count.
bool Instance::take_samples(double t_s) {
    const bool taken = model_->take_samples(values_, t_s);
    const double apart_s = t_s - seen_s_;
    seen_s_ = t_s;
    if (!judged_) {
        Message what;
        judged_ = model_->judge(&what);
        if (judged_ && what.text[0]) warn("%s", what.text);
    }
    say_what_was_lost(apart_s);
    return taken;
}

// Logged once, with the level of an error although the call succeeds: by default importers show no other level, and the
// estimate does not use the samples that the user means.
void Instance::say_what_was_lost(double apart_s) {
    if (const char* by = said_mistaken_ ? nullptr : model_->mistaken()) {
        said_mistaken_ = true;
        fail(
            "warning: %s changed for the first time after samples had been taken at the period of its sensor; they are forgotten, and "
            "the counter marks samples from now on: set sampling_mode = counter",
            by);
    }
    for (const Refusal by : {of_value, of_time})
        if (const char* why = said_refused_[by] ? nullptr : model_->refused(by)) {
            said_refused_[by] = true;
            fail("warning: %s; such samples are not used", why);
        }
    if (const char* why = model_->implausible(); why && why != said_implausible_) {
        said_implausible_ = why;
        fail("warning: %s", why);
    }
    if (const Lost held = said_repeated_ ? Lost{} : model_->repeated(); held.by) {
        said_repeated_ = true;
        warn(
            "the values of a sensor repeat, so each is used once: set %s to the period of the source, %.3g s, or connect the counter of its "
            "samples",
            held.by, held.period_s);
    }
    if (said_lost_) return;
    const Lost lost = model_->lost();
    if (!lost.by || (lost.sparse && said_sparse_)) return;
    (lost.sparse ? said_sparse_ : said_lost_) = true;
    say(lost, apart_s);
}

void Instance::say(const Lost& lost, double apart_s) const {
    if (lost.unstamped)
        fail(
            "warning: %s counts samples whose t_meas does not change, or is more than 1000 s away from the time of the simulation: "
            "connect t_meas of that sensor, in seconds of the simulation",
            lost.by);
    else if (lost.sparse)
        warn("communication step %g s > %s = %g s: inputs are one sample of each step, so the filter learns less", apart_s,
             lost.by, lost.period_s);
    else if (lost.period_s > 0)
        fail(
            "warning: communication step %g s > %s = %g s: samples are lost, and counted by count.missed; take a step that divides the "
            "period, or another period%s",
            apart_s, lost.by, lost.period_s, model_->can_hold() ? ", or sampling_mode = auto" : "");
    else
        fail(
            "warning: %s rose by more than 1 within a communication step of %g s: samples are lost, and counted by count.missed; take "
            "shorter steps",
            lost.by, apart_s);
}

// Inputs that are held over a step are sampled at each period inside it.
bool Instance::sample_inside(double end_s, Message* why) {
    const double begin_s = time_s_;
    for (double n = 0; n <= max_samples_inside; ++n) {
        const double due_s = model_->next_sample_inside_s(end_s);
        if (!(due_s < end_s)) return true;
        take_samples(due_s);
        if (!model_->advance(due_s, why)) return false;
    }
    std::snprintf(why->text, sizeof why->text, "a step of %g s holds more than %.0f samples: take a shorter one", end_s - begin_s,
                  max_samples_inside);
    return false;
}

// ------------------------------------------------------------------------------------------------ Co-Simulation

Status Instance::check_step(double t_s, double step_s) const {
    if (check_time("currentCommunicationPoint", t_s) != Status::ok) return Status::error;
    if (!std::isfinite(step_s) || !(step_s > 0)) return fail("communicationStepSize = %g must be finite and above 0", step_s);
    if (std::fabs(t_s - time_s_) > time_tolerance(time_s_, step_s))
        return fail("currentCommunicationPoint = %.17g, but the last step ended at %.17g", t_s, time_s_);
    const double end_s = t_s + step_s;
    if (check_time("the end of the step", end_s) != Status::ok) return Status::error;
    if (!(end_s > t_s)) return fail("communicationStepSize = %g is lost in rounding at t = %.17g", step_s, t_s);
    if (end_s > stop_s_ + time_tolerance(stop_s_, step_s))
        return fail("the step to %.17g passes stopTime = %.17g", end_s, stop_s_);
    return Status::ok;
}

Status Instance::do_step(double t_s, double step_s, IntermediateUpdate update, Step* reply) {
    const WithoutFloatTraps quiet;
    *reply = {};
    reply->last_successful_s = time_s_;
    if (!allowed(Call::do_step) || check_step(t_s, step_s) != Status::ok) return Status::error;
    double end_s = t_s + step_s;
    take_samples(t_s);
    // Returns early at a sample inside the step if the importer handles events.
    const double due_s = options_.event_mode_used ? model_->next_sample_s(values_) : no_bound;
    if (options_.early_return_allowed && due_s < end_s - time_tolerance(end_s, step_s)) {
        end_s = due_s;
        reply->early_return = true;
    }
    Message why;
    if (!sample_inside(end_s, &why)) return fail("%s", why.text);
    if (!model_->advance(end_s, &why)) return fail("%s", why.text);
    time_s_ = end_s;
    stale_ = ~0u;
    bool ticked = false;
    if (any_clock_active(&ticked) != Status::ok) return Status::error;
    reply->event_handling_needed = ticked || due_s <= end_s + time_tolerance(end_s, step_s);
    reply->last_successful_s = end_s;
    if (update) { // the importer may read, and no more, while its callback runs
        mode_ = intermediate;
        update(*this, end_s);
        mode_ = step;
    }
    return Status::ok;
}

// ------------------------------------------------------------------------------------------------ events

// Index of the clock of this value reference; -1, with a message, if there is none.
int Instance::clock_of(unsigned reference) const {
    for (int k = 0; k < clock_count_; ++k)
        if (slot(reference).rows > 0 && slot(reference).row == clock_row_[k]) return k;
    row_of(reference, Type::clock);
    return -1;
}

Status Instance::get_clocks(const unsigned* references, std::size_t n, bool* active) {
    if (!allowed(Call::get_clock)) return Status::error;
    if (n > 0 && (!references || !active)) return fail("a null pointer came with %zu value references", n);
    for (std::size_t i = 0; i < n; ++i) {
        const int k = clock_of(references[i]);
        if (k < 0 || refresh(table_[clock_row_[k]].group) != Status::ok) return Status::error;
        active[i] = values_[clock_row_[k]] != seen_ticks()[k];
    }
    return Status::ok;
}

// An active clock does not tick again, so a clock has at most one tick in an iteration.
Status Instance::set_clocks(const unsigned* references, std::size_t n, const bool* active) {
    if (!allowed(Call::set_clock)) return Status::error;
    if (n > 0 && (!references || !active)) return fail("a null pointer came with %zu value references", n);
    for (std::size_t i = 0; i < n; ++i) {
        const int k = clock_of(references[i]);
        if (k < 0) return Status::error;
        const Variable& row = table_[clock_row_[k]];
        if (row.causality != Causality::input) return fail("%s is no input clock", row.name);
    }
    for (std::size_t i = 0; i < n; ++i) {
        const int k = clock_of(references[i]);
        values_[clock_row_[k]] = seen_ticks()[k] + active[i];
    }
    return Status::ok;
}

Status Instance::any_clock_active(bool* active) {
    *active = false;
    for (int k = 0; k < clock_count_; ++k) {
        if (refresh(table_[clock_row_[k]].group) != Status::ok) return Status::error;
        *active |= values_[clock_row_[k]] != seen_ticks()[k];
    }
    return Status::ok;
}

Status Instance::end_ticks(bool* input_ticked) {
    *input_ticked = false;
    for (int k = 0; k < clock_count_; ++k) {
        const Variable& row = table_[clock_row_[k]];
        if (refresh(row.group) != Status::ok) return Status::error;
        *input_ticked |= row.causality == Causality::input && values_[clock_row_[k]] != seen_ticks()[k];
        seen_ticks()[k] = values_[clock_row_[k]];
    }
    return Status::ok;
}

// Applies the collected samples to the importer's states or to those of the model.
Status Instance::process_samples(bool* states_changed) {
    Message why;
    const bool done = options_.interface == model_exchange ? model_->jump(time_s_, states_, states_changed, &why)
                                                           : model_->advance(time_s_, &why);
    return done ? Status::ok : fail("%s", why.text);
}

// Samples of one instant form one event, even if their clocks tick in several iterations: samples are collected while clocks
// tick, and the first iteration without a tick processes them.
Status Instance::update_discrete_states(Events* events) {
    const WithoutFloatTraps quiet;
    *events = {};
    if (!allowed(Call::update_discrete_states)) return Status::error;
    take_samples(time_s_);
    if (end_ticks(&events->update_needed) != Status::ok) return Status::error;
    if (!events->update_needed && process_samples(&events->states_changed) != Status::ok) return Status::error;
    stale_ = ~0u;
    if (!events->update_needed && any_clock_active(&events->update_needed) != Status::ok) return Status::error;
    const double next = model_->next_sample_s(values_);
    events->next_event_defined = std::isfinite(next);
    events->next_event_s = events->next_event_defined ? next : 0;
    note("event at t = %.17g s, the next at %.17g s", time_s_, next);
    return Status::ok;
}

} // namespace hnav::fmu
