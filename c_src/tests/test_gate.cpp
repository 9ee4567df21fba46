// Laws of gates, of consistency and of readiness.
#include "estimation/consistency.hpp"
#include "estimation/gate.hpp"
#include "estimation/readiness.hpp"
#include "estimation/steps.hpp"

#include <gtest/gtest.h>

#include <random>

using namespace hnav;

TEST(Gate, WithinItNothingChangesAndBeyondItTheRatioCounts) {
    EXPECT_EQ(beyond_gate(8.0, 9.0), 1);
    EXPECT_EQ(beyond_gate(9.0, 9.0), 1);
    EXPECT_EQ(beyond_gate(18.0, 9.0), 2);
    EXPECT_EQ(beyond_gate(1e9, 0.0), 1); // no gate
}

TEST(Gate, FewerRowsHaveAsRareALimit) {
    const double limit = 16.27; // chi square, 3 degrees of freedom, 99.9 %
    EXPECT_NEAR(gate_for_rows(1, limit), 10.83, 0.15);
    EXPECT_NEAR(gate_for_rows(2, limit), 13.82, 0.15);
    EXPECT_EQ(gate_for_rows(3, limit), limit);
}

Consistency after(int samples, double interval_s, double sigma, double mean, bool gated = false) {
    std::mt19937_64 engine(3);
    std::normal_distribution<double> normal;
    Consistency fit;
    fit.begin(1, 0);
    for (int i = 0; i < samples; ++i) {
        const double noise = fit.noise; // the noise that the filter has learnt
        const double r[3] = {mean + sigma * normal(engine), sigma * normal(engine), sigma * normal(engine)};
        const double variance[3] = {noise, noise, noise};
        fit.note(r, variance, 3, gated, false, i * interval_s);
    }
    return fit;
}

// A scalar of sigma 0.1 in a filter that does not expect steps, measured with sigma 1 every 0.2 s for a minute, with a step half way through.
// Returns twice the log likelihood ratio, estimate plus step and its variance at the end.
struct Found {
    double ratio, estimate, variance;
};
Found found_of(double step) {
    std::mt19937_64 engine(3);
    std::normal_distribution<double> normal;
    StepEvidence<1> evidence{};
    double mean = 0, variance = 0.01, response = 1;
    for (int i = 0; i < 300; ++i) {
        if (i == 150) {
            evidence = {};
            response = 1;
        }
        const double S = variance + 1, r = (i < 150 ? 0 : step) + normal(engine) - mean;
        evidence.add({{response * response / S}, {response * r / S}, 0});
        const double gain = variance / S;
        mean += gain * r;
        response *= 1 - gain;
        variance *= 1 - gain;
    }
    const double sigma = 10;
    const Steps<1> found(evidence, &sigma);
    return {found.twice_log_ratio(), mean + response * found.mean()[0],
            variance + response * response * found.covariance()(0, 0)};
}

TEST(Steps, NoStepIsNotFoundAndAStepGivesTheEstimateOfAFilterThatExpectedIt) {
    EXPECT_LT(found_of(0).ratio, 18);
    const Found found = found_of(3);
    EXPECT_GT(found.ratio, 18);
    EXPECT_LT(std::fabs(found.estimate - 3), 4 * std::sqrt(found.variance));
    EXPECT_LT(found.variance, 0.01); // of 150 samples
}

TEST(Steps, RejectedSamplesAreOutliersUnlessALikelyStepExplainsThem) {
    const double sigma = 1, gate = 16;
    const auto ratio = [&](double r, int count) {
        StepEvidence<1> evidence{};
        for (int i = 0; i < count; ++i) evidence.add({{1}, {r}, r * r - gate});
        return Steps<1>(evidence, &sigma).twice_log_ratio();
    };
    EXPECT_LT(ratio(20, 1), 0); // 20 sigmas of the step are less likely than an outlier
    EXPECT_GT(ratio(5, 4), 18);
    EXPECT_LT(ratio(20, 4), 0);
}

TEST(Steps, SixInformationsOfAGyroBiasAreInTheRangeOfAFloat) {
    StepEvidence<6, float> evidence{};
    for (int i = 0; i < 6; ++i) {
        evidence.information[7 * i] = 1e10F;
        evidence.sum[i] = 1e7F;
    }
    const float sigmas[] = {0.01F, 0.01F, 0.01F, 0.01F, 0.01F, 0.01F};
    EXPECT_NEAR((Steps<6, float>(evidence, sigmas).twice_log_ratio()), 6 * (1e4 - std::log(1e6)), 1);
}

TEST(Consistency, InnovationsAsPredictedChangeNothing) {
    for (const double interval_s : {0.1, 0.2, 1.0}) {
        EXPECT_LT(after(1000, interval_s, 1, 0).bias(), 5) << interval_s;
        EXPECT_LT(after(1000, interval_s, 1, 0).noise, 1.5) << interval_s;
    }
}

// Evenly; in pairs, of two receivers; with gaps.
TEST(Consistency, TheMeanOfAnyNumberOfRowsAtAnyIntervalsIsOneByChance) {
    const auto evenly = [](int k) { return 0.2 * k; };
    const auto in_pairs = [](int k) { return 0.4 * (k / 2) + 0.001 * (k % 2); };
    const auto with_gaps = [](int k) { return 0.2 * k + 30 * (k / 10); };
    for (double (*time_s)(int) : {+evenly, +in_pairs, +with_gaps}) {
        for (const int rows : {1, 2, 3}) {
            std::mt19937_64 engine(5);
            std::normal_distribution<double> normal;
            Consistency fit;
            fit.begin(1, 0);
            double sum[Consistency::windows] = {};
            constexpr int samples = 20000, settled = 1000;
            for (int k = 0; k < samples; ++k) {
                const double r[3] = {normal(engine), normal(engine), normal(engine)}, variance[3] = {1, 1, 1};
                fit.note(r, variance, rows, false, false, time_s(k));
                for (int w = 0; w < Consistency::windows; ++w) sum[w] += k < settled ? 0 : fit.bias(w);
            }
            for (const double total : sum) EXPECT_NEAR(total / (samples - settled), 1, 0.25) << rows;
        }
    }
}

// Errors of .5 s and 3 s among white ones of the same size, five times a second. The variance is what the filter takes; 1 is that of a sample.
TEST(Consistency, SamplesOfErrorsThatLastWeighLess) {
    for (const double lasting_s : {0.0, 0.5, 3.0}) {
        std::mt19937_64 engine(7);
        std::normal_distribution<double> normal;
        Consistency fit;
        fit.begin(1, Consistency::usual_colour_s);
        constexpr double interval_s = 0.2;
        const double kept = lasting_s > 0 ? std::exp(-interval_s / lasting_s) : 0;
        double slow[3] = {}, weight = 0;
        constexpr int samples = 5000, settled = 500;
        for (int k = 0; k < samples; ++k) {
            const double t_s = k * interval_s, taken = fit.weight(t_s);
            double r[3];
            for (int i = 0; i < 3; ++i) {
                slow[i] = kept * slow[i] + std::sqrt(0.5 * (1 - kept * kept)) * normal(engine);
                r[i] = slow[i] + std::sqrt(0.5) * normal(engine);
            }
            const double variance[3] = {taken, taken, taken};
            fit.note(r, variance, 3, false, false, t_s);
            weight += k < settled ? 0 : taken / (samples - settled);
        }
        EXPECT_EQ(fit.noise, 1);
        if (lasting_s == 0) EXPECT_LT(weight, 1.25);
        else EXPECT_GT(weight, lasting_s < 1 ? 2 : 4) << lasting_s;
    }
}

// Positions that jump are noted with two rows, others with three: the difference of the two is no noise.
TEST(Consistency, AnInnovationOfFewerRowsIsNoSuccessor) {
    Consistency fit;
    fit.begin(1, 0);
    const double large[3] = {50, -50, 50}, jump[2] = {-50, 50}, variance[3] = {1, 1, 1};
    for (int k = 0; k < 20; ++k) {
        fit.note(k % 2 ? jump : large, variance, k % 2 ? 2 : 3, true, true, k);
    }
    EXPECT_EQ(fit.noise, 1);
}

TEST(Consistency, NoiseBeyondWhatIsStatedIsLearntAndForgotten) {
    const Consistency fit = after(300, 0.2, 10, 0);
    EXPECT_NEAR(fit.noise, 100, 50);
    EXPECT_LT(fit.bias(), 8);
    Consistency later = fit;
    const double one[3] = {1, 1, 1};
    for (int i = 0; i < 3000; ++i) {
        const double r[3] = {i % 2 ? 0.1 : -0.1, 0, 0};
        later.note(r, one, 3, false, false, 60 + 0.2 * i);
    }
    EXPECT_EQ(later.noise, 1); // the stated noise is a lower bound
}

TEST(Consistency, WhatIsLearntIsAVarianceAndNoFactor) {
    Consistency fit = after(300, 0.2, 10, 0);
    const double learnt = fit.noise;
    fit.restate(1);
    EXPECT_EQ(fit.noise, learnt);
    fit.restate(4);
    EXPECT_DOUBLE_EQ(fit.noise, learnt / 4);
    fit.restate(1); // back to normal: the noise learnt before no longer applies
    EXPECT_DOUBLE_EQ(fit.noise, learnt / 4);
    fit.restate(1e6);
    EXPECT_EQ(fit.noise, 1);
}

TEST(Consistency, RefusalsInARowHaveAMeanUnlessTheyHaveJumped) {
    const double far[3] = {50, 0, 0}, one[3] = {1, 1, 1};
    for (const bool jumped : {false, true}) {
        Consistency fit = after(100, 0.2, 1, 0);
        for (int i = 0; i < 5; ++i) fit.note(far, one, 3, true, jumped, 20.2 + 0.2 * i);
        EXPECT_EQ(fit.bias(0) > 20, !jumped);
    }
}

TEST(Consistency, AMeanIsAWrongStateAndNoNoise) {
    const Consistency fit = after(100, 0.2, 1, 2);
    EXPECT_GT(fit.bias(), 8);
    EXPECT_LT(fit.noise, 1.5);
}

TEST(Consistency, ASingleOutlierIsNeither) {
    Consistency fit = after(100, 0.2, 1, 0);
    const double before = fit.bias(), noise = fit.noise, far[3] = {50, 50, 50}, one[3] = {1, 1, 1};
    fit.note(far, one, 3, true, false, 20.2);
    EXPECT_EQ(fit.bias(), before);
    EXPECT_EQ(fit.noise, noise);
}

TEST(Readiness, ASmallSigmaHasToBeEarned) {
    EXPECT_TRUE(angle_ready(0.9e-4, 1.1e4, 0.01));
    EXPECT_FALSE(angle_ready(1.1e-4, 1.1e4, 0.01));
    EXPECT_FALSE(angle_ready(0.9e-4, 0.9e4, 0.01));
    EXPECT_FALSE(angle_ready(-1e-9, 1.1e4, 0.01)); // no variance
}

TEST(Readiness, TheLargerVarianceCountsForTheTilt) {
    EXPECT_EQ(tilt_variance<double>({1, 2, 9}), 2);
    EXPECT_EQ(tilt_variance<double>({3, 2, 9}), 3);
}

TEST(Readiness, WhatACorrectionBringsIsAddedToItsAngle) {
    AngleInformation<double> information{};
    information.gain_tilt({1, 4, 9}, {1, 2, 3}); // from 4 to 2
    information.gain_heading({1, 4, 8}, {1, 2, 4});
    EXPECT_NEAR(information.tilt, 0.25, 1e-15);
    EXPECT_NEAR(information.heading, 0.125, 1e-15);
}

TEST(Readiness, InformationIsTheDifferenceOfInverseVariances) {
    EXPECT_NEAR(information_gained(0.5, 0.25), 2, 1e-15);
    EXPECT_EQ(information_gained(0.25, 0.5), 0);
    EXPECT_EQ(information_gained(0.25, 0.0), 0);
}
