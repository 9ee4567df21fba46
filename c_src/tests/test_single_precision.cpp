// The attitude filters in single precision, for processors without double: the same sources with HNAV_SCALAR = float, beside
// the double ones on the same samples.
#include "ahrs.hpp"
#include "hrekf.hpp"

using namespace hnav;
using hnav::test::state_at_start, hnav::test::Turning;

namespace {

constexpr double deg = M_PI / 180;
constexpr double interval_s = 0.005;

// Continues for `legs` seconds; each second the axis of the rotation changes, so that every bias is observable.
template <class Step>
Quaternion tumble(int legs, const Vector3& bias, Step&& step) {
    Turning motion;
    motion.bias = bias;
    for (int leg = 0; leg < legs; ++leg) {
        if (leg > 0) motion.start_q = motion.q(1);
        motion.rate_b = Vector3(std::sin(1.7 * leg), std::cos(2.3 * leg), std::sin(0.9 * leg + 1));
        for (int k = leg > 0 ? 1 : 0; k <= 200; ++k) {
            AttitudeEvent e = motion.event(interval_s * k, k % 4 == 0);
            e.t_s += leg;
            step(e);
        }
    }
    return motion.q(1);
}

template <class Model>
void take(const Model& model, typename Model::State& s, const AttitudeEvent& event) {
    model.before_flow(s, event);
    if (model.flows(s)) model.flow_exactly(s, interval_s);
    model.jump(s, event);
}

struct Difference {
    double attitude_rad = 0, bias_rad_s = 0, sigma = 0; // largest difference; of sigma relative
};

// Both on the same samples: their largest difference, and the final error of the single one.
template <class Single, class Double>
Difference run_both(const Single& single, const Double& twice, int legs, const Vector3& bias, double* error_rad) {
    auto s = state_at_start(single);
    auto d = state_at_start(twice);
    Difference most;
    const Quaternion truth = tumble(legs, bias, [&](const AttitudeEvent& e) {
        take(single, s, e);
        take(twice, d, e);
        if (!single.estimate(s).started) return;
        const Estimate a = single.estimate(s), b = twice.estimate(d);
        const Matrix3 P = single.rotation_covariance(s), Q = twice.rotation_covariance(d);
        most.attitude_rad =
            std::fmax(most.attitude_rad, rotation_vector(multiply(a.q_bn, conjugate(b.q_bn)).normalized()).norm());
        most.bias_rad_s = std::fmax(most.bias_rad_s, (a.bias_b - b.bias_b).cwiseAbs().maxCoeff());
        for (int i = 0; i < 3; ++i) most.sigma = std::fmax(most.sigma, std::fabs(std::sqrt(P(i, i) / Q(i, i)) - 1));
    });
    EXPECT_EQ(single.estimate(s).started, twice.estimate(d).started);
    EXPECT_EQ(s.repaired, 0u);
    *error_rad = rotation_vector(multiply(single.estimate(s).q_bn, conjugate(truth)).normalized()).norm();
    return most;
}

// The limits are a few times the measured values: 5e-4 deg, 2e-6 rad/s and a ten-thousandth of a sigma.
void expect_near(const Difference& most) {
    EXPECT_LT(most.attitude_rad, 2e-3 * deg);
    EXPECT_LT(most.bias_rad_s, 1e-5);
    EXPECT_LT(most.sigma, 1e-3);
}

template <class R>
AhrsModelOf<R> ahrs() {
    hnav_ahrs_options o = test::ahrs_options();
    o.gamma_mode = HNAV_GAMMA_RELATIVE;
    o.gamma_relative_rate_1_s = 1;
    return AhrsModelOf<R>(o);
}

template <class R>
HrekfModelOf<R> hrekf(GammaMode mode, Adaptation adaptation) {
    hnav_hrekf_options o = test::hrekf_options();
    o.start_mode = HNAV_START_TRIAD;
    o.reference_mode = HNAV_REFERENCE_LEARNT;
    o.gamma_mode = static_cast<int32_t>(mode);
    o.gamma = 100;
    o.adaptation = static_cast<int32_t>(adaptation);
    o.adaptation_min_rad_s_per_sqrt_s = 1e-5;
    o.adaptation_max_rad_s_per_sqrt_s = 1e-3;
    return HrekfModelOf<R>(o);
}

} // namespace

TEST(SinglePrecision, TheAhrsStaysBesideItsTwin) {
    double error_rad;
    expect_near(run_both(ahrs<float>(), ahrs<double>(), 30, {0.01, -0.006, 0.004}, &error_rad));
    EXPECT_LT(error_rad, 0.2 * deg);
}

TEST(SinglePrecision, ThePapersFilterStaysBesideItsTwin) {
    for (const GammaMode mode : {GammaMode::off, GammaMode::fixed, GammaMode::relative, GammaMode::kl})
        for (const Adaptation adaptation : {Adaptation::off, Adaptation::corrected}) {
            SCOPED_TRACE(testing::Message() << "mode " << int(mode) << ", adaptation " << int(adaptation));
            double error_rad;
            expect_near(
                run_both(hrekf<float>(mode, adaptation), hrekf<double>(mode, adaptation), 10, {0.01, -0.006, 0.004}, &error_rad));
            EXPECT_LT(error_rad, 0.2 * deg);
        }
}
