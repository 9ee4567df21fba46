#include "observer/derivative_proof.hpp"

#include "base/hash.hpp"
#include "maths/finite.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>

namespace hnav::observer {
namespace {

constexpr int points = 4, other_points = 20;
constexpr double max_difference = 1e-10; // relative difference of repeated evaluations

// In (-1, 1), equal for equal k in every program.
double scattered(std::uint64_t k) {
    const std::uint64_t word = hash(&k, sizeof k);
    return static_cast<double>(word >> 11) * 0x1p-52 - 1;
}

// A row of numbers whose first, estimated ones can be scattered around the start.
struct Place {
    const Problem& problem;
    double *X, *u;

    Point at(double t_s, int scatter) const {
        for (int i = 0; i < problem.N; ++i) {
            const double sigma = std::sqrt(problem.start_variance[i]);
            const double width = sigma > 0 ? 3 * sigma : 1e-3 * problem.scale[i];
            X[i] = problem.start[i] + (scatter > 0 ? width * scattered(64 * scatter + i) : 0);
        }
        std::copy_n(problem.input_start, problem.known, u);
        std::copy_n(X + problem.n, problem.sizes.unknown_inputs, u + problem.known);
        return {t_s, X, u, X + problem.moving};
    }
};

bool answers_at_start(Plant& plant, const Problem& problem, const Point& start, double* values, Refusal& why) {
    for (const Function f : {Function::derivatives, Function::outputs}) {
        const char* name = f == Function::derivatives ? "derivatives" : "outputs";
        const Answer answer = plant.evaluate(f, start, values);
        if (answer != Answer::ok)
            return why.refuse(Refusal::plant, "the plant has no %s at the start, t = %g s: it answered %d%s%s", name, start.t_s,
                              int(answer), *plant.said() ? ": " : "", plant.said());
        for (int i = 0; i < problem.sizes.rows(f); ++i)
            if (!std::isfinite(values[i]))
                return why.refuse(Refusal::plant, "%s[%d] of the plant is %g at the start, t = %g s: give another start", name, i,
                                  values[i], start.t_s);
    }
    return true;
}

// Keeps the worst element over all points.
void compare(const Problem& problem, Function f, Variable v, const double* claimed, const double* measured, const double* values,
             double* worst, BlockProof* block) {
    const int first = problem.sizes.first(v), count = problem.sizes.count(v), N = problem.N;
    for (int i = 0; i < problem.sizes.rows(f); ++i) {
        double row = 0;
        for (int j = first; j < first + count; ++j) row += std::fabs(measured[i * N + j]) * problem.scale[j];
        for (int j = first; j < first + count; ++j) {
            const double a = claimed[i * N + j], b = measured[i * N + j];
            // Rounding of the differences: this part of the value is neglected.
            const double allowed =
                1e-4 * (std::fabs(a) + std::fabs(b)) + (1e-5 * row + 1e-9 * std::fabs(values[i])) / problem.scale[j];
            const double off = a == b ? 0 : std::isfinite(a) ? std::fabs(a - b) / allowed : HUGE_VAL;
            if (!(off > *worst)) continue;
            *worst = off;
            block->row = i;
            block->column = j;
            block->stated = a;
            block->measured = b;
        }
    }
}

struct Scratch {
    double *declared, *measured, *values;
};

// Differences must be zero where the plant declares that a derivative does not depend. A wrong declaration is not used, and is reported as
// the worst element of its block if the plant offers no right derivatives.
void prove_dependencies(Plant& plant, const Place& place, Linearisation& linearisation, double start_s, const Scratch& of,
                        DerivativeProof* proof) {
    const Problem& problem = place.problem;
    if (!plant.declares_dependencies()) return;
    bool right = true;
    for (const Variable v : {Variable::state, Variable::unknown_input}) {
        BlockProof wrong{};
        double worst = 0;
        for (int k = 0; k <= points; ++k) {
            const Point at = place.at(start_s, k);
            if (plant.evaluate(Function::derivatives, at, of.values) != Answer::ok || !all_finite(of.values, problem.n) ||
                linearisation.differences(plant, Function::derivatives, v, at, of.measured) != Answer::ok)
                continue;
            for (int i = 0; i < problem.n; ++i)
                for (int j = 0; j < problem.moving; ++j)
                    of.declared[i * problem.N + j] = plant.depends(i, j) ? of.measured[i * problem.N + j] : 0;
            compare(problem, Function::derivatives, v, of.declared, of.measured, of.values, &worst, &wrong);
        }
        if (worst <= 1) continue;
        right = false;
        wrong.offered = true;
        BlockProof& block = proof->block[int(Function::derivatives)][int(v)];
        if (!block.exact) block = wrong;
    }
    if (right) linearisation.use_dependencies(plant);
}

// The derivatives at the start, at other points, and at the start again. Plants with internal iterations agree to their
// tolerance, relative to the possible size of these derivatives.
void find_memory(Plant& plant, const Place& place, double start_s, double* values, double* again, double* size,
                 DerivativeProof* proof) {
    const int n = place.problem.n;
    plant.evaluate(Function::derivatives, place.at(start_s, 0), values);
    for (int i = 0; i < n; ++i) size[i] = std::fabs(values[i]);
    for (int k = 1; k <= other_points; ++k)
        if (plant.evaluate(Function::derivatives, place.at(start_s, points + k), again) == Answer::ok)
            for (int i = 0; i < n; ++i) size[i] = std::fmax(size[i], std::fabs(again[i]));
    plant.evaluate(Function::derivatives, place.at(start_s, 0), again);
    proof->repeatable = std::memcmp(values, again, n * sizeof(double)) == 0;
    proof->memoryless = true;
    for (int i = 0; i < n; ++i)
        if (!(std::fabs(values[i] - again[i]) <= max_difference * size[i])) proof->memoryless = false;
}

} // namespace

int proof_doubles(const Problem& problem) {
    const int rows = std::max(problem.n, problem.sensors);
    return 2 * rows * problem.N + problem.N + problem.sizes.inputs + 2 * rows;
}

bool prove(Plant& plant, const Problem& problem, Linearisation& linearisation, double start_s, double* work,
           DerivativeProof* proof, Refusal& why) {
    const int rows = std::max(problem.n, problem.sensors), matrix = rows * problem.N;
    double *claimed = work, *measured = claimed + matrix, *X = measured + matrix, *u = X + problem.N;
    double *values = u + problem.sizes.inputs, *again = values + rows;
    const Place place{problem, X, u};
    *proof = {};
    if (!answers_at_start(plant, problem, place.at(start_s, 0), values, why)) return false;

    for (const Function f : {Function::derivatives, Function::outputs})
        for (const Variable v : {Variable::state, Variable::unknown_input, Variable::parameter}) {
            BlockProof& block = proof->block[int(f)][int(v)];
            block.offered = linearisation.exact(f, v);
            if (!block.offered) continue;
            bool wanted[variables] = {};
            wanted[int(v)] = true;
            double worst = 0;
            for (int k = 0; k <= points; ++k) {
                const Point at = place.at(start_s, k);
                if (plant.evaluate(f, at, values) != Answer::ok || !all_finite(values, problem.sizes.rows(f)) ||
                    linearisation.differences(plant, f, v, at, measured) != Answer::ok)
                    continue;
                std::fill_n(claimed, matrix, std::nan(""));
                if (plant.jacobian(f, wanted, at, linearisation.dependencies(), claimed) != Answer::ok) worst = HUGE_VAL;
                compare(problem, f, v, claimed, measured, values, &worst, &block);
            }
            block.exact = worst <= 1;
            linearisation.set_exact(f, v, block.exact);
        }
    prove_dependencies(plant, place, linearisation, start_s, {claimed, measured, values}, proof);

    find_memory(plant, place, start_s, values, again, measured, proof);
    return true;
}

} // namespace hnav::observer
