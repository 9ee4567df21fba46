#include "observer/linearisation.hpp"

#include "maths/finite.hpp"

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
      here_(arena.doubles(std::max(problem.n, problem.sensors))),
      kept_(arena.doubles(problem.N)),
      points_{0, 0, arena.doubles(problem.sizes.points * problem.n), arena.doubles(problem.sizes.points * problem.sizes.inputs),
              arena.doubles(problem.sizes.points * problem.sizes.parameters)},
      point_values_(arena.doubles(problem.sizes.points * std::max(problem.n, problem.sensors))),
      dependencies_(arena, problem) {}

void Linearisation::create(Plant& plant) {
    dependencies_.create(plant, false);
    outputs_are_states_ = true;
    for (int i = 0; i < problem_.sensors; ++i) outputs_are_states_ = outputs_are_states_ && plant.state_of_output(i) >= 0;
    for (const Function f : {Function::derivatives, Function::outputs})
        for (const Variable v : {Variable::state, Variable::unknown_input, Variable::parameter})
            set_exact(f, v, problem_.sizes.count(v) > 0 && plant.offers(f, v));
}

void Linearisation::take_choices(const Linearisation& from) {
    outputs_are_states_ = from.outputs_are_states_;
    std::memcpy(exact_, from.exact_, sizeof exact_);
    dependencies_.take(from.dependencies_);
}

Linearisation::Answers Linearisation::linearise(Plant& plant, Function function, const Point& at, double* values, double* J) {
    Answers answers{};
    if (at_points(plant, function, at, values, J, &answers)) return answers;
    answers.values = answers.jacobian = plant.evaluate(function, at, values);
    if (answers.values != Answer::ok) return answers;
    const bool any = all_finite(values, problem_.sizes.rows(function));
    answers.jacobian = any ? jacobian(plant, function, at, J) : Answer::elsewhere;
    return answers;
}

Answer Linearisation::jacobian(Plant& plant, Function function, const Point& at, double* J) {
    const bool units_only = function == Function::outputs && outputs_are_states_;
    Answer answer = Answer::ok;
    if (!units_only) {
        const bool(&exact)[variables] = exact_[int(function)];
        if (exact[0] || exact[1] || exact[2]) answer = plant.jacobian(function, exact, at, dependencies_, J);
        for (const Variable v : {Variable::state, Variable::unknown_input, Variable::parameter})
            if (answer == Answer::ok && !exact[int(v)] && problem_.sizes.count(v) > 0)
                answer = differences(plant, function, v, at, J);
    }
    add_units(plant, function, J);
    return answer;
}

// Of outputs that are states.
void Linearisation::add_units(Plant& plant, Function function, double* J) const {
    if (function != Function::outputs) return;
    for (int i = 0; i < problem_.sensors; ++i) {
        const int state = plant.state_of_output(i);
        if (state < 0) continue;
        std::fill_n(J + i * problem_.N, problem_.N, 0.0);
        J[i * problem_.N + state] = 1;
    }
}

// The point at which a function is evaluated with some numbers moved.
struct Linearisation::Moved {
    Function function;
    Point at;
    int rows, first; // column of the first number
    double* numbers;

    double& number(int column) const { return numbers[column - first]; }
};

Answer Linearisation::differences(Plant& plant, Function function, Variable variable, const Point& at, double* J) {
    const int first = problem_.sizes.first(variable), count = problem_.sizes.count(variable);
    std::copy_n(at.x, problem_.n, x_);
    std::copy_n(at.u, problem_.sizes.inputs, u_);
    std::copy_n(at.p, problem_.sizes.parameters, p_);
    double* numbers = variable == Variable::state ? x_ : variable == Variable::unknown_input ? u_ + problem_.known : p_;
    for (int k = 0; k < count; ++k) numbers[k] = std::clamp(numbers[k], problem_.low[first + k], problem_.high[first + k]);
    const Moved moved{function, {at.t_s, x_, u_, p_}, problem_.sizes.rows(function), first, numbers};
    Answer answer = Answer::ok;
    if (function == Function::outputs) {
        for (int k = 0; answer == Answer::ok && k < count; ++k) answer = column(plant, moved, first + k, J);
        return answer;
    }
    const int last = dependencies_.last_group(variable);
    for (int g = dependencies_.first_group(variable); answer == Answer::ok && g < last; ++g)
        answer = group(plant, moved, dependencies_.group(g), J);
    return answer;
}

// The same numbers as by single points. False: derivatives of the plant are used, or it fails at a point beside this one.
bool Linearisation::at_points(Plant& plant, Function function, const Point& at, double* values, double* J, Answers* answers) {
    const bool(&exact)[variables] = exact_[int(function)];
    if (problem_.sizes.points == 0 || exact[0] || exact[1] || exact[2]) return false;
    const int rows = problem_.sizes.rows(function), most = (problem_.sizes.points - 1) / 2;
    const int all = function == Function::outputs ? problem_.N : dependencies_.last_group(Variable::parameter);
    const Moved moved{function, at, rows, 0, nullptr};
    for (int first = 0; first < all; first += most) {
        const int groups = std::min(most, all - first);
        if (!evaluate_points(plant, function, at, first, groups)) return false;
        if (first == 0) std::copy_n(point_values_, rows, values);
        if (!all_finite(values, rows)) {
            answers->jacobian = Answer::elsewhere;
            return true;
        }
        if (!all_finite(point_values_ + rows, 2 * groups * rows)) return false;
        const double* up = point_values_ + rows;
        for (int g = first; g < first + groups; ++g, up += 2 * rows)
            for (const int j : columns_of(function, g)) {
                const double x = within(at, j);
                put(moved, j, up, up + rows, above(j, x) - below(j, x), J);
            }
    }
    add_units(plant, function, J);
    return true;
}

// The point itself, then above and below for each group.
bool Linearisation::evaluate_points(Plant& plant, Function function, const Point& at, int first, int groups) {
    place(at, 0, {}, true);
    for (int g = first; g < first + groups; ++g)
        for (const bool up : {true, false}) place(at, 2 * (g - first) + (up ? 1 : 2), columns_of(function, g), up);
    points_.count = 2 * groups + 1;
    points_.t_s = at.t_s;
    return plant.evaluate_points(function, points_, point_values_) == Answer::ok;
}

void Linearisation::place(const Point& at, int point, Dependencies::Indices columns, bool up) {
    std::copy_n(at.x, problem_.n, points_.x + point * problem_.n);
    std::copy_n(at.u, problem_.sizes.inputs, points_.u + point * problem_.sizes.inputs);
    std::copy_n(at.p, problem_.sizes.parameters, points_.p + point * problem_.sizes.parameters);
    for (const int j : columns) {
        const double x = within(at, j), moved = up ? above(j, x) : below(j, x);
        if (j < problem_.n) points_.x[point * problem_.n + j] = moved;
        else if (j < problem_.moving) points_.u[point * problem_.sizes.inputs + problem_.known + j - problem_.n] = moved;
        else points_.p[point * problem_.sizes.parameters + j - problem_.moving] = moved;
    }
}

// A number of X, within its bounds.
double Linearisation::within(const Point& at, int j) const {
    const double x = j < problem_.n        ? at.x[j]
                     : j < problem_.moving ? at.u[problem_.known + j - problem_.n]
                                           : at.p[j - problem_.moving];
    return std::clamp(x, problem_.low[j], problem_.high[j]);
}

// Of outputs column by column. The number of the group lives as long as the columns are used.
Dependencies::Indices Linearisation::columns_of(Function function, const int& g) const {
    if (function == Function::outputs) return {&g, &g + 1};
    return dependencies_.group(g);
}

// Column by column where the plant fails.
Answer Linearisation::group(Plant& plant, const Moved& moved, Dependencies::Indices columns, double* J) {
    if (columns.count() > 1) {
        for (const int j : columns) kept_[j] = moved.number(j);
        for (const int j : columns) moved.number(j) = above(j, kept_[j]);
        Answer answer = evaluate(plant, moved, above_);
        for (const int j : columns) moved.number(j) = below(j, kept_[j]);
        if (answer == Answer::ok) answer = evaluate(plant, moved, below_);
        for (const int j : columns) moved.number(j) = kept_[j];
        if (answer == Answer::ok) {
            for (const int j : columns) put(moved, j, above_, below_, above(j, kept_[j]) - below(j, kept_[j]), J);
            return answer;
        }
    }
    for (const int j : columns)
        if (const Answer answer = column(plant, moved, j, J); answer != Answer::ok) return answer;
    return Answer::ok;
}

// One-sided where the plant fails on the other side: a root, a table that ends.
Answer Linearisation::column(Plant& plant, const Moved& moved, int j, double* J) {
    double& number = moved.number(j);
    const double kept = number;
    const auto ask = [&](double at, double* values) {
        number = at;
        const Answer answer = evaluate(plant, moved, values);
        number = kept;
        return answer;
    };
    double up = above(j, kept), down = below(j, kept);
    const double *of_up = above_, *of_down = below_;
    const Answer upwards = ask(up, above_), downwards = ask(down, below_);
    if (upwards != Answer::ok && downwards != Answer::ok) return upwards;
    if (upwards != Answer::ok || downwards != Answer::ok) {
        if (const Answer answer = ask(kept, here_); answer != Answer::ok) return answer;
        (upwards != Answer::ok ? up : down) = kept;
        (upwards != Answer::ok ? of_up : of_down) = here_;
    }
    put(moved, j, of_up, of_down, up - down, J);
    return Answer::ok;
}

Answer Linearisation::evaluate(Plant& plant, const Moved& moved, double* values) const {
    const Answer answer = plant.evaluate(moved.function, moved.at, values);
    return answer == Answer::ok && !all_finite(values, moved.rows) ? Answer::elsewhere : answer;
}

void Linearisation::put(const Moved& moved, int j, const double* up, const double* down, double width, double* J) const {
    const int N = problem_.N;
    if (moved.function == Function::outputs) {
        for (int i = 0; i < moved.rows; ++i) J[i * N + j] = (up[i] - down[i]) / width;
    } else {
        for (const int i : dependencies_.column(j)) J[i * N + j] = (up[i] - down[i]) / width;
    }
}

double Linearisation::above(int j, double x) const { return std::min(x + problem_.step(j, x), problem_.high[j]); }

double Linearisation::below(int j, double x) const { return std::max(x - problem_.step(j, x), problem_.low[j]); }

} // namespace hnav::observer
