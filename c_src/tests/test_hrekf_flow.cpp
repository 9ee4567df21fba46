// Laws of the flow of the paper's filter: its covariance is that of its state, and its closed form its integral.
#include "hrekf.hpp"
#include "hybrid/propagator.hpp"
#include "maths/cholesky.hpp"

using namespace hnav;
using hnav::test::distance, hnav::test::random_state;

namespace {

using State = HrekfModel::State;
using Vector35 = Eigen::Matrix<double, HrekfModel::nx, 1>;

constexpr double deg = M_PI / 180;

hnav_hrekf_options settings() { return test::hrekf_options(); }

Vector35 flow(const HrekfModel& model, const State& s, const Vector35& x) {
    Vector35 dx;
    model.flow(s, x.data(), dx.data());
    return dx;
}

} // namespace

TEST(HrekfFlow, TheDirectionalDerivativeEqualsAPerturbation) {
    const HrekfModel model(settings());
    test::Random random(1);
    const State s = random_state(model, random);
    const Vector35 x = Eigen::Map<const Vector35>(s.x);
    const auto J = test::perturbation_jacobian<35, 35>([&](const Vector35& y) { return flow(model, s, y); }, x);
    for (int j = 0; j < 35; ++j) {
        const Vector35 seed = Vector35::Unit(j);
        Vector35 out;
        model.flow_along(s, x.data(), seed.data(), out.data());
        EXPECT_LT(distance(out, J.col(j)), 1e-7) << "state " << j;
    }
}

// P' = A P + P A' + L Q L' with A the Jacobian of the flow of q and b itself: the errata of (9) to (11) broke this.
TEST(HrekfFlow, TheCovarianceFollowsTheJacobianOfTheState) {
    const HrekfModel model(settings());
    test::Random random(2);
    const State s = random_state(model, random);
    const Vector35 x = Eigen::Map<const Vector35>(s.x);
    const auto f = [&](const HrekfModel::Vector7& y) -> HrekfModel::Vector7 {
        Vector35 full = x;
        full.head<7>() = y;
        return flow(model, s, full).head<7>();
    };
    const Square<7> A = test::perturbation_jacobian<7, 7>(f, HrekfModel::Vector7(x.head<7>()));
    Eigen::Matrix<double, 7, 6> L = Eigen::Matrix<double, 7, 6>::Zero();
    L.topLeftCorner<4, 3>() = -Xi(Quaternion(s.x));
    L.bottomRightCorner<3, 3>().setIdentity();
    Eigen::Matrix<double, 6, 1> q;
    q << 1e-4, 1e-4, 1e-4, 1e-6, 1e-6, 1e-6;
    const Square<7> P = unpack<7>(s.x + 7);
    const Square<7> expected = A * P + P * A.transpose() + L * q.asDiagonal() * L.transpose();
    const Vector35 dx = flow(model, s, x);
    EXPECT_LT(distance(unpack<7>(dx.data() + 7), expected), 1e-9);
}

TEST(HrekfFlow, TheClosedFormIsTheIntegralOfTheFlow) {
    for (const double rate : {0.0, 1e-6, 1.9, 2.1, 20.0})
        for (const double interval_s : {1e-3, 0.01, 0.3, 2.0}) {
            hnav_hrekf_options with_noise = settings();
            with_noise.quaternion_noise_per_sqrt_s = std::sqrt(1e-5);
            const HrekfModel model(with_noise);
            test::Random random(3);
            State exact = random_state(model, random, 0);
            Eigen::Map<Vector3>(exact.rate) = Vector3(exact.x + 4) + rate * Vector3(0.48, -0.6, 0.64);
            pack<3>(random.covariance<3>(1e-4), exact.bias_psd);
            State integrated = exact;
            model.flow_exactly(exact, interval_s);

            Propagator propagator;
            Propagator::Settings p;
            double atol[35];
            for (double& a : atol) a = 1e-16;
            p.rtol = 1e-13;
            p.atol = atol;
            struct Context {
                const HrekfModel* model;
                const State* held;
            } context{&model, &integrated};
            const auto f = [](const void* c, const double* x, double* dx) {
                static_cast<const Context*>(c)->model->flow(*static_cast<const Context*>(c)->held, x, dx);
                return 0;
            };
            double x[35];
            std::memcpy(x, integrated.x, sizeof x);
            ASSERT_TRUE(propagator.create(35, f, p, &context, x));
            ASSERT_TRUE(propagator.integrate(&context, interval_s, x));
            for (int i = 0; i < 35; ++i)
                EXPECT_NEAR(exact.x[i], x[i], 2e-11) << "rate " << rate << " T " << interval_s << " state " << i;
        }
}

// P7 = G P6 G' with G = blkdiag(Xi, I): the six-state error form is the same filter in other coordinates.
TEST(HrekfFlow, TheErrorStateFormIsItsTwin) {
    const HrekfModel model(settings());
    test::Random random(4);
    State s = random_state(model, random, 5);
    Square<6> P6 = random.covariance<6>(0.01);
    const auto G = [](const double* q) {
        Eigen::Matrix<double, 7, 6> g = Eigen::Matrix<double, 7, 6>::Zero();
        g.topLeftCorner<4, 3>() = Xi(Quaternion(q));
        g.bottomRightCorner<3, 3>().setIdentity();
        return g;
    };
    pack<7>(Square<7>(G(s.x) * P6 * G(s.x).transpose()), s.x + 7);

    // theta' = -[u]x theta - db: Runge-Kutta in small steps.
    const Vector3 u = Vector3(s.rate) - Vector3(s.x + 4);
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
    EXPECT_LT(distance(unpack<7>(s.x + 7), G(s.x) * P6 * G(s.x).transpose()), 1e-11);
}

// 20 000 bodies with random starts, gyro noise and bias walk against the covariance that the flow claims.
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
    const Vector3 b0(s.x + 4), w(s.rate);
    Square<7> P = Square<7>::Zero();
    P.topLeftCorner<4, 4>() = sigma_theta * sigma_theta * Xi(q0) * Xi(q0).transpose();
    P.bottomRightCorner<3, 3>().diagonal().setConstant(sigma_b * sigma_b);
    pack<7>(P, s.x + 7);
    model.flow_exactly(s, T);
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
    // Whitened by the claim, the sample covariance has eigenvalues 1 +- a few root(2/runs): the extremes of 6 within 5 %.
    EXPECT_TRUE(Cholesky<6>(sample - 0.95 * claimed).positive());
    EXPECT_TRUE(Cholesky<6>(1.05 * claimed - sample).positive());
}
