// Derivatives of plants by groups of columns: the same values as column by column, with fewer evaluations.
#include "observer/derivative_proof.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

namespace {

using namespace hnav::observer;
using Numbers = std::vector<double>;

// x_i' = p x_(i-1)^2 - 2 x_i + sin(x_(i+1)) + u_i for the last two: states depend on their neighbours.
struct Chain final : Plant {
    explicit Chain(int states) {
        sizes.states = states;
        sizes.inputs = sizes.unknown_inputs = 2;
        sizes.parameters = sizes.outputs = 1;
    }

    Answer evaluate(Function function, const Point& at, double* values) override {
        ++evaluations;
        if (function == Function::outputs) {
            values[0] = at.x[0] * at.x[1] + at.u[0];
            return Answer::ok;
        }
        const int n = sizes.states;
        for (int i = 0; i < n; ++i) {
            if (at.x[i] > highest) return Answer::elsewhere;
            values[i] =
                -2 * at.x[i] + (i > 0 ? at.p[0] * at.x[i - 1] * at.x[i - 1] : 0) + (i + 1 < n ? std::sin(at.x[i + 1]) : 0);
            if (i >= n - 2) values[i] += at.u[i - n + 2];
        }
        if (secret) values[0] += 1e-3 * at.x[n - 1];
        return Answer::ok;
    }
    Answer evaluate_points(Function function, const Points& at, double* values) override {
        EXPECT_LE(at.count, sizes.points);
        ++calls;
        for (int k = 0; k < at.count; ++k) {
            const Point one{at.t_s, at.x + k * sizes.states, at.u + k * sizes.inputs, at.p + k * sizes.parameters};
            const Answer answer = evaluate(function, one, values + k * sizes.rows(function));
            if (answer != Answer::ok) return answer;
        }
        std::fill_n(at.p, at.count * sizes.parameters, std::nan("")); // it may change them
        return Answer::ok;
    }
    bool offers(Function, Variable) const override { return false; }
    Answer jacobian(Function, const bool (&)[variables], const Point&, const Dependencies&, double*) override {
        return Answer::broken;
    }
    bool declares_dependencies() const override { return declares; }
    bool depends(int derivative, int on) const override {
        return on < sizes.states ? std::abs(derivative - on) <= 1 : derivative - sizes.states + 2 == on - sizes.states;
    }
    void destroy() override {}

    bool declares = true, secret = false;
    double highest = HUGE_VAL;
    int evaluations = 0, calls = 0;
};

// The chain with its linearisation.
struct Linearised {
    explicit Linearised(int states, bool with_dependencies = true, int points = 0) : plant(states) {
        plant.sizes.points = points;
        hnav::Arena count;
        const Problem counted(count, plant.sizes);
        Linearisation(count, counted);
        memory.resize(count.used() / sizeof(double));
        hnav::Arena arena(memory.data());
        problem.emplace(arena, plant.sizes);
        linearisation.emplace(arena, *problem);
        x.resize(problem->N);
        for (int i = 0; i < problem->N; ++i) x[i] = 0.3 + 0.05 * i;
        const Numbers sigma(problem->N, 0.1);
        const double one = 1;
        Statistics known{};
        known.start = x.data();
        known.start_sigma = sigma.data();
        known.sensor_sigma = &one;
        hnav::Refusal why;
        EXPECT_TRUE(problem->assign(known, why)) << why.text;
        linearisation->create(plant);
        if (with_dependencies) linearisation->use_dependencies(plant);
    }

    Numbers jacobian(Function function = Function::derivatives) {
        Numbers J(plant.sizes.rows(function) * problem->N, 0.0);
        plant.evaluations = 0;
        EXPECT_EQ(linearisation->jacobian(plant, function, at(), J.data()), Answer::ok);
        return J;
    }
    // Values, then the Jacobian.
    Numbers linearised(Function function) {
        const int rows = plant.sizes.rows(function);
        Numbers found(rows * (1 + problem->N), 0.0);
        plant.evaluations = plant.calls = 0;
        const auto answer = linearisation->linearise(plant, function, at(), found.data(), found.data() + rows);
        EXPECT_EQ(answer.values, Answer::ok);
        EXPECT_EQ(answer.jacobian, Answer::ok);
        return found;
    }
    Point at() const { return {0, x.data(), x.data() + problem->n, x.data() + problem->moving}; }
    bool prove(DerivativeProof* proof) {
        Numbers work(proof_doubles(*problem));
        hnav::Refusal why;
        return hnav::observer::prove(plant, *problem, *linearisation, 0, work.data(), proof, why);
    }

    Chain plant;
    Numbers memory, x;
    std::optional<Problem> problem;
    std::optional<Linearisation> linearisation;
};

TEST(ObserverDerivatives, GroupsGiveWhatSingleColumnsGive) {
    Linearised grouped(40), single(40, false);
    const Numbers J = grouped.jacobian(), expected = single.jacobian();
    ASSERT_EQ(J.size(), expected.size());
    for (std::size_t i = 0; i < J.size(); ++i) EXPECT_NEAR(J[i], expected[i], 1e-9) << i;
    // Neighbours of neighbours, both inputs together, the parameter.
    EXPECT_EQ(grouped.plant.evaluations, 2 * (3 + 1 + 1));
    EXPECT_EQ(single.plant.evaluations, 2 * 43);
    EXPECT_EQ(grouped.jacobian(Function::outputs), single.jacobian(Function::outputs));
    Linearised other(40, false);
    other.linearisation->take_choices(*grouped.linearisation);
    EXPECT_EQ(other.jacobian(), J);
    EXPECT_EQ(other.plant.evaluations, 10);
}

TEST(ObserverDerivatives, ManyPointsInACallGiveTheSameBits) {
    for (const bool declared : {true, false}) {
        Linearised single(12, declared), many(12, declared, 31), few(12, declared, 4);
        for (const Function f : {Function::derivatives, Function::outputs}) {
            const Numbers expected = single.linearised(f);
            EXPECT_EQ(single.plant.calls, 0);
            EXPECT_EQ(many.linearised(f), expected);
            EXPECT_EQ(many.plant.calls, 1);
            EXPECT_EQ(many.plant.evaluations, single.plant.evaluations);
            EXPECT_EQ(few.linearised(f), expected);
            EXPECT_EQ(few.plant.calls, f == Function::derivatives && declared ? 5 : 15);
        }
    }
}

TEST(ObserverDerivatives, APointWithoutAnAnswerLeavesTheOthers) {
    Linearised single(12), many(12, true, 31);
    for (Linearised* of : {&single, &many}) of->plant.highest = of->x[11];
    EXPECT_EQ(many.linearised(Function::derivatives), single.linearised(Function::derivatives));
    EXPECT_EQ(many.plant.calls, 1);
}

TEST(ObserverDerivatives, NoRowHasTwoColumnsOfAGroup) {
    const Linearised of(17);
    const Dependencies& d = of.linearisation->dependencies();
    std::set<int> members;
    for (int g = 0; g < d.last_group(Variable::parameter); ++g) {
        std::set<int> rows;
        for (const int j : d.group(g)) {
            EXPECT_TRUE(members.insert(j).second);
            for (const int i : d.column(j)) EXPECT_TRUE(rows.insert(i).second) << i << " of group " << g;
        }
    }
    EXPECT_EQ(members.size(), 20u);
    for (int i = 0; i < 19; ++i)
        for (int j = 0; j < 20; ++j) {
            const bool depends = i >= 17 ? i == j : j >= 19 || of.plant.depends(i, j);
            EXPECT_EQ(std::count(d.row(i).begin(), d.row(i).end(), j), depends) << i << ", " << j;
            const bool listed = i < 17 && std::count(d.column(j).begin(), d.column(j).end(), i) == 1;
            EXPECT_EQ(listed, i < 17 && depends);
        }
}

TEST(ObserverDerivatives, AGroupThatHasNoAnswerGoesColumnByColumn) {
    Linearised at_end(12), free(12);
    at_end.plant.highest = at_end.x[11]; // the largest of the states
    const Numbers J = at_end.jacobian(), expected = free.jacobian();
    for (std::size_t i = 0; i < J.size(); ++i) EXPECT_NEAR(J[i], expected[i], 2e-5) << i;
    at_end.plant.highest = 0;
    Numbers none(J.size());
    EXPECT_EQ(at_end.linearisation->jacobian(at_end.plant, Function::derivatives, at_end.at(), none.data()), Answer::elsewhere);
}

TEST(ObserverDerivatives, AWrongDeclarationIsFoundAndNotUsed) {
    for (const bool secret : {false, true}) {
        Linearised of(12, false);
        of.plant.secret = secret;
        DerivativeProof proof;
        ASSERT_TRUE(of.prove(&proof));
        const BlockProof& block = proof.block[int(Function::derivatives)][int(Variable::state)];
        EXPECT_EQ(block.offered, secret);
        EXPECT_FALSE(proof.block[int(Function::derivatives)][int(Variable::unknown_input)].offered);
        const Numbers J = of.jacobian();
        EXPECT_EQ(of.plant.evaluations, secret ? 2 * 15 : 10);
        if (!secret) continue;
        EXPECT_EQ(std::make_pair(block.row, block.column), std::make_pair(0, 11));
        EXPECT_EQ(block.stated, 0);
        EXPECT_NEAR(block.measured, 1e-3, 1e-9);
        EXPECT_NEAR(J[11], 1e-3, 1e-9);
    }
}

TEST(ObserverDerivatives, WithoutADeclarationNothingIsProved) {
    Linearised of(12, false);
    of.plant.declares = false;
    DerivativeProof proof;
    ASSERT_TRUE(of.prove(&proof));
    of.jacobian();
    EXPECT_EQ(of.plant.evaluations, 2 * 15);
}

} // namespace
