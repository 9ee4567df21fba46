// A plant that is evaluated only within the bounds of the estimate; parameters estimated by their logarithms are passed as
// their values. A state at its bound is held while its derivative points outside: an empty tank stays empty.
#pragma once

#include "base/memory.hpp"
#include "observer/problem.hpp"

#include <algorithm>
#include <cmath>

namespace hnav::observer {

class BoundedPlant final : public Plant {
public:
    // Takes ownership of the plant. Null: no memory.
    static BoundedPlant* create(Plant* plant, const Problem& problem) {
        const int numbers = problem.n * (1 + plant->sizes.points) + problem.sizes.inputs + problem.sizes.parameters;
        void* block = take_block(numbers * sizeof(double));
        auto* made = block ? make_object<BoundedPlant>(plant, problem, static_cast<double*>(block)) : nullptr;
        if (!made) release_block(block);
        return made;
    }
    BoundedPlant(Plant* plant, const Problem& problem, double* block)
        : plant_(plant),
          problem_(problem),
          x_(block),
          u_(x_ + problem.n),
          p_(u_ + problem.sizes.inputs),
          sides_(p_ + problem.sizes.parameters) {
        sizes = plant->sizes;
    }
    ~BoundedPlant() {
        plant_->destroy();
        release_block(x_);
    }

    Answer evaluate(Function function, const Point& at, double* values) override {
        const Answer answer = plant_->evaluate(function, inside(at), values);
        for (int i = 0; function == Function::derivatives && i < problem_.n; ++i)
            if ((at.x[i] < problem_.low[i] && values[i] < 0) || (at.x[i] > problem_.high[i] && values[i] > 0)) values[i] = 0;
        return answer;
    }

    Answer evaluate_points(Function function, const Points& at, double* values) override {
        const int rows = sizes.rows(function);
        for (int k = 0; k < at.count; ++k) {
            double *x = at.x + k * problem_.n, *sides = sides_ + k * problem_.n;
            for (int i = 0; i < problem_.n; ++i) sides[i] = x[i] < problem_.low[i] ? -1 : x[i] > problem_.high[i] ? 1 : 0;
            put_inside({at.t_s, x, at.u + k * sizes.inputs, at.p + k * sizes.parameters}, x, at.u + k * sizes.inputs,
                       at.p + k * sizes.parameters);
        }
        const Answer answer = plant_->evaluate_points(function, at, values);
        for (int i = 0; function == Function::derivatives && i < at.count * rows; ++i)
            if (sides_[i] * values[i] > 0) values[i] = 0;
        return answer;
    }

    Answer step(const Point& from, double length_s, double* x) override { return plant_->step(inside(from), length_s, x); }

    bool offers(Function function, Variable variable) const override { return plant_->offers(function, variable); }

    bool declares_dependencies() const override { return plant_->declares_dependencies(); }
    bool depends(int derivative, int on) const override { return plant_->depends(derivative, on); }

    Answer jacobian(Function function, const bool (&wanted)[variables], const Point& at, const Dependencies& dependencies,
                    double* J) override {
        const Answer answer = plant_->jacobian(function, wanted, inside(at), dependencies, J);
        for (int k = 0; wanted[int(Variable::parameter)] && k < sizes.parameters; ++k)
            for (int i = 0; problem_.is_log[k] != 0 && i < sizes.rows(function); ++i)
                J[i * problem_.N + problem_.moving + k] *= p_[k];
        return answer;
    }

    Answer indicators(const Point& at, double* z) override { return plant_->indicators(inside(at), z); }
    Answer event(const Point& at, double* x, double* next_s) override { return plant_->event(inside(at), x, next_s); }
    Answer remember(double* memory) override { return plant_->remember(memory); }
    Answer recall(const double* memory) override { return plant_->recall(memory); }
    void hold(const double* memory, int by) override { plant_->hold(memory, by); }
    Answer step_done(const Point& at, bool* wants_event) override { return plant_->step_done(inside(at), wants_event); }
    bool memory_lasts() const override { return plant_->memory_lasts(); }
    double first_event_s() override { return plant_->first_event_s(); }
    bool go_to_start(Refusal& why) override { return plant_->go_to_start(why); }
    void set_holders(const Holders& h) override { plant_->set_holders(h); }
    int state_of_output(int output) const override { return plant_->state_of_output(output); }
    const char* said() const override { return plant_->said(); }
    void destroy() override { destroy_object(this); }

private:
    Point inside(const Point& at) {
        put_inside(at, x_, u_, p_);
        return {at.t_s, x_, u_, p_};
    }

    void put_inside(const Point& at, double* x, double* u, double* p) const {
        const auto put = [this](const double* from, int first, int count, double* to) {
            for (int i = 0; i < count; ++i) to[i] = std::clamp(from[i], problem_.low[first + i], problem_.high[first + i]);
        };
        put(at.x, 0, problem_.n, x);
        for (int i = 0; i < problem_.known; ++i) u[i] = at.u[i];
        put(at.u + problem_.known, problem_.n, sizes.unknown_inputs, u + problem_.known);
        put(at.p, problem_.moving, sizes.parameters, p);
        for (int k = 0; k < sizes.parameters; ++k)
            if (problem_.is_log[k] != 0) p[k] = std::exp(p[k]);
    }

    Plant* plant_;
    const Problem& problem_;
    double *x_, *u_, *p_;
    double* sides_; // of points: -1 and 1 where a state is beyond a bound
};

} // namespace hnav::observer
