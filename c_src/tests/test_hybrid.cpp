#include "counted_heap.hpp"
#include "hybrid/event_queue.hpp"
#include "laws.hpp"
#include "pendulum.hpp"
#include "pendulum_chain.hpp"

#include <algorithm>
#include <vector>

using namespace hnav;
using hnav::test::Pendulum;
using hnav::test::PendulumChain;

namespace {

// One number of one channel, for models of both kinds.
struct Reading {
    double t_s;
    int channel;
    double value;
};

// A chain of so many links; 0: the pendulum, whose size is known at compile time.
template <int links>
struct Kind {
    using Model = PendulumChain;
    static Model model() { return Model(links); }
    static double jumps(const Filter<Model>& f) { return f.model().jumps(f.newest()); }
    static const double* x(const RuntimeState& s) { return s.x(); }
    static RuntimeEvent::Sample sample(const Reading& r) { return {r.t_s, r.channel, &r.value}; }
};

template <>
struct Kind<0> {
    using Model = Pendulum;
    static Model model() { return {}; }
    static double jumps(const Filter<Model>& f) { return f.newest().jumps; }
    static const double* x(const Pendulum::State& s) { return s.x; }
    static Pendulum::Event::Sample sample(const Reading& r) { return {r.t_s, r.channel, {r.value}}; }
};

// The truth of one pendulum by small Runge-Kutta steps, sampled at 20 Hz; torque steps every half second. The other links
// of a chain read the same angle.
std::vector<Reading> readings(double duration_s, int links) {
    test::Random random(1);
    std::vector<Reading> samples;
    double a = 0.9, w = 0;
    const double h = 1e-4;
    double u = 0;
    for (long k = 0; k * h < duration_s; ++k) {
        if (k % 5000 == 0) {
            u = std::sin(k * h);
            samples.push_back({k * h, 0, u});
        }
        if (k % 500 == 0)
            for (int i = 0; i < links; ++i) samples.push_back({k * h, 1 + i, a + random.normal(0.01)});
        const auto acceleration = [&](double angle, double rate) { return -9.81 * std::sin(angle) - 0.2 * rate + u; };
        const double mid_w = w + 0.5 * h * acceleration(a, w), mid_a = a + 0.5 * h * w;
        a += h * mid_w;
        w += h * acceleration(mid_a, mid_w);
    }
    return samples;
}

// A filter of one kind with accessors for the tests.
template <class K>
class Tested : public Filter<typename K::Model> {
public:
    using Base = Filter<typename K::Model>;
    using Bytes = std::vector<unsigned char>;

    explicit Tested(double horizon_s = 0, int queue_capacity = 256) {
        typename Base::Settings settings;
        settings.horizon_s = horizon_s;
        settings.queue_capacity = queue_capacity;
        EXPECT_TRUE(this->create(K::model(), settings));
    }

    Outcome push(const Reading& r) { return Base::push(K::sample(r)); }
    double jumps() const { return K::jumps(*this); }
    double newest_x(int i) const { return K::x(this->newest())[i]; }
    // States as bytes: equal bytes, equal bits.
    Bytes newest_bytes() const { return bytes_of(this->newest()); }
    Bytes shown_bytes() const { return bytes_of(this->shown()); }
    Bytes saved() const {
        Bytes buffer(this->state_size());
        this->save(buffer.data());
        return buffer;
    }

private:
    Bytes bytes_of(const typename Base::State& state) const {
        const auto* first = reinterpret_cast<const unsigned char*>(&state);
        return Bytes(first, first + sizes_of(this->model()).state_bytes());
    }
};

// The laws hold for models of either kind.
template <class K>
class HybridFilter : public testing::Test {
public:
    using F = Tested<K>;
    static int links() { return K::model().channels() - 1; }
};
template <>
int HybridFilter<Kind<0>>::links() {
    return 1;
}

struct Names {
    template <class K>
    static std::string GetName(int) {
        if (std::is_same_v<K, Kind<0>>) return "Pendulum";
        return "ChainOf" + std::to_string(HybridFilter<K>::links());
    }
};
using Kinds = testing::Types<Kind<0>, Kind<1>, Kind<3>, Kind<12>>;
TYPED_TEST_SUITE(HybridFilter, Kinds, Names);

} // namespace

namespace {

struct Queue : EventQueue<FixedSizes<FixedEvent<2, 3>, double>> {
    explicit Queue(int capacity) : memory(bytes({}, capacity) / 8 + 1) { create(memory.data(), {}, capacity); }
    std::vector<double> memory;
};
using QueueSample = Queue::Event::Sample;

} // namespace

TEST(EventQueue, SortsByTimeAndJoinsSamplesOfOneInstant) {
    Queue queue(8);
    for (const QueueSample& s : {QueueSample{2, 1, {}}, QueueSample{1, 0, {}}, QueueSample{3, 0, {}}, QueueSample{2, 0, {}}})
        ASSERT_TRUE(queue.insert(s, s.t_s, 0));
    ASSERT_EQ(queue.size(), 3);
    EXPECT_EQ(queue.event(0).t_s, 1);
    EXPECT_EQ(queue.event(1).t_s, 2);
    EXPECT_TRUE(queue.event(1).has(0) && queue.event(1).has(1));
    EXPECT_EQ(queue.event(2).t_s, 3);
}

TEST(EventQueue, ASecondSampleOfAChannelFollowsTheFirst) {
    Queue queue(8);
    ASSERT_TRUE(queue.insert({1, 0, {10, 0, 0}}, 1, 0));
    ASSERT_TRUE(queue.insert({1, 0, {20, 0, 0}}, 1, 0));
    ASSERT_TRUE(queue.insert({1, 1, {30, 0, 0}}, 1, 0));
    ASSERT_EQ(queue.size(), 2);
    EXPECT_EQ(queue.event(0).value[0][0], 10);
    EXPECT_EQ(queue.event(0).value[1][0], 30);
    EXPECT_EQ(queue.event(1).value[0][0], 20);
}

TEST(EventQueue, StampsThatDifferInTheirLastBitsAreOneInstantOfTheEarliest) {
    for (const double t_s : {0.01, 10.0, 1.7e9}) {
        const double bits_s = std::fmax(1e-13, std::nextafter(t_s, 2 * t_s) - t_s);
        std::vector<QueueSample> samples{{t_s + bits_s, 0, {}}, {t_s + 2 * bits_s, 0, {}}, {t_s, 1, {}}};
        const auto by_channel = [](const QueueSample& a, const QueueSample& b) { return a.channel < b.channel; };
        do {
            Queue queue(8);
            for (const QueueSample& s : samples) ASSERT_TRUE(queue.insert(s, s.t_s, 0));
            ASSERT_EQ(queue.size(), 2); // channel 0 has two
            EXPECT_EQ(queue.event(0).t_s, t_s);
            EXPECT_EQ(queue.event(0).present, 3u);
            EXPECT_TRUE(queue.event(1).has(0));
            EXPECT_GE(queue.event(1).t_s, t_s);
            ASSERT_TRUE(queue.insert({t_s + 1e-3, 1, {}}, t_s + 1e-3, 0)); // another one
            EXPECT_EQ(queue.size(), 3);
        } while (std::next_permutation(samples.begin(), samples.end(), by_channel));
    }
}

TEST(EventQueue, SaysWhenItIsFullAndGoesOnAfterRemoval) {
    Queue queue(2);
    EXPECT_TRUE(queue.insert({1, 0, {}}, 1, 0));
    EXPECT_TRUE(queue.insert({2, 0, {}}, 2, 0));
    EXPECT_FALSE(queue.insert({3, 0, {}}, 3, 0));
    EXPECT_TRUE(queue.insert({2, 1, {}}, 2, 0)); // joins
    queue.remove(0);
    EXPECT_TRUE(queue.insert({3, 0, {}}, 3, 0));
    EXPECT_EQ(queue.event(1).t_s, 3);
}

TEST(Propagator, IntegratorsAgreeOnALinearOscillator) {
    const auto flow = [](const void*, const double* x, double* dx) {
        dx[0] = x[1];
        dx[1] = -4 * x[0];
        return 0;
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
        EXPECT_GT(propagator.steps(), 0u);
        EXPECT_GE(propagator.rhs_evals(), propagator.steps());
    }
}

// Oscillators of one rate; the last place is a clock. Their number gives vectors of every length.
struct Oscillators {
    int pairs;
    double rate;

    int nx() const { return 2 * pairs + 1; }
    static int flow(const void* self, const double* x, double* dx) {
        const auto& o = *static_cast<const Oscillators*>(self);
        for (int k = 0; k < o.pairs; ++k) {
            dx[2 * k] = o.rate * x[2 * k + 1];
            dx[2 * k + 1] = -o.rate * x[2 * k];
        }
        dx[2 * o.pairs] = 1;
        return 0;
    }
    std::vector<double> start() const {
        std::vector<double> x(nx());
        for (int k = 0; k < pairs; ++k) x[2 * k] = k + 1;
        return x;
    }
};

TEST(Propagator, AKnownRateTakesTheStepsThatToleranceAsksFor) {
    for (const int pairs : {1, 3, 7, 12, 17, 50})
        for (const double rtol : {1e-6, 1e-8, 1e-11})
            for (const double turn : {0.0, 0.01, 0.1, 0.3, 0.8, 20.0}) {
                const double interval_s = 0.05;
                const Oscillators body{pairs, turn / interval_s};
                const std::vector<double> atol(body.nx(), rtol);
                const double tolerance = 1e-14 + (turn > 1 ? 1000 : 20) * rtol;
                Propagator propagator;
                Propagator::Settings settings;
                settings.rtol = rtol;
                settings.atol = atol.data();
                settings.bounds_rate = true;
                std::vector<double> x = body.start();
                ASSERT_TRUE(propagator.create(body.nx(), Oscillators::flow, settings, &body, x.data()));
                ASSERT_TRUE(propagator.integrate(&body, interval_s, x.data(), body.rate));
                for (int k = 0; k < pairs; ++k) {
                    EXPECT_NEAR(x[2 * k], (k + 1) * std::cos(turn), (k + 1) * tolerance);
                    EXPECT_NEAR(x[2 * k + 1], -(k + 1) * std::sin(turn), (k + 1) * tolerance);
                }
                EXPECT_NEAR(x[2 * pairs], interval_s, 1e-15);
                if (rtol == 1e-8 && turn <= 0.1) {
                    EXPECT_EQ(propagator.steps(), 1u);
                    EXPECT_EQ(propagator.rhs_evals(), 6u);
                }
            }
}

// Where error control accepts the whole interval as one step, the step is the same with and without the error estimate.
TEST(Propagator, AKnownRateLeavesTheBitsOfAStepAlone) {
    const Oscillators body{17, 6};
    const std::vector<double> atol(body.nx(), 1e-8);
    std::vector<double> x[2] = {body.start(), body.start()};
    for (const bool bounds_rate : {false, true}) {
        Propagator propagator;
        Propagator::Settings settings;
        settings.atol = atol.data();
        settings.bounds_rate = bounds_rate;
        ASSERT_TRUE(propagator.create(body.nx(), Oscillators::flow, settings, &body, x[0].data()));
        for (int k = 0; k < 100; ++k)
            ASSERT_TRUE(
                propagator.integrate(&body, 0.01, x[bounds_rate].data(), bounds_rate ? body.rate : Propagator::unknown_rate));
        EXPECT_EQ(propagator.steps(), 100u);
    }
    EXPECT_EQ(x[0], x[1]);
}

TEST(Propagator, ARateBeyondAllSenseIsLeftToErrorControl) {
    const Oscillators body{1, 6};
    const std::vector<double> atol(body.nx(), 1e-8);
    for (const double claimed : {1e9, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        Propagator propagator;
        Propagator::Settings settings;
        settings.atol = atol.data();
        settings.bounds_rate = true;
        std::vector<double> x = body.start();
        ASSERT_TRUE(propagator.create(body.nx(), Oscillators::flow, settings, &body, x.data()));
        ASSERT_TRUE(propagator.integrate(&body, 0.01, x.data(), claimed));
        EXPECT_NEAR(x[0], std::cos(0.06), 1e-8);
        EXPECT_GT(propagator.rhs_evals(), 6u);
    }
}

TEST(Propagator, RemembersNothingOfTheIntervalBefore) {
    const auto flow = [](const void*, const double* x, double* dx) {
        dx[0] = -x[0] * x[0];
        return 0;
    };
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

// A flow without a value beyond 3 is integrated up to there, and one without any value fails; the solver stays usable.
TEST(Propagator, AFlowMayBeWithoutAnAnswer) {
    const auto flow = [](const void* broken, const double* x, double* dx) {
        if (*static_cast<const bool*>(broken)) return -1;
        dx[0] = -x[0] * x[0] * x[0];
        return std::fabs(x[0]) > 3 ? 1 : 0;
    };
    for (const Integrator integrator : {Integrator::erkstep, Integrator::adams, Integrator::euler}) {
        Propagator propagator;
        Propagator::Settings settings;
        settings.integrator = integrator;
        settings.euler_step_s = 1e-4;
        const double atol = 1e-10, probe = 1;
        settings.atol = &atol;
        bool broken = false;
        ASSERT_TRUE(propagator.create(1, flow, settings, &broken, &probe));
        double x = 2.9; // one step over the whole interval would lead beyond -3
        EXPECT_TRUE(propagator.integrate(&broken, 1.0, &x));
        EXPECT_NEAR(x, 1 / std::sqrt(2 + 1 / (2.9 * 2.9)), 1e-3);
        broken = true;
        EXPECT_FALSE(propagator.integrate(&broken, 1.0, &(x = 1)));
        broken = false;
        EXPECT_TRUE(propagator.integrate(&broken, 1.0, &(x = 1)));
        EXPECT_NEAR(x, 1 / std::sqrt(3.0), 1e-3);
    }
}

TEST(Propagator, EulerConvergesAtFirstOrder) {
    const auto flow = [](const void*, const double* x, double* dx) {
        dx[0] = -x[0];
        return 0;
    };
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

TYPED_TEST(HybridFilter, ConvergesFromAWrongStart) {
    typename TestFixture::F filter;
    const auto samples = readings(10, this->links());
    for (const Reading& s : samples) {
        ASSERT_EQ(filter.push(s), Outcome::ok);
        ASSERT_EQ(filter.advance(s.t_s), Outcome::ok);
    }
    const int n = 2 * this->links();
    EXPECT_LT(std::sqrt(filter.newest_x(n)), 0.01);
    EXPECT_GT(filter.propagator().rhs_evals(), 1000u);
    // The first estimate was half a radian off; the last innovation must have the size of the noise.
    EXPECT_NEAR(filter.newest_x(this->links() - 1), samples.back().value, 0.05);
}

TYPED_TEST(HybridFilter, TimesThatAreAskedForDoNotChangeTheEstimate) {
    const auto samples = readings(3, this->links());
    typename TestFixture::F::Bytes reference;
    for (const double step : {3.0, 0.01, 0.0037, 0.0173, 1.0}) {
        typename TestFixture::F filter(0, 1024);
        std::size_t next = 0;
        for (double t = 0; t < 3; t = std::fmin(3, t + step)) {
            while (next < samples.size() && samples[next].t_s <= t + step) ASSERT_EQ(filter.push(samples[next++]), Outcome::ok);
            ASSERT_EQ(filter.advance(std::fmin(3, t + step)), Outcome::ok);
        }
        if (step == 3.0) reference = filter.newest_bytes();
        EXPECT_EQ(filter.newest_bytes(), reference) << "step " << step;
    }
}

TYPED_TEST(HybridFilter, SamplesWithinTheHorizonMayComeLateAndChangeNoBit) {
    const auto samples = readings(3, this->links());
    typename TestFixture::F in_order(0.3), late(0.3);
    for (const Reading& s : samples) {
        ASSERT_EQ(in_order.push(s), Outcome::ok);
        ASSERT_EQ(in_order.advance(s.t_s), Outcome::ok);
    }
    // Every fourth sample is pushed after the next four.
    std::vector<Reading> shuffled = samples;
    for (std::size_t i = 0; i + 4 < shuffled.size(); i += 4) std::rotate(&shuffled[i], &shuffled[i + 1], &shuffled[i + 4]);
    double now = 0;
    for (const Reading& s : shuffled) {
        ASSERT_EQ(late.push(s), Outcome::ok);
        now = std::fmax(now, s.t_s);
        ASSERT_EQ(late.advance(now), Outcome::ok);
    }
    EXPECT_EQ(in_order.newest_bytes(), late.newest_bytes());
    EXPECT_EQ(late.refused.late, 0u);
}

TYPED_TEST(HybridFilter, SamplesBeyondTheHorizonAreRefusedAndCounted) {
    typename TestFixture::F filter(0.1);
    ASSERT_EQ(filter.push({1.0, 1, 0.5}), Outcome::ok);
    ASSERT_EQ(filter.advance(1.0), Outcome::ok);
    const auto before = filter.newest_bytes();
    EXPECT_EQ(filter.push({0.85, 1, 0.1}), Outcome::late);
    ASSERT_EQ(filter.advance(1.0), Outcome::ok);
    EXPECT_EQ(filter.newest_bytes(), before);
    EXPECT_EQ(filter.refused.late, 1u);
    EXPECT_EQ(filter.push({0.95, 1, 0.1}), Outcome::ok);
}

TYPED_TEST(HybridFilter, AnEqualTimeSampleJoinsAnEventThatWasShownAlready) {
    typename TestFixture::F together, apart;
    for (auto* f : {&together, &apart}) {
        ASSERT_EQ(f->push({1.0, 1, 0.4}), Outcome::ok);
        if (f == &apart) {
            ASSERT_EQ(f->advance(1.0), Outcome::ok);
        }
        ASSERT_EQ(f->push({1.0, 0, 2}), Outcome::ok);
        ASSERT_EQ(f->advance(1.5), Outcome::ok);
    }
    EXPECT_EQ(together.newest_bytes(), apart.newest_bytes());
    EXPECT_EQ(apart.jumps(), 1);
}

TYPED_TEST(HybridFilter, TimeDoesNotRunBackwards) {
    typename TestFixture::F filter;
    ASSERT_EQ(filter.advance(1), Outcome::ok);
    EXPECT_EQ(filter.advance(0.5), Outcome::backwards);
    EXPECT_EQ(filter.now_s(), 1);
}

TYPED_TEST(HybridFilter, OneAdvanceDropsAllThatLeadToNoFiniteStateAndUsesTheRest) {
    typename TestFixture::F struck, spared;
    for (const Reading& good : {Reading{1.0, 1, 0.4}, Reading{1.4, 1, 0.3}})
        for (auto* f : {&struck, &spared}) {
            ASSERT_EQ(f->push(good), Outcome::ok);
        }
    for (const double t_s : {1.1, 1.2, 1.3}) {
        ASSERT_EQ(struck.push({t_s, 1, 1e300}), Outcome::ok);
    }
    EXPECT_EQ(struck.advance(1.5), Outcome::diverged);
    ASSERT_EQ(spared.advance(1.5), Outcome::ok);
    EXPECT_EQ(struck.waiting(), 0);
    EXPECT_EQ(struck.now_s(), 1.5);
    EXPECT_EQ(struck.shown_bytes(), spared.shown_bytes());
    EXPECT_EQ(struck.advance(1.6), Outcome::ok);
}

TYPED_TEST(HybridFilter, AnIntervalThatCannotBeCrossedIsAnErrorWithoutAClosedForm) {
    typename TestFixture::F filter;
    ASSERT_EQ(filter.push({1.0, 1, 0.5}), Outcome::ok);
    ASSERT_EQ(filter.advance(1.0), Outcome::ok);
    const auto before = filter.newest_bytes();
    ASSERT_EQ(filter.push({1e9, 1, 0.1}), Outcome::ok);
    EXPECT_EQ(filter.advance(1e9), Outcome::diverged);
    EXPECT_EQ(filter.newest_bytes(), before);
    EXPECT_EQ(filter.waiting(), 0);
    EXPECT_EQ(filter.now_s(), 1.0);
    EXPECT_EQ(filter.advance(1.2), Outcome::ok);
    ASSERT_EQ(filter.push({1.3, 1, 0.1}), Outcome::ok);
    EXPECT_EQ(filter.advance(1.3), Outcome::ok);
    EXPECT_EQ(filter.jumps(), 2);
}

TYPED_TEST(HybridFilter, AnIntervalOfNoLengthToSpeakOfIsCrossed) {
    typename TestFixture::F filter;
    ASSERT_EQ(filter.push({1e-4, 1, 0.5}), Outcome::ok);
    ASSERT_EQ(filter.push({1e-4 + 1e-13, 1, 0.4}), Outcome::ok); // of one sensor: another event
    EXPECT_EQ(filter.advance(0.1), Outcome::ok);
    EXPECT_EQ(filter.jumps(), 2);
}

TYPED_TEST(HybridFilter, StampsAndTimesThatDifferInTheirLastBitsAreOneInstant) {
    typename TestFixture::F filter;
    ASSERT_EQ(filter.push({1e-4 + 1e-13, 1, 0.5}), Outcome::ok);
    EXPECT_EQ(filter.advance(1e-4), Outcome::ok); // it has come
    EXPECT_EQ(filter.jumps(), 1);
    ASSERT_EQ(filter.push({1e-4 - 1e-13, 0, 1.0}), Outcome::ok); // its companion is not late
    EXPECT_EQ(filter.advance(1e-4 - 1e-13), Outcome::ok);        // and the time has not run back
    EXPECT_EQ(filter.jumps(), 1);
    EXPECT_EQ(filter.refused.late, 0u);
}

TYPED_TEST(HybridFilter, AClosedFormThatTheModelLacksIsRefused) {
    Filter<typename TypeParam::Model> filter;
    typename decltype(filter)::Settings settings;
    settings.closed_form = true;
    EXPECT_FALSE(filter.create(TypeParam::model(), settings));
}

TYPED_TEST(HybridFilter, SaveWreckLoadGoOnIsBitEqual) {
    const auto samples = readings(4, this->links());
    for (const double horizon_s : {0.0, 0.3}) {
        typename TestFixture::F straight(horizon_s), interrupted(horizon_s);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            for (auto* f : {&straight, &interrupted}) {
                ASSERT_EQ(f->push(samples[i]), Outcome::ok);
                ASSERT_EQ(f->advance(samples[i].t_s + 0.003), Outcome::ok);
            }
            if (i == samples.size() / 2) {
                const auto saved = interrupted.saved();
                ASSERT_EQ(interrupted.push({samples[i].t_s + 0.01, 1, 3}), Outcome::ok);
                ASSERT_EQ(interrupted.advance(samples[i].t_s + 1), Outcome::ok);
                ASSERT_EQ(interrupted.load(saved.data(), saved.size()), LoadOutcome::ok);
                EXPECT_EQ(interrupted.shown_bytes(), straight.shown_bytes());
                EXPECT_EQ(interrupted.saved(), saved);
            }
        }
        EXPECT_EQ(straight.shown_bytes(), interrupted.shown_bytes());
        EXPECT_EQ(straight.propagator().rhs_evals(), interrupted.propagator().rhs_evals());
    }
}

TYPED_TEST(HybridFilter, ASavedStateGoesOnInAnotherFilterOfItsKindOnly) {
    typename TestFixture::F filter, twin;
    Tested<Kind<5>> stranger;
    ASSERT_EQ(filter.push({1.0, 1, 0.4}), Outcome::ok);
    ASSERT_EQ(filter.advance(1.2), Outcome::ok);
    const auto saved = filter.saved();
    ASSERT_EQ(twin.load(saved.data(), saved.size()), LoadOutcome::ok);
    EXPECT_EQ(twin.shown_bytes(), filter.shown_bytes());
    EXPECT_EQ(stranger.load(saved.data(), saved.size()), LoadOutcome::size);
}

TYPED_TEST(HybridFilter, EverySingleDamagedByteOfASavedStateIsFound) {
    typename TestFixture::F filter(0, 4);
    ASSERT_EQ(filter.push({1.0, 1, 0.4}), Outcome::ok);
    ASSERT_EQ(filter.advance(1.2), Outcome::ok);
    auto saved = filter.saved();
    const auto before = filter.shown_bytes();
    for (unsigned char& byte : saved) {
        byte ^= 0x10;
        EXPECT_EQ(filter.load(saved.data(), saved.size()), LoadOutcome::damaged) << "byte " << &byte - saved.data();
        byte ^= 0x10;
    }
    EXPECT_EQ(filter.load(saved.data(), saved.size() - 8), LoadOutcome::size);
    EXPECT_EQ(filter.shown_bytes(), before);
    EXPECT_EQ(filter.load(saved.data(), saved.size()), LoadOutcome::ok);
}

TYPED_TEST(HybridFilter, AnIntegratorOutsideReachesTheSameEstimate) {
    typename TestFixture::F inside, outside;
    const std::size_t nx = static_cast<std::size_t>(inside.nx());
    std::vector<double> x(nx), slope(nx), mid(nx);
    for (std::size_t i = 0; i < nx; ++i) x[i] = outside.newest_x(static_cast<int>(i));
    double t = 0;
    for (const Reading& s : readings(1, this->links())) {
        ASSERT_EQ(inside.push(s), Outcome::ok);
        ASSERT_EQ(inside.advance(s.t_s), Outcome::ok);
        // Small midpoint steps to the event, then the jump.
        const int steps = static_cast<int>(std::ceil((s.t_s - t) / 2e-4 - 1e-9));
        for (int k = 0; k < steps; ++k) {
            const double h = (s.t_s - t) / steps;
            outside.derivative(x.data(), slope.data());
            for (std::size_t i = 0; i < nx; ++i) mid[i] = x[i] + 0.5 * h * slope[i];
            outside.derivative(mid.data(), slope.data());
            for (std::size_t i = 0; i < nx; ++i) x[i] += h * slope[i];
        }
        t = s.t_s;
        ASSERT_EQ(outside.push(s), Outcome::ok);
        EXPECT_EQ(outside.next_event_s(), s.t_s);
        ASSERT_EQ(outside.jump(s.t_s, x.data(), x.data()), Outcome::ok);
        EXPECT_TRUE(std::isinf(outside.next_event_s()));
    }
    for (std::size_t i = 0; i < nx; ++i) EXPECT_NEAR(x[i], inside.newest_x(static_cast<int>(i)), 1e-6);
}

// Starts again from what it cannot use.
struct Forgetful : Pendulum {
    void jump(State& s, const Event& event) const {
        if (std::fabs(s.x[0]) > 1e100) begin(s);
        Pendulum::jump(s, event);
    }
};

TEST(HybridFilterJump, ANewStartDoesNotHideAnEventWithoutAFiniteState) {
    Filter<Forgetful> filter;
    Filter<Forgetful>::Settings settings;
    settings.queue_capacity = 8;
    ASSERT_TRUE(filter.create({}, settings));
    const double before = filter.newest().jumps;
    ASSERT_EQ(filter.push({0.1, 1, {1e300}}), Outcome::ok);
    ASSERT_EQ(filter.push({0.2, 1, {0.4}}), Outcome::ok);
    double x[Pendulum::nx];
    std::copy_n(filter.newest().x, Pendulum::nx, x);
    EXPECT_EQ(filter.jump(0.2, x, x), Outcome::diverged);
    EXPECT_EQ(filter.newest().jumps, before);
    EXPECT_EQ(filter.waiting(), 0);
    ASSERT_EQ(filter.push({0.3, 1, {0.4}}), Outcome::ok);
    EXPECT_EQ(filter.jump(0.3, x, x), Outcome::ok);
}

#ifdef HNAV_HEAP_IS_COUNTED
TYPED_TEST(HybridFilter, AsksTheHeapForNothingAfterItWasMade) {
    const auto samples = readings(1, this->links());
    typename TestFixture::F filter(0.2);
    heap::allocations = 0;
    heap::counting = true;
    for (const Reading& s : samples) {
        filter.push(s);
        filter.advance(s.t_s + 0.01);
    }
    filter.reset();
    heap::counting = false;
    EXPECT_EQ(heap::allocations, 0);
}
#endif

TEST(HybridFilterSizes, AChainOfOneIsThePendulum) {
    Tested<Kind<0>> pendulum;
    Tested<Kind<1>> chain;
    for (const Reading& s : readings(2, 1)) {
        ASSERT_EQ(pendulum.push(s), Outcome::ok);
        ASSERT_EQ(chain.push(s), Outcome::ok);
        ASSERT_EQ(pendulum.advance(s.t_s), Outcome::ok);
        ASSERT_EQ(chain.advance(s.t_s), Outcome::ok);
    }
    for (int i = 0; i < Pendulum::nx; ++i) EXPECT_NEAR(chain.newest_x(i), pendulum.newest_x(i), 1e-12);
}

TEST(HybridFilterSizes, AModelOfFixedSizeTakesNoRoomForItsSizes) {
    EXPECT_TRUE(has_fixed_size<Pendulum>);
    EXPECT_FALSE(has_fixed_size<PendulumChain>);
    EXPECT_LT(sizeof(EventQueue<FixedSizes<Pendulum::Event, Pendulum::State>>), sizeof(EventQueue<RuntimeSizes>));
}
