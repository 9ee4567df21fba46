// A plant given by the caller's functions.
#pragma once

#include "base/memory.hpp"
#include "hnav/observer.h"
#include "observer/plant.hpp"

#include <algorithm>
#include <cstdio>

namespace hnav::observer {

class CallbackPlant final : public Plant {
public:
    explicit CallbackPlant(const hnav_plant& given) : given_(given) {
        sizes = {given.n_states,  given.n_inputs,     given.n_unknown_inputs, given.n_parameters,
                 given.n_outputs, given.n_indicators, given.n_discrete,       given.event != nullptr};
        if (given.derivatives_at_points || given.outputs_at_points)
            sizes.points = std::min(2 * sizes.estimated() + 1, most_points);
    }

    Answer evaluate(Function function, const Point& at, double* values) override {
        return ask(function == Function::derivatives ? given_.derivatives : given_.outputs, at, values);
    }

    Answer evaluate_points(Function function, const Points& at, double* values) override {
        const auto points = function == Function::derivatives ? given_.derivatives_at_points : given_.outputs_at_points;
        return points ? answer_of(points(given_.context, at.count, at.t_s, at.x, at.u, at.p, values)) : Answer::broken;
    }

    Answer indicators(const Point& at, double* z) override {
        return given_.indicators ? ask(given_.indicators, at, z) : Answer::ok;
    }

    Answer event(const Point& at, double* x, double* next_s) override {
        std::copy_n(at.x, sizes.states, x);
        const Answer answer = ask(given_.event, at, x);
        *next_s = given_.next_event_s ? given_.next_event_s(given_.context, at.t_s) : HUGE_VAL;
        if (answer != Answer::ok || *next_s > at.t_s) return answer;
        std::snprintf(said_, sizeof said_, "next_event_s answers %.9g s, it must be later, or infinite", *next_s);
        return Answer::broken;
    }

    Answer remember(double* memory) override {
        if (sizes.memory > 0) given_.get_discrete(given_.context, memory);
        return Answer::ok;
    }

    Answer recall(const double* memory) override {
        *said_ = 0;
        if (sizes.memory > 0) given_.set_discrete(given_.context, memory);
        return Answer::ok;
    }

    const char* said() const override { return said_; }

    double first_event_s() override { return given_.next_event_s ? given_.next_event_s(given_.context, -HUGE_VAL) : HUGE_VAL; }

    bool offers(Function function, Variable) const override { return jacobian_of(function) != nullptr; }

    // The function writes all blocks at once; the caller overwrites blocks that it does not use.
    Answer jacobian(Function function, const bool (&)[variables], const Point& at, const Dependencies&, double* J) override {
        return ask(jacobian_of(function), at, J);
    }

    void destroy() override { destroy_object(this); }

private:
    hnav_plant_function jacobian_of(Function function) const {
        return function == Function::derivatives ? given_.derivatives_jacobian : given_.outputs_jacobian;
    }

    Answer ask(hnav_plant_function function, const Point& at, double* values) const {
        return answer_of(function(given_.context, at.t_s, at.x, at.u, at.p, values));
    }

    static Answer answer_of(int answer) { return answer == 0 ? Answer::ok : answer > 0 ? Answer::elsewhere : Answer::broken; }

    static constexpr int most_points = 129; // limits the memory of large plants

    hnav_plant given_;
    char said_[100] = "";
};

} // namespace hnav::observer
