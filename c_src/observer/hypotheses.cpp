// Parts (hypotheses) of an estimate. If an event has occurred for the mean and not for all of the Gaussian, or the reverse, one
// Gaussian is wrong for any covariance. It is cut at the guard: with k = P g / sd, a the distance of the mean to the guard in sd,
// and the normal density phi and distribution Phi,
//
//     not yet   weight Phi(a)     mean m + k l          P - k k' l (l + a)               l  = phi(a) / Phi(a)
//     jumped    weight Phi(-a)    J(m) - Xi k l'        Xi (P - k k' l' (l' - a)) Xi'    l' = phi(a) / Phi(-a)
//
// The next samples weight the parts; parts with equal numbers of events merge. docs/filter_observer.md derives it.
//
// A guard that noise leads over rather than drift, |z'| sd < g'Q g with the drift towards it, is an absorbing wall: what has not crossed has
// the density of absorption.hpp, and crossed is a share that does not depend on the length of intervals.
#include "estimation/mixture.hpp"
#include "estimation/truncation.hpp"
#include "observer/observer_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace hnav::observer {
namespace {

// Chosen: share led over a guard by noise before it becomes a part, of which a state holds few.
constexpr double smallest_split = 1e-3;

// What is left of a part on one side of a guard: its weight; the mean moves by shift k, the covariance loses loss k k'.
struct Cut {
    double weight, shift, loss;
};
struct Cuts {
    Cut not_yet, has_been;
};

Cuts cuts_at(double a) {
    const double not_yet = normal_below(a), has_been = normal_below(-a), density = normal_density(a);
    const double l = density / not_yet, l_jumped = density / has_been;
    return {{not_yet, l, l * (l + a)}, {has_been, -l_jumped, l_jumped * (l_jumped - a)}};
}

// a, and the variance of what has crossed in the units of a. Mean and mean square of both together are those of the part.
Cuts cuts_by_noise(double a, double share, double variance) {
    // Chosen: a share of several intervals may be larger than its variance, that of the newest, allows.
    constexpr double least = 0.1;
    const double left = 1 - share, mean = a / left;
    const double variance_left = std::max(least, (1 + a * a - share * variance) / left - mean * mean);
    return {{left, mean - a, 1 - variance_left}, {share, -a, 1 - variance}};
}

} // namespace

// ------------------------------------------------------------------------------------------------ splits

// At the end of an interval, with the plant in the state of the part.
bool Model::split_near_guard(Run& run, double* part) const {
    if (problem_->sizes.indicators == 0) return true;
    if (run.passed > 1 && run.interval_s < run.open_until_s) {
        give_up(run, -1, -1); // more than two cases: points
        return true;
    }
    const Passage& e = run.newest;
    const bool uncertain = e.is_newest && run.passed == 1 && run.interval_s - e.elapsed < near_sigma * e.sigma_s;
    if (run.went_stiffly || (uncertain && slope_leads_away(run.interval_s - e.elapsed)))
        return spread_stiffly(run, part, uncertain);
    return uncertain ? split_at_newest(run, part) : split_at_next(run, part);
}

// Whether a mode decays or oscillates within a time, so that linear extrapolation of the flow fails.
bool Model::slope_leads_away(double after_s) const {
    constexpr double modes = 1;
    return fastest_rate_of_A() * after_s > modes;
}

// run.present: X and P at the end of the interval, the slope and the guards there.
bool Model::look_from_end(Run& run, const double* part) const {
    Passage& e = run.present;
    const double now_s = run.s.x()[layout().t] + run.interval_s;
    expected(part, e.X);
    unpack_upper(part + layout().P, problem_->N, 1, e.P);
    return slope(run.s, now_s, e.X, e.slope) && gradients(run.s, now_s, e.X, e.slope);
}

// Linear extrapolation fails for a stiff plant: sigma points from the beginning of the interval replace the split.
bool Model::spread_stiffly(Run& run, const double* part, bool uncertain) const {
    if (!uncertain) {
        if (!look_from_end(run, part)) return false;
        if (next_guard(part, run.present.P, true) < 0) return true;
    }
    std::copy_n(work_->beginning, work_->layout.part_numbers, work_->segment);
    give_up(run, -1, -1);
    return true;
}

// The event may not have occurred: the part before it, propagated to now without a guard.
bool Model::split_at_newest(Run& run, double* part) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    Passage& e = run.newest;
    const double since_s = run.interval_s - e.elapsed;
    for (int i = 0; i < p.N; ++i) {
        e.X[i] += since_s * e.slope[i];
        e.P[i * p.N + i] += since_s * p.noise[i];
    }
    double *waiting = (*run.made)[run.made->used], *J = work_->slope_here;
    std::copy_n(part, at.part_numbers, waiting);
    std::copy_n(e.memory, p.sizes.memory, waiting + at.memory);
    std::copy_n(e.sides, p.sizes.indicators, waiting + at.sides);
    waiting[at.next_event] = e.next_event;
    waiting[at.jumps] -= 1;
    expected(part, J);
    if (e.rate > 0)
        for (int i = 0; i < p.N; ++i) e.gradient[i] = -e.gradient[i];
    return split(run, waiting, part, e, -std::fabs(e.rate) * since_s, J);
}

// A new part, as this one but with the discrete state after the event of run.present; it counts once a split has given it a weight.
double* Model::part_after_jump(const Run& run, const double* part) const {
    const Layout& at = layout();
    const Passage& e = run.present;
    double* jumped = (*run.made)[run.made->used];
    std::copy_n(part, at.part_numbers, jumped);
    std::copy_n(e.memory_after, problem_->sizes.memory, jumped + at.memory);
    jumped[at.next_event] = e.next_after;
    jumped[at.jumps] += 1;
    return jumped;
}

// The event may have occurred: the guard is reached along the flow, the reset applied there, and the flow reversed.
bool Model::split_at_next(Run& run, double* part) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    Passage& e = run.present;
    const double now_s = run.s.x()[at.t] + run.interval_s;
    if (!look_from_end(run, part)) return false;
    const int guard = next_guard(part, e.P, false);
    if (guard < 0) return split_by_noise(run, part);
    const double distance = std::fabs(work_->z[guard]);
    if (slope_leads_away(distance / std::fabs(work_->rates[guard]))) return spread_stiffly(run, part, true);
    const bool falls = work_->z[guard] > 0;
    double to_s = 0, beyond_sigma = 0;
    if (!turns_beyond(run, now_s, guard, &beyond_sigma)) return false;
    if (beyond_sigma < hardly_sigma) {
        if (beyond_sigma > -hardly_sigma) give_up(run, guard, -1); // else negligible weight
        return true;
    }
    if (!reach(run, part, guard, &to_s)) return false;
    if (first_changed(part) != guard) return true; // another guard is before it, or there is none
    if (!pass(run, part, now_s + to_s, Cause::guard, guard, true)) return false;
    if (!e.derivable) return true;
    if (e.silent) return ask(plant_->recall(part + at.memory), Function::event, now_s, nullptr, 0);

    for (int i = 0; !falls && i < p.N; ++i) e.gradient[i] = -e.gradient[i];
    double *jumped = part_after_jump(run, part), *J = work_->slope_here;
    for (int i = 0; i < p.N; ++i) J[i] = e.after[i] - to_s * e.slope_after[i];
    expected(part, e.X);
    return split(run, part, jumped, e, distance, J);
}

// run.present.X moves along its slope to a guard and minimally beyond, after_s from now.
bool Model::reach(Run& run, const double* part, int guard, double* after_s) const {
    Passage& e = run.present;
    const double now_s = run.s.x()[layout().t] + run.interval_s, rate = work_->rates[guard];
    const auto go_on = [&](double by_s) {
        *after_s += by_s;
        for (int i = 0; i < problem_->N; ++i) e.X[i] += by_s * e.slope[i];
        return indicators(run.s, now_s + *after_s, e.X, work_->z);
    };
    for (int k = 0; k < 4; ++k)
        if (!go_on(-work_->z[guard] / rate)) return false;
    for (double beyond_s = 1e-12 * run.interval_s; first_changed(part) != guard && beyond_s < run.interval_s; beyond_s *= 4)
        if (!go_on(beyond_s)) return false;
    return true;
}

// The first indicator among those that approach and are within four sigma; -1: none. with_noise: also those that noise leads over.
int Model::next_guard(const double* part, const double* P, bool with_noise) const {
    const Problem& p = *problem_;
    int first = -1;
    double soonest_s = HUGE_VAL;
    for (int i = 0; i < p.sizes.indicators; ++i) {
        const double *g = work_->gradients + i * p.N, z = work_->z[i], rate = work_->rates[i];
        if (!(rate * z < 0) || (z > 0) != (part[layout().sides + i] > 0)) continue;
        const double variance = variance_along(g, P, p.N);
        if (!(z * z < near_sigma * near_sigma * variance) || !(-z / rate < soonest_s)) continue;
        if (!with_noise && is_led_by_noise(i, variance)) continue;
        soonest_s = -z / rate;
        first = i;
    }
    return first;
}

// ------------------------------------------------------------------------------------------------ crossings by noise

// Power spectral density of the noise of an indicator, by its gradient.
double Model::noise_along(int guard) const {
    const double* g = work_->gradients + guard * problem_->N;
    double noise = 0;
    for (int i = 0; i < problem_->N; ++i) noise += g[i] * g[i] * problem_->noise[i];
    return noise;
}

// With the gradient and the rate of its indicator: noise that acts on it leads over the guard before drift does.
bool Model::is_led_by_noise(int guard, double variance) const {
    const double z = work_->z[guard], rate = work_->rates[guard], noise = noise_along(guard);
    return noise > 0 && (rate * z > 0 || std::fabs(rate) * std::sqrt(variance) < noise);
}

// The guard over which noise has most likely led in the newest interval, of this length; -1: none.
int Model::guard_of_noise(const double* part, const double* P, double since_s, Absorption* crossed) const {
    const Problem& p = *problem_;
    constexpr double reach_sigma = 6; // beyond lies a share of 2e-9
    int most = -1;
    *crossed = {0, 0};
    for (int i = 0; i < p.sizes.indicators; ++i) {
        const double *g = work_->gradients + i * p.N, z = work_->z[i], variance = variance_along(g, P, p.N);
        if ((z > 0) != (part[layout().sides + i] > 0) || !(z * z < reach_sigma * reach_sigma * variance)) continue;
        if (!is_led_by_noise(i, variance)) continue;
        const double added = std::min(since_s * noise_along(i), (1 - 1e-6) * variance);
        const Absorption by = absorb(std::fabs(z), variance - added, added);
        if (!(by.ended > crossed->ended)) continue;
        most = i;
        *crossed = by;
    }
    return most;
}

// At run.present, with its slope and its guards. Shares of many intervals become one part.
bool Model::split_by_noise(Run& run, double* part) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    Passage& e = run.present;
    const double from_s = std::max(work_->beginning[at.elapsed], run.passed > 0 ? run.newest.elapsed : 0);
    const double since_s = run.interval_s - from_s;
    Absorption crossed;
    const int guard = guard_of_noise(part, e.P, since_s, &crossed);
    if (guard < 0) return true;
    double& pending = part[at.pending];
    pending += (1 - pending) * crossed.ended;
    if (pending < smallest_split) return true;
    crossed.ended = std::min(pending, 1 - smallest_split);
    pending = 0;
    const double distance = std::fabs(work_->z[guard]);
    if (!have_event_on_guard(run, part, guard)) return false;
    if (e.silent) return true;
    double *jumped = part_after_jump(run, part), *J = work_->slope_here;
    const int parts = run.made->used;
    // On the guard at a time evenly within the interval. X of the mean would be beyond it by the distance.
    expected(part, e.X);
    const double sd = std::sqrt(variance_along(e.gradient, e.P, p.N));
    times_rows(e.P, p.N, p.N, e.gradient, work_->x);
    for (int i = 0; i < p.N; ++i) {
        J[i] = e.after[i] + 0.5 * since_s * (e.slope_after[i] - e.slope[i]);
        for (int j = 0; j < p.N; ++j) J[i] += e.Xi[i * p.N + j] * work_->x[j] * distance / (sd * sd);
    }
    if (!split(run, part, jumped, e, distance, J, &crossed)) return false;
    if (run.made->used > parts) add_delay(e, since_s, jumped);
    return true;
}

// The mean moves along P minimally beyond the guard, where the event does not depend on the time of its coming.
bool Model::have_event_on_guard(Run& run, double* part, int guard) const {
    const Problem& p = *problem_;
    Passage& e = run.present;
    const double now_s = run.s.x()[layout().t] + run.interval_s, sign = work_->z[guard] > 0 ? 1 : -1;
    double beyond = 0;
    for (int i = 0; i < p.N; ++i) {
        e.gradient[i] = sign * work_->gradients[guard * p.N + i];
        beyond = std::max(beyond, std::fabs(e.gradient[i]) * p.step(i, e.X[i]));
    }
    times_rows(e.P, p.N, p.N, e.gradient, work_->x);
    const double by = (std::fabs(work_->z[guard]) + 2 * beyond) / variance_along(e.gradient, e.P, p.N);
    for (int i = 0; i < p.N; ++i) e.X[i] -= by * work_->x[i];
    if (!pass(run, part, now_s, Cause::time, -1, true)) return false;
    plant_->recall(e.memory);
    if (!slope(run.s, now_s, e.X, e.slope)) return false;
    for (int i = 0; i < p.N; ++i)
        if (std::fabs(e.slope_after[i] - e.slope[i]) * run.s.x()[layout().usual] > 1e-4 * p.scale[i]) e.silent = false;
    return true;
}

// The event was within the interval: its effect on the slopes has lasted for any time up to the whole of it.
void Model::add_delay(const Passage& e, double since_s, double* part) const {
    const int N = problem_->N;
    double* P = part + layout().P;
    for (int i = 0; i < N; ++i)
        for (int j = i; j < N; ++j)
            *P++ += since_s * since_s / 12 * (e.slope_after[i] - e.slope[i]) * (e.slope_after[j] - e.slope[j]);
}

// waiting and jumped become one part beside a new one, with the weight of both; e: X and P before the reset, the gradient rising on
// the near side. J: X after the event, propagated to now.
bool Model::split(const Run& run, double* waiting, double* jumped, const Passage& e, double distance, const double* J,
                  const Absorption* by_noise) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double *k = work_->gain, *cut = work_->P, sd = 0;
    times_rows(e.P, p.N, p.N, e.gradient, k);
    for (int i = 0; i < p.N; ++i) sd += k[i] * e.gradient[i];
    sd = std::sqrt(sd);
    const double a = distance / sd;
    const auto [not_yet, has_been] = by_noise ? cuts_by_noise(a, by_noise->ended, by_noise->variance / (sd * sd)) : cuts_at(a);
    if (!(not_yet.weight > smallest_weight && has_been.weight > smallest_weight)) return true;
    for (int i = 0; i < p.N; ++i) k[i] /= sd;
    const auto cut_by = [&](double share) {
        for (int i = 0; i < p.N; ++i)
            for (int j = 0; j < p.N; ++j) cut[i * p.N + j] = e.P[i * p.N + j] - share * k[i] * k[j];
    };
    ++run.made->used;
    run.s.x()[at.counts + Layout::splits] += 1;
    double* X = work_->x;

    cut_by(has_been.loss);
    cut_joint(e, k, sd, has_been.shift, has_been.loss, jumped);
    carry(e, cut, jumped);
    for (int i = 0; i < p.N; ++i) {
        X[i] = J[i];
        for (int j = 0; j < p.N; ++j) X[i] += has_been.shift * e.Xi[i * p.N + j] * k[j];
    }
    put(X, jumped);
    jumped[at.weight] *= has_been.weight;
    const double now_s = run.s.x()[at.t] + run.interval_s;
    plant_->recall(jumped + at.memory);
    if (!take_sides(run.s, jumped, now_s, X)) return false;

    cut_by(not_yet.loss);
    cut_joint(e, k, sd, not_yet.shift, not_yet.loss, waiting);
    pack_upper(cut, p.N, waiting + at.P);
    for (int i = 0; i < p.N; ++i) X[i] = e.X[i] + not_yet.shift * k[i];
    waiting[at.weight] *= not_yet.weight;
    plant_->recall(waiting + at.memory);
    if (put_inside(run.s, waiting, now_s, X, cut) == Inside::failed) return false;
    put(X, waiting);
    return true;
}

// A correction may move X through a guard. That is no event: X is moved back along P. The plant has the state of the part.
Model::Inside Model::put_inside(const State& s, double* part, double t_s, double* X, const double* P) const {
    const Problem& p = *problem_;
    constexpr int tries = 5;
    if (p.sizes.indicators == 0) return Inside::was;
    for (int k = 0; k <= tries; ++k) {
        if (!indicators(s, t_s, X, work_->z)) return Inside::failed;
        const int guard = first_changed(part);
        if (guard < 0) return k > 0 ? Inside::is_now : Inside::was;
        if (k == tries) break;
        std::fill_n(work_->slope_here, p.N, 0.0);
        if (!gradients(s, t_s, X, work_->slope_here)) return Inside::failed;
        const double* g = work_->gradients + guard * p.N;
        const double variance = variance_along(g, P, p.N);
        if (!(variance > 0)) break;
        const double aim = (part[layout().sides + guard] > 0 ? 1e-9 : -1e-9) * std::sqrt(variance);
        const double by = (work_->z[guard] - aim) / variance;
        for (int i = 0; i < p.N; ++i)
            for (int j = 0; j < p.N; ++j) X[i] -= by * P[i * p.N + j] * g[j];
    }
    return Inside::is_not;
}

// ------------------------------------------------------------------------------------------------ merges

// Mean and covariance of all parts, each at its own time.
void Model::fused(const State& s, double* X, double* P) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const int count = parts_of(s);
    if (count == 1) {
        expected(s.x(), X);
        if (s.x()[at.clock] == 0) unpack_upper(s.x() + at.P, p.N, 1, P);
        else covariance(s, s.x(), s.x() + at.P, P);
        if (p.bounded) truncate(p.N, p.low, p.high, expected_uncut(s.x(), s.x(), X), P);
        return;
    }
    const auto part = [&](int i) {
        expected(part_of(s, i), work_->slope_here);
        return mixture::Part{part_of(s, i)[at.weight], work_->slope_here, part_of(s, i) + at.P};
    };
    mixture::moments(count, p.N, part, X, P);
}

// Merges the other into the part by moments; the discrete state is that of the heavier.
void Model::merge(double* part, const double* other) const {
    const int triangle = Layout::triangle(problem_->N);
    const Layout& at = layout();
    double *X = work_->x, *with = work_->slope_here, *P = work_->P;
    const double sum = part[at.weight] + other[at.weight], share = other[at.weight] / sum;
    expected(part, X);
    expected(other, with);
    std::copy_n(part + at.P, triangle, P);
    merge_joint(part, other, share, X, with);
    mixture::merge(problem_->N, share, X, P, with, other + at.P);
    const double pending = part[at.pending] + share * (other[at.pending] - part[at.pending]);
    double* beyond = work_->cut;
    for (int i = 0; i < problem_->N; ++i) beyond[i] = part[at.beyond + i] + share * (other[at.beyond + i] - part[at.beyond + i]);
    if (share > 0.5) std::copy_n(other, at.part_numbers, part);
    std::copy_n(beyond, problem_->N, part + at.beyond);
    part[at.weight] = sum;
    part[at.pending] = pending;
    put(X, part);
    std::copy_n(P, triangle, part + at.P);
    std::copy_n(work_->joint_merged, at.joint_numbers, part + at.joint);
}

// Distance of two parts, the largest difference in sigma.
double Model::apart(const double* part, const double* other) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    expected(part, work_->x);
    expected(other, work_->slope_here);
    const double *P = part + at.P, *Q = other + at.P;
    double most = 0;
    for (int i = 0; i < p.N; P += p.N - i, Q += p.N - i, ++i) {
        const double sigma = std::sqrt(std::max({*P, *Q, 1e-12 * p.scale[i] * p.scale[i]}));
        most = std::max(most, std::fabs(work_->x[i] - work_->slope_here[i]) / sigma);
    }
    return most;
}

// Whether two parts may merge: equal numbers of events, or a plant whose discrete state does not differ.
bool Model::alike(const double* part, const double* other) const {
    const Layout& at = layout();
    if (part[at.jumps] == other[at.jumps]) return true;
    return equal_discrete(part, other) && std::equal(part + at.sides, part + at.memory, other + at.sides) &&
           apart(part, other) < 1;
}

bool Model::equal_discrete(const double* part, const double* other) const {
    const int memory = layout().memory;
    return std::memcmp(part + memory, other + memory, problem_->sizes.memory * sizeof(double)) == 0;
}

void Model::Parts::drop(int i) {
    std::copy((*this)[i + 1], (*this)[used], (*this)[i]);
    --used;
}

void Model::Parts::merge(int i, int j) {
    model.merge((*this)[i], (*this)[j]);
    drop(j);
}

// Those of another number of events come last.
double Model::Parts::apart(int i, int j) const {
    constexpr double other_count = 1e6;
    const double *part = (*this)[i], *other = (*this)[j];
    const int jumps = model.layout().jumps;
    return model.apart(part, other) + (part[jumps] == other[jumps] ? 0 : other_count);
}

// As the parts of a state: at most four.
void Model::keep(State& s, Parts& parts) const {
    mixture::normalise(parts);
    if (parts.first != s.x()) std::copy(parts[0], parts[parts.used], s.x());
    s.x()[layout().parts_used] = parts.used;
}

Model::Summary Model::parts(const State& s) const {
    const Layout& at = layout();
    Summary all{parts_of(s), 0, 0, 0};
    for (int i = 0; i < all.count; ++i) {
        const double* part = part_of(s, i);
        all.mean_events += part[at.weight] * part[at.jumps];
        if (!(part[at.weight] > all.largest)) continue;
        all.largest = part[at.weight];
        all.events = part[at.jumps];
    }
    return all;
}

} // namespace hnav::observer
