// The navigation filter under a caller's integrator: external and internal integration agree, and derivatives equal those by
// perturbation.
#include "hnav/hnav.h"
#include "laws.hpp"

#include <cmath>
#include <cstring>
#include <memory>
#include <utility>

namespace hnav {
namespace {

using test::perturbation_jacobian;
using test::Random;
using Numbers = Eigen::Matrix<double, 10, 1>; // displacement, velocity, quaternion
constexpr int shown_numbers = 13;
using Shown = Eigen::Matrix<double, shown_numbers, 1>;

constexpr double deg = M_PI / 180, interval_s = 0.01;

struct Destroy {
    void operator()(hnav_filter* ins) const { hnav_filter_destroy(ins); }
};
using Ins = std::unique_ptr<hnav_filter, Destroy>;

// Position, attitude and velocity are known.
Ins made(double latitude_rad, double longitude_rad, hnav_solver solver = HNAV_SOLVER_CLOSED_FORM) {
    hnav_ins_options options = hnav_ins_defaults(HNAV_INS_INDUSTRIAL);
    options.start = HNAV_INS_START_STATE;
    options.start_place = HNAV_INS_PLACE_GIVEN;
    options.start_latitude_rad = latitude_rad;
    options.start_longitude_rad = longitude_rad;
    options.start_height_m = 300;
    options.start_velocity_n_m_s[0] = 30;
    options.start_velocity_n_m_s[1] = 20;
    options.solver = solver;
    options.solver_rtol = 1e-10;
    options.solver_atol = 1e-10;
    hnav_filter* ins = nullptr;
    EXPECT_EQ(hnav_ins_create(&ins, &options, nullptr, 0), HNAV_OK);
    return Ins(ins);
}

// A sample at k times the interval; some have a fix between two samples, away from the estimated position.
void push(hnav_filter* ins, int k) {
    const double t = k * interval_s;
    const double rate[3] = {0.3 * std::sin(3 * t), -0.2 * std::cos(2 * t), 0.4},
                 sigma[3] = {2, 2, 3}; // the body does not keep it
    const double force[3] = {1 + std::sin(t), 0.5 * std::cos(4 * t), -9.8}, velocity[3] = {30, 20.5, 0.2};
    ASSERT_EQ(hnav_filter_push_imu(ins, t, rate, force), HNAV_OK);
    if (k % 20 == 19) {
        ASSERT_EQ(hnav_filter_push_velocity(ins, t + 0.4 * interval_s, velocity, sigma), HNAV_OK);
    }
}

Numbers derivative(hnav_filter* ins, const Numbers& x) {
    Numbers dx;
    EXPECT_EQ(hnav_filter_derivative(ins, 0, x.data(), dx.data()), HNAV_OK);
    return dx;
}

// The classical Runge-Kutta method of order 4.
Numbers flown(hnav_filter* ins, const Numbers& x, double h) {
    const Numbers a = derivative(ins, x), b = derivative(ins, x + h / 2 * a), c = derivative(ins, x + h / 2 * b),
                  d = derivative(ins, x + h * c);
    return x + h / 6 * (a + 2 * b + 2 * c + d);
}

// Integrates to t_s from *now_s, with jumps at the events between.
void go(hnav_filter* ins, double* now_s, double t_s, Numbers* x) {
    for (;;) {
        double event_s;
        ASSERT_EQ(hnav_filter_next_event_s(ins, &event_s), HNAV_OK);
        const double end_s = std::fmin(event_s, t_s);
        *x = flown(ins, *x, end_s - *now_s);
        *now_s = end_s;
        if (event_s > t_s) break;
        ASSERT_EQ(hnav_filter_jump(ins, event_s, x->data(), x->data()), HNAV_OK) << hnav_filter_message(ins);
    }
    ASSERT_EQ(hnav_filter_show(ins, t_s, x->data()), HNAV_OK);
}

Numbers state_of(hnav_filter* ins) {
    Numbers x;
    EXPECT_EQ(hnav_filter_get_x(ins, x.data()), HNAV_OK);
    return x;
}

hnav_navigation navigation(hnav_filter* ins) {
    auto n = hnav_sized<hnav_navigation>();
    EXPECT_EQ(hnav_ins_navigation(ins, &n), HNAV_OK);
    return n;
}

// After some time, between two events.
Ins under_way(double latitude_rad, double longitude_rad, Numbers* x) {
    Ins ins = made(latitude_rad, longitude_rad);
    *x = state_of(ins.get());
    double now_s = 0;
    for (int k = 0; k < 130; ++k) {
        push(ins.get(), k);
        go(ins.get(), &now_s, (k + 0.7) * interval_s, x);
    }
    return ins;
}

TEST(InsHybrid, AnIntegratorOutsideFindsTheSame) {
    // The closed form has an error of second order in the Earth's rotation.
    const std::pair<hnav_solver, double> inner[] = {{HNAV_SOLVER_ERKSTEP, 1e-10}, {HNAV_SOLVER_CLOSED_FORM, 1e-8}};
    for (const auto& [solver, close] : inner) {
        const Ins inside = made(0.8, 0.2, solver), outside = made(0.8, 0.2);
        Numbers x = state_of(outside.get());
        double now_s = 0;
        for (int k = 0; k < 1000; ++k) {
            const double end_s = (k + 0.7) * interval_s;
            push(inside.get(), k);
            push(outside.get(), k);
            ASSERT_EQ(hnav_filter_advance(inside.get(), end_s), HNAV_OK);
            go(outside.get(), &now_s, end_s, &x);
        }
        const hnav_navigation a = navigation(inside.get()), b = navigation(outside.get());
        EXPECT_EQ(a.phase, HNAV_INS_PHASE_NAVIGATING);
        EXPECT_EQ(a.t_s, b.t_s);
        EXPECT_NEAR(a.latitude_rad, b.latitude_rad, 1e-13);
        EXPECT_NEAR(a.longitude_rad, b.longitude_rad, 1e-13);
        EXPECT_NEAR(a.height_m, b.height_m, 1e-6);
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(a.velocity_n_m_s[i], b.velocity_n_m_s[i], close);
            EXPECT_NEAR(a.euler_rad[i], b.euler_rad[i], close);
            EXPECT_NEAR(a.gyro_bias_rad_s[i], b.gyro_bias_rad_s[i], close);
        }
        auto seen = hnav_sized<hnav_diagnostics>();
        ASSERT_EQ(hnav_filter_diagnostics(outside.get(), &seen), HNAV_OK);
        EXPECT_EQ(seen.used[HNAV_SENSOR_GYRO], 1000u);
        EXPECT_EQ(seen.used[HNAV_SENSOR_VELOCITY], 50u);
    }
}

TEST(InsHybrid, SigmasAndFlagsStayAsAtTheLastEvent) {
    Numbers x;
    const Ins ins = under_way(0.8, 0.2, &x);
    double before[225], after[225];
    const hnav_navigation now = navigation(ins.get());
    ASSERT_EQ(hnav_filter_covariance(ins.get(), before), HNAV_OK);
    x = flown(ins.get(), x, 0.5);
    ASSERT_EQ(hnav_filter_show(ins.get(), 1.8, x.data()), HNAV_OK);
    const hnav_navigation later = navigation(ins.get());
    ASSERT_EQ(hnav_filter_covariance(ins.get(), after), HNAV_OK);
    EXPECT_EQ(later.t_s, 1.8);
    EXPECT_GT(std::fabs(later.latitude_rad - now.latitude_rad), 1e-7);
    EXPECT_GT(std::fabs(later.euler_rad[2] - now.euler_rad[2]), 0.1);
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(later.sigma_position_m[i], now.sigma_position_m[i]);
        EXPECT_EQ(later.sigma_rotation_rad[i], now.sigma_rotation_rad[i]);
    }
    for (int i = 0; i < 225; ++i) EXPECT_EQ(after[i], before[i]);
    EXPECT_EQ(later.tilt_ready, now.tilt_ready);
}

TEST(InsHybrid, DerivativesOfTheFlowArePerturbations) {
    Numbers x;
    const Ins ins = under_way(0.8, 0.2, &x);
    Random random(4);
    Numbers at = x;
    at.head<3>() += random.vector(100);
    at.tail<4>() *= 1.02; // an integrator does not keep the length
    const auto flow = [&](const Numbers& from) { return derivative(ins.get(), from); };
    const auto expected = perturbation_jacobian<10, 10>(flow, at, 1e-3);
    for (int k = 0; k < 10; ++k) {
        const Numbers seed = Numbers::Unit(k);
        Numbers along;
        ASSERT_EQ(hnav_filter_derivative_along(ins.get(), 1.3, at.data(), seed.data(), along.data()), HNAV_OK);
        EXPECT_LT(test::distance(along, Numbers(expected.col(k))), 1e-10) << k;
    }
    EXPECT_GT(std::fabs(expected(5, 2)), 1e-6); // gravity falls off
}

Shown shown(const hnav_navigation& n) {
    Shown all;
    all << n.latitude_rad, n.longitude_rad, n.height_m, n.velocity_n_m_s[0], n.velocity_n_m_s[1], n.velocity_n_m_s[2], n.q_nb[0],
        n.q_nb[1], n.q_nb[2], n.q_nb[3], n.euler_rad[0], n.euler_rad[1], n.euler_rad[2];
    return all;
}

TEST(InsHybrid, DerivativesOfWhatIsShownArePerturbationsNearThePoleToo) {
    for (const double latitude : {0.8, 89.9 * deg, -89.9 * deg}) {
        Numbers x;
        const Ins ins = under_way(latitude, 3.1, &x);
        Numbers sizes;
        sizes << 1, 1, 1, 1, 1, 1, 1e-3, 1e-3, 1e-3, 1e-3;
        x.tail<4>() *= 0.97;
        const auto show = [&](const Numbers& steps) {
            const Numbers at = x + steps.cwiseProduct(sizes);
            EXPECT_EQ(hnav_filter_show(ins.get(), 1.3, at.data()), HNAV_OK);
            return shown(navigation(ins.get()));
        };
        const auto expected = perturbation_jacobian<shown_numbers, 10>(show, Numbers(Numbers::Zero()), 1.0);
        show(Numbers::Zero());
        for (int k = 0; k < 10; ++k) {
            const Numbers seed = sizes[k] * Numbers::Unit(k);
            auto along = hnav_sized<hnav_navigation_along>();
            ASSERT_EQ(hnav_ins_navigation_along(ins.get(), seed.data(), &along), HNAV_OK);
            Shown found;
            found << along.latitude_rad, along.longitude_rad, along.height_m, along.velocity_n_m_s[0], along.velocity_n_m_s[1],
                along.velocity_n_m_s[2], along.q_nb[0], along.q_nb[1], along.q_nb[2], along.q_nb[3], along.euler_rad[0],
                along.euler_rad[1], along.euler_rad[2];
            for (int i = 0; i < shown_numbers; ++i)
                EXPECT_NEAR(found[i], expected(i, k), 2e-6 * expected.row(i).cwiseAbs().maxCoeff() + 1e-9)
                    << latitude << " " << i;
        }
    }
}

TEST(InsHybrid, RefusesStatesThatAreNone) {
    const Ins ins = made(0.8, 0.2);
    Numbers x = state_of(ins.get()), out;
    int32_t nx = 0;
    EXPECT_EQ(hnav_filter_nx(ins.get(), &nx), HNAV_OK);
    EXPECT_EQ(nx, 10);
    EXPECT_EQ(hnav_filter_nominal_x(ins.get(), out.data()), HNAV_OK);
    EXPECT_EQ(out, Numbers(Numbers::Ones()));
    EXPECT_EQ(derivative(ins.get(), x), Numbers(Numbers::Zero())); // nothing flows before the start
    auto along = hnav_sized<hnav_navigation_along>();
    EXPECT_EQ(hnav_ins_navigation_along(ins.get(), x.data(), &along), HNAV_OK);
    EXPECT_EQ(along.q_nb[0], 0);
    x[3] = std::nan("");
    EXPECT_EQ(hnav_filter_show(ins.get(), 0, x.data()), HNAV_ERROR_NON_FINITE);
    EXPECT_NE(std::strstr(hnav_filter_message(ins.get()), "x[3]"), nullptr);
    x[3] = 1e60;
    EXPECT_EQ(hnav_filter_jump(ins.get(), 0, x.data(), out.data()), HNAV_ERROR_OUT_OF_RANGE);
    x = Numbers::Zero();
    EXPECT_EQ(hnav_filter_jump(ins.get(), 0, x.data(), out.data()), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_filter_show(ins.get(), std::nan(""), state_of(ins.get()).data()), HNAV_ERROR_NON_FINITE);
    EXPECT_EQ(hnav_filter_derivative(ins.get(), std::nan(""), state_of(ins.get()).data(), out.data()), HNAV_ERROR_NON_FINITE);
    EXPECT_EQ(hnav_filter_derivative(nullptr, 0, x.data(), out.data()), HNAV_ERROR_NULL_ARGUMENT);
}

} // namespace
} // namespace hnav
