#include "hybrid/event_queue.hpp"
#include "laws.hpp"
#include "pendulum.hpp"

#include <algorithm>
#include <vector>

using namespace hnav;
using hnav::test::Pendulum;

namespace {

using PendulumFilter = Filter<Pendulum>;

// The truth by small Runge-Kutta steps, sampled at 20 Hz; torque steps every half second.
std::vector<Sample> pendulum_samples(double duration_s) {
    test::Random random(1);
    std::vector<Sample> samples;
    double a = 0.9, w = 0;
    const double h = 1e-4;
    double u = 0;
    for (long k = 0; k * h < duration_s; ++k) {
        if (k % 5000 == 0) {
            u = std::sin(k * h);
            samples.push_back({k * h, Pendulum::torque, {u, 0, 0}});
        }
        if (k % 500 == 0) samples.push_back({k * h, Pendulum::angle, {a + random.normal(0.01), 0, 0}});
        const auto acceleration = [&](double angle, double rate) { return -9.81 * std::sin(angle) - 0.2 * rate + u; };
        const double mid_w = w + 0.5 * h * acceleration(a, w), mid_a = a + 0.5 * h * w;
        a += h * mid_w;
        w += h * acceleration(mid_a, mid_w);
    }
    return samples;
}

void create(PendulumFilter& filter, double horizon_s = 0, Integrator integrator = Integrator::erkstep) {
    PendulumFilter::Settings settings;
    settings.horizon_s = horizon_s;
    settings.queue_capacity = 256;
    settings.propagator.integrator = integrator;
    ASSERT_TRUE(filter.create(Pendulum{}, settings));
}

bool same_bits(const Pendulum::State& a, const Pendulum::State& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

} // namespace

TEST(EventQueue, SortsByTimeAndJoinsSamplesOfOneInstant) {
    std::vector<double> memory(EventQueue<double>::bytes(8) / 8 + 1);
    EventQueue<double> queue;
    queue.create(memory.data(), 8);
    for (const Sample& s : {Sample{2, 1, {}}, Sample{1, 0, {}}, Sample{3, 0, {}}, Sample{2, 0, {}}})
        ASSERT_TRUE(queue.insert(s, 0));
    ASSERT_EQ(queue.size(), 3);
    EXPECT_EQ(queue.at(0).event.t_s, 1);
    EXPECT_EQ(queue.at(1).event.t_s, 2);
    EXPECT_TRUE(queue.at(1).event.has(0) && queue.at(1).event.has(1));
    EXPECT_EQ(queue.at(2).event.t_s, 3);
}

TEST(EventQueue, ASecondSampleOfAChannelFollowsTheFirst) {
    std::vector<double> memory(EventQueue<double>::bytes(8) / 8 + 1);
    EventQueue<double> queue;
    queue.create(memory.data(), 8);
    ASSERT_TRUE(queue.insert({1, 0, {10, 0, 0}}, 0));
    ASSERT_TRUE(queue.insert({1, 0, {20, 0, 0}}, 0));
    ASSERT_TRUE(queue.insert({1, 1, {30, 0, 0}}, 0));
    ASSERT_EQ(queue.size(), 2);
    EXPECT_EQ(queue.at(0).event.value[0][0], 10);
    EXPECT_EQ(queue.at(0).event.value[1][0], 30);
    EXPECT_EQ(queue.at(1).event.value[0][0], 20);
}

TEST(EventQueue, SaysWhenItIsFullAndGoesOnAfterRemoval) {
    std::vector<double> memory(EventQueue<double>::bytes(2) / 8 + 1);
    EventQueue<double> queue;
    queue.create(memory.data(), 2);
    EXPECT_TRUE(queue.insert({1, 0, {}}, 0));
    EXPECT_TRUE(queue.insert({2, 0, {}}, 0));
    EXPECT_FALSE(queue.insert({3, 0, {}}, 0));
    EXPECT_TRUE(queue.insert({2, 1, {}}, 0)); // joins
    queue.remove(0);
    EXPECT_TRUE(queue.insert({3, 0, {}}, 0));
    EXPECT_EQ(queue.at(1).event.t_s, 3);
}

TEST(Propagator, IntegratorsAgreeOnALinearOscillator) {
    const auto flow = [](const void*, const double* x, double* dx) {
        dx[0] = x[1];
        dx[1] = -4 * x[0];
    };
    const double atol[2] = {1e-12, 1e-12}, probe[2] = {1, 0};
    for (const auto& [integrator, tolerance] :
         {std::pair<Integrator, double>{Integrator::erkstep, 1e-8}, {Integrator::adams, 1e-6}, {Integrator::euler, 3e-2}}) {
        Propagator propagator;
        Propagator::Settings settings;
        settings.integrator = integrator;
        settings.rtol = 1e-10;
        settings.atol = atol;
        settings.euler_step_s = 1e-3;
        ASSERT_TRUE(propagator.create(2, flow, settings, nullptr, probe));
        double x[2] = {1, 0};
        ASSERT_TRUE(propagator.integrate(nullptr, 3.0, x));
        EXPECT_NEAR(x[0], std::cos(6.0), tolerance);
        EXPECT_GT(propagator.rhs_evals(), 0u);
    }
}

TEST(Propagator, RemembersNothingOfTheIntervalBefore) {
    const auto flow = [](const void*, const double* x, double* dx) { dx[0] = -x[0] * x[0]; };
    const double atol = 1e-12, probe = 1;
    for (const Integrator integrator : {Integrator::erkstep, Integrator::adams, Integrator::euler}) {
        Propagator propagator;
        Propagator::Settings settings;
        settings.integrator = integrator;
        settings.atol = &atol;
        ASSERT_TRUE(propagator.create(1, flow, settings, nullptr, &probe));
        double first = 1, other = 5, second = 1;
        ASSERT_TRUE(propagator.integrate(nullptr, 0.37, &first));
        ASSERT_TRUE(propagator.integrate(nullptr, 2.9, &other));
        ASSERT_TRUE(propagator.integrate(nullptr, 0.37, &second));
        EXPECT_EQ(first, second);
    }
}

TEST(Propagator, EulerConvergesAtFirstOrder) {
    const auto flow = [](const void*, const double* x, double* dx) { dx[0] = -x[0]; };
    double error[2];
    for (int i = 0; i < 2; ++i) {
        Propagator propagator;
        Propagator::Settings settings;
        settings.integrator = Integrator::euler;
        settings.euler_step_s = 1e-3 / (1 + i);
        ASSERT_TRUE(propagator.create(1, flow, settings, nullptr, nullptr));
        double x = 1;
        ASSERT_TRUE(propagator.integrate(nullptr, 1.0, &x));
        error[i] = std::fabs(x - std::exp(-1.0));
    }
    EXPECT_NEAR(error[0] / error[1], 2, 0.01);
}

TEST(HybridFilter, APendulumConvergesFromAWrongStart) {
    PendulumFilter filter;
    create(filter);
    for (const Sample& s : pendulum_samples(10)) ASSERT_EQ(filter.push(s), Outcome::ok);
    ASSERT_EQ(filter.advance(10), Outcome::ok);
    EXPECT_LT(std::sqrt(filter.shown().x[2]), 0.01);
    EXPECT_GT(filter.propagator().rhs_evals(), 1000u);
    // The first estimate was half a radian off; the last innovation must be noise.
    const Sample last = pendulum_samples(10).back();
    EXPECT_NEAR(filter.newest().x[0], last.value[0], 0.05);
}

TEST(HybridFilter, TimesThatAreAskedForDoNotChangeTheEstimate) {
    const auto samples = pendulum_samples(3);
    Pendulum::State reference{};
    for (const double step : {3.0, 0.01, 0.0037, 0.0173, 1.0}) {
        PendulumFilter filter;
        create(filter);
        std::size_t next = 0;
        for (double t = 0; t < 3; t = std::fmin(3, t + step)) {
            while (next < samples.size() && samples[next].t_s <= t + step) ASSERT_EQ(filter.push(samples[next++]), Outcome::ok);
            ASSERT_EQ(filter.advance(std::fmin(3, t + step)), Outcome::ok);
        }
        if (step == 3.0) reference = filter.newest();
        EXPECT_TRUE(same_bits(filter.newest(), reference)) << "step " << step;
    }
}

TEST(HybridFilter, SamplesWithinTheHorizonMayComeLateAndChangeNoBit) {
    const auto samples = pendulum_samples(3);
    PendulumFilter in_order, late;
    create(in_order, 0.3);
    create(late, 0.3);
    for (const Sample& s : samples) {
        ASSERT_EQ(in_order.push(s), Outcome::ok);
        ASSERT_EQ(in_order.advance(s.t_s), Outcome::ok);
    }
    // Every fourth sample is handed over after the next four.
    std::vector<Sample> shuffled = samples;
    for (std::size_t i = 0; i + 4 < shuffled.size(); i += 4) std::rotate(&shuffled[i], &shuffled[i + 1], &shuffled[i + 4]);
    double now = 0;
    for (const Sample& s : shuffled) {
        ASSERT_EQ(late.push(s), Outcome::ok);
        now = std::fmax(now, s.t_s);
        ASSERT_EQ(late.advance(now), Outcome::ok);
    }
    EXPECT_TRUE(same_bits(in_order.newest(), late.newest()));
    EXPECT_EQ(late.refused.late, 0u);
}

TEST(HybridFilter, SamplesBeyondTheHorizonAreRefusedAndCounted) {
    PendulumFilter filter;
    create(filter, 0.1);
    ASSERT_EQ(filter.push({1.0, Pendulum::angle, {0.5, 0, 0}}), Outcome::ok);
    ASSERT_EQ(filter.advance(1.0), Outcome::ok);
    const Pendulum::State before = filter.newest();
    EXPECT_EQ(filter.push({0.85, Pendulum::angle, {0.1, 0, 0}}), Outcome::late);
    ASSERT_EQ(filter.advance(1.0), Outcome::ok);
    EXPECT_TRUE(same_bits(filter.newest(), before));
    EXPECT_EQ(filter.refused.late, 1u);
    EXPECT_EQ(filter.push({0.95, Pendulum::angle, {0.1, 0, 0}}), Outcome::ok);
}

TEST(HybridFilter, AnEqualTimeSampleJoinsAnEventThatWasShownAlready) {
    PendulumFilter together, apart;
    create(together);
    create(apart);
    for (PendulumFilter* f : {&together, &apart}) {
        ASSERT_EQ(f->push({1.0, Pendulum::angle, {0.4, 0, 0}}), Outcome::ok);
        if (f == &apart) {
            ASSERT_EQ(f->advance(1.0), Outcome::ok);
        }
        ASSERT_EQ(f->push({1.0, Pendulum::torque, {2, 0, 0}}), Outcome::ok);
        ASSERT_EQ(f->advance(1.5), Outcome::ok);
    }
    EXPECT_TRUE(same_bits(together.newest(), apart.newest()));
    EXPECT_EQ(apart.newest().jumps, 1);
}

TEST(HybridFilter, TimeDoesNotRunBackwards) {
    PendulumFilter filter;
    create(filter);
    ASSERT_EQ(filter.advance(1), Outcome::ok);
    EXPECT_EQ(filter.advance(0.5), Outcome::backwards);
    EXPECT_EQ(filter.now_s(), 1);
}

TEST(HybridFilter, OneAdvanceDropsAllThatLeadToNoFiniteStateAndUsesTheRest) {
    PendulumFilter struck, spared;
    create(struck);
    create(spared);
    for (const Sample& good : {Sample{1.0, Pendulum::angle, {0.4, 0, 0}}, Sample{1.4, Pendulum::angle, {0.3, 0, 0}}})
        for (PendulumFilter* f : {&struck, &spared}) {
            ASSERT_EQ(f->push(good), Outcome::ok);
        }
    for (const double t_s : {1.1, 1.2, 1.3}) {
        ASSERT_EQ(struck.push({t_s, Pendulum::angle, {1e300, 0, 0}}), Outcome::ok);
    }
    EXPECT_EQ(struck.advance(1.5), Outcome::diverged);
    ASSERT_EQ(spared.advance(1.5), Outcome::ok);
    EXPECT_EQ(struck.waiting(), 0);
    EXPECT_EQ(struck.now_s(), 1.5);
    EXPECT_TRUE(same_bits(struck.shown(), spared.shown()));
    EXPECT_EQ(struck.advance(1.6), Outcome::ok);
}

TEST(HybridFilter, SaveWreckLoadGoOnIsBitEqual) {
    const auto samples = pendulum_samples(4);
    for (const double horizon_s : {0.0, 0.3}) {
        PendulumFilter straight, interrupted;
        create(straight, horizon_s);
        create(interrupted, horizon_s);
        std::vector<unsigned char> saved(straight.state_size());
        for (std::size_t i = 0; i < samples.size(); ++i) {
            for (PendulumFilter* f : {&straight, &interrupted}) {
                ASSERT_EQ(f->push(samples[i]), Outcome::ok);
                ASSERT_EQ(f->advance(samples[i].t_s + 0.003), Outcome::ok);
            }
            if (i == samples.size() / 2) {
                interrupted.save(saved.data());
                ASSERT_EQ(interrupted.push({samples[i].t_s + 0.01, Pendulum::angle, {3, 0, 0}}), Outcome::ok);
                ASSERT_EQ(interrupted.advance(samples[i].t_s + 1), Outcome::ok);
                ASSERT_EQ(interrupted.load(saved.data(), saved.size()), LoadOutcome::ok);
                EXPECT_TRUE(same_bits(interrupted.shown(), straight.shown()));
            }
        }
        EXPECT_TRUE(same_bits(straight.shown(), interrupted.shown()));
        EXPECT_EQ(straight.propagator().rhs_evals(), interrupted.propagator().rhs_evals());
    }
}

TEST(HybridFilter, EverySingleDamagedByteOfASavedStateIsFound) {
    PendulumFilter filter;
    PendulumFilter::Settings settings;
    settings.queue_capacity = 4;
    ASSERT_TRUE(filter.create(Pendulum{}, settings));
    ASSERT_EQ(filter.push({1.0, Pendulum::angle, {0.4, 0, 0}}), Outcome::ok);
    ASSERT_EQ(filter.advance(1.2), Outcome::ok);
    std::vector<unsigned char> saved(filter.state_size());
    filter.save(saved.data());
    const Pendulum::State before = filter.shown();
    for (std::size_t i = 0; i < saved.size(); ++i) {
        saved[i] ^= 0x10;
        EXPECT_EQ(filter.load(saved.data(), saved.size()), LoadOutcome::damaged) << "byte " << i;
        saved[i] ^= 0x10;
    }
    EXPECT_EQ(filter.load(saved.data(), saved.size() - 8), LoadOutcome::size);
    EXPECT_TRUE(same_bits(filter.shown(), before));
    EXPECT_EQ(filter.load(saved.data(), saved.size()), LoadOutcome::ok);
}

TEST(HybridFilter, AnIntegratorOutsideReachesTheSameEstimate) {
    PendulumFilter inside, outside;
    create(inside);
    create(outside);
    double x[Pendulum::nx];
    std::memcpy(x, outside.newest().x, sizeof x);
    double t = 0;
    for (const Sample& s : pendulum_samples(2)) {
        ASSERT_EQ(inside.push(s), Outcome::ok);
        ASSERT_EQ(inside.advance(s.t_s), Outcome::ok);
        // Small midpoint steps to the event, then the jump.
        const int steps = static_cast<int>(std::ceil((s.t_s - t) / 1e-4 - 1e-9));
        for (int k = 0; k < steps; ++k) {
            const double h = (s.t_s - t) / steps;
            double slope[Pendulum::nx], mid[Pendulum::nx];
            outside.derivative(x, slope);
            for (int i = 0; i < Pendulum::nx; ++i) mid[i] = x[i] + 0.5 * h * slope[i];
            outside.derivative(mid, slope);
            for (int i = 0; i < Pendulum::nx; ++i) x[i] += h * slope[i];
        }
        t = s.t_s;
        ASSERT_EQ(outside.push(s), Outcome::ok);
        EXPECT_EQ(outside.next_event_s(), s.t_s);
        ASSERT_EQ(outside.jump(s.t_s, x, x), Outcome::ok);
        EXPECT_TRUE(std::isinf(outside.next_event_s()));
    }
    for (int i = 0; i < Pendulum::nx; ++i) EXPECT_NEAR(x[i], inside.newest().x[i], 1e-6);
}
