// The C API: laws of the samples, every status, save and load, and the heap.
#include "hnav/hnav.h"

#include "counted_heap.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace {

constexpr double deg = M_PI / 180;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Vec {
    double v[3];
};

struct Row {
    double t_s;
    Vec rate, force, field;
};

// Owns a filter; calls that a test does not expect to fail must succeed.
class Handle {
public:
    explicit Handle(const hnav_hrekf_options& options) {
        char message[256];
        EXPECT_EQ(hnav_hrekf_create(&filter_, &options, message, sizeof message), HNAV_OK) << message;
    }
    Handle(const Handle&) = delete;
    ~Handle() { hnav_filter_destroy(filter_); }
    operator hnav_filter*() const { return filter_; }

    void push(const Row& row) {
        EXPECT_EQ(hnav_filter_push_imu(filter_, row.t_s, row.rate.v, row.force.v), HNAV_OK) << hnav_filter_message(filter_);
        EXPECT_EQ(hnav_filter_push_mag(filter_, row.t_s, row.field.v), HNAV_OK) << hnav_filter_message(filter_);
    }
    void advance(double t_s) { EXPECT_EQ(hnav_filter_advance(filter_, t_s), HNAV_OK) << hnav_filter_message(filter_); }

    hnav_posterior posterior() const {
        hnav_posterior p;
        std::memset(&p, 0, sizeof p);
        p.size = sizeof p;
        EXPECT_EQ(hnav_filter_posterior(filter_, &p), HNAV_OK);
        return p;
    }
    hnav_diagnostics diagnostics() const {
        auto s = hnav_sized<hnav_diagnostics>();
        EXPECT_EQ(hnav_filter_diagnostics(filter_, &s), HNAV_OK);
        return s;
    }

private:
    hnav_filter* filter_ = nullptr;
};

bool same_bits(const hnav_posterior& a, const hnav_posterior& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

hnav_hrekf_options defaults() { return hnav_hrekf_defaults(HNAV_PRESET_DEFAULT); }

void multiply(const double* a, const double* b, double* out) {
    const double r[4] = {
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
    std::memcpy(out, r, sizeof r);
}

Vec to_body(const double* q, Vec n) {
    const double p[4] = {0, n.v[0], n.v[1], n.v[2]}, c[4] = {q[0], -q[1], -q[2], -q[3]};
    double r[4];
    multiply(c, p, r);
    multiply(r, q, r);
    return {{r[1], r[2], r[3]}};
}

// A body tilted by 20 degrees that turns about changing axes at up to 10 rad/s, with gyro bias and noise; the rate of a row
// is the mean over the interval that follows it. truth (may be null): q of every row.
std::vector<Row> tilted_motion(double duration_s, Vec bias, double noise, std::vector<std::array<double, 4>>* truth = nullptr) {
    std::mt19937_64 engine(7);
    std::normal_distribution<double> normal;
    std::vector<Row> rows;
    double q[4] = {std::cos(10 * deg), std::sin(10 * deg), 0, 0};
    const double T = 0.01;
    for (int k = 0; k * T < duration_s; ++k) {
        const double t = k * T;
        const double w[3] = {4 * std::sin(1.1 * t), 5 * std::cos(0.7 * t), 7.5 * std::sin(0.4 * t)};
        Row row{t, {}, to_body(q, {{0, 0, -9.81}}), to_body(q, {{2e-5, 0, 4.5e-5}})};
        for (int i = 0; i < 3; ++i) {
            row.rate.v[i] = w[i] + bias.v[i] + noise * 0.01 * normal(engine);
            row.force.v[i] += noise * 0.05 * normal(engine);
            row.field.v[i] += noise * 2e-7 * normal(engine);
        }
        rows.push_back(row);
        if (truth) truth->push_back({q[0], q[1], q[2], q[3]});
        const double angle = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) * T;
        const double s = angle > 0 ? std::sin(0.5 * angle) / angle * T : 0.5 * T;
        const double turn[4] = {std::cos(0.5 * angle), s * w[0], s * w[1], s * w[2]};
        multiply(q, turn, q);
    }
    return rows;
}

hnav_posterior run_straight(const hnav_hrekf_options& options, const std::vector<Row>& rows) {
    Handle f(options);
    for (const Row& row : rows) {
        f.push(row);
        f.advance(row.t_s);
    }
    return f.posterior();
}

double total_error(const double* q, const std::array<double, 4>& truth) {
    double dot = 0;
    for (int i = 0; i < 4; ++i) dot += q[i] * truth[i];
    return 2 * std::acos(std::fmin(1, std::fabs(dot)));
}

hnav_hrekf_options precise() {
    hnav_hrekf_options o = defaults();
    o.gyro_noise_rad_per_sqrt_s = 1e-3;
    o.gyro_bias_walk_rad_s_per_sqrt_s = 1e-4;
    o.accel_noise_per_sqrt_hz = 5e-4;
    o.mag_noise_per_sqrt_hz = 5e-4;
    o.start_sigma_bias_rad_s = 0.05;
    o.accel_gate_nis = o.mag_gate_nis = 13.9;
    o.start_samples = 1; // started by the first row
    return o;
}

} // namespace

// ------------------------------------------------------------------------------------------------ truth

TEST(Hrekf, FindsTheBiasOfATiltedTumblingBody) {
    const Vec bias = {{0.03, -0.05, 0.02}};
    std::vector<std::array<double, 4>> truth;
    const auto rows = tilted_motion(30, bias, 1, &truth);
    for (const hnav_gamma_mode mode : {HNAV_GAMMA_OFF, HNAV_GAMMA_FIXED, HNAV_GAMMA_RELATIVE, HNAV_GAMMA_KL}) {
        hnav_hrekf_options o = precise();
        o.gamma_mode = mode;
        o.gamma_relative_rate_1_s = 0.1; // gentle: a robust filter pays in noise
        o.gamma_kl_rate_1_s = 0.05;
        const hnav_posterior p = run_straight(o, rows);
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(p.gyro_bias_rad_s[i], bias.v[i], 0.1 * deg) << "gamma mode " << mode;
        EXPECT_LT(total_error(p.q_nb, truth.back()), 0.5 * deg) << "gamma mode " << mode;
    }
}

TEST(Hrekf, EveryIntegratorGivesTheSameEstimate) {
    const auto rows = tilted_motion(3, {{0.03, -0.05, 0.02}}, 1);
    hnav_hrekf_options o = precise();
    o.solver = HNAV_SOLVER_CLOSED_FORM;
    const hnav_posterior exact = run_straight(o, rows);
    for (const auto& [solver, tolerance] :
         {std::pair<hnav_solver, double>{HNAV_SOLVER_ERKSTEP, 1e-7}, {HNAV_SOLVER_ADAMS, 1e-5}, {HNAV_SOLVER_EULER, 1e-3}}) {
        o.solver = solver;
        o.euler_step_s = 1e-4;
        const hnav_posterior p = run_straight(o, rows);
        for (int i = 0; i < 4; ++i) EXPECT_NEAR(p.q_nb[i], exact.q_nb[i], tolerance) << "solver " << solver;
    }
}

TEST(Hrekf, GammaOfInfiniteSizeIsTheHekf) {
    const auto rows = tilted_motion(3, {{0, 0, 0}}, 1);
    hnav_hrekf_options o = precise();
    const hnav_posterior hekf = run_straight(o, rows);
    o.gamma_mode = HNAV_GAMMA_FIXED;
    o.gamma = 1e12;
    const hnav_posterior hrekf = run_straight(o, rows);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(hekf.q_nb[i], hrekf.q_nb[i], 1e-12);
}

TEST(Hrekf, ThePaperPresetKeepsACovarianceThroughItsEulerSteps) {
    const auto rows = tilted_motion(5, {{0, 0, 0}}, 1);
    Handle f(hnav_hrekf_defaults(HNAV_PRESET_PAPER));
    for (const Row& row : rows) {
        f.push(row);
        f.advance(row.t_s);
    }
    EXPECT_EQ(f.diagnostics().covariance_repaired, 0u);
    EXPECT_GT(f.diagnostics().solver_steps, 900u);
    EXPECT_EQ(f.diagnostics().gamma_raised, 0u);
    EXPECT_LT(f.diagnostics().gamma_used, infinity);
    EXPECT_GT(f.diagnostics().gamma_margin, 0.9);
}

TEST(Hrekf, AdaptationRaisesABiasWalkThatIsTooSmall) {
    auto rows = tilted_motion(40, {{0, 0, 0}}, 1);
    for (Row& row : rows) row.rate.v[0] += 0.1 * std::sin(0.5 * row.t_s); // a bias that wanders much faster than stated
    hnav_hrekf_options o = precise();
    o.gyro_bias_walk_rad_s_per_sqrt_s = 1e-5;
    o.adaptation_min_rad_s_per_sqrt_s = 1e-6;
    o.adaptation = HNAV_ADAPTATION_CORRECTED;
    Handle f(o);
    for (const Row& row : rows) {
        f.push(row);
        f.advance(row.t_s);
    }
    EXPECT_GT(f.diagnostics().adapted_bias_walk_rad_s_per_sqrt_s, 1e-3);
}

TEST(Hrekf, AHeadingAidReplacesTheMagnetometer) {
    std::vector<std::array<double, 4>> truth;
    const auto rows = tilted_motion(20, {{0.01, 0.01, -0.02}}, 1, &truth);
    Handle f(precise());
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const auto& q = truth[k];
        EXPECT_EQ(hnav_filter_push_imu(f, rows[k].t_s, rows[k].rate.v, rows[k].force.v), HNAV_OK);
        if (k % 10 == 0) {
            const double yaw = std::atan2(2 * (q[0] * q[3] + q[1] * q[2]), 1 - 2 * (q[2] * q[2] + q[3] * q[3]));
            EXPECT_EQ(hnav_filter_push_heading(f, rows[k].t_s, yaw, 1 * deg), HNAV_OK);
        }
        f.advance(rows[k].t_s);
    }
    auto a = hnav_sized<hnav_attitude>();
    ASSERT_EQ(hnav_filter_attitude(f, &a), HNAV_OK);
    EXPECT_LT(total_error(a.q_nb, truth.back()), 2 * deg);
    EXPECT_TRUE(a.heading_ready);
    EXPECT_GT(f.diagnostics().used[HNAV_SENSOR_HEADING], 100u);
}

TEST(Hrekf, WithoutAMagnetometerTheHeadingSigmaGrows) {
    const auto rows = tilted_motion(20, {{0, 0, 0}}, 1);
    hnav_hrekf_options o = defaults();
    o.start_mode = HNAV_START_HEADING;
    o.ready_tilt_rad = 3 * deg;
    Handle f(o);
    double early = 0;
    for (const Row& row : rows) {
        EXPECT_EQ(hnav_filter_push_imu(f, row.t_s, row.rate.v, row.force.v), HNAV_OK);
        f.advance(row.t_s);
        if (row.t_s == 1.0) early = f.posterior().sigma[2];
    }
    EXPECT_GT(f.posterior().sigma[2], early);
    auto a = hnav_sized<hnav_attitude>();
    ASSERT_EQ(hnav_filter_attitude(f, &a), HNAV_OK);
    EXPECT_TRUE(a.tilt_ready);
    EXPECT_FALSE(a.heading_ready);
}

// ------------------------------------------------------------------------------------------------ frames

TEST(Frames, ALevelBodyAtRestHasNoRollPitchAndTheHeadingOfItsField) {
    for (const double heading : {-170.0, -45.0, 0.0, 30.0, 90.0}) {
        hnav_hrekf_options o = defaults();
        o.start_samples = 1;
        Handle f(o);
        const double c = std::cos(heading * deg), s = std::sin(heading * deg);
        const Row row{0, {{0, 0, 0}}, {{0, 0, -9.81}}, {{2e-5 * c, -2e-5 * s, 4.5e-5}}};
        f.push(row);
        f.advance(0);
        auto a = hnav_sized<hnav_attitude>();
        ASSERT_EQ(hnav_filter_attitude(f, &a), HNAV_OK);
        EXPECT_NEAR(a.euler_rad[0], 0, 1e-12);
        EXPECT_NEAR(a.euler_rad[1], 0, 1e-12);
        EXPECT_NEAR(a.euler_rad[2], heading * deg, 1e-12);
        EXPECT_NEAR(a.heading_rad, heading * deg, 1e-12);
    }
}

TEST(Frames, EastNorthUpAndDeclinationTurnTheOutputsOnly) {
    const auto rows = tilted_motion(5, {{0.01, 0, 0}}, 1);
    hnav_hrekf_options o = precise();
    Handle ned(o);
    o.navigation_frame = HNAV_FRAME_ENU;
    o.declination_rad = 0.1;
    Handle enu(o);
    for (const Row& row : rows)
        for (Handle* f : {&ned, &enu}) {
            f->push(row);
            f->advance(row.t_s);
        }
    auto a = hnav_sized<hnav_attitude>(), b = a;
    ASSERT_EQ(hnav_filter_attitude(ned, &a), HNAV_OK);
    ASSERT_EQ(hnav_filter_attitude(enu, &b), HNAV_OK);
    EXPECT_NEAR(std::remainder(b.heading_rad - a.heading_rad - 0.1, 2 * M_PI), 0, 1e-12);
    // Body axes in the navigation frame: east = y of north-east-down turned by the declination, up = -down.
    const double x[3] = {1, 0, 0};
    const double qa[4] = {a.q_nb[0], -a.q_nb[1], -a.q_nb[2], -a.q_nb[3]}, qb[4] = {b.q_nb[0], -b.q_nb[1], -b.q_nb[2], -b.q_nb[3]};
    const Vec na = to_body(qa, {{x[0], x[1], x[2]}}), nb = to_body(qb, {{x[0], x[1], x[2]}});
    EXPECT_NEAR(nb.v[2], -na.v[2], 1e-12);
    EXPECT_NEAR(nb.v[1], std::cos(0.1) * na.v[0] - std::sin(0.1) * na.v[1], 1e-12);
    EXPECT_NEAR(nb.v[0], std::sin(0.1) * na.v[0] + std::cos(0.1) * na.v[1], 1e-12);
    double C[36], D[36];
    ASSERT_EQ(hnav_filter_covariance(ned, C), HNAV_OK);
    ASSERT_EQ(hnav_filter_covariance(enu, D), HNAV_OK);
    EXPECT_NEAR(D[14], C[14], 1e-15); // heading variance
    EXPECT_NEAR(D[0] + D[7], C[0] + C[7], 1e-15);
    EXPECT_NEAR(std::sqrt(D[14]), b.sigma_rad[2], 1e-15);
}

TEST(Frames, AMountedSensorGivesTheAttitudeOfTheBody) {
    const auto rows = tilted_motion(2, {{0, 0, 0}}, 1);
    const double mounting[4] = {std::sqrt(0.5), 0, 0, std::sqrt(0.5)}; // sensor turned by 90 deg about z
    hnav_hrekf_options o = precise();
    const hnav_posterior plain = run_straight(o, rows);
    std::memcpy(o.q_body_sensor, mounting, sizeof mounting);
    std::vector<Row> turned = rows;
    for (Row& row : turned)
        for (Vec* v : {&row.rate, &row.force, &row.field}) *v = to_body(mounting, *v);
    const hnav_posterior mounted = run_straight(o, turned);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(mounted.q_nb[i], plain.q_nb[i], 1e-9);
}

// ------------------------------------------------------------------------------------------------ laws of the samples

TEST(Law, TheSameSamplesGiveTheSameBitsForEveryAdvancePattern) {
    const auto rows = tilted_motion(3, {{0.01, 0.02, 0.03}}, 1);
    for (const hnav_solver solver : {HNAV_SOLVER_ERKSTEP, HNAV_SOLVER_ADAMS, HNAV_SOLVER_CLOSED_FORM, HNAV_SOLVER_EULER}) {
        hnav_hrekf_options o = precise();
        o.solver = solver;
        o.gamma_mode = HNAV_GAMMA_KL;
        o.adaptation = HNAV_ADAPTATION_CORRECTED;
        o.queue_capacity = 400;
        const hnav_posterior reference = run_straight(o, rows);
        std::mt19937_64 engine(3);
        for (const double step : {0.01, 0.0037, 0.0173, 1.0, -1.0}) { // -1: random
            Handle f(o);
            std::size_t next = 0;
            for (double t = 0; t < 3;) {
                t = std::fmin(3, t + (step > 0 ? step : std::uniform_real_distribution<double>(1e-4, 0.1)(engine)));
                while (next < rows.size() && rows[next].t_s <= t) f.push(rows[next++]);
                f.advance(t);
            }
            EXPECT_TRUE(same_bits(f.posterior(), reference)) << "solver " << solver << ", step " << step;
        }
    }
}

TEST(Law, TheDecayRateIsZeroBeforeACorrectionAndTheSameBitsForEveryAdvancePattern) {
    const auto rows = tilted_motion(3, {{0.01, 0.02, 0.03}}, 1);
    const auto rate_after = [&rows](double step) {
        hnav_hrekf_options o = precise();
        o.queue_capacity = 400;
        Handle f(o);
        EXPECT_EQ(f.diagnostics().decay_rate_1_s, 0);
        std::size_t next = 0;
        for (double t = 0; t < 3;) {
            t = std::fmin(3, t + step);
            while (next < rows.size() && rows[next].t_s <= t) f.push(rows[next++]);
            f.advance(t);
        }
        const double rate = f.diagnostics().decay_rate_1_s;
        EXPECT_EQ(hnav_filter_realign(f), HNAV_OK);
        EXPECT_EQ(f.diagnostics().decay_rate_1_s, 0);
        return rate;
    };
    const double reference = rate_after(0.01);
    EXPECT_GT(reference, 0);
    for (const double step : {0.0037, 0.0173, 1.0}) EXPECT_EQ(rate_after(step), reference) << "step " << step;
}

TEST(Law, TheOrderWithinAnInstantDoesNotMatter) {
    const auto rows = tilted_motion(1, {{0, 0, 0}}, 1);
    const hnav_posterior reference = run_straight(precise(), rows);
    Handle f(precise());
    for (const Row& row : rows) {
        ASSERT_EQ(hnav_filter_push_mag(f, row.t_s, row.field.v), HNAV_OK);
        f.advance(row.t_s);
        ASSERT_EQ(hnav_filter_push_imu(f, row.t_s, row.rate.v, row.force.v), HNAV_OK);
    }
    f.advance(rows.back().t_s);
    EXPECT_TRUE(same_bits(f.posterior(), reference));
}

TEST(Law, ABatchRunIsPushAndAdvanceRowByRow) {
    const auto rows = tilted_motion(2, {{0, 0, 0}}, 1);
    std::vector<double> t, rate, force, field, q(4 * rows.size()), nis(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
        t.push_back(rows[k].t_s);
        for (int i = 0; i < 3; ++i) {
            rate.push_back(rows[k].rate.v[i]);
            force.push_back(rows[k].force.v[i]);
            field.push_back(k % 3 == 0 ? rows[k].field.v[i] : not_a_number);
        }
    }
    Handle batch(precise()), single(precise());
    const hnav_run_input input{sizeof(hnav_run_input), t.data(), rate.data(), force.data(), field.data(), nullptr, nullptr};
    auto output = hnav_sized<hnav_run_output>();
    output.q_nb = q.data();
    output.mag_nis = nis.data();
    size_t done;
    ASSERT_EQ(hnav_filter_run(batch, rows.size(), &input, &output, &done), HNAV_OK) << hnav_filter_message(batch);
    EXPECT_EQ(done, rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
        ASSERT_EQ(hnav_filter_push_imu(single, rows[k].t_s, rows[k].rate.v, rows[k].force.v), HNAV_OK);
        if (k % 3 == 0) {
            ASSERT_EQ(hnav_filter_push_mag(single, rows[k].t_s, rows[k].field.v), HNAV_OK);
        }
        single.advance(rows[k].t_s);
        auto a = hnav_sized<hnav_attitude>();
        ASSERT_EQ(hnav_filter_attitude(single, &a), HNAV_OK);
        EXPECT_EQ(std::memcmp(a.q_nb, &q[4 * k], sizeof a.q_nb), 0) << "row " << k;
        EXPECT_EQ(std::isnan(nis[k]), k % 3 != 0 || k == 0);
    }
    EXPECT_TRUE(same_bits(batch.posterior(), single.posterior()));
    EXPECT_EQ(batch.diagnostics().non_finite, 0u);
}

TEST(Law, ResetGivesBackTheMomentAfterCreate) {
    const auto rows = tilted_motion(1, {{0, 0, 0}}, 1);
    Handle f(precise());
    hnav_posterior runs[2];
    for (hnav_posterior& p : runs) {
        for (const Row& row : rows) {
            f.push(row);
            f.advance(row.t_s);
        }
        p = f.posterior();
        ASSERT_EQ(hnav_filter_reset(f), HNAV_OK);
        EXPECT_EQ(f.diagnostics().corrections, 0u);
        EXPECT_EQ(f.diagnostics().solver_rhs_evals, 0u);
        auto none = hnav_sized<hnav_posterior>();
        EXPECT_EQ(hnav_filter_posterior(f, &none), HNAV_ERROR_NOT_STARTED);
    }
    EXPECT_TRUE(same_bits(runs[0], runs[1]));
}

TEST(Law, RealignForgetsTheAttitudeAndKeepsTheBias) {
    std::vector<std::array<double, 4>> truth;
    const auto rows = tilted_motion(20, {{0.03, 0, 0}}, 1, &truth);
    Handle f(precise());
    for (std::size_t k = 0; k < rows.size(); ++k) {
        f.push(rows[k]);
        f.advance(rows[k].t_s);
        if (k == 1500) {
            ASSERT_EQ(hnav_filter_realign(f), HNAV_OK);
            auto a = hnav_sized<hnav_attitude>();
            EXPECT_EQ(hnav_filter_attitude(f, &a), HNAV_ERROR_NOT_STARTED);
        }
        if (k == 1502) {
            EXPECT_NEAR(f.posterior().gyro_bias_rad_s[0], 0.03, 0.2 * deg);
        }
    }
    EXPECT_LT(total_error(f.posterior().q_nb, truth.back()), 0.5 * deg);
}

// Two samples that share each stamp are spread over the time since the previous stamp: each has half of it.
TEST(Law, SamplesThatShareAStampShareItsInformation) {
    const auto rows = tilted_motion(1, {{0, 0, 0}}, 1);
    Handle once(precise()), twice(precise());
    for (const Row& row : rows) {
        once.push(row);
        twice.push(row);
        twice.push(row);
        once.advance(row.t_s);
        twice.advance(row.t_s);
    }
    const hnav_posterior a = once.posterior(), b = twice.posterior();
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(b.sigma[i] / a.sigma[i], 1, 0.01);
    EXPECT_EQ(twice.diagnostics().used[HNAV_SENSOR_ACCEL], 2 * rows.size());
}

// ------------------------------------------------------------------------------------------------ save and load

TEST(SaveLoad, SaveWreckLoadGoOnIsBitEqual) {
    const auto rows = tilted_motion(4, {{0.01, 0, 0}}, 1);
    for (const double horizon_s : {0.0, 0.05}) {
        hnav_hrekf_options o = precise();
        o.horizon_s = horizon_s;
        o.gamma_mode = HNAV_GAMMA_RELATIVE;
        const hnav_posterior reference = run_straight(o, rows);
        Handle f(o);
        size_t bytes;
        ASSERT_EQ(hnav_filter_state_size(f, &bytes), HNAV_OK);
        std::vector<unsigned char> saved(bytes);
        for (std::size_t k = 0; k < rows.size(); ++k) {
            f.push(rows[k]);
            if (k == 200) {
                f.advance(rows[k].t_s + 0.004);
                ASSERT_EQ(hnav_filter_save(f, saved.data(), bytes), HNAV_OK);
                Row wreck = rows[k + 1];
                wreck.force = {{1, 1, 1}};
                f.push(wreck);
                f.advance(rows[k].t_s + 3);
                ASSERT_EQ(hnav_filter_load(f, saved.data(), bytes), HNAV_OK);
            } else f.advance(rows[k].t_s + 0.004);
        }
        EXPECT_TRUE(same_bits(f.posterior(), reference));
    }
}

TEST(SaveLoad, DamageOtherOptionsAndWrongSizesAreRefused) {
    Handle f(precise());
    f.push(tilted_motion(0.01, {{0, 0, 0}}, 0)[0]);
    f.advance(0);
    size_t bytes;
    ASSERT_EQ(hnav_filter_state_size(f, &bytes), HNAV_OK);
    std::vector<unsigned char> saved(bytes);
    EXPECT_EQ(hnav_filter_save(f, saved.data(), bytes - 1), HNAV_ERROR_SIZE);
    ASSERT_EQ(hnav_filter_save(f, saved.data(), bytes), HNAV_OK);
    EXPECT_EQ(hnav_filter_load(f, saved.data(), bytes - 1), HNAV_ERROR_SIZE);
    const hnav_posterior before = f.posterior();
    for (std::size_t i = 0; i < bytes; i += 97) {
        saved[i] ^= 1;
        EXPECT_EQ(hnav_filter_load(f, saved.data(), bytes), HNAV_ERROR_STATE_CORRUPT) << "byte " << i;
        saved[i] ^= 1;
    }
    EXPECT_TRUE(same_bits(f.posterior(), before));
    hnav_hrekf_options other = precise();
    other.mag_gate_nis = 20;
    Handle g(other);
    EXPECT_EQ(hnav_filter_load(g, saved.data(), bytes), HNAV_ERROR_STATE_CORRUPT);
}

TEST(SaveLoad, SignsThatChangeInTwoNumbersAreFound) {
    Handle f(precise());
    f.push(tilted_motion(0.01, {{0, 0, 0}}, 0)[0]);
    f.advance(0);
    size_t bytes;
    ASSERT_EQ(hnav_filter_state_size(f, &bytes), HNAV_OK);
    std::vector<unsigned char> saved(bytes);
    ASSERT_EQ(hnav_filter_save(f, saved.data(), bytes), HNAV_OK);
    for (std::size_t i = 31; i < 400; i += 8)
        for (std::size_t j = i + 8; j < 400; j += 8) {
            saved[i] ^= 0x80;
            saved[j] ^= 0x80;
            ASSERT_EQ(hnav_filter_load(f, saved.data(), bytes), HNAV_ERROR_STATE_CORRUPT) << "bytes " << i << " and " << j;
            saved[i] ^= 0x80;
            saved[j] ^= 0x80;
        }
    EXPECT_EQ(hnav_filter_load(f, saved.data(), bytes), HNAV_OK);
}

TEST(SaveLoad, ALoadedStateSavesTheSameBytes) {
    Handle f(precise());
    for (const Row& row : tilted_motion(0.3, {{0, 0, 0}}, 0)) {
        f.push(row);
        f.advance(row.t_s);
    }
    size_t bytes;
    ASSERT_EQ(hnav_filter_state_size(f, &bytes), HNAV_OK);
    std::vector<unsigned char> saved(bytes), again(bytes);
    ASSERT_EQ(hnav_filter_save(f, saved.data(), bytes), HNAV_OK);
    ASSERT_EQ(hnav_filter_load(f, saved.data(), bytes), HNAV_OK);
    ASSERT_EQ(hnav_filter_save(f, again.data(), bytes), HNAV_OK);
    EXPECT_EQ(saved, again);
}

// ------------------------------------------------------------------------------------------------ names

TEST(Names, TheVersionOfTheHeadersIsThatOfTheLibrary) {
    EXPECT_STREQ(HNAV_VERSION, hnav_version());
    const std::string numbers =
        std::to_string(HNAV_VERSION_MAJOR) + "." + std::to_string(HNAV_VERSION_MINOR) + "." + std::to_string(HNAV_VERSION_PATCH);
    EXPECT_EQ(numbers, HNAV_VERSION);
}

TEST(Names, EveryStatusHasATextOfItsOwn) {
    std::set<std::string> texts;
    for (int status = HNAV_OK; status <= HNAV_ERROR_STATE_VERSION; ++status)
        texts.insert(hnav_status_text(static_cast<hnav_status>(status)));
    EXPECT_EQ(texts.size(), HNAV_ERROR_STATE_VERSION + 1u);
    EXPECT_EQ(texts.count("unknown status"), 0u);
    for (const int none : {-1, HNAV_ERROR_STATE_VERSION + 1})
        EXPECT_STREQ(hnav_status_text(static_cast<hnav_status>(none)), "unknown status");
}

// ------------------------------------------------------------------------------------------------ bad input

TEST(BadInput, EverySampleThatIsNoSampleIsRefusedAndChangesNothing) {
    const auto rows = tilted_motion(1, {{0, 0, 0}}, 1);
    Handle f(precise());
    for (const Row& row : rows) {
        f.push(row);
        f.advance(row.t_s);
    }
    const hnav_posterior before = f.posterior();
    const double t = rows.back().t_s, zero[3] = {0, 0, 0}, bad[3] = {0, not_a_number, 0}, huge[3] = {1e300, 0, 0};
    const double endless[3] = {infinity, 0, 0}, fine[3] = {0.1, 0, -9.8}, too_fast[3] = {0, 0, 1.1e4};
    const auto refused = [&](hnav_status status, hnav_status expected, const char* word) {
        EXPECT_EQ(status, expected);
        EXPECT_NE(std::string(hnav_filter_message(f)).find(word), std::string::npos) << hnav_filter_message(f);
        EXPECT_NE(std::string(hnav_status_text(status)), "unknown status");
    };
    refused(hnav_filter_push_gyro(f, t, bad), HNAV_ERROR_NON_FINITE, "gyro");
    refused(hnav_filter_push_accel(f, t, endless), HNAV_ERROR_NON_FINITE, "accel");
    refused(hnav_filter_push_mag(f, not_a_number, fine), HNAV_ERROR_NON_FINITE, "mag");
    refused(hnav_filter_push_accel(f, t, zero), HNAV_ERROR_ZERO_VECTOR, "accel");
    refused(hnav_filter_push_mag(f, t, zero), HNAV_ERROR_ZERO_VECTOR, "mag");
    refused(hnav_filter_push_gyro(f, t, huge), HNAV_ERROR_OUT_OF_RANGE, "gyro");
    refused(hnav_filter_push_gyro(f, t, too_fast), HNAV_ERROR_OUT_OF_RANGE, "beyond 10000");
    refused(hnav_filter_push_accel(f, t - 0.5, fine), HNAV_ERROR_LATE_SAMPLE, "late");
    refused(hnav_filter_push_heading(f, t, not_a_number, 0.1), HNAV_ERROR_NON_FINITE, "heading");
    refused(hnav_filter_push_heading(f, t, 0.1, 0), HNAV_ERROR_OUT_OF_RANGE, "sigma_rad");
    refused(hnav_filter_push_imu(f, t, fine, zero), HNAV_ERROR_ZERO_VECTOR, "accel");
    refused(hnav_filter_push_gyro(f, t, nullptr), HNAV_ERROR_NULL_ARGUMENT, "rate_b_rad_s");
    refused(hnav_filter_advance(f, t - 0.1), HNAV_ERROR_TIME_BACKWARDS, "before");
    refused(hnav_filter_advance(f, infinity), HNAV_ERROR_NON_FINITE, "t_s");
    auto innovation = hnav_sized<hnav_innovation>();
    refused(hnav_filter_innovation(f, HNAV_SENSOR_GYRO, &innovation), HNAV_ERROR_OUT_OF_RANGE, "sensor");
    refused(hnav_filter_innovation(f, HNAV_SENSOR_HEADING, &innovation), HNAV_ERROR_NO_DATA, "heading");
    f.advance(t);
    EXPECT_TRUE(same_bits(f.posterior(), before));
    EXPECT_EQ(f.diagnostics().non_finite, 7u);
    EXPECT_EQ(f.diagnostics().zero, 3u);
    EXPECT_EQ(f.diagnostics().late, 1u);
    // The filter continues.
    Row next = rows.back();
    next.t_s += 0.01;
    f.push(next);
    f.advance(next.t_s);
    EXPECT_FALSE(same_bits(f.posterior(), before));
}

TEST(BadInput, AFullQueueSaysSoAndLosesNothing) {
    hnav_hrekf_options o = precise();
    o.queue_capacity = 4;
    Handle f(o);
    const double up[3] = {0, 0, -9.81};
    for (int k = 0; k < 4; ++k) ASSERT_EQ(hnav_filter_push_accel(f, k, up), HNAV_OK);
    EXPECT_EQ(hnav_filter_push_accel(f, 4, up), HNAV_ERROR_QUEUE_FULL);
    EXPECT_EQ(f.diagnostics().waiting, 4);
    f.advance(3);
    EXPECT_EQ(hnav_filter_push_accel(f, 4, up), HNAV_OK);
    f.advance(4);
    EXPECT_EQ(f.diagnostics().used[HNAV_SENSOR_ACCEL], 5u);
}

// A sample that was refused for want of room leaves no trace: pushed again it is the first of its instant.
TEST(BadInput, ASampleThatIsPushedAgainAfterAFullQueueKeepsItsInstant) {
    int refused = 0;
    const auto posterior = [&refused](std::int32_t capacity) {
        hnav_hrekf_options o = precise();
        o.queue_capacity = capacity;
        Handle f(o);
        const double rate[3] = {0.1, 0.02, -0.3}, field[3] = {2e-5, 0, 4e-5};
        for (int k = 0; k < 80; ++k) {
            const double t_s = 0.01 * k, force[3] = {0.1 * std::sin(k), 0, -9.81};
            const auto push = [&] { return hnav_filter_push_gyro(f, t_s, rate); };
            if (push() != HNAV_OK) {
                ++refused;
                f.advance(t_s - 0.01);
                EXPECT_EQ(push(), HNAV_OK);
            }
            EXPECT_EQ(hnav_filter_push_accel(f, t_s, force), HNAV_OK);
            EXPECT_EQ(hnav_filter_push_mag(f, t_s, field), HNAV_OK);
        }
        f.advance(0.79);
        return f.posterior();
    };
    const auto roomy = posterior(100);
    EXPECT_EQ(refused, 0);
    EXPECT_TRUE(same_bits(posterior(4), roomy));
    EXPECT_GT(refused, 10);
}

TEST(BadInput, AClockThatStandsStillDoesNotFillTheQueueForGood) {
    hnav_hrekf_options o = precise();
    o.queue_capacity = 6;
    Handle f(o);
    const double up[3] = {0, 0, -9.81};
    for (int k = 0; k < 50; ++k) {
        ASSERT_EQ(hnav_filter_push_accel(f, 0, up), HNAV_OK) << "sample " << k << " of the same instant";
        f.advance(0);
    }
    EXPECT_EQ(hnav_filter_push_imu(f, 0.01, up, up), HNAV_OK);
    f.advance(0.01);
    EXPECT_EQ(f.diagnostics().used[HNAV_SENSOR_ACCEL], 51u);
}

TEST(BadInput, AHorizonThatHoldsMoreThanTheQueueLetsGoOfTheOldest) {
    hnav_hrekf_options o = precise();
    o.queue_capacity = 6;
    o.horizon_s = 10;
    Handle f(o);
    const double up[3] = {0, 0, -9.81};
    for (int k = 0; k < 50; ++k) {
        ASSERT_EQ(hnav_filter_push_imu(f, 0.01 * k, up, up), HNAV_OK) << "sample " << k;
        f.advance(0.01 * k);
    }
    EXPECT_EQ(hnav_filter_push_accel(f, 0.475, up), HNAV_OK); // open events accept late samples
    EXPECT_EQ(hnav_filter_push_accel(f, 0.1, up), HNAV_ERROR_LATE_SAMPLE);
}

TEST(BadInput, AGapThatNoIntegratorCanFollowIsCrossedByTheClosedForm) {
    for (int solver : {HNAV_SOLVER_ERKSTEP, HNAV_SOLVER_ADAMS, HNAV_SOLVER_EULER}) {
        hnav_hrekf_options o = precise();
        o.solver = HNAV_SOLVER_CLOSED_FORM;
        o.time_jump_limit_s = 0; // otherwise the first stamp after the gap would be omitted
        Handle exact(o);
        o.solver = solver;
        Handle f(o);
        const double spin[3] = {1000, 0, 0}, up[3] = {0, 0, -9.81}, field[3] = {2e-5, 0, 4e-5};
        for (hnav_filter* filter : {static_cast<hnav_filter*>(exact), static_cast<hnav_filter*>(f)})
            for (double t_s : {0.0, 1e5, 1e5 + 0.01}) {
                const double still[3] = {0, 0, 0};
                ASSERT_EQ(hnav_filter_push_imu(filter, t_s, t_s > 0 ? still : spin, up), HNAV_OK);
                ASSERT_EQ(hnav_filter_push_mag(filter, t_s, field), HNAV_OK);
                ASSERT_EQ(hnav_filter_advance(filter, t_s), HNAV_OK) << hnav_filter_message(filter);
            }
        EXPECT_EQ(f.diagnostics().used[HNAV_SENSOR_ACCEL], 3u) << "solver " << solver;
        for (int i = 0; i < 4; ++i) EXPECT_NEAR(f.posterior().q_nb[i], exact.posterior().q_nb[i], 1e-6) << "solver " << solver;
    }
}

TEST(BadInput, TimesAndStatesThatWouldOverflowAreRefused) {
    Handle f(precise());
    f.push(tilted_motion(0.01, {{0, 0, 0}}, 0)[0]);
    f.advance(0);
    const double up[3] = {0, 0, -9.81};
    EXPECT_EQ(hnav_filter_push_accel(f, 1e300, up), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_filter_push_heading(f, -1e13, 0, 1), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_filter_advance(f, 1e300), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(f.diagnostics().non_finite, 2u);
    double x[64], out[64];
    ASSERT_EQ(hnav_filter_get_x(f, x), HNAV_OK);
    EXPECT_EQ(hnav_filter_show(f, 1e300, x), HNAV_ERROR_OUT_OF_RANGE);
    x[8] = 1e200;
    EXPECT_EQ(hnav_filter_show(f, 0, x), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_filter_jump(f, 0, x, out), HNAV_ERROR_OUT_OF_RANGE);
    ASSERT_EQ(hnav_filter_get_x(f, x), HNAV_OK);
    x[0] = x[1] = x[2] = x[3] = 0;
    EXPECT_EQ(hnav_filter_show(f, 0, x), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_NE(std::string(hnav_filter_message(f)).find("no attitude"), std::string::npos);
    f.advance(1e11);
}

TEST(BadInput, NullObjectsAreAnswered) {
    double v[36] = {};
    EXPECT_EQ(hnav_filter_advance(nullptr, 0), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_filter_push_gyro(nullptr, 0, v), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_filter_reset(nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_filter_covariance(nullptr, v), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_STREQ(hnav_filter_message(nullptr), "filter is null");
    hnav_filter_destroy(nullptr);
}

TEST(BadInput, EveryOptionOutsideItsRangeIsRefusedByName) {
    hnav_filter* f;
    char message[256];
    for (int32_t k = 0; const hnav_option_info* row = hnav_option("hrekf", k); ++k) {
        std::vector<double> impossible = {row->max * (row->max > 0 ? 1.01 : 0.99) + 1, row->min - 1};
        if (row->kind == HNAV_OPTION_REAL) impossible.push_back(not_a_number);
        if (row->min_is_open) impossible.push_back(row->min);
        for (const double value : impossible) {
            hnav_hrekf_options o = defaults();
            char* field = reinterpret_cast<char*>(&o) + row->offset;
            if (row->kind == HNAV_OPTION_REAL) {
                std::memcpy(field + 8 * (row->count - 1), &value, 8);
            } else {
                const auto integer = static_cast<int32_t>(value);
                std::memcpy(field, &integer, 4);
            }
            EXPECT_EQ(hnav_hrekf_create(&f, &o, message, sizeof message), HNAV_ERROR_OPTION) << row->name << " = " << value;
            EXPECT_EQ(f, nullptr);
            EXPECT_NE(std::string(message).find(row->name), std::string::npos) << message;
        }
    }
}

TEST(BadInput, CreateRefusesWhatNoDefaultsCallHasStamped) {
    hnav_filter* f;
    char message[256];
    hnav_hrekf_options o{};
    EXPECT_EQ(hnav_hrekf_create(&f, &o, message, sizeof message), HNAV_ERROR_OPTIONS_STAMP);
    o = hnav_hrekf_defaults(static_cast<hnav_preset>(99));
    EXPECT_EQ(hnav_hrekf_create(&f, &o, nullptr, 0), HNAV_ERROR_OPTIONS_STAMP);
    EXPECT_EQ(hnav_hrekf_create(nullptr, &o, message, sizeof message), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_hrekf_create(&f, nullptr, message, sizeof message), HNAV_ERROR_NULL_ARGUMENT);
    o = defaults();
    for (double& c : o.start_q_nb) c = 0; // the paper's x0 = 0 is no quaternion
    EXPECT_EQ(hnav_hrekf_create(&f, &o, message, sizeof message), HNAV_ERROR_OPTION);
    EXPECT_NE(std::string(message).find("start_q_nb"), std::string::npos);
}

TEST(BadInput, ARunStopsAtTheRowThatIsWrongAndNamesIt) {
    Handle f(defaults());
    const double t[3] = {0, 1, 0.5}, force[9] = {0, 0, -9.81, 0, 0, -9.81, 0, 0, -9.81};
    const hnav_run_input input{sizeof(hnav_run_input), t, nullptr, force, nullptr, nullptr, nullptr};
    const auto output = hnav_sized<hnav_run_output>();
    size_t done;
    EXPECT_EQ(hnav_filter_run(f, 3, &input, &output, &done), HNAV_ERROR_LATE_SAMPLE);
    EXPECT_EQ(done, 2u);
    EXPECT_NE(std::string(hnav_filter_message(f)).find("row 2"), std::string::npos) << hnav_filter_message(f);
}

// ------------------------------------------------------------------------------------------------ hybrid view

TEST(HybridView, AnIntegratorOutsideReachesTheSameEstimate) {
    const auto rows = tilted_motion(1, {{0.02, 0, 0}}, 1);
    hnav_hrekf_options o = precise();
    const hnav_posterior reference = run_straight(o, rows);
    Handle f(o);
    int32_t nx;
    ASSERT_EQ(hnav_filter_nx(f, &nx), HNAV_OK);
    ASSERT_EQ(nx, 14);
    std::vector<double> x(nx), k1(nx), mid(nx), nominal(nx);
    ASSERT_EQ(hnav_filter_get_x(f, x.data()), HNAV_OK);
    double t = 0;
    for (const Row& row : rows) {
        for (int s = 0; s < 20 && row.t_s > t; ++s) { // midpoint steps
            const double h = (row.t_s - t) / (20 - s);
            ASSERT_EQ(hnav_filter_derivative(f, t, x.data(), k1.data()), HNAV_OK);
            for (int i = 0; i < nx; ++i) mid[i] = x[i] + 0.5 * h * k1[i];
            ASSERT_EQ(hnav_filter_derivative(f, t + 0.5 * h, mid.data(), k1.data()), HNAV_OK);
            for (int i = 0; i < nx; ++i) x[i] += h * k1[i];
            t += h;
        }
        f.push(row);
        double next;
        ASSERT_EQ(hnav_filter_next_event_s(f, &next), HNAV_OK);
        EXPECT_EQ(next, row.t_s);
        ASSERT_EQ(hnav_filter_jump(f, row.t_s, x.data(), x.data()), HNAV_OK);
        t = row.t_s;
    }
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(f.posterior().q_nb[i], reference.q_nb[i], 1e-6);
    ASSERT_EQ(hnav_filter_nominal_x(f, nominal.data()), HNAV_OK);
    for (const double n : nominal) EXPECT_GT(n, 0);
}

TEST(HybridView, RefusesTheBackwardHold) {
    hnav_hrekf_options o = precise();
    o.gyro_hold = HNAV_GYRO_HOLD_BACKWARD;
    Handle f(o);
    double x[14] = {1};
    EXPECT_EQ(hnav_filter_jump(f, 0, x, x), HNAV_ERROR_OPTION);
    x[3] = not_a_number;
    EXPECT_EQ(hnav_filter_jump(f, 0, x, x), HNAV_ERROR_NON_FINITE);
}

// ------------------------------------------------------------------------------------------------ gaps

namespace {

template <class Options>
void crosses_gaps_at_the_cost_of_short_ones(hnav_status (*create)(hnav_filter**, const Options*, char*, size_t),
                                            Options options) {
    const auto rows = tilted_motion(2, {{0.01, 0, 0}}, 1);
    for (const int32_t solver : {HNAV_SOLVER_ERKSTEP, HNAV_SOLVER_ADAMS, HNAV_SOLVER_EULER}) {
        options.solver = solver;
        hnav_filter* filter = nullptr;
        ASSERT_EQ(create(&filter, &options, nullptr, 0), HNAV_OK);
        for (const Row& row : rows) {
            ASSERT_EQ(hnav_filter_push_imu(filter, row.t_s, row.rate.v, row.force.v), HNAV_OK);
            ASSERT_EQ(hnav_filter_push_mag(filter, row.t_s, row.field.v), HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(filter, row.t_s), HNAV_OK);
        }
        const double t_s = rows.back().t_s;
        const auto evaluations = [&] {
            auto s = hnav_sized<hnav_diagnostics>();
            EXPECT_EQ(hnav_filter_diagnostics(filter, &s), HNAV_OK);
            return s.solver_rhs_evals;
        };
        const auto before = evaluations();
        ASSERT_EQ(hnav_filter_advance(filter, t_s + 0.9), HNAV_OK);
        const auto short_one = evaluations() - before;
        EXPECT_GT(short_one, 0u);
        for (const double gap_s : {1e1, 1e4, 1e5}) ASSERT_EQ(hnav_filter_advance(filter, t_s + gap_s), HNAV_OK); // looked ahead
        EXPECT_EQ(evaluations() - before, short_one) << "solver " << solver;
        ASSERT_EQ(hnav_filter_push_imu(filter, t_s + 1e5, rows[0].rate.v, rows[0].force.v), HNAV_OK); // and what is committed
        ASSERT_EQ(hnav_filter_advance(filter, t_s + 1e5), HNAV_OK);
        EXPECT_EQ(evaluations() - before, short_one) << "solver " << solver;
        const double beyond_sense[3] = {1e4, -1e4, 0};
        ASSERT_EQ(hnav_filter_push_gyro(filter, t_s + 1e5 + 1, beyond_sense), HNAV_OK);
        ASSERT_EQ(hnav_filter_push_gyro(filter, t_s + 1e5 + 1.1, rows[0].rate.v), HNAV_OK);
        ASSERT_EQ(hnav_filter_advance(filter, t_s + 1e5 + 1.1), HNAV_OK);
        EXPECT_LT(evaluations() - before, 100000u) << "solver " << solver;
        hnav_filter_destroy(filter);
    }
}

} // namespace

TEST(Gaps, CostTheAhrsWhatAShortOneDoes) {
    crosses_gaps_at_the_cost_of_short_ones(hnav_ahrs_create, hnav_ahrs_defaults(HNAV_PRESET_DEFAULT));
}

TEST(Gaps, CostTheHrekfWhatAShortOneDoes) { crosses_gaps_at_the_cost_of_short_ones(hnav_hrekf_create, defaults()); }

// ------------------------------------------------------------------------------------------------ heap

#ifdef HNAV_HEAP_IS_COUNTED

TEST(Heap, NothingIsAllocatedAfterCreate) {
    const auto rows = tilted_motion(2, {{0.01, 0, 0}}, 1);
    for (const hnav_solver solver : {HNAV_SOLVER_ERKSTEP, HNAV_SOLVER_ADAMS, HNAV_SOLVER_CLOSED_FORM, HNAV_SOLVER_EULER})
        for (const hnav_gamma_mode mode : {HNAV_GAMMA_OFF, HNAV_GAMMA_FIXED, HNAV_GAMMA_RELATIVE, HNAV_GAMMA_KL}) {
            hnav_hrekf_options o = precise();
            o.solver = solver;
            o.gamma_mode = mode;
            o.adaptation = HNAV_ADAPTATION_CORRECTED;
            o.horizon_s = 0.05;
            Handle f(o);
            size_t bytes;
            ASSERT_EQ(hnav_filter_state_size(f, &bytes), HNAV_OK);
            std::vector<unsigned char> saved(bytes);
            auto attitude = hnav_sized<hnav_attitude>();
            hnav_status worst = HNAV_OK;
            const auto check = [&worst](hnav_status status) { worst = worst == HNAV_OK ? status : worst; };
            heap::allocations = 0;
            heap::counting = true;
            for (const Row& row : rows) {
                check(hnav_filter_push_imu(f, row.t_s, row.rate.v, row.force.v));
                check(hnav_filter_push_mag(f, row.t_s, row.field.v));
                check(hnav_filter_advance(f, row.t_s + 0.003));
                check(hnav_filter_attitude(f, &attitude));
            }
            check(hnav_filter_save(f, saved.data(), bytes));
            check(hnav_filter_load(f, saved.data(), bytes));
            check(hnav_filter_reset(f));
            heap::counting = false;
            EXPECT_EQ(worst, HNAV_OK) << hnav_filter_message(f);
            EXPECT_EQ(heap::allocations, 0) << "solver " << solver << ", gamma mode " << mode;
        }
}
#endif

// Equal bit for bit to a filter from the heap; the library must not destroy it.
TEST(CallersMemory, HoldsAFilterOfTheClosedForm) {
    hnav_ahrs_options o = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    std::vector<unsigned char> memory(hnav_ahrs_memory_bytes(&o));
    hnav_filter *here, *heaped;
    char message[256];
    EXPECT_EQ(hnav_ahrs_create_in(memory.data(), memory.size(), &here, &o, message, sizeof message), HNAV_ERROR_UNSUPPORTED);
    EXPECT_NE(std::string(message).find("closed_form"), std::string::npos) << message;
    o.solver = HNAV_SOLVER_CLOSED_FORM;
    EXPECT_EQ(hnav_ahrs_create_in(memory.data(), memory.size() - 1, &here, &o, message, sizeof message), HNAV_ERROR_SIZE);
    EXPECT_EQ(here, nullptr);
    ASSERT_EQ(hnav_ahrs_create_in(memory.data(), memory.size(), &here, &o, message, sizeof message), HNAV_OK) << message;
    ASSERT_EQ(hnav_ahrs_create(&heaped, &o, message, sizeof message), HNAV_OK) << message;
    auto a = hnav_sized<hnav_attitude>(), b = a;
    for (const Row& row : tilted_motion(2, {{0.01, 0, 0}}, 1)) {
        for (hnav_filter* f : {here, heaped}) {
            ASSERT_EQ(hnav_filter_push_imu(f, row.t_s, row.rate.v, row.force.v), HNAV_OK);
            ASSERT_EQ(hnav_filter_push_mag(f, row.t_s, row.field.v), HNAV_OK);
            ASSERT_EQ(hnav_filter_advance(f, row.t_s + 0.003), HNAV_OK);
        }
        EXPECT_EQ(hnav_filter_attitude(here, &a), hnav_filter_attitude(heaped, &b));
        EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
    }
    hnav_filter_destroy(here);
    hnav_filter_destroy(heaped);
    o.gyro_noise_rad_per_sqrt_s = -1;
    EXPECT_EQ(hnav_ahrs_memory_bytes(&o), 0u);
}
