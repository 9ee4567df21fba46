// Intervals in which the plant fails. Over the rest of the interval the estimate is held, and P grows by the missed displacement: the
// largest recent rates of the states, over the w seconds in all for which it has been held, and their noise,
//
//     P_ii += ((w + T)^2 - w^2) x_i'^2 + T Q_ii
//
// each variance by itself: the path may curve, so that correlations along a straight one would let a sensor of one state correct the
// others. An event that was not passed may have changed a state by its whole value. A correction into a region where the plant fails
// ends before that region.
#include "maths/finite.hpp"
#include "observer/observer_model.hpp"

#include <algorithm>
#include <cmath>

namespace hnav::observer {

void Model::hold(State& s, double by_s) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double *v = s.x(), *P = work_->P, *dX = work_->gain;
    if (v[at.begun] == 0) return;
    open_joint(s);
    const bool unpassed = trouble_->any && trouble_->function == Function::event;
    const double before_s = v[at.held], after_s = before_s + by_s, grows = after_s * after_s - before_s * before_s;
    for (int i = 0; i < parts_of(s); ++i) {
        double* part = part_of(s, i);
        collect(s, part);
        course(s, part, dX);
        unpack_upper(part + at.P, p.N, 1, P);
        for (int j = 0; j < p.N; ++j) P[j * p.N + j] += by_s * p.noise[j] + grows * dX[j] * dX[j];
        for (int j = 0; unpassed && j < p.moving; ++j) P[j * p.N + j] += part[j] * part[j] + p.scale[j] * p.scale[j];
        pack_upper(P, p.N, part + at.P);
        part[at.elapsed] += by_s;
    }
    v[at.held] = after_s;
    v[at.holds] = 1;
    v[at.counts + Layout::holding] += 1;
    v[at.ready] = 0;
    if (unpassed) earn_again(s);
}

// Largest rate of each estimated number: of the plant, or the last one before it failed.
void Model::course(const State& s, const double* part, double* dX) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const Trouble met = *trouble_; // failures here are not reported
    const double t_s = s.x()[at.t] + part[at.elapsed];
    expected(part, work_->x);
    const bool recalled = !remembers() || plant_->recall(part + at.memory) == Answer::ok;
    if (!recalled || !slope(s, t_s, work_->x, dX)) std::fill_n(dX, p.N, 0.0);
    *trouble_ = met;
    for (int i = 0; i < p.moving; ++i) dX[i] = std::max(std::fabs(dX[i]), s.x()[at.course + i]);
}

// The event has no sound result: its inputs hold from now on, its sensors are not used.
bool Model::miss(State& s, const Event& event) const {
    const Layout& at = layout();
    double* v = s.x();
    if (v[at.begun] == 0) return false;
    collect_all(s);
    v[at.t] = event.t_s;
    for (int i = 0; i < problem_->known; ++i)
        if (event.has(i)) v[at.inputs + i] = *event.value(i);
    v[at.ready] = 0;
    end_interval(s);
    return true;
}

// At the end of an interval, before anything is corrected.
void Model::note_course(State& s, double interval_s) const {
    constexpr double kept = 0.99; // share of the largest rate kept from interval to interval
    const Layout& at = layout();
    double *v = s.x(), *from = v + at.from, *rate = v + at.course;
    for (int i = 0; interval_s > 0 && v[at.holds] == 0 && i < problem_->moving; ++i)
        rate[i] = std::max(std::fabs(v[i] - from[i]) / interval_s, kept * rate[i]);
}

void Model::end_interval(State& s) const {
    const Layout& at = layout();
    double* v = s.x();
    if (v[at.holds] == 0) v[at.held] = 0;
    v[at.holds] = 0;
    v[at.closed] = 1;
    std::copy_n(v, problem_->moving, v + at.from);
}

bool Model::answers(const State& s, const double* X) const {
    const Problem& p = *problem_;
    double* dx = work_->slope_here;
    const Point here = point_of(s, s.x()[layout().t], X);
    if (plant_->evaluate(Function::derivatives, here, dx) != Answer::ok) return false;
    return all_finite(dx, p.n);
}

// From the corrected X back towards the predicted one, as far as necessary; P grows by the difference.
void Model::pull_back(const State& s, const double* part, double* X, double* P) const {
    const Problem& p = *problem_;
    constexpr int halves = 12;
    if (answers(s, X)) return;
    double *before = work_->probe, *trial = work_->probe + p.N;
    expected(part, before);
    for (int k = 1; k <= halves; ++k) {
        const double share = k == halves ? 0 : std::ldexp(1.0, -k);
        for (int i = 0; i < p.N; ++i) trial[i] = before[i] + share * (X[i] - before[i]);
        if (!answers(s, trial)) continue;
        for (int i = 0; i < p.N; ++i)
            for (int j = 0; j < p.N; ++j) P[i * p.N + j] += (X[i] - trial[i]) * (X[j] - trial[j]);
        std::copy_n(trial, p.N, X);
        return;
    }
}

} // namespace hnav::observer
