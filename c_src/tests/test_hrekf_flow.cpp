// Laws of the flow of the paper's filter: its covariance is that of its state, and its closed form equals the integral.
#include "hrekf.hpp"
#include "hybrid/propagator.hpp"
#include "maths/cholesky.hpp"

using namespace hnav;
using hnav::test::distance, hnav::test::random_state;

namespace {

using State = HrekfModel::State;
using Vector7 = Eigen::Matrix<double, 7, 1>;
using VectorX = Eigen::Matrix<double, HrekfModel::nx, 1>;

constexpr double deg = M_PI / 180;

hnav_hrekf_options settings() { return test::hrekf_options(); }

VectorX flow(const HrekfModel& model, const State& s, const VectorX& x) {
    VectorX dx;
    model.flow(s, x.data(), dx.data());
    return dx;
}

// A sample of the rate, held from then on.
void take_rate(const HrekfModel& model, State& s, double t_s, const Vector3& rate) {
    AttitudeEvent e{};
    e.t_s = t_s;
    AttitudeSample sample{t_s, gyro, {rate[0], rate[1], rate[2]}};
    e.add(sample);
    model.jump(s, e);
}

// The paper's flow with all its 35 states: q, b and the upper triangle of P' = A P + P A' + L Qc L'.
struct FullFlow {
    static constexpr int nx = 35;
    Vector3 rate;
    double gyro_psd, quaternion_psd;
    Matrix3 Q;

    static Vector7 of_state(const Vector3& rate, const Vector7& y) {
        Vector7 dy = Vector7::Zero();
        dy.head<4>() = Omega<double>(rate - y.tail<3>()) * y.head<4>();
        return dy;
    }
    static Square<7> jacobian(const Vector3& rate, const Vector7& y) {
        Square<7> A = Square<7>::Zero();
        A.topLeftCorner<4, 4>() = Omega<double>(rate - y.tail<3>());
        A.topRightCorner<4, 3>() = -Xi<double>(y.head<4>());
        return A;
    }
    void operator()(const double* x, double* dx) const {
        const Vector7 y = Eigen::Map<const Vector7>(x);
        const Square<7> P = unpack<7>(x + 7), AP = jacobian(rate, y) * P;
        Square<7> noise = Square<7>::Zero();
        const Matrix43 L = Xi<double>(y.head<4>());
        noise.topLeftCorner<4, 4>() = gyro_psd * L * L.transpose() + quaternion_psd * Square<4>::Identity();
        noise.bottomRightCorner<3, 3>() = Q;
        Eigen::Map<Vector7> slope(dx);
        slope = of_state(rate, y);
        pack<7>(Square<7>(AP + AP.transpose() + noise), dx + 7);
    }
};

// By ERKStep with tolerances near rounding.
template <int nx, class Flow>
void integrate(const Flow& flow, double interval_s, double* x) {
    double atol[nx];
    std::fill(atol, atol + nx, 1e-18);
    Propagator::Settings settings;
    settings.rtol = 1e-14;
    settings.atol = atol;
    settings.max_steps = 1000000;
    const auto f = [](const void* context, const double* y, double* dy) {
        (*static_cast<const Flow*>(context))(y, dy);
        return 0;
    };
    Propagator propagator;
    ASSERT_TRUE(propagator.create(nx, f, settings, &flow, x));
    ASSERT_TRUE(propagator.integrate(&flow, interval_s, x));
}

} // namespace

TEST(HrekfFlow, TheDirectionalDerivativeEqualsAPerturbation) {
    const HrekfModel model(settings());
    test::Random random(1);
    const State s = random_state(model, random);
    const VectorX x = Eigen::Map<const VectorX>(s.x);
    const auto J =
        test::perturbation_jacobian<HrekfModel::nx, HrekfModel::nx>([&](const VectorX& y) { return flow(model, s, y); }, x);
    for (int j = 0; j < HrekfModel::nx; ++j) {
        const VectorX seed = VectorX::Unit(j);
        VectorX out;
        model.flow_along(s, x.data(), seed.data(), out.data());
        EXPECT_LT(distance(out, J.col(j)), 1e-7) << "state " << j;
    }
}

// The errata of (9) to (11) violate this law.
TEST(HrekfFlow, TheFullSystemHasTheJacobianOfItsState) {
    test::Random random(2);
    const Vector3 rate = random.vector(3);
    Vector7 y;
    y << random.quaternion(), random.vector(0.05);
    const auto J = test::perturbation_jacobian<7, 7>([&](const Vector7& z) { return FullFlow::of_state(rate, z); }, y);
    EXPECT_LT(distance(FullFlow::jacobian(rate, y), J), 1e-9);
}

// From one correction to the next, over ten intervals of different rates: the transition by the integral of the rotation matrix
// against the integral of all 28 numbers of the covariance. With a walk that is the same for all axes, and with a full matrix.
TEST(HrekfFlow, TheTransitionOfTheCovarianceIsThatOfTheFullSystem) {
    for (const bool even : {true, false})
        for (const double largest : {1e-6, 1.0, 20.0})
            for (const double interval_s : {0.001, 0.01, 0.1}) {
                hnav_hrekf_options set = settings();
                set.adaptation = even ? HNAV_ADAPTATION_OFF : HNAV_ADAPTATION_PAPER;
                set.quaternion_noise_per_sqrt_s = 3e-3;
                set.gyro_bias_walk_rad_s_per_sqrt_s = 0.1;
                const HrekfModel model(set);
                test::Random random(3);
                State s = random_state(model, random, largest);
                if (!even) pack<3>(random.covariance<3>(0.01), s.bias_psd);
                FullFlow full{Vector3(s.rate), 1e-4, 9e-6, unpack<3>(s.bias_psd)};
                double x[FullFlow::nx];
                std::copy(s.x, s.x + 4, x);
                std::copy(s.bias, s.bias + 3, x + 4);
                pack<7>(test::full_covariance(model, s), x + 7);
                for (int k = 1; k <= 10; ++k) {
                    model.flow_exactly(s, interval_s);
                    integrate<FullFlow::nx>(full, interval_s, x);
                    full.rate = random.vector(largest);
                    take_rate(model, s, k * interval_s, full.rate);
                }
                const Square<7> P = test::full_covariance(model, s, 9e-6 * 10 * interval_s), expected = unpack<7>(x + 7);
                const Vector7 sigma = expected.diagonal().cwiseSqrt();
                EXPECT_LT((P - expected).cwiseQuotient(sigma * sigma.transpose()).cwiseAbs().maxCoeff(), 1e-12)
                    << "even " << even << ", rates " << largest << " rad/s, " << interval_s << " s";
                EXPECT_LT(distance(Quaternion(s.x), Quaternion(x)), 1e-12);
            }
}

TEST(HrekfFlow, TheClosedFormIsTheIntegralOfTheFlow) {
    for (const double rate : {0.0, 1e-6, 1.9, 2.1, 20.0})
        for (const double interval_s : {1e-3, 0.01, 0.3, 2.0}) {
            const HrekfModel model(settings());
            test::Random random(3);
            State exact = random_state(model, random, 0);
            Eigen::Map<Vector3>(exact.rate) = Vector3(exact.bias) + rate * Vector3(0.48, -0.6, 0.64);
            const State held = exact;
            double x[HrekfModel::nx];
            std::memcpy(x, exact.x, sizeof x);
            model.flow_exactly(exact, interval_s);
            integrate<HrekfModel::nx>([&](const double* y, double* dy) { model.flow(held, y, dy); }, interval_s, x);
            for (int i = 0; i < HrekfModel::nx; ++i)
                EXPECT_NEAR(exact.x[i], x[i], 1e-12) << "rate " << rate << " T " << interval_s << " state " << i;
        }
}

// The error in body axes, theta' = -[u]x theta - db: the same filter in other coordinates.
TEST(HrekfFlow, TheErrorStateFormIsItsTwin) {
    const HrekfModel model(settings());
    test::Random random(4);
    State s = random_state(model, random, 5);
    Square<6> P6 = random.covariance<6>(0.01);
    const auto navigation_axes = [&] {
        Square<6> G = Square<6>::Identity();
        G.topLeftCorner<3, 3>() = rotation_matrix(Quaternion(s.x));
        return G;
    };
    pack<6>(Square<6>(navigation_axes() * P6 * navigation_axes().transpose()), s.P);

    const Vector3 u = Vector3(s.rate) - Vector3(s.bias); // Runge-Kutta in small steps
    Square<6> F = Square<6>::Zero(), Q = Square<6>::Zero();
    F.topLeftCorner<3, 3>() = -cross_matrix(u);
    F.topRightCorner<3, 3>() = -Matrix3::Identity();
    Q.diagonal() << 1e-4, 1e-4, 1e-4, 1e-6, 1e-6, 1e-6;
    const auto slope = [&](const Square<6>& P) -> Square<6> { return F * P + P * F.transpose() + Q; };
    const double h = 0.5 / 4000;
    for (int k = 0; k < 4000; ++k) {
        const Square<6> k1 = slope(P6), k2 = slope(P6 + h / 2 * k1), k3 = slope(P6 + h / 2 * k2), k4 = slope(P6 + h * k3);
        P6 += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    model.flow_exactly(s, 0.5);
    take_rate(model, s, 0.5, Vector3::Zero());
    EXPECT_LT(distance(model.error_covariance(s), navigation_axes() * P6 * navigation_axes().transpose()), 1e-11);
}

// 20 000 bodies with random starts, gyro noise and bias walk against the covariance of the flow.
TEST(HrekfFlow, TheCovarianceIsThatOfManyRuns) {
    hnav_hrekf_options set = settings();
    set.gyro_noise_rad_per_sqrt_s = 0.3 * deg;
    set.gyro_bias_walk_rad_s_per_sqrt_s = 0.05 * deg;
    const HrekfModel model(set);
    test::Random random(5);
    State s = random_state(model, random, 0);
    const double sigma_theta = 1 * deg, sigma_b = 0.2 * deg, T = 4;
    Eigen::Map<Vector3>(s.rate) = Vector3(0.5, -0.9, 0.7);
    const Quaternion q0(s.x);
    const Vector3 b0(s.bias), w(s.rate);
    Square<6> P = Square<6>::Zero();
    P.diagonal() << Vector3::Constant(sigma_theta * sigma_theta), Vector3::Constant(sigma_b * sigma_b);
    pack<6>(P, s.P);
    model.flow_exactly(s, T);
    take_rate(model, s, T, w);
    const auto claimed = model.error_covariance(s);
    const Quaternion q_end = Quaternion(s.x).normalized();

    constexpr int runs = 20000, steps = 400;
    const double h = T / steps;
    ErrorCovariance sample = ErrorCovariance::Zero();
    for (int r = 0; r < runs; ++r) {
        Quaternion q = multiply(q0, rotation_quaternion(random.vector(sigma_theta)));
        Vector3 b = b0 + random.vector(sigma_b);
        for (int k = 0; k < steps; ++k) {
            const Vector3 b_next = b + random.vector(0.05 * deg * std::sqrt(h));
            q = multiply(q, rotation_quaternion((w - 0.5 * (b + b_next)) * h + random.vector(0.3 * deg * std::sqrt(h))));
            b = b_next;
        }
        Quaternion e = multiply(q, conjugate(q_end)); // about the navigation axes
        if (e[0] < 0) e = -e;
        Eigen::Matrix<double, 6, 1> error;
        error << 2 * e.tail<3>(), b - b0;
        sample += error * error.transpose() / runs;
    }
    // Whitened by the stated covariance, the sample covariance has eigenvalues 1 +- a few root(2/runs): the extremes of 6 are
    // within 5 %.
    EXPECT_TRUE(Cholesky<6>(sample - 0.95 * claimed).positive());
    EXPECT_TRUE(Cholesky<6>(1.05 * claimed - sample).positive());
}
