// The Jacobian of a plant's function by X, block by block: the plant's own derivatives where they have been confirmed
// (derivative_proof.hpp), central differences elsewhere. An output that is a state has a unit row. Of derivatives of states only what
// depends on X is written, by groups of columns.
#pragma once

#include "observer/dependencies.hpp"

namespace hnav::observer {

class Linearisation {
public:
    // Counts on an arena without memory.
    Linearisation(Arena& arena, const Problem& problem);

    void create(Plant& plant);
    // Those of another one of the same plant.
    void take_choices(const Linearisation& from);

    bool exact(Function function, Variable variable) const { return exact_[int(function)][int(variable)]; }
    // What the plant declares; until then all rows depend on all columns.
    void use_dependencies(const Plant& plant) { dependencies_.create(plant, true); }
    const Dependencies& dependencies() const { return dependencies_; }
    void set_exact(Function function, Variable variable, bool is) { exact_[int(function)][int(variable)] = is; }

    // Values and Jacobian, which is not asked for where there are no values.
    struct Answers {
        Answer values, jacobian;
    };
    Answers linearise(Plant& plant, Function function, const Point& at, double* values, double* J);
    // Rows of the function, N columns, row-major. Not ok: incomplete.
    Answer jacobian(Plant& plant, Function function, const Point& at, double* J);
    Answer differences(Plant& plant, Function function, Variable variable, const Point& at, double* J);

private:
    struct Moved;
    bool at_points(Plant& plant, Function function, const Point& at, double* values, double* J, Answers* answers);
    bool evaluate_points(Plant& plant, Function function, const Point& at, int first, int groups);
    void place(const Point& at, int point, Dependencies::Indices columns, bool up);
    double within(const Point& at, int column) const;
    Dependencies::Indices columns_of(Function function, const int& group) const;
    void add_units(Plant& plant, Function function, double* J) const;
    Answer group(Plant& plant, const Moved& moved, Dependencies::Indices columns, double* J);
    Answer column(Plant& plant, const Moved& moved, int column, double* J);
    Answer evaluate(Plant& plant, const Moved& moved, double* values) const;
    void put(const Moved& moved, int column, const double* up, const double* down, double width, double* J) const;
    double above(int column, double x) const;
    double below(int column, double x) const;

    const Problem& problem_;
    double *x_, *u_, *p_;
    double *above_, *below_, *here_, *kept_;
    Points points_; // of one call, and their values
    double* point_values_;
    Dependencies dependencies_;
    bool outputs_are_states_ = false;
    bool exact_[functions][variables] = {};
};

} // namespace hnav::observer
