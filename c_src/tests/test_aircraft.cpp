// The aircraft with an INS through the C API: its flight is a function of seed and commands, its noise has the stated
// statistics, every refusal names its cause, and the heap.
#include "hnav/simulation.h"

#include "counted_heap.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// A damped oscillator beside a slow state, with one control.
struct Model {
    std::vector<double> A = {-0.5, 2, 0, -2, -0.5, 0.3, 0, 0, -0.2}, B = {0, 1, 0};
    std::vector<double> noise = {0.3, 0.2, 0.1}, v = {0.5, 0.2, 0.1}, start = {0, 0, 0}, start_sigma = {1, 1, 1};
    std::vector<double> sigma = {2, 1, 0.5}, tau = {6, 6, 3};
    std::vector<double> gravity_sigma, gravity_tau = {20, 20, 20};
    std::vector<hnav_square_wave> commands = {{0.3, 4, 0}};
    std::vector<hnav_noise_fault> faults = {{0, 0, 1}, {8, 15, 8}, {0, 0, 1}};
    double interval_s = 0.1;

    hnav_aircraft_model view() const {
        auto m = hnav_sized<hnav_aircraft_model>();
        m.nx = 3;
        m.nu = 1;
        m.interval_s = interval_s;
        m.A_1_s = A.data();
        m.B_1_s = B.data();
        m.process_noise_per_sqrt_s = noise.data();
        m.measurement_sigma = v.data();
        m.accelerometer_error = {sigma.empty() ? nullptr : sigma.data(), tau.data()};
        m.gravity_error = {gravity_sigma.empty() ? nullptr : gravity_sigma.data(), gravity_tau.data()};
        m.start = start.data();
        m.start_sigma = start_sigma.data();
        m.commands = commands.data();
        m.faults = faults.data();
        return m;
    }
};

hnav_aircraft_options seeded(std::uint64_t seed) {
    hnav_aircraft_options options = hnav_aircraft_defaults();
    options.seed = seed;
    return options;
}

class Plant {
public:
    explicit Plant(const Model& model = Model(), const hnav_aircraft_options& options = hnav_aircraft_defaults()) {
        const hnav_aircraft_model view = model.view();
        char message[320];
        EXPECT_EQ(hnav_aircraft_create(&handle, &options, &view, message, sizeof message), HNAV_OK) << message;
    }
    ~Plant() { hnav_aircraft_destroy(handle); }
    Plant(const Plant&) = delete;

    struct Flight {
        std::vector<double> x, lambda, z, u, factor;
    };

    // The next n samples.
    Flight run(std::size_t n, const double* command = nullptr) {
        Flight f;
        for (std::vector<double>* rows : {&f.x, &f.lambda, &f.z, &f.factor}) rows->resize(3 * n);
        f.u.resize(n);
        hnav_aircraft_sample out{
            sizeof(hnav_aircraft_sample), 0, 0, f.x.data(), f.lambda.data(), f.z.data(), f.u.data(), f.factor.data()};
        EXPECT_EQ(hnav_aircraft_run(handle, n, command, &out), HNAV_OK) << hnav_aircraft_message(handle);
        return f;
    }

    hnav_aircraft* handle = nullptr;
};

// Mean of a[k] a[k - lag] of channel i.
double correlation(const std::vector<double>& rows, int i, int lag) {
    const std::size_t n = rows.size() / 3;
    double sum = 0;
    for (std::size_t k = lag; k < n; ++k) sum += rows[3 * k + i] * rows[3 * (k - lag) + i];
    return sum / static_cast<double>(n - lag);
}

TEST(Aircraft, EqualSeedsGiveEqualFlightsAndOthersDiffer) {
    Plant a(Model(), seeded(0)), b(Model(), seeded(0)), c(Model(), seeded(1));
    const auto first = a.run(100), again = b.run(100), other = c.run(100);
    EXPECT_EQ(first.z, again.z);
    EXPECT_NE(first.z, other.z);
    EXPECT_EQ(first.u, other.u);
}

TEST(Aircraft, ResetGoesBackToTheSameFlight) {
    Plant plant;
    const auto first = plant.run(50);
    EXPECT_EQ(hnav_aircraft_reset(plant.handle), HNAV_OK);
    EXPECT_EQ(plant.run(50).z, first.z);
}

TEST(Aircraft, OneSourceOfNoiseDoesNotDisturbAnother) {
    Model quiet;
    quiet.v = {0, 0, 0};
    Plant loud, silent(quiet);
    const auto with = loud.run(100), without = silent.run(100);
    EXPECT_EQ(with.x, without.x);
    EXPECT_EQ(with.lambda, without.lambda);
}

TEST(Aircraft, AMeasurementIsTruthPlusErrorWhenThereIsNoWhiteNoise) {
    Model model;
    model.v = {0, 0, 0};
    model.gravity_sigma = {1, 1, 1};
    Plant plant(model);
    const auto flight = plant.run(100);
    for (std::size_t i = 0; i < flight.z.size(); ++i) EXPECT_EQ(flight.z[i], flight.x[i] + flight.lambda[i]);
}

TEST(Aircraft, WithoutNoiseItIsTheLinearSystemOfItsFilterModel) {
    Model model;
    model.noise = {0, 0, 0};
    Plant plant(model);
    std::vector<double> command(100);
    for (int k = 0; k < 100; ++k) command[k] = 0.01 * k;
    const auto flight = plant.run(100, command.data());
    auto m = hnav_sized<hnav_ins_error_model>();
    ASSERT_EQ(hnav_aircraft_filter_model(plant.handle, &m), HNAV_OK);
    for (int k = 1; k < 100; ++k) {
        const double wave = std::sin(2 * M_PI * 0.1 * (k - 1) / 4);
        const double sign = std::fabs(wave) < 1e-9 ? 0 : wave > 0 ? 1 : -1;
        EXPECT_NEAR(flight.u[k], 0.3 * sign + command[k - 1], 1e-15) << k;
        for (int i = 0; i < 3; ++i) {
            double x = m.B[i] * flight.u[k];
            for (int j = 0; j < 3; ++j) x += m.A[3 * i + j] * flight.x[3 * (k - 1) + j];
            EXPECT_NEAR(flight.x[3 * k + i], x, 1e-13);
        }
    }
}

TEST(Aircraft, ColouredErrorsHaveTheirSigmaAndTheirTimeConstantInBothForms) {
    for (const int euler : {0, 1}) {
        hnav_aircraft_options options = seeded(3);
        options.euler_colour = euler;
        Plant plant(Model(), options);
        const int n = 200000;
        const auto flight = plant.run(n);
        const Model model;
        for (int i = 0; i < 3; ++i) {
            const double ratio = 0.1 / model.tau[i], phi = euler ? 1 - ratio : std::exp(-ratio);
            const double variance = model.sigma[i] * model.sigma[i];
            // Four standard errors of a variance from n samples of a first-order process.
            const double error = 4 * std::sqrt(2.0 / n * (1 + phi * phi) / (1 - phi * phi));
            EXPECT_NEAR(correlation(flight.lambda, i, 0) / variance, 1, error);
            EXPECT_NEAR(correlation(flight.lambda, i, 1) / correlation(flight.lambda, i, 0), phi,
                        4 * std::sqrt((1 - phi * phi) / n));
        }
    }
}

TEST(Aircraft, TheTwoColouredErrorsAddUp) {
    Model model;
    model.gravity_sigma = {3, 0, 1};
    Plant both(model, seeded(4));
    const int n = 400000;
    const auto flight = both.run(n);
    for (int i = 0; i < 3; ++i) {
        const double accelerometer = model.sigma[i] * model.sigma[i], gravity = model.gravity_sigma[i] * model.gravity_sigma[i];
        EXPECT_NEAR(correlation(flight.lambda, i, 0) / (accelerometer + gravity), 1, 4 * std::sqrt(2.0 / n * 200));
    }
}

TEST(Aircraft, ProcessNoiseHasTheCovarianceOfTheFilterModelInBothForms) {
    for (const int exact : {0, 1}) {
        hnav_aircraft_options options = seeded(5);
        options.exact_process_noise = exact;
        Plant plant(Model(), options);
        auto m = hnav_sized<hnav_ins_error_model>();
        ASSERT_EQ(hnav_aircraft_filter_model(plant.handle, &m), HNAV_OK);
        EXPECT_EQ(m.Qw[1] != 0, exact == 1); // the exact integral correlates the states
        const int n = 200000;
        const auto flight = plant.run(n);
        double Q[9] = {};
        for (int k = 1; k < n; ++k) {
            double w[3];
            for (int i = 0; i < 3; ++i) {
                w[i] = flight.x[3 * k + i] - m.B[i] * flight.u[k];
                for (int j = 0; j < 3; ++j) w[i] -= m.A[3 * i + j] * flight.x[3 * (k - 1) + j];
            }
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) Q[3 * i + j] += w[i] * w[j] / (n - 1);
        }
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                EXPECT_NEAR(Q[3 * i + j], m.Qw[3 * i + j], 4 * std::sqrt(2.0 / n * m.Qw[4 * i] * m.Qw[4 * j])) << i << j << exact;
    }
}

TEST(Aircraft, AFaultHoldsFromItsFirstToItsLastSample) {
    Plant plant;
    const auto flight = plant.run(200);
    for (int k = 0; k < 200; ++k) {
        EXPECT_EQ(flight.factor[3 * k + 1], k >= 80 && k <= 150 ? 8 : 1) << k;
        EXPECT_EQ(flight.factor[3 * k], 1);
    }
}

TEST(Aircraft, AFaultMultipliesTheWhiteNoiseAndNothingElse) {
    Model healthy;
    healthy.faults[1].factor = 1;
    Plant sound(healthy), faulty;
    const auto a = sound.run(200), b = faulty.run(200);
    EXPECT_EQ(a.x, b.x);
    for (int k = 0; k < 200; ++k)
        for (int i = 0; i < 3; ++i) {
            const int at = 3 * k + i;
            const double v = a.z[at] - a.x[at] - a.lambda[at];
            EXPECT_NEAR(b.z[at] - b.x[at] - b.lambda[at], b.factor[at] * v, 1e-13);
        }
}

TEST(Aircraft, ItsFilterIsConsistent) {
    Model model;
    model.faults[1].factor = 1;
    Plant plant(model, seeded(6));
    auto m = hnav_sized<hnav_ins_error_model>();
    ASSERT_EQ(hnav_aircraft_filter_model(plant.handle, &m), HNAV_OK);
    hnav_ins_error_options options = hnav_ins_error_defaults();
    options.noise_scaling = HNAV_NOISE_SCALING_NONE;
    hnav_ins_error_filter* filter;
    char message[320];
    ASSERT_EQ(hnav_ins_error_filter_create(&filter, &options, &m, message, sizeof message), HNAV_OK) << message;
    const int n = 20000;
    const auto flight = plant.run(n);
    double sum = 0;
    for (int k = 0; k < n; ++k) {
        ASSERT_EQ(hnav_ins_error_filter_step(filter, &flight.u[k], &flight.z[3 * k], nullptr), HNAV_OK);
        double nis;
        ASSERT_EQ(hnav_ins_error_filter_innovation(filter, nullptr, nullptr, &nis), HNAV_OK);
        sum += nis;
    }
    hnav_ins_error_filter_destroy(filter);
    // NIS of white innovations: chi-square with 3 degrees of freedom each, within 99.9 % bounds of its mean.
    EXPECT_NEAR(sum / n, 3, 3.29 * std::sqrt(6.0 / n));
}

TEST(Aircraft, ASavedFlightGoesOnBitForBit) {
    Plant plant;
    plant.run(70);
    std::size_t bytes = 0;
    ASSERT_EQ(hnav_aircraft_state_size(plant.handle, &bytes), HNAV_OK);
    std::vector<char> state(bytes);
    ASSERT_EQ(hnav_aircraft_save(plant.handle, state.data(), bytes), HNAV_OK);
    const auto straight = plant.run(50);
    ASSERT_EQ(hnav_aircraft_load(plant.handle, state.data(), bytes), HNAV_OK);
    EXPECT_EQ(plant.run(50).z, straight.z);
    Plant twin;
    ASSERT_EQ(hnav_aircraft_load(twin.handle, state.data(), bytes), HNAV_OK);
    EXPECT_EQ(twin.run(50).z, straight.z);
}

TEST(Aircraft, AStateThatDoesNotFitIsRefusedAndChangesNothing) {
    Plant plant, other(Model(), seeded(9));
    plant.run(10);
    std::size_t bytes = 0;
    hnav_aircraft_state_size(plant.handle, &bytes);
    std::vector<char> state(bytes);
    EXPECT_EQ(hnav_aircraft_save(plant.handle, state.data(), bytes - 1), HNAV_ERROR_SIZE);
    ASSERT_EQ(hnav_aircraft_save(plant.handle, state.data(), bytes), HNAV_OK);
    EXPECT_EQ(hnav_aircraft_load(other.handle, state.data(), bytes), HNAV_ERROR_STATE_CORRUPT);
    EXPECT_EQ(hnav_aircraft_load(plant.handle, state.data(), bytes - 8), HNAV_ERROR_SIZE);
    const auto before = other.run(5);
    state[bytes / 2] ^= 1;
    EXPECT_EQ(hnav_aircraft_load(plant.handle, state.data(), bytes), HNAV_ERROR_STATE_CORRUPT);
    hnav_aircraft_reset(other.handle);
    EXPECT_EQ(other.run(5).z, before.z);
}

TEST(Aircraft, ACommandThatIsNoNumberIsRefusedAndNothingMoves) {
    Plant plant;
    EXPECT_EQ(hnav_aircraft_step(plant.handle, &not_a_number), HNAV_ERROR_NON_FINITE);
    EXPECT_NE(std::string(hnav_aircraft_message(plant.handle)).find("command[0]"), std::string::npos);
    auto sample = hnav_sized<hnav_aircraft_sample>();
    hnav_aircraft_get_sample(plant.handle, &sample);
    EXPECT_EQ(sample.k, 0u);
}

TEST(Aircraft, EveryImpossibleEntryIsRefusedByName) {
    struct Case {
        const char* name;
        hnav_status status;
        std::function<void(hnav_aircraft_model&, hnav_aircraft_options&, Model&)> spoil;
    };
    const Case cases[] = {
        {"nx = 0", HNAV_ERROR_SIZE, [](auto& m, auto&, auto&) { m.nx = 0; }},
        {"nx = 33", HNAV_ERROR_SIZE, [](auto& m, auto&, auto&) { m.nx = 33; }},
        {"nu = -1", HNAV_ERROR_SIZE, [](auto& m, auto&, auto&) { m.nu = -1; }},
        {"interval_s", HNAV_ERROR_OPTION, [](auto& m, auto&, auto&) { m.interval_s = 0; }},
        {"interval_s", HNAV_ERROR_NON_FINITE, [](auto& m, auto&, auto&) { m.interval_s = not_a_number; }},
        {"A_1_s is null", HNAV_ERROR_NULL_ARGUMENT, [](auto& m, auto&, auto&) { m.A_1_s = nullptr; }},
        {"A_1_s[4]", HNAV_ERROR_NON_FINITE, [](auto&, auto&, auto& d) { d.A[4] = not_a_number; }},
        {"A_1_s is unstable", HNAV_ERROR_OPTION, [](auto&, auto&, auto& d) { d.A[8] = 0.1; }},
        {"B_1_s", HNAV_ERROR_NULL_ARGUMENT, [](auto& m, auto&, auto&) { m.B_1_s = nullptr; }},
        {"process_noise_per_sqrt_s[2]", HNAV_ERROR_OPTION, [](auto&, auto&, auto& d) { d.noise[2] = -1; }},
        {"measurement_sigma[0]", HNAV_ERROR_OPTION, [](auto&, auto&, auto& d) { d.v[0] = -1; }},
        {"start[1]", HNAV_ERROR_NON_FINITE, [](auto&, auto&, auto& d) { d.start[1] = not_a_number; }},
        {"start_sigma[1]", HNAV_ERROR_OPTION, [](auto&, auto&, auto& d) { d.start_sigma[1] = -0.1; }},
        {"accelerometer_error.sigma[0]", HNAV_ERROR_OPTION, [](auto&, auto&, auto& d) { d.sigma[0] = -1; }},
        {"accelerometer_error.time_constant_s[1]", HNAV_ERROR_OPTION, [](auto&, auto&, auto& d) { d.tau[1] = 0; }},
        {"accelerometer_error.time_constant_s", HNAV_ERROR_NULL_ARGUMENT,
         [](auto& m, auto&, auto&) { m.accelerometer_error.time_constant_s = nullptr; }},
        {"gravity_error.time_constant_s[0]", HNAV_ERROR_OPTION,
         [](auto& m, auto&, auto& d) {
             m.gravity_error.sigma = d.v.data();
             d.gravity_tau[0] = 0;
         }},
        {"accelerometer_error.time_constant_s[2]", HNAV_ERROR_OPTION,
         [](auto&, auto& o, auto& d) {
             o.euler_colour = 1;
             d.tau[2] = 0.05;
         }},
        {"commands.period_s[0]", HNAV_ERROR_OPTION, [](auto&, auto&, auto& d) { d.commands[0].period_s = 0; }},
        {"faults.factor[1]", HNAV_ERROR_OPTION, [](auto&, auto&, auto& d) { d.faults[1].factor = -1; }},
        {"euler_colour = 2", HNAV_ERROR_OPTION, [](auto&, auto& o, auto&) { o.euler_colour = 2; }},
        {"exact_process_noise = -1", HNAV_ERROR_OPTION, [](auto&, auto& o, auto&) { o.exact_process_noise = -1; }},
        {"hnav_aircraft_defaults", HNAV_ERROR_OPTIONS_STAMP, [](auto&, auto& o, auto&) { o.stamp = 0; }},
        {"beyond what numbers hold", HNAV_ERROR_OPTION,
         [](auto& m, auto&, auto& d) {
             d.A[0] = -1e300;
             m.interval_s = 1e10;
         }},
    };
    for (const Case& c : cases) {
        Model data;
        hnav_aircraft_model model = data.view();
        hnav_aircraft_options options = hnav_aircraft_defaults();
        c.spoil(model, options, data);
        hnav_aircraft* plant = reinterpret_cast<hnav_aircraft*>(1);
        char message[320] = "";
        EXPECT_EQ(hnav_aircraft_create(&plant, &options, &model, message, sizeof message), c.status) << c.name << ": " << message;
        EXPECT_EQ(plant, nullptr) << c.name;
        EXPECT_NE(std::string(message).find(c.name), std::string::npos) << c.name << ": " << message;
    }
}

TEST(Aircraft, NullArgumentsAreAnswered) {
    Plant plant;
    const hnav_aircraft_options options = hnav_aircraft_defaults();
    hnav_aircraft* made = nullptr;
    EXPECT_EQ(hnav_aircraft_create(nullptr, &options, nullptr, nullptr, 0), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_aircraft_create(&made, nullptr, nullptr, nullptr, 0), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_aircraft_create(&made, &options, nullptr, nullptr, 0), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_aircraft_reset(nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_aircraft_step(nullptr, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_aircraft_run(plant.handle, 1, nullptr, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_aircraft_get_sample(plant.handle, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_aircraft_filter_model(plant.handle, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_aircraft_state_size(plant.handle, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_aircraft_save(plant.handle, nullptr, 0), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_aircraft_load(plant.handle, nullptr, 0), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_STREQ(hnav_aircraft_message(nullptr), "aircraft is null");
    hnav_aircraft_destroy(nullptr);
}

} // namespace

// ------------------------------------------------------------------------------------------------ heap

#ifdef HNAV_HEAP_IS_COUNTED

namespace {

TEST(Aircraft, NothingIsAllocatedAfterCreate) {
    hnav_aircraft_options options = hnav_aircraft_defaults();
    options.exact_process_noise = 1;
    Plant plant(Model(), options);
    std::vector<double> z(3);
    auto sample = hnav_sized<hnav_aircraft_sample>();
    sample.z = z.data();
    heap::allocations = 0;
    heap::counting = true;
    for (int k = 0; k < 100; ++k) {
        hnav_aircraft_step(plant.handle, nullptr);
        hnav_aircraft_get_sample(plant.handle, &sample);
    }
    hnav_aircraft_reset(plant.handle);
    heap::counting = false;
    EXPECT_EQ(heap::allocations, 0);
}

} // namespace
#endif
