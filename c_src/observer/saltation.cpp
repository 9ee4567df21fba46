// An event of the plant and its first-order effect on the estimate, the saltation matrix (O4 in docs/filter_observer.md)
//
//   Xi = R + (f+ - R f- - r_t) z_X' / (z_t + z_X' f-)          R = dr/dX of the reset r
//
// R does not exist on a guard. Xi is therefore computed by differences of "flow, event, flow back", each from the discrete state
// before the event. Every probe starts on a surface parallel to the guard and slightly beyond it, so that each has its event.
#include "observer/observer_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace hnav::observer {
namespace {

constexpr double rate_step = 1e-5; // of an interval
constexpr double grazing_1_s = 1e-3;

} // namespace

bool Model::slope(const State& s, double t_s, const double* X, double* dX) const {
    const Problem& p = *problem_;
    std::fill_n(dX, p.N, 0.0);
    if (!ask(plant_->evaluate(Function::derivatives, point_of(s, t_s, X), dX), Function::derivatives, t_s, dX, p.n)) return false;
    for (int i = 0; i < p.sizes.unknown_inputs; ++i) dX[p.n + i] = -p.decay_1_s[i] * X[p.n + i];
    return true;
}

bool Model::indicators(const State& s, double t_s, const double* X, double* z) const {
    const int count = problem_->sizes.indicators;
    if (count == 0) return true;
    return ask(plant_->indicators(point_of(s, t_s, X), z), Function::indicators, t_s, z, count);
}

// Stores in the part on which sides of the guards X is.
bool Model::take_sides(const State& s, double* part, double t_s, const double* X) const {
    if (!indicators(s, t_s, X, work_->z)) return false;
    for (int i = 0; i < problem_->sizes.indicators; ++i) part[layout().sides + i] = work_->z[i] > 0;
    return true;
}

// The first indicator on another side than in the part; -1: none.
int Model::first_changed(const double* part) const {
    const double* sides = part + layout().sides;
    for (int i = 0; i < problem_->sizes.indicators; ++i)
        if ((work_->z[i] > 0) != (sides[i] > 0)) return i;
    return -1;
}

// Derivatives of all indicators by X, and their rates along the flow.
bool Model::gradients(const State& s, double t_s, const double* X, const double* dX) const {
    const Problem& p = *problem_;
    const int count = p.sizes.indicators;
    double *moved = work_->probe, *above = work_->z_above, *below = work_->z;
    std::copy_n(X, p.N, moved);
    for (int k = 0; k < p.N; ++k) {
        const double step = p.step(k, X[k]), up = X[k] + step, down = X[k] - step;
        moved[k] = up;
        if (!indicators(s, t_s, moved, above)) return false;
        moved[k] = down;
        if (!indicators(s, t_s, moved, below)) return false;
        moved[k] = X[k];
        for (int i = 0; i < count; ++i) work_->gradients[i * p.N + k] = (above[i] - below[i]) / (up - down);
    }
    const double step_s = rate_step * s.x()[layout().usual];
    for (const double sign : {1.0, -1.0}) {
        for (int k = 0; k < p.N; ++k) moved[k] = X[k] + sign * step_s * dX[k];
        if (!indicators(s, t_s + sign * step_s, moved, sign > 0 ? above : below)) return false;
    }
    for (int i = 0; i < count; ++i) work_->rates[i] = (above[i] - below[i]) / (2 * step_s);
    return indicators(s, t_s, X, work_->z);
}

// Several indicators may have one event: the steepest determines its time. guard: the only one considered, or -1. Returns which.
int Model::choose_guard(const double* part, int guard, Passage& e) const {
    const Problem& p = *problem_;
    const double* sides = part + layout().sides;
    double steepest = -1;
    int chosen = -1;
    std::fill_n(e.gradient, p.N, 0.0);
    for (int i = 0; i < p.sizes.indicators; ++i) {
        if (guard >= 0 ? i != guard : (work_->z[i] > 0) == (sides[i] > 0)) continue;
        const double* g = work_->gradients + i * p.N;
        double variance = 0;
        for (int j = 0; j < p.N; ++j) {
            const double floor = floor_step * p.scale[j];
            variance += g[j] * g[j] * floor * floor;
            for (int k = 0; k < p.N; ++k) variance += g[j] * e.P[j * p.N + k] * g[k];
        }
        const double rate = std::fabs(work_->rates[i]), steep = variance > 0 ? rate / std::sqrt(variance) : HUGE_VAL;
        if (!(steep > steepest)) continue;
        steepest = steep;
        chosen = i;
        std::copy_n(g, p.N, e.gradient);
        e.rate = work_->rates[i];
        e.sigma_s = 1 / steep;
    }
    e.derivable = steepest > grazing_1_s;
    return chosen;
}

// Another guard that is crossed within its uncertainty after this one; -1: none. Indicators with the same event always cross
// together.
int Model::coinciding(const State& s, const double* part, int guard, const Passage& e) const {
    const Problem& p = *problem_;
    const double *sides = part + layout().sides, least_s = 1e-9 * s.x()[layout().usual];
    double* apart = work_->slope_here;
    for (int i = 0; i < p.sizes.indicators; ++i) {
        const double z = work_->z[i], rate = work_->rates[i], after_s = -z / rate;
        const bool changed = (z > 0) != (sides[i] > 0);
        if (i == guard || rate == 0 || (changed ? rate * z < 0 : !(after_s > 0))) continue;
        for (int j = 0; j < p.N; ++j) apart[j] = work_->gradients[i * p.N + j] / rate - e.gradient[j] / e.rate;
        const double variance = variance_along(apart, e.P, p.N);
        if (variance > least_s * least_s && after_s * after_s < hardly_sigma * hardly_sigma * variance) return i;
    }
    return -1;
}

// Where the flow of an indicator turns back: distance beyond its guard in sigma of the guard; infinite: it does not turn back, or it
// does not affect the derivatives. At run.present, with its slope; work_->rates and gradients are those there.
bool Model::turns_beyond(const Run& run, double t_s, int guard, double* beyond_sigma) const {
    const Problem& p = *problem_;
    const State& s = run.s;
    const Passage& e = run.present;
    const double usual_s = s.x()[layout().usual], back_s = 1e-3 * usual_s, step_s = rate_step * usual_s;
    const double z = work_->z[guard], rate = work_->rates[guard], *g = work_->gradients + guard * p.N;
    double *X = work_->probe, *moved = X + p.N, *dX = work_->slope_here, before = 0, bend = 0;
    *beyond_sigma = HUGE_VAL;
    if (is_stiff(s) || run.stiff_step_s > 0) {
        // Slopes of a stiff plant change with rounding: the last step shows the curvature of the indicator.
        const double step = run.stiff_step_s;
        if (step > 0) bend = 2 * (rate - (z - work_->z_inside[guard]) / step) / step;
    } else {
        for (int i = 0; i < p.N; ++i) X[i] = e.X[i] - back_s * e.slope[i];
        if (!slope(s, t_s - back_s, X, dX)) return false;
        for (const double sign : {1.0, -1.0}) {
            for (int i = 0; i < p.N; ++i) moved[i] = X[i] + sign * step_s * dX[i];
            if (!indicators(s, t_s - back_s + sign * step_s, moved, work_->z_above)) return false;
            before += sign * work_->z_above[guard] / (2 * step_s);
        }
        work_->z[guard] = z;
        bend = (rate - before) / back_s;
    }
    if (!(rate * bend < 0)) return true;
    const double to_guard = rate < 0 ? z : -z, sigma = std::sqrt(variance_along(g, e.P, p.N));
    *beyond_sigma = (0.5 * rate * rate / std::fabs(bend) - to_guard) / sigma;
    return true;
}

// The event has no derivative: points start from the beginning of this piece of the interval. another: -1 for none.
void Model::give_up(Run& run, int guard, int another) const {
    const int N = problem_->N;
    run.derivable = false;
    std::fill_n(work_->guards, 2 * N, 0.0);
    if (guard >= 0) note_guard(work_->segment_S, work_->gradients + guard * N, work_->guards);
    if (another >= 0) note_guard(work_->segment_S, work_->gradients + another * N, work_->guards + N);
}

// Its slope and its guard, and whether it has a derivative.
bool Model::come_to_guard(Run& run, const double* part, double t_s, int guard) const {
    const State& s = run.s;
    Passage& e = run.present;
    if (!slope(s, t_s, e.X, e.slope) || !gradients(s, t_s, e.X, e.slope)) return false;
    const int met = choose_guard(part, guard, e), other = met < 0 ? -1 : coinciding(s, part, met, e);
    double beyond_sigma = HUGE_VAL;
    if (met >= 0 && !turns_beyond(run, t_s, met, &beyond_sigma)) return false;
    e.derivable = e.derivable && other < 0 && beyond_sigma > hardly_sigma;
    e.shifts = met >= 0 && (e.derivable || (run.outside && beyond_sigma > 0));
    if (!e.derivable && !run.outside) give_up(run, met, other);
    return true;
}

// The event at the mean run.present.X with the covariance run.present.P. Afterwards the plant is in the state after the event, or before
// it if the event has no derivative.
bool Model::pass(Run& run, const double* part, double t_s, Cause cause, int guard, bool with_matrix) const {
    const Problem& p = *problem_;
    Passage& e = run.present;
    const Layout& at = layout();
    std::copy_n(part + at.memory, p.sizes.memory, e.memory);
    std::copy_n(part + at.sides, p.sizes.indicators, e.sides);
    std::copy_n(part + at.joint, at.joint_numbers, e.joint);
    e.elapsed = part[at.elapsed];
    e.next_event = part[at.next_event];
    e.derivable = true;
    e.shifts = false;
    plant_->recall(e.memory);
    // Other events do not shift in time: no flow before them.
    std::fill_n(e.slope, p.N, 0.0);
    if (run.alone && !slope(run.s, t_s, e.X, e.slope)) return false;
    if (cause == Cause::guard && with_matrix && !come_to_guard(run, part, t_s, guard)) return false;
    return !(e.derivable || run.outside) || have_event(run, t_s, cause, with_matrix);
}

bool Model::have_event(Run& run, double t_s, Cause cause, bool with_matrix) const {
    const Problem& p = *problem_;
    const State& s = run.s;
    Passage& e = run.present;
    if (cause == Cause::guard) plant_->recall(e.memory);
    std::copy_n(e.X, p.N, e.after);
    if (!ask(plant_->event(point_of(s, t_s, e.X), e.after, &e.next_after), Function::event, t_s, e.after, p.n)) return false;
    if (!ask(plant_->remember(e.memory_after), Function::event, t_s, nullptr, 0)) return false;
    const bool moved = std::memcmp(e.after, e.X, p.N * sizeof(double)) != 0;
    if (cause == Cause::input && !moved) with_matrix = false;
    if ((with_matrix || run.alone) && !slope(s, t_s, e.after, e.slope_after)) return false;
    if (with_matrix && !probe(s, t_s, e)) return false;
    e.silent = changes_nothing(run, with_matrix);
    return ask(plant_->recall(e.memory_after), Function::event, t_s, nullptr, 0);
}

// The return of an indicator has no effect.
bool Model::changes_nothing(const Run& run, bool with_matrix) const {
    const Problem& p = *problem_;
    const Passage& e = run.present;
    const double usual_s = run.s.x()[layout().usual];
    for (int i = 0; i < p.N; ++i) {
        const bool turned = std::fabs(e.slope_after[i] - e.slope[i]) * usual_s > 1e-4 * p.scale[i];
        if (run.alone && turned) return false;
        if (!(std::fabs(e.after[i] - e.X[i]) < 1e-6 * p.scale[i])) return false;
        for (int j = 0; with_matrix && j < p.N; ++j)
            if (!(std::fabs(e.Xi[i * p.N + j] - (i == j)) < 1e-4 * p.scale[i] / p.scale[j])) return false;
    }
    return true;
}

bool Model::probe(const State& s, double t_s, Passage& e) const {
    const Problem& p = *problem_;
    double largest = 0;
    for (int k = 0; k < p.N; ++k) largest = std::max(largest, std::fabs(e.gradient[k]) * p.step(k, e.X[k]));
    const double margin_s = e.shifts ? 2 * largest / std::fabs(e.rate) : 0;
    double *up = work_->probe, *down = work_->probe + p.N;
    for (int k = 0; k < p.N; ++k) {
        const double step = p.step(k, e.X[k]);
        for (const double by : {step, -step}) {
            const double shift_s = e.shifts ? margin_s - e.gradient[k] * by / e.rate : 0;
            if (!one_probe(s, t_s, e, k, by, shift_s)) return false;
            std::copy_n(work_->x, p.N, by > 0 ? up : down);
        }
        for (int i = 0; i < p.N; ++i) e.Xi[i * p.N + k] = (up[i] - down[i]) / (2 * step);
    }
    return true;
}

// One number perturbed, the flow over the delay of its event, the event, the flow back: to work_->x.
bool Model::one_probe(const State& s, double t_s, const Passage& e, int number, double by, double shift_s) const {
    const Problem& p = *problem_;
    double *X = work_->slope_here, *out = work_->x, next_s;
    for (int i = 0; i < p.N; ++i) X[i] = e.X[i] + shift_s * e.slope[i];
    X[number] += by;
    std::copy_n(X, p.N, out);
    plant_->recall(e.memory);
    if (!ask(plant_->event(point_of(s, t_s + shift_s, X), out, &next_s), Function::event, t_s, out, p.n)) return false;
    for (int i = 0; i < p.N; ++i) out[i] -= shift_s * e.slope_after[i];
    return true;
}

// Xi P Xi' plus the floor, to the part, the difference to its bounds, and its joint moments.
void Model::carry(const Passage& e, const double* P, double* part) const {
    const Problem& p = *problem_;
    double *carried = work_->Qd, *beyond = part + layout().beyond;
    std::copy_n(beyond, p.N, work_->cut);
    times_rows(e.Xi, p.N, p.N, work_->cut, beyond);
    std::fill_n(carried, p.N * p.N, 0.0);
    for (int i = 0; i < p.N; ++i) {
        const double floor = floor_step * p.scale[i];
        carried[i * p.N + i] = floor * floor;
    }
    add_congruence(p.N, e.Xi, P, work_->product, carried);
    pack_upper(carried, p.N, part + layout().P);
    move_joint(e.Xi, p.N, part);
}

} // namespace hnav::observer
