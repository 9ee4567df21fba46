#include "observer/observer_model.hpp"

#include "estimation/truncation.hpp"
#include "maths/finite.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace hnav::observer {

PassageMemory::PassageMemory(Arena& arena, const Problem& p, const Layout& layout) {
    for (double** row : {&X, &slope, &after, &slope_after, &gradient}) *row = arena.doubles(p.N);
    for (double** matrix : {&Xi, &P}) *matrix = arena.doubles(p.N * p.N);
    for (double** state : {&memory, &memory_after}) *state = arena.doubles(p.sizes.memory);
    sides = arena.doubles(p.sizes.indicators);
    joint = arena.doubles(layout.joint_numbers);
}

Workspace::Workspace(Arena& arena, const Problem& p, bool smooths)
    : layout(p, smooths), linearisation(arena, p), passages{{arena, p, layout}, {arena, p, layout}} {
    for (double** row : {&x, &slope_here, &spread_mean, &distances, &open_guard, &chattered_from}) *row = arena.doubles(p.N);
    for (double** rows : {&guards, &probe, &joint_row}) *rows = arena.doubles(2 * p.N);
    gain = arena.doubles(3 * p.N);
    for (double** moving_rows : {&A, &segment_S}) *moving_rows = arena.doubles(p.moving * p.N);
    for (double** matrix : {&Qd, &product, &P, &cut}) *matrix = arena.doubles(p.N * p.N);
    matrices = arena.doubles(5 * p.N * p.N);
    u = arena.doubles(p.sizes.inputs);
    for (double** of_sensors : {&y, &nu, &variance}) *of_sensors = arena.doubles(max_parts * p.sensors);
    H = arena.doubles(max_parts * p.sensors * p.N);
    for (double** flowing : {&step_from, &step_to, &inside, &slope}) *flowing = arena.doubles(layout.nx);
    for (double** of_guards : {&z, &z_low, &z_above, &z_first, &rates}) *of_guards = arena.doubles(p.sizes.indicators);
    z_inside = arena.doubles(5 * p.sizes.indicators);
    gradients = arena.doubles(p.sizes.indicators * p.N);
    for (double** part : {&beginning, &segment, &point}) *part = arena.doubles(layout.part_numbers);
    branches = arena.doubles(p.sizes.events ? max_branches * layout.part_numbers : 0);
    plane = arena.doubles(2 * spread_count(p.N));
    first_memory = arena.doubles(p.sizes.memory);
    stiff_start = arena.doubles(layout.numbers);
    for (double** moments : {&joint, &joint_root, &joint_merged}) *moments = arena.doubles(layout.joint_numbers);
}

void Model::begin(State& s) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double* v = s.x();
    std::copy_n(p.start, p.moving, v);
    for (int i = 0; i < p.moving; ++i) v[at.S + i * p.N + i] = 1;
    std::copy_n(p.start + p.moving, p.sizes.parameters, v + at.parameters);
    double* variance = v + at.P;
    for (int i = 0; i < p.N; variance += p.N - i++) *variance = p.start_variance[i];
    if (p.bounded) {
        std::copy_n(p.start, p.N, work_->x);
        unpack_upper(v + at.P, p.N, 1, work_->P);
        place(work_->x, work_->P, v);
        put(work_->x, v);
    }
    std::copy_n(p.input_start, p.known, v + at.inputs);
    v[at.usual] = 1;
    v[at.parts_used] = v[at.weight] = 1;
    v[at.next_event] = plant_->first_event_s();
    std::copy_n(work_->first_memory, p.sizes.memory, v + at.memory);
}

bool Model::plausible(const State& s) const {
    const Layout& at = layout();
    const double* v = s.x();
    if (v[at.broken] != 0) return false;
    for (int part = 0; part < parts_of(s); ++part) {
        const double *x = part_of(s, part), *P = x + at.P;
        double sum = 0;
        for (int i = 0; part > 0 && i < problem_->moving; ++i) sum += std::fabs(x[i]);
        for (int i = 0; i < Layout::triangle(problem_->N); ++i) sum += std::fabs(P[i]);
        if (!std::isfinite(sum)) return false;
        for (int i = 0; i < problem_->N; P += problem_->N - i++)
            if (*P < 0) return false;
    }
    return true;
}

// ------------------------------------------------------------------------------------------------ flow

// Whether the plant returned finite numbers; keeps the failure otherwise.
bool Model::ask(Answer answer, Function function, double t_s, const double* values, int count) const {
    const bool fine = answer == Answer::ok && all_finite(values, count);
    if (!fine) {
        *trouble_ = {true, function, answer, t_s, ""};
        std::snprintf(trouble_->said, sizeof trouble_->said, "%s", plant_->said());
    }
    return fine;
}

// The same of A, where it depends on X.
bool Model::ask_A(Answer answer, double t_s) const {
    const Problem& p = *problem_;
    double not_a_number = 0; // unless all are finite
    for (int i = 0; answer == Answer::ok && i < p.n; ++i)
        for (const int j : work_->linearisation.dependencies().row(i)) not_a_number += 0 * work_->A[i * p.N + j];
    return ask(answer, Function::derivatives, t_s, &not_a_number, 1);
}

int Model::flow(const State& s, const double* x, double* dx, const Piece& piece) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    if (!all_finite(x, p.moving)) return int(Answer::elsewhere);
    const Point here = point(s, piece.part ? piece.part : s.x(), x);
    Linearisation::Answers answer{};
    if (piece.alone) answer.values = plant_->evaluate(Function::derivatives, here, dx);
    else answer = work_->linearisation.linearise(*plant_, Function::derivatives, here, dx, work_->A);
    const auto failed = [](Answer by) { return int(by == Answer::ok ? Answer::elsewhere : by); };
    if (!ask(answer.values, Function::derivatives, here.t_s, dx, p.n)) return failed(answer.values);
    for (int i = 0; i < p.sizes.unknown_inputs; ++i) dx[p.n + i] = -p.decay_1_s[i] * x[p.n + i];

    if (piece.alone) {
        std::fill(dx + at.S, dx + at.clock, 0.0);
        dx[at.clock] = 1;
        return 0;
    }
    if (!ask_A(answer.jacobian, here.t_s)) return failed(answer.jacobian);
    flow_of_matrices(s.x()[at.usual], x, dx);
    dx[at.clock] = 1;
    return 0;
}

// The rows of A for unknown inputs and parameters.
void Model::add_decays() const {
    const Problem& p = *problem_;
    for (int i = p.n; i < p.moving; ++i) {
        std::fill_n(work_->A + i * p.N, p.N, 0.0);
        work_->A[i * p.N + i] = -p.decay_1_s[i - p.n];
    }
}

void Model::flow_of_matrices(double usual_s, const double* x, double* dx) const {
    const Problem& p = *problem_;
    add_decays();
    // Loops of compile-time length take a third of the time, and most plants are small.
    if (p.moving == 2 && p.N == 2) return flow_of_sized<2, 2>(usual_s, x, dx);
    if (p.moving == 2 && p.N == 3) return flow_of_sized<2, 3>(usual_s, x, dx);
    if (p.moving == 3 && p.N == 3) return flow_of_sized<3, 3>(usual_s, x, dx);
    flow_of_sized<0, 0>(usual_s, x, dx);
}

// A row of A times the moving rows of a matrix.
template <int fixed_moving, int fixed_N>
void Model::multiply_row(int i, const double* with, double* out) const {
    const int moving = fixed_moving ? fixed_moving : problem_->moving, N = fixed_N ? fixed_N : problem_->N;
    const double* row = work_->A + i * N;
    std::fill_n(out, N, 0.0);
    if constexpr (fixed_N != 0) {
        for (int k = 0; k < moving; ++k)
            for (int j = 0; j < N; ++j) out[j] += row[k] * with[k * N + j];
    } else {
        for (const int k : work_->linearisation.dependencies().row(i)) {
            if (k >= moving || row[k] == 0) continue;
            for (int j = 0; j < N; ++j) out[j] += row[k] * with[k * N + j];
        }
    }
}

// 0: only known at run time.
template <int fixed_moving, int fixed_N>
void Model::flow_of_sized(double usual_s, const double* x, double* dx) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const int moving = fixed_moving ? fixed_moving : p.moving, N = fixed_N ? fixed_N : p.N;
    double *A = work_->A, *Qd = work_->Qd, *product = work_->product;
    unpack_upper(x + at.Qd, N, 1, Qd);
    for (int i = 0; i < moving; ++i) {
        double *row = A + i * N, *dS = dx + at.S + i * N, *AQ = product + i * N;
        multiply_row<fixed_moving, fixed_N>(i, x + at.S, dS);
        multiply_row<fixed_moving, fixed_N>(i, Qd, AQ);
        for (int k = moving; k < N; ++k) {
            dS[k] += row[k];
            for (int j = 0; j < N; ++j) AQ[j] += row[k] * Qd[k * N + j];
        }
    }
    double* dQ = dx + at.Qd;
    for (int i = 0; i < N; ++i)
        for (int j = i; j < N; ++j) {
            double sum = i < moving ? product[i * N + j] : 0;
            if (j < moving) sum += product[j * N + i];
            *dQ++ = i == j ? sum + p.noise[i] / usual_s : sum;
        }
}

void Model::nominal(double* x) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const double ratio = options_.covariance_rtol / options_.rtol;
    std::copy_n(p.scale, p.moving, x);
    for (int i = 0; i < p.moving; ++i)
        for (int j = 0; j < p.N; ++j) x[at.S + i * p.N + j] = ratio * p.scale[i] / p.scale[j];
    double* Qd = x + at.Qd;
    for (int i = 0; i < p.N; ++i)
        for (int j = i; j < p.N; ++j) *Qd++ = ratio * p.noise_scale[i] * p.noise_scale[j];
    x[at.clock] = 1;
}

// ------------------------------------------------------------------------------------------------ covariance

// P at the time of the estimate: Phi P Phi' + Qd.
void Model::covariance(const State& s, const double* flowed, const double* held_P, double* P) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const double* S = flowed + at.S;
    double *held = work_->Qd, *product = work_->product;
    unpack_upper(held_P, p.N, 1, held);
    for (int i = 0; i < p.N; ++i) {
        double* row = product + i * p.N;
        if (i >= p.moving) {
            std::copy_n(held + i * p.N, p.N, row);
            continue;
        }
        const double* factors = S + i * p.N;
        for (int j = 0; j < p.N; ++j) row[j] = factors[0] * held[j];
        for (int k = 1; k < p.N; ++k)
            for (int j = 0; j < p.N; ++j) row[j] += factors[k] * held[k * p.N + j];
    }
    unpack_upper(flowed + at.Qd, p.N, s.x()[at.usual], P);
    for (int i = 0; i < p.N; ++i)
        for (int j = i; j < p.N; ++j) {
            double sum = j < p.moving ? 0 : product[i * p.N + j];
            if (j < p.moving)
                for (int k = 0; k < p.N; ++k) sum += product[i * p.N + k] * S[j * p.N + k];
            P[i * p.N + j] += sum;
            P[j * p.N + i] = P[i * p.N + j];
        }
}

// Includes the flow in P and begins another interval.
void Model::collect(const State& s, double* part) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    covariance(s, part, part + at.P, work_->P);
    // A decayed mode has a variance of rounding only.
    for (int i = 0; i < p.N; ++i) {
        double& variance = work_->P[i * p.N + i];
        if (variance < 0 && variance > -1e-12 * p.scale[i] * p.scale[i]) variance = 0;
    }
    pack_upper(work_->P, p.N, part + at.P);
    if (p.bounded) {
        std::copy_n(part + at.beyond, p.N, work_->cut);
        times_rows(part + at.S, p.moving, p.N, work_->cut, part + at.beyond);
    }
    flow_joint(part);
    begin_flow(part, part[at.clock]);
}

// S and Qd begin again, after so long.
void Model::begin_flow(double* part, double after_s) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    std::fill(part + at.S, part + at.clock, 0.0);
    for (int i = 0; i < p.moving; ++i) part[at.S + i * p.N + i] = 1;
    part[at.elapsed] += after_s;
    part[at.clock] = 0;
}

void Model::expected(const double* part, double* X) const {
    std::copy_n(part, problem_->moving, X);
    std::copy_n(part + layout().parameters, problem_->sizes.parameters, X + problem_->moving);
}

void Model::put(const double* X, double* part) const {
    std::copy_n(X, problem_->moving, part);
    std::copy_n(X + problem_->moving, problem_->sizes.parameters, part + layout().parameters);
}

// The mean of the untruncated Gaussian at the present time of the part.
double* Model::expected_uncut(const double* flowed, const double* part, double* X) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    const double *S = flowed + at.S, *beyond = part + at.beyond;
    for (int i = 0; i < p.moving; ++i) {
        X[i] = flowed[i];
        for (int j = 0; j < p.N; ++j) X[i] += S[i * p.N + j] * beyond[j];
    }
    for (int i = p.moving; i < p.N; ++i) X[i] = part[at.parameters + i - p.moving] + beyond[i];
    return X;
}

// X, the mean of an untruncated Gaussian, becomes the mean of the truncated one; the part keeps the difference.
void Model::place(double* X, const double* P, double* part) const {
    const Problem& p = *problem_;
    double* beyond = part + layout().beyond;
    std::copy_n(X, p.N, beyond);
    std::copy_n(P, p.N * p.N, work_->cut);
    truncate(p.N, p.low, p.high, X, work_->cut);
    for (int i = 0; i < p.N; ++i) beyond[i] -= X[i];
}

// The logarithm is replaced by its parameter when the mean is too large.
double Model::to_unit(const State& s, int i) const {
    if (!is_log(i)) return 1;
    const double* part = s.x();
    const int N = problem_->N;
    return std::exp(part[layout().parameters + i - problem_->moving] + 0.5 * part[layout().P + i * N - i * (i - 1) / 2]);
}

// Parameters of a logarithm, with the moments of the Gaussian.
void Model::leave_logarithms(double* X, double* P) const {
    const Problem& p = *problem_;
    for (int i = p.moving; i < p.N; ++i) {
        if (!is_log(i)) continue;
        X[i] = std::exp(X[i] + 0.5 * P[i * p.N + i]);
        for (int j = 0; j < p.N; ++j) {
            if (j == i) continue;
            // Of two logarithms the first has been left already when the second is, to the first order.
            P[i * p.N + j] = P[j * p.N + i] *= X[i];
        }
        P[i * p.N + i] = X[i] * X[i] * std::expm1(P[i * p.N + i]);
    }
}

void Model::estimate(const State& s, double* X, double* sigma, double* P) const {
    const Problem& p = *problem_;
    fused(s, work_->x, work_->P);
    if (p.bounded) leave_logarithms(work_->x, work_->P);
    if (X) std::copy_n(work_->x, p.N, X);
    if (P) std::copy_n(work_->P, p.N * p.N, P);
    for (int i = 0; sigma && i < p.N; ++i) sigma[i] = std::sqrt(std::max(0.0, work_->P[i * p.N + i]));
}

} // namespace hnav::observer
