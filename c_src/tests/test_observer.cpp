// The observer through the C API: a Kalman filter for a linear plant, the same bits for any arrival order of samples,
// consistent for nonlinear plants, and robust against plants that fail, are wrong or have a memory.
#include "hnav/hnav.h"

#include "counted_heap.hpp"
#include "hybrid/sundials_names.hpp"
#include "laws.hpp"
#include "maths/discretise.hpp"
#include "observer.hpp"
#include "van_der_pol.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

using hnav::test::Bytes;
using hnav::test::first_state;
using hnav::test::Given;
using hnav::test::Numbers;
using hnav::test::Observer;
using hnav::test::Random;
using hnav::test::van_der_pol;
using hnav::test::van_der_pol_jacobian;

namespace {

// ------------------------------------------------------------------------------------------------ plants

// A mass on a spring beside a slow first-order lag, driven by a force: linear.
constexpr double spring = 4, friction = 0.3, lag_1_s = 0.2;

int linear_derivatives(void*, double, const double* x, const double* u, const double*, double* dx) {
    dx[0] = x[1];
    dx[1] = -spring * x[0] - friction * x[1] + u[0];
    dx[2] = lag_1_s * (x[0] - x[2]);
    return 0;
}

int linear_outputs(void*, double, const double* x, const double* u, const double*, double* y) {
    y[0] = x[0];
    y[1] = x[2] + 0.5 * u[0];
    return 0;
}

Given linear() {
    Given g;
    g.plant.n_states = 3;
    g.plant.n_inputs = 1;
    g.plant.n_outputs = 2;
    g.plant.derivatives = linear_derivatives;
    g.plant.outputs = linear_outputs;
    g.start = {1, 0, 0.3};
    g.start_sigma = {0.5, 0.7, 0.2};
    g.noise = {0, 0.3, 0.02};
    g.sensor_sigma = {0.05, 0.1};
    return g;
}

Given oscillator() {
    Given g;
    g.plant.n_states = 2;
    g.plant.n_outputs = 1;
    g.plant.derivatives = van_der_pol;
    g.plant.outputs = first_state;
    g.start = {2, 0};
    g.start_sigma = {1, 1};
    g.noise = {0.01, 0.1};
    g.sensor_sigma = {0.05};
    return g;
}

// The truth by Heun's method with noise, twenty steps to a sample.
struct VanDerPol {
    explicit VanDerPol(unsigned seed) : random(seed) {}

    void step(double T) {
        for (int k = 0; k < 20; ++k) {
            const double d = T / 20;
            double f1[2], f2[2];
            van_der_pol(nullptr, 0, x.data(), nullptr, nullptr, f1);
            const double y[2] = {x[0] + d * f1[0], x[1] + d * f1[1]};
            van_der_pol(nullptr, 0, y, nullptr, nullptr, f2);
            x[0] += d / 2 * (f1[0] + f2[0]) + random.normal(0.01 * std::sqrt(d));
            x[1] += d / 2 * (f1[1] + f2[1]) + random.normal(0.1 * std::sqrt(d));
        }
    }

    Random random;
    Numbers x{2, 0};
};

// ------------------------------------------------------------------------------------------------ samples

struct Sample {
    double t_s;
    bool input;
    int index;
    double value;
};

// Two sensors with different intervals and an input that is held between samples, as in a recording.
std::vector<Sample> samples_of_linear(double duration_s, unsigned seed = 3) {
    Random random(seed);
    std::vector<Sample> samples;
    for (int k = 0; 0.05 * k <= duration_s; ++k) {
        const double t_s = 0.05 * k;
        if (k % 8 == 0) samples.push_back({t_s, true, 0, std::sin(t_s)});
        samples.push_back({t_s, false, 0, std::cos(2 * t_s) + random.normal(0.05)});
        if (k % 3 == 0) samples.push_back({t_s + (k % 2 ? 0.0 : 0.013), false, 1, 0.2 + random.normal(0.1)});
    }
    std::stable_sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) { return a.t_s < b.t_s; });
    return samples;
}

hnav_status push(hnav_filter* o, const Sample& s) {
    return s.input ? hnav_observer_push_input(o, s.index, s.t_s, s.value) : hnav_observer_push(o, s.index, s.t_s, s.value);
}

void go_through(hnav_filter* o, const std::vector<Sample>& samples) {
    for (const Sample& s : samples) {
        ASSERT_EQ(push(o, s), HNAV_OK);
        ASSERT_EQ(hnav_filter_advance(o, s.t_s), HNAV_OK) << hnav_filter_message(o);
    }
}

// The Kalman filter of the linear plant, discretised exactly.
struct KalmanFilter {
    Eigen::Vector3d x{1, 0, 0.3};
    Eigen::Matrix3d P = Eigen::Vector3d(0.25, 0.49, 0.04).asDiagonal();
    double t_s = 0, u = 0;

    void flow(double to_s) {
        if (to_s == t_s) return;
        hnav::Small A(3, 3), B(3, 1), Q = hnav::Small::Zero(3, 3);
        A << 0, 1, 0, -spring, -friction, 0, lag_1_s, 0, -lag_1_s;
        B << 0, 1, 0;
        Q(1, 1) = 0.09;
        Q(2, 2) = 4e-4;
        const hnav::Discrete d = hnav::discretise(A, B, Q, to_s - t_s);
        x = (d.A * x + d.B * u).eval();
        P = (d.A * P * d.A.transpose() + d.Q).eval();
        t_s = to_s;
    }

    void use(const Sample& s) {
        flow(s.t_s);
        if (s.input) {
            u = s.value;
            return;
        }
        Eigen::RowVector3d H = s.index == 0 ? Eigen::RowVector3d(1, 0, 0) : Eigen::RowVector3d(0, 0, 1);
        const double R = s.index == 0 ? 0.0025 : 0.01, S = H * P * H.transpose() + R;
        const Eigen::Vector3d K = P * H.transpose() / S;
        x += K * (s.value - H * x - (s.index == 1 ? 0.5 * u : 0));
        P = (P - K * H * P).eval();
    }
};

} // namespace

// ------------------------------------------------------------------------------------------------ laws

TEST(Observer, OfALinearPlantIsAKalmanFilter) {
    Given given = linear();
    given.options.queue_capacity = 1000;
    Observer observer(given);
    KalmanFilter exact;
    for (const Sample& s : samples_of_linear(20)) {
        ASSERT_EQ(push(observer, s), HNAV_OK);
        exact.use(s);
    }
    ASSERT_EQ(hnav_filter_advance(observer, 20.3), HNAV_OK);
    exact.flow(20.3);
    for (int i = 0; i < 3; ++i) {
        const double sigma = std::sqrt(exact.P(i, i));
        EXPECT_NEAR(observer.x()[i], exact.x[i], 1e-5 * sigma);
        EXPECT_NEAR(observer.sigma()[i], sigma, 1e-5 * sigma);
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(observer.P()[3 * i + j], exact.P(i, j), 1e-5 * sigma * std::sqrt(exact.P(j, j)));
    }
}

TEST(Observer, TimesThatAreAskedForDoNotChangeTheEstimate) {
    const Given given = linear();
    const auto samples = samples_of_linear(5);
    Observer reference(given);
    go_through(reference, samples);
    ASSERT_EQ(hnav_filter_advance(reference, 5.5), HNAV_OK);
    for (const double step : {0.0037, 0.02, 0.31, 5.5}) {
        Given roomy = given;
        roomy.options.queue_capacity = 1000;
        Observer observer(step > 1 ? roomy : given);
        std::size_t next = 0;
        for (double t = step; next < samples.size(); t += step) {
            while (next < samples.size() && samples[next].t_s <= t) ASSERT_EQ(push(observer, samples[next++]), HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(observer, std::min(t, 5.5)), HNAV_OK);
        }
        ASSERT_EQ(hnav_filter_advance(observer, 5.5), HNAV_OK);
        EXPECT_EQ(observer.x(), reference.x());
        EXPECT_EQ(observer.P(), reference.P());
    }
}

TEST(Observer, ArraysAreTheSameStepsBitForBit) {
    const Given given = oscillator();
    Observer steps(given), arrays(given);
    VanDerPol truth(1);
    const std::size_t n = 100;
    Numbers t(n), y(n), x(2 * n), sigma(2 * n), nis(n);
    std::vector<std::uint8_t> ready(n);
    for (std::size_t k = 0; k < n; ++k) {
        truth.step(0.05);
        t[k] = 0.05 * (k + 1);
        y[k] = k % 7 == 3 ? NAN : truth.x[0] + truth.random.normal(0.05);
    }
    auto in = hnav_sized<hnav_observer_run_input>();
    auto out = hnav_sized<hnav_observer_run_output>();
    in.t_s = t.data();
    in.sensors = y.data();
    out.x = x.data();
    out.sigma = sigma.data();
    out.nis = nis.data();
    out.ready = ready.data();
    size_t done = 0;
    ASSERT_EQ(hnav_observer_run(arrays, n, &in, &out, &done), HNAV_OK);
    EXPECT_EQ(done, n);
    for (std::size_t k = 0; k < n; ++k) {
        if (!std::isnan(y[k])) {
            ASSERT_EQ(hnav_observer_push(steps, 0, t[k], y[k]), HNAV_OK);
        }
        ASSERT_EQ(hnav_filter_advance(steps, t[k]), HNAV_OK);
        EXPECT_EQ(steps.x(), Numbers(&x[2 * k], &x[2 * k] + 2));
        EXPECT_EQ(steps.sigma(), Numbers(&sigma[2 * k], &sigma[2 * k] + 2));
        EXPECT_EQ(std::isnan(nis[k]), std::isnan(y[k]));
    }
    EXPECT_EQ(steps.info().ready, ready.back());
    EXPECT_TRUE(ready.back());
}

TEST(Observer, LateSamplesWithinTheHorizonGiveTheSameBits) {
    Given given = linear();
    given.options.horizon_s = 0.5;
    const auto samples = samples_of_linear(4);
    Observer in_order(given), late(given);
    go_through(in_order, samples);
    // Sensor 1 arrives 0.2 s late.
    std::vector<Sample> waiting;
    for (const Sample& s : samples) {
        while (!waiting.empty() && waiting.front().t_s + 0.2 <= s.t_s) {
            ASSERT_EQ(push(late, waiting.front()), HNAV_OK);
            waiting.erase(waiting.begin());
        }
        if (!s.input && s.index == 1) {
            waiting.push_back(s);
            continue;
        }
        ASSERT_EQ(push(late, s), HNAV_OK);
        ASSERT_EQ(hnav_filter_advance(late, s.t_s), HNAV_OK);
    }
    for (const Sample& s : waiting) ASSERT_EQ(push(late, s), HNAV_OK);
    for (hnav_filter* o : {static_cast<hnav_filter*>(late), static_cast<hnav_filter*>(in_order)})
        ASSERT_EQ(hnav_filter_advance(o, 4.1), HNAV_OK);
    EXPECT_EQ(late.x(), in_order.x());
    EXPECT_EQ(late.P(), in_order.P());
    EXPECT_EQ(hnav_observer_push(late, 1, 3.2, 0), HNAV_ERROR_LATE_SAMPLE);
    EXPECT_EQ(late.info().late, 1u);
}

TEST(Observer, GoesOnFromASavedStateBitForBit) {
    Given given = linear();
    given.options.horizon_s = 0.1;
    const auto samples = samples_of_linear(4);
    const std::vector<Sample> first(samples.begin(), samples.begin() + 70), rest(samples.begin() + 70, samples.end());
    Observer whole(given), saved(given), loaded(given);
    go_through(whole, samples);
    go_through(saved, first);
    const Bytes state = saved.saved();
    ASSERT_EQ(hnav_filter_load(loaded, state.data(), state.size()), HNAV_OK);
    EXPECT_EQ(loaded.saved(), state);
    go_through(loaded, rest);
    EXPECT_EQ(loaded.x(), whole.x());
    EXPECT_EQ(loaded.P(), whole.P());
    EXPECT_EQ(loaded.saved(), whole.saved());

    Given other = given;
    other.sensor_sigma[0] = 0.06;
    Observer stranger(other);
    EXPECT_EQ(hnav_filter_load(stranger, state.data(), state.size()), HNAV_ERROR_STATE_CORRUPT);
    EXPECT_EQ(hnav_filter_load(loaded, state.data(), state.size() - 8), HNAV_ERROR_SIZE);

    ASSERT_EQ(hnav_filter_reset(saved), HNAV_OK);
    go_through(saved, samples);
    EXPECT_EQ(saved.saved(), whole.saved());
}

// Fifty runs of ten seconds from a start with a large error.
TEST(Observer, StatesItsErrorsOfVanDerPol) {
    double nees = 0, nis = 0, count = 0;
    for (unsigned seed = 0; seed < 50; ++seed) {
        VanDerPol truth(seed);
        Given given = oscillator();
        given.options.start_mode = HNAV_OBSERVER_START_GIVEN;
        if (seed % 2) given.plant.derivatives_jacobian = van_der_pol_jacobian;
        for (double& start : given.start) start += truth.random.normal();
        Observer observer(given);
        for (int k = 0; k < 200; ++k) {
            truth.step(0.05);
            ASSERT_EQ(hnav_observer_push(observer, 0, 0.05 * (k + 1), truth.x[0] + truth.random.normal(0.05)), HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(observer, 0.05 * (k + 1)), HNAV_OK) << observer.message();
            if (k < 20) continue;
            nees += observer.nees(truth.x);
            nis += observer.innovation(0).nis;
            ++count;
        }
    }
    EXPECT_NEAR(nees / count / 2, 1, 0.07);
    EXPECT_NEAR(nis / count, 1, 0.05);
}

TEST(Observer, OwnDerivativesAndDifferencesAgree) {
    Given offered = oscillator(), differences = oscillator();
    offered.plant.derivatives_jacobian = van_der_pol_jacobian;
    Observer a(offered), b(differences);
    EXPECT_TRUE(a.proof(HNAV_DERIVATIVES_BY_STATES).exact);
    EXPECT_FALSE(b.proof(HNAV_DERIVATIVES_BY_STATES).offered);
    VanDerPol truth(5);
    for (int k = 0; k < 100; ++k) {
        truth.step(0.05);
        for (hnav_filter* o : {static_cast<hnav_filter*>(a), static_cast<hnav_filter*>(b)}) {
            ASSERT_EQ(hnav_observer_push(o, 0, 0.05 * k, truth.x[0]), HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(o, 0.05 * k), HNAV_OK);
        }
        for (int i = 0; i < 2; ++i) EXPECT_NEAR(a.x()[i], b.x()[i], 1e-7);
    }
}

// ------------------------------------------------------------------------------------------------ what is not a state

// A cup that cools at an unknown rate: x' = -p (x - 20).
Given cup() {
    Given g;
    g.plant.n_states = g.plant.n_parameters = g.plant.n_outputs = 1;
    g.plant.derivatives = [](void*, double, const double* x, const double*, const double* p, double* dx) {
        dx[0] = -p[0] * (x[0] - 20);
        return 0;
    };
    g.plant.outputs = first_state;
    g.start = {80, 0.02};
    g.start_sigma = {5, 0.02};
    g.sensor_sigma = {0.5};
    return g;
}

TEST(Observer, LearnsAParameter) {
    const Given g = cup();
    double normalised = 0;
    for (unsigned seed = 0; seed < 20; ++seed) {
        Random random(seed);
        const double rate = 0.03 + random.normal(0.003), start = 80 + random.normal(5);
        Observer observer(g);
        for (int k = 0; k <= 60; ++k) {
            const double t_s = 2.0 * k;
            ASSERT_EQ(hnav_observer_push(observer, 0, t_s, 20 + (start - 20) * std::exp(-rate * t_s) + random.normal(0.5)),
                      HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(observer, t_s), HNAV_OK);
        }
        EXPECT_NEAR(observer.x()[1], rate, 5 * observer.sigma()[1]);
        EXPECT_LT(observer.sigma()[1], 3e-4);
        normalised += std::pow((observer.x()[1] - rate) / observer.sigma()[1], 2) / 20;
    }
    EXPECT_GT(normalised, 0.35);
    EXPECT_LT(normalised, 2.2);
}

TEST(Observer, OwnDerivativesByALogarithmAreThoseOfDifferences) {
    Given offered = cup(), differences = cup();
    for (Given* g : {&offered, &differences}) g->logarithmic = {1};
    offered.plant.derivatives_jacobian = [](void*, double, const double* x, const double*, const double* p, double* J) {
        J[0] = -p[0];
        J[1] = 20 - x[0];
        return 0;
    };
    Observer a(offered), b(differences);
    EXPECT_TRUE(a.proof(HNAV_DERIVATIVES_BY_PARAMETERS).exact);
    for (int k = 0; k <= 60; ++k) {
        for (hnav_filter* o : {static_cast<hnav_filter*>(a), static_cast<hnav_filter*>(b)}) {
            ASSERT_EQ(hnav_observer_push(o, 0, 2.0 * k, 20 + 60 * std::exp(-0.06 * k)), HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(o, 2.0 * k), HNAV_OK);
        }
        EXPECT_NEAR(a.x()[1], b.x()[1], 1e-9);
        EXPECT_NEAR(a.sigma()[1] / b.sigma()[1], 1, 1e-6);
    }
    EXPECT_NEAR(a.x()[1], 0.03, 1e-3);
}

// A cart under an unknown force: x'' = u + d; the force u is known up to its noise.
TEST(Observer, LearnsAnUnknownInput) {
    Given g;
    g.plant.n_states = 2;
    g.plant.n_inputs = 2;
    g.plant.n_unknown_inputs = g.plant.n_outputs = 1;
    g.plant.derivatives = [](void*, double, const double* x, const double* u, const double*, double* dx) {
        dx[0] = x[1];
        dx[1] = u[0] + u[1];
        return 0;
    };
    g.plant.outputs = first_state;
    g.start_sigma = {1, 1, 2};
    g.noise = {0, 0, 0.1};
    g.sensor_sigma = {0.01};
    for (const double tau : {0.0, 100.0}) {
        g.time_constant = {tau};
        Observer observer(g);
        ASSERT_EQ(hnav_observer_push_input(observer, 0, 0, 0.5), HNAV_OK);
        EXPECT_EQ(hnav_observer_push_input(observer, 1, 0, 0.5), HNAV_ERROR_OUT_OF_RANGE);
        Random random(1);
        for (int k = 0; k <= 200; ++k) {
            const double t_s = 0.05 * k;
            ASSERT_EQ(hnav_observer_push(observer, 0, t_s, 0.5 * (0.5 - 1.5) * t_s * t_s + random.normal(0.01)), HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(observer, t_s), HNAV_OK);
        }
        EXPECT_NEAR(observer.x()[2], -1.5, 4 * observer.sigma()[2]);
        EXPECT_LT(observer.sigma()[2], 0.3);
        // Without the input the force decays to zero, or stays.
        ASSERT_EQ(hnav_filter_advance(observer, 1010), HNAV_OK) << observer.message();
        EXPECT_NEAR(observer.x()[2], tau > 0 ? 0 : -1.5, tau > 0 ? 1e-3 : 1);
    }
}

TEST(Observer, TimeOfThePlantIsTimeOfTheSamples) {
    Given g = oscillator();
    g.plant.n_states = 1;
    g.plant.derivatives = [](void*, double t_s, const double*, const double*, const double*, double* dx) {
        dx[0] = std::cos(t_s);
        return 0;
    };
    g.start = {std::sin(100.0)};
    g.start_sigma = {1e-3};
    g.noise = {};
    g.options.start_mode = HNAV_OBSERVER_START_GIVEN;
    g.options.start_time_s = 100;
    Observer observer(g);
    ASSERT_EQ(hnav_observer_push(observer, 0, 99, 5), HNAV_OK); // before the start: not used
    for (const double t_s : {101.0, 103.5, 117.25}) {
        ASSERT_EQ(hnav_filter_advance(observer, t_s), HNAV_OK);
        EXPECT_NEAR(observer.x()[0], std::sin(t_s), 1e-5);
    }
    EXPECT_EQ(observer.info().corrections, 0u);
}

// ------------------------------------------------------------------------------------------------ gates, readiness

TEST(Observer, AGateInflatesWhatIsFarOffOnceReady) {
    Given g = oscillator();
    g.gate_nis = {10.8};
    g.options.outlier_sigma = 0; // or the first that is far off would be rejected
    g.ready_sigma = {0.1, 0.5};
    Observer observer(g);
    VanDerPol truth(8);
    const auto sample = [&](int k, double error) {
        truth.step(0.05);
        EXPECT_EQ(hnav_observer_push(observer, 0, 0.05 * k, truth.x[0] + truth.random.normal(0.05) + error), HNAV_OK);
        EXPECT_EQ(hnav_filter_advance(observer, 0.05 * k), HNAV_OK);
    };
    sample(0, 0);
    EXPECT_FALSE(observer.info().ready);
    for (int k = 1; k < 100; ++k) sample(k, 0);
    EXPECT_TRUE(observer.info().ready);
    sample(100, 3);
    EXPECT_EQ(observer.innovation(0).inflated, 1u);
    EXPECT_GT(observer.innovation(0).nis, 100);
    EXPECT_NEAR(observer.x()[0], truth.x[0], 0.15);
    // A sensor with a lasting offset is no outlier: the mean innovation shows it, and the estimate is no longer ready.
    for (int k = 101; k < 140; ++k) sample(k, 3);
    EXPECT_FALSE(observer.info().ready);
}

// ------------------------------------------------------------------------------------------------ hostile plants

namespace {

struct Hostile {
    enum Kind { none, nan, elsewhere, broken } derivatives = none, outputs = none;
    double calls = 0;
};

int hostile(Hostile::Kind kind, double* value) {
    if (kind == Hostile::nan) *value = NAN;
    return kind == Hostile::elsewhere ? 1 : kind == Hostile::broken ? -1 : 0;
}

Given hostile_plant(Hostile* context) {
    Given g = oscillator();
    g.plant.context = context;
    g.plant.derivatives = [](void* c, double t_s, const double* x, const double* u, const double* p, double* dx) {
        van_der_pol(nullptr, t_s, x, u, p, dx);
        return hostile(static_cast<Hostile*>(c)->derivatives, dx + 1);
    };
    g.plant.outputs = [](void* c, double t_s, const double* x, const double* u, const double* p, double* y) {
        first_state(nullptr, t_s, x, u, p, y);
        return hostile(static_cast<Hostile*>(c)->outputs, y);
    };
    return g;
}

} // namespace

TEST(Observer, APlantWithoutAnAnswerCostsItsSampleAndNothingElse) {
    for (const Hostile::Kind kind : {Hostile::nan, Hostile::elsewhere, Hostile::broken})
        for (const bool in_outputs : {false, true}) {
            Hostile context;
            Observer observer(hostile_plant(&context)), undisturbed(hostile_plant(&context));
            const auto step = [&](hnav_filter* o, double t_s) {
                EXPECT_EQ(hnav_observer_push(o, 0, t_s, 2), HNAV_OK);
                return hnav_filter_advance(o, t_s);
            };
            for (hnav_filter* o : {static_cast<hnav_filter*>(observer), static_cast<hnav_filter*>(undisturbed)})
                for (double t_s : {0.0, 0.1, 0.2}) ASSERT_EQ(step(o, t_s), HNAV_OK);
            (in_outputs ? context.outputs : context.derivatives) = kind;
            // Without derivatives the estimate is held and the sample is used; without outputs the sample cannot be used.
            EXPECT_EQ(step(observer, 0.3), in_outputs ? HNAV_ERROR_SOLVER : HNAV_OK);
            EXPECT_NE(observer.message().find(in_outputs ? "outputs" : "derivatives"), std::string::npos) << observer.message();
            EXPECT_EQ(observer.info().dropped, in_outputs ? 1u : 0u);
            EXPECT_EQ(observer.info().held, in_outputs ? 0u : 1u);
            EXPECT_EQ(observer.info().ready, 0);
            context = {};
            for (hnav_filter* o : {static_cast<hnav_filter*>(observer), static_cast<hnav_filter*>(undisturbed)})
                ASSERT_EQ(step(o, 0.4), HNAV_OK);
            const Numbers x = observer.x(), sigma = observer.sigma(), expected = undisturbed.x();
            for (std::size_t i = 0; i < x.size(); ++i)
                EXPECT_NEAR(x[i], expected[i], in_outputs ? 1e-6 : 3 * sigma[i]) << "kind " << kind << " of " << i;
        }
}

TEST(Observer, InputsOfASampleThatCannotBeUsedHoldNevertheless) {
    bool fails = false;
    Given g;
    g.plant.n_states = g.plant.n_outputs = 1;
    g.plant.n_inputs = 2;
    g.plant.context = &fails;
    g.plant.derivatives = [](void*, double, const double*, const double* u, const double*, double* dx) {
        dx[0] = u[0] + u[1];
        return 0;
    };
    g.plant.outputs = [](void* failing, double, const double* x, const double*, const double*, double* y) {
        y[0] = x[0];
        return *static_cast<bool*>(failing) ? -1 : 0;
    };
    g.start = {0};
    g.start_sigma = {1e-3};
    g.noise = {0};
    g.sensor_sigma = {1};
    Observer observer(g);
    ASSERT_EQ(hnav_observer_push(observer, 0, 0, 0), HNAV_OK);
    ASSERT_EQ(hnav_filter_advance(observer, 0), HNAV_OK);
    fails = true;
    for (const int input : {0, 1}) ASSERT_EQ(hnav_observer_push_input(observer, input, 0.5, 1 + input), HNAV_OK);
    ASSERT_EQ(hnav_observer_push(observer, 0, 0.5, 0), HNAV_OK);
    EXPECT_EQ(hnav_filter_advance(observer, 0.5), HNAV_ERROR_SOLVER);
    fails = false;
    ASSERT_EQ(hnav_filter_advance(observer, 1.5), HNAV_OK);
    EXPECT_NEAR(observer.x()[0], 3, 0.01);
}

TEST(Observer, AllPointsOfALinearisationComeInOneCall) {
    int most = 0;
    Given g = linear();
    g.plant.context = &most;
    g.plant.derivatives_at_points = [](void* largest, int32_t count, double t_s, const double* x, const double* u,
                                       const double* p, double* values) {
        *static_cast<int*>(largest) = std::max(*static_cast<int*>(largest), count);
        for (int k = 0; k < count; ++k) linear_derivatives(nullptr, t_s, x + 3 * k, u + k, p, values + 3 * k);
        return 0;
    };
    Observer observer(g), single(linear());
    for (hnav_filter* o : {static_cast<hnav_filter*>(observer), static_cast<hnav_filter*>(single)})
        go_through(o, samples_of_linear(2));
    EXPECT_EQ(most, 2 * 3 + 1); // its own and two for each number that is estimated
    EXPECT_EQ(observer.x(), single.x());
    EXPECT_EQ(observer.P(), single.P());
}

TEST(Observer, FindsDerivativesThatLie) {
    Given g = linear();
    g.plant.derivatives_jacobian = [](void*, double, const double*, const double*, const double*, double* J) {
        const double stated[9] = {0, 1, 0, -spring, friction, 0, lag_1_s, 0, -lag_1_s}; // the sign of the friction is wrong
        std::copy_n(stated, 9, J);
        return 0;
    };
    g.plant.outputs_jacobian = [](void*, double, const double*, const double*, const double*, double*) { return -1; };
    Observer lies(g), honest(linear());
    const auto proof = lies.proof(HNAV_DERIVATIVES_BY_STATES);
    EXPECT_TRUE(proof.offered);
    EXPECT_FALSE(proof.exact);
    EXPECT_EQ(proof.row, 1);
    EXPECT_EQ(proof.column, 1);
    EXPECT_EQ(proof.stated, friction);
    EXPECT_NEAR(proof.measured, -friction, 1e-6);
    EXPECT_TRUE(lies.proof(HNAV_OUTPUTS_BY_STATES).offered);
    EXPECT_FALSE(lies.proof(HNAV_OUTPUTS_BY_STATES).exact);
    const auto samples = samples_of_linear(2);
    go_through(lies, samples);
    go_through(honest, samples);
    EXPECT_EQ(lies.x(), honest.x());
}

TEST(Observer, RefusesAPlantThatRemembers) {
    Hostile context;
    Given g = hostile_plant(&context);
    g.plant.derivatives = [](void* c, double t_s, const double* x, const double* u, const double* p, double* dx) {
        van_der_pol(nullptr, t_s, x, u, p, dx);
        dx[0] += 1e-6 * static_cast<Hostile*>(c)->calls++;
        return 0;
    };
    EXPECT_NE(g.refusal(HNAV_ERROR_UNSUPPORTED).find("remembers"), std::string::npos);
    // A difference in the last digits is accepted, with a message.
    g.plant.derivatives = [](void* c, double t_s, const double* x, const double* u, const double* p, double* dx) {
        van_der_pol(nullptr, t_s, x, u, p, dx);
        dx[1] *= 1 + 1e-15 * static_cast<Hostile*>(c)->calls++;
        return 0;
    };
    Observer observer(g);
    EXPECT_FALSE(observer.info().repeatable);
    EXPECT_TRUE(Observer(oscillator()).info().repeatable);
}

// x' = -rate (x - cos t) + w: a sample is forgotten after a second, and x stays at cos t with a variance of q^2 / (2 rate).
TEST(Observer, AStiffPlantIsCrossedByAnImplicitSolver) {
    static double rate;
    for (const double of : {1e5, 1e7, 1e9}) {
        rate = of;
        Given g = oscillator();
        g.plant.n_states = 1;
        g.plant.derivatives = [](void*, double t_s, const double* x, const double*, const double*, double* dx) {
            dx[0] = -rate * (x[0] - std::cos(t_s));
            return 0;
        };
        g.start = g.start_sigma = {1};
        g.noise = {0.1 * std::sqrt(2 * rate)};
        Observer observer(g);
        for (int k = 0; k < 5; ++k) {
            ASSERT_EQ(hnav_observer_push(observer, 0, k, 1), HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(observer, k + 0.5), HNAV_OK) << observer.message();
            EXPECT_NEAR(observer.x()[0], std::cos(k + 0.5), 1e-5) << "rate " << rate;
            EXPECT_NEAR(observer.sigma()[0], 0.1, 1e-5) << "rate " << rate;
        }
        EXPECT_LT(observer.info().steps, 3000u) << "rate " << rate;
    }
}

TEST(Observer, AnIntervalThatTakesTooManyStepsIsGivenUp) {
    Given g = oscillator();
    g.plant.n_states = 1;
    g.plant.derivatives = [](void*, double t_s, const double* x, const double*, const double*, double* dx) {
        dx[0] = -1e5 * (x[0] - std::cos(100 * t_s));
        return 0;
    };
    g.start = g.start_sigma = {1};
    g.noise = {0.1};
    g.options.max_steps = 20;
    Observer observer(g);
    ASSERT_EQ(hnav_observer_push(observer, 0, 0, 1), HNAV_OK);
    ASSERT_EQ(hnav_observer_push(observer, 0, 1, 1), HNAV_OK);
    EXPECT_EQ(hnav_filter_advance(observer, 1), HNAV_OK);
    EXPECT_EQ(observer.info().held, 1u);
    EXPECT_NE(observer.message().find("more than max_steps steps of the solver"), std::string::npos) << observer.message();
}

// After any calls in any order every shown number is finite, and a reset restores the initial state.
TEST(Observer, RandomCallsLeaveASoundEstimate) {
    const auto samples = samples_of_linear(2);
    for (unsigned seed = 0; seed < 8; ++seed) {
        Random random(seed);
        const auto any_of = [&](std::initializer_list<double> values) {
            return values.begin()[static_cast<std::size_t>(std::fabs(random.normal()) * 1e6) % values.size()];
        };
        Given given = linear();
        given.options.horizon_s = any_of({0, 0.1, 10});
        given.options.queue_capacity = static_cast<int>(any_of({4, 64}));
        given.options.max_steps = 300;
        given.gate_nis = {10, 0};
        Observer observer(given), fresh(given);
        double t_s = any_of({0, -1e5, 1.6e9});
        for (int k = 0; k < 100; ++k) {
            t_s += any_of({0, 1e-13, 1e-3, 0.1, 30, -0.05});
            const double value = any_of({0, 1, random.normal(), 1e8, -1e150, 1e300, NAN, INFINITY});
            const int index = static_cast<int>(any_of({-1, 0, 1, 2}));
            if (k % 3 == 0) hnav_observer_push_input(observer, index, t_s, std::fabs(value) > 1e8 ? 0 : value);
            else hnav_observer_push(observer, index, t_s, value);
            hnav_filter_advance(observer, any_of({t_s, t_s, t_s, NAN, t_s + 1}));
            for (const double x : observer.x()) ASSERT_TRUE(std::isfinite(x)) << "seed " << seed << " call " << k;
            for (const double sigma : observer.sigma()) ASSERT_TRUE(sigma >= 0 && std::isfinite(sigma)) << "seed " << seed;
            ASSERT_TRUE(std::isfinite(observer.number_of(1, [](const auto& i) { return i.mean_nis; })));
        }
        ASSERT_EQ(hnav_filter_reset(observer), HNAV_OK);
        for (const Sample& s : samples)
            for (hnav_filter* o : {static_cast<hnav_filter*>(observer), static_cast<hnav_filter*>(fresh)}) {
                push(o, s);
                hnav_filter_advance(o, s.t_s);
            }
        EXPECT_EQ(observer.P(), fresh.P());
    }
}

// An explicit step has seven evaluations, and a block of derivatives as many.
TEST(Observer, AsksNoMoreThanSevenTimesForAnInterval) {
    Given given = oscillator();
    given.plant.derivatives_jacobian = van_der_pol_jacobian;
    Observer observer(given);
    VanDerPol truth(3);
    for (int k = 0; k <= 100; ++k) {
        truth.step(0.05);
        ASSERT_EQ(hnav_observer_push(observer, 0, 0.05 * k, truth.x[0]), HNAV_OK);
        ASSERT_EQ(hnav_filter_advance(observer, 0.05 * k), HNAV_OK);
    }
    EXPECT_EQ(observer.info().steps, 100u);
    EXPECT_LE(observer.info().flow_evaluations, 700u);
}

TEST(Observer, NothingAllocatesAfterCreate) {
#ifndef HNAV_HEAP_IS_COUNTED
    GTEST_SKIP() << "the heap is not counted here";
#else
    const auto samples = samples_of_linear(4);
    Given given = linear();
    given.options.horizon_s = 0.1;
    Observer observer(given);
    heap::allocations = 0;
    heap::counting = true;
    go_through(observer, samples);
    heap::counting = false;
    EXPECT_EQ(heap::allocations, 0);
#endif
}

// The last row has no later samples; the state of the filter does not change.
TEST(Observer, SmoothsARecordingAndStaysWhereItIs) {
    constexpr size_t n = 200, N = 2;
    Numbers t(n), y(n), x(n * N), sigma(n * N), smooth_x(n * N), smooth_sigma(n * N);
    Random random(8);
    for (size_t i = 0; i < n; ++i) {
        t[i] = 0.05 * static_cast<double>(i);
        y[i] = 2 * std::cos(t[i]) + random.normal(0.05);
    }
    auto in = hnav_sized<hnav_observer_run_input>();
    in.t_s = t.data();
    in.sensors = y.data();
    auto out = hnav_sized<hnav_observer_run_output>();
    out.x = x.data();
    out.sigma = sigma.data();
    const Observer o(oscillator());
    ASSERT_EQ(hnav_observer_run(o, n, &in, &out, nullptr), HNAV_OK);
    const Bytes before = o.saved();
    out.x = smooth_x.data();
    out.sigma = smooth_sigma.data();
    ASSERT_EQ(hnav_observer_smooth(o, n, &in, &out), HNAV_OK);
    EXPECT_EQ(o.saved(), before);
    for (size_t k = 0; k < N; ++k) {
        EXPECT_EQ(smooth_x[(n - 1) * N + k], x[(n - 1) * N + k]);
        EXPECT_LT(smooth_sigma[n / 2 * N + k], 0.8 * sigma[n / 2 * N + k]);
    }
    t[7] = t[6] - 1;
    EXPECT_EQ(hnav_observer_smooth(o, n, &in, &out), HNAV_ERROR_TIME_BACKWARDS) << o.message();
    EXPECT_EQ(hnav_observer_smooth(o, n, nullptr, &out), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(o.saved(), before);
}

TEST(Observer, AStiffIntervalAllocatesNothing) {
#ifndef HNAV_HEAP_IS_COUNTED
    GTEST_SKIP() << "the heap is not counted here";
#else
    Given g = linear();
    g.plant.derivatives = [](void*, double, const double* x, const double* u, const double*, double* dx) {
        dx[0] = x[1];
        dx[1] = -1e5 * (x[1] + x[0] - u[0]);
        return 0;
    };
    Observer observer(g);
    heap::allocations = 0;
    heap::counting = true;
    for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(hnav_observer_push(observer, 0, k, 1), HNAV_OK);
        EXPECT_EQ(hnav_filter_advance(observer, k), HNAV_OK);
    }
    heap::counting = false;
    // Version 7 of SUNDIALS allocates the text of an error on the heap and frees it: once, when the explicit method fails.
    EXPECT_EQ(heap::allocations, SUNDIALS_VERSION_MAJOR < 7 ? 0 : 1);
    EXPECT_EQ(heap::held, 0);
#endif
}

// ------------------------------------------------------------------------------------------------ refusals

TEST(Observer, SaysWhatIsImpossible) {
    const auto refused = [](hnav_status status, const char* word, void (*spoil)(Given&)) {
        Given g = linear();
        spoil(g);
        EXPECT_NE(g.refusal(status).find(word), std::string::npos) << word << ": " << g.refusal(status);
    };
    refused(HNAV_ERROR_OPTION, "nothing to estimate", [](Given& g) { g.plant.n_states = 0; });
    refused(HNAV_ERROR_OPTION, "sensor", [](Given& g) { g.plant.n_outputs = 0; });
    refused(HNAV_ERROR_SIZE, "unknown", [](Given& g) { g.plant.n_unknown_inputs = 2; });
    refused(HNAV_ERROR_SIZE, "more than 1 GiB, the most of an observer: estimate fewer",
            [](Given& g) { g.plant.n_states = 5001; });
    refused(HNAV_ERROR_SIZE, "62", [](Given& g) { g.plant.n_outputs = 62; });
    refused(HNAV_ERROR_SIZE, "is -1, below 0", [](Given& g) { g.plant.n_inputs = -1; });
    refused(HNAV_ERROR_NULL_ARGUMENT, "derivatives", [](Given& g) { g.plant.derivatives = nullptr; });
    refused(HNAV_ERROR_NULL_ARGUMENT, "outputs", [](Given& g) { g.plant.outputs = nullptr; });
    refused(HNAV_ERROR_NULL_ARGUMENT, "start_sigma", [](Given& g) { g.start_sigma.clear(); });
    refused(HNAV_ERROR_NULL_ARGUMENT, "sensor_sigma", [](Given& g) { g.sensor_sigma.clear(); });
    refused(HNAV_ERROR_NON_FINITE, "start[1]", [](Given& g) { g.start[1] = NAN; });
    refused(HNAV_ERROR_OPTION, "noise[2]", [](Given& g) { g.noise[2] = -1; });
    refused(HNAV_ERROR_OPTION, "sensor_sigma[1]", [](Given& g) { g.sensor_sigma[1] = 0; });
    refused(HNAV_ERROR_OPTION, "no noise", [](Given& g) { g.start_sigma = g.noise = {0, 0, 0}; });
    refused(HNAV_ERROR_OPTION, "ready_sigma[0]", [](Given& g) { g.ready_sigma = {0, 1, 1}; });
    refused(HNAV_ERROR_OPTION, "rtol", [](Given& g) { g.options.rtol = 1; });
    refused(HNAV_ERROR_OPTIONS_STAMP, "hnav_observer_defaults", [](Given& g) { g.options = {}; });
    refused(HNAV_ERROR_SIZE, "plant.size", [](Given& g) { g.plant.size = 3; });
    refused(HNAV_ERROR_SOLVER, "answered -1", [](Given& g) {
        g.plant.derivatives = [](void*, double, const double*, const double*, const double*, double*) { return -1; };
    });
    refused(HNAV_ERROR_SOLVER, "outputs[0]", [](Given& g) {
        g.plant.outputs = [](void*, double, const double*, const double*, const double*, double* y) {
            y[0] = y[1] = NAN;
            return 0;
        };
    });
}

TEST(Observer, AnswersBadCallsAndGoesOn) {
    Observer observer(linear());
    auto innovation = hnav_sized<hnav_observer_innovation_of>();
    EXPECT_EQ(hnav_observer_innovation(observer, 0, &innovation), HNAV_ERROR_NO_DATA);
    EXPECT_EQ(hnav_observer_innovation(observer, 2, &innovation), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_observer_push(observer, 2, 0, 1), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_observer_push(observer, -1, 0, 1), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_observer_push(observer, 0, NAN, 1), HNAV_ERROR_NON_FINITE);
    EXPECT_EQ(hnav_observer_push(observer, 0, 0, INFINITY), HNAV_ERROR_NON_FINITE);
    EXPECT_EQ(hnav_observer_push(observer, 0, 1e13, 1), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_filter_advance(observer, NAN), HNAV_ERROR_NON_FINITE);
    EXPECT_EQ(hnav_observer_proof(observer, static_cast<hnav_plant_block>(6), nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_filter_covariance(observer, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_filter_advance(nullptr, 0), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(observer.info().non_finite, 2u);
    // Before any sample the initial estimate is shown.
    EXPECT_EQ(observer.x(), (Numbers{1, 0, 0.3}));
    EXPECT_FALSE(observer.info().begun);
    go_through(observer, samples_of_linear(1));
    EXPECT_TRUE(observer.info().begun);
    EXPECT_EQ(hnav_filter_advance(observer, 0.5), HNAV_ERROR_TIME_BACKWARDS);
    EXPECT_EQ(hnav_observer_push(observer, 0, 0.5, 1), HNAV_ERROR_LATE_SAMPLE);
}
