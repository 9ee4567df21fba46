// A plant: the model of what is observed, as functions of time, states, inputs and parameters. Who answers, callbacks or
// an FMU, is behind this.
#pragma once

#include <cmath>

namespace hnav::observer {

// elsewhere: no answer at this point, a solver may try one nearer to where it came from. broken: none at all.
enum class Answer { ok = 0, elsewhere = 1, broken = -1 };

enum class Function { derivatives, outputs, indicators, event };
enum class Variable { state, unknown_input, parameter };
constexpr int functions = 2, variables = 3; // that have derivatives

struct Refusal;

struct Point {
    double t_s;
    const double *x, *u, *p;
};

// How many there are of each; the unknown inputs are the last of the inputs.
struct PlantSizes {
    int states = 0, inputs = 0, unknown_inputs = 0, parameters = 0, outputs = 0, indicators = 0;
    int memory = 0;      // numbers that hold what it remembers: its discrete state
    bool events = false; // it has events of its own: indicators, times, inputs that it acts on

    int known_inputs() const { return inputs - unknown_inputs; }
    // What is estimated: states, unknown inputs, parameters.
    int estimated() const { return states + unknown_inputs + parameters; }
    int rows(Function function) const {
        return function == Function::derivatives ? states : function == Function::outputs ? outputs : indicators;
    }
    int count(Variable variable) const {
        return variable == Variable::state ? states : variable == Variable::unknown_input ? unknown_inputs : parameters;
    }
    // Where a kind of variable begins among what is estimated.
    int first(Variable variable) const {
        return variable == Variable::state ? 0 : variable == Variable::unknown_input ? states : states + unknown_inputs;
    }
};

// Who may hold what a plant has remembered: each calls seen for all of it.
struct Holders {
    const void* context = nullptr;
    void (*each)(const void* context, void (*seen)(void* visitor, const double* memory), void* visitor) = nullptr;
};

class Plant {
public:
    PlantSizes sizes;
    Holders holders; // null: everything is held

    virtual Answer evaluate(Function function, const Point& at, double* values) = 0;

    // Whether it knows the derivatives of a function by a kind of variable.
    virtual bool offers(Function function, Variable variable) const = 0;
    // Writes those columns of J (rows of the function, columns of all that is estimated, row-major) that are wanted. Only
    // what is offered is asked.
    virtual Answer jacobian(Function function, const bool (&wanted)[variables], const Point& at, double* J) = 0;

    // Events. What a plant remembers changes in event alone; between events its answers depend on what it was asked and on that.
    // An event comes where an indicator leaves its domain, z > 0 or z <= 0, at a time that the event before has named, and with
    // inputs and parameters that have changed.
    virtual Answer indicators(const Point&, double*) { return Answer::ok; }
    // x: the states after it; next_s: of the next that time brings, infinite for none.
    virtual Answer event(const Point& at, double* x, double* next_s) {
        for (int i = 0; i < sizes.states; ++i) x[i] = at.x[i];
        *next_s = HUGE_VAL;
        return Answer::ok;
    }
    // What it remembers, to and from so many numbers; nothing else changes.
    virtual Answer remember(double*) { return Answer::ok; }
    virtual Answer recall(const double*) { return Answer::ok; }
    // Once more (by 1) or once less (-1) somebody beside the holders holds it.
    virtual void hold(const double* /*memory*/, int /*by*/) {}
    // A step of the solver has come to this point. wants_event: now.
    virtual Answer step_done(const Point&, bool* wants_event) {
        *wants_event = false;
        return Answer::ok;
    }
    // Whether what it remembers is good for another instance, in another process.
    virtual bool memory_lasts() const { return true; }
    // When the first event of time comes, before there was any.
    virtual double first_event_s() { return HUGE_VAL; }
    // The derivatives have been proven, which may have cost what was asked its life: it is as at the start again. False: why says it.
    virtual bool begin_anew(Refusal&) { return true; }

    // The state that an output is, or -1.
    virtual int state_of_output(int) const { return -1; }

    // What it said of its last failure; "" if nothing.
    virtual const char* said() const { return ""; }

    virtual void set_holders(const Holders& h) { holders = h; }

    virtual void destroy() = 0;

protected:
    ~Plant() = default;
};

} // namespace hnav::observer
