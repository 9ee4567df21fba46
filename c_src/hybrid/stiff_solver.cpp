#include "hybrid/stiff_solver.hpp"

#include "base/memory.hpp"
#include "hybrid/sundials_memory.hpp"
#include "hybrid/sundials_names.hpp"

#include <cstring>

namespace hnav {

using sundials::real;

struct StiffSolver::Solver {
    static constexpr ARKODE_DIRKTableID method = ARKODE_ESDIRK43I6L2SA_6_3_4;
    static constexpr int most_failures = 30;

    SUNContext context = nullptr;
    N_Vector y = nullptr, inside = nullptr;
    SUNMatrix matrix = nullptr;
    SUNLinearSolver linear = nullptr;
    void* ark = nullptr;
    StiffSolver* owner = nullptr;
    Function flow = nullptr, jacobian = nullptr;
    const void* flow_context = nullptr;
    double* rows = nullptr; // n x n, row-major
    int n = 0;
    double whole_s = 0, reached_s = 0;
    long max_steps = 0, steps_left = 0;

    static double* data(N_Vector v) { return NV_DATA_S(v); }

    static int rhs(real s, N_Vector x, N_Vector dx, void* self) {
        auto* solver = static_cast<Solver*>(self);
        ++solver->owner->evaluations;
        return solver->flow(solver->flow_context, s, data(x), data(dx));
    }

    static int slopes(real s, N_Vector x, N_Vector, SUNMatrix J, void* self, N_Vector, N_Vector, N_Vector) {
        auto* solver = static_cast<Solver*>(self);
        const int answer = solver->jacobian(solver->flow_context, s, data(x), solver->rows);
        if (answer != 0) return answer;
        for (int i = 0; i < solver->n; ++i)
            for (int j = 0; j < solver->n; ++j) SM_ELEMENT_D(J, i, j) = solver->rows[i * solver->n + j];
        return 0;
    }

    bool create(const Settings& settings, const double* probe) {
        if (sundials::create_context(&context) != 0) return false;
        y = N_VNew_Serial(n, context);
        inside = N_VNew_Serial(n, context);
        N_Vector atol = N_VNew_Serial(n, context);
        matrix = SUNDenseMatrix(n, n, context);
        if (!y || !inside || !atol || !matrix) return false;
        std::memcpy(data(y), probe, n * sizeof(double));
        std::memcpy(data(atol), settings.atol, n * sizeof(double));
        const bool made = create_solver(settings.rtol, atol);
        N_VDestroy(atol);
        return made;
    }

    bool create_solver(double rtol, N_Vector atol) {
        linear = SUNLinSol_Dense(y, matrix, context);
        ark = ARKStepCreate(nullptr, rhs, 0, y, context);
        if (!linear || !ark) return false;
        sundials::silence_ark(ark);
        // Slopes of stiff states are inaccurate, so values alone are interpolated.
        constexpr int interpolant = ARK_INTERP_LAGRANGE, degree = 3;
        return ARKStepSetTableNum(ark, method, ARKODE_ERK_NONE) == 0 && sundials::ark_tolerances(ark, rtol, atol) == 0 &&
               sundials::ark_set_user_data(ark, this) == 0 && sundials::ark_set_interpolant_type(ark, interpolant) == 0 &&
               sundials::ark_set_interpolant_degree(ark, degree) == 0 &&
               sundials::ark_set_max_error_failures(ark, most_failures) == 0 &&
               sundials::ark_set_max_solver_failures(ark, most_failures) == 0 &&
               sundials::ark_set_linear_solver(ark, linear, matrix) == 0 && sundials::ark_set_jacobian(ark, slopes) == 0;
    }

    ~Solver() {
        if (ark) sundials::free_ark(&ark);
        if (linear) SUNLinSolFree(linear);
        if (matrix) SUNMatDestroy(matrix);
        if (inside) N_VDestroy(inside);
        if (y) N_VDestroy(y);
        if (context) SUNContext_Free(&context);
    }
};

StiffSolver::~StiffSolver() {
    if (solver_) {
        release_block(solver_->rows);
        destroy_object(solver_);
    }
    release_block(reserved_);
}

bool StiffSolver::create(int n, Function flow, Function jacobian, const Settings& settings, const void* probe_context,
                         const double* probe) {
    // Twice the memory of version 6.4: vectors of stages and work, the matrix and its factors.
    const std::size_t bytes = 64 * 1024 + (80 + 8 * static_cast<std::size_t>(n)) * n * sizeof(double);
    reserved_ = take_block(bytes);
    solver_ = reserved_ ? make_object<Solver>() : nullptr;
    if (!solver_) return false;
    solver_->rows = static_cast<double*>(take_block(static_cast<std::size_t>(n) * n * sizeof(double)));
    if (!solver_->rows) return false;
    solver_->owner = this;
    solver_->flow = flow;
    solver_->jacobian = jacobian;
    solver_->n = n;
    solver_->max_steps = settings.max_steps;
    const SundialsMemory memory(reserved_, bytes);
    if (!solver_->create(settings, probe)) return false;
    double reached_s = 0;
    if (begin(probe_context, 1e-3, probe)) step(&reached_s, solver_->rows);
    evaluations = steps = 0;
    return true;
}

// After a correction fast modes have to decay again: the solver itself finds the length of the first step.
bool StiffSolver::begin(const void* context, double interval_s, const double* x) {
    Solver& s = *solver_;
    s.flow_context = context;
    s.whole_s = interval_s;
    s.reached_s = 0;
    s.steps_left = s.max_steps;
    std::memcpy(Solver::data(s.y), x, s.n * sizeof(double));
    return sundials::ark_reset(s.ark, 0, s.y) == 0 && sundials::ark_set_first_step(s.ark, 0) == 0 &&
           sundials::ark_set_stop_time(s.ark, interval_s) == 0;
}

bool StiffSolver::step(double* reached_s, double* x) {
    Solver& s = *solver_;
    if (s.steps_left-- <= 0) return false;
    real t_s = s.reached_s;
    if (sundials::ark_evolve(s.ark, s.whole_s, s.y, &t_s, ARK_ONE_STEP) < 0) return false;
    ++steps;
    *reached_s = s.reached_s = t_s;
    std::memcpy(x, Solver::data(s.y), s.n * sizeof(double));
    return true;
}

bool StiffSolver::between(double s, double* x) {
    if (sundials::ark_between(solver_->ark, s, 0, solver_->inside) < 0) return false;
    std::memcpy(x, Solver::data(solver_->inside), solver_->n * sizeof(double));
    return true;
}

} // namespace hnav
