// A hybrid filter: the estimate flows between events and jumps at them.
//
// Commit at events, look ahead between them: the estimate is kept just after each event; what is shown at a time t is a
// copy that has coasted there. So the same samples give the same bits whatever times are asked for, and a saved filter
// is numbers only.
//
// A model supplies the mathematics:
//     static constexpr int nx                                  continuous states
//     struct State { double x[nx]; ... }                       all that changes; 8-byte numbers only
//     void begin(State&) const                                 the state before any sample
//     bool flows(const State&) const                           false while there is nothing to integrate
//     bool plausible(const State&) const                       false when finite numbers lie beyond all sense
//     void normalise(State&) const                             x has come from an integrator outside: what it strained is restored
//     void flow(const State&, const double* x, double* dx) const       x' = f(x), inputs held in the state
//     void flow_exactly(State&, double interval_s) const       the same over an interval, in closed form
//     void before_flow(State&, const Event&) const             inputs of an event that act on the interval before it
//     void jump(State&, const Event&) const                    the correction; the state is at the event
//     void nominal(double* x) const                            sizes that absolute tolerances are relative to
#pragma once

#include "base/memory.hpp"
#include "base/saved_state.hpp"
#include "hybrid/event_queue.hpp"
#include "hybrid/propagator.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

namespace hnav {

enum class Outcome { ok, late, full, backwards, diverged };

template <class Model>
class Filter {
public:
    using State = typename Model::State;
    static constexpr int nx = Model::nx;

    struct Settings {
        Propagator::Settings propagator;
        bool closed_form = false; // use Model::flow_exactly; the propagator is not made
        double atol = 1e-8; // relative to Model::nominal
        double horizon_s = 0; // a sample may be this much older than the newest used one
        int queue_capacity = 64; // events, the base included
        std::uint64_t fingerprint = 0; // of the options: saved states fit filters of equal fingerprint
    };

    // Samples that never entered.
    struct Refused {
        std::uint64_t late, non_finite, zero;
    };

    Filter() = default;
    Filter(const Filter&) = delete;
    Filter& operator=(const Filter&) = delete;
    ~Filter() { release_block(memory_); }

    bool create(const Model& model, const Settings& settings) {
        static_assert(sizeof(State) % 8 == 0 && sizeof(Event) % 8 == 0, "states are saved as 8-byte numbers");
        model_ = model;
        settings_ = settings;
        memory_ = take_block(EventQueue<State>::bytes(settings.queue_capacity));
        if (!memory_) return false;
        queue_.create(memory_, settings.queue_capacity);
        reset();
        if (settings.closed_form) return true;
        double atol[nx];
        model_.nominal(atol);
        for (double& a : atol) a *= settings.atol;
        settings_.propagator.atol = atol;
        const FlowContext context{&model_, &queue_.at(0).after};
        const bool made = propagator_.create(nx, flow, settings_.propagator, &context, context.held->x);
        settings_.propagator.atol = nullptr;
        return made;
    }

    void reset() {
        State start;
        std::memset(static_cast<void*>(&start), 0, sizeof start);
        model_.begin(start);
        now_ = late_limit_ = -std::numeric_limits<double>::infinity();
        refused = {};
        propagator_.set_counts(0, 0);
        restart_chain(now_, start);
    }

    // Takes a sample in. It acts at the next advance that reaches its time.
    Outcome push(const Sample& sample) {
        if (sample.t_s < late_limit_) {
            ++refused.late;
            return Outcome::late;
        }
        return queue_.insert(sample, 1) ? Outcome::ok : Outcome::full;
    }

    // Room for `count` more samples, whatever their times.
    bool has_room(int count) const { return queue_.size() + count <= settings_.queue_capacity; }

    // Uses the samples up to t_s and shows the estimate there. Events that lead to no sound state are dropped, all of
    // them now: those that wait would fill the queue while each advance dropped one.
    Outcome advance(double t_s) {
        if (t_s < now_) return Outcome::backwards;
        Outcome outcome = Outcome::ok;
        while (queue_.solved() < queue_.size() && queue_.at(queue_.solved()).event.t_s <= t_s)
            if (solve(queue_.solved()) != Outcome::ok) outcome = Outcome::diverged;
        close_events();
        if (look_ahead(t_s) != Outcome::ok) return Outcome::diverged;
        now_ = t_s;
        return outcome;
    }

    double now_s() const { return now_; }
    const State& shown() const { return *view_; } // at now_s
    const State& newest() const { return queue_.newest_solved().after; } // just after the newest used event
    double newest_s() const { return queue_.newest_solved().event.t_s; } // its time; -infinity before the first
    double late_limit_s() const { return late_limit_; } // older samples are refused
    int waiting() const { return queue_.size() - queue_.solved(); }
    const Model& model() const { return model_; }
    const Propagator& propagator() const { return propagator_; }

    // Changes the newest state by hand (a command, not a sample) and closes every event before it.
    template <class Change>
    void change(Change&& apply) {
        while (queue_.solved() > 1) queue_.remove_first();
        State& state = queue_.at(0).after;
        apply(state);
        show_copy(state);
    }

    // -------------------------------------------------------------------------------------------- hybrid view

    void derivative(const double* x, double* dx) const { model_.flow(newest(), x, dx); }

    double next_event_s() const {
        return waiting() ? queue_.at(queue_.solved()).event.t_s : std::numeric_limits<double>::infinity();
    }

    // The events up to t_s act on the state x_minus, which an integrator of the caller has brought to t_s.
    Outcome jump(double t_s, const double* x_minus, double* x_plus) {
        while (queue_.solved() > 1) queue_.remove_first();
        auto& base = queue_.at(0);
        State state = base.after;
        std::memcpy(state.x, x_minus, sizeof state.x);
        model_.normalise(state);
        int used = 0;
        while (used < waiting() && queue_.at(1 + used).event.t_s <= t_s) {
            const Event& event = queue_.at(1 + used).event;
            // The integrator did not know this event: inputs that act on the interval before it are put in now.
            model_.rehold(state, event, event.t_s - (used > 0 ? queue_.at(used).event.t_s : base.event.t_s));
            model_.jump(state, event);
            ++used;
        }
        if (!sound(state)) {
            for (; used > 0; --used) queue_.remove(1);
            return Outcome::diverged;
        }
        if (used > 0) base.event.t_s = queue_.at(used).event.t_s;
        for (; used > 0; --used) queue_.remove(1);
        base.after = state;
        late_limit_ = base.event.t_s;
        std::memcpy(x_plus, state.x, sizeof state.x);
        show(t_s, state.x);
        return Outcome::ok;
    }

    void show(double t_s, const double* x) {
        show_copy(newest());
        std::memcpy(coasted_.x, x, sizeof coasted_.x);
        now_ = t_s;
    }

    // -------------------------------------------------------------------------------------------- save and load

    std::size_t state_size() const { return saved_state().bytes(); }

    void save(void* buffer) const {
        std::memset(buffer, 0, state_size());
        unsigned char* place = SavedState::numbers(buffer);
        place = put(place, Kept{now_, late_limit_, refused, propagator_.rhs_evals(), propagator_.steps(),
                                static_cast<std::uint64_t>(queue_.size()), static_cast<std::uint64_t>(queue_.solved())});
        place = put(place, queue_.at(0).after);
        place = put(place, *view_);
        for (int i = 0; i < queue_.size(); ++i) place = put(place, queue_.at(i).event);
        saved_state().seal(buffer);
    }

    // The filter is untouched unless the buffer is whole and made by a filter with the same model and options.
    LoadOutcome load(const void* buffer, std::size_t size) {
        const LoadOutcome outcome = saved_state().check(buffer, size);
        if (outcome != LoadOutcome::ok) return outcome;
        Kept kept;
        const unsigned char* place = get(SavedState::numbers(buffer), kept);
        if (kept.events < 1 || kept.events > static_cast<std::uint64_t>(settings_.queue_capacity) || kept.solved < 1 ||
            kept.solved > kept.events)
            return LoadOutcome::damaged;

        State base;
        place = get(place, base);
        place = get(place, coasted_);
        Event event;
        place = get(place, event);
        restart_chain(event.t_s, base);
        queue_.at(0).event = event;
        for (std::uint64_t i = 1; i < kept.events; ++i) place = get(place, queue_.append().event);
        while (queue_.solved() < static_cast<int>(kept.solved))
            if (solve(queue_.solved()) != Outcome::ok) break;
        view_ = &coasted_;
        now_ = kept.now;
        late_limit_ = kept.late_limit;
        refused = kept.refused;
        propagator_.set_counts(kept.rhs_evals, kept.steps);
        return LoadOutcome::ok;
    }

    Refused refused{};

private:
    static constexpr double least_interval_s = 1e-12;

    struct FlowContext {
        const Model* model;
        const State* held;
    };

    // What is saved beside the state of the base, the shown one and the events.
    struct Kept {
        double now, late_limit;
        Refused refused;
        std::uint64_t rhs_evals, steps;
        std::uint64_t events, solved;
    };

    // Models differ in the sizes of their states and events, and options in their fingerprint.
    SavedState saved_state() const {
        const std::size_t sizes[] = {sizeof(State), sizeof(Event)};
        return {SavedState::letters("HNAVFILT"), 2, hash(sizes, sizeof sizes, settings_.fingerprint),
                sizeof(Kept) + 2 * sizeof(State) + settings_.queue_capacity * sizeof(Event)};
    }

    static void flow(const void* context, const double* x, double* dx) {
        const auto* c = static_cast<const FlowContext*>(context);
        c->model->flow(*c->held, x, dx);
    }

    bool sound(const State& state) const {
        double sum = 0; // no NaN and no infinity leaves a sum of squares; and numbers whose squares overflow have no length
        for (double v : state.x) sum += v * v;
        return std::isfinite(sum) && model_.plausible(state);
    }

    // The chain of events begins with a base that stands for all that went before.
    void restart_chain(double t_s, const State& state) {
        queue_.clear();
        auto& base = queue_.append();
        base.event = {};
        base.event.t_s = t_s;
        base.after = state;
        queue_.mark_solved();
        view_ = &base.after;
    }

    void show_copy(const State& state) {
        coasted_ = state;
        view_ = &coasted_;
    }

    // The first event has no time before it: its interval is infinite, and the state begins there. An interval with more
    // turns than an integrator can follow (a gap of days, a rate beyond all sense) is left to the closed form: a failure, or
    // numbers without bound, would come back with every later sample, because the interval only grows. So is one of no
    // length to speak of: a solver keeps its step for the next interval and multiplies the two, and a product that
    // underflows says to it that time runs back, now and ever after.
    void flow_over(State& state, double interval_s) {
        if (!(interval_s > 0) || std::isinf(interval_s) || !model_.flows(state)) return;
        if (settings_.closed_form || interval_s < least_interval_s) {
            model_.flow_exactly(state, interval_s);
            return;
        }
        const FlowContext context{&model_, &state};
        double before[nx];
        std::copy(state.x, state.x + nx, before);
        if (propagator_.integrate(&context, interval_s, state.x) && sound(state)) return;
        std::copy(before, before + nx, state.x);
        model_.flow_exactly(state, interval_s);
    }

    // The state after event i from the state after event i - 1. A failing event is dropped: the filter goes on.
    Outcome solve(int i) {
        auto& slot = queue_.at(i);
        const auto& previous = queue_.at(i - 1);
        slot.after = previous.after;
        model_.before_flow(slot.after, slot.event);
        flow_over(slot.after, slot.event.t_s - previous.event.t_s);
        model_.jump(slot.after, slot.event);
        if (!sound(slot.after)) {
            queue_.remove(i);
            return Outcome::diverged;
        }
        queue_.mark_solved();
        return Outcome::ok;
    }

    // Closes the events that no sample may change any more. The newest stays open: its other sensors may follow.
    void close_events() {
        const double newest = newest_s();
        late_limit_ = std::fmax(late_limit_, newest - settings_.horizon_s);
        while (queue_.solved() > 2 && queue_.at(1).event.t_s < late_limit_) queue_.remove_first();
        // A queue full of events that wait for late company (a horizon too long for it, a clock that stands still) would
        // refuse every later sample: the oldest close early. Two places are what a sample of rate and force needs.
        while (queue_.solved() > 2 && !has_room(2)) {
            queue_.remove_first();
            late_limit_ = std::fmax(late_limit_, queue_.at(0).event.t_s);
        }
    }

    Outcome look_ahead(double t_s) {
        const auto& last = queue_.newest_solved();
        view_ = &last.after;
        const double interval_s = t_s - last.event.t_s;
        if (!(interval_s > 0)) return Outcome::ok;
        coasted_ = last.after;
        flow_over(coasted_, interval_s);
        if (!sound(coasted_)) return Outcome::diverged;
        view_ = &coasted_;
        return Outcome::ok;
    }

    template <class T>
    static unsigned char* put(unsigned char* place, const T& value) {
        std::memcpy(place, &value, sizeof value);
        return place + sizeof value;
    }
    template <class T>
    static const unsigned char* get(const unsigned char* place, T& value) {
        std::memcpy(static_cast<void*>(&value), place, sizeof value);
        return place + sizeof value;
    }

    Model model_{};
    Settings settings_{};
    Propagator propagator_;
    EventQueue<State> queue_;
    void* memory_ = nullptr;
    State coasted_{};
    const State* view_ = &coasted_;
    double now_ = 0;
    double late_limit_ = 0;
};

} // namespace hnav
