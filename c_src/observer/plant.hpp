// A plant: the observed model as functions of time, states, inputs and parameters. Callbacks and FMUs implement this
// interface.
#pragma once

#include "base/refusal.hpp"

#include <cmath>

namespace hnav::observer {

// elsewhere: no value at this point, a solver may try one nearer to its start. broken: none at all.
enum class Answer { ok = 0, elsewhere = 1, broken = -1 };

enum class Function { derivatives, outputs, indicators, event };
enum class Variable { state, unknown_input, parameter };
constexpr int functions = 2, variables = 3; // that have derivatives

class Dependencies;

struct Point {
    double t_s;
    const double *x, *u, *p;
};

// Of one time; rows of x, u and p.
struct Points {
    int count;
    double t_s;
    double *x, *u, *p;
};

// How many there are of each; the unknown inputs are the last of the inputs.
struct PlantSizes {
    int states = 0, inputs = 0, unknown_inputs = 0, parameters = 0, outputs = 0, indicators = 0;
    int memory = 0;      // numbers of its discrete state
    bool events = false; // it has events of its own: indicators, times, inputs that it acts on
    int points = 0;      // at most in one call of evaluate_points; 0: it has none
    bool steps = false;  // it integrates its states itself, by step

    int known_inputs() const { return inputs - unknown_inputs; }
    // Estimated numbers: states, unknown inputs, parameters.
    int estimated() const { return states + unknown_inputs + parameters; }
    int rows(Function function) const {
        return function == Function::derivatives ? states : function == Function::outputs ? outputs : indicators;
    }
    int count(Variable variable) const {
        return variable == Variable::state ? states : variable == Variable::unknown_input ? unknown_inputs : parameters;
    }
    // First index of a kind of variable in X.
    int first(Variable variable) const {
        return variable == Variable::state ? 0 : variable == Variable::unknown_input ? states : states + unknown_inputs;
    }
};

// Holders of discrete states: each calls seen for all of its own.
struct Holders {
    const void* context = nullptr;
    void (*each)(const void* context, void (*seen)(void* visitor, const double* memory), void* visitor) = nullptr;
};

class Plant {
public:
    PlantSizes sizes;
    Holders holders; // null: everything is held

    virtual Answer evaluate(Function function, const Point& at, double* values) = 0;
    // values: a row for each point. Of a plant whose sizes have points. The points may be changed.
    virtual Answer evaluate_points(Function, const Points&, double*) { return Answer::broken; }

    // Of a plant that integrates its states itself: the states (x) after this time from this point and its discrete state, which changes.
    virtual Answer step(const Point& /*from*/, double /*length_s*/, double* /*x*/) { return Answer::broken; }

    // Whether it offers the derivatives of a function by a kind of variable.
    virtual bool offers(Function function, Variable variable) const = 0;
    // Writes the requested columns of J (rows of the function, columns of X, row-major). Only offered blocks are
    // requested. Of derivatives of states only the dependent elements are needed.
    virtual Answer jacobian(Function function, const bool (&wanted)[variables], const Point& at, const Dependencies& dependencies,
                            double* J) = 0;
    // Whether the derivative of a state may depend on a state or an unknown input, by its place in X; declares: any does not.
    virtual bool declares_dependencies() const { return false; }
    virtual bool depends(int /*derivative*/, int /*on*/) const { return true; }

    // Events. The discrete state changes in event only; between events the values depend on it and on the arguments.
    // An event occurs where an indicator leaves its domain, z > 0 or z <= 0, at a time announced by the previous event, and with
    // changed inputs and parameters.
    virtual Answer indicators(const Point&, double*) { return Answer::ok; }
    // x: the states after it; next_s: time of the next time event, infinite for none.
    virtual Answer event(const Point& at, double* x, double* next_s) {
        for (int i = 0; i < sizes.states; ++i) x[i] = at.x[i];
        *next_s = HUGE_VAL;
        return Answer::ok;
    }
    // The discrete state, to and from so many numbers; nothing else changes.
    virtual Answer remember(double*) { return Answer::ok; }
    virtual Answer recall(const double*) { return Answer::ok; }
    // One more (by 1) or one less (-1) holder outside the list.
    virtual void hold(const double* /*memory*/, int /*by*/) {}
    // A step of the solver has ended at this point. wants_event: an event is due now.
    virtual Answer step_done(const Point&, bool* wants_event) {
        *wants_event = false;
        return Answer::ok;
    }
    // Whether a discrete state is valid for another instance, in another process.
    virtual bool memory_lasts() const { return true; }
    // Time of the first time event, before any event.
    virtual double first_event_s() { return HUGE_VAL; }
    // The derivatives have been checked, possibly at the cost of the instance: it is at its start again. False: why has the reason.
    virtual bool go_to_start(Refusal&) { return true; }

    // The state that an output is, or -1.
    virtual int state_of_output(int) const { return -1; }

    // Message of its last failure; "" if none.
    virtual const char* said() const { return ""; }

    virtual void set_holders(const Holders& h) { holders = h; }

    virtual void destroy() = 0;

protected:
    ~Plant() = default;
};

} // namespace hnav::observer
