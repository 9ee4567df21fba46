// Integrates a stiff flow x' = f(s, x) over one interval between events, step by step: SUNDIALS ARKStep with an implicit method of
// order 4 and dense Jacobians. It is a method of one step: no history is lost at a sample, where BDF would begin at order 1. Of the
// ESDIRK tables of ARKODE it took by far the fewest steps on van der Pol's oscillator with mu = 1000 (46 over 100 s from a start off
// the slow motion, others 83 to 1800): its method and the method of its error both forget fast modes at once.
//
// Every call of begin starts afresh, so the same interval gives the same bits wherever and whenever it is integrated. Memory is
// taken in create alone.
#pragma once

#include "hybrid/propagator.hpp"

#include <cstdint>

namespace hnav {

class StiffSolver {
public:
    // n numbers, or n x n row-major, at s seconds from the beginning of the interval. Returns as Propagator::Flow does.
    using Function = int (*)(const void* context, double s, const double* x, double* out);

    struct Settings {
        double rtol = 1e-7;
        const double* atol = nullptr; // n values; read in create
        long max_steps = 20000; // of an interval
    };

    StiffSolver() = default;
    StiffSolver(const StiffSolver&) = delete;
    StiffSolver& operator=(const StiffSolver&) = delete;
    ~StiffSolver();

    // Also makes a first step, because solvers allocate their last memory then; its result is not used. probe: a state at
    // which the flow is defined.
    bool create(int n, Function flow, Function jacobian, const Settings& settings, const void* probe_context,
                const double* probe);

    // begin: starts afresh at x. step: makes the next step, with x at its end reached_s; the last one ends at interval_s;
    // false: failure, or too many steps. between: x within the newest step.
    bool begin(const void* context, double interval_s, const double* x);
    bool step(double* reached_s, double* x);
    bool between(double s, double* x);

    std::uint64_t evaluations = 0, steps = 0; // of the flow; since create

private:
    struct Solver;
    Solver* solver_ = nullptr;
    void* reserved_ = nullptr; // contains the memory of SUNDIALS
};

// The propagator that this solver replaces counts its evaluations.
class CountedBy {
public:
    CountedBy(Propagator& propagator, const StiffSolver& solver)
        : propagator_(propagator), solver_(solver), evaluations_(solver.evaluations), steps_(solver.steps) {}
    ~CountedBy() {
        propagator_.set_counts(propagator_.rhs_evals() + solver_.evaluations - evaluations_, propagator_.steps() + steps());
    }
    CountedBy(const CountedBy&) = delete;
    CountedBy& operator=(const CountedBy&) = delete;

    std::uint64_t steps() const { return solver_.steps - steps_; }

private:
    Propagator& propagator_;
    const StiffSolver& solver_;
    const std::uint64_t evaluations_, steps_;
};

} // namespace hnav
