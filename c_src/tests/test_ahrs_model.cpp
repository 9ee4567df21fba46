// Laws of the AHRS: its flow, the transition that its covariance follows from, its gathered samples and corrections.
#include "ahrs.hpp"
#include "hnav/hnav.h"

#include <memory>
#include <random>
#include <vector>

using namespace hnav;
using hnav::test::angle_between, hnav::test::follow, hnav::test::state_at_start, hnav::test::take, hnav::test::Turning;
using Event = AttitudeEvent;
using Sample = AttitudeSample;
using State = AhrsModel::State;
using Vector2 = Eigen::Vector2d;
using Vector14 = Eigen::Matrix<double, 14, 1>;

namespace {

constexpr double deg = M_PI / 180;

hnav_ahrs_options settings() { return test::ahrs_options(); }

// Samples of an integrating sensor at a low rate, or force as an instantaneous reading; the body swings about all axes.
// Propagates by the closed form; the caller handles each sample.
template <class At>
void swing(const AhrsModel& model, State& s, double interval_s, double duration_s, bool mean_force, At&& at) {
    const auto rate = [](double t) { return Vector3(2 * std::sin(3 * t), 2.5 * std::cos(2.3 * t), 1.5 * std::sin(4 * t + 1)); };
    constexpr int substeps = 50;
    const double h = interval_s / substeps;
    Quaternion q(1, 0, 0, 0);
    for (int k = 0; k * interval_s < duration_s; ++k) {
        Vector3 turn = Vector3::Zero(), force = Vector3::Zero();
        for (int i = 0; k > 0 && i < substeps; ++i) {
            const Vector3 u = rate((k - 1) * interval_s + (i + 0.5) * h);
            const Quaternion middle = multiply(q, rotation_quaternion(0.5 * h * u));
            force += rotation_matrix(middle).transpose() * Vector3(0, 0, -AhrsModel::gravity_m_s2) / substeps;
            turn += u / substeps;
            q = multiply(q, rotation_quaternion(h * u));
        }
        if (!mean_force || k == 0) force = rotation_matrix(q).transpose() * Vector3(0, 0, -AhrsModel::gravity_m_s2);
        const Vector3 field = rotation_matrix(q).transpose() * Vector3(2.5e-5, 0, 4.33e-5);
        Event e{};
        e.t_s = k * interval_s;
        e.add(Sample{e.t_s, gyro, {turn[0], turn[1], turn[2]}});
        e.add(Sample{e.t_s, accel, {force[0], force[1], force[2]}});
        e.add(Sample{e.t_s, mag, {field[0], field[1], field[2]}});
        take(model, s, e, k > 0 ? interval_s : 0);
        at(e.t_s, q);
    }
}

} // namespace

TEST(HeldTurn, IsTheIntegralOfTheRotationOnBothSidesOfItsSeries) {
    for (const double speed : {0.0, 1e-9, 0.9, 0.999, 1.001, 20.0}) {
        const Vector3 u = speed * Vector3(1, 2, -2) / 3;
        const HeldTurn turn(u, 0.1);
        // Simpson's rule for the rotation itself.
        Matrix3 sum = Matrix3::Zero();
        constexpr int n = 400;
        for (int k = 0; k <= n; ++k)
            sum += (k == 0 || k == n ? 1 : k % 2 ? 4 : 2) * rotation_matrix(rotation_quaternion(u * 0.1 * k / n));
        EXPECT_LT((turn.integral - sum * 0.1 / (3 * n)).cwiseAbs().maxCoeff(), 1e-12) << speed;
        EXPECT_LT((turn.q - rotation_quaternion(u * 0.1)).cwiseAbs().maxCoeff(), 1e-15) << speed;
    }
}

TEST(HeldTurn, BackwardsUndoesForwards) {
    const Vector3 u(3, -7, 5);
    const HeldTurn there(u, 0.02), back(u, -0.02);
    EXPECT_LT((multiply(there.q, back.q) - Quaternion(1, 0, 0, 0)).cwiseAbs().maxCoeff(), 1e-15);
    EXPECT_LT((there.integral + rotation_matrix(there.q) * back.integral).cwiseAbs().maxCoeff(), 1e-16);
}

TEST(AhrsFlow, TheClosedFormIsTheIntegralOfTheFlow) {
    const AhrsModel model(settings());
    State s = state_at_start(model);
    follow(model, s, Turning{}, 0.02);
    State exact = s;
    model.flow_exactly(exact, 0.03);
    // The classical Runge-Kutta method of order 4 in steps of 10 us.
    Vector14 x = Eigen::Map<Vector14>(s.x);
    const auto f = [&](const Vector14& y) {
        Vector14 dy;
        model.flow(s, y.data(), dy.data());
        return dy;
    };
    constexpr double h = 3e-4;
    for (int k = 0; k < 100; ++k) {
        const Vector14 k1 = f(x), k2 = f(x + 0.5 * h * k1), k3 = f(x + 0.5 * h * k2), k4 = f(x + h * k3);
        x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    EXPECT_LT((x - Eigen::Map<Vector14>(exact.x)).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(AhrsFlow, TheDirectionalDerivativeEqualsAPerturbation) {
    const AhrsModel model(settings());
    State s = state_at_start(model);
    follow(model, s, Turning{}, 0.05);
    const Vector14 x = Eigen::Map<Vector14>(s.x);
    const auto J = test::perturbation_jacobian<14, 14>(
        [&](const Vector14& y) {
            Vector14 dy;
            model.flow(s, y.data(), dy.data());
            return dy;
        },
        x);
    for (int j = 0; j < 14; ++j) {
        const Vector14 seed = Vector14::Unit(j);
        Vector14 out;
        model.flow_along(s, x.data(), seed.data(), out.data());
        EXPECT_LT((out - J.col(j)).cwiseAbs().maxCoeff(), 1e-8) << "state " << j;
    }
}

// The flow propagates, instead of the covariance, how bias and calibration errors become rotation.
TEST(AhrsFlow, TheTransitionIsWhatAnErrorOfTheGyroscopeDoesToTheAttitude) {
    const AhrsModel model(settings());
    State begin = state_at_start(model);
    Turning motion;
    motion.rate_b = {1.5, -2, 1};
    follow(model, begin, motion, 0.0);
    const auto after = [&](const Vector3& bias, const Matrix3& S) {
        State s = begin;
        Eigen::Map<Vector3>(s.bias) = bias;
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(s.calibration) = S;
        model.note_turning(s);
        model.flow_exactly(s, 0.03);
        return s;
    };
    const State still = after(Vector3::Zero(), Matrix3::Zero());
    const Eigen::Map<const Matrix3> G(still.x + 4);
    const auto rotation_to = [&](const State& s) {
        const Quaternion e = multiply(Quaternion(s.x), conjugate(Quaternion(still.x)));
        return Vector3(2 * e.tail<3>());
    };
    constexpr double small = 1e-7;
    const Vector3 y(still.rate);
    for (int j = 0; j < 3; ++j) {
        const Vector3 by_bias = rotation_to(after(small * Vector3::Unit(j), Matrix3::Zero())) / small;
        EXPECT_LT((by_bias + G.col(j)).cwiseAbs().maxCoeff(), 1e-6) << j;
        for (int i = 0; i < 3; ++i) {
            Matrix3 S = Matrix3::Zero();
            S(i, j) = small;
            const Vector3 by_scale = rotation_to(after(Vector3::Zero(), S)) / small;
            EXPECT_LT((by_scale + G.col(i) * y[j]).cwiseAbs().maxCoeff(), 1e-6) << i << j; // L = int R (x) y
        }
    }
}

TEST(AhrsFlow, AMeanRateTurnsTheBodyAsFarAsTheTurnsThatItIsTheMeanOf) {
    hnav_ahrs_options set = settings();
    set.correction_interval_s = 1e3; // nothing is corrected
    set.start_mode = HNAV_START_ATTITUDE;
    const AhrsModel model(set);
    State s = state_at_start(model);
    double error = 0;
    swing(model, s, 0.035, 20, true, [&](double, const Quaternion& q) { error = angle_between(Quaternion(s.x), q); });
    EXPECT_LT(error, 0.05 * deg); // 0.35 deg without coning
}

TEST(Ahrs, WhetherAForceIsAMeanOrAReadingShowsInTheMotion) {
    for (const bool mean : {false, true}) {
        const AhrsModel model(settings());
        State s = state_at_start(model);
        double worst = 0;
        swing(model, s, 0.035, 60, mean, [&](double t_s, const Quaternion& q) {
            if (t_s > 30) worst = std::fmax(worst, angle_between(Quaternion(s.x), q));
        });
        EXPECT_NEAR(s.force_latency, mean ? 0.5 : 0, 0.1);
        EXPECT_LT(worst, 0.3 * deg) << mean;
    }
}

// The rows of the transition that belong to the accelerometer.
TEST(AhrsCovariance, VelocityIsWhatAnErrorOfTheAccelerometerBecomes) {
    hnav_ahrs_options set = settings();
    set.correction_interval_s = 1e3;
    set.start_mode = HNAV_START_ATTITUDE;
    const AhrsModel model(set);
    const auto after = [&](const Vector3& bias, double latency) {
        State s = state_at_start(model);
        Eigen::Map<Vector3>(s.force_bias) = bias;
        s.force_latency = 0.3 + latency;
        swing(model, s, 0.01, 0.5, true, [](double, const Quaternion&) {});
        return s;
    };
    const State still = after(Vector3::Zero(), 0);
    const auto velocity = [&](const State& s) {
        return Vector2(s.velocity[0] - still.velocity[0], s.velocity[1] - still.velocity[1]);
    };
    constexpr double small = 1e-6;
    const Eigen::Map<const Matrix3> G(still.x + 4);
    for (int j = 0; j < 3; ++j) {
        const Vector2 by_bias = velocity(after(small * Vector3::Unit(j), 0)) / small;
        EXPECT_LT((by_bias + G.block<2, 1>(0, j) * (still.force_s / still.x[13])).norm(), 0.02) << j;
    }
    const Vector2 by_latency = velocity(after(Vector3::Zero(), small)) / small;
    EXPECT_LT((by_latency + Vector2(still.swept_velocity[0], still.swept_velocity[1])).norm(), 1e-4 * by_latency.norm());
}

TEST(Ahrs, TheFieldOfOnePlaceDoesNotTellTheHeadingBetterThanPlacesDiffer) {
    const AhrsModel model(settings());
    State s = state_at_start(model);
    follow(model, s, Turning{}, 30);
    const double sigma = std::sqrt(model.rotation_covariance(s)(2, 2)),
                 place = std::sqrt(s.field_noise.scale2) * settings().local_declination_rad;
    EXPECT_GT(sigma, 0.5 * place);
}

TEST(Ahrs, ABodyOnABenchKnowsItsTiltBetterThanOneInAHandAndAMotionCountsAtOnce) {
    const auto horizon_sigma = [](double shake_m_s2, double still_after_s) {
        const AhrsModel model(settings());
        State s = state_at_start(model);
        const Turning motion;
        for (int k = 0; k <= 20000; ++k) {
            Event e = motion.event(0.005 * k);
            const double a = e.t_s < still_after_s ? shake_m_s2 * std::cos(4 * e.t_s) : 0;
            const Vector3 push = rotation_matrix(motion.q(e.t_s)).transpose() * Vector3(a, 0, 0);
            for (int i = 0; i < 3; ++i) e.value[accel][i] += push[i];
            take(model, s, e, k > 0 ? 0.005 : 0);
        }
        return std::sqrt(model.rotation_covariance(s)(0, 0));
    };
    const double bench = horizon_sigma(0, 0), hand = horizon_sigma(2, 100), hand_laid_down = horizon_sigma(2, 20);
    EXPECT_LT(bench, 0.7 * hand);
    EXPECT_LT(hand_laid_down, 0.8 * hand);

    MotionNoise<double> noise;
    noise.begin(0.25);
    EXPECT_NEAR(noise.density2(0.25, false), 0.25, 1e-12); // nothing is known yet
    for (int k = 0; k < 20000; ++k) noise.note({0.3, -0.2, -9.8}, 0.01); // a tilted horizon is no motion
    EXPECT_NEAR(std::sqrt(noise.density2(0.25, true)), MotionNoise<double>::min_density, 1e-3);
    EXPECT_EQ(std::sqrt(noise.density2(0.25, false)), MotionNoise<double>::min_moving_density);
    for (int k = 0; k < 30; ++k) noise.note({2.3, -0.2, -9.8}, 0.01);
    EXPECT_GT(std::sqrt(noise.density2(0.25, false)), 0.3);
}

TEST(Ahrs, CorrectionsOfTheTiltInOneDirectionAddToItsVarianceAndWhiteOnesDoNot) {
    constexpr double T = 0.035, sigma = 1e-4;
    std::mt19937 random(1);
    std::normal_distribution<double> normal(0, sigma);
    TiltExcess<double> white{}, turning{}, wide{};
    double mean = 0;
    constexpr int count = 200000;
    for (int k = 0; k < count; ++k) {
        const double by[] = {normal(random), normal(random)}, steady[] = {0.5 * sigma, 0};
        for (auto* excess : {&white, &turning, &wide}) excess->pass(T);
        white.note(by, sigma * sigma);
        turning.note(steady, sigma * sigma);
        wide.note(steady, 1e4 * sigma * sigma); // of an unknown horizon
        mean += white.corrected[0] * white.corrected[0] / count / white.expected;
    }
    EXPECT_NEAR(mean, 1, 0.2); // the variance of the sum equals the predicted one
    const double sum = 0.5 * sigma * TiltExcess<double>::memory_s / T;
    EXPECT_NEAR(turning.variance, sum * sum / 2 - turning.expected, 0.02 * sum * sum);
    EXPECT_LT(white.variance, 5 * white.expected);
    EXPECT_EQ(wide.variance, 0);
    const double before = turning.variance;
    for (int k = 0; k * T < TiltExcess<double>::memory_s; ++k) turning.pass(T);
    EXPECT_NEAR(turning.variance, std::exp(-1.0) * before, 0.02 * before);
}

TEST(Ahrs, AMeanForceOfAnotherLengthThanAtRestIsAnAcceleration) {
    constexpr double g = 9.80665, T = 0.035;
    const auto accelerates = [&](double rest_force, const Vector3& force, double for_s) {
        LastingMotion<double> motion{};
        motion.begin(0.1);
        motion.down2 = 0;
        if (rest_force > 0) motion.settle(rest_force, T);
        for (int k = 0; k * T < for_s; ++k) motion.note(T * force, 1e-4 * g * g, g, T);
        return motion.may_accelerate(g);
    };
    const Vector3 bank(4, 0, -g), level(0, 0, -g), biased(0, 0, -g - 0.4);
    EXPECT_TRUE(accelerates(0, bank, 10));
    EXPECT_TRUE(accelerates(g, bank, 10));
    EXPECT_FALSE(accelerates(0, level, 10));
    EXPECT_FALSE(accelerates(g, level, 10));
    LastingMotion<double> cheap{};
    cheap.begin(0.1);
    cheap.settle(g + 0.4, T);
    for (int k = 0; k < 300; ++k) cheap.note(T * biased, 1e-4 * g * g, g, T);
    EXPECT_FALSE(cheap.may_accelerate(g)); // the bias of its accelerometer was observed at rest
}

TEST(Ahrs, AVelocityThatNoLongerCountsGoesOnUnlessARestHasEndedIt) {
    constexpr double g = 9.80665, T = 0.035;
    for (const bool rests : {false, true}) {
        LastingMotion<double> motion{};
        motion.begin(0.1);
        for (int k = 0; k < 200; ++k) motion.note(T * Vector3(2, 0, -g), 1e-4 * g * g, g, T);
        motion.uncount();
        double released2 = 0;
        for (int k = 0; k < 30; ++k) {
            if (rests) motion.settle(g, T);
            else
                for (double& p : motion.power) p *= 0.9;
            for (double& n : motion.now) n *= 0.9;
            released2 += motion.uncount();
        }
        if (rests) EXPECT_EQ(released2, 0);
        else EXPECT_GT(released2, 10);
    }
}

TEST(Ahrs, ABodyThatGoesFarMaySinkWithoutItsHorizonBeingWrong) {
    constexpr double g = 9.80665, for_s = 4, bank = 25 * M_PI / 180;
    const auto ratio = [&](double velocity2) {
        LastingMotion<double> motion{};
        motion.begin(0);
        motion.power[1] = velocity2;
        motion.force_s = for_s;
        Eigen::Map<Vector3>(motion.force) = for_s * g * Vector3(std::sin(bank), 0, -std::cos(bank));
        return motion.wrong_horizon(g, 0);
    };
    EXPECT_GT(ratio(0), 100);
    EXPECT_LT(ratio(900), 1);
}

TEST(Ahrs, AFieldThatIsTheSameEverywhereTellsTheHeadingBetterThanOneOfARoom) {
    const auto heading_sigma = [](double iron) {
        const AhrsModel model(settings());
        State s = state_at_start(model);
        const Turning motion;
        for (int k = 0; k <= 12000; ++k) {
            Event e = motion.event(0.005 * k, false);
            const double t = e.t_s;
            const Vector3 place = iron * 5e-5 * Vector3(std::sin(0.8 * t), std::cos(0.5 * t), std::sin(0.6 * t));
            const Vector3 field = rotation_matrix(motion.q(t)).transpose() * (Vector3(2.5e-5, 0, 4.33e-5) + place);
            e.add(Sample{t, mag, {field[0], field[1], field[2]}});
            take(model, s, e, k > 0 ? 0.005 : 0);
        }
        EXPECT_EQ(s.repaired, 0u);
        return std::sqrt(model.rotation_covariance(s)(2, 2));
    };
    EXPECT_LT(heading_sigma(0), 0.5 * heading_sigma(0.02));
}

TEST(Ahrs, AFieldThatContradictsAFreshReferenceMakesTheHeadingDoubtful) {
    const AhrsModel model(settings());
    const auto variance_after = [&](double clean_s) {
        State s = state_at_start(model);
        const Turning motion;
        follow(model, s, motion, clean_s);
        const double before = model.rotation_covariance(s)(2, 2);
        for (int k = 1; k <= 100; ++k) {
            Event e = motion.event(clean_s + 0.005 * k);
            for (int i = 0; i < 3; ++i) e.value[mag][i] *= 1.3;
            take(model, s, e, 0.005);
        }
        return model.rotation_covariance(s)(2, 2) - before;
    };
    EXPECT_GT(variance_after(1), 0.02);
    EXPECT_LT(variance_after(20), 0.002);
}

TEST(Ahrs, TheAddedVarianceOfTheHeadingLastsAsLongAsTheContradictionUnlessTheReferenceHasChanged) {
    const AhrsModel model(settings());
    // Clean for a second, then a field of another strength, then clean again.
    const auto variance_after = [&](double contradicted_s, double clean_s, bool stays) {
        State s = state_at_start(model);
        const Turning motion;
        for (int k = 0; k * 0.005 <= 1 + contradicted_s + clean_s; ++k) {
            Event e = motion.event(0.005 * k);
            const bool false_field = e.t_s > 1 && (stays || e.t_s < 1 + contradicted_s);
            for (int i = 0; i < 3; ++i) e.value[mag][i] *= false_field ? 1.3 : 1;
            take(model, s, e, k > 0 ? 0.005 : 0);
        }
        EXPECT_EQ(s.field.changes > 0, stays);
        return s.reference_variance;
    };
    const double at_end = variance_after(1, 0, false), half_way = variance_after(1, 0.5, false);
    EXPECT_NEAR(half_way, 0.5 * at_end, 0.1 * at_end);
    EXPECT_EQ(variance_after(1, 1.2, false), 0);
    EXPECT_GT(variance_after(1, 10, true), 0.3 * at_end);
}

TEST(Ahrs, AReferenceThatIsNotOfTheEarthMakesTheHeadingDoubtfulUnlessItWasGivenOrAnAidTellsTheHeading) {
    const auto heading = [](double strength, bool given, bool aided) {
        hnav_ahrs_options set = settings();
        if (given) set.reference_mode = HNAV_REFERENCE_GIVEN;
        set.reference_strength_tesla = strength * 5e-5;
        set.reference_dip_rad = M_PI / 3;
        const AhrsModel model(set);
        State s = state_at_start(model);
        const Turning motion;
        for (int k = 0; k <= 3000; ++k) {
            Event e = motion.event(0.005 * k);
            for (int i = 0; i < 3; ++i) e.value[mag][i] *= strength;
            const Matrix3 R_bn = rotation_matrix(motion.q(e.t_s));
            if (aided && k % 200 == 100) e.add(Sample{e.t_s, hnav::heading, {std::atan2(R_bn(1, 0), R_bn(0, 0)), 0.01, 0}});
            take(model, s, e, k > 0 ? 0.005 : 0);
        }
        EXPECT_EQ(std::sqrt(model.rotation_covariance(s)(2, 2)) < 0.1, model.estimate(s).heading_ready);
        return model.estimate(s).heading_ready;
    };
    for (const double strength : {0.5, 1.0, 1.3}) EXPECT_TRUE(heading(strength, false, false)) << strength;
    for (const double strength : {0.3, 2.0}) {
        EXPECT_FALSE(heading(strength, false, false)) << strength;
        EXPECT_TRUE(heading(strength, true, false)) << strength;
        EXPECT_TRUE(heading(strength, false, true)) << strength;
    }
}

TEST(AhrsCovariance, GrowsWhileNothingIsMeasuredAsManyRunsDo) {
    hnav_ahrs_options set = settings();
    set.gyro_noise_rad_per_sqrt_s = std::sqrt(1e-5);
    set.gyro_rate_noise_sqrt_s = 0;
    set.start_mode = HNAV_START_ATTITUDE;
    set.start_sigma_tilt_rad = set.start_sigma_heading_rad = 0.01;
    set.start_sigma_bias_rad_s = 0.02;
    set.start_sigma_gyro_scale = set.start_sigma_gyro_misalignment_rad = 1e-6;
    const AhrsModel model(set);
    State s = state_at_start(model);
    Turning motion;
    motion.rate_b = {2, -1, 3};
    Event first{};
    first.add(Sample{0, gyro, {2, -1, 3}});
    model.before_flow(s, first);
    model.jump(s, first);
    model.flow_exactly(s, 0.5);
    const Matrix3 claimed = model.rotation_covariance(s);

    test::Random random(7);
    Matrix3 sum = Matrix3::Zero();
    constexpr int runs = 20000, steps = 50;
    constexpr double h = 0.5 / steps;
    const Quaternion end = HeldTurn(motion.rate_b, 0.5).q;
    for (int r = 0; r < runs; ++r) {
        const auto normal3 = [&](double sigma) {
            return Vector3(sigma * Vector3(random.normal(), random.normal(), random.normal()));
        };
        Quaternion q = rotation_quaternion(normal3(0.01));
        const Vector3 bias = normal3(0.02);
        for (int k = 0; k < steps; ++k)
            q = multiply(q, rotation_quaternion(h * (motion.rate_b - bias) + normal3(std::sqrt(1e-5 * h))));
        const Quaternion e = multiply(q, conjugate(end));
        const Vector3 theta = 2 * e.tail<3>() * (e[0] < 0 ? -1 : 1);
        sum += theta * theta.transpose();
    }
    const Matrix3 sample = sum / runs;
    EXPECT_LT((sample - claimed).cwiseAbs().maxCoeff(), 0.05 * claimed.diagonal().maxCoeff());
}

TEST(Ahrs, FindsAttitudeBiasAndLatency) {
    const AhrsModel model(settings());
    State s = state_at_start(model);
    Turning motion;
    motion.bias = {0.01, -0.006, 0.004};
    motion.latency_s = 0.012;
    // Turns about changing axes, so that every bias is observable; each leg continues from the previous one.
    double t = 0;
    for (int leg = 0; leg < 60; ++leg) {
        const Quaternion q_end = leg ? motion.q(1.0) : motion.start_q;
        motion.start_q = q_end;
        motion.rate_b = Vector3(std::sin(1.7 * leg), std::cos(2.3 * leg), std::sin(0.9 * leg + 1));
        for (int k = leg ? 1 : 0; k <= 200; ++k) {
            Event e = motion.event(0.005 * k);
            e.t_s = t + 0.005 * k;
            take(model, s, e, 0.005);
        }
        t += 1;
    }
    EXPECT_LT(angle_between(Quaternion(s.x), motion.q(1.0)), 0.3 * deg);
    EXPECT_LT((Vector3(s.bias) - motion.bias).cwiseAbs().maxCoeff(), 1e-3);
    EXPECT_NEAR(s.latency, 0.012, 2e-3);
    EXPECT_TRUE(model.estimate(s).heading_ready);
    EXPECT_EQ(s.repaired, 0u);
}

TEST(Ahrs, AFieldCannotTiltTheHorizon) {
    const AhrsModel model(settings());
    State right = state_at_start(model);
    const Turning motion;
    follow(model, right, motion, 2.0);
    State wrong = right;
    // The samples of one correction; for one of two twins the field is turned by 2 deg about north, within the gate.
    const std::uint64_t before = right.corrections;
    for (int k = 1; right.corrections == before; ++k) {
        const double t_s = 2 + 0.005 * k;
        for (State* state : {&right, &wrong}) {
            Event e = motion.event(t_s, false);
            const Matrix3 R = rotation_matrix(motion.q(t_s));
            const Matrix3 turned =
                state == &wrong ? rotation_matrix(rotation_quaternion({2 * deg, 0, 0})) : Matrix3(Matrix3::Identity());
            const Vector3 field = R.transpose() * turned * R * motion.field_b(t_s);
            e.add(Sample{t_s, mag, {field[0], field[1], field[2]}});
            model.before_flow(*state, e);
            model.flow_exactly(*state, 0.005);
            model.jump(*state, e);
        }
    }
    EXPECT_EQ(wrong.verdict, 0u);
    const auto down_in_body = [](const State& s) { return Vector3(rotation_matrix(Quaternion(s.x)).row(2)); };
    EXPECT_GT(angle_between(Quaternion(right.x), Quaternion(wrong.x)), 1e-4); // the heading follows
    EXPECT_LT((down_in_body(right) - down_in_body(wrong)).norm(), 1e-7);      // the horizon does not
}

TEST(Ahrs, AnIntegratorOutsideComesToTheSameStateAsTheOneInside) {
    // Backward hold: the external integrator uses the previous rate, the jump replaces it with the right one.
    const AhrsModel model(settings());
    State inside = state_at_start(model);
    Turning motion;
    follow(model, inside, motion, 0.02);
    State outside = inside;
    Event e = motion.event(0.025);
    for (int i = 0; i < 3; ++i) e.value[gyro][i] += 0.7 - i;
    model.before_flow(inside, e);
    model.flow_exactly(inside, 0.005);
    model.jump(inside, e);
    model.flow_exactly(outside, 0.005);
    model.rehold(outside, e, 0.005);
    model.jump(outside, e);
    EXPECT_LT((Eigen::Map<Vector14>(inside.x) - Eigen::Map<Vector14>(outside.x)).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Ahrs, AnInnovationIsToldWithItsCovarianceAndItsNormalisedSquare) {
    const AhrsModel model(settings());
    State s = state_at_start(model);
    Turning motion;
    motion.bias = {0.01, -0.006, 0.004};
    follow(model, s, motion, 5);
    Event e = motion.event(5.005);
    e.add(Sample{5.005, heading, {roll_pitch_yaw(motion.q(5.005))[2] + 0.02, 0.03}});
    take(model, s, e, 0.005);
    for (const int channel : {accel, mag, heading}) {
        const Innovation& i = s.innovation[channel];
        const int n = static_cast<int>(i.dimension);
        const Matrix3 whole(i.S);
        const Eigen::MatrixXd S = whole.topLeftCorner(n, n);
        const Eigen::VectorXd nu = Vector3(i.value).head(n);
        EXPECT_EQ(i.t_s, 5.005);
        EXPECT_GT(i.nis, 0) << channel;
        EXPECT_NEAR(nu.dot(S.inverse() * nu), i.nis, 1e-9 * i.nis) << channel;
        EXPECT_LT((S - S.transpose()).norm(), 1e-12 * S.norm()) << channel;
    }
}

TEST(Ahrs, AHeadingBeyondItsGateCountsAsMuchLessAsItLiesFurtherOutside) {
    hnav_ahrs_options set = settings();
    set.heading_gate_nis = 4;
    const AhrsModel model(set);
    State s = state_at_start(model);
    const Turning motion;
    follow(model, s, motion, 20);
    ASSERT_TRUE(model.estimate(s).heading_ready);
    const double sigma = 2 * deg;
    Event e = motion.event(20.005);
    e.add(Sample{20.005, heading, {roll_pitch_yaw(motion.q(20.005))[2] + 20 * deg, sigma}});
    take(model, s, e, 0.005);
    const Innovation& i = s.innovation[heading];
    EXPECT_EQ(s.gated[heading], 1u);
    const double noise = sigma * sigma, of_state = i.S[0] - noise;
    // With the noise of the filter it is at the gate.
    EXPECT_NEAR(i.value[0] * i.value[0] / (of_state + i.noise_scale * noise), 4, 1e-9);
}

TEST(Ahrs, AtRestTheMeanRateIsTheBiasWhateverForceSays) {
    hnav_ahrs_options set = settings();
    set.rest_bias_noise_rad_s_per_sqrt_hz = 1e-10;
    set.start_mode = HNAV_START_ATTITUDE;
    const AhrsModel model(set);
    State s = state_at_start(model);
    const Vector3 bias(0.01, -0.02, 0.015);
    for (int k = 0; k <= 6000; ++k) {
        const double t_s = 0.005 * k;
        Event e{};
        e.t_s = t_s;
        e.add(Sample{t_s, gyro, {bias[0], bias[1], bias[2]}});
        // A constant force that is no tilt: the velocity that it would leave contradicts a bias.
        e.add(Sample{t_s, accel, {t_s > 3 ? 0.3 : 0, t_s > 3 ? -0.2 : 0, -AhrsModel::gravity_m_s2}});
        model.before_flow(s, e);
        if (k > 0) model.flow_exactly(s, 0.005);
        const std::uint64_t before = s.corrections;
        model.jump(s, e);
        if (t_s < set.rest_duration_s || t_s > set.rest_duration_s + 0.1) {
            EXPECT_EQ(s.rest.at_rest(set), t_s > set.rest_duration_s) << t_s;
        }
        // The variance of the mean rate, which may be a turn, decays while the rate stays the same.
        if (s.corrections > before && s.rest.at_rest(set) && t_s > 25) {
            ASSERT_LT((Vector3(s.bias) - Vector3(s.rest.mean_rate)).norm(), 0.02 * bias.norm()) << t_s;
        }
    }
    EXPECT_TRUE(model.field_estimate(s).at_rest);
}

// At rest for a while, with a force of this length in the direction of gravity.
State rested(const AhrsModel& model, double force_m_s2, double duration_s) {
    Turning still;
    still.rate_b.setZero();
    State s = state_at_start(model);
    for (int k = 0; k <= std::lround(duration_s * 200); ++k) {
        AttitudeEvent e = still.event(0.005 * k);
        for (int i = 0; i < 3; ++i) e.value[accel][i] *= force_m_s2 / AhrsModel::gravity_m_s2;
        take(model, s, e, k > 0 ? 0.005 : 0);
    }
    return s;
}

// Gravity was removed, or the force has another unit.
TEST(Ahrs, AtRestWithoutGravityNothingIsReady) {
    const AhrsModel model(settings());
    for (const double strength : {0.02, 1.0, 9.7, 9.9, 20.0}) {
        const State s = rested(model, strength, 30);
        const bool is_gravity = std::fabs(strength - 9.8) < 1;
        EXPECT_EQ(model.estimate(s).tilt_ready, is_gravity) << strength;
        EXPECT_EQ(model.estimate(s).heading_ready, is_gravity) << strength;
    }
}

// The robust law widens what the force observes, and no more: not the tilt that a bias of the accelerometer cancels.
TEST(Ahrs, AtRestTheTiltIsAsUncertainAsTheBiasOfTheAccelerometerMakesIt) {
    hnav_ahrs_options set = settings();
    set.start_sigma_accel_bias_m_s2 = 0.5;
    set.gamma_mode = HNAV_GAMMA_RELATIVE;
    set.gamma_relative_rate_1_s = 0.3;
    const State s = rested(AhrsModel(set), AhrsModel::gravity_m_s2, 60);
    const double by_bias = AhrsModel::gravity_m_s2 / set.start_sigma_accel_bias_m_s2, by_start = 1 / set.start_sigma_tilt_rad;
    const double expected = 1 / std::hypot(by_bias, by_start);
    EXPECT_NEAR(std::sqrt(s.P[AhrsModel::packed(AhrsModel::rotation, AhrsModel::rotation)]), expected, 0.02 * expected);
}

// The length of the force shows the error along the vertical; the others may be as large.
TEST(Ahrs, AForceAtRestThatIsLongerThanGravityMakesTheHorizonLessCertain) {
    const AhrsModel model(settings());
    const double g = AhrsModel::gravity_m_s2, tangent = std::sqrt(3.0); // of the dip
    const auto variances = [&](double bias) { return model.rotation_variances(rested(model, g + bias, 10)); };
    const Vector3 added = variances(-0.3) - variances(0);
    const double unstated2 = (square(0.3) - 4 * (square(settings().start_sigma_accel_bias_m_s2) + square(0.02))) / (g * g);
    EXPECT_NEAR(added[0], unstated2, 0.01 * unstated2);
    EXPECT_NEAR(added[1], unstated2, 0.01 * unstated2);
    EXPECT_NEAR(added[2], unstated2 * (1 + square(tangent)), 0.02 * added[2]);
    EXPECT_NEAR((variances(0.03) - variances(0)).norm(), 0, 0.01 * unstated2);
}

// A slow turn and a step of the bias look the same to the gyroscope and to the force; the field distinguishes them.
TEST(Ahrs, AtRestAStepOfTheBiasIsLearntAndASlowTurnIsNot) {
    const AhrsModel model(settings());
    constexpr double deg = M_PI / 180;
    for (const Vector3& step : {Vector3(0.3, 0, 0), Vector3(0.2, -0.3, 0.4), Vector3(0, 0, -1)}) {
        for (const bool turns : {false, true}) {
            Turning still;
            still.rate_b.setZero();
            State s = state_at_start(model);
            follow(model, s, still, 30);
            Turning then = still;
            (turns ? then.rate_b : then.bias) = step * deg;
            follow(model, s, then, 10, 30.005);
            EXPECT_LT((Vector3(s.bias) - then.bias).norm(), 0.1 * deg) << step.transpose() << turns;
            if (turns) continue;
            const double off = angle_between(Quaternion(s.x), still.q(0));
            EXPECT_LT(off, 1.5 * deg) << step.transpose();
            EXPECT_LT(off, 3 * std::sqrt(s.P[AhrsModel::packed(AhrsModel::rotation + 2, AhrsModel::rotation + 2)]));
        }
    }
}

TEST(Ahrs, WhatItTellsOfItsCovarianceAgrees) {
    const AhrsModel model(settings());
    State s = state_at_start(model);
    follow(model, s, Turning{}, 5.01);
    const ErrorCovariance C = model.error_covariance(s);
    EXPECT_LT((C - C.transpose()).norm(), 1e-15);
    EXPECT_LT((model.bias_variances(s) - C.diagonal().tail<3>()).norm(), 1e-18);
    EXPECT_LT((model.rotation_covariance(s) - C.topLeftCorner<3, 3>()).norm(), 1e-18);
    EXPECT_GT(C.topRightCorner(3, 3).norm(), 0);
    // Before the start attitude and bias are not correlated.
    const State fresh = state_at_start(model);
    const ErrorCovariance first = model.error_covariance(fresh);
    EXPECT_EQ(first.topRightCorner(3, 3).norm(), 0);
    EXPECT_EQ(first.bottomLeftCorner(3, 3).norm(), 0);
    double S[9], sigma[9];
    model.gyro_calibration(fresh, S, sigma);
    for (int i = 0; i < 9; ++i)
        EXPECT_NEAR(sigma[i], i % 4 ? settings().start_sigma_gyro_misalignment_rad : settings().start_sigma_gyro_scale, 1e-12)
            << i;
}

TEST(Ahrs, TheCovarianceShownAfterAnEventIsThatOfAnEventThere) {
    const AhrsModel model(settings());
    State s = state_at_start(model);
    const Turning motion;
    follow(model, s, motion, 5.01);
    State shown = s, gathered = s;
    model.flow_exactly(shown, 0.005);
    Event e{};
    e.t_s = 5.015;
    e.add(Sample{e.t_s, gyro, {motion.rate_b[0], motion.rate_b[1], motion.rate_b[2]}});
    model.before_flow(gathered, e);
    model.flow_exactly(gathered, 0.005);
    model.jump(gathered, e);
    ASSERT_EQ(gathered.corrections, s.corrections);
    const ErrorCovariance there = model.error_covariance(gathered), here = model.error_covariance(shown);
    EXPECT_LT((there - here).norm(), 1e-9 * here.norm());
    EXPECT_GT((here - model.error_covariance(s)).norm(), 1e-6 * here.norm());
}

TEST(Ahrs, TheTiltIsReadyWhenBothOfItsAnglesAre) {
    const AhrsModel model(settings());
    State ready = state_at_start(model);
    follow(model, ready, Turning{}, 10);
    ASSERT_TRUE(model.estimate(ready).tilt_ready);
    for (int angle = AhrsErrors::rotation; angle < AhrsErrors::rotation + 2; ++angle) {
        State s = ready;
        s.P[AhrsErrors::packed(angle, angle)] = 1;
        EXPECT_FALSE(model.estimate(s).tilt_ready) << angle;
    }
}

TEST(Ahrs, TheLengthOfAQuaternionIsRestoredWhenItIsFarFromOne) {
    const AhrsModel model(settings());
    State s = state_at_start(model);
    const Quaternion q = Quaternion(1, 2, -3, 4).normalized();
    for (const double length : {0.3, 0.8, 1.5, 3.0}) {
        Eigen::Map<Quaternion>(s.x) = length * q;
        model.normalise(s);
        EXPECT_NEAR(Quaternion(s.x).norm(), length > 0.5 && length < 2 ? length : 1, 1e-15) << length;
        EXPECT_LT((Quaternion(s.x).normalized() - q).norm(), 1e-15);
    }
}

// After 20 s, certain of a horizon that is 40 deg off.
State with_wrong_horizon(const AhrsModel& model, const Turning& motion) {
    State s = state_at_start(model);
    follow(model, s, motion, 20);
    EXPECT_TRUE(model.estimate(s).tilt_ready && model.estimate(s).heading_ready);
    Eigen::Map<Quaternion> q(s.x);
    q = multiply<double>(rotation_quaternion<double>({0.6, -0.4, 0}), Quaternion(q));
    return s;
}

TEST(Ahrs, AForceThatSpeaksAgainstTheHorizonLevelsItAnew) {
    hnav_ahrs_options set = settings();
    set.lost_ratio = 12;
    const AhrsModel model(set);
    const Turning motion;
    State s = with_wrong_horizon(model, motion);
    double t_s = 20;
    for (; s.times_lost == 0 && t_s < 30; t_s += 0.05)
        for (int k = 1; k <= 10; ++k) take(model, s, motion.event(t_s + 0.005 * k), 0.005);
    EXPECT_LT(t_s, 28);
    EXPECT_EQ(s.times_lost, 1u);
    EXPECT_EQ(s.lost, 0u);
    EXPECT_FALSE(model.estimate(s).tilt_ready || model.estimate(s).heading_ready);
    const Vector3 down = rotation_matrix(Quaternion(s.x)).transpose() * Vector3(0, 0, 1);
    const Vector3 true_down = rotation_matrix(motion.q(t_s)).transpose() * Vector3(0, 0, 1);
    EXPECT_LT(std::acos(std::fmin(1, down.dot(true_down))), 0.1);
}

TEST(Ahrs, AHorizonFromForcesUnderFaultyRatesIsUncertainByTheTurnThatTheyMissed) {
    hnav_ahrs_options set = settings();
    set.lost_ratio = 12;
    const AhrsModel model(set);
    const auto tilt_variance = [&](double lost_turn2) {
        const Turning motion;
        State s = with_wrong_horizon(model, motion);
        for (double t_s = 20.005; s.times_lost == 0 && t_s < 30; t_s += 0.005) {
            s.lasting.lost_turn2 = lost_turn2;
            take(model, s, motion.event(t_s), 0.005);
        }
        EXPECT_EQ(s.times_lost, 1u);
        EXPECT_EQ(s.lasting.lost_turn2, 0);
        return s.P[AhrsErrors::packed(AhrsErrors::rotation, AhrsErrors::rotation)];
    };
    EXPECT_NEAR(tilt_variance(0.3) - tilt_variance(0), 0.1, 1e-3);
    EXPECT_NEAR(tilt_variance(100), 1, 1e-3); // of any tilt
}

TEST(Ahrs, AClockThatWasSetMakesEveryAngleLessCertain) {
    const AhrsModel model(settings());
    State plain = state_at_start(model);
    const Turning motion;
    follow(model, plain, motion, 5);
    plain.last_correction_s = 4; // the event corrects
    State jumped = plain;
    Event e{};
    e.t_s = 5.001;
    e.add(Sample{5.001, gyro, {motion.rate_b[0], motion.rate_b[1], motion.rate_b[2]}});
    model.jump(plain, e);
    e.present |= new_time_base;
    model.jump(jumped, e);
    const Square<AhrsErrors::errors> added =
        unpack_columns<AhrsErrors::errors>(jumped.P) - unpack_columns<AhrsErrors::errors>(plain.P);
    const Vector3 variances(0.1 * 0.1, 0.1 * 0.1, 0.2 * 0.2);
    for (int i = 0; i < 3; ++i) {
        const double share = added(AhrsErrors::rotation + i, AhrsErrors::rotation + i) / variances[i];
        EXPECT_GT(share, 0.5) << i; // the correction removes some of it
        EXPECT_LT(share, 1) << i;
    }
    EXPECT_EQ(jumped.repaired, 0u);
}

TEST(Ahrs, AnAxisThatIsStuckIsFoundAfterAQuarterOfASecondAndWhatWasEarnedIsGone) {
    hnav_ahrs_options set = settings();
    const AhrsModel model(set);
    State s = state_at_start(model);
    const Turning motion;
    test::Random random(9);
    double found_s = 0;
    for (int k = 0; k <= 2200 && found_s == 0; ++k) {
        const double t_s = 0.005 * k;
        Event e = motion.event(t_s);
        const Vector3 rate = motion.rate_b + random.vector(0.003);
        e.add(Sample{t_s, gyro, {rate[0], rate[1], k >= 2000 ? 0.8 : rate[2]}});
        e.add(Sample{t_s, accel, {k % 2 ? 9.0 : -9.0, 0, -9}}); // it is shaken
        const double before = s.information.tilt;
        model.before_flow(s, e);
        if (s.check[gyro].fault == SensorFault::stuck) {
            found_s = t_s;
            EXPECT_GT(before, 0);
            EXPECT_EQ(s.information.tilt, 0);
            EXPECT_EQ(s.information.heading, 0);
        }
        if (model.flows(s) && k > 0) model.flow_exactly(s, 0.005);
        model.jump(s, e);
    }
    EXPECT_GT(found_s, 10.24);
    EXPECT_LT(found_s, 10.5);
}

// From event to event the filter neither copies the slow part of its state nor recomputes the rotation: both must be marked
// as changed. Samples start and stop, an axis sticks, the field changes, a clock is set.
TEST(Ahrs, WhatSeldomChangesIsCountedAndWhatTurnsTheBodyIsUpToDate) {
    hnav_ahrs_options set = settings();
    set.outlier_rate_rad_s = 0.5;
    set.gamma_mode = HNAV_GAMMA_RELATIVE;
    set.gamma_relative_rate_1_s = 1;
    const AhrsModel model(set);
    State s = state_at_start(model);
    const Turning motion;
    test::Random random(4);
    int unchanged = 0, t_ms = 0;
    for (int k = 0; k < 6000; ++k) {
        t_ms += k == 4500 ? 30000 : k % 700 == 699 ? 400 : 5;
        Event e = motion.event(1e-3 * t_ms, false);
        const Vector3 rate = motion.rate_b + random.vector(0.003);
        const bool sticks = k > 2500 && k < 2700;
        e.add(Sample{e.t_s, gyro, {rate[0], rate[1], sticks ? 0.8 : rate[2]}});
        if (k % 3) e.add(Sample{e.t_s, mag, {k < 3000 ? 2.5e-5 : 1.2e-5, k % 7 * 1e-6, 4e-5}});
        if (k % 1000 == 5) e.add(Sample{e.t_s, heading, {0.3, 0.1, 0}});
        if (k == 3500) e.present |= new_time_base;
        const State before = s;
        take(model, s, e, k > 0 ? e.t_s - before.last_event_s : 0);

        const auto* const was = reinterpret_cast<const unsigned char*>(&before) + AhrsModel::seldom_begin;
        const auto* const is = reinterpret_cast<const unsigned char*>(&s) + AhrsModel::seldom_begin;
        const bool same = std::memcmp(was, is, AhrsModel::seldom_bytes) == 0;
        ASSERT_EQ(same, AhrsModel::seldom_changes(before) == AhrsModel::seldom_changes(s)) << k;
        unchanged += same;
        State again = s;
        model.note_turning(again);
        ASSERT_EQ(std::memcmp(again.turning, s.turning, sizeof s.turning), 0) << k;
    }
    EXPECT_GT(unchanged, 3000);
    EXPECT_GT(s.times_lost, 0u);
    EXPECT_GT(s.check[gyro].stuck, 0u);
    State turned = s;
    model.turn_back(turned, 0);
    State again = turned;
    model.note_turning(again);
    EXPECT_EQ(std::memcmp(again.turning, turned.turning, sizeof s.turning), 0);
    EXPECT_NE(std::memcmp(s.turning, turned.turning, sizeof s.turning), 0);
}

TEST(Ahrs, AHeadingThatAFalseFieldGaveTurnsWithTheTrueOneAndIsLessCertain) {
    const AhrsModel model(settings());
    State s = state_at_start(model);
    const Turning motion;
    bool turned = false;
    for (int k = 0; k <= 8000; ++k) {
        const double t_s = 0.005 * k;
        Event e = motion.event(t_s, false);
        const Vector3 field_n = t_s < 4 ? Vector3(1.5e-5, 2.6e-5, 6e-5) : Vector3(2.5e-5, 0, 4.33e-5);
        const Vector3 field = rotation_matrix(motion.q(t_s)).transpose() * field_n;
        e.add(Sample{t_s, mag, {field[0], field[1], field[2]}});
        const State before = s;
        take(model, s, e, k > 0 ? 0.005 : 0);
        if (s.field.changes > before.field.changes) {
            turned = true;
            EXPECT_GT(model.rotation_covariance(s)(2, 2), 0.5 * settings().turn_sigma_rad * settings().turn_sigma_rad);
            EXPECT_FALSE(model.estimate(s).heading_ready);
        }
    }
    EXPECT_TRUE(turned);
    EXPECT_EQ(s.repaired, 0u);
    EXPECT_LT(angle_between(Quaternion(s.x), motion.q(40)), 3 * deg);
}

// A start within an acceleration has a wrong vertical, and takes heading and dip of the field from it.
TEST(Ahrs, TheHeadingAndTheReferenceOfTheFirstFieldHaveTheErrorOfTheHorizonThatTheyWereFoundWith) {
    for (const bool given : {false, true}) {
        auto options = settings();
        options.reference_mode = given ? HNAV_REFERENCE_GIVEN : HNAV_REFERENCE_LEARNT;
        const Vector2 M(0.5, std::sqrt(0.75));
        options.reference_strength_tesla = 5e-5;
        options.reference_dip_rad = std::atan2(M[1], M[0]);
        const AhrsModel model(options);
        for (const Vector2& accelerated : {Vector2(0.01, 0), Vector2(0, 0.01), Vector2(-0.007, 0.004)}) { // in units of gravity
            State s = state_at_start(model);
            const Quaternion q = Turning{}.start_q;
            const Matrix3 to_body = rotation_matrix(q).transpose();
            const Vector3 force = AhrsModel::gravity_m_s2 * to_body * Vector3(accelerated[0], accelerated[1], -1);
            const Vector3 field = 5e-5 * to_body * Vector3(M[0], 0, M[1]);
            Event e{};
            e.add(Sample{0, accel, {force[0], force[1], force[2]}});
            e.add(Sample{0, mag, {field[0], field[1], field[2]}});
            model.jump(s, e);
            ASSERT_TRUE(s.started);

            constexpr int tilt = AhrsModel::rotation, heading = tilt + 2, first = AhrsModel::reference;
            const Matrix3 apart = rotation_matrix(q) * rotation_matrix(Quaternion(s.x)).transpose();
            const Vector3 error(apart(2, 1), apart(0, 2), apart(1, 0)); // of small angles
            const double of_tilt2 = options.start_sigma_tilt_rad * options.start_sigma_tilt_rad;
            const auto expected = [&](int row) {
                return (s.P[AhrsModel::packed(tilt, row)] * error[0] + s.P[AhrsModel::packed(tilt + 1, row)] * error[1]) /
                       of_tilt2;
            };
            EXPECT_NEAR(expected(heading), error[2], 3e-4);
            EXPECT_GT(std::fabs(error[2]) + std::fabs(accelerated[0]), 0.008);
            for (int i = 0; i < 2; ++i) EXPECT_NEAR(expected(first + i), given ? 0 : M[i] - s.reference[i], 3e-4);
        }
    }
}

TEST(Ahrs, AHeadingThatIsFarOffIsNoMeasurementOfTheGyroBias) {
    const AhrsModel model(settings());
    const auto bias_after_turn = [&](double turned_rad) {
        State s = state_at_start(model);
        model.before_flow(s, Turning{}.event(0));
        model.jump(s, Turning{}.event(0));
        constexpr int heading = AhrsModel::rotation + 2, bias = AhrsModel::bias + 2;
        double& variance = s.P[AhrsModel::packed(heading, heading)];
        variance = 1;
        s.P[AhrsModel::packed(heading, bias)] = 0.9 * std::sqrt(s.P[AhrsModel::packed(bias, bias)]);
        Event e = Turning{}.event(0.04, false);
        const Vector3 field_n = rotation_matrix(rotation_quaternion({0, 0, turned_rad})) * Vector3(2.5e-5, 0, 4.33e-5);
        const Vector3 field = rotation_matrix(Turning{}.q(0.04)).transpose() * field_n;
        e.add(Sample{0.04, mag, {field[0], field[1], field[2]}});
        take(model, s, e, 0.04);
        EXPECT_LT(variance, 0.1);
        const Vector3 seen = rotation_matrix(Quaternion(s.x)) * field;
        EXPECT_LT(std::fabs(std::atan2(seen[1], seen[0])), 0.1 * turned_rad);
        return std::fabs(s.bias[2]);
    };
    EXPECT_LT(bias_after_turn(2.5), bias_after_turn(0.4));
}

TEST(Ahrs, AHeadingThatIsFarOffForLongIsNoLessCertainThanAnyAngle) {
    const AhrsModel model(settings());
    const Turning motion;
    State s = state_at_start(model);
    follow(model, s, motion, 10);
    s.P[AhrsModel::packed(AhrsModel::rotation + 2, AhrsModel::rotation + 2)] = 1;
    std::uint64_t rejected = 0;
    for (int k = 1; k <= 400; ++k) {
        const double t_s = 10 + 0.005 * k;
        Event e = motion.event(t_s, false);
        const Vector3 field =
            rotation_matrix(motion.q(t_s)).transpose() * Vector3(-2.5e-5, 1e-5, 7e-5); // rejected: far too strong
        e.add(Sample{t_s, mag, {field[0], field[1], field[2]}});
        take(model, s, e, 0.005);
        rejected += FieldVerdict(s.verdict) == FieldVerdict::reject;
        EXPECT_LT(s.P[AhrsModel::packed(AhrsModel::rotation + 2, AhrsModel::rotation + 2)], 1.01 * any_angle_variance<double>);
    }
    EXPECT_GT(rejected, 100u);
}

TEST(MagneticReference, AnotherFieldWinsByEvidenceAndALongTrustedHeadingStays) {
    const hnav_ahrs_options set = settings();
    for (const bool trusted : {false, true}) {
        MagneticReference<double> m{};
        const MeanField<double> first{{0.5, 0, 0.8}}, second{{0.5 * std::cos(0.4), 0.5 * std::sin(0.4), 0.5}};
        for (int k = 0; k < (trusted ? 70 : 1) * 28; ++k) m.weigh(set, first, 0.5, 0.8, true, 1 / 28.0);
        EXPECT_FALSE(m.candidate_wins(set));
        int until = 0;
        while (!m.candidate_wins(set) && until < 100 * 28) {
            m.weigh(set, second, 0.5, 0.8, true, 1 / 28.0);
            ++until;
        }
        const double needed_s = trusted ? 0.4 * 70 : 1.6;
        EXPECT_NEAR(until / 28.0, needed_s, 0.2);
        EXPECT_NEAR(m.distrust(set, 1e-4), trusted ? 0 : 1 - 1 / 60.0, 0.02);
        EXPECT_NEAR(m.candidate_horizontal(), 0.5, 1e-3);
        EXPECT_NEAR(m.candidate_azimuth_rad(), 0.4, 1e-3);
    }
}

TEST(MagneticReference, RejectsForATimeThatGrowsWithService) {
    const hnav_ahrs_options set = settings();
    MagneticReference<double> m{};
    EXPECT_EQ(m.judge(set, 0.1, 0.1), FieldVerdict::begin_inflating); // has never served
    EXPECT_EQ(m.judge(set, 0.1, 0.1), FieldVerdict::inflate);
    for (int k = 0; k < 100; ++k) EXPECT_EQ(m.judge(set, 0.01, 0.1), FieldVerdict::accept);
    int rejected = 0;
    while (m.judge(set, 0.1, 0.1) == FieldVerdict::reject) ++rejected;
    EXPECT_NEAR(0.1 * rejected, 30, 0.2); // three times ten seconds
}

TEST(RestDetector, KnowsRestFromSteadyTurningAndFromShaking) {
    const hnav_ahrs_options set = settings();
    const auto ends_at_rest = [&](const Vector3& rate, double shake) {
        RestDetector<double> rest;
        rest.clear(rate, {0, 0, -9.8});
        for (int k = 0; k < 400; ++k) {
            rest.note_rate(set, rate, 0.01);
            rest.note_force(set, {shake * (k % 2 ? 1 : -1), 0, -9.8}, 0.01);
        }
        return rest.at_rest(set);
    };
    EXPECT_TRUE(ends_at_rest({0.01, -0.02, 0.03}, 0.1));
    EXPECT_FALSE(ends_at_rest({0, 0, 0.1}, 0.1));
    EXPECT_FALSE(ends_at_rest({0, 0, 0}, 1));
}

TEST(RestDetector, RestBeginsAnewAfterEveryMovement) {
    const hnav_ahrs_options set = settings();
    RestDetector<double> rest;
    rest.clear(Vector3::Zero(), {0, 0, -9.8});
    rest.note_force(set, {0, 0, -9.8}, 0.01);
    for (int k = 0; k < 400; ++k) rest.note_rate(set, Vector3::Zero(), 0.01);
    EXPECT_TRUE(rest.at_rest(set));
    for (int k = 0; k < 400; ++k) rest.note_rate(set, {k % 2 ? 0.1 : -0.1, 0, 0}, 0.01); // it trembles
    EXPECT_FALSE(rest.at_rest(set));
    EXPECT_EQ(rest.still_s, 0);
}

// ------------------------------------------------------------------------------------------------ through the C API

namespace {

using Handle = std::unique_ptr<hnav_filter, decltype(&hnav_filter_destroy)>;

Handle make(const hnav_ahrs_options& options) {
    hnav_filter* filter = nullptr;
    char message[256];
    EXPECT_EQ(hnav_ahrs_create(&filter, &options, message, sizeof message), HNAV_OK) << message;
    return {filter, hnav_filter_destroy};
}

void push(hnav_filter* f, const Turning& m, double t_s, bool with_mag) {
    const Vector3 rate = m.rate_b + m.bias, force = m.force_b(t_s), field = m.field_b(t_s);
    ASSERT_EQ(hnav_filter_push_imu(f, t_s, rate.data(), force.data()), HNAV_OK);
    if (with_mag) {
        ASSERT_EQ(hnav_filter_push_mag(f, t_s, field.data()), HNAV_OK);
    }
}

} // namespace

TEST(AhrsApi, WithoutAMagnetometerItStartsLevelAndItsHeadingSigmaGrows) {
    const Handle f = make(hnav_ahrs_defaults(HNAV_PRESET_DEFAULT));
    Turning motion; // about the vertical, which leaves the bias unobservable; faster than vehicles turn
    motion.rate_b = rotation_matrix(motion.start_q).transpose() * Vector3(0, 0, 0.6);
    auto a = hnav_sized<hnav_attitude>();
    double sigma_10 = 0;
    for (int k = 0; k <= 12000; ++k) {
        const double t_s = 0.005 * k;
        push(f.get(), motion, t_s, false);
        ASSERT_EQ(hnav_filter_advance(f.get(), t_s), HNAV_OK);
        if (k == 100) {
            EXPECT_EQ(hnav_filter_attitude(f.get(), &a), HNAV_ERROR_NOT_STARTED);
        }
        if (k == 2000) {
            ASSERT_EQ(hnav_filter_attitude(f.get(), &a), HNAV_OK);
            sigma_10 = a.sigma_rad[2];
        }
    }
    ASSERT_EQ(hnav_filter_attitude(f.get(), &a), HNAV_OK);
    EXPECT_TRUE(a.tilt_ready);
    EXPECT_FALSE(a.heading_ready);
    EXPECT_GT(sigma_10, 1.8); // any heading
    EXPECT_GT(a.sigma_rad[2], sigma_10 + 0.02);
    const Vector3 truth = roll_pitch_yaw(motion.q(60));
    EXPECT_NEAR(a.euler_rad[0], truth[0], 0.5 * deg);
    EXPECT_NEAR(a.euler_rad[1], truth[1], 0.5 * deg);

    // Confirmed by a heading aid, without a field.
    for (int k = 12001; k <= 12400; ++k) {
        const double t_s = 0.005 * k;
        push(f.get(), motion, t_s, false);
        if (k % 40 == 0) {
            ASSERT_EQ(hnav_filter_push_heading(f.get(), t_s, roll_pitch_yaw(motion.q(t_s))[2], 1 * deg), HNAV_OK);
        }
        ASSERT_EQ(hnav_filter_advance(f.get(), t_s), HNAV_OK);
    }
    ASSERT_EQ(hnav_filter_attitude(f.get(), &a), HNAV_OK);
    EXPECT_LT(std::fabs(wrap_angle(a.heading_rad - roll_pitch_yaw(motion.q(62))[2])), 1 * deg);
    EXPECT_TRUE(a.heading_ready);
}

TEST(AhrsApi, AMagnetometerThatComesLateTurnsTheHeading) {
    const Handle f = make(hnav_ahrs_defaults(HNAV_PRESET_DEFAULT));
    const Turning motion;
    for (int k = 0; k <= 4000; ++k) {
        push(f.get(), motion, 0.005 * k, k > 1000);
        ASSERT_EQ(hnav_filter_advance(f.get(), 0.005 * k), HNAV_OK);
    }
    auto a = hnav_sized<hnav_attitude>();
    ASSERT_EQ(hnav_filter_attitude(f.get(), &a), HNAV_OK);
    EXPECT_LT(angle_between(Quaternion(a.q_nb), motion.q(20)), 1 * deg);
    EXPECT_TRUE(a.heading_ready);
    auto field = hnav_sized<hnav_field>();
    ASSERT_EQ(hnav_filter_field(f.get(), &field), HNAV_OK);
    EXPECT_NEAR(field.strength_tesla, 5e-5, 1e-6);
    EXPECT_NEAR(field.dip_rad, 60 * deg, 1 * deg);
}

TEST(AhrsApi, EachSensorMayHaveItsOwnRateAndTimes) {
    const Handle f = make(hnav_ahrs_defaults(HNAV_PRESET_DEFAULT));
    const Turning motion;
    // Gyroscope at 400 Hz, accelerometer at 100 Hz shifted by half a sample, magnetometer at 25 Hz: no two at the same time.
    for (int k = 0; k < 12000; ++k) {
        const double t_s = 0.0025 * k;
        const Vector3 rate = motion.rate_b;
        ASSERT_EQ(hnav_filter_push_gyro(f.get(), t_s, rate.data()), HNAV_OK);
        if (k % 4 == 1) {
            ASSERT_EQ(hnav_filter_push_accel(f.get(), t_s + 0.001, motion.force_b(t_s + 0.001).data()), HNAV_OK);
        }
        if (k % 16 == 5) {
            ASSERT_EQ(hnav_filter_push_mag(f.get(), t_s + 0.0005, motion.field_b(t_s + 0.0005).data()), HNAV_OK);
        }
        if (k % 7 == 0) {
            ASSERT_EQ(hnav_filter_advance(f.get(), t_s), HNAV_OK);
        }
    }
    ASSERT_EQ(hnav_filter_advance(f.get(), 30), HNAV_OK);
    auto a = hnav_sized<hnav_attitude>();
    ASSERT_EQ(hnav_filter_attitude(f.get(), &a), HNAV_OK);
    EXPECT_LT(angle_between(Quaternion(a.q_nb), motion.q(30)), 0.3 * deg);
    EXPECT_TRUE(a.heading_ready);
}

TEST(AhrsApi, SaveWreckLoadGoesOnBitForBitAndLateSamplesGiveTheSameBits) {
    hnav_ahrs_options options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    options.horizon_s = 0.1;
    const Handle one = make(options), other = make(options);
    const Turning motion;
    std::size_t bytes = 0;
    ASSERT_EQ(hnav_filter_state_size(one.get(), &bytes), HNAV_OK);
    std::vector<unsigned char> state(bytes);
    const auto delayed_field = [&](hnav_filter* f, int k, int delay) {
        if (k < delay || (k - delay) % 4) return;
        const double t_s = 0.01 * (k - delay);
        ASSERT_EQ(hnav_filter_push_mag(f, t_s, motion.field_b(t_s).data()), HNAV_OK);
    };
    for (int k = 0; k <= 600; ++k) {
        const double t_s = 0.01 * k;
        push(one.get(), motion, t_s, k % 4 == 0);
        push(other.get(), motion, t_s, false);
        delayed_field(other.get(), k, 4);
        ASSERT_EQ(hnav_filter_advance(one.get(), t_s), HNAV_OK);
        ASSERT_EQ(hnav_filter_advance(other.get(), t_s), HNAV_OK);
        if (k == 300) {
            ASSERT_EQ(hnav_filter_save(other.get(), state.data(), bytes), HNAV_OK);
            ASSERT_EQ(hnav_filter_reset(other.get()), HNAV_OK);
            ASSERT_EQ(hnav_filter_load(other.get(), state.data(), bytes), HNAV_OK);
        }
    }
    ASSERT_EQ(hnav_filter_push_mag(other.get(), 6.0, motion.field_b(6.0).data()), HNAV_OK);
    for (hnav_filter* f : {one.get(), other.get()}) ASSERT_EQ(hnav_filter_advance(f, 6.005), HNAV_OK);
    auto a = hnav_sized<hnav_attitude>(), b = a;
    ASSERT_EQ(hnav_filter_attitude(one.get(), &a), HNAV_OK);
    ASSERT_EQ(hnav_filter_attitude(other.get(), &b), HNAV_OK);
    EXPECT_EQ(std::memcmp(a.q_nb, b.q_nb, sizeof a.q_nb), 0);
    EXPECT_EQ(std::memcmp(a.sigma_rad, b.sigma_rad, sizeof a.sigma_rad), 0);
}

TEST(AhrsApi, WhatAnEventLeavesAloneIsThatOfTheEventBeforeWhateverChangedIt) {
    // One filter continues; the other is loaded after every row, so that its memory contains nothing of earlier events.
    const Handle one = make(hnav_ahrs_defaults(HNAV_PRESET_DEFAULT)), loaded = make(hnav_ahrs_defaults(HNAV_PRESET_DEFAULT));
    const Turning motion;
    std::size_t bytes = 0;
    ASSERT_EQ(hnav_filter_state_size(one.get(), &bytes), HNAV_OK);
    std::vector<unsigned char> there(bytes), here(bytes);
    auto health = hnav_sized<hnav_health>();
    for (int k = 0; k <= 1800; ++k) {
        if (k > 1200 && k < 1500) continue; // a gap
        const double t_s = 0.01 * k, stamp_s = t_s - (k >= 900 ? 5 : 0); // and a clock that is set back
        Vector3 rate = motion.rate_b + 0.01 * Vector3(std::sin(7 * k), std::sin(11 * k), std::sin(13 * k));
        if (k > 600 && k < 700) rate[1] = 0.3; // stuck
        for (hnav_filter* f : {one.get(), loaded.get()}) {
            ASSERT_EQ(hnav_filter_push_imu(f, stamp_s, rate.data(), motion.force_b(t_s).data()), HNAV_OK);
            if (k > 300) {
                ASSERT_EQ(hnav_filter_push_mag(f, stamp_s, motion.field_b(t_s).data()), HNAV_OK);
            }
            ASSERT_EQ(hnav_filter_advance(f, stamp_s), HNAV_OK);
        }
        ASSERT_EQ(hnav_filter_save(one.get(), here.data(), bytes), HNAV_OK);
        ASSERT_EQ(hnav_filter_save(loaded.get(), there.data(), bytes), HNAV_OK);
        ASSERT_EQ(std::memcmp(here.data(), there.data(), bytes), 0) << k;
        ASSERT_EQ(hnav_filter_load(loaded.get(), there.data(), bytes), HNAV_OK);
    }
    ASSERT_EQ(hnav_filter_health(one.get(), &health), HNAV_OK);
    EXPECT_GT(health.sensor[HNAV_SENSOR_GYRO].stuck, 0u);
    EXPECT_EQ(health.clock_jumps, 1u);
    EXPECT_GT(health.times_lost, 0u);
}

TEST(AhrsApi, RealignmentForgetsTheAttitudeAndKeepsWhatItLearntOfTheSensors) {
    const Handle f = make(hnav_ahrs_defaults(HNAV_PRESET_DEFAULT));
    Turning motion;
    motion.bias = {0.004, 0.002, -0.003};
    for (int k = 0; k <= 6000; ++k) {
        push(f.get(), motion, 0.005 * k, true);
        ASSERT_EQ(hnav_filter_advance(f.get(), 0.005 * k), HNAV_OK);
    }
    double bias[3], sigma[3], kept[3], kept_sigma[3];
    ASSERT_EQ(hnav_filter_gyro_bias(f.get(), bias, sigma), HNAV_OK);
    ASSERT_EQ(hnav_filter_realign(f.get()), HNAV_OK);
    auto a = hnav_sized<hnav_attitude>();
    EXPECT_EQ(hnav_filter_attitude(f.get(), &a), HNAV_ERROR_NOT_STARTED);
    ASSERT_EQ(hnav_filter_gyro_bias(f.get(), kept, kept_sigma), HNAV_OK);
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(bias[i], kept[i]);
        EXPECT_NEAR(sigma[i], kept_sigma[i], 1e-2 * sigma[i]);
    }
    for (const double t_s : {30.005, 30.01}) push(f.get(), motion, t_s, true);
    ASSERT_EQ(hnav_filter_advance(f.get(), 30.01), HNAV_OK);
    ASSERT_EQ(hnav_filter_attitude(f.get(), &a), HNAV_OK);
    EXPECT_FALSE(a.heading_ready);
    EXPECT_LT(angle_between(Quaternion(a.q_nb), motion.q(30.01)), 1 * deg);
    ASSERT_EQ(hnav_filter_gyro_bias(f.get(), kept, kept_sigma), HNAV_OK);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(sigma[i], kept_sigma[i], 1e-2 * sigma[i]);
}

TEST(AhrsApi, AStartNeedsSamplesThatAgreeUnderTheTurn) {
    Turning motion;
    motion.rate_b *= 3;
    const Vector3 weak(0.19, 0, 0), sideways(9.81, 0, 0), false_field(4e-5, -4e-5, 1e-5);
    for (const Vector3& first : {weak, sideways, Vector3(3 * sideways)}) {
        const Handle f = make(hnav_ahrs_defaults(HNAV_PRESET_DEFAULT));
        ASSERT_EQ(hnav_filter_push_imu(f.get(), 0, motion.rate_b.data(), first.data()), HNAV_OK);
        ASSERT_EQ(hnav_filter_push_mag(f.get(), 0, false_field.data()), HNAV_OK);
        auto a = hnav_sized<hnav_attitude>();
        for (const double t_s : {0.01, 0.02}) {
            push(f.get(), motion, t_s, true);
            ASSERT_EQ(hnav_filter_advance(f.get(), t_s), HNAV_OK);
            ASSERT_EQ(hnav_filter_attitude(f.get(), &a), t_s < 0.02 ? HNAV_ERROR_NOT_STARTED : HNAV_OK);
        }
        EXPECT_LT(angle_between(Quaternion(a.q_nb), motion.q(0.02)), 0.1 * deg) << first.transpose();
    }
}

TEST(AhrsApi, AStartTakesAnyForceWhenNoneAgreesForASecond) {
    const Handle f = make(hnav_ahrs_defaults(HNAV_PRESET_DEFAULT));
    const Turning motion;
    auto a = hnav_sized<hnav_attitude>();
    for (int k = 0; k <= 102; ++k) {
        const Vector3 force = 1.5 * motion.force_b(0.01 * k);
        ASSERT_EQ(hnav_filter_push_imu(f.get(), 0.01 * k, motion.rate_b.data(), force.data()), HNAV_OK);
        ASSERT_EQ(hnav_filter_advance(f.get(), 0.01 * k), HNAV_OK);
        ASSERT_EQ(hnav_filter_attitude(f.get(), &a), k < 101 ? HNAV_ERROR_NOT_STARTED : HNAV_OK) << k;
    }
}

TEST(AhrsApi, OptionsOfAnotherFilterAreRefused) {
    hnav_filter* filter = nullptr;
    char message[256];
    hnav_ahrs_options o = hnav_ahrs_defaults(HNAV_PRESET_PAPER);
    EXPECT_EQ(hnav_ahrs_create(&filter, &o, message, sizeof message), HNAV_ERROR_OPTIONS_STAMP);
    o = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    o.mag_gate = 0;
    EXPECT_EQ(hnav_ahrs_create(&filter, &o, message, sizeof message), HNAV_ERROR_OPTION);
    EXPECT_NE(std::string(message).find("mag_gate"), std::string::npos);
}
