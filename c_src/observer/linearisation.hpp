// The Jacobian of a plant's function by X, block by block: the plant's own derivatives where they have been confirmed
// (derivative_proof.hpp), central differences elsewhere. An output that is a state has a unit row.
#pragma once

#include "observer/problem.hpp"

namespace hnav::observer {

class Linearisation {
public:
    // Counts on an arena without memory.
    Linearisation(Arena& arena, const Problem& problem);

    void create(Plant& plant);
    // Those of another one of the same plant.
    void take_choices(const Linearisation& from);

    bool exact(Function function, Variable variable) const { return exact_[int(function)][int(variable)]; }
    void set_exact(Function function, Variable variable, bool is) { exact_[int(function)][int(variable)] = is; }

    // Rows of the function, N columns, row-major. Not ok: incomplete.
    Answer jacobian(Plant& plant, Function function, const Point& at, double* J);
    Answer differences(Plant& plant, Function function, Variable variable, const Point& at, double* J);

private:
    Answer column(Plant& plant, Function function, const Point& moved, double* number, double up, double down, int rows,
                  double* out);

    const Problem& problem_;
    double *x_, *u_, *p_;
    double *above_, *below_, *here_;
    bool outputs_are_states_ = false;
    bool exact_[functions][variables] = {};
};

} // namespace hnav::observer
