// The C boundary of the observer: creation and samples.
#include "c_api/observer.hpp"

#include "base/hash.hpp"
#include "c_api/engine_settings.hpp"
#include "c_api/sized.hpp"
#include "observer/bounded_plant.hpp"
#include "observer/callback_plant.hpp"
#include "options/lists.hpp"

#include <atomic>
#include <cmath>
#include <cstdio>
#include <initializer_list>

using hnav::ObserverObject;
using hnav::Refusal;
using hnav::observer::Answer;
using hnav::observer::Function;
using hnav::observer::Problem;

namespace {

// A given start time is a sample on its own channel.
void push_start(ObserverObject* o) {
    const double none = 0;
    if (o->start_s) o->filter.push({*o->start_s, o->filter.model().start_channel(), &none});
}

std::size_t workspace_bytes(const Problem& problem, bool smooths) {
    hnav::Arena count;
    const hnav::observer::Workspace work(count, problem, smooths);
    return count.used();
}

// With its problem.
std::size_t memory_bytes(const hnav::observer::PlantSizes& sizes) {
    hnav::Arena count;
    const Problem counted(count, sizes);
    return count.used() + workspace_bytes(counted, false);
}

bool take_memory(ObserverObject* o) {
    o->block = hnav::take_block(memory_bytes(o->plant->sizes));
    if (!o->block) return false;
    hnav::Arena arena(o->block);
    o->problem.emplace(arena, o->plant->sizes);
    o->work.emplace(arena, *o->problem);
    if (o->plant->sizes.events) hnav::observer::make_spread(o->problem->N, o->work->plane);
    return true;
}

hnav_status prove(ObserverObject* o, double start_s, const hnav::CallersMessage& caller) {
    o->work->linearisation.create(*o->plant);
    Refusal why;
    double* work = static_cast<double*>(hnav::take_block(hnav::observer::proof_doubles(*o->problem) * sizeof(double)));
    if (!work) return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for the proof of the derivatives");
    const bool answers = hnav::observer::prove(*o->plant, *o->problem, o->work->linearisation, start_s, work, &o->proof, why);
    hnav::release_block(work);
    if (!answers) return caller.refuse(why);
    if (!o->proof.memoryless)
        return caller.fail(HNAV_ERROR_UNSUPPORTED,
                           "the plant remembers what it was asked: its derivatives at the start changed after twenty others; "
                           "they must depend on time, states, inputs and parameters alone");
    if (!o->plant->go_to_start(why)) return caller.refuse(why);
    if (o->plant->remember(o->work->first_memory) != Answer::ok)
        return caller.fail(HNAV_ERROR_SOLVER, "the plant cannot return its discrete state at the start%s%s", o->colon(),
                           o->plant->said());
    return HNAV_OK;
}

hnav_status too_large(const hnav::observer::PlantSizes& sizes, int capacity, double bytes, const char* remedy,
                      const hnav::CallersMessage& caller) {
    return caller.fail(HNAV_ERROR_OPTION,
                       "%d states, unknown inputs and parameters with queue_capacity = %d take %.1f GiB, an observer may take "
                       "1 GiB: %sestimate fewer parameters and unknown inputs, or export a coarser model",
                       sizes.estimated(), capacity, bytes / hnav::max_filter_bytes, remedy);
}

// The numbers of a plan take memory in the workspace and in each place of the queue.
hnav_status check_memory(const ObserverObject& o, const hnav::observer::Model& model,
                         const ObserverObject::FilterOfModel::Settings& settings, const hnav::CallersMessage& caller) {
    const auto fixed = static_cast<double>(workspace_bytes(*o.problem, model.layout().joint_numbers > 0));
    const auto queue = static_cast<double>(ObserverObject::FilterOfModel::bytes(model, settings));
    const double left = hnav::max_filter_bytes - fixed;
    if (queue <= left) return HNAV_OK;
    const int capacity = o.options.queue_capacity;
    const double holds = hnav::capacity_that_fits(capacity, queue, left);
    char remedy[64] = "";
    if (holds >= 2) std::snprintf(remedy, sizeof remedy, "take queue_capacity = %.0f, ", holds);
    return too_large(o.plant->sizes, capacity, fixed + queue, remedy, caller);
}

hnav_status create_filter(ObserverObject* o, const hnav::CallersMessage& caller) {
    const hnav_observer_options& options = o->options;
    o->trouble = {};
    const hnav::observer::Model model(*o->plant, *o->problem, *o->work, o->stiff, o->trouble, options);
    if (model.by_points() && o->plant->sizes.events)
        return caller.fail(HNAV_ERROR_OPTION,
                           "propagation = sigma_points is for plants without events, and this one has some: take "
                           "derivatives");
    hnav::ObserverObject::FilterOfModel::Settings e;
    e.propagator.rtol = e.atol = options.rtol;
    e.propagator.max_steps = options.max_steps;
    e.horizon_s = options.horizon_s;
    // A sample within the horizon is late, not a clock jump.
    e.time_jump_limit_s = options.time_jump_limit_s > 0 ? std::fmax(options.time_jump_limit_s, options.horizon_s) : 0;
    // The base of the chain and a given start time take one place each.
    e.queue_capacity = options.queue_capacity + 2;
    e.fingerprint = o->problem->fingerprint(o->fingerprint);
    if (const hnav_status status = check_memory(*o, model, e, caller)) return status;
    const bool made = o->filter.create(model, e);
    if (made && model.make_stiff_solver(options.max_steps)) return HNAV_OK;
    if (!made && o->trouble.any)
        return caller.fail(HNAV_ERROR_SOLVER, "the plant has no derivatives within a millisecond of its start");
    return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for an observer with N = %d and queue_capacity = %d", o->problem->N,
                       options.queue_capacity);
}

hnav_status complete(ObserverObject* o, const hnav::observer::Statistics& known, const hnav::CallersMessage& caller) {
    const auto fixed = static_cast<double>(memory_bytes(o->plant->sizes));
    if (fixed > hnav::max_filter_bytes) return too_large(o->plant->sizes, o->options.queue_capacity, fixed, "", caller);
    if (!take_memory(o)) return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for an observer");
    Refusal why;
    if (!o->problem->assign(known, why)) return caller.refuse(why);
    if (o->problem->bounded) {
        auto* bounded = hnav::observer::BoundedPlant::create(o->plant, *o->problem);
        if (!bounded) return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for an observer");
        o->plant = bounded;
    }
    if (o->options.start_mode == HNAV_OBSERVER_START_GIVEN) o->start_s = o->options.start_time_s;
    hnav_status status = prove(o, o->options.start_time_s, caller);
    if (status == HNAV_OK) status = create_filter(o, caller);
    if (status != HNAV_OK) return status;
    o->plant->set_holders({o, hnav::each_holder});
    // Addresses are reused, and another copy of this library in the process has a separate counter.
    static std::atomic<std::uint64_t> made{0};
    const std::uint64_t own[] = {++made, reinterpret_cast<std::uintptr_t>(o)};
    o->own_number = hnav::hash(own, sizeof own);
    push_start(o);
    return status;
}

hnav_status push(ObserverObject* o, const char* kind, int index, int count, int first_channel, double t_s, double value) {
    if (index < 0 || index >= count)
        return o->fail(HNAV_ERROR_OUT_OF_RANGE, "there is no %s %d: there are %d", kind, index, count);
    if (!std::isfinite(t_s) || !std::isfinite(value)) {
        ++o->filter.refused.non_finite;
        return o->fail(HNAV_ERROR_NON_FINITE, "sample of %s %d at t = %g s is not finite: %g", kind, index, t_s, value);
    }
    if (const hnav_status status = hnav::check_time(o, t_s)) return status;
    char what[32];
    std::snprintf(what, sizeof what, "%s %d", kind, index);
    return hnav::queued(o, o->filter.push({t_s, first_channel + index, &value}), what, t_s, o->filter.late_limit_s());
}

// Missing functions of a plant with events; null: none.
const char* missing_for_events(const hnav_plant& p) {
    if (p.n_indicators > 0 && !p.indicators) return "indicators";
    if (p.n_discrete > 0 && !p.get_discrete) return "get_discrete";
    if (p.n_discrete > 0 && !p.set_discrete) return "set_discrete";
    const bool needs_event = p.n_indicators > 0 || p.n_discrete > 0 || p.next_event_s;
    return needs_event && !p.event ? "event" : nullptr;
}

} // namespace

namespace hnav {

void each_holder(const void* context, void (*seen)(void*, const double*), void* visitor) {
    const auto* o = static_cast<const ObserverObject*>(context);
    if (o->plant->sizes.memory == 0) return;
    const observer::Layout& at = o->layout();
    o->filter.visit_states([&](const RuntimeState& s) {
        for (int i = 0; i < at.parts; ++i) seen(visitor, s.x() + i * at.part_numbers + at.memory);
    });
    for (int i = 0; o->plant->sizes.events && i < observer::max_branches; ++i)
        seen(visitor, o->work->branches + i * at.part_numbers + at.memory);
    for (const double* part : {o->work->beginning, o->work->segment, o->work->point}) seen(visitor, part + at.memory);
    for (const observer::PassageMemory& e : o->work->passages) {
        seen(visitor, e.memory);
        seen(visitor, e.memory_after);
    }
    seen(visitor, o->work->first_memory);
}

hnav_status make_beside(const ObserverObject& of, ObserverObject* twin, const CallersMessage& caller) {
    using observer::Workspace;
    twin->plant = of.plant;
    twin->problem.emplace(*of.problem);
    twin->block = take_block(workspace_bytes(*twin->problem, true));
    if (!twin->block) return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for a smoother");
    Arena arena(twin->block);
    Workspace& work = twin->work.emplace(arena, *twin->problem, true);
    if (of.plant->sizes.events) std::copy_n(of.work->plane, 2 * observer::spread_count(of.problem->N), work.plane);
    std::copy_n(of.work->first_memory, of.plant->sizes.memory, work.first_memory);
    work.linearisation.take_choices(of.work->linearisation);
    twin->options = of.options;
    twin->fingerprint = of.fingerprint;
    twin->start_s = of.start_s;
    const hnav_status status = create_filter(twin, caller);
    if (status == HNAV_OK) push_start(twin);
    return status;
}

hnav_status make_observer(hnav_filter** filter, const hnav_observer_options& options, observer::Plant* plant,
                          const observer::Statistics& known, std::uint64_t fingerprint, const CallersMessage& caller) {
    auto* made = make_object<ObserverObject>();
    if (!made) {
        plant->destroy();
        return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for an observer");
    }
    made->plant = plant;
    made->options = options;
    made->fingerprint = fingerprint;
    const hnav_status status = complete(made, known, caller);
    if (status != HNAV_OK) destroy_object(made);
    else *filter = made;
    return status;
}

hnav_status ObserverObject::no_estimate(double t_s) const { return log_trouble("samples up to", t_s, " were dropped"); }

void ObserverObject::log_held(double t_s) const { log_trouble("the estimate was held before", t_s, ""); }

// Adds the plant's reason if it failed.
hnav_status ObserverObject::log_trouble(const char* what, double at_s, const char* happened) const {
    if (!trouble.any)
        return fail(
            HNAV_ERROR_SOLVER,
            "%s t = %.9g s%s: there is no usable estimate, but a state without bound, or more than max_steps steps of the "
            "solver",
            what, at_s, happened);
    const char* names[] = {"derivatives", "outputs", "indicators", "events"};
    const char* of = names[int(trouble.function)];
    if (trouble.function == Function::event && trouble.answer == Answer::ok)
        return fail(HNAV_ERROR_SOLVER, "%s t = %.9g s%s: the events of the plant do not end at t = %.9g s", what, at_s, happened,
                    filter.stamp_of(trouble.t_s));
    const char* answer = trouble.answer == Answer::ok       ? "gave a number that is not finite for"
                         : trouble.answer == Answer::broken ? "failed in"
                                                            : "had no answer for";
    return fail(HNAV_ERROR_SOLVER, "%s t = %.9g s%s: the plant %s its %s at t = %.9g s%s%s", what, at_s, happened, answer, of,
                filter.stamp_of(trouble.t_s), *trouble.said ? ": " : "", trouble.said);
}

void ObserverObject::destroy() { destroy_object(this); }

void ObserverObject::reset() {
    filter.reset();
    dropped = 0;
    push_start(this);
}

} // namespace hnav

extern "C" {

hnav_status hnav_observer_create(hnav_filter** filter, const hnav_observer_options* options, const hnav_plant* plant,
                                 const hnav_observer_statistics* known, char* message, size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    if (const hnav_status status = caller.begin(filter, "filter", {{options, "options"}, {plant, "plant"}, {known, "known"}}))
        return status;
    hnav_status status = hnav::check_size(caller, *plant, "plant", "hnav_plant");
    if (status == HNAV_OK) status = hnav::check_size(caller, *known, "known", "hnav_observer_statistics");
    if (status == HNAV_OK) status = caller.check_options(options, hnav::observer_options);
    if (status != HNAV_OK) return status;
    const hnav_plant given = hnav::take_in(*plant);
    if (!given.derivatives) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "plant.derivatives is null");
    if (const char* missing = missing_for_events(given))
        return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "plant.%s is null", missing);
    if (!given.outputs) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "plant.outputs is null");
    auto* made = hnav::make_object<hnav::observer::CallbackPlant>(given);
    if (!made) return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for an observer");
    Refusal why;
    if (!Problem::sizes_fit(made->sizes, why)) {
        made->destroy();
        return caller.refuse(why);
    }
    return hnav::make_observer(filter, *options, made, hnav::take_in(*known), hnav::fingerprint(hnav::observer_options, options),
                               caller);
}

hnav_status hnav_observer_push_input(hnav_filter* filter, int32_t input, double t_s, double value) {
    REQUIRE_OBJECT(ObserverObject, object, filter);
    return push(object, "input", input, object->problem->known, 0, t_s, value);
}

hnav_status hnav_observer_push(hnav_filter* filter, int32_t sensor, double t_s, double value) {
    REQUIRE_OBJECT(ObserverObject, object, filter);
    return push(object, "sensor", sensor, object->problem->sensors, object->filter.model().sensor_channel(0), t_s, value);
}

} // extern "C"
