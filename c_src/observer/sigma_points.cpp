// An interval by sigma points, for plants whose derivatives do not exist or are inaccurate over a sigma: tables, relays without
// indicators, strong curvature. 2N cubature points of equal weight keep P positive semidefinite. Half of the noise enters before, half
// after.
#include "estimation/mixture.hpp"
#include "hybrid/stiff_solver.hpp"
#include "observer/observer_model.hpp"

#include <algorithm>
#include <cmath>

namespace hnav::observer {
// With the implicit solver for a stiff plant, the same for all points of an interval.
bool Model::flow_one_point(State& s, double interval_s, Propagator& propagator, double* x) const {
    double* v = s.x();
    const Layout& at = layout();
    if (problem_->sizes.steps) return step(s, interval_s, x);
    if (v[at.stiff] == 0) {
        const FlowContext<Model> context{this, &s, {nullptr, true}};
        if (propagator.integrate(&context, interval_s, x)) return true;
        if (!propagator.out_of_steps()) return false;
        std::copy_n(work_->stiff_start, problem_->moving, x);
        v[at.stiff] = 1;
    }
    const StiffRun run{this, &s, v, v[at.t] + v[at.elapsed] + v[at.clock]};
    const CountedBy counted(propagator, *stiff_);
    return go_until(run, x, interval_s, false, x);
}

// The plant integrates its states itself; unknown inputs are held and decay afterwards.
bool Model::step(const State& s, double interval_s, double* x) const {
    const Problem& p = *problem_;
    const Point here = point(s, s.x(), x);
    double* after = work_->slope_here;
    if (!ask(plant_->step(here, interval_s, after), Function::derivatives, here.t_s, after, p.n)) return false;
    std::copy_n(after, p.n, x);
    for (int i = 0; i < p.sizes.unknown_inputs; ++i) x[p.n + i] *= std::exp(-p.decay_1_s[i] * interval_s);
    return true;
}

// The discrete state of such a plant is that of the path of the mean.
bool Model::step_of_mean(State& s, double interval_s, const double* mean) const {
    double *v = s.x(), *x = work_->step_to;
    std::copy_n(work_->step_from, nx(), x);
    std::copy_n(mean, problem_->moving, x);
    std::copy_n(mean + problem_->moving, problem_->sizes.parameters, v + layout().parameters);
    if (!step(s, interval_s, x)) return false;
    return ask(plant_->remember(v + layout().memory), Function::derivatives, v[layout().t], nullptr, 0);
}

bool Model::flow_by_points(State& s, double interval_s, Propagator& propagator) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const int N = p.N;
    double *v = s.x(), *points = work_->matrices, *L = points + 2 * N * N, *P = L + N * N, *mean = work_->probe;
    open_joint(s);
    flow_joint(v);
    covariance(s, v, v + at.P, P);
    for (int i = 0; i < N; ++i) P[i * N + i] += 0.5 * interval_s * p.noise[i];
    root_of(N, P, 1e-14, L);
    begin_cubature_joint(L, v);
    expected_uncut(v, v, mean);
    std::copy_n(v, nx(), work_->step_from);
    bool whole = !remembers() || ask(plant_->recall(v + at.memory), Function::derivatives, v[at.t], nullptr, 0);
    for (int k = 0; whole && k < 2 * N; ++k) {
        double *X = points + k * N, *x = work_->step_to;
        const double by = k % 2 == 0 ? std::sqrt(N) : -std::sqrt(N);
        for (int i = 0; i < N; ++i) X[i] = mean[i] + by * L[i * N + k / 2];
        std::copy_n(work_->step_from, nx(), x);
        std::copy_n(X, p.moving, x);
        std::copy_n(X + p.moving, p.sizes.parameters, v + at.parameters);
        std::copy_n(X, p.moving, work_->stiff_start);
        whole = flow_one_point(s, interval_s, propagator, x);
        std::copy_n(x, p.moving, X);
    }
    if (!whole || (p.sizes.steps && !step_of_mean(s, interval_s, mean))) return false;
    const auto point = [&](int k) { return mixture::Part{0.5 / N, points + k * N, nullptr}; };
    mixture::moments(2 * N, N, point, mean, P);
    for (int i = 0; i < N; ++i) P[i * N + i] += 0.5 * interval_s * p.noise[i];
    place(mean, P, v);
    put(mean, v);
    pack_upper(P, N, v + at.P);
    end_cubature_joint(points, v);
    begin_flow(v, v[at.clock] + interval_s);
    return true;
}

} // namespace hnav::observer
