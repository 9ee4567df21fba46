// An interval of a stiff plant: an implicit solver integrates the states, and in each of its steps Phi and Qd are advanced by the
// exponential of A, frozen in the middle of each quarter. Decayed modes are zero for any step, which no explicit method
// achieves.
#include "hybrid/stiff_solver.hpp"
#include "maths/finite.hpp"
#include "observer/observer_model.hpp"

#include <algorithm>
#include <cmath>

namespace hnav::observer {
namespace {

// radians or decays per interval below which an explicit method is as good
constexpr double calm = 20;
// If the implicit solver needs a larger share of the explicit one's steps, the plant is not stiff but fast.
constexpr double worth_while = 0.3;

// The largest sum of magnitudes in a row of D^-1 a D. D: the diagonal matrix of the scales.
double largest_row(int n, const double* a, const double* scale) {
    double largest = 0;
    for (int i = 0; i < n; ++i) {
        double sum = 0;
        for (int j = 0; j < n; ++j) sum += std::fabs(a[i * n + j]) * scale[j] / scale[i];
        largest = std::max(largest, sum);
    }
    return largest;
}

} // namespace

int Model::StiffRun::flow(const void* context, double s, const double* x, double* dx) {
    const auto* run = static_cast<const StiffRun*>(context);
    return run->model->stiff_flow(*run, s, x, dx, nullptr);
}

int Model::StiffRun::jacobian(const void* context, double s, const double* x, double* J) {
    const auto* run = static_cast<const StiffRun*>(context);
    return run->model->stiff_flow(*run, s, x, nullptr, J);
}

// Slopes of the moving numbers, or their derivatives by each other; A of the workspace is by all of X.
int Model::stiff_flow(const StiffRun& run, double s, const double* x, double* dx, double* J) const {
    const Problem& p = *problem_;
    if (!all_finite(x, p.moving)) return int(Answer::elsewhere);
    const Point here = point_at(*run.s, run.begin_s + s, x, run.part + layout().parameters);
    const Answer answer = dx ? plant_->evaluate(Function::derivatives, here, dx)
                             : work_->linearisation.jacobian(*plant_, Function::derivatives, here, work_->A);
    const bool fine = dx ? ask(answer, Function::derivatives, here.t_s, dx, p.n) : ask_A(answer, here.t_s);
    if (!fine) return int(answer == Answer::ok ? Answer::elsewhere : answer);
    if (dx) {
        for (int i = p.n; i < p.moving; ++i) dx[i] = -p.decay_1_s[i - p.n] * x[i];
        return 0;
    }
    add_decays();
    for (int i = 0; J && i < p.moving; ++i) std::copy_n(work_->A + i * p.N, p.moving, J + i * p.moving);
    return 0;
}

bool Model::is_stiff(const State& s) const { return s.x()[layout().stiff] != 0; }

bool Model::make_stiff_solver(long max_steps) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double* atol = work_->gain;
    for (int i = 0; i < p.moving; ++i) atol[i] = options_.rtol * p.scale[i];
    RuntimeState& first = *reinterpret_cast<RuntimeState*>(work_->stiff_start);
    std::fill_n(first.x(), at.numbers, 0.0);
    begin(first);
    const StiffRun run{this, &first, first.x(), 0};
    StiffSolver::Settings settings{options_.rtol, atol, max_steps};
    return stiff_->create(p.moving, StiffRun::flow, StiffRun::jacobian, settings, &run, first.x());
}

bool Model::flow_stiffly(State& s, double interval_s, Propagator& counts) const {
    const Layout& at = layout();
    double *v = s.x(), *x = work_->gain;
    const StiffRun run{this, &s, v, v[at.t] + v[at.elapsed] + v[at.clock]};
    const CountedBy counted(counts, *stiff_);
    if (!go_until(run, v, interval_s, true, x)) return false;
    std::copy_n(x, problem_->moving, v);
    v[at.clock] += interval_s;
    judge_stiffness(v, counted.steps(), interval_s);
    return true;
}

// Moving numbers of the part to x.
bool Model::go_until(const StiffRun& run, double* part, double length_s, bool with_matrices, double* x) const {
    bool whole = stiff_->begin(&run, length_s, part);
    for (double from_s = 0, to_s = 0; whole && to_s < length_s; from_s = to_s)
        whole = stiff_->step(&to_s, x) && (!with_matrices || add_step(run, part, from_s, to_s));
    return whole;
}

// Phi and Qd over the newest step.
bool Model::add_step(const StiffRun& run, double* part, double from_s, double to_s) const {
    bool whole = true;
    for (const double share : {0.125, 0.375, 0.625, 0.875})
        whole = whole && stiff_->between(from_s + share * (to_s - from_s), work_->probe) &&
                stiff_flow(run, from_s + share * (to_s - from_s), work_->probe, nullptr, nullptr) == 0 &&
                add_matrices(part, 0.25 * (to_s - from_s), run.s->x()[layout().usual]);
    return whole;
}

// Whether the next interval begins with the implicit solver.
void Model::judge_stiffness(double* s, std::uint64_t taken, double length_s) const {
    const bool few = static_cast<double>(taken) < worth_while * max_explicit_steps;
    s[layout().stiff] = few && fastest_rate_of_A() * length_s > calm;
}

// The same to a guard, for a plant with events: a step is searched for crossings before its matrices are used.
Model::Stop Model::go_stiffly(Run& run, double* part, double length_s) const {
    const Layout& at = layout();
    run.stiffly = run.went_stiffly = true;
    const StiffRun of{this, &run.s, part, run.s.x()[at.t] + part[at.elapsed] + part[at.clock]};
    StiffSolver& solver = *stiff_;
    const CountedBy counted(*run.propagator, solver);
    const bool with_matrices = !run.alone;
    double *x = work_->step_to, from_s = 0, to_s = 0, low_s = 0, high_s = 0;
    Stop stop = Stop::end;
    std::copy_n(part, nx(), x);
    bool whole = solver.begin(&of, length_s, part);
    while (whole && stop == Stop::end && to_s < length_s) {
        from_s = to_s;
        std::copy_n(x, problem_->moving, work_->step_from);
        whole = solver.step(&to_s, x);
        x[at.clock] = to_s;
        if (whole) stop = look_between(run, part, from_s, to_s, &low_s, &high_s);
        if (!whole || stop == Stop::failed || stop == Stop::missed) break;
        if (stop == Stop::guard) {
            to_s = high_s;
            whole = narrow(run, part, &low_s, &to_s) && go_to_guard(run, of, part, from_s, low_s, &to_s);
        } else {
            whole = !with_matrices || add_step(of, part, from_s, to_s);
            stop = end_of_step(run, part);
        }
    }
    run.stiffly = false;
    if (!whole) return Stop::failed;
    if (stop == Stop::failed || stop == Stop::missed) return stop;
    std::copy_n(x, problem_->moving, part);
    part[at.clock] = to_s;
    if (with_matrices) judge_stiffness(run.s.x(), counted.steps(), length_s);
    return stop;
}

// From the beginning of the step again, to the guard and with the matrices.
bool Model::go_to_guard(Run& run, const StiffRun& of, double* part, double from_s, double low_s, double* to_s) const {
    if (!close_in(run, of, part, from_s, low_s, to_s)) return false;
    run.stiff_step_s = *to_s - from_s;
    std::copy_n(work_->step_from, problem_->moving, part);
    const StiffRun rest{this, of.s, part, of.begin_s + from_s};
    return go_until(rest, part, *to_s - from_s, !run.alone, work_->step_to);
}

// Inside a step a polynomial approximates the flow, which may cross slightly earlier or later.
bool Model::close_in(const Run& run, const StiffRun& of, const double* part, double from_s, double low_s, double* high_s) const {
    const Layout& at = layout();
    double* x = work_->inside;
    double width_s = std::max(*high_s - low_s, 1e-9 * (*high_s - from_s));
    const StiffRun rest{this, of.s, part, of.begin_s + from_s};
    const auto crossed = [&](double to_s, bool* is) {
        std::copy_n(part, nx(), x);
        std::copy_n(work_->step_from, problem_->moving, x);
        x[at.clock] = to_s;
        if (to_s > from_s && !go_until(rest, x, to_s - from_s, false, x)) return false;
        if (!look(run, part, x)) return false;
        *is = first_changed(part) >= 0;
        return true;
    };
    bool before = true, after = false;
    for (int k = 0; k < 12; ++k, width_s *= 4) {
        const double end_s = *high_s;
        if (!crossed(end_s, &after)) return false;
        if (!after) {
            *high_s += width_s;
            continue;
        }
        if (!crossed(std::max(from_s, end_s - width_s), &before)) return false;
        if (!before || end_s - width_s <= from_s) return true;
        *high_s = end_s - width_s;
    }
    return after;
}

// Phi and Qd over a time with the A of the workspace: Taylor series over a short piece, doubled to the whole.
bool Model::add_matrices(double* part, double by_s, double usual_s) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const int N = p.N, all = N * N;
    double *A = work_->matrices, *Phi = A + all, *Q = Phi + all, *next = Q + all, *term = next + all, *product = work_->product;
    std::fill_n(A, all, 0.0);
    std::copy_n(work_->A, p.moving * N, A);
    int doublings = 0;
    for (double norm = largest_row(N, A, p.scale) * by_s; norm > 0.25; norm *= 0.5)
        if (++doublings > 60) return false;
    const double piece_s = std::ldexp(by_s, -doublings);
    constexpr int terms = 9;
    std::fill_n(Phi, all, 0.0);
    std::fill_n(Q, all, 0.0);
    std::fill_n(term, all, 0.0);
    std::fill_n(next, all, 0.0);
    for (int i = 0; i < N; ++i) {
        next[i * N + i] = piece_s * p.noise[i] / usual_s;
        Phi[i * N + i] = term[i * N + i] = 1;
    }
    for (int k = 1; k <= terms; ++k) {
        for (int i = 0; i < all; ++i) Q[i] += next[i];
        multiply(N, A, next, product);
        for (int i = 0; i < N; ++i)
            for (int j = 0; j < N; ++j) next[i * N + j] = (product[i * N + j] + product[j * N + i]) * piece_s / (k + 1);
        multiply(N, A, term, product);
        for (int i = 0; i < all; ++i) Phi[i] += term[i] = product[i] * piece_s / k;
    }
    for (; doublings > 0; --doublings) {
        std::fill_n(next, all, 0.0);
        add_congruence(N, Phi, Q, product, next);
        for (int i = 0; i < all; ++i) Q[i] += next[i];
        multiply(N, Phi, Phi, next);
        std::copy_n(next, all, Phi);
    }
    // All of Phi so far has rows of the identity below.
    std::fill_n(term, all, 0.0);
    std::copy_n(part + at.S, p.moving * N, term);
    for (int i = p.moving; i < N; ++i) term[i * N + i] = 1;
    multiply(N, Phi, term, next);
    std::copy_n(next, p.moving * N, part + at.S);
    unpack_upper(part + at.Qd, N, 1, term);
    std::fill_n(next, all, 0.0);
    add_congruence(N, Phi, term, product, next);
    for (int i = 0; i < all; ++i) next[i] += Q[i];
    pack_upper(next, N, part + at.Qd);
    return true;
}

// The spectral radius of the newest A, by the norm of its sixteenth power.
double Model::fastest_rate_of_A() const {
    const Problem& p = *problem_;
    const int N = p.N, all = N * N;
    double *A = work_->matrices, *next = A + 3 * all, logarithm = 0;
    std::fill_n(A, all, 0.0);
    std::copy_n(work_->A, p.moving * N, A);
    for (int k = 0; k < 4; ++k) {
        const double norm = largest_row(N, A, p.scale);
        if (!(norm > 0)) return 0;
        // Of A^(2^k), divided by its norm each time.
        logarithm += std::log(norm) * std::ldexp(1.0, -k);
        for (int i = 0; i < all; ++i) A[i] /= norm;
        multiply(N, A, A, next);
        std::copy_n(next, all, A);
    }
    const double norm = largest_row(N, A, p.scale);
    return norm > 0 ? std::exp(logarithm + std::log(norm) / 16) : 0;
}

} // namespace hnav::observer
