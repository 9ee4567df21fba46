#include "attitude/common/robust_law.hpp"
#include "attitude/hrekf/noise_adaptation.hpp"
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

double largest_eigenvalue(const Square<7>& A) { return eigenvalues<7>(A)[6]; }

} // namespace

TEST(RobustLaw, OffLeavesTheCovarianceAlone) {
    const Square<7> P = test::Random(1).covariance<7>();
    RobustReport<double> report;
    EXPECT_EQ(distance(inflate<7>(P, Weight::Ones(), 0.01, settings(GammaMode::off), &report), P), 0);
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
    const Square<7> Sigma = inflate<7>(P, L, 0.01, fixed, &report);
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
    EXPECT_LT(distance(inflate<7>(P, Weight::Ones(), 0.01, fixed, &report), P), 1e-14);
}

TEST(RobustLaw, AnInfeasibleGammaIsRaisedAndReported) {
    const Square<7> P = test::Random(4).covariance<7>();
    RobustSettings<double> fixed = settings(GammaMode::fixed);
    fixed.gamma = 1e-3;
    RobustReport<double> report;
    const Square<7> Sigma = inflate<7>(P, Weight::Ones(), 0.01, fixed, &report);
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
    inflate<7>(P, Weight::Ones(), 0.2, relative, &report);
    EXPECT_NEAR(report.margin, std::exp(-0.3), 1e-12);
}

TEST(RobustLaw, TheKlModeMeetsItsTolerance) {
    const Square<7> P = test::Random(6).covariance<7>();
    for (const double c : {1e-6, 1e-3, 0.1, 1.0}) {
        RobustSettings<double> kl = settings(GammaMode::kl);
        kl.kl_rate = c;
        RobustReport<double> report;
        inflate<7>(P, Weight::Ones(), 1.0, kl, &report);
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

TEST(RobustLaw, ASingularCovarianceIsNoObstacle) {
    Square<7> P = test::Random(7).covariance<7>();
    P.row(0).setZero();
    P.col(0).setZero();
    for (const GammaMode mode : {GammaMode::fixed, GammaMode::relative, GammaMode::kl}) {
        RobustReport<double> report;
        const Square<7> Sigma = inflate<7>(P, Weight::Ones(), 0.01, settings(mode), &report);
        EXPECT_TRUE(Sigma.allFinite());
        EXPECT_EQ(Sigma.row(0).cwiseAbs().maxCoeff(), 0);
    }
    RobustReport<double> report;
    EXPECT_EQ(
        inflate<7>(Square<7>(Square<7>::Zero()), Weight::Ones(), 0.01, settings(GammaMode::kl), &report).cwiseAbs().maxCoeff(),
        0);
}

TEST(NoiseAdaptation, AsPrintedIsAMovingAverageOfOuterProducts) {
    const Matrix3 Q = 2 * Matrix3::Identity();
    AdaptationSettings<double> s;
    s.gain = 0.5;
    const Vector3 step(1, 2, 3);
    EXPECT_LT(distance(adapt_as_printed(Q, s, step), 0.5 * Q + 0.5 * step * step.transpose()), 1e-15);
}

TEST(NoiseAdaptation, TheCorrectedFormStaysWithinItsBounds) {
    AdaptationSettings<double> s;
    s.gain = 0.02;
    s.min = 1e-4;
    s.max = 1e-2;
    const Matrix3 down =
        adapt_corrected(Matrix3::Identity() * 1e-3, s, Vector3::Zero(), Matrix3::Zero(), Matrix3::Identity(), 0.01, 1);
    const Matrix3 up =
        adapt_corrected(Matrix3::Identity() * 1e-3, s, Vector3(9, 9, 9), Matrix3::Zero(), Matrix3::Zero(), 0.01, 1);
    EXPECT_NEAR(Eigen::SelfAdjointEigenSolver<Matrix3>(down).eigenvalues()[0], 1e-4, 1e-12);
    EXPECT_NEAR(Eigen::SelfAdjointEigenSolver<Matrix3>(up).eigenvalues()[2], 1e-2, 1e-12);
}

// With innovations of exactly the expected size, K0 S K0' = P- - P0+, and P- = P+_{k-1} + Q T: Q is a fixed point.
TEST(NoiseAdaptation, TheTrueNoiseIsAFixedPointOfTheCorrectedForm) {
    const double T = 0.01, p = 1e-4, q = 1e-3, r = 2e-4;
    const double prior = p + q * T, gain = prior / (prior + r), posterior = prior - gain * prior;
    AdaptationSettings<double> s;
    s.gain = 0.1;
    s.min = 0;
    s.max = 1;
    const double step = std::sqrt(gain * gain * (prior + r)); // root of K S K'
    Matrix3 after = Matrix3::Zero(), before = Matrix3::Zero();
    after(0, 0) = posterior;
    before(0, 0) = p;
    const Matrix3 Q = adapt_corrected(q * Matrix3::Identity(), s, Vector3(step, 0, 0), after, before, T, 100);
    EXPECT_NEAR(Q(0, 0), q, 1e-12);
}
