// The observer with an integrator of the caller's: what flows outside is what flows inside.
#include "event_plants.hpp"
#include "hybrid/filter.hpp"
#include "hybrid/stiff_solver.hpp"
#include "observer.hpp"
#include "observer/observer_model.hpp"

#include <cmath>

using hnav::test::Given;
using hnav::test::Numbers;
using hnav::test::Observer;

namespace {

// A mass on a spring with estimated stiffness, and an unmeasured push.
int spring(void*, double, const double* x, const double* u, const double* p, double* dx) {
    dx[0] = x[1];
    dx[1] = -p[0] * x[0] - 0.3 * x[1] + u[0];
    return 0;
}

int position(void*, double, const double* x, const double*, const double*, double* y) {
    y[0] = x[0];
    return 0;
}

Given spring_with_everything() {
    Given g;
    g.plant.n_states = 2;
    g.plant.n_inputs = g.plant.n_unknown_inputs = 1;
    g.plant.n_parameters = 1;
    g.plant.n_outputs = 1;
    g.plant.derivatives = spring;
    g.plant.outputs = position;
    g.start = {1, 0, 0, 4};
    g.start_sigma = {0.2, 0.5, 0.1, 0.5};
    g.noise = {0, 0.1, 0.01, 0};
    g.time_constant = {5};
    g.sensor_sigma = {0.02};
    g.options.rtol = 1e-10;
    g.options.covariance_rtol = 1e-8;
    return g;
}

double sample(double t_s) { return std::cos(2 * t_s) * std::exp(-0.15 * t_s) + 0.02 * std::sin(40 * t_s); }

// The classical Runge-Kutta method of order 4.
void flow(hnav_filter* o, double interval_s, Numbers* x) {
    constexpr int steps = 50;
    const double h = interval_s / steps;
    const std::size_t n = x->size();
    const auto slope = [&](const Numbers& at) {
        Numbers dx(n);
        EXPECT_EQ(hnav_filter_derivative(o, 0, at.data(), dx.data()), HNAV_OK);
        return dx;
    };
    const auto moved = [&](const Numbers& dx, double by) {
        Numbers at = *x;
        for (std::size_t i = 0; i < n; ++i) at[i] += by * dx[i];
        return at;
    };
    for (int k = 0; k < steps; ++k) {
        const Numbers a = slope(*x), b = slope(moved(a, h / 2)), c = slope(moved(b, h / 2)), d = slope(moved(c, h));
        for (std::size_t i = 0; i < n; ++i) (*x)[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
    }
}

// x' = -x, which requests an event at the end of a step below 0.5 and restarts at 1 there.
struct WithWish final : hnav::observer::Plant {
    using Point = hnav::observer::Point;
    using Answer = hnav::observer::Answer;

    WithWish() {
        sizes.states = sizes.outputs = 1;
        sizes.events = true;
    }
    Answer evaluate(hnav::observer::Function function, const Point& at, double* values) override {
        *values = function == hnav::observer::Function::derivatives ? -at.x[0] : at.x[0];
        return Answer::ok;
    }
    bool offers(hnav::observer::Function, hnav::observer::Variable) const override { return false; }
    Answer jacobian(hnav::observer::Function, const bool (&)[hnav::observer::variables], const Point&,
                    const hnav::observer::Dependencies&, double*) override {
        return Answer::broken;
    }
    Answer event(const Point&, double* x, double* next_s) override {
        *x = 1;
        *next_s = HUGE_VAL;
        return Answer::ok;
    }
    Answer step_done(const Point& at, bool* wants_event) override {
        *wants_event = at.x[0] < 0.5;
        return Answer::ok;
    }
    void destroy() override {}
};

// A filter of it, started at 0 s.
struct OfWish {
    OfWish() {
        using namespace hnav::observer;
        Arena count;
        const Problem counted(count, plant.sizes);
        Workspace(count, counted);
        memory.resize(count.used() / sizeof(double));
        Arena arena(memory.data());
        problem.emplace(arena, plant.sizes);
        work.emplace(arena, *problem);
        const double one = 1, noise = 0.1;
        Statistics known{};
        known.start = known.start_sigma = known.sensor_sigma = &one;
        known.noise = &noise;
        hnav::Refusal why;
        EXPECT_TRUE(problem->assign(known, why)) << why.text;
        work->linearisation.create(plant);
        const Model model(plant, *problem, *work, stiff, trouble, {});
        EXPECT_TRUE(filter.create(model, {}));
        EXPECT_EQ(filter.push({0, model.start_channel(), &one}), hnav::Outcome::ok);
        x.resize(filter.nx());
        std::copy_n(filter.newest().x(), x.size(), x.data());
        EXPECT_EQ(filter.jump(0, x.data(), x.data()), hnav::Outcome::ok);
    }

    using Arena = hnav::Arena;
    WithWish plant;
    Numbers memory, x;
    std::optional<hnav::observer::Problem> problem;
    std::optional<hnav::observer::Workspace> work;
    hnav::StiffSolver stiff;
    hnav::observer::Trouble trouble{};
    hnav::Filter<hnav::observer::Model> filter;
};

} // namespace

TEST(ObserverHybrid, TheEventThatAStepWantsSurvivesSaveAndLoad) {
    for (const bool wants : {false, true}) {
        OfWish o, loaded;
        const auto& model = o.filter.model();
        o.x[0] = wants ? 0.4 : 0.6;
        ASSERT_TRUE(o.filter.note([&](hnav::RuntimeState& s) { return model.step_outside_done(s, o.x.data()); }));
        EXPECT_EQ(model.wants_event(o.filter.newest()), wants);
        hnav::test::Bytes saved(o.filter.state_size());
        o.filter.save(saved.data());
        ASSERT_EQ(loaded.filter.load(saved.data(), saved.size()), hnav::LoadOutcome::ok);
        for (OfWish* of : {&o, &loaded}) {
            Numbers x = o.x;
            ASSERT_EQ(of->filter.jump(1, x.data(), x.data()), hnav::Outcome::ok);
            EXPECT_NEAR(x[0], wants ? 1 : 0.6, 1e-12);
            EXPECT_FALSE(of->filter.model().wants_event(of->filter.newest())) << "it has had its event";
        }
    }
}

TEST(ObserverHybrid, EveryNumberOfAStateHasAPlaceOfItsOwn) {
    hnav::observer::PlantSizes sizes{2, 1, 1, 1, 2, 3, 1, true};
    sizes.memory = 4;
    hnav::Arena count;
    const hnav::observer::Problem p(count, sizes);
    for (const bool smooths : {false, true}) {
        const hnav::observer::Layout at(p, smooths);
        // Where each begins, in their order, and how many there are.
        const std::vector<std::pair<int, int>> of_part = {
            {0, p.moving},        {at.S, p.moving * p.N}, {at.Qd, at.triangle(p.N)},
            {at.clock, 1},        {at.parameters, 1},     {at.P, at.triangle(p.N)},
            {at.beyond, p.N},     {at.weight, 1},         {at.elapsed, 1},
            {at.jumps, 1},        {at.next_event, 1},     {at.pending, 1},
            {at.sides, 3},        {at.memory, 4},         {at.joint, at.joint_numbers},
            {at.part_numbers, 0},
        };
        const std::vector<std::pair<int, int>> shared = {
            {at.parts * at.part_numbers, 0},
            {at.inputs, p.known},
            {at.information, p.N},
            {at.t, 1},
            {at.usual, 1},
            {at.begun, 1},
            {at.broken, 1},
            {at.ready, 1},
            {at.violations, 1},
            {at.events, 1},
            {at.corrections, 1},
            {at.likelihood, 1},
            {at.parts_used, 1},
            {at.stiff, 1},
            {at.corrected, 1},
            {at.wants_event, 1},
            {at.held, 1},
            {at.holds, 1},
            {at.closed, 1},
            {at.from, p.moving},
            {at.course, p.moving},
            {at.counts, at.all_counts},
            {at.sensors, at.per_sensor * p.sensors},
            {at.checks, at.check_numbers * p.sensors},
            {at.numbers, 0},
        };
        for (const auto& places : {of_part, shared})
            for (std::size_t i = 1; i < places.size(); ++i)
                EXPECT_EQ(places[i].first, places[i - 1].first + places[i - 1].second) << i;
    }
}

TEST(ObserverHybrid, AnIntegratorOutsideFindsTheSame) {
    const Given g = spring_with_everything();
    Observer inside(g), outside(g);
    int32_t nx = 0;
    ASSERT_EQ(hnav_filter_nx(outside, &nx), HNAV_OK);
    Numbers x(nx), nominal(nx);
    ASSERT_EQ(hnav_filter_get_x(outside, x.data()), HNAV_OK);
    ASSERT_EQ(hnav_filter_nominal_x(outside, nominal.data()), HNAV_OK);
    for (const double size : nominal) EXPECT_GT(size, 0);
    constexpr double interval_s = 0.1;
    for (int k = 0; k < 30; ++k) {
        const double t_s = k * interval_s, end_s = t_s + interval_s;
        ASSERT_EQ(hnav_observer_push(inside, 0, t_s, sample(t_s)), HNAV_OK);
        ASSERT_EQ(hnav_observer_push(outside, 0, t_s, sample(t_s)), HNAV_OK);
        double next_s = 0;
        ASSERT_EQ(hnav_filter_next_event_s(outside, &next_s), HNAV_OK);
        EXPECT_EQ(next_s, t_s);
        ASSERT_EQ(hnav_filter_advance(inside, end_s), HNAV_OK);
        ASSERT_EQ(hnav_filter_jump(outside, t_s, x.data(), x.data()), HNAV_OK);
        flow(outside, interval_s, &x);
        ASSERT_EQ(hnav_filter_show(outside, end_s, x.data()), HNAV_OK);
        const Numbers sigma = inside.sigma(), shown = outside.sigma(), is = inside.x(), was = outside.x();
        for (std::size_t i = 0; i < sigma.size(); ++i) {
            EXPECT_NEAR(was[i], is[i], 1e-5 * sigma[i]);
            EXPECT_NEAR(shown[i], sigma[i], 1e-5 * sigma[i]);
        }
    }
    EXPECT_EQ(outside.info().corrections, 30u);
}

TEST(ObserverHybrid, TheEstimateAfterASampleStaysWhileTimeGoesOn) {
    Observer o(spring_with_everything());
    ASSERT_EQ(hnav_observer_push(o, 0, 0, 0.9), HNAV_OK);
    ASSERT_EQ(hnav_filter_advance(o, 0), HNAV_OK);
    const Numbers x = o.x(), sigma = o.sigma();
    ASSERT_EQ(hnav_filter_advance(o, 0.3), HNAV_OK);
    Numbers after(4), its_sigma(4);
    ASSERT_EQ(hnav_observer_posterior(o, after.data(), its_sigma.data()), HNAV_OK);
    EXPECT_EQ(after, x);
    EXPECT_EQ(its_sigma, sigma);
    const Numbers ahead = o.x();
    EXPECT_NE(ahead, x);
    ASSERT_EQ(hnav_filter_commit(o, 0.4), HNAV_OK);
    EXPECT_EQ(o.x(), x);
    EXPECT_EQ(hnav_filter_commit(o, 0.2), HNAV_ERROR_TIME_BACKWARDS);
    ASSERT_EQ(hnav_filter_advance(o, 0.4), HNAV_OK);
    EXPECT_NE(o.x(), ahead);
}

TEST(ObserverHybrid, NothingFlowsBeforeTheFirstSample) {
    Observer o(spring_with_everything());
    int32_t nx = 0;
    ASSERT_EQ(hnav_filter_nx(o, &nx), HNAV_OK);
    Numbers x(nx), dx(nx, 1);
    ASSERT_EQ(hnav_filter_get_x(o, x.data()), HNAV_OK);
    ASSERT_EQ(hnav_filter_derivative(o, 0, x.data(), dx.data()), HNAV_OK);
    EXPECT_EQ(dx, Numbers(nx, 0));
    double next_s = 0;
    ASSERT_EQ(hnav_filter_next_event_s(o, &next_s), HNAV_OK);
    EXPECT_TRUE(std::isinf(next_s));
}

TEST(ObserverHybrid, WhatCannotBeIsRefused) {
    Observer o(spring_with_everything());
    int32_t nx = 0;
    ASSERT_EQ(hnav_filter_nx(o, &nx), HNAV_OK);
    Numbers x(nx), dx(nx);
    ASSERT_EQ(hnav_filter_get_x(o, x.data()), HNAV_OK);
    EXPECT_EQ(hnav_filter_jump(o, NAN, x.data(), x.data()), HNAV_ERROR_NON_FINITE);
    x[3] = NAN;
    EXPECT_EQ(hnav_filter_show(o, 0, x.data()), HNAV_ERROR_NON_FINITE);
    EXPECT_NE(o.message().find("x[3]"), std::string::npos) << o.message();
    EXPECT_EQ(hnav_filter_get_x(o, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_filter_nx(nullptr, &nx), HNAV_ERROR_NULL_ARGUMENT);

    // A plant that fails loses the samples of the jump only.
    Given breaks = spring_with_everything();
    breaks.plant.outputs = [](void*, double t_s, const double* x, const double*, const double*, double* y) {
        y[0] = x[0];
        return t_s > 1 ? -1 : 0;
    };
    Observer broken(breaks);
    ASSERT_EQ(hnav_filter_get_x(broken, x.data()), HNAV_OK);
    ASSERT_EQ(hnav_observer_push(broken, 0, 2, 0.5), HNAV_OK);
    EXPECT_EQ(hnav_filter_jump(broken, 2, x.data(), x.data()), HNAV_ERROR_SOLVER);
    EXPECT_EQ(broken.info().dropped, 1u);
}

// A bounce at a guard found by the integrator: its closed form, then a sample.
TEST(ObserverHybrid, EventsOfThePlantAreJumps) {
    Given given = hnav::test::event_plants::ball({1, 0}, {0.02, 0.1}, 0);
    Observer o(given);
    const double g = 9.81, e = 0.7, bounce_s = std::sqrt(2 / g), speed = -g * bounce_s;
    int32_t nx = 0, wants = 1;
    ASSERT_EQ(hnav_filter_nx(o, &nx), HNAV_OK);
    Numbers x(nx);
    double z = 0, next_s = 0;
    EXPECT_EQ(o.info().n_indicators, 1);
    EXPECT_EQ(o.info().crosses, 1);
    ASSERT_EQ(hnav_filter_get_x(o, x.data()), HNAV_OK);
    ASSERT_EQ(hnav_filter_jump(o, 0, x.data(), x.data()), HNAV_OK); // the given start
    ASSERT_EQ(hnav_filter_get_x(o, x.data()), HNAV_OK);
    flow(o, bounce_s, &x);
    ASSERT_EQ(hnav_observer_indicators(o, x.data(), &z), HNAV_OK);
    EXPECT_NEAR(z, 0, 1e-12);
    ASSERT_EQ(hnav_observer_step_done(o, x.data(), &wants), HNAV_OK);
    EXPECT_EQ(wants, 0);
    x[0] = -1e-12; // just beyond
    ASSERT_EQ(hnav_filter_jump(o, bounce_s, x.data(), x.data()), HNAV_OK);
    EXPECT_EQ(o.info().plant_events, 1u);
    EXPECT_NEAR(x[1], -e * speed, 1e-9);
    // Again: nothing remains to be done.
    Numbers again(nx);
    ASSERT_EQ(hnav_filter_jump(o, bounce_s, x.data(), again.data()), HNAV_OK);
    EXPECT_EQ(again, x);
    ASSERT_EQ(hnav_filter_next_event_s(o, &next_s), HNAV_OK);
    EXPECT_TRUE(std::isinf(next_s));
    flow(o, 0.7 - bounce_s, &x);
    ASSERT_EQ(hnav_filter_show(o, 0.7, x.data()), HNAV_OK);
    Observer inside(given);
    ASSERT_EQ(hnav_filter_advance(inside, 0.7), HNAV_OK);
    for (int i = 0; i < 2; ++i) {
        EXPECT_NEAR(o.x()[i], inside.x()[i], 1e-9);
        EXPECT_NEAR(o.sigma()[i] / inside.sigma()[i], 1, 1e-6);
    }
}
