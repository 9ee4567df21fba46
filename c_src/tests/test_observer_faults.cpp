// Effects of faults of sensors and clocks on an observer: a pendulum and a tank that drains, with noise, for a minute, five
// times each. Laws: after the stated time the error stays below four sigma; it does not exceed five sigma while the estimate
// is ready; at the end the NEES is that of a run without the fault; and the fault is counted.
#include "laws.hpp"
#include "observer.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

using hnav::test::Given;
using hnav::test::Numbers;
using hnav::test::Observer;
using hnav::test::Random;

namespace {

struct Plant {
    Given given;
    hnav_plant_function flow;
    Numbers truth;
    double interval_s, sigma, noise;
};

int pendulum_flow(void*, double, const double* x, const double*, const double*, double* dx) {
    dx[0] = x[1];
    dx[1] = -9.81 * std::sin(x[0]) - 0.02 * x[1];
    return 0;
}

// Filled at a constant rate, drained by its own height.
int tank_flow(void*, double, const double* x, const double*, const double*, double* dx) {
    dx[0] = 0.02 - 0.03 * std::sqrt(std::max(0.0, x[0])) + x[1];
    dx[1] = -0.05 * x[1];
    return 0;
}

int first(void*, double, const double* x, const double*, const double*, double* y) {
    y[0] = x[0];
    return 0;
}

Plant plant(bool tank) {
    Plant p{{}, tank ? tank_flow : pendulum_flow, {}, tank ? 0.1 : 0.02, 0.01, tank ? 5e-3 : 0.02};
    p.truth = tank ? Numbers{1, 0.05} : Numbers{1, 0};
    p.given.plant.n_states = 2;
    p.given.plant.n_outputs = 1;
    p.given.plant.derivatives = p.flow;
    p.given.plant.outputs = first;
    p.given.start = tank ? Numbers{1.1, 0} : Numbers{0.9, 0.1};
    p.given.start_sigma = tank ? Numbers{0.1, 0.05} : Numbers{0.1, 0.2};
    p.given.noise = {1e-4, p.noise};
    p.given.sensor_sigma = {p.sigma};
    p.given.ready_sigma = tank ? Numbers{0.02, 0.05} : Numbers{0.02, 0.06};
    return p;
}

struct Sample {
    double t_s, value;
};

// The sample of t_s under a fault; NaN: there is none.
using Fault = std::function<Sample(double t_s, double value)>;
using FaultOf = std::function<Fault(const Plant&)>;

struct Outcome {
    double recovered_s = 0; // from then on the error is below four sigma
    double lies = 0; // rows that were ready with an error beyond five sigma
    double nees = 0; // mean over the last ten seconds, per state
    bool ready = false;
    hnav_observer_info info{};
};

Outcome run(const Plant& p, unsigned seed, const Fault& fault) {
    constexpr double end_s = 60;
    Outcome out;
    Observer observer(p.given);
    Random random(seed);
    Numbers x = p.truth;
    const int count = static_cast<int>(std::lround(end_s / p.interval_s));
    int last = 0;
    for (int k = 1; k <= count; ++k) {
        constexpr int steps = 10;
        const double h = p.interval_s / steps;
        for (int i = 0; i < steps; ++i) {
            double a[2], b[2];
            p.flow(nullptr, 0, x.data(), nullptr, nullptr, a);
            const double half[2] = {x[0] + 0.5 * h * a[0], x[1] + 0.5 * h * a[1]};
            p.flow(nullptr, 0, half, nullptr, nullptr, b);
            x[0] += h * b[0] + random.normal(1e-4 * std::sqrt(h));
            x[1] += h * b[1] + random.normal(p.noise * std::sqrt(h));
        }
        const Sample s = fault(k * p.interval_s, x[0] + random.normal(p.sigma));
        if (!std::isnan(s.value)) hnav_observer_push(observer, 0, s.t_s, s.value);
        hnav_filter_advance(observer, s.t_s);
        const Numbers is = observer.x(), sigma = observer.sigma();
        double far = 0;
        for (int i = 0; i < 2; ++i) far = std::max(far, std::fabs(is[i] - x[i]) / sigma[i]);
        if (far > 4 || hnav_filter_advance(observer, s.t_s) != HNAV_OK) last = k;
        if (observer.info().ready && far > 5) ++out.lies;
        if (k > count - 10 / p.interval_s) out.nees += observer.nees(x) / 2 * p.interval_s / 10;
    }
    out.recovered_s = last * p.interval_s;
    out.ready = observer.info().ready;
    out.info = observer.info();
    return out;
}

void expect_recovery(bool tank, const char* name, const FaultOf& fault, double by_s, int lies,
                     const std::function<void(const hnav_observer_info&)>& counted) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
        SCOPED_TRACE(std::string(name) + (tank ? ", tank, seed " : ", pendulum, seed ") + std::to_string(seed));
        const Plant p = plant(tank);
        const Outcome o = run(p, seed, fault(p));
        EXPECT_LE(o.recovered_s, by_s);
        EXPECT_LE(o.lies, lies);
        EXPECT_LT(o.nees, 1.5);
        EXPECT_TRUE(o.ready);
        counted(o.info);
    }
}

void on_both(const char* name, const FaultOf& fault, double by_s, int lies,
             const std::function<void(const hnav_observer_info&)>& counted) {
    for (const bool tank : {false, true}) expect_recovery(tank, name, fault, by_s, lies, counted);
}

constexpr double at_s = 30;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

Fault stuck_for_5_s(const Plant&) {
    return [held = 0.0](double t_s, double y) mutable {
        if (t_s < at_s || t_s > at_s + 5) held = y;
        return Sample{t_s, held};
    };
}

Fault as_it_is(const Plant&) {
    return [](double t_s, double y) { return Sample{t_s, y}; };
}

} // namespace

TEST(ObserverFaults, NothingIsFoundWhereNothingIsWrong) {
    on_both("well", as_it_is, 0, 0,
            [](const hnav_observer_info& i) { EXPECT_EQ(i.outliers + i.stuck + i.stamps_left_out + i.clock_jumps, 0u); });
}

TEST(ObserverFaults, ASpikeOfOneSampleIsAnOutlier) {
    for (const double by : {3.0, 1e3, 1e200}) // the square of the last is not finite: its event is dropped
        on_both(
            "spike",
            [by](const Plant& p) {
                return [by, half_s = 0.5 * p.interval_s](double t_s, double y) {
                    return Sample{t_s, std::fabs(t_s - at_s) < half_s ? y + by : y};
                };
            },
            0, 0, [by](const hnav_observer_info& i) { EXPECT_EQ(by > 1e100 ? i.dropped : i.outliers, 1u); });
}

TEST(ObserverFaults, AStepThatStaysIsBelieved) {
    Observer observer(plant(false).given);
    Random random(3);
    for (int k = 1; k <= 500; ++k) {
        ASSERT_EQ(hnav_observer_push(observer, 0, 0.02 * k, (k < 400 ? 0.0 : 2.0) + random.normal(0.01)), HNAV_OK);
        ASSERT_EQ(hnav_filter_advance(observer, 0.02 * k), HNAV_OK);
    }
    EXPECT_LE(observer.info().outliers, 3u);
    EXPECT_GE(observer.info().outliers, 1u);
}

// At a nearly constant level a stuck sensor cannot be detected, but its samples carry no new information.
TEST(ObserverFaults, AStuckSensorIsLeftOut) {
    for (const bool tank : {false, true})
        expect_recovery(tank, "stuck", stuck_for_5_s, tank ? 0 : at_s + 5.6, 2,
                        [tank](const hnav_observer_info& i) { EXPECT_TRUE(tank || i.stuck > 200) << i.stuck; });
}

// The level drifts by some sigmas of the sensor meanwhile.
TEST(ObserverFaults, AStuckSensorDoesNotHoldASlowPlant) {
    const Plant p = plant(true);
    int wrong = 0;
    for (unsigned seed = 1; seed <= 100; ++seed) wrong += run(p, seed, stuck_for_5_s(p)).lies > 2;
    EXPECT_LE(wrong, 1);
}

TEST(ObserverFaults, ConstantSamplesWithoutNoiseAreNeitherStuckNorOutliers) {
    Given g = plant(true).given;
    g.start = {4.0 / 9, 0}; // where inflow and outflow are equal
    Observer observer(g);
    for (int k = 1; k <= 600; ++k) {
        ASSERT_EQ(hnav_observer_push(observer, 0, 0.1 * k, 4.0 / 9), HNAV_OK);
        ASSERT_EQ(hnav_filter_advance(observer, 0.1 * k), HNAV_OK);
    }
    EXPECT_EQ(observer.info().outliers + observer.info().stuck, 0u);
    EXPECT_LT(observer.sigma()[0], 0.005);
}

TEST(ObserverFaults, AGapIsCoasted) {
    const auto gap = [](const Plant&) {
        return [](double t_s, double y) { return Sample{t_s, t_s > at_s && t_s < at_s + 10 ? none : y}; };
    };
    on_both("gap", gap, 0, 0, [](const hnav_observer_info&) {});
}

TEST(ObserverFaults, AStampFarAheadIsLeftOut) {
    const auto ahead = [](const Plant& p) {
        return [half_s = 0.5 * p.interval_s](double t_s, double y) {
            return Sample{std::fabs(t_s - at_s) < half_s ? t_s + 1e5 : t_s, y};
        };
    };
    on_both("ahead", ahead, at_s, 0, [](const hnav_observer_info& i) {
        EXPECT_EQ(i.stamps_left_out, 1u);
        EXPECT_EQ(i.late, 0u);
    });
}

TEST(ObserverFaults, AClockThatIsSetBackBeginsANewTimeBase) {
    const auto back = [](const Plant&) { return [](double t_s, double y) { return Sample{t_s > at_s ? t_s - 10 : t_s, y}; }; };
    on_both("back", back, 0, 0, [](const hnav_observer_info& i) {
        EXPECT_EQ(i.clock_jumps, 1u);
        EXPECT_EQ(i.late, 0u);
    });
}

// Each try of an interval would take all the steps that one may have.
TEST(ObserverFaults, ADerivativeWithoutBoundCostsTheStepsOfOneInterval) {
    for (const double size : {1e150, 1e300}) {
        static double accel;
        accel = size;
        Given given = plant(false).given;
        given.plant.derivatives = [](void*, double t_s, const double* x, const double*, const double*, double* dx) {
            dx[0] = x[1];
            dx[1] = t_s > 1 ? accel : -x[0];
            return 0;
        };
        Observer observer(given);
        for (int k = 0; k <= 10; ++k) {
            ASSERT_EQ(hnav_observer_push(observer, 0, 0.1 * k, 0), HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(observer, 0.1 * k), HNAV_OK);
        }
        const std::uint64_t before = observer.info().steps;
        ASSERT_EQ(hnav_observer_push(observer, 0, 1.1, 0), HNAV_OK);
        hnav_filter_advance(observer, 1.1);
        EXPECT_LT(observer.info().steps - before, 2u * given.options.max_steps);
        EXPECT_EQ(observer.info().ready, 0);
        EXPECT_NE(observer.message().find("max_steps"), std::string::npos) << observer.message();
    }
}

TEST(ObserverFaults, ARowThatComesTwiceCountsOnce) {
    Observer once(plant(false).given), twice(plant(false).given);
    Random random(5);
    for (int k = 1; k <= 500; ++k) {
        const double y = random.normal(0.01);
        for (Observer* o : {&once, &twice, &twice}) {
            ASSERT_EQ(hnav_observer_push(*o, 0, 0.02 * k, y), HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(*o, 0.02 * k), HNAV_OK);
        }
    }
    EXPECT_EQ(once.x(), twice.x());
    EXPECT_EQ(once.P(), twice.P());
}

// Samples of a slow plant arrive once a minute: their stamps are not implausibly far ahead.
TEST(ObserverFaults, SlowSamplesAreAllUsed) {
    Observer observer(plant(true).given);
    for (const double t_s : {0.0, 60.0, 120.0, 180.0, 500.0, 560.0, 620.0}) {
        ASSERT_EQ(hnav_observer_push(observer, 0, t_s, 0.45), HNAV_OK);
        ASSERT_EQ(hnav_filter_advance(observer, t_s), HNAV_OK);
    }
    EXPECT_EQ(observer.info().corrections, 7u);
    EXPECT_EQ(observer.info().stamps_left_out, 0u);
}
