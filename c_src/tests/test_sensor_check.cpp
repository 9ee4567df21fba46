// The health of one sensor from its samples.
#include "signals/gaps.hpp"
#include "signals/sensor_check.hpp"

#include <gtest/gtest.h>

#include <random>

using hnav::SensorCheck, hnav::SensorCheckSettings, hnav::SensorFault, hnav::Vector3;

namespace {

constexpr double interval_s = 0.01;

// A noisy gyroscope in a hand that turns; `noise` 0 is a simulated one.
class Gyro {
public:
    explicit Gyro(double noise = 0.003) : noise_(noise) {}

    Vector3 sample() {
        const double t = interval_s * count_++;
        return Vector3(std::sin(3 * t), std::cos(2 * t), 0.5 * std::sin(5 * t)) +
               noise_ * Vector3(normal_(r_), normal_(r_), normal_(r_));
    }

    SensorFault take(const Vector3& y, bool moves = true) {
        const double t_s = interval_s * count_;
        check.note_course(y);
        check.examine(settings, y, interval_s, t_s, moves, check.has_noise());
        return check.fault;
    }

    void run(int count) {
        for (int k = 0; k < count; ++k) EXPECT_EQ(take(sample()), SensorFault::none) << k;
    }

    SensorCheck<double> check{};
    SensorCheckSettings<double> settings{8, 0, 1.7};

private:
    double noise_;
    int count_ = 0;
    std::mt19937 r_{1};
    std::normal_distribution<double> normal_;
};

} // namespace

TEST(SensorCheck, AHealthySensorIsWell) {
    Gyro gyro;
    gyro.run(5000);
    EXPECT_TRUE(gyro.check.has_noise());
    EXPECT_EQ(gyro.check.outliers + gyro.check.stuck + gyro.check.saturated, 0u);
}

// A co-simulation whose step is two periods long: the steps of the held value are no noise, so an axis that stays is well.
TEST(SensorCheck, AnAxisThatStaysIsWellWithoutNoiseHoweverLongAValueIsHeld) {
    for (const int held : {1, 2, 3, 5}) {
        Gyro gyro(0);
        Vector3 y;
        for (int k = 0; k < 5000; ++k) {
            if (k % held == 0) y = Vector3(-1, std::sin(0.003 * k), 2);
            EXPECT_EQ(gyro.take(y), SensorFault::none) << "held " << held << ", " << k;
        }
        EXPECT_FALSE(gyro.check.has_noise()) << held;
    }
}

TEST(SensorCheck, ASpikeIsAnOutlierAndAStepIsNot) {
    Gyro gyro;
    gyro.run(200);
    const Vector3 far(35, 0, 0);
    EXPECT_EQ(gyro.take(gyro.sample() + far), SensorFault::outlier);
    EXPECT_EQ(gyro.take(gyro.sample()), SensorFault::none);
    EXPECT_EQ(gyro.take(gyro.sample() + far), SensorFault::outlier);
    EXPECT_EQ(gyro.take(gyro.sample() + far), SensorFault::none); // a second one beside it is accepted
    EXPECT_EQ(gyro.check.outliers, 2u);
}

TEST(SensorCheck, WithoutALimitNothingIsAnOutlier) {
    Gyro gyro;
    gyro.settings.outlier = 0;
    gyro.run(200);
    EXPECT_EQ(gyro.take({1e5, 0, 0}), SensorFault::none);
}

TEST(SensorCheck, AnAxisThatRepeatsIsStuckWhileTheBodyMoves) {
    for (const bool moves : {true, false}) {
        Gyro gyro;
        gyro.run(200);
        SensorFault fault{};
        for (int k = 0; k < 50; ++k) {
            Vector3 y = gyro.sample();
            y[2] = 0;
            fault = gyro.take(y, moves);
        }
        EXPECT_EQ(fault, moves ? SensorFault::stuck : SensorFault::none);
        EXPECT_EQ(gyro.check.is_at_fault(2), moves);
        EXPECT_FALSE(gyro.check.is_at_fault(0));
        EXPECT_EQ(gyro.take(gyro.sample()), SensorFault::none); // and recovers with the first different value
    }
}

TEST(SensorCheck, AxesThatRepeatOneAfterTheOtherAreNoRun) {
    for (int axis = 0; axis < 3; ++axis) {
        Gyro gyro;
        gyro.run(200);
        for (const int repeats : {axis, (axis + 1) % 3}) {
            Vector3 y = gyro.sample();
            y[repeats] = gyro.check.last[repeats];
            EXPECT_EQ(gyro.take(y), SensorFault::none);
        }
        EXPECT_EQ(gyro.check.running, 0u) << axis;
        EXPECT_EQ(gyro.check.run[(axis + 1) % 3], 0) << axis;
        Vector3 y = gyro.sample();
        y[(axis + 1) % 3] = gyro.check.last[(axis + 1) % 3];
        gyro.take(y); // the second repeat of one axis
        EXPECT_EQ(gyro.check.run[(axis + 1) % 3], 1) << axis;
        gyro.run(1); // the run has ended
        EXPECT_EQ(gyro.check.run[(axis + 1) % 3], 0) << axis;
        EXPECT_EQ(gyro.check.running, 0u) << axis;
    }
}

TEST(SensorCheck, AFifthOfAShortRunIsLearntAsUsual) {
    Gyro gyro;
    gyro.run(200);
    for (const double usual : {0.2 * 3, 0.2 * 3 + 0.8 * 0.2 * 3}) {
        for (int k = 0; k < 4; ++k) { // three repeats after the first
            Vector3 y = gyro.sample();
            y[2] = gyro.check.last[2];
            EXPECT_EQ(gyro.take(y), SensorFault::none);
        }
        gyro.run(1);
        EXPECT_NEAR(gyro.check.usual_run, usual, 1e-12);
    }
}

TEST(RateChange, AfterAGapTheTurnIsKnownAsTheChangeOfTheRateAllows) {
    constexpr double acceleration = 3, gap_s = 0.4;
    hnav::RateChange<double> change{};
    for (int k = 0; k < 10000; ++k) // of each axis
        change.note(acceleration * interval_s * Vector3(1, k % 2 ? 1 : -1, 1), interval_s);
    const double by_last = acceleration * gap_s * gap_s / 2, by_mean = acceleration * gap_s * gap_s / 8;
    EXPECT_NEAR(std::sqrt(change.gap_variance(gap_s, false, 1)), by_last, 1e-9);
    EXPECT_NEAR(std::sqrt(change.gap_variance(gap_s, true, 1)), by_mean, 1e-9);
    EXPECT_NEAR(std::sqrt(change.gap_variance(gap_s, true, 2.5)), 2.5 * by_mean, 1e-9);
}

TEST(SensorCheck, ASensorThatSticksASecondTimeIsFoundAgain) {
    Gyro gyro;
    gyro.run(200);
    for (int spell = 0; spell < 5; ++spell) {
        SensorFault fault{};
        for (int k = 0; k < 500; ++k) {
            Vector3 y = gyro.sample();
            y[2] = 0;
            fault = gyro.take(y);
        }
        EXPECT_EQ(fault, SensorFault::stuck) << spell;
        gyro.take(gyro.sample());
        gyro.run(1000);
    }
}

TEST(SensorCheck, ASensorWithoutNoiseMayRepeatWhatIsConstant) {
    Gyro gyro(0);
    gyro.run(200);
    for (int k = 0; k < 500; ++k) EXPECT_EQ(gyro.take({3, 0, 0}), SensorFault::none);
    for (int k = 0; k < 500; ++k) EXPECT_EQ(gyro.take({0, 0, 0}), SensorFault::none);
}

TEST(SensorCheck, ARangeShowsItselfByRepeatingAndAStatedOneAtOnce) {
    Gyro found, stated;
    stated.settings.range = 2;
    int found_after = 0, stated_after = 0;
    found.run(200);
    stated.run(200);
    for (int k = 1; k <= 20; ++k) {
        Vector3 y = found.sample();
        y[0] = 2;
        if (found.take(y) == SensorFault::saturated && !found_after) found_after = k;
        if (stated.take(y) == SensorFault::saturated && !stated_after) stated_after = k;
    }
    EXPECT_EQ(stated_after, 1);
    EXPECT_GT(found_after, 1);
    EXPECT_LE(found_after, 10);
    EXPECT_EQ(found.check.limit, 2);
    found.take({2.5, 0, 0}); // it was no limit
    EXPECT_EQ(found.check.limit, 0);
}

TEST(SensorCheck, WhatAFaultyAxisMissedGrowsWithTime) {
    Gyro gyro;
    gyro.run(200);
    double variance = 0;
    for (int k = 0; k < 100; ++k) {
        Vector3 y = gyro.sample();
        y[1] = 0;
        gyro.take(y);
        variance += gyro.check.lost_rotation(1, interval_s, gyro.check.since_s + 1);
        EXPECT_EQ(gyro.check.lost_rotation(0, interval_s, 0), 0);
    }
    EXPECT_GT(variance, 1); // rad^2 within a second: the rotation is unknown
}
