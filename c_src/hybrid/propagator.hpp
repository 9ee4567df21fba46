// Integrates a flow x' = f(x) over one interval between events.
//
// Every call starts afresh: no step size, order or history is kept. A state therefore consists of numbers only, and the same
// interval always gives the same bits. Memory is allocated in create alone.
#pragma once

#include <cstdint>
#include <limits>

namespace hnav {

enum class Integrator {
    // SUNDIALS ARKODE ERKStep, Dormand-Prince 5(4): equal steps if the rate of the flow determines their number, otherwise
    // error control with the interval as the first trial step
    erkstep,
    adams, // SUNDIALS CVODE, Adams-Moulton with fixed-point iteration
    euler // forward Euler in equal sub-steps, the source paper's method
};

class Propagator {
public:
    // f(context, x, dx): the flow, with the context passed to integrate. Returns 0; > 0: no value at this x, the solver tries
    // a smaller step; < 0: no value at all.
    using Flow = int (*)(const void* context, const double* x, double* dx);

    struct Settings {
        Integrator integrator = Integrator::erkstep;
        double rtol = 1e-8;
        const double* atol = nullptr; // nx values; read in create
        int read = 0; // the flow reads only the first so many numbers of x; 0: all
        bool bounds_rate = false; // integrate will be given the rate of the flow
        bool looks_inside = false; // begin, step and between will be called: erkstep only
        bool may_be_stiff = false; // create succeeds although the warm-up takes too many steps
        double euler_step_s = 0.005;
        // Largest number of steps of an interval: minutes of coasting at ten turns a second, computed in a fraction of a
        // second.
        long max_steps = 100000;
    };

    Propagator() = default;
    Propagator(const Propagator&) = delete;
    Propagator& operator=(const Propagator&) = delete;
    ~Propagator();

    // Also makes warm-up steps, because solvers allocate their last memory then. probe: a state at which the flow is defined.
    bool create(int nx, Flow flow, const Settings& settings, const void* probe_context, const double* probe);

    static constexpr double unknown_rate = std::numeric_limits<double>::infinity();

    // Advances x over interval_s > 0. False: too many steps, tolerances that cannot be met, or no value of the flow; x is
    // then invalid. rate_rad_s: of the fastest mode of the flow.
    bool integrate(const void* context, double interval_s, double* x, double rate_rad_s = unknown_rate);

    // The same step by step, for event detection within steps. begin: starts afresh at x. step: makes the next step, with x
    // at its end reached_s; the last one ends at interval_s; false as for integrate. between: x within the newest step by
    // cubic Hermite interpolation.
    bool begin(const void* context, double interval_s, const double* x);
    bool step(double* reached_s, double* x);
    bool between(double s, double* x);

    // Whether the newest integrate or step has failed for another reason than a missing value of the flow.
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
    void* reserved_ = nullptr; // contains the memory of SUNDIALS
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
