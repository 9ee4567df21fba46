// A hybrid filter: the estimate is integrated between events and corrected at them.
//
// It commits at events and looks ahead between them: the estimate is kept just after each event; the estimate shown at a time
// t is a copy that is propagated to t. The same samples therefore give the same bits whichever times are requested, and a
// saved filter consists of numbers only.
//
// The model contains the mathematics; model_concept.hpp lists what a model must provide.
#pragma once

#include "base/instant.hpp"
#include "base/memory.hpp"
#include "base/rare.hpp"
#include "base/saved_state.hpp"
#include "hybrid/event_queue.hpp"
#include "hybrid/model_concept.hpp"
#include "hybrid/outcome.hpp"
#include "hybrid/propagator.hpp"
#include "hybrid/stamps.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace hnav {

template <class Model>
class Filter {
    static_assert(check_model<Model>());

public:
    using State = typename Model::State;
    using Event = typename Model::Event;
    using Sample = typename Event::Sample;

    struct Settings {
        Propagator::Settings propagator;
        bool closed_form = false; // use Model::flow_exactly, if it exists; no propagator is made
        double atol = 1e-8; // relative to Model::nominal
        double horizon_s = 0; // largest age of a sample relative to the newest used one
        double time_jump_limit_s = 0; // a stamp that decreases by more begins a new time base; 0: never
        int queue_capacity = 64; // number of events, including the base
        std::uint64_t fingerprint = 0; // of the options: saved states fit filters of equal fingerprint
    };

    // Numbers of samples that were not used.
    struct Refused {
        std::uint64_t late, non_finite, zero;
    };

    Filter() = default;
    Filter(const Filter&) = delete;
    Filter& operator=(const Filter&) = delete;
    ~Filter() { release_block(memory_); }

    // False: no memory, settings outside a solver's range, or a closed form that the model does not have.
    bool create(const Model& model, const Settings& settings) {
        if (settings.closed_form && !Model::has_closed_form) return false;
        memory_ = take_block(bytes(model, settings));
        if (!memory_) return false;
        create_in(memory_, model, settings);
        return settings.closed_form || make_propagator();
    }

    // The same with the closed form only, in memory owned by the caller: zeros of the given size, aligned for doubles.
    static std::size_t bytes(const Model& model, const Settings& settings) {
        const Sizes sizes = sizes_of(model);
        return queue_bytes(sizes, settings.queue_capacity) +
               (Queue::has_ring ? 0 : 2 * sizes.state_bytes() + nx_of(model) * sizeof(double));
    }
    void create_in(void* memory, const Model& model, const Settings& settings) {
        model_ = model;
        settings_ = settings;
        const Sizes sizes = sizes_of(model_);
        state_bytes_ = sizes.state_bytes();
        if constexpr (has_seldom_part<Model>) {
            seldom_end_ = Model::seldom_begin + Model::seldom_bytes;
        }
        queue_.create(memory, sizes, settings.queue_capacity);
        if constexpr (!Queue::has_ring) {
            unsigned char* const behind = static_cast<unsigned char*>(memory) + queue_bytes(sizes, settings.queue_capacity);
            coasted_ = reinterpret_cast<State*>(behind);
            spare_ = reinterpret_cast<State*>(behind + sizes.state_bytes());
            spare_x_ = reinterpret_cast<double*>(behind + 2 * sizes.state_bytes());
        }
        reset();
    }

    void reset() {
        queue_.clear();
        State& begun = spare();
        std::memset(static_cast<void*>(&begun), 0, queue_.sizes().state_bytes());
        model_.begin(begun);
        now_ = event_now_ = late_limit_ = -std::numeric_limits<double>::infinity();
        refused = {};
        stamps_.clear();
        propagator_.set_counts(0, 0);
        restart_chain(now_, begun);
    }

    // Queues a sample. It takes effect at the first advance that reaches its time. A sample that finds the queue full may be pushed again.
    Outcome push(const Sample& sample) {
        if (!queue_.full()) return place(sample);
        const auto before = stamps_;
        const Outcome outcome = place(sample);
        if (outcome == Outcome::full) stamps_ = before;
        return outcome;
    }

    // Queues all samples of a stamp that is later than every other, with the effect of separate pushes and an advance to that stamp, which
    // must follow. False: nothing was queued, because one of them needs the checks of push.
    bool push_event(const Event& event) {
        static_assert(has_fixed_size<Model>);
        const double t_s = event.t_s + stamps_.offset_s();
        const bool newest =
            t_s - sample_instant_s(t_s) > queue_.event(queue_.size() - 1).t_s && t_s >= late_limit_ && !queue_.full();
        if (!newest || !stamps_.place_together(event.present, event.t_s, now_, settings_.time_jump_limit_s)) return false;
        // Now, not after the advance: the next state then takes the place of the newest but one, whose slow part is often the same.
        close_before(t_s - settings_.horizon_s, 1);
        queue_.append();
        Event& taken = queue_.event(queue_.size() - 1);
        taken = event;
        taken.t_s = t_s;
        return true;
    }

    // Whether so many more samples have room, whatever their times.
    bool has_room(int count) const { return queue_.size() + count <= settings_.queue_capacity; }

    // Uses the samples up to t_s and shows the estimate there. All events without a valid state are dropped at once:
    // otherwise the waiting ones would fill the queue while each advance dropped one.
    Outcome advance(double stamp_s) {
        const double t_s = stamp_s + stamps_.offset_s();
        return runs_back(t_s) ? Outcome::backwards : advance_to(t_s);
    }

    // The same without the look-ahead: the estimate just after the newest event is shown until advance(stamp_s) is called.
    Outcome commit(double stamp_s) {
        const double t_s = stamp_s + stamps_.offset_s();
        if (runs_back(t_s)) return Outcome::backwards;
        const Outcome outcome = solve_to(t_s);
        view_ = &newest();
        now_ = event_now_ = t_s;
        return outcome;
    }

    // For a row of a recording whose samples have been pushed: rows that share a stamp have the times over which their
    // samples are spread; a row with an implausible stamp has none.
    Outcome advance_row(double stamp_s) {
        using Place = typename decltype(stamps_)::Place;
        switch (stamps_.last()) {
        case Place::spread: return advance_to(std::max(now_, queue_.event(queue_.size() - 1).t_s));
        case Place::left_out: return Outcome::ok;
        default: return advance_or_stay(stamp_s);
        }
    }

    // For a row whose stamp may run back within the horizon, which has admitted its samples.
    Outcome advance_or_stay(double stamp_s) {
        const double t_s = stamp_s + stamps_.offset_s();
        return runs_back(t_s) && t_s >= late_limit_ ? advance_to(now_) : advance(stamp_s);
    }

    int nx() const { return nx_of(model_); }
    // Times are given and shown in the clock of the samples' stamps.
    double now_s() const { return stamp_of(now_); }
    const State& shown() const { return *view_; } // at now_s
    const State& newest() const { return queue_.after(queue_.solved() - 1); } // just after the newest used event
    double newest_s() const { return stamp_of(newest_time_s()); } // its time; -infinity before the first
    double late_limit_s() const { return stamp_of(late_limit_); } // older samples are refused
    int waiting() const { return queue_.size() - queue_.solved(); }
    const Model& model() const { return model_; }
    // The filter's own time, which never decreases, and that of its newest used event.
    double stamp_of(double time_s) const { return time_s - stamps_.offset_s(); }
    double newest_time_s() const { return queue_.event(queue_.solved() - 1).t_s; }
    // Time from the newest used event to the shown estimate.
    double looked_ahead_s() const { return now_ - newest_time_s(); }
    // The filter's time of the last advance or jump. Under an external integrator, quantities that are not continuous states
    // are shown for this time: they change at events only.
    double event_now_s() const { return event_now_; }
    const auto& stamps() const { return stamps_; }
    const Propagator& propagator() const { return propagator_; }

    // Calls visit for every state in memory, also for unused ones.
    template <class Visit>
    void visit_states(Visit&& visit) const {
        for (int i = 0; i < settings_.queue_capacity; ++i) visit(queue_.after(i));
        visit(*coasted_);
        visit(*spare_);
    }

    // Changes the newest state by a command (not a sample) and closes every event before it.
    template <class Change>
    void change(Change&& apply) {
        while (queue_.solved() > 1) queue_.remove_first();
        State& state = queue_.after(0);
        apply(state);
        has_changed(0);
        show_copy(state);
    }

    // Notes in the newest state something that does not change the estimate, such as an event found by an external
    // integrator. Returns the result of `act`.
    template <class Act>
    bool note(Act&& act) {
        const bool shows_newest = view_ == &newest();
        while (queue_.solved() > 1) close_oldest();
        has_changed(0);
        if (shows_newest) view_ = &newest();
        return act(queue_.after(0));
    }

    // Uses the closed form although there is a propagator, if the model has one.
    void prefer_closed_form(bool prefer) { prefers_closed_form_ = prefer; }

    // -------------------------------------------------------------------------------------------- hybrid view

    void get_x(double* x) const { std::memcpy(x, x_of(newest()), nx() * sizeof(double)); }
    void derivative(const double* x, double* dx) const { model_.flow(newest(), x, dx); }

    double next_event_s() const {
        return waiting() ? stamp_of(queue_.event(queue_.solved()).t_s) : std::numeric_limits<double>::infinity();
    }

    // Applies the events up to t_s to the state x_minus, which the caller's integrator has propagated to t_s.
    Outcome jump(double stamp_s, const double* x_minus, double* x_plus) {
        const double t_s = stamp_s + stamps_.offset_s();
        while (queue_.solved() > 1) queue_.remove_first();
        State& state = *spare_;
        copy(state, queue_.after(0));
        std::memcpy(x_of(state), x_minus, nx() * sizeof(double));
        model_.normalise(state);
        if constexpr (may_cross<Model>) {
            bool any = !model_.crosses();
            if (!any && !model_.have_events_of_plant(state, t_s, &any)) return Outcome::diverged;
            if (!any && !(waiting() && queue_.event(1).t_s <= through(t_s))) {
                std::memmove(x_plus, x_minus, nx() * sizeof(double));
                return Outcome::ok;
            }
        }
        bool usable = sound(state);
        int used = apply_waiting(state, t_s, &usable);
        if (usable && used > 0) queue_.event(0).t_s = queue_.event(used).t_s;
        for (; used > 0; --used) queue_.remove(1);
        if (!usable) return Outcome::diverged;
        copy(queue_.after(0), state);
        has_changed(0);
        late_limit_ = queue_.event(0).t_s;
        std::memcpy(x_plus, x_of(state), nx() * sizeof(double));
        show(stamp_s, x_of(state));
        event_now_ = now_;
        return Outcome::ok;
    }

    void show(double stamp_s, const double* x) {
        show_copy(newest());
        std::memcpy(x_of(*coasted_), x, nx() * sizeof(double));
        now_ = stamp_s + stamps_.offset_s();
    }

    // -------------------------------------------------------------------------------------------- save and load

    std::size_t state_size() const { return saved_state().bytes(); }

    void save(void* buffer) const {
        std::memset(buffer, 0, state_size());
        unsigned char* place = SavedState::numbers(buffer);
        const Kept kept = kept_now();
        place = put(place, &kept, sizeof kept);
        place = put(place, &queue_.after(0), queue_.sizes().state_bytes());
        place = put(place, view_, queue_.sizes().state_bytes());
        for (int i = 0; i < queue_.size(); ++i) place = put(place, &queue_.event(i), queue_.sizes().event_bytes());
        saved_state().seal(buffer);
    }

    // Loads a saved state. The filter is unchanged unless the buffer is complete and from a filter with the same model and
    // options.
    LoadOutcome load(const void* buffer, std::size_t size) {
        const LoadOutcome outcome = saved_state().check(buffer, size);
        if (outcome != LoadOutcome::ok) return outcome;
        Kept kept;
        const unsigned char* place = get(SavedState::numbers(buffer), &kept, sizeof kept);
        if (!possible(kept)) return LoadOutcome::damaged;

        place = get(place, spare_, queue_.sizes().state_bytes());
        place = get(place, coasted_, queue_.sizes().state_bytes());
        restart_chain(0, *spare_);
        for (std::uint64_t i = 1; i < kept.events; ++i) queue_.append();
        for (int i = 0; i < queue_.size(); ++i) place = get(place, &queue_.event(i), queue_.sizes().event_bytes());
        while (queue_.solved() < static_cast<int>(kept.solved))
            if (solve(queue_.solved()) != Outcome::ok) break;
        view_ = coasted_;
        take_back(kept);
        return LoadOutcome::ok;
    }

    // The same for this filter itself, or one with equal options in this process: its length depends on the queued events, it
    // has no checksum, and it contains the solved states, so that none is computed again. Takes about a microsecond.
    std::size_t snapshot_size() const {
        return sizeof(Kept) + (1 + queue_.solved()) * queue_.sizes().state_bytes() + queue_.size() * queue_.sizes().event_bytes();
    }

    void take_snapshot(void* buffer) const {
        const Kept kept = kept_now();
        unsigned char* place = put(static_cast<unsigned char*>(buffer), &kept, sizeof kept);
        place = put(place, view_, queue_.sizes().state_bytes());
        for (int i = 0; i < queue_.size(); ++i) place = put(place, &queue_.event(i), queue_.sizes().event_bytes());
        for (int i = 0; i < queue_.solved(); ++i) place = put(place, &queue_.after(i), queue_.sizes().state_bytes());
    }

    // Calls act for every state in a snapshot, one after the other in the same memory. False: not a snapshot of such a
    // filter.
    template <class Visit>
    bool visit_snapshot(const void* buffer, std::size_t size, Visit&& visit) const {
        Kept kept;
        const unsigned char* place = open_snapshot(buffer, size, &kept);
        if (!place) return false;
        place = get(place, spare_, queue_.sizes().state_bytes());
        visit(*spare_);
        place += kept.events * queue_.sizes().event_bytes();
        for (std::uint64_t i = 0; i < kept.solved; ++i) {
            place = get(place, spare_, queue_.sizes().state_bytes());
            visit(*spare_);
        }
        return true;
    }

    // False: not a snapshot of such a filter, which is unchanged.
    bool restore_snapshot(const void* buffer, std::size_t size) {
        Kept kept;
        const unsigned char* place = open_snapshot(buffer, size, &kept);
        if (!place) return false;
        place = get(place, coasted_, queue_.sizes().state_bytes());
        queue_.clear();
        for (std::uint64_t i = 0; i < kept.events; ++i) queue_.append();
        for (int i = 0; i < queue_.size(); ++i) place = get(place, &queue_.event(i), queue_.sizes().event_bytes());
        for (std::uint64_t i = 0; i < kept.solved; ++i) {
            place = get(place, &queue_.after(static_cast<int>(i)), queue_.sizes().state_bytes());
            has_changed(static_cast<int>(i));
            queue_.mark_solved();
        }
        view_ = coasted_;
        take_back(kept);
        return true;
    }

    Refused refused{};

private:
    Outcome place(const Sample& sample) {
        if constexpr (!has_fixed_size<Model>)
            if (same_instant(sample.t_s, stamps_.last_s(sample.channel)) && has_again(sample)) return Outcome::ok;
        const auto newest_s = [this] { return std::max(now_, queue_.event(queue_.size() - 1).t_s); };
        const auto placed = stamps_.place(sample.channel, sample.t_s, now_, late_limit_, settings_.time_jump_limit_s, newest_s);
        using Place = typename decltype(stamps_)::Place;
        if (placed.how == Place::left_out) return Outcome::ok;
        if (placed.t_s < late_limit_ - sample_instant_s(late_limit_)) {
            ++refused.late;
            stamps_.note_late(sample.channel, newest_s());
            return Outcome::late;
        }
        Event* event = queue_.insert(sample, placed.t_s, 1);
        if (event && placed.how == Place::jumped) event->present |= new_time_base;
        return event ? Outcome::ok : Outcome::full;
    }

    using Sizes = decltype(sizes_of(std::declval<const Model&>()));
    using Queue = EventQueue<Sizes>;
    using Real = model_concept::Real<Model>;
    static constexpr double min_interval_s = 1e-12;
    // Longest interval in s for the integrator. Its cost is proportional to the turns within an interval, and it adds nothing
    // to a closed form where a model has one. A look-ahead is repeated while samples are missing, each time from the newest
    // event on: beyond a second it takes the closed form. An event is committed once: the integrator takes all but the long
    // gaps, within about a millisecond.
    static constexpr double max_look_ahead_s = 1, max_commit_s = 10;
    // The same limit for absurd rates: ten seconds at five turns a second. Small for the fuzzer, which must reach both sides
    // quickly.
#ifndef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
    static constexpr long max_steps_beside_closed_form = 10000;
#else
    static constexpr long max_steps_beside_closed_form = 200;
#endif

    using Context = FlowContext<Model>;
    using Timing = Stamps<Event::channel_count, !has_fixed_size<Model>, bursts_of<Model>()>;

    // Saved beside the state of the base, the shown one and the events.
    struct Kept {
        double now, event_now, late_limit;
        Refused refused;
        Timing stamps;
        std::uint64_t rhs_evals, steps;
        std::uint64_t events, solved;
    };

    Kept kept_now() const {
        return {now_,
                event_now_,
                late_limit_,
                refused,
                stamps_,
                propagator_.rhs_evals(),
                propagator_.steps(),
                static_cast<std::uint64_t>(queue_.size()),
                static_cast<std::uint64_t>(queue_.solved())};
    }

    bool possible(const Kept& kept) const {
        return kept.events >= 1 && kept.events <= static_cast<std::uint64_t>(settings_.queue_capacity) && kept.solved >= 1 &&
               kept.solved <= kept.events;
    }

    // The bytes behind the header of a snapshot, or null.
    const unsigned char* open_snapshot(const void* buffer, std::size_t size, Kept* kept) const {
        if (size < sizeof *kept) return nullptr;
        const unsigned char* place = get(static_cast<const unsigned char*>(buffer), kept, sizeof *kept);
        const bool fits = possible(*kept) && size == sizeof *kept + (1 + kept->solved) * queue_.sizes().state_bytes() +
                                                         kept->events * queue_.sizes().event_bytes();
        return fits ? place : nullptr;
    }

    void take_back(const Kept& kept) {
        now_ = kept.now;
        event_now_ = kept.event_now;
        late_limit_ = kept.late_limit;
        refused = kept.refused;
        stamps_ = kept.stamps;
        propagator_.set_counts(kept.rhs_evals, kept.steps);
    }

    // Models differ in the sizes of states and events, options in their fingerprint.
    SavedState saved_state() const {
        const std::size_t event = queue_.sizes().event_bytes(), state = queue_.sizes().state_bytes();
        const std::size_t sizes[] = {state, event};
        return {SavedState::letters("HNAVFILT"), 2, hash(sizes, sizeof sizes, settings_.fingerprint),
                sizeof(Kept) + 2 * state + settings_.queue_capacity * event};
    }

    static int flow(const void* context, const double* x, double* dx) {
        return static_cast<const Context*>(context)->flow(x, dx);
    }

    bool sound(const State& state) const {
        // A sum of squares is finite only if no number is NaN or infinite; numbers whose squares overflow are refused too.
        const Eigen::Map<const Eigen::Matrix<Real, compiled_nx<Model>(), 1>> x(x_of(state), nx());
        return std::isfinite(x.squaredNorm()) && model_.plausible(state);
    }

    // The chain of events begins with a base, which stands for the whole past.
    void restart_chain(double t_s, const State& state) {
        queue_.clear();
        queue_.append();
        queue_.sizes().clear(queue_.event(0), t_s);
        copy(queue_.after(0), state);
        has_changed(0);
        queue_.mark_solved();
        view_ = &queue_.after(0);
    }

    void show_copy(const State& state) {
        copy(coasted(), state);
        view_ = &coasted();
    }

    // The state propagated beyond the events; in a ring of states the free one behind the solved ones.
    State& coasted() {
        if constexpr (Queue::has_ring) return queue_.after(queue_.solved());
        else return *coasted_;
    }

    State& spare() {
        if constexpr (Queue::has_ring) return queue_.after(Sizes::states - 1);
        else return *spare_;
    }

    // Propagates over an interval. The first event begins the state: its interval is infinite. The closed form takes
    // intervals longer than longest_s and those with more turns than an integrator can follow (an absurd rate): a failure
    // there would recur with every later sample, because the interval only grows. It also takes intervals of negligible
    // length: a solver multiplies its step by the next interval, and a product that underflows makes its time run backward
    // for good. False: a model without a closed form is unchanged, except over the shortest intervals, for which one Euler
    // step suffices.
    bool flow_over(State& state, double interval_s, double longest_s) {
        if (!(interval_s > 0) || std::isinf(interval_s) || !model_.flows(state)) return true;
        if constexpr (Model::has_closed_form) {
            if constexpr (!small_build) {
                const bool exact = settings_.closed_form || prefers_closed_form_;
                const bool integrable = !exact && interval_s >= min_interval_s && interval_s <= longest_s;
                if (integrable && integrate(state, interval_s)) return true;
            }
            model_.flow_exactly(state, interval_s);
            return true;
        } else {
            if constexpr (may_cross<Model>)
                if (model_.crosses()) return cross(state, interval_s);
            if (interval_s < min_interval_s) return step_by_euler(state, interval_s);
            if constexpr (may_stiffen<Model>) return integrate_or_as_the_model_does(state, interval_s);
            else return integrate(state, interval_s);
        }
    }

    // If the whole interval fails, it is tried in shorter pieces; over the rest the model holds its estimate, if it can.
    // before: the state before, in other memory.
    bool flow_or_hold(State& state, const State& before, double interval_s, double longest_s) {
        [[maybe_unused]] const std::uint64_t steps = propagator_.steps();
        if constexpr (may_hold<Model>) model_.open_interval();
        const bool whole = flow_over(state, interval_s, longest_s);
        if constexpr (may_hold<Model>) {
            if (whole) return true;
            copy(*spare_, before);
            const double left_s = interval_s - flow_in_pieces(state, interval_s, longest_s, steps);
            copy(state, *spare_);
            model_.hold(state, left_s);
            return sound(state);
        }
        return whole;
    }

    // Continues from the spare state, which is updated after every completed piece. Returns the completed time.
    bool flow_over_piece(State& state, double length_s, double longest_s) {
        copy(state, *spare_);
        if (!flow_over(state, length_s, longest_s) || !sound(state)) return false;
        copy(*spare_, state);
        return true;
    }
    // steps: of the solver before the interval; all tries together have no more than one may have.
    double flow_in_pieces(State& state, double interval_s, double longest_s, std::uint64_t steps) {
        constexpr int most_pieces = 24; // a plant that fails late costs at most so many intervals
        const auto most = static_cast<std::uint64_t>(settings_.propagator.max_steps);
        double done_s = 0, piece_s = 0.5 * interval_s;
        for (int k = 0; k < most_pieces && done_s < interval_s && propagator_.steps() - steps < most; ++k) {
            const double length_s = std::min(piece_s, interval_s - done_s);
            if (flow_over_piece(state, length_s, longest_s)) done_s += length_s;
            else piece_s *= 0.25;
        }
        return done_s;
    }

    // False: the state is unchanged.
    bool integrate(State& state, double interval_s) {
        const Context context{&model_, &state};
        std::memcpy(spare_x_, x_of(state), nx() * sizeof(double));
        if (propagator_.integrate(&context, interval_s, x_of(state), rate_of(state)) && sound(state)) return true;
        std::memcpy(x_of(state), spare_x_, nx() * sizeof(double));
        return false;
    }

    // Uses a model's own solver if the options require it, or if the integrator makes no progress.
    bool integrate_or_as_the_model_does(State& state, double interval_s) {
        if (model_.by_points()) {
            return model_.flow_by_points(state, interval_s, propagator_) && sound(state);
        }
        if (!model_.is_stiff(state)) {
            if (integrate(state, interval_s)) return true;
            if (!propagator_.out_of_steps()) return false;
        }
        return model_.flow_stiffly(state, interval_s, propagator_) && sound(state);
    }

    bool cross(State& state, double interval_s) { return model_.cross(state, interval_s, propagator_) && sound(state); }

    double rate_of(const State& state) const {
        if constexpr (Model::bounds_rate) return model_.fastest_rate(state);
        else return Propagator::unknown_rate;
    }

    bool step_by_euler(State& state, double interval_s) {
        if (Context{&model_, &state}.flow(x_of(state), spare_x_) != 0) return false;
        for (int i = 0; i < nx(); ++i) x_of(state)[i] += interval_s * spare_x_[i];
        return true;
    }

    // Applies the waiting events up to t_s and returns their number. usable: false after an event without a valid state, which a later
    // event may hide by a new start.
    int apply_waiting(State& state, double t_s, bool* usable) const {
        int used = 0;
        while (used < waiting() && queue_.event(1 + used).t_s <= through(t_s)) {
            const Event& event = queue_.event(1 + used);
            // The integrator did not have this event's inputs of the interval before it: they are applied now.
            if constexpr (Model::reholds) model_.rehold(state, event, event.t_s - queue_.event(used).t_s);
            model_.jump(state, event);
            *usable = *usable && sound(state);
            ++used;
        }
        return used;
    }

    // The end of the instant of t_s: all samples with stamps up to it are included.
    static double through(double t_s) { return t_s + sample_instant_s(t_s); }
    static bool same_instant(double a_s, double b_s) { return std::fabs(a_s - b_s) <= sample_instant_s(a_s); }

    // A repeated row is no burst.
    bool has_again(const Sample& sample) const {
        const double t_s = sample.t_s + stamps_.offset_s();
        for (int i = queue_.size() - 1; i >= 0 && queue_.event(i).t_s >= t_s - sample_instant_s(t_s); --i) {
            const Event& event = queue_.event(i);
            if (same_instant(event.t_s, t_s) && event.has(sample.channel) &&
                std::memcmp(event.value(sample.channel), sample.value, event.values * sizeof(double)) == 0)
                return true;
        }
        return false;
    }

    // A state was written: its slow part differs from that of every other slot.
    void has_changed(int i) { queue_.tag(i) = ++last_tag_; }

    // Copies the state after the previous event as a start. Slots with equal tags have the same slow part, which is not
    // copied again.
    void go_on_from_before(int i, State& to, const State& from) {
        std::uint64_t& tag = queue_.tag(i);
        const std::uint64_t before = queue_.tag(i - 1);
        if (tag != before) {
            copy(to, from);
            tag = before;
        } else if constexpr (has_seldom_part<Model>) {
            auto* const target = reinterpret_cast<unsigned char*>(&to);
            const auto* const source = reinterpret_cast<const unsigned char*>(&from);
            std::memcpy(target, source, Model::seldom_begin); // few enough for the compiler's own moves
            std::memcpy(target + seldom_end_, source + seldom_end_, state_bytes_ - seldom_end_);
        } else {
            copy(to, from);
        }
    }

    // Computes the state after event i from the state after event i - 1. A failing event is dropped.
    Outcome solve(int i) {
        State& state = queue_.after(i);
        const State& before = queue_.after(i - 1);
        const Event& event = queue_.event(i);
        const double interval_s = event.t_s - queue_.event(i - 1).t_s;
        go_on_from_before(i, state, before);
        model_.before_flow(state, event);
        const bool crossed = flow_or_hold(state, before, interval_s, max_commit_s);
        if (crossed) model_.jump(state, event);
        if constexpr (has_seldom_part<Model>)
            if (Model::seldom_changes(state) != Model::seldom_changes(before)) has_changed(i);
        if (!crossed || !sound(state)) {
            has_changed(i);
            if (miss(state, before, event, interval_s)) queue_.mark_solved();
            else queue_.remove(i);
            return Outcome::diverged;
        }
        queue_.mark_solved();
        return Outcome::ok;
    }

    // The event gives no valid state: the model holds its estimate without it, if it can.
    bool miss(State& state, const State& before, const Event& event, double interval_s) {
        if constexpr (may_hold<Model>) {
            copy(state, before);
            return flow_or_hold(state, before, interval_s, max_commit_s) && model_.miss(state, event) && sound(state);
        }
        return false;
    }

    // Closes events before this time, which no further sample can change; `open` of the solved ones stay.
    void close_before(double limit_s, int open) {
        late_limit_ = std::max(late_limit_, limit_s);
        while (queue_.solved() > open && queue_.event(1).t_s < late_limit_) queue_.remove_first();
    }

    // The newest event stays open: samples of other sensors may follow.
    void close_events() {
        close_before(newest_time_s() - settings_.horizon_s, 2);
        // A queue full of open events (a horizon too long for it, a clock that stands still) would refuse every later sample,
        // so the oldest close early. A sample of rate and force needs two places.
        while (queue_.solved() > 2 && !has_room(2)) close_oldest();
    }

    void close_oldest() {
        queue_.remove_first();
        if (queue_.event(0).t_s > late_limit_) late_limit_ = queue_.event(0).t_s;
    }

    Outcome look_ahead(double t_s) {
        view_ = &newest();
        const double interval_s = t_s - newest_time_s();
        return interval_s > 0 ? coast(interval_s) : Outcome::ok;
    }

    // A separate function, because a row of a recording is shown at its own samples.
    HNAV_RARE Outcome coast(double interval_s) {
        State& ahead = coasted();
        copy(ahead, newest());
        if (!flow_or_hold(ahead, newest(), interval_s, max_look_ahead_s) || !sound(ahead)) return Outcome::diverged;
        view_ = &ahead;
        return Outcome::ok;
    }

    // The look-ahead went beyond the newest sample, so the shown time may decrease to it.
    bool runs_back(double t_s) const {
        const bool comes_back =
            settings_.time_jump_limit_s > 0 && now_ - t_s > settings_.time_jump_limit_s && t_s >= newest_time_s();
        return through(t_s) < now_ && !comes_back;
    }

    Outcome solve_to(double t_s) {
        Outcome outcome = Outcome::ok;
        while (queue_.solved() < queue_.size() && queue_.event(queue_.solved()).t_s <= through(t_s)) {
            if (solve(queue_.solved()) != Outcome::ok) outcome = Outcome::diverged;
            if constexpr (Queue::has_ring)
                if (queue_.solved() == Sizes::states) close_oldest();
        }
        close_events();
        return outcome;
    }

    Outcome advance_to(double t_s) {
        const Outcome outcome = solve_to(t_s);
        if (look_ahead(t_s) != Outcome::ok) return Outcome::diverged;
        now_ = event_now_ = t_s;
        return outcome;
    }

    static std::size_t queue_bytes(const Sizes& sizes, int capacity) { return (Queue::bytes(sizes, capacity) + 7) / 8 * 8; }

    bool make_propagator() {
        double* atol = spare_x_;
        model_.nominal(atol);
        for (int i = 0; i < nx(); ++i) atol[i] *= settings_.atol;
        settings_.propagator.atol = atol;
        settings_.propagator.bounds_rate = Model::bounds_rate;
        if constexpr (reads_in_part<Model>) settings_.propagator.read = Model::read;
        if constexpr (may_cross<Model>) settings_.propagator.looks_inside = model_.crosses();
        if constexpr (may_stiffen<Model>) settings_.propagator.may_be_stiff = true;
        if (Model::has_closed_form) settings_.propagator.max_steps = max_steps_beside_closed_form;
        Propagator::Settings settings = settings_.propagator;
        if constexpr (may_stiffen<Model>) settings.max_steps = std::min(Model::max_explicit_steps, settings.max_steps);
        const Context context{&model_, &queue_.after(0)};
        const bool made = propagator_.create(nx(), flow, settings, &context, x_of(*context.held));
        settings_.propagator.atol = nullptr;
        return made;
    }

    static Real* x_of(State& state) {
        if constexpr (has_fixed_size<Model>) return state.x;
        else return state.x();
    }
    static const Real* x_of(const State& state) {
        if constexpr (has_fixed_size<Model>) return state.x;
        else return state.x();
    }

    // Copies bytes. For an unknown size the compiler calls the library, which uses the widest moves of this machine; for a
    // known one it writes a loop over single numbers, which takes three times as long. In pieces, because above 4 kB the library
    // switches to string instructions, which begin slowly.
    void copy(State& to, const State& from) const {
        if constexpr (sizeof(State) <= longest_piece) {
            std::memcpy(static_cast<void*>(&to), &from, state_bytes_);
        } else {
            for (std::size_t done = 0; done < state_bytes_; done += longest_copy_)
                std::memcpy(reinterpret_cast<unsigned char*>(&to) + done, reinterpret_cast<const unsigned char*>(&from) + done,
                            std::min(longest_copy_, state_bytes_ - done));
        }
    }

    static unsigned char* put(unsigned char* place, const void* value, std::size_t bytes) {
        std::memcpy(place, value, bytes);
        return place + bytes;
    }
    static const unsigned char* get(const unsigned char* place, void* value, std::size_t bytes) {
        std::memcpy(value, place, bytes);
        return place + bytes;
    }

    Model model_{};
    Settings settings_{};
    bool prefers_closed_form_ = false;
    Propagator propagator_;
    Queue queue_;
    Timing stamps_;
    // Known at compile time, but hidden from the compiler, whose own moves are slower: see copy.
    static constexpr std::size_t longest_piece = 4032;
    std::size_t state_bytes_ = 0, seldom_end_ = 0, longest_copy_ = longest_piece;
    std::uint64_t last_tag_ = 0;
    void* memory_ = nullptr; // memory of the members below, and of the queue, if the caller does not own it
    State* coasted_ = nullptr;
    State* spare_ = nullptr;
    double* spare_x_ = nullptr;
    const State* view_ = nullptr; // the shown state: the newest solved one, or coasted_
    double now_ = 0;
    double event_now_ = 0;
    double late_limit_ = 0;
};

} // namespace hnav
