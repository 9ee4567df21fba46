// An interval of a stiff plant: its states go by an implicit solver, and in each of its steps Phi and the noise that enters go by the
// exponential of A, frozen in the middle of each quarter. Modes that have died are zero there whatever the step, which no
// explicit method can say.
#include "hybrid/stiff_solver.hpp"
#include "observer/observer_model.hpp"

#include <algorithm>
#include <cmath>

namespace hnav::observer {
namespace {

// Below so many radians or decays in an interval an explicit method does as well.
constexpr double calm = 20;
// One that needs as many steps as an explicit one is not stiff, it only goes far.
constexpr double worth_while = 0.3;

void multiply(int n, const double* a, const double* b, double* out) {
    std::fill_n(out, n * n, 0.0);
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k)
            if (const double factor = a[i * n + k]; factor != 0)
                for (int j = 0; j < n; ++j) out[i * n + j] += factor * b[k * n + j];
}

// a b a'
void congruence(int n, const double* a, const double* b, double* work, double* out) {
    multiply(n, a, b, work);
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) {
            double sum = 0;
            for (int k = 0; k < n; ++k) sum += work[i * n + k] * a[j * n + k];
            out[i * n + j] = out[j * n + i] = sum;
        }
}

// Of D^-1 a D, D the scales of what the rows and columns are.
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

// The moving numbers' slopes, or their derivatives by each other; A of the workspace is by all that is estimated.
int Model::stiff_flow(const StiffRun& run, double s, const double* x, double* dx, double* J) const {
    const Problem& p = *problem_;
    for (int i = 0; i < p.moving; ++i)
        if (!std::isfinite(x[i])) return int(Answer::elsewhere);
    double* X = work_->slope_here;
    std::copy_n(x, p.moving, X);
    std::copy_n(run.s->x() + layout().parameters, p.sizes.parameters, X + p.moving);
    const Point here = point_of(*run.s, run.begin_s + s, X);
    double* out = dx ? dx : work_->A;
    const Answer answer = dx ? plant_->evaluate(Function::derivatives, here, dx)
                             : work_->linearisation.jacobian(*plant_, Function::derivatives, here, work_->A);
    if (!ask(answer, Function::derivatives, here.t_s, out, dx ? p.n : p.n * p.N))
        return int(answer == Answer::ok ? Answer::elsewhere : answer);
    if (dx) {
        for (int i = p.n; i < p.moving; ++i) dx[i] = -p.decay_1_s[i - p.n] * x[i];
        return 0;
    }
    add_decays();
    for (int i = 0; J && i < p.moving; ++i) std::copy_n(work_->A + i * p.N, p.moving, J + i * p.moving);
    return 0;
}

bool Model::is_stiff(const State& s) const { return s.x()[layout().stiff] != 0; }

bool Model::make_stiff_solver(StiffSolver& solver, long max_steps) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    double* atol = work_->gain;
    for (int i = 0; i < p.moving; ++i) atol[i] = settings_.rtol * p.scale[i];
    RuntimeState& first = *reinterpret_cast<RuntimeState*>(work_->stiff_start);
    std::fill_n(first.x(), at.numbers, 0.0);
    begin(first);
    const StiffRun run{this, &first, 0};
    StiffSolver::Settings settings{settings_.rtol, atol, max_steps};
    work_->stiff = &solver;
    return solver.create(p.moving, StiffRun::flow, StiffRun::jacobian, settings, &run, first.x());
}

bool Model::flow_stiffly(State& s, double interval_s, Propagator& counts) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    double *v = s.x(), *x = work_->gain;
    StiffSolver& solver = *work_->stiff;
    const StiffRun run{this, &s, v[at.t] + v[at.elapsed] + v[at.clock]};
    const std::uint64_t evaluations = solver.evaluations, steps = solver.steps;
    if (!solver.begin(&run, interval_s, v)) return false;
    bool whole = true;
    for (double from_s = 0, to_s = 0; whole && to_s < interval_s; from_s = to_s) {
        whole = solver.step(&to_s, x);
        for (const double share : {0.125, 0.375, 0.625, 0.875})
            whole = whole && solver.between(from_s + share * (to_s - from_s), work_->probe) &&
                    stiff_flow(run, from_s + share * (to_s - from_s), work_->probe, nullptr, nullptr) == 0 &&
                    add_matrices(v, 0.25 * (to_s - from_s));
    }
    const std::uint64_t taken = solver.steps - steps;
    counts.set_counts(counts.rhs_evals() + solver.evaluations - evaluations, counts.steps() + taken);
    if (!whole) return false;
    std::copy_n(x, p.moving, v);
    v[at.clock] += interval_s;
    const bool pays = static_cast<double>(taken) < worth_while * max_explicit_steps && fastest_rate_of_A() * interval_s > calm;
    v[at.stiff] = pays;
    return true;
}

// Phi and Qd go on by a time in which A is what the workspace has: Taylor's series over a piece in which little happens, doubled until
// it is the whole.
bool Model::add_matrices(double* part, double by_s) const {
    const Problem& p = *problem_;
    const Layout at = layout();
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
        next[i * N + i] = piece_s * p.noise[i] / part[at.usual];
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
        congruence(N, Phi, Q, product, next);
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
    congruence(N, Phi, term, product, next);
    for (int i = 0; i < all; ++i) next[i] += Q[i];
    pack_upper(next, N, part + at.Qd);
    return true;
}

// The spectral radius of the newest A, by the norm of its sixteenth power.
double Model::fastest_rate_of_A() const {
    const Problem& p = *problem_;
    const int N = p.N, all = N * N;
    double *A = work_->matrices, *next = A + 3 * all, logarithm = 0;
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
