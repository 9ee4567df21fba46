#include "hybrid/propagator.hpp"

#include "base/memory.hpp"
#include "hybrid/sundials_memory.hpp"
#include "hybrid/sundials_names.hpp"
#include "hybrid/sundials_vector.hpp"

#include <cmath>
#include <cstdlib>
#include <cstring>

namespace hnav {
namespace {

using sundials::create_vector;
using sundials::data;
using sundials::real;
using sundials::stages_of_equal_steps;

} // namespace

struct Propagator::Solver {
    static constexpr ARKODE_ERKTableID method = ARKODE_DORMAND_PRINCE_7_4_5;

    SUNContext context = nullptr;
    N_Vector y = nullptr, inside = nullptr; // its present time; within the newest step
    void* erk = nullptr;
    void* equal_steps = nullptr; // ERKStep without error control
    double max_turn = 0; // of one of those steps, rad
    void* cv = nullptr;
    SUNNonlinearSolver iteration = nullptr;
    Propagator* owner = nullptr;
    const void* flow_context = nullptr;
    // An interval that is integrated step by step: its length, the time reached, the next step to be tried.
    double whole_s = 0, reached_s = 0, tried_s = 0;
    long steps_left = 0;

    static int rhs(real, N_Vector x, N_Vector dx, void* self) {
        auto* solver = static_cast<Solver*>(self);
        ++solver->owner->rhs_evals_;
        return solver->owner->flow_(solver->flow_context, data(x), data(dx));
    }

    bool create(const Settings& settings, int nx) {
        if (sundials::create_context(&context) != 0) return false;
        const bool sees_stages_alone = settings.integrator == Integrator::erkstep && !settings.looks_inside;
        const int read = sees_stages_alone ? settings.read : 0;
        y = create_vector(nx, read, context);
        N_Vector atol = create_vector(nx, read, context);
        if (settings.looks_inside) inside = create_vector(nx, read, context);
        bool ok = y && atol && (inside || !settings.looks_inside);
        if (ok) std::memcpy(data(atol), settings.atol, nx * sizeof(double));
        ok = ok && (settings.integrator == Integrator::erkstep ? create_erkstep(settings, atol) : create_adams(settings, atol));
        if (settings.integrator == Integrator::erkstep && settings.bounds_rate) ok = ok && create_equal_steps(settings);
        if (atol) N_VDestroy(atol);
        return ok;
    }

    bool create_erkstep(const Settings& settings, N_Vector atol) {
        // Without output between events, the constant interpolant saves an evaluation of f at the stop time. With output it
        // must be Hermite's: Lagrange's needs a history, and each interval begins without one.
        erk = settings.looks_inside ? create_erk(ARK_INTERP_HERMITE, 3) : create_erk(ARK_INTERP_LAGRANGE, 0);
        return erk && ERKStepSetTableNum(erk, method) == 0 && sundials::erk_tolerances(erk, settings.rtol, atol) == 0 &&
               sundials::erk_set_max_steps(erk, settings.max_steps) == 0;
    }

    void* create_erk(int interpolant, int degree) {
        void* memory = ERKStepCreate(rhs, 0, y, context);
        if (!memory) return nullptr;
        sundials::silence_erk(memory);
        const bool ok = sundials::erk_set_interpolant_type(memory, interpolant) == 0 &&
                        sundials::erk_set_interpolant_degree(memory, degree) == 0 &&
                        sundials::erk_set_user_data(memory, this) == 0;
        if (!ok) sundials::free_erk(&memory);
        return memory;
    }

    // The same method without its last stage, which only estimates the error. For an oscillation of w rad/s the estimate
    // would be 97/120000 (w h)^5 in a step h (the difference of the two stability functions), so rtol determines the largest
    // angle of a step.
    bool create_equal_steps(const Settings& settings) {
        constexpr double error_of_turn = 97.0 / 120000, largest_turn = 0.5;
        max_turn = std::fmin(largest_turn, std::pow(settings.rtol / error_of_turn, 0.2));
        ARKodeButcherTable table = without_error_estimate();
        // Its vectors are clones of y with the same operations.
        const auto norm = y->ops->nvwrmsnorm;
        y->ops->nvwrmsnorm = no_norm;
        equal_steps = create_erk(sundials::unused_interpolant, 0);
        y->ops->nvwrmsnorm = norm;
        const bool ok = table && equal_steps && ERKStepSetTable(equal_steps, table) == 0 &&
                        sundials::erk_set_fixed_step(equal_steps, 1) == 0 && sundials::erk_weights(equal_steps, no_weights) == 0;
        ARKodeButcherTable_Free(table);
        return ok;
    }

    static ARKodeButcherTable without_error_estimate() {
        constexpr int stages = stages_of_equal_steps;
        ARKodeButcherTable whole = ARKodeButcherTable_LoadERK(method);
        if (!whole) return nullptr;
        real A[stages * stages];
        for (int i = 0; i < stages; ++i)
            for (int j = 0; j < stages; ++j) A[i * stages + j] = whole->A[i][j];
        ARKodeButcherTable table = ARKodeButcherTable_Create(stages, whole->q, 0, whole->c, A, whole->b, nullptr);
        ARKodeButcherTable_Free(whole);
        return table;
    }

    // Without an error estimate no weights are needed: they stay zero.
    static int no_weights(N_Vector, N_Vector, void*) { return 0; }
    static real no_norm(N_Vector, N_Vector) { return 0; }

    bool create_adams(const Settings& settings, N_Vector atol) {
        cv = CVodeCreate(CV_ADAMS, context);
        if (!cv) return false;
        sundials::silence_cv(cv);
        if (CVodeInit(cv, rhs, 0, y) != 0) return false;
        iteration = SUNNonlinSol_FixedPoint(y, 0, context);
        return iteration && CVodeSetNonlinearSolver(cv, iteration) == 0 && CVodeSVtolerances(cv, settings.rtol, atol) == 0 &&
               CVodeSetMaxNumSteps(cv, settings.max_steps) == 0 && CVodeSetUserData(cv, this) == 0;
    }

    // From y at a time within an interval of this length, with the first step to be tried.
    int begin_at(double at_s, double first_step_s, double length_s) {
        int rc = sundials::erk_reset(erk, at_s, y);
        if (rc == 0) rc = sundials::erk_set_first_step(erk, first_step_s);
        return rc == 0 ? sundials::erk_set_stop_time(erk, length_s) : rc;
    }

    // The first trial step is the whole interval; at a hundred events a second it is also the last. Setting it each time
    // discards the step size of the interval before. The stop time prevents a step beyond the event.
    int evolve_erkstep(double interval_s, const double* x) {
        real reached = 0;
        int rc = begin_at(0, interval_s, interval_s);
        long before = 0, after = 0;
        sundials::erk_steps(erk, &before);
        if (rc == 0) rc = sundials::erk_evolve(erk, interval_s, y, &reached, ARK_NORMAL);
        if (rc == ARK_UNREC_RHSFUNC_ERR || rc == ARK_FIRST_RHSFUNC_ERR || rc == ARK_REPTD_RHSFUNC_ERR)
            rc = approach(interval_s, x);
        sundials::erk_steps(erk, &after);
        owner->steps_ += static_cast<std::uint64_t>(after >= before ? after - before : after);
        return rc;
    }

    // ERKStep fails where the flow returns no value, without reporting the time reached. The interval is therefore repeated
    // one step at a time, with half the step after each failure. x: at the beginning.
    int approach(double interval_s, const double* x) {
        constexpr double smallest = 1e-9;
        std::memcpy(data(y), x, owner->nx_ * sizeof(double));
        real reached_s = 0, tried_s = interval_s;
        long left = owner->max_steps_;
        while (tried_s > smallest * interval_s && left > 0) {
            tried_s *= 0.5;
            int rc = begin_at(reached_s, tried_s, interval_s);
            for (real t_s = reached_s; rc == 0 && left-- > 0;) {
                rc = sundials::erk_evolve(erk, interval_s, y, &t_s, ARK_ONE_STEP);
                if (rc < 0) break;
                reached_s = t_s;
                sundials::erk_next_step(erk, &tried_s);
            }
            if (reached_s >= interval_s) return 0;
        }
        return left > 0 ? ARK_RHSFUNC_FAIL : ARK_TOO_MUCH_WORK;
    }

    int begin_steps(double interval_s) {
        whole_s = tried_s = interval_s;
        reached_s = 0;
        steps_left = owner->max_steps_;
        return begin_at(0, interval_s, interval_s);
    }

    // One step; half of it after a failure of the flow. x: at its beginning, then at its end.
    int next_step(double* x) {
        constexpr double smallest = 1e-9;
        while (steps_left-- > 0) {
            real t_s = reached_s;
            const int rc = sundials::erk_evolve(erk, whole_s, y, &t_s, ARK_ONE_STEP);
            if (rc >= 0) {
                reached_s = t_s;
                sundials::erk_next_step(erk, &tried_s);
                ++owner->steps_;
                std::memcpy(x, data(y), owner->nx_ * sizeof(double));
                return 0;
            }
            const bool flow_failed = rc == ARK_UNREC_RHSFUNC_ERR || rc == ARK_FIRST_RHSFUNC_ERR || rc == ARK_REPTD_RHSFUNC_ERR;
            tried_s *= 0.5;
            if (!flow_failed) return rc;
            if (!(tried_s > smallest * whole_s)) return ARK_RHSFUNC_FAIL;
            std::memcpy(data(y), x, owner->nx_ * sizeof(double));
            if (begin_at(reached_s, tried_s, whole_s) < 0) return ARK_RHSFUNC_FAIL;
        }
        return ARK_TOO_MUCH_WORK;
    }

    // Number of equal steps for the turn of the interval; 0 if it is unknown or too large.
    int count_of_steps(double turn) const {
        constexpr int most = 8; // beyond this, error control chooses the steps
        if (!equal_steps || !(turn <= most * max_turn)) return 0;
        return turn <= max_turn ? 1 : static_cast<int>(std::ceil(turn / max_turn));
    }

    // Each step starts afresh: without its last stage the method has no slope to reuse.
    int evolve_in_steps(double interval_s, int count) {
        real reached = 0;
        int rc = sundials::erk_set_fixed_step(equal_steps, interval_s / count);
        for (int k = 0; k < count && rc >= 0; ++k) {
            rc = sundials::erk_reset(equal_steps, 0, y);
            if (rc == 0) rc = sundials::erk_evolve(equal_steps, interval_s, y, &reached, ARK_ONE_STEP);
        }
        owner->steps_ += static_cast<std::uint64_t>(count);
        return rc;
    }

    int evolve_adams(double interval_s) {
        real reached = 0;
        int rc = CVodeReInit(cv, 0, y);
        if (rc == 0) rc = CVodeSetStopTime(cv, interval_s);
        if (rc == 0) rc = CVode(cv, interval_s, y, &reached, CV_NORMAL);
        long steps = 0;
        CVodeGetNumSteps(cv, &steps);
        owner->steps_ += static_cast<std::uint64_t>(steps);
        return rc;
    }

    // x: the initial values of y.
    int evolve(double interval_s, double rate, const double* x) {
        if (!erk) return evolve_adams(interval_s);
        const int count = count_of_steps(rate * interval_s);
        return count > 0 ? evolve_in_steps(interval_s, count) : evolve_erkstep(interval_s, x);
    }

    ~Solver() {
        if (equal_steps) sundials::free_erk(&equal_steps);
        if (erk) sundials::free_erk(&erk);
        if (cv) CVodeFree(&cv);
        if (iteration) SUNNonlinSolFree(iteration);
        if (inside) N_VDestroy(inside);
        if (y) N_VDestroy(y);
        if (context) SUNContext_Free(&context);
    }
};

Propagator::~Propagator() {
    destroy_object(solver_);
    release_block(reserved_);
    std::free(slope_);
}

bool Propagator::create(int nx, Flow flow, const Settings& settings, const void* probe_context, const double* probe) {
    nx_ = nx;
    flow_ = flow;
    euler_step_s_ = settings.euler_step_s;
    max_steps_ = settings.max_steps;
    slope_ = static_cast<double*>(std::calloc(2 * nx, sizeof(double)));
    if (!slope_) return false;
    if (settings.integrator == Integrator::euler) return true;

    const std::size_t bytes = SundialsMemory::bytes(nx);
    reserved_ = take_block(bytes);
    solver_ = reserved_ ? make_object<Solver>() : nullptr;
    if (!solver_) return false;
    solver_->owner = this;
    const SundialsMemory memory(reserved_, bytes);
    if (!solver_->create(settings, nx)) return false;
    double* scratch = slope_ + nx;
    std::memcpy(scratch, probe, nx * sizeof(double));
    bool ok = integrate(probe_context, 1e-3, scratch) || (settings.may_be_stiff && out_of_steps_);
    if (ok && settings.bounds_rate) ok = integrate(probe_context, 1e-3, scratch, 0);
    set_counts(0, 0);
    return ok;
}

bool Propagator::integrate(const void* context, double interval_s, double* x, double rate_rad_s) {
    if (!solver_) return integrate_euler(context, interval_s, x);
    solver_->flow_context = context;
    std::memcpy(data(solver_->y), x, nx_ * sizeof(double));
    // Version 6.4 returns 0 at the stop time, version 7 returns 1: both are success.
    const int rc = solver_->evolve(interval_s, rate_rad_s, x);
    out_of_steps_ = rc < 0 && rc != ARK_RHSFUNC_FAIL;
    if (rc < 0) return false;
    std::memcpy(x, data(solver_->y), nx_ * sizeof(double));
    return true;
}

bool Propagator::begin(const void* context, double interval_s, const double* x) {
    if (!solver_ || !solver_->erk) return false;
    solver_->flow_context = context;
    std::memcpy(data(solver_->y), x, nx_ * sizeof(double));
    return solver_->begin_steps(interval_s) >= 0;
}

bool Propagator::step(double* reached_s, double* x) {
    const int rc = solver_->next_step(x);
    out_of_steps_ = rc < 0 && rc != ARK_RHSFUNC_FAIL;
    if (rc < 0) return false;
    *reached_s = solver_->reached_s;
    return true;
}

bool Propagator::between(double s, double* x) {
    if (sundials::erk_between(solver_->erk, s, 0, solver_->inside) < 0) return false;
    std::memcpy(x, data(solver_->inside), nx_ * sizeof(double));
    return true;
}

} // namespace hnav
