#include "observer/fmu_plant.hpp"

#include "base/arena.hpp"
#include "base/memory.hpp"
#include "observer/dependencies.hpp"
#include "observer/platform.hpp"

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <utility>

namespace hnav::observer {
namespace {

constexpr int max_iterations = 100; // of an event

// Full, and with / between folders and at the end.
bool full_path(const char* folder, char* to) {
#ifdef _WIN32
    if (!_fullpath(to, folder, max_path)) return false;
    for (char* c = to; *c; ++c)
        if (*c == '\\') *c = '/';
#else
    char resolved[PATH_MAX];
    if (!realpath(folder, resolved) || std::strlen(resolved) + 2 > max_path) return false;
    std::strcpy(to, resolved);
#endif
    const std::size_t length = std::strlen(to);
    if (length + 2 > max_path) return false;
    if (to[length - 1] != '/') std::strcat(to, "/");
    return true;
}

} // namespace

FmuPlant* FmuPlant::open(const char* folder, Plan& plan, double start_s, Refusal& why) {
    auto* plant = make_object<FmuPlant>();
    if (!plant || !plant->prepare(plan)) {
        why.refuse(Refusal::plant, "no memory for a plant");
        destroy_object(plant);
        return nullptr;
    }
    plant->start_s_ = start_s;
    if (plant->load(folder, why) && plant->start(why) && plant->take_starts(plan, why)) return plant;
    plant->destroy();
    return nullptr;
}

// False: no memory.
bool FmuPlant::prepare(const Plan& plan) {
    if (!plan_.copy(plan)) return false;
    sizes = plan.sizes;
    rows_ = take_block(place_rows(nullptr));
    if (!rows_) return false;
    place_rows(rows_);
    std::fill_n(ones_, sizes.estimated(), 1.0);
    list_asked();
    return true;
}

// Bytes of all.
std::size_t FmuPlant::place_rows(void* block) {
    Arena arena(block);
    inputs_ = arena.doubles(sizes.inputs);
    parameters_ = arena.doubles(sizes.parameters);
    column_ = arena.doubles(std::max(sizes.states, sizes.outputs));
    ones_ = arena.doubles(sizes.estimated());
    together_ = arena.rows<Reference>(sizes.estimated());
    return arena.used();
}

void FmuPlant::list_asked() {
    for (int i = 0; i < sizes.outputs; ++i) {
        const Reference* end = asked_ + asked_count_;
        asked_as_[i] = static_cast<int>(std::find(static_cast<const Reference*>(asked_), end, plan_.sensor[i]) - asked_);
        if (asked_as_[i] == asked_count_) asked_[asked_count_++] = plan_.sensor[i];
    }
}

bool FmuPlant::load(const char* folder, Refusal& why) {
    char path[max_path], binary[max_path], reason[200] = "";
    const char* missing = "";
    if (!full_path(folder, resources_)) return why.refuse(Refusal::impossible, "%.200s is no folder", folder);
    if (!binary_here(plan_.binary, plan_.fmi, binary, sizeof binary) ||
        std::snprintf(path, sizeof path, "%s%s", resources_, binary) >= max_path || std::strlen(resources_) + 12 > max_path)
        return why.refuse(Refusal::impossible, "the path of the folder is longer than %d characters", max_path);
    std::strcat(resources_, "resources/");
    // Static variables are shared by all instances of a loaded library: each plant loads a file of its own.
    if (!library_.open_alone(path, reason, sizeof reason))
        return why.refuse(Refusal::impossible, "%.100s cannot be loaded: %s", binary, reason);
    fmi_ = plan_.fmi == 2 ? make_fmi2_instance(by_steps()) : make_fmi3_instance(by_steps());
    if (!fmi_) return why.refuse(Refusal::plant, "no memory for an instance");
    if (!fmi_->find(library_, &missing))
        return why.refuse(Refusal::impossible, "%.100s has no function %s: it does not offer %s of FMI %d", binary, missing,
                          by_steps() ? "Co-Simulation" : "Model Exchange", plan_.fmi);
    return true;
}

bool FmuPlant::start(Refusal& why) {
    fmi_->said[0] = '\0';
    if (!fmi_->instantiate(plan_.token, resources_))
        return why.refuse(Refusal::plant, "%s could not be instantiated%s%s", plan_.identifier, *fmi_->said ? ": " : "",
                          fmi_->said);
    running_ = initialise(why);
    return running_;
}

// By what was said last; always false.
bool FmuPlant::refuse(Refusal& why) const { return why.refuse(Refusal::plant, "%s: %s", plan_.identifier, said_); }

bool FmuPlant::initialise(Refusal& why) {
    Answer done = Answer::ok;
    t_s_ = start_s_;
    for (int i = 0; done == Answer::ok && i < plan_.set_count; ++i) done = fmi_->set(plan_.set + i, 1, plan_.set_value + i);
    if (done == Answer::ok) done = fmi_->enter_initialization(start_s_);
    if (done == Answer::ok) done = fmi_->exit_initialization();
    if (done == Answer::ok && !by_steps()) done = begin_continuous_time();
    if (done != Answer::ok)
        return why.refuse(Refusal::plant,
                          "%s could not be initialised at t = %g s%s%s; other start values may help, set in the plan",
                          plan_.identifier, start_s_, *fmi_->said || *said_ ? ": " : "", *said_ ? said_ : fmi_->said);
    // The FMU's present values serve for inputs without a sample and parameters that are not estimated.
    done = fmi_->get(plan_.input, sizes.inputs, inputs_);
    if (done == Answer::ok) done = fmi_->get(plan_.parameter, sizes.parameters, parameters_);
    if (keep(done, "get") != Answer::ok) return refuse(why);
    return by_steps() ? begin_steps(why) : begin_events(why);
}

Answer FmuPlant::begin_continuous_time() {
    const Answer done = iterate();
    return done == Answer::ok ? fmi_->enter_continuous_time_mode() : done;
}

// The first instance determines whether there are events; every instance begins with its own discrete state.
bool FmuPlant::begin_events(Refusal& why) {
    if (sizes.events) return true;
    const int indicators = fmi_->indicators(plan_.indicators);
    first_event_s_ = next_event_s_;
    sizes.events = !plan_.memoryless && (indicators > 0 || plan_.discrete || first_event_s_ < HUGE_VAL);
    if (!sizes.events) return true;
    if (plan_.state_access == 0)
        return why.refuse(
            Refusal::impossible,
            "%s has events and cannot save its state: export it with canGetAndSetFMUstate, or without events; if its "
            "answers depend on time, states, inputs and parameters alone, say memoryless in the plan",
            plan_.identifier);
    sizes.indicators = indicators;
    return take_memory(why);
}

bool FmuPlant::take_memory(Refusal& why) {
    if (!memory_.create(*fmi_, plan_.state_access == 2))
        return why.refuse(Refusal::plant, "%s declares that its state can be saved, but it cannot%s%s", plan_.identifier,
                          *fmi_->said ? ": " : "", fmi_->said);
    sizes.memory = before_memory() + memory_.numbers();
    held_ = static_cast<double*>(take_block(sizes.memory * sizeof(double)));
    if (!held_) return why.refuse(Refusal::plant, "no memory for a plant");
    return remember(held_) == Answer::ok || refuse(why);
}

bool FmuPlant::take_starts(Plan& plan, Refusal& why) {
    const int n = sizes.states;
    const Block moments(2 * n * sizeof(double));
    if (!moments.doubles()) return why.refuse(Refusal::plant, "no memory for a plant");
    double *own = moments.doubles(), *nominal = own + n;
    const int unknown = sizes.unknown_inputs, known = sizes.known_inputs();
    Answer done = by_steps() ? fmi_->get(plan_.state, n, own) : fmi_->get_states(own, n);
    std::fill_n(nominal, n, 1.0);
    if (done == Answer::ok && !by_steps()) done = fmi_->get_nominals(nominal, n);
    if (done != Answer::ok)
        return why.refuse(Refusal::plant, "%s does not return its states%s%s", plan_.identifier, *fmi_->said ? ": " : "",
                          fmi_->said);
    for (int i = 0; i < n; ++i) plan.nominal[i] = std::max(plan.nominal[i], std::fabs(nominal[i]));
    const auto fill = [](double* given, const double* from, int count) {
        for (int i = 0; i < count; ++i)
            if (std::isnan(given[i])) given[i] = from[i];
    };
    fill(plan.start, own, n);
    fill(plan.start + n, inputs_ + known, unknown);
    fill(plan.start + n + unknown, parameters_, sizes.parameters);
    fill(plan.input_start, inputs_, known);
    return plan_.copy(plan) || why.refuse(Refusal::plant, "no memory for a plant");
}

void FmuPlant::close() {
    release_block(held_);
    release_block(rows_);
    if (!fmi_) return;
    free_instance();
    fmi_->destroy();
    fmi_ = nullptr;
}

// An instance that crashes when freed is kept, with its code.
void FmuPlant::free_instance() {
    memory_.forget(*fmi_);
    if (plan_.never_freed) library_.stay();
    else fmi_->free();
}

void FmuPlant::destroy() { destroy_object(this); }

// Keeps the message of a failed call.
Answer FmuPlant::keep(Answer answer, const char* call) {
    if (answer != Answer::ok) std::snprintf(said_, sizeof said_, "%s failed%s%s", call, *fmi_->said ? ": " : "", fmi_->said);
    return answer;
}

Answer FmuPlant::unless_terminated(Answer answer, bool terminate) {
    if (answer != Answer::ok || !terminate) return answer;
    std::snprintf(said_, sizeof said_, "it asks to terminate");
    return Answer::broken;
}

// A broken instance cannot be used.
Answer FmuPlant::ended(Answer answer) {
    if (answer == Answer::broken) running_ = false;
    return answer;
}

Answer FmuPlant::iterate() {
    for (int i = 0; i < max_iterations; ++i) {
        FmiInstance::Iteration found{};
        Answer done = keep(fmi_->iterate(&found), "the event iteration");
        done = unless_terminated(done, found.terminate);
        if (done != Answer::ok) return done;
        next_event_s_ = found.next_event_defined ? found.next_event_s : HUGE_VAL;
        if (!found.again) return Answer::ok;
    }
    std::snprintf(said_, sizeof said_, "its event iteration does not end");
    return Answer::broken;
}

bool FmuPlant::differs(const Point& at) const {
    bool changed = std::memcmp(at.p, parameters_, sizes.parameters * sizeof(double)) != 0;
    for (int i = 0; i < sizes.inputs; ++i) changed = changed || (plan_.input_is_discrete[i] && at.u[i] != inputs_[i]);
    return changed;
}

// Parameters and discrete inputs may change in event mode only.
Answer FmuPlant::change_discrete(const Point& at) {
    if (!differs(at)) return Answer::ok;
    if (sizes.events && (has_gone_on_ || is_moved_)) {
        // Not from the state of another evaluation, which may lie beyond an event that has not happened.
        has_gone_on_ = true;
        const Answer back = recall(held_);
        return back == Answer::ok ? change_discrete(at) : back;
    }
    has_gone_on_ = sizes.events;
    Answer done = keep(fmi_->enter_event_mode(), "EnterEventMode");
    if (done == Answer::ok && sizes.parameters > 0)
        done = keep(fmi_->set(plan_.parameter, sizes.parameters, at.p), "setting parameters");
    for (int i = 0; done == Answer::ok && i < sizes.inputs; ++i)
        if (plan_.input_is_discrete[i]) done = keep(fmi_->set(plan_.input + i, 1, at.u + i), "setting an input");
    if (done == Answer::ok) done = iterate();
    if (done == Answer::ok) done = keep(fmi_->enter_continuous_time_mode(), "EnterContinuousTimeMode");
    if (done == Answer::ok) std::copy_n(at.p, sizes.parameters, parameters_);
    return done;
}

Answer FmuPlant::move_to(const Point& at) {
    if (!running_ && !restart()) return Answer::broken;
    if (by_steps()) return place(at);
    Answer done = change_discrete(at);
    is_moved_ = true;
    if (done == Answer::ok) done = keep(fmi_->set_time(at.t_s), "SetTime");
    if (done == Answer::ok) done = keep(fmi_->set_states(at.x, sizes.states), "SetContinuousStates");
    for (int i = 0; done == Answer::ok && i < sizes.inputs; ++i) {
        if (at.u[i] == inputs_[i]) continue;
        if (!plan_.input_is_discrete[i]) done = keep(fmi_->set(plan_.input + i, 1, at.u + i), "setting an input");
        inputs_[i] = at.u[i];
    }
    return ended(done);
}

// After an error an instance cannot be used. A new one replaces it if its state can be set; after a fatal error there is no
// replacement.
bool FmuPlant::restart() {
    if (fmi_->dead || lost_) return false;
    if (!memory_lasts()) {
        std::snprintf(said_, sizeof said_,
                      "it has failed, and the states that it has saved are lost with it: make a new observer");
        lost_ = true;
        return false;
    }
    free_instance();
    Refusal why;
    has_gone_on_ = sizes.memory > 0;
    return start(why) && (sizes.memory == 0 || recall(held_) == Answer::ok);
}

// One instance exists at a time: some FMUs lose events while there are two. The instance of the derivative check is freed before
// another is made; an FMU with one instance for each process keeps it.
bool FmuPlant::go_to_start(Refusal& why) {
    if (plan_.once || plan_.never_freed) return recall(held_) == Answer::ok || refuse(why);
    free_instance();
    running_ = false;
    has_gone_on_ = is_moved_ = false;
    return start(why) && (remember(held_) == Answer::ok || refuse(why));
}

// ------------------------------------------------------------------------------------------------ Co-Simulation

// Between steps all continuous states must be settable, and the next step must begin from them.
bool FmuPlant::begin_steps(Refusal& why) {
    if (sizes.memory > 0) return true;
    sizes.steps = running_ = true;
    if (plan_.state_access == 0)
        return why.refuse(
            Refusal::impossible,
            "%s offers Co-Simulation only and cannot get and set its state: export it with canGetAndSetFMUstate, or "
            "for Model Exchange",
            plan_.identifier);
    if (!take_memory(why)) return false;
    const Block states(4 * sizes.states * sizeof(double));
    if (!states.doubles()) return why.refuse(Refusal::plant, "no memory for a plant");
    double *x = states.doubles(), *after = x + sizes.states;
    if (keep(fmi_->get(plan_.state, sizes.states, x), "reading its states") != Answer::ok) return refuse(why);
    const Point start{start_s_, x, inputs_, parameters_};
    if (place(start) != Answer::ok)
        return why.refuse(
            Refusal::impossible,
            "%s offers Co-Simulation only, and its states cannot be set between steps: %s; export it for Model Exchange",
            plan_.identifier, said_);
    if (step(start, plan_.step_s, after) != Answer::ok)
        return why.refuse(Refusal::plant, "%s makes no step: %s", plan_.identifier, said_);
    return sensors_follow(x, after, why) && states_follow(x, after, after + sizes.states, why) &&
           (recall(held_) == Answer::ok || refuse(why));
}

// A step from other states has another end. moved: room for twice the states.
bool FmuPlant::states_follow(const double* x, const double* after, double* moved, Refusal& why) {
    double* after_moved = moved + sizes.states;
    for (int i = 0; i < sizes.states; ++i) {
        std::copy_n(x, sizes.states, moved);
        moved[i] += 1e-3 * std::max(std::fabs(x[i]), 1.0);
        const Answer done = step({start_s_, moved, inputs_, parameters_}, plan_.step_s, after_moved);
        if (done != Answer::ok || std::equal(after, after + sizes.states, after_moved))
            return why.refuse(
                Refusal::impossible,
                "%s offers Co-Simulation only, and its state %d cannot be set between steps%s%s: export it for Model "
                "Exchange",
                plan_.identifier, i, done == Answer::ok ? "" : ": ", done == Answer::ok ? "" : said_);
    }
    return true;
}

// The instance has made a step. Sensors that only a step computes keep their value when the states are set.
bool FmuPlant::sensors_follow(const double* x, const double* after, Refusal& why) {
    double stepped[max_channels_used], placed[max_channels_used], before[max_channels_used];
    Answer done = fmi_->get(plan_.sensor, sizes.outputs, stepped);
    for (const auto& [states, values] : {std::pair{after, placed}, std::pair{x, before}})
        if (done == Answer::ok) done = evaluate(Function::outputs, {start_s_, states, inputs_, parameters_}, values);
    for (int i = 0; done == Answer::ok && i < sizes.outputs; ++i)
        if (placed[i] == before[i] && stepped[i] != before[i])
            return why.refuse(Refusal::impossible,
                              "%s offers Co-Simulation only, and its sensor %d does not follow its states between steps: take a "
                              "state as sensor, or export it for Model Exchange",
                              plan_.identifier, i);
    return done == Answer::ok || why.refuse(Refusal::plant, "%s: reading a sensor failed", plan_.identifier);
}

// At the time of its saved state: a step changes time and hidden states.
Answer FmuPlant::place(const Point& at) {
    if (has_gone_on_) {
        const Answer back = recall(held_);
        if (back != Answer::ok) return back;
    }
    Answer done = keep(fmi_->set(plan_.state, sizes.states, at.x), "setting its states between steps");
    if (done == Answer::ok && sizes.inputs > 0) done = keep(fmi_->set(plan_.input, sizes.inputs, at.u), "setting inputs");
    if (done == Answer::ok && sizes.parameters > 0)
        done = keep(fmi_->set(plan_.parameter, sizes.parameters, at.p), "setting parameters");
    return ended(done);
}

Answer FmuPlant::step(const Point& from, double length_s, double* x) {
    Answer done = move_to(from);
    if (done != Answer::ok) return done;
    bool terminate = false;
    has_gone_on_ = true;
    done = keep(fmi_->step(t_s_, length_s, &terminate), "DoStep");
    done = unless_terminated(done, terminate);
    if (done == Answer::ok) done = keep(fmi_->get(plan_.state, sizes.states, x), "reading its states");
    if (done == Answer::broken) running_ = false;
    t_s_ += length_s;
    return done;
}

// Rates of the states over its usual step.
Answer FmuPlant::rates(const Point& at, double* values) {
    const Answer done = step(at, plan_.step_s, values);
    for (int i = 0; i < sizes.states; ++i) values[i] = (values[i] - at.x[i]) / plan_.step_s;
    return done;
}

// ------------------------------------------------------------------------------------------------ events

Answer FmuPlant::indicators(const Point& at, double* z) {
    const Answer done = move_to(at);
    if (done != Answer::ok) return done;
    return ended(keep(fmi_->get_indicators(z, sizes.indicators), "GetEventIndicators"));
}

Answer FmuPlant::event(const Point& at, double* x, double* next_s) {
    if (!running_ && !restart()) return Answer::broken;
    has_gone_on_ = true;
    Answer done = keep(fmi_->set_time(at.t_s), "SetTime");
    if (done == Answer::ok) done = keep(fmi_->set_states(at.x, sizes.states), "SetContinuousStates");
    if (done == Answer::ok) done = keep(fmi_->enter_event_mode(), "EnterEventMode");
    if (done == Answer::ok) done = keep(fmi_->set(plan_.input, sizes.inputs, at.u), "setting inputs");
    if (done == Answer::ok) done = keep(fmi_->set(plan_.parameter, sizes.parameters, at.p), "setting parameters");
    if (done == Answer::ok) done = iterate();
    if (done == Answer::ok) done = keep(fmi_->enter_continuous_time_mode(), "EnterContinuousTimeMode");
    if (done == Answer::ok) done = keep(fmi_->get_states(x, sizes.states), "GetContinuousStates");
    if (done != Answer::ok) {
        running_ = false;
        return done;
    }
    std::copy_n(at.u, sizes.inputs, inputs_);
    std::copy_n(at.p, sizes.parameters, parameters_);
    *next_s = next_event_s_;
    return Answer::ok;
}

Answer FmuPlant::remember(double* memory) {
    if (sizes.memory == 0) return Answer::ok;
    if (!running_ && fmi_->dead) return Answer::broken;
    std::copy_n(inputs_, sizes.inputs, memory);
    std::copy_n(parameters_, sizes.parameters, memory + sizes.inputs);
    memory[inputs_and_parameters()] = t_s_;
    const Answer done = keep(memory_.store(*fmi_, holders, before_memory(), memory + before_memory()), "saving its state");
    if (done != Answer::ok) return done;
    if (memory != held_) std::memcpy(held_, memory, sizes.memory * sizeof(double));
    has_gone_on_ = is_moved_ = false;
    return done;
}

Answer FmuPlant::recall(const double* memory) {
    if (sizes.memory == 0) return Answer::ok;
    if (!has_gone_on_ && std::memcmp(memory, held_, sizes.memory * sizeof(double)) == 0) return Answer::ok;
    if (memory != held_) std::memcpy(held_, memory, sizes.memory * sizeof(double));
    has_gone_on_ = true;
    if (!running_) return restart() ? Answer::ok : Answer::broken;
    const Answer done = keep(memory_.load(*fmi_, held_ + before_memory()), "setting its state");
    if (done != Answer::ok) {
        running_ = false;
        return done;
    }
    has_gone_on_ = is_moved_ = false;
    std::copy_n(held_, sizes.inputs, inputs_);
    std::copy_n(held_ + sizes.inputs, sizes.parameters, parameters_);
    t_s_ = held_[inputs_and_parameters()];
    return done;
}

void FmuPlant::hold(const double* memory, int by) {
    if (sizes.memory > 0) memory_.hold(memory + before_memory(), by);
}

Answer FmuPlant::step_done(const Point& at, bool* wants_event) {
    *wants_event = false;
    if (!plan_.step_done) return Answer::ok;
    bool terminate = false;
    Answer done = move_to(at);
    if (done == Answer::ok) done = keep(fmi_->step_done(wants_event, &terminate), "CompletedIntegratorStep");
    done = unless_terminated(done, terminate);
    return ended(done);
}

Answer FmuPlant::evaluate(Function function, const Point& at, double* values) {
    if (by_steps() && function == Function::derivatives) return rates(at, values);
    Answer done = move_to(at);
    if (done != Answer::ok) return done;
    fmi_->said[0] = said_[0] = '\0';
    done = function == Function::derivatives ? keep(fmi_->get_derivatives(values, sizes.states), "GetDerivatives")
                                             : keep(fmi_->get(plan_.sensor, sizes.outputs, values), "reading a sensor");
    return ended(done);
}

// Allowed by the standards: derivatives of states and of outputs, by states and inputs. FMI 3 tools may offer parameters too.
bool FmuPlant::offers(Function function, Variable variable) const {
    if (!plan_.derivatives || (variable == Variable::parameter && plan_.fmi == 2)) return false;
    for (int i = 0; function == Function::outputs && i < sizes.outputs; ++i)
        if (!plan_.sensor_is_output[i] && state_of_output(i) < 0) return false;
    return true;
}

// The variable of a column of X.
Reference FmuPlant::known(int column) const {
    const int inputs = sizes.first(Variable::unknown_input), parameters = sizes.first(Variable::parameter);
    return column < inputs       ? plan_.state[column]
           : column < parameters ? plan_.input[sizes.known_inputs() + column - inputs]
                                 : plan_.parameter[column - parameters];
}

Answer FmuPlant::columns_of_outputs(Variable variable, double* J) {
    const int first = sizes.first(variable), N = sizes.estimated();
    for (int j = first; j < first + sizes.count(variable); ++j) {
        const Reference by = known(j);
        const Answer done = keep(fmi_->directional(asked_, asked_count_, &by, 1, ones_, column_), "GetDirectionalDerivative");
        if (done != Answer::ok) return done;
        for (int i = 0; i < sizes.outputs; ++i) J[i * N + j] = column_[asked_as_[i]];
    }
    return Answer::ok;
}

Answer FmuPlant::columns_of_derivatives(Variable variable, const Dependencies& dependencies, double* J) {
    for (int g = dependencies.first_group(variable); g < dependencies.last_group(variable); ++g) {
        const auto group = dependencies.group(g);
        for (int k = 0; k < group.count(); ++k) together_[k] = known(group.first[k]);
        const Answer done = keep(fmi_->directional(plan_.derivative, sizes.states, together_, group.count(), ones_, column_),
                                 "GetDirectionalDerivative");
        if (done != Answer::ok) return done;
        for (const int j : group)
            for (const int i : dependencies.column(j)) J[i * sizes.estimated() + j] = column_[i];
    }
    return Answer::ok;
}

Answer FmuPlant::jacobian(Function function, const bool (&wanted)[variables], const Point& at, const Dependencies& dependencies,
                          double* J) {
    Answer done = move_to(at);
    for (const Variable v : {Variable::state, Variable::unknown_input, Variable::parameter})
        if (done == Answer::ok && wanted[int(v)])
            done = function == Function::outputs ? columns_of_outputs(v, J) : columns_of_derivatives(v, dependencies, J);
    return ended(done);
}

bool FmuPlant::declares_dependencies() const {
    return std::any_of(plan_.declared, plan_.declared + sizes.states, [](std::uint8_t is) { return is != 0; });
}

int FmuPlant::state_of_output(int output) const {
    for (int i = 0; i < sizes.states; ++i)
        if (plan_.sensor[output] == plan_.state[i]) return i;
    return -1;
}

} // namespace hnav::observer
