// An event of the filter: inputs, then the sensors of the instant together, in each part of the estimate.
#include "estimation/gate.hpp"
#include "estimation/mixture.hpp"
#include "estimation/readiness.hpp"
#include "observer/observer_model.hpp"

#include <algorithm>
#include <cmath>

namespace hnav::observer {
namespace {

constexpr double nis_window = 50; // samples
constexpr double min_mean_nis = 0.47; // 99.9 % of the means of 50 squared unit normals are above it
constexpr int samples_to_ready = 20, violations_to_fall = 3;
constexpr double sure_part = 0.99;
constexpr double samples_to_check = 8; // the usual change is then estimated
constexpr double stale_runs = 4; // usual runs of equal samples; further repetitions of a sensor with noise have one common error

// Whether the squared normalised innovations of a sensor have the mean of a chi-square: 99.9 % of the means of so many are below the upper limit
// (Wilson and Hilferty 1931).
bool is_consistent(double mean, double samples) {
    constexpr double quantile = 3.29;
    if (!(samples > 0)) return true;
    const double variance = 2 / (9 * std::fmin(samples, nis_window)), root = 1 - variance + quantile * std::sqrt(variance);
    return mean < root * root * root && (mean > min_mean_nis || samples < nis_window);
}

} // namespace

void Model::jump(State& s, const Event& event) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double* v = s.x();
    if (v[at.begun] != 0) collect_all(s);
    if (event.begins_time_base() && v[at.begun] != 0) forget_time(s);
    v[at.t] = event.t_s;
    const bool begins =
        v[at.begun] == 0 && (options_.start_mode == HNAV_OBSERVER_START_FIRST_SAMPLE || event.has(start_channel()));
    if (begins) v[at.begun] = 1;
    if (begins && crosses()) {
        expected(v, work_->x);
        if (!ask(plant_->recall(v + at.memory), Function::event, event.t_s, nullptr, 0) || !take_sides(s, v, event.t_s, work_->x))
            v[at.broken] = 1;
    }
    if (!take_inputs(s, event, begins)) v[at.broken] = 1;
    v[at.events] += 1;
    if (v[at.begun] == 0) return;
    for (int i = 0; i < p.sensors; ++i)
        if (event.has(sensor_channel(i))) {
            correct(s, event);
            break;
        }
    end_interval(s);
}

void Model::collect_all(State& s) const {
    const Layout& at = layout();
    double* v = s.x();
    const double interval_s = v[at.elapsed] + v[at.clock];
    open_joint(s);
    for (int i = 0; i < parts_of(s); ++i) {
        collect(s, part_of(s, i));
        part_of(s, i)[at.elapsed] = 0;
    }
    // The noise of an interval is estimated from intervals of about that length; two samples close together differ little.
    if (interval_s > 0) v[at.usual] = std::max(interval_s, 0.5 * v[at.usual]);
    note_course(s, interval_s);
}

// In a plant with events, new inputs are an event, and all inputs at the beginning.
bool Model::take_inputs(State& s, const Event& event, bool begins) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    bool any = begins && p.known > 0;
    for (int i = 0; i < p.known; ++i) {
        if (!event.has(i)) continue;
        s.x()[at.inputs + i] = *event.value(i);
        any = true;
    }
    if (!any || !crosses() || s.x()[at.begun] == 0) return true;
    for (int i = 0; i < parts_of(s); ++i) {
        Run run(s, 0, *work_);
        if (!jump_part(run, part_of(s, i), Cause::input, 1)) return false;
    }
    return true;
}

// Predicted outputs of the part and their derivatives.
bool Model::linearise(State& s, const Event& event, int i) const {
    const Problem& p = *problem_;
    const double* part = part_of(s, i);
    double *y = work_->y + i * p.sensors, *H = work_->H + i * p.sensors * p.N;
    if (remembers()) plant_->recall(part + layout().memory);
    const Point here = point(s, part, part);
    const Linearisation::Answers answer = work_->linearisation.linearise(*plant_, Function::outputs, here, y, H);
    if (!ask(answer.values, Function::outputs, here.t_s, nullptr, 0)) return false;
    for (int k = 0; k < p.sensors; ++k)
        if (event.has(sensor_channel(k)) && !ask(Answer::ok, Function::outputs, here.t_s, y + k, 1)) return false;
    if (!ask(answer.jacobian, Function::outputs, here.t_s, H, p.sensors * p.N)) return false;
    unpack_upper(part + layout().P, p.N, 1, work_->P);
    for (int k = 0; k < p.sensors; ++k) {
        if (!event.has(sensor_channel(k))) continue;
        const double* h = H + k * p.N;
        double variance = p.sensor_variance[k];
        for (int j = 0; j < p.N; ++j)
            for (int l = 0; l < p.N; ++l) variance += h[j] * work_->P[j * p.N + l] * h[l];
        double& nu = work_->nu[i * p.sensors + k];
        nu = *event.value(sensor_channel(k)) - y[k];
        for (int j = 0; p.bounded && j < p.N; ++j) nu -= h[j] * part[layout().beyond + j];
        work_->variance[i * p.sensors + k] = variance;
    }
    return true;
}

// Innovations with all of P, before any sensor has corrected; of several parts with the covariance of their mixture.
void Model::innovate(State& s, const Event& event) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double* v = s.x();
    for (int k = 0; k < p.sensors; ++k) {
        if (!event.has(sensor_channel(k))) continue;
        double innovation = work_->nu[k], variance = work_->variance[k];
        if (parts_of(s) > 1) {
            double squares = innovation = 0;
            for (int i = 0; i < parts_of(s); ++i) {
                const double w = part_of(s, i)[at.weight], nu = work_->nu[i * p.sensors + k];
                innovation += w * nu;
                squares += w * (work_->variance[i * p.sensors + k] + nu * nu);
            }
            variance = squares - innovation * innovation;
        }
        const double nis = innovation * innovation / variance;
        v[at.of_sensor(k, Layout::innovation)] = innovation;
        v[at.of_sensor(k, Layout::innovation_sigma)] = std::sqrt(variance);
        v[at.of_sensor(k, Layout::nis)] = nis;
        // A NIS that overflows would stay in every later mean.
        if (!std::isfinite(nis)) v[at.broken] = 1;
    }
}

// The duration of setting a clock is unknown: process noise for as long as the limit of a jump, and the plant has flowed about
// one interval more or less.
void Model::forget_time(State& s) const {
    const Problem& p = *problem_;
    const double usual_s = s.x()[layout().usual];
    double *P = work_->P, *dX = work_->slope_here;
    for (int i = 0; i < parts_of(s); ++i) {
        double* part = part_of(s, i);
        if (remembers()) plant_->recall(part + layout().memory);
        expected(part, work_->x);
        if (!slope(s, s.x()[layout().t], work_->x, dX)) std::fill_n(dX, p.N, 0.0);
        unpack_upper(part + layout().P, p.N, 1, P);
        for (int j = 0; j < p.N; ++j) {
            P[j * p.N + j] += options_.time_jump_limit_s * p.noise[j];
            for (int k = 0; k < p.N; ++k) P[j * p.N + k] += usual_s * dX[j] * usual_s * dX[k];
        }
        pack_upper(P, p.N, part + layout().P);
    }
}

// Factor on the variance of a sample from the history of its sensor; infinite: rejected. An outlier deviates from the previous
// sample, in sigmas of the sensor and in usual changes, and from the prediction. A sensor is stuck if it repeats a value while
// the plant moves away from that value. If a sensor with noise repeats a value for longer than its resolution explains, its
// samples have one common error: the weights 1/(1 + n)^2 of the repetitions sum to 0.64, those of 1/(1 + n) to infinity, and a slow
// plant would be held at the value.
double Model::variance_factor(State& s, const Event& event, int k) const {
    const Layout& at = layout();
    double* v = s.x();
    Check& health = check(s, k);
    const Check::Vector y(*event.value(sensor_channel(k)));
    const double sigma = std::sqrt(problem_->sensor_variance[k]), limit = options_.outlier_sigma;
    double &repeats = v[at.of_sensor(k, Layout::repeats)], &usual = v[at.of_sensor(k, Layout::usual_repeats)];
    const double samples = v[at.of_sensor(k, Layout::samples)], nis = v[at.of_sensor(k, Layout::nis)];
    const bool unlikely = limit > 0 && samples >= samples_to_check && nis > limit * limit;
    if (samples > 0) health.note_course(y);
    const bool again = samples > 0 && y[0] == health.last[0];
    if (!again && repeats > 0) usual += 0.2 * (repeats - usual);
    repeats = again ? repeats + 1 : 0;
    const bool moves = std::fabs(v[at.of_sensor(k, Layout::innovation)]) > sigma;
    const SensorCheckSettings<double> settings{unlikely ? limit * sigma : HUGE_VAL, 0, HUGE_VAL};
    if (health.examine(settings, y, v[at.usual], event.t_s, moves, health.has_noise())) {
        ++health.left_out;
        return HUGE_VAL;
    }
    const double stale = health.has_noise() ? repeats - stale_runs * (1 + usual) : 0;
    return stale > 0 ? (1 + stale) * (1 + stale) : 1;
}

// Factors on the variances of the sensors, and the mean of the NIS.
void Model::gate(State& s, const Event& event, double* inflation) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double* v = s.x();
    for (int k = 0; k < p.sensors; ++k) {
        if (!event.has(sensor_channel(k))) continue;
        double nis = v[at.of_sensor(k, Layout::nis)];
        inflation[k] = variance_factor(s, event, k);
        if (std::isinf(inflation[k])) continue;
        if (const double beyond = beyond_gate(nis, p.gate_nis[k]); beyond > 1 && v[at.ready] != 0) {
            inflation[k] *= beyond;
            v[at.of_sensor(k, Layout::gated)] += 1;
            nis = p.gate_nis[k];
        }
        double& samples = v[at.of_sensor(k, Layout::samples)];
        double& mean = v[at.of_sensor(k, Layout::mean_nis)];
        samples += 1;
        mean += (nis - mean) / std::min(samples, nis_window);
    }
}

void Model::correct(State& s, const Event& event) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double *v = s.x(), *before = work_->gain + 2 * p.N, inflation[max_channels_used];
    forget(s);
    for (int i = 0; i < parts_of(s); ++i)
        if (!linearise(s, event, i)) {
            v[at.broken] = 1;
            return;
        }
    innovate(s, event);
    if (v[at.broken] != 0) return;
    const bool several = parts_of(s) > 1; // of a single part P is in the workspace, first as unpacked, then as corrected
    if (several) fused(s, work_->x, work_->P);
    for (int i = 0; i < p.N; ++i) before[i] = work_->P[i * p.N + i];
    gate(s, event, inflation);
    double likelihood[max_parts];
    for (int i = 0; i < parts_of(s); ++i) likelihood[i] = correct_part(s, event, i, inflation);
    v[at.likelihood] = likelihood[0];
    v[at.corrections] += 1;
    if (several) {
        Parts parts = parts_in(s);
        v[at.likelihood] = mixture::reweigh(parts, likelihood);
        mixture::prune(parts, smallest_weight);
        mixture::merge_alike(parts);
        keep(s, parts);
        fused(s, work_->x, work_->P);
    }
    judge(s, before);
}

// A second correction at one instant does not inflate P again.
void Model::forget(State& s) const {
    const Layout& at = layout();
    double* v = s.x();
    const double since_s = v[at.corrections] > 0 ? v[at.t] - v[at.corrected] : 0;
    v[at.corrected] = v[at.t];
    if (options_.robust_rate_1_s > 0 && since_s > 0)
        for (int i = 0; i < parts_of(s); ++i) inflate(part_of(s, i), since_s);
}

// The robust inflation of the HREKF (estimation/robust_law.hpp): P becomes (P^-1 - theta L'L)^-1, L the inverse scales, and
// theta such that the largest variance of L P L' grows by exp(rate T). Each row of L is applied as an inverse correction; the
// added matrix is positive semidefinite. A state whose sigma is not below its scale has nothing to forget and no row: without this, one
// that no sensor observes grows without end, and theta, which its variance divides, forgets nothing of the others.
void Model::inflate(double* part, double since_s) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double *P = work_->P, *column = work_->gain, *L = work_->gain + 2 * p.N;
    constexpr double most = 0.95;
    unpack_upper(part + at.P, p.N, 1, P);
    for (int i = 0; i < p.N; ++i) L[i] = P[i * p.N + i] < p.scale[i] * p.scale[i] ? 1 / p.scale[i] : 0;
    const double largest = largest_variance(P, L, work_->gain, work_->gain + p.N);
    if (!(largest > 0)) return;
    const double theta = std::min(most, -std::expm1(-options_.robust_rate_1_s * since_s)) / largest;
    for (int i = 0; i < p.N; ++i) {
        const double weight = theta * L[i] * L[i], left = 1 - weight * P[i * p.N + i];
        if (!(weight > 0 && left > 0)) continue; // left: rounding
        for (int j = 0; j < p.N; ++j) column[j] = P[j * p.N + i];
        for (int j = 0; j < p.N; ++j)
            for (int k = 0; k < p.N; ++k) P[j * p.N + k] += column[j] * column[k] * weight / left;
    }
    pack_upper(P, p.N, part + at.P);
}

// The largest eigenvalue of L P L', from below, by power iteration from a vector that no symmetry of P makes orthogonal to its direction.
// L: its diagonal.
double Model::largest_variance(const double* P, const double* L, double* vector, double* next) const {
    const Problem& p = *problem_;
    constexpr int powers = 40;
    constexpr double golden = 0.6180339887498949;
    double largest = 0, length = 1;
    for (int i = 0; i < p.N; ++i) vector[i] = std::fmod((i + 1) * golden, 1.0) - 0.5;
    for (int k = 0; k < powers && length > 0; ++k) {
        double sum = 0;
        for (int i = 0; i < p.N; ++i) {
            next[i] = 0;
            for (int j = 0; j < p.N; ++j) next[i] += P[i * p.N + j] * L[i] * L[j] * vector[j];
            sum += next[i] * next[i];
        }
        largest = length = std::sqrt(sum);
        for (int i = 0; i < p.N && length > 0; ++i) vector[i] = next[i] / length;
    }
    for (int i = 0; i < p.N; ++i) largest = std::max(largest, P[i * p.N + i] * L[i] * L[i]);
    return largest;
}

// The sensors of an instant correct one after the other with one linearisation, which equals a joint correction because their
// noises are independent. Returns the logarithm of their likelihood.
double Model::correct_part(State& s, const Event& event, int i, const double* inflation) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double *part = part_of(s, i), *X = work_->x, *moved = work_->gain + p.N;
    unpack_upper(part + at.P, p.N, 1, work_->P);
    std::fill_n(moved, p.N, 0.0);
    expected(part, X);
    double likelihood = 0;
    for (int k = 0; k < p.sensors; ++k) {
        if (!event.has(sensor_channel(k)) || std::isinf(inflation[k])) continue;
        const double* h = work_->H + (i * p.sensors + k) * p.N;
        double nu = work_->nu[i * p.sensors + k], variance = p.sensor_variance[k];
        for (int j = 0; j < p.N; ++j) nu -= h[j] * moved[j];
        if (inflation[k] != 1) variance *= inflation[k];
        correct_joint(part, work_->P, h, nu, variance);
        const double S = correct_by(work_->P, moved, h, nu, variance);
        likelihood -= 0.5 * (nu * nu / S + std::log(2 * M_PI * S));
    }
    for (int j = 0; j < p.N; ++j) X[j] += moved[j];
    if (p.bounded) {
        for (int j = 0; j < p.N; ++j) X[j] += part[at.beyond + j];
        place(X, work_->P, part);
    }
    if (remembers()) plant_->recall(part + at.memory);
    pull_back(s, part, X, work_->P);
    pack_upper(work_->P, p.N, part + at.P);
    if (crosses()) {
        const Inside inside = put_inside(s, part, s.x()[at.t], X, work_->P);
        if (inside != Inside::was) s.x()[at.counts + Layout::projected] += 1;
        if (inside == Inside::failed) s.x()[at.broken] = 1;
    }
    put(X, part);
    if (crosses() && !settle(s, part)) s.x()[at.broken] = 1;
    return likelihood;
}

// A plant accepts corrected parameters at an event only; its states stay those of the correction.
bool Model::settle(State& s, double* part) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    if (p.sizes.parameters == 0 || p.sizes.memory == 0) return true;
    expected(part, work_->probe);
    const Point here = point_of(s, s.x()[at.t], work_->probe);
    plant_->recall(part + at.memory);
    if (!ask(plant_->event(here, work_->x, part + at.next_event), Function::event, here.t_s, nullptr, 0)) return false;
    return ask(plant_->remember(part + at.memory), Function::event, here.t_s, nullptr, 0);
}

// One sensor, Joseph form: P = (I - K h) P (I - K h)' + K R K'. Returns the variance of the innovation.
double Model::correct_by(double* P, double* moved, const double* h, double innovation, double variance) const {
    const int N = problem_->N;
    double* Ph = work_->gain;
    times_rows(P, N, N, h, Ph);
    double S = variance;
    for (int i = 0; i < N; ++i) S += h[i] * Ph[i];
    double* K = work_->product;
    for (int i = 0; i < N; ++i) K[i] = Ph[i] / S;
    for (int i = 0; i < N; ++i) moved[i] += K[i] * innovation;
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) P[i * N + j] -= K[i] * Ph[j];
    times_rows(P, N, N, h, Ph);
    for (int i = 0; i < N; ++i)
        for (int j = i; j < N; ++j) {
            P[i * N + j] += (variance * K[i] - Ph[i]) * K[j];
            P[j * N + i] = P[i * N + j];
        }
    return S;
}

// Ready: every sigma is below its limit with as much information as that limit corresponds to, the NIS is consistent, and one
// part has a weight above sure_part. Three corrections that violate this end it.
void Model::judge(State& s, const double* before) const {
    const Problem& p = *problem_;
    const Layout& at = layout();
    double* v = s.x();
    const bool earned = gather_information(s, before);
    bool ready = earned && v[at.holds] == 0 && parts(s).largest > sure_part && is_below_limits(s);
    double all = 0;
    for (int i = 0; i < p.sensors; ++i) {
        const double samples = v[at.of_sensor(i, Layout::samples)];
        all += samples;
        ready = ready && is_consistent(v[at.of_sensor(i, Layout::mean_nis)], samples);
    }
    ready = ready && all >= samples_to_ready;
    v[at.violations] = ready ? 0 : v[at.violations] + 1;
    v[at.ready] = ready || (v[at.ready] != 0 && v[at.violations] < violations_to_fall);
}

// After events that the covariance has not passed: not ready until new samples show that the estimate is right.
void Model::earn_again(State& s) const {
    const Layout& at = layout();
    double* v = s.x();
    v[at.ready] = 0;
    for (int i = 0; i < problem_->sensors; ++i) {
        double& samples = v[at.of_sensor(i, Layout::samples)];
        samples = std::min(samples, 1.0);
    }
}

// Adds the information that a correction brought. before: the variances before it. True: all that the limits need has been gathered.
bool Model::gather_information(State& s, const double* before) const {
    const Problem& p = *problem_;
    bool enough = true;
    for (int i = 0; i < p.N; ++i) {
        const double after = work_->P[i * p.N + i], sigma = p.ready_sigma[i] / to_unit(s, i);
        double& information = s.x()[layout().information + i];
        information += information_gained(before[i], after);
        enough = enough && (std::isinf(sigma) || is_earned(information, sigma));
    }
    return enough;
}

// From the covariance in the workspace.
bool Model::is_below_limits(const State& s) const {
    const Problem& p = *problem_;
    for (int i = 0; i < p.N; ++i) {
        const double sigma = p.ready_sigma[i] / to_unit(s, i);
        if (!(work_->P[i * p.N + i] < sigma * sigma)) return false;
    }
    return true;
}

bool Model::ready(const State& s) const {
    if (s.x()[layout().ready] == 0) return false;
    fused(s, work_->x, work_->P);
    return is_below_limits(s);
}

} // namespace hnav::observer
