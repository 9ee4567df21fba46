// Laws of the intervals of raw samples: checks of three sensors together, the held sample, gaps, rest.
#include "laws.hpp"
#include "signals/gaps.hpp"
#include "signals/rest.hpp"
#include "signals/sensor_checks.hpp"
#include "signals/slow_noise.hpp"
#include "signals/strapdown.hpp"

#include <gtest/gtest.h>

using namespace hnav;

namespace {

using Vector = Eigen::Map<const Vector3>;

struct RestOptions {
    double rest_rate_rad_s, rest_force_m_s2, rest_duration_s;
};
struct CheckOptions {
    double outlier_rate_rad_s = 8, gyro_range_rad_s = 0, outlier_force_m_s2 = 100, accel_range_m_s2 = 0;
};

// A noisy unit at 100 Hz, sample by sample.
struct Unit {
    SensorCheck<double> check[checked_count]{};
    CheckLimits<double> limits{CheckOptions{}, 0};
    test::Random random{5};
    double t_s = 0;

    Examined next(const Vector3& rate_error, const Vector3& force_error, bool moves = false, bool turns = false) {
        return take(random.vector(0.01) + rate_error, Vector3(0, 0, -9.8) + random.vector(0.05) + force_error, moves, turns);
    }
    Examined take(const Vector3& rate, const Vector3& force, bool moves, bool turns) {
        t_s += 0.01;
        const Vector3 y[] = {rate, force, Vector3::Zero()};
        const auto sample = [&](int sensor, Vector3* value) {
            *value = y[sensor];
            return sensor != checked_mag;
        };
        return examine(check, limits.of, t_s, moves, turns, sample, [](int) { return 0.01; });
    }
};

std::uint64_t bit(int sensor) { return std::uint64_t{1} << sensor; }

} // namespace

// ------------------------------------------------------------------------------------------------ checks

TEST(SensorChecks, OneWildSampleIsRejectedAndCountedAndTheNextIsUsed) {
    for (const int sensor : {checked_gyro, checked_accel}) {
        Unit unit;
        for (int k = 0; k < 300; ++k) ASSERT_EQ(unit.next({0, 0, 0}, {0, 0, 0}).rejected, 0u);
        const Vector3 wild(0, 1000, 0), none(0, 0, 0);
        EXPECT_EQ(unit.next(sensor == checked_gyro ? wild : none, sensor == checked_accel ? wild : none).rejected, bit(sensor));
        EXPECT_EQ(unit.next(none, none).rejected, 0u);
        EXPECT_EQ(unit.check[sensor].left_out, 1u);
        EXPECT_EQ(unit.check[1 - sensor].left_out, 0u);
    }
}

TEST(SensorChecks, AStepThatASecondSampleConfirmsIsUsed) {
    Unit unit;
    for (int k = 0; k < 300; ++k) unit.next({0, 0, 0}, {0, 0, 0});
    EXPECT_EQ(unit.next({0, 20, 0}, {0, 0, 0}).rejected, bit(checked_gyro));
    EXPECT_EQ(unit.next({0, 20, 0}, {0, 0, 0}).rejected, 0u);
}

TEST(SensorChecks, AStuckGyroscopeIsUsedAndAStuckAccelerometerIsNot) {
    Unit unit;
    for (int k = 0; k < 300; ++k) unit.next({0, 0, 0}, {0, 0, 0});
    const Vector3 rate(0.1, 0.2, 0.3), force(1, 2, -9);
    bool found = false;
    for (int k = 0; k < 100; ++k) {
        const Examined e = unit.take(rate, unit.random.vector(1) + force, true, true);
        EXPECT_EQ(e.rejected, 0u);
        found |= e.rate_at_fault;
    }
    EXPECT_TRUE(found);
    for (int k = 0; k < 10; ++k) unit.next({0, 0, 0}, {0, 0, 0});
    std::uint64_t rejected = 0;
    for (int k = 0; k < 100; ++k) rejected |= unit.take(unit.random.vector(0.5), force, true, true).rejected;
    EXPECT_EQ(rejected, bit(checked_accel));
}

TEST(SensorChecks, ABodyThatDoesNotMoveRepeatsWithoutAFault) {
    Unit unit;
    for (int k = 0; k < 300; ++k) unit.next({0, 0, 0}, {0, 0, 0});
    for (int k = 0; k < 200; ++k) EXPECT_FALSE(unit.take({0.01, 0, 0}, {0, 0, -9.8}, false, false).rate_at_fault);
}

TEST(SensorCheck, WhatIsLostGrowsWithTheSizeAndTheMemory) {
    SensorCheck<double> check{};
    check.axes = 2;
    check.since_s = 1;
    EXPECT_EQ(check.lost(0, 0.01, 2, 3, 1), 0);
    EXPECT_NEAR(check.lost(1, 0.01, 2, 3, 1), 9 * 2 * 1 * 0.01, 1e-12);
    check.run[1] = 20; // found now: the samples that showed it count
    EXPECT_NEAR(check.lost(1, 0.01, 1, 3, 0), 9 * 0.2 * 0.2, 1e-12);
}

// ------------------------------------------------------------------------------------------------ the held sample

// A rate w0 + w1 t: the rotation by a mean over each interval, with and without coning, against fine steps.
void expect_the_turn_within_the_interval(Hold hold) {
    const Vector3 w0(1, -2, 0.5), w1(30, 20, -40);
    const double T = 0.01;
    HeldSample held;
    held.begin();
    Quaternion with(1, 0, 0, 0), without = with, exact = with;
    for (int k = 0; k < 20; ++k) {
        const Vector3 sample = w0 + w1 * (k + (hold == Hold::instant ? 1 : 0.5)) * T;
        held.hold(sample, sample, T, T, hold);
        for (int i = 0; i < 100; ++i) {
            const double t = (k + (i + 0.5) / 100) * T;
            exact = multiply(exact, rotation_quaternion(Vector3((w0 + w1 * t) * T / 100)));
        }
        if (k < HeldSample::history) {
            with = without = exact;
            continue;
        }
        with = multiply(with, rotation_quaternion(Vector3((Vector(held.rate) + Vector(held.coning)) * T)));
        without = multiply(without, rotation_quaternion(Vector3(Vector(held.rate) * T)));
    }
    const auto error = [&](const Quaternion& q) { return rotation_vector(multiply(q, conjugate(exact))).norm(); };
    EXPECT_LT(error(with), 0.02 * error(without));
}

TEST(HeldSample, ConingTurnsTheBodyAsFarAsTheRateWithinTheInterval) {
    expect_the_turn_within_the_interval(Hold::backward);
    expect_the_turn_within_the_interval(Hold::instant);
}

TEST(HeldSample, ReadingsAreMetByAStraightLine) {
    HeldSample held;
    held.begin();
    const Vector3 first(1, 2, 3), second(3, 2, -1);
    held.hold(first, second, std::numeric_limits<double>::infinity(), 0, Hold::instant);
    EXPECT_EQ(Vector(held.rate), first); // there is none before it
    held.hold(second, first, 0.05, 0.01, Hold::instant); // also over a gap
    EXPECT_EQ(Vector(held.rate), 0.5 * (first + second));
    EXPECT_EQ(Vector(held.force), 0.5 * (first + second));
    EXPECT_EQ(Vector(held.sculling).norm(), 0);
}

TEST(HeldSample, AGapIsCrossedEvenlyFromTheLastSampleToTheNext) {
    const double T = 0.01, gap_s = 0.05;
    const Vector3 last(1, 2, 3), next(2, 0, 5);
    HeldSample held;
    held.begin();
    held.hold(last, last, T, T, Hold::backward);
    held.hold(next, next, gap_s, T, Hold::backward);
    const Vector3 slope = (next - last) / gap_s, mean = next - 0.5 * (gap_s - T) * slope;
    EXPECT_LT((Vector(held.rate) + Vector(held.coning) - mean).norm(), 1e-12);
    EXPECT_LT((Vector(held.force) + Vector(held.sculling) - mean).norm(), 1e-12);
}

TEST(HeldSample, ASampleThatActsFromNowOnHasNoConing) {
    HeldSample held;
    held.begin();
    for (int k = 0; k < 10; ++k) held.hold({0.1 * k, 1, -1}, {1, 0.1 * k, 2}, 0.01, 0.01, Hold::forward);
    EXPECT_EQ(Vector(held.coning).norm() + Vector(held.sculling).norm(), 0);
}

TEST(HeldSample, VibrationIsTheVarianceOfWhiteSamplesAndNoneOfASmoothMotion) {
    test::Random random(3);
    for (const Hold hold : {Hold::backward, Hold::instant}) { // as measured, not their means
        HeldSample white, smooth;
        white.begin();
        smooth.begin();
        for (int k = 0; k < 3000; ++k) {
            white.hold(random.vector(0.2), random.vector(3), 0.01, 0.01, hold);
            smooth.hold({std::sin(0.01 * k), 0, 0}, {0, 5 * std::cos(0.01 * k), 0}, 0.01, 0.01, hold);
        }
        EXPECT_NEAR(white.vibration_rate2, 0.04, 0.01);
        EXPECT_NEAR(white.vibration_force2, 9, 2);
        EXPECT_LT(smooth.vibration_rate2, 1e-8);
        EXPECT_LT(smooth.vibration_force2, 1e-6);
    }
}

// Before the first sample there was none at any time: an infinite interval, which has no second difference.
TEST(HeldSample, TheFirstSamplesShowNoVibration) {
    HeldSample held;
    held.begin();
    double interval_s = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 2; ++k) {
        held.hold({1.0 + k % 2, 0, 0}, {0, 5.0 * (k % 2), 9.8}, interval_s, 0.01, Hold::backward);
        EXPECT_EQ(held.vibration_rate2 + held.vibration_force2, 0) << k;
        interval_s = 0.01;
    }
}

// Across a gap a motion changes the samples by more than it does between neighbours.
TEST(HeldSample, AGapInAMotionShowsNoVibration) {
    HeldSample held;
    held.begin();
    double t_s = 0;
    for (int k = 0; k < 100; ++k) {
        const double interval_s = k == 50 ? 0.5 : 0.01;
        t_s += interval_s;
        held.hold({std::sin(2 * t_s), 0, 0}, {0, 5 * std::cos(2 * t_s), 9.8},
                  k > 0 ? interval_s : std::numeric_limits<double>::infinity(), 0.01, Hold::backward);
    }
    EXPECT_LT(held.vibration_rate2, 1e-6);
    EXPECT_LT(held.vibration_force2, 1e-5);
}

// ------------------------------------------------------------------------------------------------ slow noise

// White noise has one density at all frequencies; a vibration of 40 Hz has less of it in means over .05 s, and a motion more.
TEST(SlowNoise, OfWhiteSamplesIsTheirVarianceAndOfAVibrationLess) {
    test::Random random(5);
    SlowNoise white{}, shaken{}, moved{};
    for (int k = 0; k < 5000; ++k) {
        const double t_s = 0.005 * k, vibration = std::sin(2 * M_PI * 40 * t_s), motion = 5 * std::sin(2 * M_PI * 2 * t_s);
        white.note(random.vector(0.2), random.vector(3), 0.005);
        shaken.note({vibration, 0, 0}, {0, vibration, 0}, 0.005);
        moved.note({motion, 0, 0}, {0, motion, 0}, 0.005);
    }
    EXPECT_NEAR(white.at_most(1, SlowNoise::rate), 0.04, 0.01);
    EXPECT_NEAR(white.at_most(100, SlowNoise::force), 9, 2);
    EXPECT_LT(shaken.at_most(1.0 / 6, SlowNoise::rate), 0.01);
    EXPECT_EQ(moved.at_most(1e-3, SlowNoise::force), 1e-3);
}

TEST(SlowNoise, IsThatOfNeighboursAtFirstAndAfterAGap) {
    SlowNoise noise{};
    const auto quiet = [&noise](int samples) {
        for (int k = 0; k < samples; ++k) noise.note(Vector3::Zero(), Vector3::Zero(), 0.01);
    };
    quiet(30);
    EXPECT_EQ(noise.at_most(2, SlowNoise::rate), 2);
    quiet(70);
    EXPECT_EQ(noise.at_most(2, SlowNoise::rate), 0);
    noise.note(Vector3::Zero(), Vector3::Zero(), 3);
    EXPECT_EQ(noise.at_most(2, SlowNoise::rate), 2);
}

// ------------------------------------------------------------------------------------------------ gaps and rest

TEST(GapMotion, CountsNothingWithinAFewIntervalsAndPartsOfAGapAddUp) {
    GapMotion none{}, whole{}, parts{};
    none.add(0, 0.029, 0.01, 1, 1);
    EXPECT_EQ(none.turn2 + none.gain2 + none.way2, 0);
    whole.add(0, 0.5, 0.01, 0.3, 2);
    for (int k = 0; k < 5; ++k) parts.add(0.1 * k, 0.1 * (k + 1), 0.01, 0.3, 2);
    EXPECT_GT(whole.turn2, 0);
    EXPECT_NEAR(parts.turn2, whole.turn2, 1e-12);
    EXPECT_NEAR(parts.gain2, whole.gain2, 1e-12);
    EXPECT_NEAR(parts.way2, whole.way2, 1e-12);
}

TEST(GapMotion, TheWayIsThatOfAGainThatGrewEvenly) {
    for (const double gap_s : {0.5, 3.0}) {
        GapMotion m{};
        m.add(0, gap_s + 0.01, 0.01, 0, 0);
        EXPECT_NEAR(m.gain2, 4 * gap_s * gap_s, 1e-12); // 2 m/s2
        EXPECT_NEAR(m.way2, m.gain2 * gap_s * gap_s / 4, 1e-12);
    }
}

TEST(Sampling, TheUsualIntervalFollowsByATenthAndGrowsThroughGaps) {
    EXPECT_EQ(usual_interval(0, 0.01), 0.01);
    EXPECT_EQ(usual_interval(0.02, 0), 0.02);
    EXPECT_NEAR(usual_interval(0.02, 0.01), 0.011, 1e-15);
    EXPECT_NEAR(usual_interval(2.0, 1.5), 1.55, 1e-15);
    EXPECT_NEAR(usual_interval(0.04, 0.01), 0.012, 1e-15);
}

TEST(Sampling, ASampleStandsForTheTimeSinceTheLastOrTheUsualOneWithinTheLimit) {
    EXPECT_EQ(interval_of_sample(0, 0.01, 1), 0);
    EXPECT_EQ(interval_of_sample(0.03, 0.01, 1), 0.03); // a loss is no gap
    EXPECT_EQ(interval_of_sample(0.031, 0.01, 1), 0.01);
    EXPECT_EQ(interval_of_sample(5, 0, 1), 1);
}

TEST(GapMotion, ASwingCountsFromItsOwnLengthOn) {
    const auto swung = [](double gap_s) {
        GapMotion still{}, swings{};
        still.add(0, gap_s, 0.01, 0, 0);
        swings.add(0, gap_s, 0.01, 3, 0);
        return (swings.turn2 - still.turn2) / still.turn2;
    };
    EXPECT_LT(swung(0.05), 0.05);
    EXPECT_NEAR(swung(1.0), 1 / (0.2 * 0.2), 0.5);
}

TEST(Unrest, WhatIdlesIsAtRestWhatSwaysIsSoWithinWiderLimitsAndWhatMovesIsNot) {
    const RestOptions o{0.02, 0.25, 1};
    const auto after = [&](double rate, double force) {
        test::Random random(2);
        Unrest rest{};
        for (int k = 0; k < 500; ++k) rest.note(o, random.vector(rate), random.vector(force), 0.01);
        return rest;
    };
    EXPECT_TRUE(after(0.005, 0.05).still(o));
    EXPECT_FALSE(after(0.03, 0.05).still(o));
    EXPECT_TRUE(after(0.03, 0.05).sways(o));
    EXPECT_FALSE(after(0.2, 0.05).sways(o));
    EXPECT_FALSE(after(0.005, 0.5).still(o));
    EXPECT_FALSE(after(0.005, 0.05).still(RestOptions{0, 0.25, 1}));
}

TEST(Unrest, ABiasIsAtRestAndWavesAreNot) {
    const RestOptions o{0.02, 0.25, 1};
    const auto still_share = [&](double amplitude_rad_s) { // of the last minute, with a roll of ten seconds
        test::Random random(3);
        Unrest rest{};
        int still = 0;
        for (int k = 0; k < 9000; ++k) {
            const double roll = amplitude_rad_s * std::sin(2 * M_PI * 0.001 * k);
            rest.note(o, Vector3(0.01 + roll, 0, 0) + random.vector(0.002), random.vector(0.05), 0.01);
            still += k >= 3000 && rest.still(o);
        }
        return still / 6000.0;
    };
    EXPECT_EQ(still_share(0), 1);
    EXPECT_LT(still_share(0.02), 0.05);
}
