#include "observer/linearisation.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>

namespace hnav::observer {

Linearisation::Linearisation(Arena& arena, const Problem& problem)
    : problem_(problem),
      x_(arena.doubles(problem.n)),
      u_(arena.doubles(problem.sizes.inputs)),
      p_(arena.doubles(problem.sizes.parameters)),
      above_(arena.doubles(std::max(problem.n, problem.sensors))),
      below_(arena.doubles(std::max(problem.n, problem.sensors))),
      here_(arena.doubles(std::max(problem.n, problem.sensors))) {}

void Linearisation::create(Plant& plant) {
    outputs_are_states_ = true;
    for (int i = 0; i < problem_.sensors; ++i) outputs_are_states_ = outputs_are_states_ && plant.state_of_output(i) >= 0;
    for (const Function f : {Function::derivatives, Function::outputs})
        for (const Variable v : {Variable::state, Variable::unknown_input, Variable::parameter})
            set_exact(f, v, problem_.sizes.count(v) > 0 && plant.offers(f, v));
}

void Linearisation::take_choices(const Linearisation& from) {
    outputs_are_states_ = from.outputs_are_states_;
    std::memcpy(exact_, from.exact_, sizeof exact_);
}

Answer Linearisation::jacobian(Plant& plant, Function function, const Point& at, double* J) {
    const int rows = problem_.sizes.rows(function);
    const bool units_only = function == Function::outputs && outputs_are_states_;
    Answer answer = Answer::ok;
    if (!units_only) {
        const bool(&exact)[variables] = exact_[int(function)];
        if (exact[0] || exact[1] || exact[2]) answer = plant.jacobian(function, exact, at, J);
        for (const Variable v : {Variable::state, Variable::unknown_input, Variable::parameter})
            if (answer == Answer::ok && !exact[int(v)] && problem_.sizes.count(v) > 0)
                answer = differences(plant, function, v, at, J);
    }
    if (function == Function::outputs)
        for (int i = 0; i < rows; ++i) {
            const int state = plant.state_of_output(i);
            if (state < 0) continue;
            std::fill_n(J + i * problem_.N, problem_.N, 0.0);
            J[i * problem_.N + state] = 1;
        }
    return answer;
}

// The cube root of the rounding, where rounding and truncation errors are equal.
Answer Linearisation::differences(Plant& plant, Function function, Variable variable, const Point& at, double* J) {
    const int rows = problem_.sizes.rows(function), first = problem_.sizes.first(variable);
    std::copy_n(at.x, problem_.n, x_);
    std::copy_n(at.u, problem_.sizes.inputs, u_);
    std::copy_n(at.p, problem_.sizes.parameters, p_);
    const Point moved{at.t_s, x_, u_, p_};
    double* numbers = variable == Variable::state ? x_ : variable == Variable::unknown_input ? u_ + problem_.known : p_;
    const double *low = problem_.low + first, *high = problem_.high + first;
    for (int k = 0; k < problem_.sizes.count(variable); ++k) numbers[k] = std::clamp(numbers[k], low[k], high[k]);
    for (int k = 0; k < problem_.sizes.count(variable); ++k) {
        const double step = 6e-6 * std::max(std::fabs(numbers[k]), problem_.scale[first + k]);
        const double up = std::min(numbers[k] + step, high[k]), down = std::max(numbers[k] - step, low[k]);
        const Answer answer = column(plant, function, moved, numbers + k, up, down, rows, J + first + k);
        if (answer != Answer::ok) return answer;
    }
    return Answer::ok;
}

// One-sided where the plant fails on the other side: a root, a table that ends.
Answer Linearisation::column(Plant& plant, Function function, const Point& moved, double* number, double up, double down,
                             int rows, double* out) {
    const double kept = *number;
    const auto ask = [&](double at, double* values) {
        *number = at;
        Answer answer = plant.evaluate(function, moved, values);
        *number = kept;
        for (int i = 0; answer == Answer::ok && i < rows; ++i)
            if (!std::isfinite(values[i])) answer = Answer::elsewhere;
        return answer;
    };
    const double *above = above_, *below = below_;
    const Answer of_up = ask(up, above_), of_down = ask(down, below_);
    if (of_up != Answer::ok && of_down != Answer::ok) return of_up;
    if (of_up != Answer::ok || of_down != Answer::ok) {
        if (const Answer answer = ask(kept, here_); answer != Answer::ok) return answer;
        (of_up != Answer::ok ? up : down) = kept;
        (of_up != Answer::ok ? above : below) = here_;
    }
    for (int i = 0; i < rows; ++i) out[i * problem_.N] = (above[i] - below[i]) / (up - down);
    return Answer::ok;
}

} // namespace hnav::observer
