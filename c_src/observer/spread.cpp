// The rest of an interval in which an event has no derivative: its guard is hardly crossed or hardly missed, so that only a part of the
// Gaussian crosses it, or two guards are crossed in an uncertain order. Points spread over P pass the plant with all its events.
// Points with equal numbers of events form a part by their moments, so the parts together have the moments of all points, which are
// exact for a linear flow.
//
// The first two columns of a root of P point along the guards. In their plane, where the plant is not smooth, the points are even.
// For the other columns each point has one, as cubature points do. Half of the noise enters before, half after.
#include "estimation/truncation.hpp"
#include "observer/observer_model.hpp"

#include <algorithm>
#include <cmath>

namespace hnav::observer {
namespace {

// x with Phi(x) = p > 0.5
double normal_quantile(double p) {
    double low = 0, high = 10;
    for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + high);
        (normal_below(middle) < p ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

} // namespace

// Pairs of numbers that with their opposites have mean 0, variance 1 and correlation 0: quantiles in one direction, the golden
// ratio in the other.
void make_spread(int N, double* plane) {
    const int count = spread_count(N);
    constexpr double golden = 0.6180339887498949;
    double aa = 0, ab = 0, bb = 0;
    for (int k = 0; k < count; ++k) {
        const double v = std::fmod(0.5 + (k + 1) * golden, 1.0), side = v > 0.5 ? 1 : -1;
        const double a = normal_quantile(0.5 + (k + 0.5) / (2 * count)), b = side * normal_quantile(0.5 + std::fabs(v - 0.5));
        plane[2 * k] = a;
        plane[2 * k + 1] = b;
        aa += a * a / count;
        ab += a * b / count;
    }
    for (int k = 0; k < count; ++k) {
        plane[2 * k + 1] -= ab / aa * plane[2 * k];
        plane[2 * k] /= std::sqrt(aa);
        bb += plane[2 * k + 1] * plane[2 * k + 1] / count;
    }
    for (int k = 0; k < count; ++k) plane[2 * k + 1] /= std::sqrt(bb);
}

// The gradient of a guard at the crossing, transformed to the beginning of this piece of the interval: Phi' g.
void Model::note_guard(const double* S, const double* gradient, double* to) const {
    const Problem& p = *problem_;
    for (int j = 0; j < p.N; ++j) {
        to[j] = j < p.moving ? 0 : gradient[j];
        for (int i = 0; i < p.moving; ++i) to[j] += gradient[i] * S[i * p.N + j];
    }
}

// The event run.present may have occurred earlier or later, or not yet.
void Model::note_open(Run& run) const {
    const Passage& e = run.present;
    if (run.open_until_s == 0) note_guard(work_->segment_S, e.gradient, work_->open_guard);
    run.open_until_s = std::max(run.open_until_s, e.elapsed + hardly_sigma * e.sigma_s);
}

// While an event may not have occurred, points start before it: those behind it have all had it.
void Model::begin_again() const {
    const int N = problem_->N;
    std::copy_n(work_->beginning, layout().part_numbers, work_->segment);
    std::copy_n(work_->open_guard, N, work_->guards);
    std::fill_n(work_->guards + N, N, 0.0);
}

// Columns L of a root of P, N each, the first along the guards; returns their number. P becomes zero.
int Model::root_along_guards(double* P, double* L) const {
    const int N = problem_->N;
    const double* scale = problem_->scale;
    int columns = 0;
    const auto take = [&](const double* direction) {
        double *k = L + columns * N, variance = 0;
        times_rows(P, N, N, direction, k);
        for (int i = 0; i < N; ++i) variance += k[i] * direction[i];
        if (!(variance > 0)) return;
        for (int i = 0; i < N; ++i) k[i] /= std::sqrt(variance);
        condition_joint(k, columns, direction, std::sqrt(variance));
        for (int i = 0; i < N; ++i)
            for (int j = 0; j < N; ++j) P[i * N + j] -= k[i] * k[j];
        ++columns;
    };
    double all = 0;
    for (int i = 0; i < N; ++i) all = std::max(all, P[i * N + i] / (scale[i] * scale[i]));
    take(work_->guards);
    if (N > 1) take(work_->guards + N);
    for (double* unit = work_->probe; columns < N;) {
        int largest = 0;
        const auto of = [&](int i) { return P[i * N + i] / (scale[i] * scale[i]); };
        for (int i = 1; i < N; ++i)
            if (of(i) > of(largest)) largest = i;
        if (!(of(largest) > 1e-14 * all)) break;
        std::fill_n(unit, N, 0.0);
        unit[largest] = 1;
        take(unit);
    }
    return columns;
}

// part: as at the point where the derivatives failed, then the first of the new parts. False: the plant fails at every point.
bool Model::spread(Run& run, double* part) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const int N = p.N, count = spread_count(N);
    const double* start = work_->segment;
    if (part[at.elapsed] < run.open_until_s && start[at.jumps] > work_->beginning[at.jumps]) begin_again();
    const double left_s = run.interval_s - start[at.elapsed];
    double *mean = work_->spread_mean, *L = work_->matrices, *P = L + N * N;
    run.s.x()[at.counts + Layout::grazing] += 1;
    expected(start, mean);
    unpack_upper(start + at.P, N, 1, P);
    for (int i = 0; i < N; ++i) P[i * N + i] += 0.5 * left_s * p.noise[i];
    std::copy_n(start + at.joint, at.joint_numbers, work_->joint);
    const int columns = root_along_guards(P, L), others = std::max(0, columns - 2);
    const Spread of{mean, L, columns, start[at.weight] / (others > 0 ? 4 * count : 2 * count)};
    Parts groups{*this, part, 0};
    for (int k = 0; k < count; ++k)
        for (const double side : {1.0, -1.0})
            for (const double other : {1.0, -1.0}) {
                if (others == 0 && other < 0) break;
                if (send(run, of, k, side, other)) gather(groups);
                else if (work_->events_left <= 0) return false;
            }
    if (groups.used == 0 || !close_groups(run, groups, 0.5 * left_s, 2 * N * of.weight)) return false;
    run.made->used += groups.used - 1;
    return true;
}

// Propagates one point through the interval, to work_->point.
bool Model::send(const Run& run, const Spread& of, int k, double side, double other) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const int N = p.N, count = spread_count(N), others = std::max(0, of.columns - 2);
    double *X = work_->x, *point = work_->point, *distance = work_->distances;
    std::fill_n(distance, of.columns, 0.0);
    for (int c = 0; c < std::min(2, of.columns); ++c) distance[c] = side * work_->plane[2 * k + c];
    if (others > 0) {
        const int c = k % others, points = count / others + (c < count % others);
        distance[2 + c] = other * std::sqrt(double(count) / points);
    }
    for (int i = 0; i < N; ++i) {
        X[i] = of.mean[i];
        for (int c = 0; c < of.columns; ++c) X[i] += distance[c] * of.root[c * N + i];
    }
    std::copy_n(work_->segment, at.part_numbers, point);
    std::fill(point + at.P, point + at.weight, 0.0);
    point[at.weight] = of.weight;
    place_point_joint(distance, of.columns, point);
    put(X, point);
    Run of_point(run.s, run.interval_s, *work_, run.propagator);
    of_point.alone = true;
    return cross_part(of_point, point);
}

// Adds the point to the group with as many events; a new group for a new number, while there is space.
void Model::gather(Parts& groups) const {
    const Layout& at = layout();
    const double* point = work_->point;
    double* nearest = nullptr;
    const auto apart = [&](const double* group) { return std::fabs(group[at.jumps] - point[at.jumps]); };
    for (int i = 0; i < groups.used; ++i)
        if (!nearest || apart(groups[i]) < apart(nearest)) nearest = groups[i];
    if (nearest && (apart(nearest) == 0 || groups.used == max_parts)) return merge(nearest, point);
    std::copy_n(point, at.part_numbers, groups[groups.used++]);
}

// Noise of the groups. A group of too few points for a covariance joins the next one; if the plant's discrete states differ, it would lose
// its own there, and takes the covariance of the next one instead.
bool Model::close_groups(const Run& run, Parts& groups, double noise_s, double smallest) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const auto next = [](int i) { return i == 0 ? 1 : i - 1; };
    for (int i = 0; i < groups.used && groups.used > 1; ++i) {
        const bool joins = run.went_stiffly || equal_discrete(groups[i], groups[next(i)]);
        if (groups.weight(i) >= smallest || !joins) continue;
        groups.merge(next(i), i);
        i = -1;
    }
    for (int i = 0; i < groups.used && groups.used > 1; ++i)
        if (groups.weight(i) < smallest) std::copy_n(groups[next(i)] + at.P, Layout::triangle(p.N), groups[i] + at.P);
    const double now_s = run.s.x()[at.t] + run.interval_s;
    for (int i = 0; i < groups.used; ++i) {
        double *to = groups[i], *P = work_->matrices, *X = work_->x;
        unpack_upper(to + at.P, p.N, 1, P);
        for (int k = 0; k < p.N; ++k) {
            const double floor = floor_step * p.scale[k];
            P[k * p.N + k] += noise_s * p.noise[k] + floor * floor;
        }
        pack_upper(P, p.N, to + at.P);
        expected(to, X);
        // The mean of points on one side of a curved guard may be on the other.
        plant_->recall(to + at.memory);
        if (put_inside(run.s, to, now_s, X, P) == Inside::failed) return false;
        put(X, to);
    }
    return true;
}

} // namespace hnav::observer
