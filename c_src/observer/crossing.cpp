// An interval of the filter with events of the plant: each part flows to the next guard or time, passes its event, and continues.
#include "estimation/mixture.hpp"
#include "hybrid/stiff_solver.hpp"
#include "observer/observer_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hnav::observer {
namespace {

constexpr int most_matrices = 50; // per interval: further events are chattering
constexpr int most_events = 5000; // more events are treated as an endless sequence
// So many events of one source, each within this share of the interval after the one before: they would be more than most_events, or the
// bounces of a body that comes to rest, which soon are too short for the numbers.
constexpr int most_close = 3;
constexpr double close_share = 1e-4;
constexpr double shortest_s = 1e-12; // shortest interval for a solver

} // namespace

void Model::open_interval() const { work_->events_left = most_events; }

bool Model::cross(State& s, double interval_s, Propagator& propagator) const {
    const double chattered = s.x()[layout().counts + Layout::chattering];
    open_joint(s);
    Parts made{*this, work_->branches, 0};
    for (int i = 0; i < parts_of(s); ++i) {
        Run run(s, s.x()[layout().elapsed] + interval_s, *work_, &propagator, &made);
        double* part = made[made.used++];
        std::copy_n(part_of(s, i), layout().part_numbers, part);
        if (!cross_part(run, part)) return false;
    }
    mixture::collapse(made, max_parts);
    keep(s, made);
    if (s.x()[layout().counts + Layout::chattering] > chattered) earn_again(s);
    return true;
}

bool Model::cross_part(Run& run, double* part) const {
    int events = 0;
    if (!run.alone) std::copy_n(part, layout().part_numbers, work_->beginning);
    if (!begin_part(run, part, &events)) return false;
    Way way = Way::on;
    while (way == Way::on) way = cross_piece(run, part, &events);
    if (way != Way::ended) return way == Way::spread && spread(run, part);
    part[layout().elapsed] = run.interval_s;
    if (events > most_matrices) add_chatter(part);
    if (run.alone) return true;
    return split_near_guard(run, part) && (run.derivable || spread(run, part));
}

// To the next event and through it, or to the end.
Model::Way Model::cross_piece(Run& run, double* part, int* events) const {
    const Layout& at = layout();
    const double left_s = std::max(0.0, run.interval_s - part[at.elapsed]);
    const double to_event_s = std::max(0.0, part[at.next_event] - (run.s.x()[at.t] + part[at.elapsed]));
    const Stop stop = flow_piece(run, part, std::min(left_s, to_event_s));
    if (stop == Stop::failed) return Way::failed;
    if (stop == Stop::missed) return Way::spread;
    if (stop == Stop::end && to_event_s > left_s) return Way::ended;
    const Cause cause = stop == Stop::guard ? Cause::guard : Cause::time;
    const int source = cause == Cause::guard ? std::max(0, first_changed(part)) : -1, passed = run.passed;
    if (!jump_part(run, part, cause, ++*events)) return Way::failed;
    if (!run.derivable) return Way::spread;
    if (!may_go_on(run, part, source, cause == Cause::time || run.passed > passed)) return Way::failed;
    if (*events == most_matrices) expected(part, work_->chattered_from);
    return Way::on;
}

// counts: the event is none of an indicator that only returns.
bool Model::may_go_on(Run& run, const double* part, int source, bool counts) const {
    Succession& was = run.succession;
    const double elapsed_s = part[layout().elapsed];
    if (counts) {
        const bool close = source == was.source && elapsed_s - was.last_s < close_share * run.interval_s;
        was = {source, close ? was.length + 1 : 0, elapsed_s};
    }
    if (--work_->events_left >= 0 && was.length < most_close) return true;
    *trouble_ = {true, Function::event, Answer::ok, run.s.x()[layout().t] + elapsed_s, ""};
    if (run.alone) work_->events_left = 0; // nor do other points end
    return false;
}

// P has not passed the events since: the way of the mean may be wrong by as much.
void Model::add_chatter(double* part) const {
    const int N = problem_->N;
    double *X = work_->x, *variance = part + layout().P;
    expected(part, X);
    for (int i = 0; i < N; variance += N - i++) *variance += std::pow(X[i] - work_->chattered_from[i], 2);
}

// The plant has the state of the part; new inputs may have moved it through a guard.
bool Model::begin_part(Run& run, double* part, int* events) const {
    const Layout& at = layout();
    plant_->recall(part + at.memory);
    expected(part, work_->x);
    if (!indicators(run.s, run.s.x()[at.t] + part[at.elapsed], work_->x, work_->z)) return false;
    return first_changed(part) < 0 || jump_part(run, part, Cause::input, ++*events);
}

// To the next event, or to the end after length_s. P then includes the flow.
Model::Stop Model::flow_piece(Run& run, double* part, double length_s) const {
    const Layout& at = layout();
    if (!run.alone) std::copy_n(part, at.part_numbers, work_->segment);
    const Stop stop = length_s > 0 ? flow_until(run, part, length_s) : Stop::end;
    if (stop == Stop::failed || stop == Stop::missed) return stop;
    if (!run.alone) std::copy_n(part + at.S, problem_->moving * problem_->N, work_->segment_S);
    collect(run.s, part);
    return stop;
}

// The plant's event at the state of the part. An event without a derivative is not passed: run.derivable.
bool Model::jump_part(Run& run, double* part, Cause cause, int count) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double* c = run.s.x();
    Passage& e = run.present;
    const double t_s = c[at.t] + part[at.elapsed];
    const bool with_matrix = count <= most_matrices && !run.alone;
    expected(part, e.X);
    unpack_upper(part + at.P, p.N, 1, e.P);
    if (!pass(run, part, t_s, cause, -1, with_matrix)) return false;
    if (!run.derivable) return true;
    if (!e.derivable) c[at.counts + Layout::grazing] += 1;
    if (count > most_matrices) c[at.counts + Layout::chattering] += 1;
    put(e.after, part);
    std::copy_n(e.memory_after, p.sizes.memory, part + at.memory);
    part[at.next_event] = e.next_after;
    if (!e.silent) {
        if (with_matrix) carry(e, e.P, part);
        part[at.jumps] += 1;
        ++run.passed;
    }
    if (!take_sides(run.s, part, t_s, e.after)) return false;
    if (!e.silent) {
        e.is_newest = cause == Cause::guard && with_matrix;
        if (e.is_newest) note_open(run);
        std::swap(run.newest, run.present);
    }
    return true;
}

// ------------------------------------------------------------------------------------------------ from outside

bool Model::have_events_of_plant(State& s, double t_s, bool* any) const {
    const Layout& at = layout();
    double* part = s.x();
    if (!flows(s)) return true;
    bool whole = ask(plant_->recall(part + at.memory), Function::event, t_s, nullptr, 0);
    expected(part, work_->x);
    whole = whole && indicators(s, s.x()[at.t] + part[at.elapsed] + part[at.clock], work_->x, work_->z);
    const bool crossed = whole && first_changed(part) >= 0;
    const bool wanted = std::exchange(s.x()[at.wants_event], 0) != 0;
    *any = crossed || wanted || part[at.next_event] <= t_s;
    if (whole && *any) collect(s, part);
    const auto come = [&](Cause cause) {
        Run run(s, 0, *work_);
        run.outside = true;
        part[at.elapsed] = t_s - s.x()[at.t]; // the integrator's value, to the last digit
        return jump_part(run, part, cause, 1);
    };
    if (crossed || (whole && wanted)) whole = come(crossed ? Cause::guard : Cause::time);
    for (int k = 0; whole && part[at.next_event] <= t_s; ++k) whole = k < most_matrices && come(Cause::time);
    return whole;
}

bool Model::step_outside_done(State& s, const double* x) const {
    if (!crosses() || !flows(s)) return true;
    const Point here = point(s, s.x(), x);
    bool wants = false;
    if (!ask(plant_->recall(s.x() + layout().memory), Function::event, here.t_s, nullptr, 0) ||
        !ask(plant_->step_done(here, &wants), Function::event, here.t_s, nullptr, 0))
        return false;
    s.x()[layout().wants_event] = wants;
    return true;
}

// A plant may announce a time without an event: a plant without events is not queried.
double Model::next_event_of_plant_s(const State& s) const {
    return crosses() && flows(s) ? s.x()[layout().next_event] : HUGE_VAL;
}

// Values of the indicators in the first part; 1 before the estimate has begun, since nothing flows.
bool Model::indicators_at(const State& s, const double* x, double* z) const {
    const int count = problem_->sizes.indicators;
    std::fill_n(z, count, 1.0);
    if (count == 0 || !flows(s)) return true;
    const Point here = point(s, s.x(), x);
    return ask(plant_->recall(s.x() + layout().memory), Function::indicators, here.t_s, nullptr, 0) &&
           ask(plant_->indicators(here, z), Function::indicators, here.t_s, z, count);
}

// ------------------------------------------------------------------------------------------------ to a guard

Model::Stop Model::flow_until(Run& run, double* part, double length_s) const {
    run.stiff_step_s = 0;
    for (double* z : {work_->z_first, work_->z_inside}) std::copy_n(work_->z, problem_->sizes.indicators, z);
    if (length_s < shortest_s) return move(run, part, part, length_s) ? Stop::end : Stop::failed;
    return is_stiff(run.s) ? go_stiffly(run, part, length_s) : go_step_by_step(run, part, length_s);
}

// By one Euler step, sufficient for a short time.
bool Model::move(const Run& run, const double* part, double* x, double by_s) const {
    if (flow(run.s, x, work_->slope, {part, run.alone}) != 0) return false;
    for (int i = 0; i < nx(); ++i) x[i] += by_s * work_->slope[i];
    return true;
}

Model::Stop Model::go_step_by_step(Run& run, double* part, double length_s) const {
    const int numbers = nx();
    double *x = work_->step_to, to_s = 0;
    std::copy_n(part, numbers, x);
    const FlowContext<Model> context{this, &run.s, {part, run.alone}};
    if (!run.propagator->begin(&context, length_s, x)) return Stop::failed;
    while (to_s < length_s) {
        const double from_s = to_s;
        std::copy_n(x, numbers, work_->step_from);
        if (!run.propagator->step(&to_s, x)) return go_after_failure(run, part, length_s);
        double low_s = from_s, high_s = to_s;
        const Stop stop = look_between(run, part, from_s, to_s, &low_s, &high_s);
        if (stop == Stop::failed || stop == Stop::missed) return stop;
        if (stop == Stop::guard) {
            if (!narrow(run, part, &low_s, &high_s) || !polish(run, part, from_s, low_s, high_s)) return Stop::failed;
            std::copy_n(work_->inside, numbers, part);
            return Stop::guard;
        }
        const Stop done = end_of_step(run, part);
        if (done != Stop::end) {
            std::copy_n(x, numbers, part);
            return done;
        }
    }
    std::copy_n(x, numbers, part);
    return Stop::end;
}

// If the explicit solver needs too many steps, the plant is stiff.
Model::Stop Model::go_after_failure(Run& run, double* part, double length_s) const {
    if (!run.propagator->out_of_steps()) return Stop::failed;
    std::copy_n(work_->z_first, problem_->sizes.indicators, work_->z_inside);
    return go_stiffly(run, part, length_s);
}

// Within the newest step; for a stiff step S and Qd are those of its beginning.
bool Model::between(const Run& run, const double* part, double s, double* x) const {
    if (!run.stiffly) return run.propagator->between(s, x);
    std::copy_n(part, nx(), x);
    x[layout().clock] = s;
    return stiff_->between(s, x);
}

// The indicators at its end are those at the beginning of the next one.
Model::Stop Model::end_of_step(const Run& run, const double* part) const {
    const int count = problem_->sizes.indicators;
    std::copy_n(work_->z_inside + 4 * count, count, work_->z_inside);
    bool wants_event = false;
    const Point here = point(run.s, part, work_->step_to);
    if (!ask(plant_->step_done(here, &wants_event), Function::event, here.t_s, nullptr, 0)) return Stop::failed;
    return wants_event ? Stop::step : Stop::end;
}

// Solvers check the ends of their steps, and two crossings within one step cancel. Quarters of the step are checked too, and
// points between them at which an indicator turns back.
Model::Stop Model::look_between(const Run& run, const double* part, double from_s, double to_s, double* low_s,
                                double* high_s) const {
    const int count = problem_->sizes.indicators;
    if (count == 0) return Stop::end;
    *low_s = from_s;
    for (int quarter = 1; quarter <= 4; ++quarter) {
        *high_s = quarter < 4 ? from_s + 0.25 * quarter * (to_s - from_s) : to_s;
        const double* x = work_->step_to;
        if (quarter < 4) {
            if (!between(run, part, *high_s, work_->inside)) return Stop::failed;
            x = work_->inside;
        }
        if (!look(run, part, x)) return Stop::failed;
        std::copy_n(work_->z, count, work_->z_inside + quarter * count);
        if (first_changed(part) >= 0) return Stop::guard;
        *low_s = *high_s;
        const Stop turned = quarter < 2 ? Stop::end : look_at_turn(run, part, from_s, to_s, quarter, low_s, high_s);
        if (turned != Stop::end) return turned;
    }
    return Stop::end;
}

// The parabola through an indicator at a quarter and the two before it reaches the guard, or comes near it.
Model::Stop Model::look_at_turn(const Run& run, const double* part, double from_s, double to_s, int quarter, double* low_s,
                                double* high_s) const {
    const int count = problem_->sizes.indicators;
    const double quarter_s = 0.25 * (to_s - from_s);
    for (int i = 0; i < count; ++i) {
        const double* z = work_->z_inside + (quarter - 2) * count + i;
        const double middle = z[count], rise = 0.5 * (z[2 * count] - z[0]), bend = z[0] - 2 * middle + z[2 * count];
        if (!(middle * bend > 0 && std::fabs(rise) <= std::fabs(bend))) continue;
        const double turn = quarter - 1 - rise / bend, at_s = std::min(to_s, from_s + turn * quarter_s);
        if (run.alone && (middle - 0.5 * rise * rise / bend) * middle > 0) continue;
        if (!between(run, part, at_s, work_->inside) || !look(run, part, work_->inside)) return Stop::failed;
        if (first_changed(part) >= 0) {
            *low_s = from_s + std::floor(turn) * quarter_s;
            *high_s = at_s;
            return *low_s < at_s ? Stop::guard : Stop::end;
        }
        bool narrow = false;
        const double drift = (std::fabs(rise) + std::fabs(bend)) / quarter_s;
        if (!run.alone && !turns_near(run, part, i, drift, &narrow)) return Stop::failed;
        if (narrow) return Stop::missed;
    }
    return Stop::end;
}

// Whether P extends to both sides of the guard at work_->inside, where the indicator turns back. drift: its rate just before.
bool Model::turns_near(const Run& run, const double* part, int guard, double drift, bool* near) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const double *x = work_->inside, *g = work_->gradients + guard * p.N;
    const double t_s = run.s.x()[at.t] + part[at.elapsed] + x[at.clock];
    double *X = run.present.X, *dX = run.present.slope;
    std::copy_n(x, p.moving, X);
    std::copy_n(part + at.parameters, p.sizes.parameters, X + p.moving);
    if (!slope(run.s, t_s, X, dX) || !gradients(run.s, t_s, X, dX)) return false;
    covariance(run.s, x, part + at.P, work_->P);
    const double variance = variance_along(g, work_->P, p.N);
    work_->rates[guard] = work_->z[guard] > 0 ? -drift : drift;
    *near = work_->z[guard] * work_->z[guard] < hardly_sigma * hardly_sigma * variance && !is_led_by_noise(guard, variance);
    if (!*near) return true;
    note_guard(x + at.S, g, work_->guards);
    std::fill_n(work_->guards + p.N, p.N, 0.0);
    return true;
}

// The bracket of the first crossing on the cubic of the step, to a millionth of the interval: Illinois method, bisection where an
// indicator jumps.
bool Model::narrow(const Run& run, const double* part, double* low_s, double* high_s) const {
    const int count = problem_->sizes.indicators;
    const double enough_s = 1e-6 * (*high_s - *low_s);
    double *low = work_->z_low, *z = work_->z;
    const auto look_at = [&](double at_s) { return between(run, part, at_s, work_->inside) && look(run, part, work_->inside); };
    int guard = first_changed(part);
    double z_high = z[guard];
    if (!look_at(*low_s)) return false;
    std::copy_n(z, count, low);
    double z_low = low[guard];
    for (int k = 0; k < 60 && *high_s - *low_s > enough_s; ++k) {
        const double width_s = *high_s - *low_s, share = z_low / (z_low - z_high);
        const bool halve = k % 4 == 3 || !(share > 0 && share < 1);
        const double middle_s = *low_s + (halve ? 0.5 : share) * width_s;
        if (!(middle_s > *low_s && middle_s < *high_s)) break;
        if (!look_at(middle_s)) return false;
        const int changed = first_changed(part);
        if (changed >= 0) {
            *high_s = middle_s;
            if (changed != guard) z_low = low[changed];
            else if (!halve) z_low *= 0.5;
            guard = changed;
            z_high = z[guard];
        } else {
            *low_s = middle_s;
            std::copy_n(z, count, low);
            z_low = z[guard];
            if (!halve) z_high *= 0.5;
        }
    }
    return true;
}

// The values of all indicators at x, to work_->z.
bool Model::look(const Run& run, const double* part, const double* x) const {
    const Point here = point(run.s, part, x);
    return ask(plant_->indicators(here, work_->z), Function::indicators, here.t_s, work_->z, problem_->sizes.indicators);
}

// The cubic is an approximation: the flow itself is integrated to the bracket, moved to the zero of the indicator, and then beyond
// it by the smallest step at which the plant has its event. Result in work_->inside.
bool Model::polish(const Run& run, const double* part, double from_s, double low_s, double high_s) const {
    double* x = work_->inside;
    const FlowContext<Model> context{this, &run.s, {part, run.alone}};
    if (!run.propagator->between(high_s, x) || !look(run, part, x)) return false;
    const int guard = std::max(0, first_changed(part));
    std::copy_n(work_->step_from, nx(), x);
    const double way_s = high_s - from_s;
    if (way_s < shortest_s ? !move(run, part, x, way_s) : !run.propagator->integrate(&context, way_s, x)) return false;
    if (!look(run, part, x) || !move_to_zero(run, part, guard, way_s, std::max(1e-3 * way_s, 10 * (high_s - low_s))))
        return false;
    for (double beyond_s = 1e-14 * way_s; first_changed(part) < 0; beyond_s *= 4)
        if (!(beyond_s < way_s) || !move(run, part, x, beyond_s) || !look(run, part, x)) return false;
    return true;
}

// Newton's method, unless the zero is farther than possible: an indicator that jumps has none.
bool Model::move_to_zero(const Run& run, const double* part, int guard, double way_s, double near_s) const {
    double *x = work_->inside, *z = work_->z;
    const double small_s = 1e-7 * way_s;
    for (int k = 0; k < 3 && z[guard] != 0; ++k) {
        const double here = z[guard];
        std::copy_n(x, nx(), work_->step_to);
        if (!move(run, part, x, -small_s) || !look(run, part, x)) return false;
        const double rate = (here - z[guard]) / small_s;
        std::copy_n(work_->step_to, nx(), x);
        if (!(std::fabs(here) < near_s * std::fabs(rate))) return look(run, part, x);
        if (!move(run, part, x, -here / rate) || !look(run, part, x)) return false;
        if (std::fabs(here / rate) < 1e-7 * way_s) break; // quadratic convergence: the next correction would be its square
    }
    return true;
}

} // namespace hnav::observer
