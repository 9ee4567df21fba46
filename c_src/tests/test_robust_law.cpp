#include "attitude/hrekf/noise_adaptation.hpp"
#include "estimation/robust_law.hpp"
#include "laws.hpp"

#include <Eigen/LU>

using namespace hnav;
using hnav::test::distance;

namespace {

using Weight = Eigen::Matrix<double, 7, 1>;

RobustSettings<double> settings(GammaMode mode) {
    RobustSettings<double> s;
    s.mode = mode;
    return s;
}

Square<7> inflate(const Square<7>& P, const Weight& L, double interval_s, const RobustSettings<double>& settings,
                  RobustReport<double>* report) {
    Square<7> Sigma = P;
    const Square<7> LP = L.asDiagonal() * P;
    hnav::inflate<7, 7, double>(Sigma, LP, LP * L.asDiagonal(), interval_s, settings, report);
    return Sigma;
}

double largest_eigenvalue(const Square<7>& A) { return eigenvalues<7>(A)[6]; }

} // namespace

TEST(RobustLaw, OffLeavesTheCovarianceAlone) {
    const Square<7> P = test::Random(1).covariance<7>();
    RobustReport<double> report;
    EXPECT_EQ(distance(inflate(P, Weight::Ones(), 0.01, settings(GammaMode::off), &report), P), 0);
    EXPECT_TRUE(std::isinf(report.gamma));
    EXPECT_EQ(report.margin, 1);
}

TEST(RobustLaw, SigmaEqualsThePrintedFormWithInverses) {
    const Square<7> P = test::Random(2).covariance<7>(0.01);
    Weight L;
    L << 1, 1, 1, 1, 0.3, 0.3, 0.3;
    RobustSettings<double> fixed = settings(GammaMode::fixed);
    fixed.gamma = 2;
    RobustReport<double> report;
    const Square<7> Sigma = inflate(P, L, 0.01, fixed, &report);
    const Square<7> LL = L.cwiseAbs2().asDiagonal();
    const Square<7> printed = (P.inverse() - LL / 4).inverse();
    EXPECT_LT(distance(Sigma, printed), 1e-10 * printed.cwiseAbs().maxCoeff());
    EXPECT_FALSE(report.raised);
    EXPECT_NEAR(report.gamma, 2, 1e-15);
}

TEST(RobustLaw, GammaTowardsInfinityIsTheKalmanFilter) {
    const Square<7> P = test::Random(3).covariance<7>();
    RobustSettings<double> fixed = settings(GammaMode::fixed);
    fixed.gamma = 1e9;
    RobustReport<double> report;
    EXPECT_LT(distance(inflate(P, Weight::Ones(), 0.01, fixed, &report), P), 1e-14);
}

TEST(RobustLaw, AnInfeasibleGammaIsRaisedAndReported) {
    const Square<7> P = test::Random(4).covariance<7>();
    RobustSettings<double> fixed = settings(GammaMode::fixed);
    fixed.gamma = 1e-3;
    RobustReport<double> report;
    const Square<7> Sigma = inflate(P, Weight::Ones(), 0.01, fixed, &report);
    EXPECT_TRUE(report.raised);
    EXPECT_NEAR(report.margin, 0.05, 1e-12);
    EXPECT_NEAR(report.gamma * report.gamma, largest_eigenvalue(P) / 0.95, 1e-9);
    EXPECT_GT(eigenvalues<7>(Sigma - P)[0], -1e-9);
}

TEST(RobustLaw, RelativeGammaTakesTheShareOfItsRate) {
    const Square<7> P = test::Random(5).covariance<7>();
    RobustSettings<double> relative = settings(GammaMode::relative);
    relative.relative_rate = 1.5;
    RobustReport<double> report;
    inflate(P, Weight::Ones(), 0.2, relative, &report);
    EXPECT_NEAR(report.margin, std::exp(-0.3), 1e-12);
}

TEST(RobustLaw, TheKlModeMeetsItsTolerance) {
    const Square<7> P = test::Random(6).covariance<7>();
    for (const double c : {1e-6, 1e-3, 0.1, 1.0}) {
        RobustSettings<double> kl = settings(GammaMode::kl);
        kl.kl_rate = std::sqrt(c);
        RobustReport<double> report;
        inflate(P, Weight::Ones(), 1.0, kl, &report);
        ASSERT_FALSE(report.raised);
        // Sum over all eigenvalues of 1/2 (1/z - 1 + ln z), written out.
        const Weight values = eigenvalues<7>(P);
        double divergence = 0;
        for (int i = 0; i < 7; ++i) {
            const double z = 1 - values[i] / (report.gamma * report.gamma);
            divergence += 0.5 * (1 / z - 1 + std::log(z));
        }
        EXPECT_NEAR(divergence, c, 1e-8 * c + 1e-14);
    }
}

TEST(RobustLaw, WhatTheKlModeInflatesInASecondDoesNotHangOnTheRate) {
    const Square<7> P = test::Random(8).covariance<7>();
    RobustSettings<double> kl = settings(GammaMode::kl);
    kl.kl_rate = 0.5;
    double theta_per_s[2];
    for (const int slow : {0, 1}) {
        const double T = slow ? 0.01 : 0.001;
        RobustReport<double> report;
        inflate(P, Weight::Ones(), T, kl, &report);
        theta_per_s[slow] = 1 / (report.gamma * report.gamma * T);
    }
    EXPECT_NEAR(theta_per_s[1] / theta_per_s[0], 1, 0.02);
}

TEST(RobustLaw, ASingularCovarianceIsNoObstacle) {
    Square<7> P = test::Random(7).covariance<7>();
    P.row(0).setZero();
    P.col(0).setZero();
    for (const GammaMode mode : {GammaMode::fixed, GammaMode::relative, GammaMode::kl}) {
        RobustReport<double> report;
        const Square<7> Sigma = inflate(P, Weight::Ones(), 0.01, settings(mode), &report);
        EXPECT_TRUE(Sigma.allFinite());
        EXPECT_EQ(Sigma.row(0).cwiseAbs().maxCoeff(), 0);
    }
    RobustReport<double> report;
    EXPECT_EQ(inflate(Square<7>(Square<7>::Zero()), Weight::Ones(), 0.01, settings(GammaMode::kl), &report).cwiseAbs().maxCoeff(),
              0);
}

TEST(NoiseAdaptation, AsPrintedIsAMovingAverageOfOuterProducts) {
    const Matrix3 Q = 2 * Matrix3::Identity();
    AdaptationSettings<double> s;
    s.gain = 0.5;
    const Vector3 step(1, 2, 3);
    EXPECT_LT(distance(adapt_as_printed(Q, s, step), 0.5 * Q + 0.5 * step * step.transpose()), 1e-15);
}

AdaptationWindow<double> window_that_has_settled() {
    AdaptationWindow<double> w;
    w.clear();
    w.add(0, 0.01, Vector3(9, 9, 9), 9); // settling begins
    return w;
}

TEST(NoiseAdaptation, NothingIsTakenInBeforeTheStartHasSettled) {
    AdaptationWindow<double> w = window_that_has_settled();
    for (double t = 0.01; t < 20; t += 0.01) EXPECT_FALSE(w.add(t, 0.01, Vector3(1, 1, 1), 1));
    EXPECT_EQ(w.elapsed_s, 0);
    EXPECT_FALSE(w.add(24, 4, Vector3(1, 2, 3), 1)); // all of it after that
    EXPECT_TRUE(w.add(30.5, 6.5, Vector3(1, 2, 3), 1));
    EXPECT_EQ(w.sum[2], 6);
}

TEST(NoiseAdaptation, TheCorrectedFormStaysWithinItsBounds) {
    AdaptationSettings<double> s;
    s.min = 1e-4;
    s.max = 1e-2;
    AdaptationWindow<double> w = window_that_has_settled();
    w.add(40, 10, Vector3::Zero(), -1);
    EXPECT_NEAR(w.factor(s, 1e-3) * 1e-3, 1e-4, 1e-15);
    w.add(50, 10, Vector3(9, 9, 9), 0);
    EXPECT_NEAR(w.factor(s, 1e-3) * 1e-3, 1e-2, 1e-12);
    w.add(60, 10, Vector3::Zero(), -1);
    s.min = 0;
    s.gain = 1;
    EXPECT_NEAR(w.factor(s, 1e-3), 0.05, 1e-12); // no further within one window
}

// With corrections of exactly the expected size, |sum K0 nu|^2 = tr(P- - P0+) summed, and P- = P+_{k-1} + Q T.
TEST(NoiseAdaptation, TheTrueNoiseIsAFixedPointOfTheCorrectedForm) {
    const double q = 1e-3, W = 10, p = 1e-4, posterior = 0.7 * (p + q * W);
    AdaptationWindow<double> w = window_that_has_settled();
    const double step = std::sqrt(p + q * W - posterior);
    w.add(40, W, Vector3(step, -step, step), 3 * (posterior - p));
    EXPECT_NEAR(w.factor({}, q), 1, 1e-12);
}

TEST(NoiseAdaptation, StepsFallWhenTheEstimatesSwingAndOnlyThen) {
    AdaptationSettings<double> s;
    s.gain = 0.2;
    s.max = 10;
    AdaptationWindow<double> w = window_that_has_settled();
    const auto step = [&](double share) { // of what is expected
        w.add(100, 10, Vector3(std::sqrt(share * 30), 0, 0), 0);
        return (w.factor(s, 1) - 1) / (share - 1);
    };
    EXPECT_NEAR(step(2), 0.9, 1e-12);
    EXPECT_NEAR(step(3), 0.9, 1e-12);
    EXPECT_NEAR(step(0.5), 0.45, 1e-12);
    EXPECT_NEAR(step(2), 0.3, 1e-12);
    for (const double share : {0.5, 2., 0.5}) step(share);
    EXPECT_NEAR(step(2), 0.2, 1e-12);
}
