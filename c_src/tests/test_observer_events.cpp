// Plants with events: the covariance passes through them, the estimate splits at uncertain events, and the same samples give
// the same bits whatever is requested between them.
#include "estimation/absorption.hpp"
#include "event_plants.hpp"
#include "laws.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

using hnav::test::Bytes;
using hnav::test::Given;
using hnav::test::Numbers;
using hnav::test::Observer;
using hnav::test::Random;
using namespace hnav::test::event_plants;

namespace {

// Means over many runs.
struct Errors {
    double nees = 0, parts = 0, count = 0;
    void add(const Observer& observer, const Numbers& truth) {
        nees += observer.nees(truth) / static_cast<double>(truth.size());
        parts += observer.info().parts;
        count += 1;
    }
};

void use(hnav_filter* o, double t_s, double y) {
    ASSERT_EQ(hnav_observer_push(o, 0, t_s, y), HNAV_OK);
    ASSERT_EQ(hnav_filter_advance(o, t_s), HNAV_OK) << hnav_filter_message(o);
}

Errors balls(unsigned first_seed, int runs) {
    Errors all;
    for (int run = 0; run < runs; ++run) {
        Ball truth{Random(first_seed + run), 1, 0};
        truth.h += truth.random.normal(0.05);
        truth.v += truth.random.normal(0.3);
        Observer observer(ball());
        for (int k = 1; k <= 24; ++k) {
            truth.step(0.05);
            use(observer, 0.05 * k, truth.h + truth.random.normal(0.02));
            all.add(observer, {truth.h, truth.v});
        }
    }
    return all;
}

// The samples of a run of the ball or the heater.
Numbers heights(unsigned seed, int count) {
    Ball truth{Random(seed), 1, 0};
    Numbers y;
    for (int k = 0; k < count; ++k) {
        truth.step(0.05);
        y.push_back(truth.h + truth.random.normal(0.02));
    }
    return y;
}

Numbers temperatures(unsigned seed, int count) {
    Room truth{Random(seed), 0};
    Numbers y;
    for (int k = 0; k < count; ++k) {
        truth.step(0.1);
        y.push_back(truth.x + truth.random.normal(0.1));
    }
    return y;
}

} // namespace

// ------------------------------------------------------------------------------------------------ covariance through an event

TEST(ObserverEvents, TheCovarianceGoesThroughABounceByItsClosedForm) {
    const double T = 0.7, bounce_s = std::sqrt(2 / gravity), speed = -gravity * bounce_s;
    Given given = ball({1, 0}, {0.02, 0.1}, 0);
    Observer observer(given);
    ASSERT_EQ(hnav_filter_advance(observer, T), HNAV_OK);
    Eigen::Matrix2d before, Xi, after;
    before << 1, bounce_s, 0, 1;
    Xi << -restitution, 0, -gravity * (1 + restitution) / speed, -restitution;
    after << 1, T - bounce_s, 0, 1;
    const Eigen::Matrix2d Phi = after * Xi * before;
    const Eigen::Matrix2d P = Phi * Eigen::Vector2d(4e-4, 1e-2).asDiagonal() * Phi.transpose();
    for (int i = 0; i < 4; ++i)
        EXPECT_NEAR(observer.P()[i], P(i / 2, i % 2), 1e-7 * std::sqrt(P(i / 2, i / 2) * P(i % 2, i % 2)));
    const double a = T - bounce_s, v = -restitution * speed;
    EXPECT_NEAR(observer.x()[0], v * a - 0.5 * gravity * a * a, 1e-10);
    EXPECT_NEAR(observer.x()[1], v - gravity * a, 1e-10);
    EXPECT_EQ(observer.info().plant_events, 1u);
    EXPECT_EQ(observer.info().parts, 1);
}

TEST(ObserverEvents, TheCovarianceAfterABounceIsThatOfTwentyThousandSamples) {
    Observer observer(ball({1, 0}, {0.02, 0.1}, 0));
    ASSERT_EQ(hnav_filter_advance(observer, 0.7), HNAV_OK);
    Random random(1);
    const int n = 20000;
    Eigen::MatrixXd X(n, 2);
    for (int k = 0; k < n; ++k) {
        const double h = 1 + random.normal(0.02), v = random.normal(0.1);
        const double bounce_s = (v + std::sqrt(v * v + 2 * gravity * h)) / gravity, up = -restitution * (v - gravity * bounce_s);
        const double a = 0.7 - bounce_s;
        X.row(k) << up * a - 0.5 * gravity * a * a, up - gravity * a;
    }
    const Eigen::MatrixXd centred = X.rowwise() - X.colwise().mean();
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(observer.sigma()[i] / (centred.col(i).norm() / std::sqrt(n - 1.0)), 1, 0.03);
}

// Thrown up to a ceiling at 1 m that the mean just touches: half of the distribution hits it.
TEST(ObserverEvents, TheCovarianceOfABallThatGrazesIsThatOfTwentyThousandSamples) {
    constexpr double e = 0.7, T = 0.6;
    const double speed = std::sqrt(gravity); // from 0.5 m
    // Where the mean hits, where it narrowly misses, and for short intervals.
    for (const double more : {0.0, 0.05, -0.05, 0.12})
        for (const int intervals : {1, 6}) {
            Given given = ball({0.5, speed + more}, {0.02, 0.1}, 0);
            given.plant.indicators = [](void*, double, const double* x, const double*, const double*, double* z) {
                z[0] = 1 - x[0];
                return 0;
            };
            given.plant.event = [](void*, double, const double* x, const double*, const double*, double* after) {
                if (x[0] >= 1 && x[1] > 0) after[1] = -e * x[1] - 1; // a ceiling that reflects
                return 0;
            };
            given.sensor_sigma = {1e6};
            Observer observer(given);
            for (int k = 1; k <= intervals; ++k) use(observer, T * k / intervals, 0);
            Random random(3);
            const int n = 20000;
            Eigen::MatrixXd X(n, 2);
            for (int k = 0; k < n; ++k) {
                const double h = 0.5 + random.normal(0.02), v = speed + more + random.normal(0.1);
                const double left = v * v - 2 * gravity * (1 - h), w = left > 0 ? std::sqrt(left) : 0, a = T - (v - w) / gravity;
                const double down = -e * w - 1;
                X.row(k) << (left > 0 ? 1 + down * a - 0.5 * gravity * a * a : h + v * T - 0.5 * gravity * T * T),
                    (left > 0 ? down - gravity * a : v - gravity * T);
            }
            const Eigen::RowVector2d mean = X.colwise().mean();
            const Eigen::MatrixXd centred = X.rowwise() - mean;
            EXPECT_GT(observer.info().grazing, 0u);
            // Each interval merges its points into two parts by their moments.
            const double near = intervals == 1 ? 0.03 : 0.06;
            for (int i = 0; i < 2; ++i) {
                const double sigma = centred.col(i).norm() / std::sqrt(n - 1.0);
                EXPECT_NEAR(observer.sigma()[i] / sigma, 1, near) << more << " " << intervals;
                EXPECT_NEAR(observer.x()[i], mean[i], (intervals == 1 ? 0.02 : 0.12) * sigma) << more << " " << intervals;
            }
        }
}

// Two numbers rise to 1 together; each triples the speed of the other when it arrives. Which arrives first is uncertain.
TEST(ObserverEvents, TheCovarianceOfTwoGuardsCrossedTogetherIsThatOfTwentyThousandSamples) {
    struct Rates {
        double a = 1, b = 1;
    } rates;
    Given given = ball({0, 0}, {0.1, 0.15}, 0);
    given.plant.context = &rates;
    given.plant.n_indicators = given.plant.n_discrete = 2;
    given.plant.derivatives = [](void* c, double, const double*, const double*, const double*, double* dx) {
        dx[0] = static_cast<Rates*>(c)->a;
        dx[1] = static_cast<Rates*>(c)->b;
        return 0;
    };
    given.plant.indicators = [](void*, double, const double* x, const double*, const double*, double* z) {
        z[0] = 1 - x[0];
        z[1] = 1 - x[1];
        return 0;
    };
    given.plant.event = [](void* c, double, const double* x, const double*, const double*, double*) {
        auto& r = *static_cast<Rates*>(c);
        if (x[0] >= 1) r.b = 3;
        if (x[1] >= 1) r.a = 3;
        return 0;
    };
    given.plant.get_discrete = [](void* c, double* d) { std::memcpy(d, c, sizeof(Rates)); };
    given.plant.set_discrete = [](void* c, const double* d) { std::memcpy(c, d, sizeof(Rates)); };
    constexpr double T = 1.6;
    Random random(4);
    const int n = 20000;
    for (const double ahead : {0.0, 0.1}) {
        rates = {};
        given.start = {ahead, 0};
        given.sensor_sigma = {1e6};
        Observer observer(given);
        use(observer, T, 0);
        Eigen::MatrixXd X(n, 2);
        for (int k = 0; k < n; ++k) {
            const double x[] = {ahead + random.normal(0.1), random.normal(0.15)};
            const int first = x[0] > x[1] ? 0 : 1;
            const double at_s = 1 - x[first], then_s = at_s + (1 - at_s - x[1 - first]) / 3;
            X(k, first) = 1 + then_s - at_s + 3 * (T - then_s);
            X(k, 1 - first) = 1 + 3 * (T - then_s);
        }
        const Eigen::RowVector2d mean = X.colwise().mean();
        const Eigen::MatrixXd centred = X.rowwise() - mean, P = centred.transpose() * centred / (n - 1);
        EXPECT_EQ(observer.info().grazing, 1u);
        for (int i = 0; i < 4; ++i)
            EXPECT_NEAR(observer.P()[i], P(i / 2, i % 2), 0.04 * std::sqrt(P(i / 2, i / 2) * P(i % 2, i % 2)));
        for (int i = 0; i < 2; ++i) EXPECT_NEAR(observer.x()[i], mean[i], 0.03 * std::sqrt(P(i, i)));
    }
}

// Just above the floor: at the end of the interval it may not have bounced, and the height of the bounce is below 3 sigma.
TEST(ObserverEvents, TheCovarianceOfABallThatHasPerhapsNotBouncedIsThatOfTwentyThousandSamples) {
    struct Case {
        double h, v, sigma_h, sigma_v, T;
    };
    for (const Case& c : {Case{0.0073, -0.408, 0.0035, 0.149, 0.02}, Case{0.0071, -0.28, 0.0031, 0.12, 0.02},
                          Case{0.01, -0.408, 0.0045, 0.05, 0.03}}) {
        Given given = ball({c.h, c.v}, {c.sigma_h, c.sigma_v}, 0);
        given.sensor_sigma = {1e6};
        Observer observer(given);
        use(observer, c.T, 0);
        Random random(7);
        const int n = 20000;
        Eigen::MatrixXd X(n, 2);
        for (int k = 0; k < n; ++k) {
            double h = std::fabs(c.h + random.normal(c.sigma_h)), v = c.v + random.normal(c.sigma_v), left = c.T;
            for (int bounces = 0; bounces < 40; ++bounces) {
                const double to_floor = (v + std::sqrt(v * v + 2 * gravity * h)) / gravity;
                if (to_floor >= left) break;
                v = -restitution * (v - gravity * to_floor);
                h = 0;
                left -= to_floor;
            }
            X.row(k) << h + v * left - 0.5 * gravity * left * left, v - gravity * left;
        }
        const Eigen::RowVector2d mean = X.colwise().mean();
        const Eigen::MatrixXd centred = X.rowwise() - mean;
        EXPECT_EQ(observer.info().parts, 2);
        for (int i = 0; i < 2; ++i) {
            const double sigma = centred.col(i).norm() / std::sqrt(n - 1.0);
            EXPECT_NEAR(observer.sigma()[i] / sigma, 1, 0.03) << c.v << " " << i;
            EXPECT_NEAR(observer.x()[i], mean[i], 0.05 * sigma) << c.v << " " << i;
        }
    }
}

TEST(ObserverEvents, AnEventThatChangesNothingIsSilent) {
    Given given = ball({0.5, 1.2}, {0.05, 0.3}), plain = given;
    given.plant.event = [](void*, double, const double*, const double*, const double*, double*) { return 0; };
    plain.plant.n_indicators = 0;
    plain.plant.event = nullptr;
    Observer observer(given), without(plain);
    for (int k = 1; k < 20; ++k) {
        const double t_s = 0.05 * k, y = 0.5 + 1.2 * t_s - 0.5 * gravity * t_s * t_s;
        use(observer, t_s, y);
        use(without, t_s, y);
        EXPECT_EQ(observer.info().parts, 1);
        for (int i = 0; i < 2; ++i) {
            EXPECT_NEAR(observer.x()[i], without.x()[i], 1e-9);
            EXPECT_NEAR(observer.sigma()[i], without.sigma()[i], 1e-9);
        }
    }
    EXPECT_LT(observer.x()[0], -1);
    EXPECT_EQ(observer.info().plant_events, 0u);
}

// ------------------------------------------------------------------------------------------------ crossings by noise

// From a point the reflection principle; and a time in pieces is the whole.
TEST(ObserverEvents, AbsorptionDoesNotDependOnTheLengthOfIntervals) {
    for (const double z : {0.5, 1.0, 3.0}) EXPECT_NEAR(hnav::absorb(z, 1e-6, 1).ended, std::erfc(z / M_SQRT2), 1e-5);
    for (const double sigma : {0.1, 0.3, 0.5}) {
        const double added = 0.4, once = hnav::absorb(1, sigma * sigma, added).ended;
        for (const int pieces : {3, 30}) {
            double left = 1, mean = 1, square = 1 + sigma * sigma;
            for (int k = 0; k < pieces; ++k) {
                const hnav::Absorption one = hnav::absorb(mean, square - mean * mean, added / pieces);
                left *= 1 - one.ended;
                mean /= 1 - one.ended;
                square = (square + added / pieces - one.ended * one.variance) / (1 - one.ended);
            }
            EXPECT_NEAR(1 - left, once, 1e-3 * once) << sigma << " " << pieces;
        }
    }
}

namespace {

// A heater that would come to rest at `rest`, just below the limit of its thermostat; off, it cools until `again`.
struct Rest {
    double on = 1;
    double rest = 0.99, again = -HUGE_VAL;

    double rate(double x) const { return on > 0 ? 0.02 * (rest - x) : -0.02; }
    void switch_at(double x) { on = on > 0 ? x < 1 : x <= again; }
    void step(double T, double* x, Random& random) {
        const double d = 0.05;
        for (int k = 0; k < std::lround(T / d); ++k) {
            *x += d * rate(*x) + random.normal(0.002 * std::sqrt(d));
            switch_at(*x);
        }
    }
    Given given(double start, double sigma, double sensor) {
        Given g = ball({start}, {sigma}, 0, sensor);
        g.noise = {0.002};
        g.plant.n_states = g.plant.n_discrete = 1;
        g.plant.context = this;
        g.plant.derivatives = [](void* c, double, const double* x, const double*, const double*, double* dx) {
            dx[0] = static_cast<Rest*>(c)->rate(x[0]);
            return 0;
        };
        g.plant.indicators = [](void* c, double, const double* x, const double*, const double*, double* z) {
            const Rest& r = *static_cast<Rest*>(c);
            z[0] = r.on > 0 ? 1 - x[0] : std::isinf(r.again) ? 1 : x[0] - r.again;
            return 0;
        };
        g.plant.event = [](void* c, double, const double* x, const double*, const double*, double*) {
            static_cast<Rest*>(c)->switch_at(x[0]);
            return 0;
        };
        g.plant.get_discrete = [](void* c, double* d) { *d = static_cast<Rest*>(c)->on; };
        g.plant.set_discrete = [](void* c, const double* d) { static_cast<Rest*>(c)->on = *d; };
        return g;
    }
};

} // namespace

// The drift never reaches the guard: noise alone does.
TEST(ObserverEvents, ACrossingByNoiseIsThatOfParticlesForAnyInterval) {
    struct Case {
        double rest, start, sigma, end_s;
    };
    for (const Case& c : {Case{0.985, 0.985, 0.001, 60}, Case{0.99, 0.985, 0.002, 60}, Case{0.992, 0.98, 0.001, 20}}) {
        Random random(5);
        const int n = 4000;
        double mean = 0, square = 0;
        for (int k = 0; k < n; ++k) {
            Rest truth{1, c.rest};
            double x = c.start + random.normal(c.sigma);
            truth.step(c.end_s, &x, random);
            mean += x / n;
            square += x * x / n;
        }
        const double sigma = std::sqrt(square - mean * mean);
        for (const double interval_s : {0.25, 1.0, 5.0}) {
            Rest plant{1, c.rest};
            Observer observer(plant.given(c.start, c.sigma, 1e3));
            for (int k = 1; k * interval_s <= c.end_s; ++k) use(observer, k * interval_s, c.rest);
            EXPECT_NEAR(observer.x()[0], mean, 0.1 * sigma) << c.rest << " " << interval_s;
            EXPECT_NEAR(observer.sigma()[0] / sigma, 1, 0.1) << c.rest << " " << interval_s;
            EXPECT_EQ(observer.info().ready, 0);
        }
    }
}

TEST(ObserverEvents, StatesItsErrorsOfAThermostatThatNoiseSwitches) {
    Errors all;
    int ready = 0, worst = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
        Rest plant{1, 0.99, 0.9}, truth = plant;
        Random random(seed);
        double x = 0.95 + random.normal(0.01);
        Observer observer(plant.given(0.95, 0.01, 0.02));
        for (int k = 1; k <= 300; ++k) {
            truth.step(1, &x, random);
            use(observer, k, x + random.normal(0.02));
            all.add(observer, {x});
            ready += observer.info().ready;
            worst += observer.info().ready && observer.nees({x}) > 16;
        }
    }
    EXPECT_GT(all.nees / all.count, 0.85);
    EXPECT_LT(all.nees / all.count, 1.2);
    EXPECT_GT(ready, 0.1 * all.count);
    EXPECT_LT(worst, 0.001 * all.count); // readiness ends after three corrections
}

// ------------------------------------------------------------------------------------------------ sigmas that are right

TEST(ObserverEvents, StatesItsErrorsOfABouncingBall) {
    for (unsigned first_seed : {0u, 1000u, 2000u}) {
        const Errors all = balls(first_seed, 100);
        EXPECT_GT(all.nees / all.count, 0.85);
        EXPECT_LT(all.nees / all.count, 1.2);
        EXPECT_LT(all.parts / all.count, 1.1);
    }
}

TEST(ObserverEvents, StatesItsErrorsOfAPendulumWithAStop) {
    Errors all;
    for (unsigned seed = 0; seed < 100; ++seed) {
        Pendulum truth{Random(seed), 0.5, 0};
        truth.a += truth.random.normal(0.05);
        truth.w += truth.random.normal(0.1);
        Observer observer(pendulum());
        for (int k = 1; k <= 40; ++k) {
            truth.step(0.05);
            use(observer, 0.05 * k, truth.a + truth.random.normal(0.02));
            all.add(observer, {truth.a, truth.w});
        }
    }
    EXPECT_GT(all.nees / all.count, 0.85);
    EXPECT_LT(all.nees / all.count, 1.2);
}

TEST(ObserverEvents, StatesItsErrorsOfARelayWithHysteresis) {
    Errors all;
    for (unsigned seed = 0; seed < 100; ++seed) {
        Room truth{Random(seed), 0};
        truth.x += truth.random.normal(0.3);
        Heater heater;
        Observer observer(heater.given());
        for (int k = 1; k <= 60; ++k) {
            truth.step(0.1);
            use(observer, 0.1 * k, truth.x + truth.random.normal(0.1));
            all.add(observer, {truth.x});
        }
    }
    EXPECT_GT(all.nees / all.count, 0.85);
    EXPECT_LT(all.nees / all.count, 1.2);
    EXPECT_GT(all.parts / all.count, 1.1);
}

// The restitution is estimated from bounces: only the reset depends on it.
TEST(ObserverEvents, LearnsTheRestitutionOfABall) {
    double squares = 0, normalised = 0;
    const int runs = 40;
    for (int run = 0; run < runs; ++run) {
        Ball truth{Random(run), 1, 0};
        truth.noise = std::sqrt(0.005);
        truth.e = 0.75 + std::clamp(truth.random.normal(0.05), -0.13, 0.15);
        truth.h += truth.random.normal(0.02);
        truth.v += truth.random.normal(0.05);
        Given given = ball({1, 0, 0.75}, {0.02, 0.05, 0.05}, std::sqrt(0.005), 0.01);
        given.noise.push_back(0);
        given.plant.n_parameters = 1;
        given.plant.event = [](void* c, double t_s, const double* x, const double* u, const double* p, double* after) {
            return ball_bounce(c, t_s, x, u, p, after);
        };
        Observer observer(given);
        for (int k = 1; k <= 30; ++k) {
            truth.step(0.05);
            use(observer, 0.05 * k, truth.h + truth.random.normal(0.01));
        }
        squares += std::pow(observer.x()[2] - truth.e, 2) / runs;
        normalised += std::pow((observer.x()[2] - truth.e) / observer.sigma()[2], 2) / runs;
    }
    EXPECT_LT(std::sqrt(squares), 0.008);
    EXPECT_GT(normalised, 0.4);
    EXPECT_LT(normalised, 1.8);
}

// ------------------------------------------------------------------------------------------------ the same bits

namespace {

// A plant and its samples; each plant has its own memory.
struct Case {
    Case(bool heated, Numbers y, double interval_s) : is_heater(heated), samples(std::move(y)), interval_s(interval_s) {}
    Given given(double horizon_s = 0) {
        Given g = is_heater ? heaters.emplace_back(std::make_unique<Heater>())->given() : ball();
        g.options.horizon_s = horizon_s;
        g.options.queue_capacity = 200;
        return g;
    }
    bool is_heater;
    Numbers samples;
    double interval_s;
    std::vector<std::unique_ptr<Heater>> heaters;
};

std::vector<Case> cases() {
    std::vector<Case> all;
    all.emplace_back(false, heights(5, 30), 0.05);
    all.emplace_back(true, temperatures(6, 60), 0.1);
    return all;
}

} // namespace

TEST(ObserverEvents, TimesThatAreAskedForDoNotChangeTheEstimate) {
    for (Case& c : cases()) {
        Observer reference(c.given());
        const double end_s = c.interval_s * (c.samples.size() + 3);
        for (std::size_t k = 0; k < c.samples.size(); ++k) use(reference, c.interval_s * (k + 1), c.samples[k]);
        ASSERT_EQ(hnav_filter_advance(reference, end_s), HNAV_OK);
        EXPECT_GT(reference.info().splits, 0u);
        for (const double step : {0.0037, 0.03, 0.31, end_s}) {
            Observer observer(c.given());
            std::size_t next = 0;
            for (double t = step; next < c.samples.size(); t += step) {
                for (; next < c.samples.size() && c.interval_s * (next + 1) <= t; ++next)
                    ASSERT_EQ(hnav_observer_push(observer, 0, c.interval_s * (next + 1), c.samples[next]), HNAV_OK);
                ASSERT_EQ(hnav_filter_advance(observer, std::min(t, end_s)), HNAV_OK);
            }
            ASSERT_EQ(hnav_filter_advance(observer, end_s), HNAV_OK);
            EXPECT_EQ(observer.x(), reference.x());
            EXPECT_EQ(observer.P(), reference.P());
        }
    }
}

TEST(ObserverEvents, LateSamplesWithinTheHorizonGiveTheSameBits) {
    for (Case& c : cases()) {
        Observer in_order(c.given(1)), late(c.given(1));
        const auto t = [&](std::size_t k) { return c.interval_s * (k + 1); };
        for (std::size_t k = 0; k < c.samples.size(); ++k) use(in_order, t(k), c.samples[k]);
        for (std::size_t k = 0; k + 1 < c.samples.size(); k += 2) {
            use(late, t(k + 1), c.samples[k + 1]);
            ASSERT_EQ(hnav_observer_push(late, 0, t(k), c.samples[k]), HNAV_OK);
        }
        ASSERT_EQ(hnav_filter_advance(in_order, t(c.samples.size())), HNAV_OK);
        ASSERT_EQ(hnav_filter_advance(late, t(c.samples.size())), HNAV_OK);
        EXPECT_EQ(late.x(), in_order.x());
        EXPECT_EQ(late.P(), in_order.P());
    }
}

TEST(ObserverEvents, GoesOnFromASavedStateBitForBit) {
    for (Case& c : cases())
        for (const std::size_t cut : {std::size_t{8}, c.samples.size() / 2}) {
            Observer whole(c.given(0.2)), saved(c.given(0.2)), loaded(c.given(0.2));
            for (std::size_t k = 0; k < c.samples.size(); ++k) use(whole, c.interval_s * (k + 1), c.samples[k]);
            for (std::size_t k = 0; k < cut; ++k) use(saved, c.interval_s * (k + 1), c.samples[k]);
            const Bytes state = saved.saved();
            ASSERT_EQ(hnav_filter_load(loaded, state.data(), state.size()), HNAV_OK);
            EXPECT_EQ(loaded.saved(), state);
            for (std::size_t k = cut; k < c.samples.size(); ++k) use(loaded, c.interval_s * (k + 1), c.samples[k]);
            EXPECT_EQ(loaded.saved(), whole.saved());
            ASSERT_EQ(hnav_filter_reset(saved), HNAV_OK);
            for (std::size_t k = 0; k < c.samples.size(); ++k) use(saved, c.interval_s * (k + 1), c.samples[k]);
            EXPECT_EQ(saved.saved(), whole.saved());
        }
}

TEST(ObserverEvents, ASnapshotIsGoneBackToAsOftenAsWantedBitForBit) {
    for (Case& c : cases()) {
        Observer o(c.given(0.2)), other(c.given(0.2));
        const std::size_t cut = c.samples.size() / 2;
        for (std::size_t k = 0; k < cut; ++k) use(o, c.interval_s * (k + 1), c.samples[k]);
        std::size_t bytes = 0;
        ASSERT_EQ(hnav_filter_snapshot_size(o, &bytes), HNAV_OK);
        Bytes snapshot(bytes), end;
        EXPECT_EQ(hnav_filter_take_snapshot(o, snapshot.data(), bytes - 1), HNAV_ERROR_SIZE);
        ASSERT_EQ(hnav_filter_take_snapshot(o, snapshot.data(), bytes), HNAV_OK);
        for (int time = 0; time < 3; ++time) {
            for (std::size_t k = cut; k < c.samples.size(); ++k) use(o, c.interval_s * (k + 1), c.samples[k]);
            if (time == 0) end = o.saved();
            EXPECT_EQ(o.saved(), end);
            if (time == 1) EXPECT_EQ(hnav_filter_reset(o), HNAV_OK);
            ASSERT_EQ(hnav_filter_restore_snapshot(o, snapshot.data(), bytes), HNAV_OK);
        }
        const Bytes before = o.saved();
        for (const std::size_t wrong : {std::size_t{0}, std::size_t{16}, std::size_t{24}, bytes - 8}) {
            EXPECT_EQ(hnav_filter_restore_snapshot(o, snapshot.data(), wrong), HNAV_ERROR_STATE_CORRUPT);
            EXPECT_EQ(hnav_filter_release_snapshot(o, snapshot.data(), wrong), HNAV_ERROR_STATE_CORRUPT);
        }
        EXPECT_EQ(hnav_filter_restore_snapshot(other, snapshot.data(), bytes), HNAV_ERROR_STATE_CORRUPT);
        EXPECT_NE(other.message().find("ends with the observer that it was taken of"), std::string::npos);
        EXPECT_EQ(hnav_filter_release_snapshot(other, snapshot.data(), bytes), HNAV_ERROR_STATE_CORRUPT);
        EXPECT_EQ(hnav_filter_release_snapshot(o, snapshot.data(), bytes), HNAV_OK);
        EXPECT_EQ(o.saved(), before);
    }
}

TEST(ObserverEvents, TwoObserversOfOnePlantAreAsAlone) {
    // One heater for both: each restores its own discrete state.
    Heater shared;
    const Numbers y = temperatures(3, 60);
    Heater own;
    Observer alone(own.given()), a(shared.given()), b(shared.given());
    for (std::size_t k = 0; k < y.size(); ++k) {
        use(alone, 0.1 * (k + 1), y[k]);
        use(a, 0.1 * (k + 1), y[k]);
        use(b, 0.1 * (k + 1), -y[k]);
    }
    EXPECT_EQ(a.saved(), alone.saved());
}

// ------------------------------------------------------------------------------------------------ other events

TEST(ObserverEvents, TheFirstSampleMayBeginIt) {
    Given given = ball();
    given.options.start_mode = HNAV_OBSERVER_START_FIRST_SAMPLE;
    Observer observer(given);
    for (int k = 0; k < 9; ++k) {
        const double t_s = 0.05 * k, h = 1 - 0.5 * gravity * t_s * t_s;
        use(observer, 100 + t_s, h);
        EXPECT_NEAR(observer.x()[0], h, 0.03) << k;
    }
    EXPECT_EQ(observer.info().projected, 0u);
    ASSERT_EQ(hnav_filter_advance(observer, 100.7), HNAV_OK);
    EXPECT_EQ(observer.info().plant_events, 1u);
    EXPECT_GT(observer.x()[0], 0.3);
}

TEST(ObserverEvents, TimeBringsEventsToo) {
    // x' = 1, then -1 from t = 1 s on, then 1 from 2 s on, ...
    Heater direction;
    Given given = direction.given();
    given.start_sigma = {0.1};
    given.noise = {};
    given.plant.n_indicators = 0;
    given.plant.derivatives = [](void* c, double, const double*, const double*, const double*, double* dx) {
        dx[0] = static_cast<Heater*>(c)->on > 0 ? 1 : -1;
        return 0;
    };
    given.plant.event = [](void* c, double, const double*, const double*, const double*, double*) {
        double& on = static_cast<Heater*>(c)->on;
        on = 1 - on;
        return 0;
    };
    given.plant.next_event_s = [](void*, double t_s) { return t_s < 0 ? 1 : std::floor(t_s + 0.5) + 1; };
    Observer observer(given);
    for (const double t_s : {0.25, 1.0, 1.5, 2.0, 3.75, 10.25}) {
        ASSERT_EQ(hnav_filter_advance(observer, t_s), HNAV_OK) << observer.message();
        const double phase = std::fmod(t_s, 2);
        EXPECT_NEAR(observer.x()[0], phase < 1 ? phase : 2 - phase, 1e-9) << t_s;
        EXPECT_NEAR(observer.sigma()[0], 0.1, 1e-6);
    }
}

TEST(ObserverEvents, AnInputMayBeAnEvent) {
    // A sample of the input above 0 sets x to 5 and reverses the flow.
    Heater direction;
    Given given = direction.given();
    given.plant.n_inputs = 1;
    given.plant.n_indicators = 0;
    given.plant.event = [](void* c, double, const double*, const double* u, const double*, double* after) {
        if (u[0] > 0) {
            after[0] = 5;
            static_cast<Heater*>(c)->on = 0;
        }
        return 0;
    };
    Observer observer(given);
    ASSERT_EQ(hnav_observer_push_input(observer, 0, 0.5, -1), HNAV_OK);
    ASSERT_EQ(hnav_filter_advance(observer, 0.9), HNAV_OK);
    EXPECT_NEAR(observer.x()[0], 3 - 3 * std::exp(-0.9), 1e-6);
    ASSERT_EQ(hnav_observer_push_input(observer, 0, 1, 1), HNAV_OK);
    ASSERT_EQ(hnav_filter_advance(observer, 1), HNAV_OK);
    EXPECT_EQ(observer.x()[0], 5);
    EXPECT_LT(observer.sigma()[0], 1e-5);
    ASSERT_EQ(hnav_filter_advance(observer, 2), HNAV_OK);
    EXPECT_NEAR(observer.x()[0], -3 + 8 * std::exp(-1), 1e-6);
}

// A thermostat whose thermometer has a time constant of ten microseconds, beside a thermostat that reads the temperature directly.
TEST(ObserverEvents, AStiffPlantGoesFromGuardToGuardByTheImplicitSolver) {
    Heater slow, lagging;
    Given plain = slow.given(), stiff = lagging.given();
    stiff.plant.n_states = 2;
    stiff.start = {0, 0};
    stiff.start_sigma = {0.3, 0.3};
    stiff.noise = {0.1, 0};
    stiff.plant.derivatives = [](void* c, double t_s, const double* x, const double* u, const double* p, double* dx) {
        Heater::flow(c, t_s, x, u, p, dx);
        dx[1] = 1e5 * (x[0] - x[1]);
        return 0;
    };
    stiff.plant.indicators = [](void* c, double t_s, const double* x, const double* u, const double* p, double* z) {
        return Heater::to_switch(c, t_s, x + 1, u, p, z);
    };
    stiff.plant.event = [](void* c, double t_s, const double* x, const double* u, const double* p, double* after) {
        return Heater::switch_over(c, t_s, x + 1, u, p, after);
    };
    Observer reference(plain), observer(stiff);
    const Numbers y = temperatures(4, 60);
    for (int k = 0; k < 60; ++k) {
        use(reference, 0.1 * (k + 1), y[k]);
        use(observer, 0.1 * (k + 1), y[k]);
        // Near a guard sigma points replace the two parts of the other.
        EXPECT_NEAR(observer.x()[0], reference.x()[0], 0.25 * reference.sigma()[0]) << k;
        EXPECT_NEAR(observer.sigma()[0] / reference.sigma()[0], 1, 0.15) << k;
    }
    EXPECT_GT(observer.info().plant_events, 2u);
    EXPECT_EQ(observer.info().plant_events, reference.info().plant_events);
    EXPECT_EQ(observer.info().dropped, 0u);
}

// ------------------------------------------------------------------------------------------------ where events have no end

// A third number follows the speed with a time constant of a millisecond and less: extrapolated along its slope just after a
// bounce it would be far off at the sample.
TEST(ObserverEvents, AModeThatIsFastBesideItsSamplesFollowsThroughABounce) {
    static double rate;
    for (const double fast : {1e3, 1e4}) {
        rate = fast;
        Given given = ball({1, 0, 0}, {0.05, 0.3, 0.3});
        given.noise.push_back(0);
        given.plant.n_states = 3;
        given.plant.derivatives = [](void* c, double t_s, const double* x, const double* u, const double* p, double* dx) {
            dx[2] = rate * (x[1] - x[2]);
            return ball_flow(c, t_s, x, u, p, dx);
        };
        Observer observer(given), plain(ball());
        const Numbers y = heights(2, 30);
        std::uint64_t points = 0;
        double furthest = 0;
        for (std::size_t k = 0; k < y.size(); ++k) {
            const double t_s = 0.05 * static_cast<double>(k + 1);
            use(observer, t_s, y[k]);
            use(plain, t_s, y[k]);
            const Numbers x = observer.x(), sigma = plain.sigma();
            EXPECT_NEAR(x[1], plain.x()[1], 0.3 * sigma[1]) << fast << " " << k;
            // It lags by g / rate, and for some time constants by part of the bounce, within its own sigma.
            EXPECT_NEAR(x[2], x[1], 3 * observer.sigma()[2] + gravity / fast) << fast << " " << k;
            furthest = std::max(furthest, observer.sigma()[2]);
            points = observer.info().grazing;
        }
        EXPECT_GT(points, 0u);
        EXPECT_LT(furthest, 30); // a bounce is 7.5; along its slope hundreds
        EXPECT_EQ(observer.info().dropped, 0u);
    }
}

TEST(ObserverEvents, AChatteringPlantIsFollowedOrDropped) {
    // x' = -sign(x): at 0 it slides.
    Heater sign;
    Given given = sign.given();
    given.plant.derivatives = [](void* c, double, const double*, const double*, const double*, double* dx) {
        dx[0] = static_cast<Heater*>(c)->on > 0 ? -1 : 1;
        return 0;
    };
    given.plant.indicators = [](void*, double, const double* x, const double*, const double*, double* z) {
        z[0] = x[0];
        return 0;
    };
    given.plant.event = [](void* c, double, const double* x, const double*, const double*, double*) {
        static_cast<Heater*>(c)->on = x[0] > 0;
        return 0;
    };
    given.start = {0.2};
    Observer observer(given);
    for (int k = 1; k <= 6; ++k) {
        ASSERT_EQ(hnav_observer_push(observer, 0, 0.1 * k, 0), HNAV_OK);
        const hnav_status status = hnav_filter_advance(observer, 0.1 * k);
        if (status == HNAV_OK) continue;
        EXPECT_EQ(status, HNAV_ERROR_SOLVER);
        EXPECT_NE(observer.message().find("do not end"), std::string::npos) << observer.message();
    }
    EXPECT_TRUE(std::isfinite(observer.x()[0]));
    EXPECT_GT(observer.info().chattering + observer.info().held, 0u);
}

TEST(ObserverEvents, ABallThatComesToRestIsFollowed) {
    // Below 0.1 m/s it sticks: the end of infinitely many bounces.
    Heater free;
    Given given = ball();
    given.plant.context = &free;
    given.plant.n_discrete = 1;
    given.plant.get_discrete = [](void* c, double* d) { *d = static_cast<Heater*>(c)->on; };
    given.plant.set_discrete = [](void* c, const double* d) { static_cast<Heater*>(c)->on = *d; };
    given.plant.derivatives = [](void* c, double, const double* x, const double*, const double*, double* dx) {
        dx[0] = x[1];
        dx[1] = static_cast<Heater*>(c)->on > 0 ? -gravity : 0;
        return 0;
    };
    given.plant.event = [](void* c, double t_s, const double* x, const double* u, const double*, double* after) {
        if (x[0] > 0 || x[1] >= 0) return 0;
        ball_bounce(nullptr, t_s, x, u, nullptr, after);
        after[0] = 1e-300;
        if (after[1] < 0.1) {
            after[1] = 0;
            static_cast<Heater*>(c)->on = 0;
        }
        return 0;
    };
    given.noise = {0, 0.01};
    Observer observer(given);
    Ball truth{Random(2), 1, 0};
    truth.noise = 0;
    bool rests = false;
    for (int k = 1; k <= 100; ++k) {
        if (!rests) truth.step(0.05);
        rests = rests || (truth.h < 0.003 && std::fabs(truth.v) < 0.15);
        if (rests) truth.h = truth.v = 0;
        ASSERT_EQ(hnav_observer_push(observer, 0, 0.05 * k, truth.h + truth.random.normal(0.02)), HNAV_OK);
        ASSERT_EQ(hnav_filter_advance(observer, 0.05 * k), HNAV_OK) << observer.message();
        EXPECT_LE(observer.info().parts, 4);
        EXPECT_LT(std::fabs(observer.x()[0] - truth.h), 0.15);
    }
}

// Its bounces have no end, and no model of rest follows them.
TEST(ObserverEvents, ABallThatIsNotModelledAtRestIsNeverReadyThere) {
    for (const double interval_s : {0.1, 0.05}) {
        int beyond = 0, rows = 0;
        for (unsigned seed = 0; seed < 10; ++seed) {
            Observer observer(ball());
            Random random(seed);
            double h = 1, v = 0;
            std::uint64_t before = 0, most = 0;
            for (int k = 0; k * interval_s < 4; ++k) {
                use(observer, k * interval_s, h + random.normal(0.02));
                const hnav_observer_info info = observer.info();
                most = std::max(most, info.flow_evaluations - before);
                before = info.flow_evaluations;
                const Numbers x = observer.x(), sigma = observer.sigma();
                const bool is_beyond = std::fabs(x[0] - h) > 5 * sigma[0] || std::fabs(x[1] - v) > 5 * sigma[1];
                EXPECT_FALSE(is_beyond && info.ready) << k * interval_s;
                EXPECT_FALSE(v == 0 && k > 0 && info.ready) << k * interval_s;
                beyond += is_beyond;
                rows += 1;
                double left = interval_s;
                for (int bounces = 0; bounces < 300; ++bounces) {
                    const double to_floor = (v + std::sqrt(v * v + 2 * gravity * h)) / gravity;
                    if (to_floor >= left) break;
                    v = to_floor < 1e-9 ? 0 : -restitution * (v - gravity * to_floor);
                    h = 0;
                    left = v == 0 ? 0 : left - to_floor;
                }
                h += v * left - 0.5 * gravity * left * left;
                v -= gravity * left;
            }
            EXPECT_GT(observer.info().held, 0u);
            EXPECT_LT(most, 50000u); // of an interval
        }
        EXPECT_LT(beyond, rows / 20);
    }
}

TEST(ObserverEvents, AnEventThatFailsIsHeldBefore) {
    Heater broken;
    Given given = ball();
    given.plant.context = &broken;
    given.plant.event = [](void* c, double t_s, const double* x, const double* u, const double*, double* after) {
        return static_cast<Heater*>(c)->on > 0 ? ball_bounce(nullptr, t_s, x, u, nullptr, after) : -1;
    };
    Observer observer(given), undisturbed(ball());
    for (double t_s : {0.1, 0.2}) {
        use(observer, t_s, 1 - 0.5 * gravity * t_s * t_s);
        use(undisturbed, t_s, 1 - 0.5 * gravity * t_s * t_s);
    }
    broken.on = 0;
    ASSERT_EQ(hnav_observer_push(observer, 0, 0.6, 0.2), HNAV_OK);
    EXPECT_EQ(hnav_filter_advance(observer, 0.6), HNAV_OK);
    EXPECT_NE(observer.message().find("events"), std::string::npos) << observer.message();
    EXPECT_EQ(observer.info().held, 1u);
    EXPECT_EQ(observer.info().dropped, 0u);
    EXPECT_EQ(observer.info().ready, 0);
    EXPECT_GT(observer.sigma()[1], 3); // the event may have reversed the ball
    broken.on = 1;
    for (int k = 1; k <= 8; ++k) {
        const double t_s = 0.6 + 0.05 * k;
        ASSERT_EQ(hnav_filter_advance(undisturbed, t_s), HNAV_OK);
        const double h = undisturbed.x()[0];
        use(observer, t_s, h);
        use(undisturbed, t_s, h);
    }
    for (int i = 0; i < 2; ++i) EXPECT_LT(std::fabs(observer.x()[i] - undisturbed.x()[i]), 3 * observer.sigma()[i]) << i;
}

TEST(ObserverEvents, ATimeEventThatIsNotLaterIsRefusedAtOnce) {
    for (const double answer : {-1.0, 0.0, std::nan("")}) {
        static double next;
        next = answer;
        Given given = ball();
        given.plant.n_indicators = 0;
        given.plant.event = [](void*, double, const double*, const double*, const double*, double*) { return 0; };
        given.plant.next_event_s = [](void*, double t_s) { return std::isinf(t_s) ? 0.02 : next; };
        Observer observer(given);
        for (int k = 0; k < 4; ++k) {
            ASSERT_EQ(hnav_observer_push(observer, 0, 0.05 * k, 1), HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(observer, 0.05 * k), HNAV_OK);
        }
        EXPECT_NE(observer.message().find("next_event_s answers"), std::string::npos) << observer.message();
        EXPECT_EQ(observer.info().held, 3u);
        EXPECT_EQ(observer.info().ready, 0);
        EXPECT_LT(observer.info().flow_evaluations, 1000u);
    }
}

TEST(ObserverEvents, SaysWhatIsMissing) {
    const auto refused = [](const char* word, void (*spoil)(Given&)) {
        Heater heater;
        Given g = heater.given();
        spoil(g);
        EXPECT_NE(g.refusal(HNAV_ERROR_NULL_ARGUMENT).find(word), std::string::npos) << word;
    };
    refused("indicators", [](Given& g) { g.plant.indicators = nullptr; });
    refused("event", [](Given& g) { g.plant.event = nullptr; });
    refused("get_discrete", [](Given& g) { g.plant.get_discrete = nullptr; });
    refused("set_discrete", [](Given& g) { g.plant.set_discrete = nullptr; });
    // A caller compiled before events existed.
    Given old = ball();
    old.plant.size = offsetof(hnav_plant, n_indicators);
    Observer observer(old);
    ASSERT_EQ(hnav_filter_advance(observer, 1), HNAV_OK);
    EXPECT_LT(observer.x()[0], -3);
}
