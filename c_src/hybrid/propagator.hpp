// Integrates a flow x' = f(x) over one interval between events.
//
// Every call starts afresh: no step size, order or history is carried over, so a state is numbers only and the same
// interval gives the same bits wherever and whenever it is integrated. Memory is taken in create alone.
#pragma once

#include <cstdint>
#include <limits>

namespace hnav {

enum class Integrator {
    // SUNDIALS ARKODE ERKStep, Dormand-Prince 5(4): equal steps where the rate of the flow gives their number, else with error
    // control, first trial step = the interval
    erkstep,
    adams, // SUNDIALS CVODE, Adams-Moulton with fixed-point iteration
    euler // forward Euler in equal sub-steps, the source paper's method
};

class Propagator {
public:
    // f(context, x, dx): the flow; context is what integrate was given. Answers 0; above: there is no flow at x, and the
    // solver tries a smaller step; below: there is none at all.
    using Flow = int (*)(const void* context, const double* x, double* dx);

    struct Settings {
        Integrator integrator = Integrator::erkstep;
        double rtol = 1e-8;
        const double* atol = nullptr; // nx values; read in create
        int read = 0; // the flow reads so many numbers of x, the first; 0: all
        bool bounds_rate = false; // integrate will be given the rate of the flow
        bool looks_inside = false; // begin, step and between will be called: erkstep only
        bool may_be_stiff = false; // create does not mind that the warm-up takes too many steps
        double euler_step_s = 0.005;
        // One interval takes no more: minutes of coasting at ten turns a second, a fraction of a second of computing.
        long max_steps = 100000;
    };

    Propagator() = default;
    Propagator(const Propagator&) = delete;
    Propagator& operator=(const Propagator&) = delete;
    ~Propagator();

    // Also makes warm-up steps, because solvers take their last memory then. probe: a state the flow is defined at.
    bool create(int nx, Flow flow, const Settings& settings, const void* probe_context, const double* probe);

    static constexpr double unknown_rate = std::numeric_limits<double>::infinity();

    // Advances x over interval_s > 0. False: more steps than one interval is worth, tolerances out
    // of reach, or no flow; x is then of no use. rate_rad_s: of the fastest mode of the flow.
    bool integrate(const void* context, double interval_s, double* x, double rate_rad_s = unknown_rate);

    // The same step by step, for whoever looks at what lies within them. begin: afresh at x. step: the next one, x at its end
    // reached_s, which is interval_s at last; false as for integrate. between: x within the newest step by the cubic of its ends
    // and slopes.
    bool begin(const void* context, double interval_s, const double* x);
    bool step(double* reached_s, double* x);
    bool between(double s, double* x);

    // Whether the newest integrate or step has failed for another reason than that the flow had no answer.
    bool out_of_steps() const { return out_of_steps_; }

    std::uint64_t rhs_evals() const { return rhs_evals_; }
    std::uint64_t steps() const { return steps_; }
    void set_counts(std::uint64_t rhs_evals, std::uint64_t steps) {
        rhs_evals_ = rhs_evals;
        steps_ = steps;
    }

private:
    struct Solver;
    bool integrate_euler(const void* context, double interval_s, double* x);

    Solver* solver_ = nullptr;
    void* reserved_ = nullptr; // what SUNDIALS made lies in it
    Flow flow_ = nullptr;
    int nx_ = 0;
    double euler_step_s_ = 0;
    long max_steps_ = 0;
    bool out_of_steps_ = false;
    double* slope_ = nullptr; // Euler's f(x)
    std::uint64_t rhs_evals_ = 0;
    std::uint64_t steps_ = 0;
};

} // namespace hnav
