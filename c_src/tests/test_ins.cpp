// The navigation filter: its mechanisation against exact solutions, its covariance against perturbation, the heading on the
// circle, and the laws of every hybrid filter.
#include "hnav/hnav.h"
#include "ins.hpp"
#include "ins/circle.hpp"

#include <vector>

namespace hnav {
namespace {

using namespace test;

// Free inertial over `duration_s`: the final distance from the truth.
double free_run_error(const Truth& truth, double duration_s, double* heading_error = nullptr) {
    const ins::Model model(usual());
    ins::State s = started_at(model, truth, 0);
    const int n = static_cast<int>(std::lround(duration_s / truth.interval_s));
    for (int k = 1; k <= n; ++k) {
        const ins::Event e = truth.at(k * truth.interval_s);
        model.before_flow(s, e);
        model.flow_exactly(s, truth.interval_s);
        model.jump(s, e);
    }
    const ins::Navigation end = model.navigation(s, 0, n * truth.interval_s);
    if (heading_error) *heading_error = wrap_angle(roll_pitch_yaw(end.q_nb)[2] - truth.heading(n * truth.interval_s));
    return (end.position_e - truth.position_e(n * truth.interval_s)).norm();
}

// ------------------------------------------------------------------------------------------------ the Earth

TEST(Earth, PlaceAndPositionAreInverse) {
    for (const double latitude : {-90.0, -45.0, 0.0, 33.0, 89.9999, 90.0})
        for (const double height : {-100.0, 0.0, 12000.0}) {
            const earth::Place p{latitude * deg, 170 * deg, height};
            const earth::Place back = earth::place_of(earth::position_of(p));
            EXPECT_NEAR(back.latitude_rad, p.latitude_rad, 1e-12);
            EXPECT_NEAR(back.height_m, height, 1e-5);
            EXPECT_LT((earth::position_of(back) - earth::position_of(p)).norm(), 1e-5);
        }
}

TEST(Earth, GravityIsThatOfTheStandard) {
    EXPECT_NEAR(earth::gravity_m_s2(0, 0), 9.7803253359, 1e-10);
    EXPECT_NEAR(earth::gravity_m_s2(1, 0), 9.8321849379, 1e-9);
    EXPECT_NEAR(earth::gravity_m_s2(std::sin(45 * deg), 1000), 9.8061977694 - 3.0855e-3, 2e-6);
}

TEST(Earth, PressureIsThatOfTheStandardAtmosphere) {
    EXPECT_NEAR(earth::pressure_height_m(101325), 0, 1e-9);
    EXPECT_NEAR(earth::pressure_height_m(89874.6), 1000, 0.5);
}

// ------------------------------------------------------------------------------------------------ mechanisation

TEST(InsMechanisation, ABodyAtRestOnTheTurningEarthStays) {
    for (const double latitude : {0.0, 50.0, 90.0}) {
        const Vector3 p = earth::position_of({latitude * deg, 20 * deg, 100});
        const Quaternion q = Quaternion(0.7, 0.1, -0.2, 0.6).normalized();
        Truth rest{[=](double) { return p; }, [=](double) { return q; }};
        EXPECT_LT(free_run_error(rest, 60), 2e-5);
    }
}

TEST(InsMechanisation, AGreatCircleAcrossPoleAndDateLineIsFollowed) {
    struct Way {
        double latitude, longitude, course;
    };
    for (const Way way : {Way{0, 0, 30}, Way{89.98, 40, 0}, Way{10, 179.99, 90}}) {
        // A circle about the centre of the Earth at constant speed, and a constant attitude in Earth-fixed axes.
        const earth::Place start{way.latitude * deg, way.longitude * deg, 1000};
        const Vector3 p0 = earth::position_of(start);
        const Vector3 out = p0.normalized(),
                      along0 = earth::axes_at(start) * Vector3(std::cos(way.course * deg), std::sin(way.course * deg), 0);
        const Vector3 along = (along0 - out * out.dot(along0)).normalized();
        const double radius = p0.norm(), speed = 200;
        Truth flight{[=](double t) {
                         const double angle = speed * t / radius;
                         return Vector3(radius * (std::cos(angle) * out + std::sin(angle) * along));
                     },
                     [](double) { return Quaternion(1, 0, 0, 0); }};
        EXPECT_LT(free_run_error(flight, 120), 5e-3) << way.latitude;
    }
}

// Samples that are means over their intervals: of a coning motion of 10 Hz and 1 deg the axes drift by less than 0.01 deg/h.
TEST(InsMechanisation, ConingAt200HzDriftsLessThanAHundredthOfADegreeInAnHour) {
    const double rate = 2 * M_PI * 10, half = deg, T = 0.005;
    const Vector3 p = earth::position_of({0.5, 0.3, 0});
    const auto q_at = [=](double t) { return rotation_quaternion(half * Vector3(std::cos(rate * t), std::sin(rate * t), 0)); };
    // The sample is the mean of the rate, by quadrature, not the rotation divided by time.
    const auto rate_at = [&](double t) {
        const double h = 1e-5;
        return Vector3(rotation_vector(multiply(conjugate(q_at(t - h)), q_at(t + h))) / (2 * h));
    };
    const ins::Model model(usual());
    Truth still{[=](double) { return p; }, q_at, T};
    ins::State s = started_at(model, still, 0);
    ins::vec(s.earth_rate).setZero();
    Vector3 after_start = Vector3::Zero();
    const int n = 4000, settled = 20 * 20;
    for (int k = 1; k <= n; ++k) {
        Vector3 sum = Vector3::Zero();
        const int parts = 16;
        for (int i = 0; i <= parts; ++i) {
            const double weight = i == 0 || i == parts ? 1 : i % 2 ? 4 : 2;
            sum += weight * rate_at((k - 1 + double(i) / parts) * T);
        }
        const Vector3 w = sum / (3 * parts);
        ins::Event e{};
        e.t_s = k * T;
        e.add({k * T, imu, {w[0], w[1], w[2], 0, 0, -9.8}});
        model.before_flow(s, e);
        model.flow_exactly(s, T);
        s.last_s[imu] = s.last_event_s = k * T;
        const Matrix3 N = ins::mat(s.axes);
        const Quaternion truth = multiply(quaternion_from_matrix(N.transpose()), q_at(k * T));
        const Vector3 off = rotation_vector(multiply(ins::quat(s.x + 6), conjugate(truth)));
        if (k == settled) after_start = off;
        if (k == n) {
            EXPECT_LT((off - after_start).norm() / deg * 3600 / ((n - settled) * T), 0.01);
        }
    }
}

TEST(InsMechanisation, TheClosedFormIsTheIntegralOfTheFlow) {
    const ins::Model model(usual());
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    for (const double fastest_rad_s : {0.5, 20.0}) {
        test::Random random(3);
        ins::State s = started_at(model, truth, 0);
        for (int i = 0; i < 3; ++i) {
            s.held.rate[i] = random.normal(fastest_rad_s);
            s.held.force[i] = random.normal(5);
        }
        ins::State exact = s;
        model.flow_exactly(exact, 0.02);
        double x[ins::nx], k1[ins::nx], k2[ins::nx], k3[ins::nx], k4[ins::nx], y[ins::nx];
        std::copy(s.x, s.x + ins::nx, x);
        const int n = 200;
        const double h = 0.02 / n;
        for (int step = 0; step < n; ++step) {
            const auto probe = [&](const double* k, double share) {
                for (int i = 0; i < ins::nx; ++i) y[i] = x[i] + share * h * k[i];
            };
            model.flow(s, x, k1);
            probe(k1, 0.5);
            model.flow(s, y, k2);
            probe(k2, 0.5);
            model.flow(s, y, k3);
            probe(k3, 1);
            model.flow(s, y, k4);
            for (int i = 0; i < ins::nx; ++i) x[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
        }
        for (int i = 0; i < ins::nx; ++i) EXPECT_NEAR(exact.x[i], x[i], 1e-8) << i;
    }
}

// ------------------------------------------------------------------------------------------------ covariance

// The transition of a window against differences of two whole flows, for every error state that propagates.
TEST(InsCovariance, TheTransitionIsTheDerivativeOfTheFlow) {
    constexpr double variance = 1e-4; // of the one error: small, or the force that it puts into t would be taken for the motion
    ins::Options options = usual();
    options.gyro_noise_rad_per_sqrt_s = options.accel_noise_m_s_per_sqrt_s = 1e-9;
    const ins::Model model(options);
    const Truth truth = winding({0.8, 0.2, 100}, 1, 80);
    const auto flown = [&](int row, double by) {
        ins::State s = started_at(model, truth, 0);
        if (row < ins::row_v) s.x[row] += by;
        else if (row < ins::row_phi) s.x[row] += by;
        else if (row < ins::row_gyro) {
            Vector3 turn = Vector3::Zero();
            turn[row - ins::row_phi] = by;
            ins::quat(s.x + 6) = multiply(rotation_quaternion(turn), ins::quat(s.x + 6));
        } else if (row < ins::row_accel) s.gyro_bias[row - ins::row_gyro] += by;
        else if (row >= ins::row_axes) s.gyro_axes[row - ins::row_axes] += by;
        else s.accel_bias[row - ins::row_accel] += by;
        ins::quat(s.seen_q) = ins::quat(s.x + 6);
        for (double& p : s.P) p = 0;
        for (int i = 0; i < ins::row_u; ++i) s.P[ins::packed(i, i)] = i == row ? variance : 0;
        flow_uncorrected(model, truth, s);
        return s;
    };
    const ins::State base = flown(0, 0);
    for (int row = 0; row < ins::row_u; ++row) {
        const double step = row < ins::row_v ? 10 : 1e-4;
        const ins::State moved = flown(row, step);
        Eigen::Matrix<double, 9, 1> slope;
        slope << (ins::vec(moved.x) - ins::vec(base.x)) / step, (ins::vec(moved.x + 3) - ins::vec(base.x + 3)) / step,
            rotation_vector(multiply(ins::quat(moved.x + 6), conjugate(ins::quat(base.x + 6)))) / step;
        const ins::Covariance P = model.covariance_at(moved, 0);
        // With one error the covariance is the square of its column; noise adds to it. Axes rotate; what the rotation does to v and d follows in the
        // next window, and here it is less than by the whole rotation from the begin on.
        const bool rotates_only = row >= ins::row_axes;
        if (rotates_only) EXPECT_LT(slope.head<6>().norm(), 0.1 * 9.9 * slope.tail<3>().norm() + 1e-6) << row;
        for (int i = rotates_only ? 6 : 0; i < 9; ++i)
            for (int j = rotates_only ? 6 : 0; j < i; ++j)
                EXPECT_NEAR(P[i][j] / variance, slope[i] * slope[j],
                            1e-2 * std::fabs(slope[i] * slope[j]) + 2e-5 * slope.squaredNorm() + 1e-7)
                    << row << " " << i << " " << j;
    }
}

// ------------------------------------------------------------------------------------------------ the circle

TEST(InsCircle, KnowingNothingIsKnownAsNothing) {
    const double m[2] = {0, 0}, S[2][2] = {{0.5, 0}, {0, 0.5}};
    EXPECT_NEAR(ins::heading_on_circle(m, S, {}).spread_rad, M_PI / std::sqrt(3.0), 1e-3);
}

TEST(InsCircle, ANarrowOneHasTheSigmaOfItsTangent) {
    for (const double alpha : {-3.1, -0.4, 0.0, 2.0}) {
        const double m[2] = {std::cos(alpha), std::sin(alpha)}, S[2][2] = {{1e-4, 0}, {0, 1e-4}};
        const ins::Circle c = ins::heading_on_circle(m, S, {});
        EXPECT_NEAR(c.spread_rad, 0.01, 1e-5);
        EXPECT_NEAR(wrap_angle(c.mode_rad - alpha), 0, 1e-9);
    }
}

TEST(InsCircle, AnAxisWithoutASignHasTwoModes) {
    const double m[2] = {0, 0}, S[2][2] = {{1, 0}, {0, 1e-4}};
    const ins::Circle c = ins::heading_on_circle(m, S, {});
    EXPECT_NEAR(c.second_share, 0.5, 0.02);
    EXPECT_NEAR(std::fabs(wrap_angle(c.second_rad - c.mode_rad)), M_PI, 1e-6);
    EXPECT_GT(c.spread_rad, 1);
}

TEST(InsCircle, AHeadingFromElsewhereIsBelievedAloneAndNotAgainstMotion) {
    const double nothing[2] = {0, 0}, any[2][2] = {{0.5, 0}, {0, 0.5}};
    const ins::Circle alone = ins::heading_on_circle(nothing, any, {3.0, 1 / (0.05 * 0.05)});
    EXPECT_NEAR(alone.mode_rad, 3.0, 1e-3);
    // Its own variance, and one share in ten thousand that is uniform on the circle.
    EXPECT_NEAR(alone.spread_rad, std::hypot(0.05, M_PI / std::sqrt(3.0) * 1e-2), 5e-4);
    const double m[2] = {1, 0}, S[2][2] = {{0.04, 0}, {0, 0.04}};
    const ins::Circle against = ins::heading_on_circle(m, S, {3.0, 1 / (0.05 * 0.05)});
    EXPECT_NEAR(against.mode_rad, 0.0, 1e-3);
    EXPECT_LT(against.second_share, 1e-6);
    const ins::Circle with = ins::heading_on_circle(m, S, {0.1, 1 / (0.05 * 0.05)});
    EXPECT_NEAR(with.mode_rad, 0.1 * 400 / 425, 2e-3);
    EXPECT_NEAR(with.spread_rad, 1 / std::sqrt(425.0), 2e-3);
}

// ------------------------------------------------------------------------------------------------ any heading

TEST(InsAnyHeading, IsFoundFromEveryStartOnEveryPartOfTheEarth) {
    const earth::Place places[] = {{0.1, 0.2, 0}, {-0.9, M_PI - 1e-6, 500}, {89.99 * deg, 1, 0}};
    for (const earth::Place& place : places)
        for (int k = 0; k < 3; ++k) {
            const Truth truth = winding(place, -3 + 2 * k);
            Flight run(usual());
            for (int i = 1; i <= 4000; ++i) {
                feed(run, truth, i);
                ASSERT_EQ(run.filter.advance(0.01 * i), Outcome::ok);
            }
            const ins::Navigation n = run.shown();
            EXPECT_EQ(run.filter.shown().phase, Phase::navigating);
            // In Earth-fixed axes, because north is ill-defined at a pole.
            const Quaternion q_eb = multiply(quaternion_from_matrix(earth::axes_at(n.place)), n.q_nb);
            EXPECT_LT(rotation_vector(multiply(q_eb, conjugate(truth.q_eb(40)))).norm(), 1 * deg)
                << place.latitude_rad << " " << k;
            EXPECT_LT((n.position_e - truth.position_e(40)).norm(), 1.0);
            EXPECT_TRUE(n.heading_ready);
        }
}

TEST(InsAnyHeading, WrongAxesOfAGyroscopeAreFound) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    ins::Options s = usual();
    s.start_sigma_gyro_scale = s.start_sigma_gyro_misalignment_rad = 0.02;
    Flight run(s);
    drive(run, truth, 60, [](ins::Sample& sample) {
        if (sample.channel != imu) return;
        sample.value[0] += 0.005 * sample.value[2];
        sample.value[2] *= 1.01;
    });
    const ins::State& now = run.filter.shown();
    const auto expect_found = [&now](int entry, double wrong) {
        const int row = ins::row_axes + entry;
        EXPECT_NEAR(now.gyro_axes[entry], wrong, std::fmin(3e-3, 3 * std::sqrt(now.P[ins::packed(row, row)])));
    };
    expect_found(2, 0.005); // of x, towards z
    expect_found(8, 0.01); // of z
    EXPECT_LT(std::fabs(wrap_angle(roll_pitch_yaw(run.shown().q_nb)[2] - truth.heading(60))), 0.3 * deg);
}

TEST(InsAnyHeading, AFirstFixThatLiesFarOffIsForgotten) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    // The fix at the end of the window, where the filter starts, and one in the middle.
    for (const double far_off_s : {3.4, 9.0}) {
        Flight run(usual());
        drive(run, truth, 60, [&](ins::Sample& sample) {
            if (sample.channel == imu || std::fabs(sample.t_s - far_off_s) > 1e-6) return;
            for (int i = 0; i < 3; ++i) sample.value[i] += sample.channel == velocity ? 2.8 : i < 2 ? -8e-6 : -12;
        });
        const ins::Navigation n = run.shown();
        EXPECT_TRUE(n.heading_ready) << far_off_s;
        EXPECT_LT(std::fabs(wrap_angle(roll_pitch_yaw(n.q_nb)[2] - truth.heading(60))), 0.5 * deg) << far_off_s;
        EXPECT_LT((n.position_e - truth.position_e(60)).norm(), 3.0);
    }
}

struct Misses {
    double attitude, velocity, position, ahead; // displacement to the north; across the pole it decreases
};

// After two minutes with satellites whose error is the same everywhere, and 20 s without them. A receiver has north and east of the place that
// it measures.
Misses after_a_flight(const earth::Place& start, double heading) {
    const Truth truth = winding(start, heading, 60);
    Flight run(usual());
    drive(run, truth, 120, [&](ins::Sample& sample) {
        if (sample.channel == imu) return;
        const double t = sample.t_s;
        if (t > 100) sample.t_s = -1; // refused: late
        const Vector3 off(std::sin(7.1 * t), std::sin(5.3 * t), std::sin(3.7 * t));
        const earth::Place true_place = earth::place_of(truth.position_e(t));
        const earth::Place moved = earth::place_of(truth.position_e(t) + 2 * off);
        const Vector3 v_e = earth::axes_at(true_place) * (Eigen::Map<const Vector3>(sample.value) + 0.05 * off);
        if (sample.channel == velocity) Eigen::Map<Vector3>(sample.value) = earth::axes_at(moved).transpose() * v_e;
        else Eigen::Map<Vector3>(sample.value) = Vector3(moved.latitude_rad, moved.longitude_rad, moved.height_m);
    });
    const ins::Navigation n = run.shown();
    EXPECT_TRUE(n.heading_ready);
    EXPECT_LE(std::fabs(n.place.longitude_rad), M_PI);
    const Quaternion q_eb = multiply(quaternion_from_matrix(earth::axes_at(n.place)), n.q_nb);
    return {rotation_vector(multiply(q_eb, conjugate(truth.q_eb(120)))).norm(), (n.velocity_e - truth.velocity_e(120)).norm(),
            (n.position_e - truth.position_e(120)).norm(), n.place.latitude_rad - start.latitude_rad};
}

TEST(InsAnyHeading, AFlightAcrossThePoleOrTheDateLineIsAsGoodAsOneAtTheEquator) {
    const Misses equator = after_a_flight({0.001, 0.3, 1000}, 0);
    const double apart_rad = 2900 / 6.357e6; // crossed after a minute
    const Misses pole = after_a_flight({M_PI / 2 - apart_rad, 0.3, 1000}, 0);
    EXPECT_GT(equator.ahead, 1.5 * apart_rad);
    EXPECT_LT(std::fabs(pole.ahead), 0.9 * apart_rad);
    const double east = M_PI / 2;
    const Misses there = after_a_flight({0.001, M_PI - 2900 / 6.378e6, 1000}, east),
                 here = after_a_flight({0.001, 0.3, 1000}, east);
    for (const auto& [is, was] : {std::pair(pole, equator), std::pair(there, here)}) {
        EXPECT_LT(is.attitude, 1.5 * was.attitude + 1e-4);
        EXPECT_LT(is.velocity, 1.5 * was.velocity + 0.02);
        EXPECT_LT(is.position, 1.5 * was.position + 0.3);
    }
    EXPECT_LT(equator.position, 8);
    EXPECT_LT(equator.attitude, 0.5 * deg);
}

// Fixes of a winding path that arrive so late, whose stamps are those of their arrival.
TEST(InsAnyHeading, FixesThatAreAllLateAreFoundToBeLate) {
    for (const double late_s : {0.1, 0.4})
        for (const double speed : {15.0, 60.0}) {
            const Truth truth = winding({0.7, -1, 50}, 2, speed);
            ins::Options o = usual();
            o.start_sigma_latency_s = 0.12;
            Flight run(o);
            drive(run, truth, 60, [&](ins::Sample& sample) {
                const double then_s = std::fmax(0, sample.t_s - late_s);
                if (sample.channel == velocity) sample = truth.velocity_fix(then_s);
                else if (sample.channel == position) sample = truth.position_fix(then_s);
                else return;
                sample.t_s = then_s + late_s;
            });
            const ins::Navigation n = run.shown();
            EXPECT_TRUE(n.heading_ready && n.position_ready) << late_s << " s, " << speed << " m/s";
            EXPECT_LT(std::fabs(wrap_angle(roll_pitch_yaw(n.q_nb)[2] - truth.heading(60))), 0.5 * deg)
                << late_s << " s, " << speed << " m/s";
            EXPECT_NEAR(run.filter.newest().latency, late_s, 0.02) << speed << " m/s";
            EXPECT_LT((n.position_e - truth.position_e(60)).norm(), 2) << late_s << " s, " << speed << " m/s";
        }
}

// Accelerates straight ahead from the first sample for so long, then keeps its speed.
Truth sprint(double heading, double gain_m_s2, double until_s) {
    const earth::Place start{0.7, -1, 50};
    const Vector3 p0 = earth::position_of(start);
    const Matrix3 N = earth::axes_at(start);
    Truth truth;
    truth.position_e = [=](double t) {
        const double until = std::fmin(t, until_s), way = gain_m_s2 * until * (t - 0.5 * until);
        return Vector3(p0 + N * (way * Vector3(std::cos(heading), std::sin(heading), 0)));
    };
    truth.q_eb = [=](double) { return multiply(quaternion_from_matrix(N), rotation_quaternion(Vector3(0, 0, heading))); };
    return truth;
}

TEST(InsAnyHeading, OneStraightAccelerationLeavesTheTiltOpenAndItsEndTellsIt) {
    constexpr double until_s = 11;
    const Truth truth = sprint(2, 3, until_s);
    Flight run(usual());
    bool started = false;
    for (int i = 1; i <= 6000; ++i) {
        const double t = 0.01 * i;
        feed(run, truth, i);
        ASSERT_EQ(run.filter.advance(t), Outcome::ok);
        if (!run.filter.shown().started()) continue;
        if (!started) {
            EXPECT_GT(t, until_s);
        }
        started = true;
        if (i % 20 == 0) {
            ASSERT_LT(tilt_nees(run.shown(), truth, t), 14) << t;
        }
    }
    EXPECT_TRUE(started);
}

TEST(InsAnyHeading, AnAccelerationWithoutAnEndStartsWithAWideTilt) {
    const Truth truth = sprint(-1, 3, 1e9);
    Flight run(usual());
    drive(run, truth, 19, [](ins::Sample&) {});
    ASSERT_TRUE(run.filter.shown().started());
    EXPECT_GT(run.filter.shown().P[ins::packed(ins::row_phi, ins::row_phi)], 0.1 * 0.1);
    EXPECT_LT(tilt_nees(run.shown(), truth, 19), 14);
    EXPECT_FALSE(run.shown().tilt_ready);
}

TEST(InsAnyHeading, WithoutMotionNothingIsClaimed) {
    const Vector3 p = earth::position_of({0.7, 0.3, 10});
    const Quaternion q = multiply(quaternion_from_matrix(earth::axes_at({0.7, 0.3, 10})), rotation_quaternion(Vector3(0, 0, 2)));
    Truth rest{[=](double) { return p; }, [=](double) { return q; }, 0.02};
    Flight run(usual());
    for (int i = 1; i <= 3000; ++i) {
        const double t = 0.02 * i;
        run.push_imu(rest, t);
        if (i % 50 == 0) {
            run.filter.push(rest.velocity_fix(t));
            run.filter.push(rest.position_fix(t));
        }
        ASSERT_EQ(run.filter.advance(t), Outcome::ok);
        ASSERT_FALSE(run.shown().heading_ready);
    }
    EXPECT_EQ(run.filter.shown().phase, Phase::any_heading);
    EXPECT_TRUE(run.shown().tilt_ready);
}

TEST(InsAnyHeading, AGyrocompassFindsNorthByTheRateOfTheEarth) {
    const earth::Place place{0.8, 0.3, 10};
    const Vector3 p = earth::position_of(place);
    for (const double heading : {-2.5, 0.4, 2.0}) {
        const Quaternion q = multiply(quaternion_from_matrix(earth::axes_at(place)), rotation_quaternion(Vector3(0, 0, heading)));
        Truth rest{[=](double) { return p; }, [=](double) { return q; }, 0.02};
        ins::Options s = usual();
        s.gyro_noise_rad_per_sqrt_s = 6e-7;
        s.gyro_bias_walk_rad_s_per_sqrt_s = 1e-10;
        s.accel_noise_m_s_per_sqrt_s = 1e-4;
        s.accel_bias_walk_m_s2_per_sqrt_s = 1e-7;
        s.start_sigma_gyro_bias_rad_s = 4.8e-8;
        s.start_sigma_accel_bias_m_s2 = 5e-4;
        s.rest_rate_noise_rad_per_sqrt_s = 1e-5;
        s.rest_velocity_noise_m_s = 0.01;
        give_place(s, place);
        Flight run(s);
        for (int i = 1; i <= 15000; ++i) {
            run.push_imu(rest, 0.02 * i);
            ASSERT_EQ(run.filter.advance(0.02 * i), Outcome::ok);
        }
        const ins::Navigation n = run.shown();
        EXPECT_TRUE(n.heading_ready);
        EXPECT_LT(std::fabs(wrap_angle(roll_pitch_yaw(n.q_nb)[2] - heading)), 0.1 * deg);
    }
}

// ------------------------------------------------------------------------------------------------ faults

ins::Options guarded() {
    ins::Options o = usual();
    o.outlier_rate_rad_s = 8;
    o.outlier_force_m_s2 = 100;
    o.time_jump_limit_s = 1;
    return o;
}

// Rotation error at t, in rad.
double rotation_error(const Flight& run, const Truth& truth, double t) {
    const ins::Navigation n = run.shown();
    const Quaternion q_eb = multiply(quaternion_from_matrix(earth::axes_at(n.place)), n.q_nb);
    return rotation_vector(multiply(q_eb, conjugate(truth.q_eb(t)))).norm();
}

TEST(InsFaults, OneWildSampleOfTheInertialUnitChangesNothing) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    for (const double size : {35.0, 1000.0, 9e5}) {
        Flight run(guarded());
        drive(run, truth, 41, [&](ins::Sample& sample) {
            if (sample.channel == imu && std::fabs(sample.t_s - 40) < 0.001) sample.value[2] = sample.value[4] = size;
        });
        EXPECT_LT(rotation_error(run, truth, 41), 1 * deg) << size;
        EXPECT_TRUE(run.shown().heading_ready) << size;
        EXPECT_EQ(run.filter.newest().check[checked_gyro].outliers, 1u);
    }
}

TEST(InsFaults, AStampFarAheadIsLeftOutAndAClockThatIsSetBackIsFollowed) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    for (const double back_s : {0.0, 10.0, 604800.0}) {
        Flight run(guarded());
        for (int i = 1; i <= 4500; ++i) {
            const double t = 0.01 * i, stamp = i > 4000 ? t - back_s : t;
            ins::Sample turn{i == 3500 ? t + 3600 : stamp, imu, {}};
            truth.sample(t, turn.value);
            ASSERT_EQ(run.filter.push(turn), Outcome::ok);
            if (i % 20 == 0)
                for (ins::Sample fix : {truth.velocity_fix(t), truth.position_fix(t)}) {
                    fix.t_s = stamp;
                    ASSERT_EQ(run.filter.push(fix), Outcome::ok);
                }
            ASSERT_EQ(run.filter.advance(stamp), Outcome::ok) << i;
        }
        EXPECT_EQ(run.filter.stamps().left_out(), 1u);
        EXPECT_EQ(run.filter.stamps().jumps(), back_s > 0 ? 1u : 0u);
        EXPECT_LT(rotation_error(run, truth, 45), 4 * deg) << back_s;
        EXPECT_LT((run.shown().position_e - truth.position_e(45)).norm(), 2.0);
        EXPECT_EQ(run.filter.newest().times_lost, 0u);
    }
}

// Fixes alone must not start the filter: a state without force would be kilometres off with a sigma of 0.
TEST(InsFaults, WithoutTheInertialUnitNothingIsReadyAndItIsFoundAgainAfterwards) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    Flight run(guarded());
    for (int i = 1; i <= 14000; ++i) {
        const double t = 0.01 * i;
        const bool silent = i > 4000 && i <= 10000;
        if (!silent) run.push_imu(truth, t);
        if (i % 20 == 0) {
            run.filter.push(truth.velocity_fix(t));
            run.filter.push(truth.position_fix(t));
        }
        ASSERT_EQ(run.filter.advance(t), Outcome::ok) << i;
        if (silent && i > 4200) {
            const ins::Navigation n = run.shown();
            ASSERT_FALSE(n.tilt_ready || n.heading_ready || n.velocity_ready || n.position_ready) << t;
        }
    }
    EXPECT_EQ(run.filter.newest().times_lost, 1u);
    EXPECT_TRUE(run.shown().heading_ready);
    EXPECT_LT(rotation_error(run, truth, 140), 1 * deg);
    EXPECT_LT((run.shown().position_e - truth.position_e(140)).norm(), 1.0);
}

TEST(InsFaults, AnAxisThatIsStuckCostsCertaintyAboutItAndNoneIsClaimed) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    test::Random random(4);
    Flight run(guarded());
    double sigma_before = 0;
    drive(run, truth, 43, [&](ins::Sample& sample) {
        if (sample.channel != imu) return;
        for (int i = 0; i < 3; ++i) sample.value[i] += random.normal(1e-3);
        if (sample.t_s > 40) sample.value[2] = 0.3;
        if (sample.t_s < 40) sigma_before = run.filter.shown().P[ins::packed(ins::row_phi + 2, ins::row_phi + 2)];
    });
    EXPECT_GT(run.filter.newest().check[checked_gyro].stuck, 100u);
    EXPECT_GT(run.shown().sigma_rotation[2], 5 * std::sqrt(sigma_before));
    EXPECT_FALSE(run.shown().heading_ready);
}

// The false force would make a wrong heading look observable, through the lateral velocity.
TEST(InsFaults, ASaturatedAccelerometerTellsNothingOfTheHeading) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    test::Random random(4);
    double sigma[2] = {};
    for (const bool saturated : {false, true}) {
        Flight run(guarded());
        drive(run, truth, 42, [&](ins::Sample& sample) {
            if (sample.channel != imu) return;
            for (int i = 0; i < 6; ++i) sample.value[i] += random.normal(1e-3);
            if (saturated && sample.t_s > 40 && sample.t_s < 41) sample.value[3] = 157;
        });
        sigma[saturated] = run.shown().sigma_rotation[2];
    }
    EXPECT_GT(sigma[1], 0.7 * sigma[0]); // the fault is found after some samples
}

// A receiver without a fix repeats zeros.
TEST(InsFaults, FixesFromNowhereAreLeftOutWithTheirVelocities) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    Flight run(guarded());
    drive(run, truth, 60, [&](ins::Sample& sample) {
        if (sample.t_s < 40 || (sample.channel != velocity && sample.channel != position)) return;
        for (int i = 0; i < 3; ++i) sample.value[i] = 0;
    });
    EXPECT_EQ(run.filter.newest().times_lost, 0u);
    EXPECT_LT((run.shown().position_e - truth.position_e(60)).norm(), 10);
}

TEST(InsFaults, AStepOfABiasIsFound) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    Flight run(guarded());
    drive(run, truth, 140, [&](ins::Sample& sample) {
        if (sample.channel == imu && sample.t_s > 40) sample.value[3] += 1;
    });
    EXPECT_NEAR(run.filter.newest().accel_bias[0], 1, 0.1);
    EXPECT_LT(rotation_error(run, truth, 140), 2 * deg);
}

// ------------------------------------------------------------------------------------------------ what hybrid filters promise

// All phases: waiting, levelling, any heading, navigating, and a change of the anchor.
ins::Options restless() {
    ins::Options s = usual();
    s.anchor_distance_m = 300;
    return s;
}

TEST(InsHybrid, TheSameSamplesGiveTheSameBitsWhateverTimesAreAskedFor) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    for (const bool closed_form : {true, false}) {
        Flight often(restless(), closed_form), seldom(restless(), closed_form);
        for (int i = 1; i <= 4000; ++i) {
            feed(often, truth, i);
            feed(seldom, truth, i);
            for (const double share : {0.0, 0.3, 0.9}) ASSERT_EQ(often.filter.advance(0.01 * (i + share)), Outcome::ok);
            if (i % 50 == 0) {
                ASSERT_EQ(seldom.filter.advance(0.01 * i), Outcome::ok);
                ASSERT_EQ(std::memcmp(&often.filter.newest(), &seldom.filter.newest(), sizeof(ins::State)), 0) << i;
            }
        }
        EXPECT_EQ(seldom.filter.newest().phase, Phase::navigating);
        EXPECT_GT((ins::vec(seldom.filter.newest().anchor_e) - earth::position_of({0.8, 0.2, 100})).norm(), 250);
    }
}

TEST(InsHybrid, AFixThatComesLateGivesTheBitsOfAPunctualOne) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    Flight punctual(restless(), true, 0.3), late(restless(), true, 0.3);
    for (int i = 1; i <= 4000; ++i) {
        const double t = 0.01 * i;
        // Also between two samples of the IMU.
        const double valid = t - 0.003;
        punctual.push_imu(truth, t);
        late.push_imu(truth, t);
        if (i % 20 == 0) {
            punctual.filter.push(truth.velocity_fix(valid));
            punctual.filter.push(truth.position_fix(valid));
        }
        if (i > 20 && i % 20 == 19) {
            const double was_valid = 0.01 * (i - 19) - 0.003;
            late.filter.push(truth.velocity_fix(was_valid));
            late.filter.push(truth.position_fix(was_valid));
        }
        ASSERT_EQ(punctual.filter.advance(t), Outcome::ok);
        ASSERT_EQ(late.filter.advance(t), Outcome::ok);
        if (i % 20 != 19) continue;
        ASSERT_EQ(std::memcmp(&punctual.filter.newest(), &late.filter.newest(), sizeof(ins::State)), 0) << i;
    }
    EXPECT_EQ(late.filter.newest().phase, Phase::navigating);
}

TEST(InsHybrid, ASavedStateGoesOnBitForBitFromEveryPhase) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    for (const int at : {5, 150, 330, 3000}) {
        Flight whole(restless()), other(restless());
        std::vector<unsigned char> saved(whole.filter.state_size());
        for (int i = 1; i <= at + 400; ++i) {
            feed(whole, truth, i);
            if (i > at) feed(other, truth, i);
            ASSERT_EQ(whole.filter.advance(0.01 * i), Outcome::ok);
            if (i > at) {
                ASSERT_EQ(other.filter.advance(0.01 * i), Outcome::ok);
            }
            if (i != at) continue;
            whole.filter.save(saved.data());
            ASSERT_EQ(other.filter.load(saved.data(), saved.size()), LoadOutcome::ok);
        }
        EXPECT_EQ(std::memcmp(&whole.filter.newest(), &other.filter.newest(), sizeof(ins::State)), 0) << at;
    }
}

TEST(InsHybrid, BothEnginesGiveTheSameNavigation) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    Flight closed(restless(), true), solver(restless(), false);
    for (int i = 1; i <= 4000; ++i) {
        for (Flight* run : {&closed, &solver}) {
            feed(*run, truth, i);
            ASSERT_EQ(run->filter.advance(0.01 * i), Outcome::ok);
        }
    }
    const ins::Navigation a = closed.shown(), b = solver.shown();
    EXPECT_LT((a.position_e - b.position_e).norm(), 1e-4);
    EXPECT_LT((a.velocity_e - b.velocity_e).norm(), 1e-4);
    EXPECT_LT(rotation_vector(multiply(a.q_nb, conjugate(b.q_nb))).norm(), 1e-6);
}

// ------------------------------------------------------------------------------------------------ faults

TEST(InsFaults, AJumpOfThePositionIsGatedAndItsEndForgotten) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    Flight run(usual());
    double worst_sigmas = 0, end_error = 0;
    for (int i = 1; i <= 10000; ++i) {
        const double t = 0.01 * i;
        run.push_imu(truth, t);
        if (i % 20 == 0) {
            run.filter.push(truth.velocity_fix(t));
            ins::Sample fix = truth.position_fix(t);
            if (t > 60 && t <= 70) fix.value[0] += 100 / earth::equator_m;
            run.filter.push(fix);
        }
        ASSERT_EQ(run.filter.advance(t), Outcome::ok);
        if (i % 100 || t < 50) continue;
        const ins::Navigation n = run.shown();
        end_error = (n.position_e - truth.position_e(t)).norm();
        worst_sigmas = std::fmax(worst_sigmas, end_error / n.sigma_position.norm());
    }
    EXPECT_LT(worst_sigmas, 3);
    EXPECT_LT(end_error, 2);
    EXPECT_GT(run.filter.newest().inflated[position], 40u);
}

TEST(InsFaults, AGapBeginsAnewAndKeepsTheBiases) {
    const Truth truth = winding({0.8, 0.2, 100}, 1);
    Flight run(usual());
    for (int i = 1; i <= 9000; ++i) {
        if (i > 4000 && i < 4300) continue;
        feed(run, truth, i);
        ASSERT_EQ(run.filter.advance(0.01 * i), Outcome::ok);
        if (i == 4310) {
            EXPECT_EQ(run.filter.shown().phase, Phase::levelling);
        }
    }
    EXPECT_EQ(run.filter.newest().times_lost, 1u);
    EXPECT_EQ(run.filter.newest().phase, Phase::navigating);
    EXPECT_LT(std::fabs(wrap_angle(roll_pitch_yaw(run.shown().q_nb)[2] - truth.heading(90))), 1 * deg);
}

// ------------------------------------------------------------------------------------------------ the C API

TEST(InsApi, RefusesWhatIsNoSampleAndGoesOn) {
    hnav_ins_options options = hnav_ins_defaults(HNAV_INS_INDUSTRIAL);
    hnav_filter* object = nullptr;
    ASSERT_EQ(hnav_ins_create(&object, &options, nullptr, 0), HNAV_OK);
    const double rate[3] = {0, 0, 0}, force[3] = {0, 0, -9.8}, sigma[3] = {1, 1, 1}, zero[3] = {0, 1, 1};
    const double bad[3] = {std::nan(""), 0, 0};
    EXPECT_EQ(hnav_filter_push_imu(object, 0, bad, force), HNAV_ERROR_NON_FINITE);
    EXPECT_EQ(hnav_filter_push_position(object, 0, 2, 0, 0, sigma), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_filter_push_position(object, 0, 1, 0, 0, zero), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_filter_push_pressure(object, 0, 1013, 1), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_NE(std::strstr(hnav_filter_message(object), "Pa"), nullptr);
    EXPECT_EQ(hnav_filter_push_imu(object, std::nan(""), rate, force), HNAV_ERROR_NON_FINITE);
    EXPECT_EQ(hnav_filter_push_imu(nullptr, 0, rate, force), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_filter_push_imu(object, 0, rate, force), HNAV_OK);
    EXPECT_EQ(hnav_filter_advance(object, 0), HNAV_OK);
    EXPECT_EQ(hnav_filter_advance(object, -1), HNAV_ERROR_TIME_BACKWARDS);
    auto now = hnav_sized<hnav_navigation>();
    EXPECT_EQ(hnav_ins_navigation(object, &now), HNAV_OK);
    EXPECT_EQ(now.phase, HNAV_INS_PHASE_LEVELLING);
    EXPECT_TRUE(std::isnan(now.latitude_rad) && std::isnan(now.sigma_latency_s));
    double covariance[225];
    EXPECT_EQ(hnav_filter_covariance(object, covariance), HNAV_ERROR_NOT_STARTED);
    auto diagnostics = hnav_sized<hnav_diagnostics>();
    EXPECT_EQ(hnav_filter_diagnostics(object, &diagnostics), HNAV_OK);
    EXPECT_EQ(diagnostics.non_finite, 5u);
    hnav_filter_destroy(object);
    options.gate_nis = -1;
    char message[160];
    EXPECT_EQ(hnav_ins_create(&object, &options, message, sizeof message), HNAV_ERROR_OPTION);
    EXPECT_NE(std::strstr(message, "gate_nis"), nullptr);
}

} // namespace
} // namespace hnav
