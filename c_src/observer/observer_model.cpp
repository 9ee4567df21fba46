#include "observer/observer_model.hpp"

#include <algorithm>
#include <cmath>

namespace hnav::observer {
namespace {

constexpr double nis_window = 50; // samples
// 99.9 % of the mean of 50 squares of unit normals lies within.
constexpr double min_mean_nis = 0.47, max_mean_nis = 1.79;
constexpr int samples_to_ready = 20, doubts_to_fall = 3;

void unpack_upper(const double* upper, int n, double factor, double* full) {
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) full[i * n + j] = full[j * n + i] = factor * *upper++;
}

void pack_upper(const double* full, int n, double* upper) {
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) *upper++ = full[i * n + j];
}

} // namespace

Workspace::Workspace(Arena& arena, const Problem& p)
    : linearisation(arena, p),
      x(arena.doubles(p.N)),
      u(arena.doubles(p.sizes.inputs)),
      A(arena.doubles(p.moving * p.N)),
      Qd(arena.doubles(p.N * p.N)),
      product(arena.doubles(p.N * p.N)),
      H(arena.doubles(p.sensors * p.N)),
      y(arena.doubles(p.sensors)),
      gain(arena.doubles(3 * p.N)),
      P(arena.doubles(p.N * p.N)) {}

void Model::begin(State& s) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    double* v = s.x();
    std::copy_n(p.start, p.moving, v);
    for (int i = 0; i < p.moving; ++i) v[at.S + i * p.N + i] = 1;
    std::copy_n(p.start + p.moving, p.sizes.parameters, v + at.parameters);
    double* variance = v + at.P;
    for (int i = 0; i < p.N; variance += p.N - i++) *variance = p.start_variance[i];
    std::copy_n(p.input_start, p.known, v + at.inputs);
    v[at.usual] = 1;
}

bool Model::plausible(const State& s) const {
    const Layout at = layout();
    const double* v = s.x();
    if (v[at.broken] != 0) return false;
    const double* P = v + at.P;
    double sum = 0;
    for (int i = 0; i < Layout::triangle(problem_->N); ++i) sum += std::fabs(P[i]);
    if (!std::isfinite(sum)) return false;
    for (int i = 0; i < problem_->N; P += problem_->N - i++)
        if (*P < 0) return false;
    return true;
}

// ------------------------------------------------------------------------------------------------ flow

// Whether the plant has answered, with numbers; keeps what was wrong.
bool Model::ask(Answer answer, Function function, double t_s, const double* values, int count) const {
    bool fine = answer == Answer::ok;
    for (int i = 0; fine && i < count; ++i) fine = std::isfinite(values[i]);
    if (!fine) work_->trouble = {true, function, answer, t_s};
    return fine;
}

Point Model::point(const State& s, const double* x) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    std::copy_n(s.x() + at.inputs, p.known, work_->u);
    std::copy_n(x + p.n, p.sizes.unknown_inputs, work_->u + p.known);
    return {s.x()[at.t] + x[at.clock], x, work_->u, s.x() + at.parameters};
}

int Model::flow(const State& s, const double* x, double* dx) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    work_->asked = true;
    for (int i = 0; i < p.moving; ++i)
        if (!std::isfinite(x[i])) return int(Answer::elsewhere);
    const Point here = point(s, x);
    Answer answer = plant_->evaluate(Function::derivatives, here, dx);
    if (!ask(answer, Function::derivatives, here.t_s, dx, p.n)) return int(answer == Answer::ok ? Answer::elsewhere : answer);
    for (int i = 0; i < p.sizes.unknown_inputs; ++i) dx[p.n + i] = -p.decay_1_s[i] * x[p.n + i];

    answer = work_->linearisation.jacobian(*plant_, Function::derivatives, here, work_->A);
    if (!ask(answer, Function::derivatives, here.t_s, work_->A, p.n * p.N))
        return int(answer == Answer::ok ? Answer::elsewhere : answer);
    flow_of_matrices(s.x()[at.usual], x, dx);
    dx[at.clock] = 1;
    return 0;
}

void Model::flow_of_matrices(double usual_s, const double* x, double* dx) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    double *A = work_->A, *Qd = work_->Qd, *product = work_->product;
    for (int i = p.n; i < p.moving; ++i) {
        std::fill_n(A + i * p.N, p.N, 0.0);
        A[i * p.N + i] = -p.decay_1_s[i - p.n];
    }
    // Rows of the product with the moving rows of a matrix whose other rows do not move.
    const auto multiply = [&](const double* with, const double* row, double* out) {
        std::fill_n(out, p.N, 0.0);
        for (int k = 0; k < p.moving; ++k)
            for (int j = 0; j < p.N; ++j) out[j] += row[k] * with[k * p.N + j];
    };
    unpack_upper(x + at.Qd, p.N, 1, Qd);
    for (int i = 0; i < p.moving; ++i) {
        double *row = A + i * p.N, *dS = dx + at.S + i * p.N, *AQ = product + i * p.N;
        multiply(x + at.S, row, dS);
        multiply(Qd, row, AQ);
        for (int k = p.moving; k < p.N; ++k) {
            dS[k] += row[k];
            for (int j = 0; j < p.N; ++j) AQ[j] += row[k] * Qd[k * p.N + j];
        }
    }
    double* dQ = dx + at.Qd;
    for (int i = 0; i < p.N; ++i)
        for (int j = i; j < p.N; ++j) {
            double sum = i < p.moving ? product[i * p.N + j] : 0;
            if (j < p.moving) sum += product[j * p.N + i];
            *dQ++ = i == j ? sum + p.noise[i] / usual_s : sum;
        }
}

void Model::nominal(double* x) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    const double ratio = settings_.covariance_rtol / settings_.rtol;
    std::copy_n(p.scale, p.moving, x);
    for (int i = 0; i < p.moving; ++i)
        for (int j = 0; j < p.N; ++j) x[at.S + i * p.N + j] = ratio * p.scale[i] / p.scale[j];
    double* Qd = x + at.Qd;
    for (int i = 0; i < p.N; ++i)
        for (int j = i; j < p.N; ++j) *Qd++ = ratio * p.noise_scale[i] * p.noise_scale[j];
    x[at.clock] = 1;
}

// ------------------------------------------------------------------------------------------------ covariance

// P of what is shown: Phi P Phi' + Qd.
void Model::covariance(const State& s, double* P) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    const double *v = s.x(), *S = v + at.S;
    double *held = work_->Qd, *product = work_->product;
    unpack_upper(v + at.P, p.N, 1, held);
    for (int i = 0; i < p.N; ++i) {
        double* row = product + i * p.N;
        if (i >= p.moving) {
            std::copy_n(held + i * p.N, p.N, row);
            continue;
        }
        std::fill_n(row, p.N, 0.0);
        for (int k = 0; k < p.N; ++k)
            for (int j = 0; j < p.N; ++j) row[j] += S[i * p.N + k] * held[k * p.N + j];
    }
    unpack_upper(v + at.Qd, p.N, v[at.usual], P);
    for (int i = 0; i < p.N; ++i)
        for (int j = i; j < p.N; ++j) {
            double sum = j < p.moving ? 0 : product[i * p.N + j];
            if (j < p.moving)
                for (int k = 0; k < p.N; ++k) sum += product[i * p.N + k] * S[j * p.N + k];
            P[i * p.N + j] += sum;
            P[j * p.N + i] = P[i * p.N + j];
        }
}

// What has flowed goes into P, and the next interval begins.
void Model::collect(State& s) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    double* v = s.x();
    covariance(s, work_->P);
    pack_upper(work_->P, p.N, v + at.P);
    std::fill(v + at.S, v + at.clock, 0.0);
    for (int i = 0; i < p.moving; ++i) v[at.S + i * p.N + i] = 1;
    // The noise of an interval is judged by that of one about as long; two samples that are nearly one change little.
    if (v[at.clock] > 0) v[at.usual] = std::max(v[at.clock], 0.5 * v[at.usual]);
    v[at.clock] = 0;
}

void Model::expected(const State& s, double* X) const {
    std::copy_n(s.x(), problem_->moving, X);
    std::copy_n(s.x() + layout().parameters, problem_->sizes.parameters, X + problem_->moving);
}

void Model::estimate(const State& s, double* X, double* sigma, double* P) const {
    const Problem& p = *problem_;
    if (X) expected(s, X);
    covariance(s, work_->P);
    if (P) std::copy_n(work_->P, p.N * p.N, P);
    for (int i = 0; sigma && i < p.N; ++i) sigma[i] = std::sqrt(std::max(0.0, work_->P[i * p.N + i]));
}

// ------------------------------------------------------------------------------------------------ events

void Model::jump(State& s, const Event& event) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    double* v = s.x();
    if (v[at.begun] != 0) collect(s);
    v[at.t] = event.t_s;
    if (settings_.start_at_first_sample || event.has(start_channel())) v[at.begun] = 1;
    for (int i = 0; i < p.known; ++i)
        if (event.has(i)) v[at.inputs + i] = *event.value(i);
    v[at.events] += 1;
    if (v[at.begun] == 0) return;
    for (int i = 0; i < p.sensors; ++i)
        if (event.has(sensor_channel(i))) return correct(s, event);
}

// Innovations by all of P, before any sensor has acted.
void Model::innovate(State& s, const Event& event) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    double* v = s.x();
    for (int i = 0; i < p.sensors; ++i) {
        if (!event.has(sensor_channel(i))) continue;
        const double* h = work_->H + i * p.N;
        double variance = p.sensor_variance[i];
        for (int j = 0; j < p.N; ++j)
            for (int k = 0; k < p.N; ++k) variance += h[j] * work_->P[j * p.N + k] * h[k];
        const double innovation = *event.value(sensor_channel(i)) - work_->y[i];
        const double nis = innovation * innovation / variance;
        v[at.of_sensor(i, Layout::innovation)] = innovation;
        v[at.of_sensor(i, Layout::innovation_sigma)] = std::sqrt(variance);
        v[at.of_sensor(i, Layout::nis)] = nis;
        // One that is beyond all numbers would stay in every mean.
        if (!std::isfinite(nis)) v[at.broken] = 1;
    }
}

// The sensors of an instant act one after the other on one linearisation, which is what all of them together do: their noises
// are independent.
void Model::correct(State& s, const Event& event) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    double* v = s.x();
    const Point here = point(s, v);
    bool fine = ask(plant_->evaluate(Function::outputs, here, work_->y), Function::outputs, here.t_s, nullptr, 0);
    for (int i = 0; i < p.sensors && fine; ++i)
        if (event.has(sensor_channel(i))) fine = ask(Answer::ok, Function::outputs, here.t_s, work_->y + i, 1);
    if (fine)
        fine = ask(work_->linearisation.jacobian(*plant_, Function::outputs, here, work_->H), Function::outputs, here.t_s,
                   work_->H, p.sensors * p.N);
    if (!fine) {
        v[at.broken] = 1;
        return;
    }
    unpack_upper(v + at.P, p.N, 1, work_->P);
    innovate(s, event);
    if (v[at.broken] != 0) return;
    double *X = work_->x, *moved = work_->gain + p.N, *before = work_->gain + 2 * p.N;
    std::fill_n(moved, p.N, 0.0);
    v[at.likelihood] = 0;
    for (int i = 0; i < p.N; ++i) before[i] = work_->P[i * p.N + i];
    expected(s, X);
    for (int i = 0; i < p.sensors; ++i) {
        if (!event.has(sensor_channel(i))) continue;
        const double* h = work_->H + i * p.N;
        double nu = v[at.of_sensor(i, Layout::innovation)], nis = v[at.of_sensor(i, Layout::nis)];
        for (int j = 0; j < p.N; ++j) nu -= h[j] * moved[j];
        double variance = p.sensor_variance[i];
        if (p.gate_nis[i] > 0 && nis > p.gate_nis[i] && v[at.ready] != 0) {
            variance *= nis / p.gate_nis[i];
            v[at.of_sensor(i, Layout::gated)] += 1;
            nis = p.gate_nis[i];
        }
        const double S = correct_by(work_->P, moved, h, nu, variance);
        v[at.likelihood] -= 0.5 * (nu * nu / S + std::log(2 * M_PI * S));
        double& samples = v[at.of_sensor(i, Layout::samples)];
        double& mean = v[at.of_sensor(i, Layout::mean_nis)];
        samples += 1;
        mean += (nis - mean) / std::min(samples, nis_window);
    }
    for (int i = 0; i < p.N; ++i) X[i] += moved[i];
    std::copy_n(X, p.moving, v);
    std::copy_n(X + p.moving, p.sizes.parameters, v + at.parameters);
    pack_upper(work_->P, p.N, v + at.P);
    v[at.corrections] += 1;
    judge(s, before);
}

// One sensor, Joseph's form: P = (I - K h) P (I - K h)' + K R K'. Answers the variance of the innovation.
double Model::correct_by(double* P, double* moved, const double* h, double innovation, double variance) const {
    const int N = problem_->N;
    double* Ph = work_->gain;
    const auto times_h = [&] {
        for (int i = 0; i < N; ++i) {
            Ph[i] = 0;
            for (int j = 0; j < N; ++j) Ph[i] += P[i * N + j] * h[j];
        }
    };
    times_h();
    double S = variance;
    for (int i = 0; i < N; ++i) S += h[i] * Ph[i];
    double* K = work_->product;
    for (int i = 0; i < N; ++i) K[i] = Ph[i] / S;
    for (int i = 0; i < N; ++i) moved[i] += K[i] * innovation;
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) P[i * N + j] -= K[i] * Ph[j];
    times_h();
    for (int i = 0; i < N; ++i)
        for (int j = i; j < N; ++j) {
            P[i * N + j] += (variance * K[i] - Ph[i]) * K[j];
            P[j * N + i] = P[i * N + j];
        }
    return S;
}

// Ready: every sigma below its limit, by evidence of at least as much as that limit stands for, and innovations as large
// as they are said to be. Three corrections that deny it make an end of it.
void Model::judge(State& s, const double* before) const {
    const Problem& p = *problem_;
    const Layout at = layout();
    double* v = s.x();
    bool ready = true;
    for (int i = 0; i < p.N; ++i) {
        const double after = work_->P[i * p.N + i], limit = p.ready_sigma[i] * p.ready_sigma[i];
        double& information = v[at.information + i];
        if (after > 0 && before[i] > after) information += 1 / after - 1 / before[i];
        if (std::isfinite(limit)) ready = ready && after < limit && information > 1 / limit;
    }
    for (int i = 0; i < p.sensors; ++i) {
        const double mean = v[at.of_sensor(i, Layout::mean_nis)], samples = v[at.of_sensor(i, Layout::samples)];
        if (samples > 0) ready = ready && samples >= samples_to_ready && mean > min_mean_nis && mean < max_mean_nis;
    }
    v[at.doubts] = ready ? 0 : v[at.doubts] + 1;
    v[at.ready] = ready || (v[at.ready] != 0 && v[at.doubts] < doubts_to_fall);
}

} // namespace hnav::observer
