// The observer as a model of Filter<Model>: between samples x, d, the moving rows S of their transition matrix and the noise
// that enters flow together, at a sample P = Phi P Phi' + Qd is corrected by all its sensors.
//
//   x' = f(t, x, u, d, theta),  S' = A [S; rest of I],  Qd' = A Qd + Qd A' + Q        A = d(x', d')/dX
//
// The flow does not know P, which stays positive semidefinite through the congruence; Phi and Qd have tolerances of their own.
#pragma once

#include "hybrid/model_concept.hpp"
#include "observer/linearisation.hpp"

namespace hnav::observer {

struct ModelSettings {
    bool start_at_first_sample = true;
    double rtol = 1e-7;            // of x; absolute tolerances are these times a scale
    double covariance_rtol = 1e-4; // of Phi and Qd
};

// Memory in which a model computes, and what it has to tell beside its state. One for each filter.
class Workspace {
public:
    // Counts on an arena without memory.
    Workspace(Arena& arena, const Problem& problem);

    Linearisation linearisation;
    double *x, *u, *A, *Qd, *product, *H, *y, *gain, *P; // N; inputs; moving x N; N x N twice; sensors x N; sensors; N; N x N

    struct Trouble {
        bool any;
        Function function;
        Answer answer; // ok: a number that is not finite
        double t_s;
    } trouble{};
    bool asked = false; // a flow has been asked for
};

class Model {
public:
    using Event = RuntimeEvent;
    using State = RuntimeState;
    static constexpr bool has_closed_form = false, knows_rate = false, reholds = false, turns_back = false;

    Model() = default;
    Model(Plant& plant, const Problem& problem, Workspace& work, const ModelSettings& settings)
        : plant_(&plant), problem_(&problem), work_(&work), settings_(settings) {}

    int nx() const { return layout().nx; }
    // Inputs, sensors, and the moment at which the estimate begins: so inputs of an instant act before its sensors.
    int channels() const { return start_channel() + 1; }
    int values() const { return 1; }
    int sensor_channel(int sensor) const { return problem_->known + sensor; }
    int start_channel() const { return problem_->known + problem_->sensors; }
    std::size_t state_bytes() const { return static_cast<std::size_t>(layout().numbers) * sizeof(double); }

    void begin(State& s) const;
    bool flows(const State& s) const { return s.x()[layout().begun] != 0; }
    bool plausible(const State& s) const;
    void normalise(State&) const {}
    void before_flow(State&, const Event&) const {}
    int flow(const State& s, const double* x, double* dx) const;
    void jump(State& s, const Event& event) const;
    void nominal(double* x) const;

    // N numbers each, of a state that may have flowed since its event; P is N x N. Null is not written.
    void estimate(const State& s, double* X, double* sigma, double* P) const;

    Layout layout() const { return Layout(*problem_); }
    const Problem& problem() const { return *problem_; }

private:
    Point point(const State& s, const double* x) const;
    void flow_of_matrices(double usual_s, const double* x, double* dx) const;
    void expected(const State& s, double* X) const;
    void covariance(const State& s, double* P) const;
    void collect(State& s) const;
    void correct(State& s, const Event& event) const;
    void innovate(State& s, const Event& event) const;
    double correct_by(double* P, double* moved, const double* h, double innovation, double variance) const;
    void judge(State& s, const double* before) const;
    bool ask(Answer answer, Function function, double t_s, const double* values, int count) const;

    Plant* plant_ = nullptr;
    const Problem* problem_ = nullptr;
    Workspace* work_ = nullptr;
    ModelSettings settings_{};
};

} // namespace hnav::observer
