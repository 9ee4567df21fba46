#include "attitude/hrekf/hrekf_model.hpp"
#include "hybrid/filter.hpp"
#include "laws.hpp"

#include <Eigen/LU>
#include <vector>

using namespace hnav;
using hnav::test::distance;

namespace {

using State = HrekfModel::State;
using Vector35 = Eigen::Matrix<double, HrekfModel::nx, 1>;
using HrekfFilter = Filter<HrekfModel>;

constexpr double deg = M_PI / 180;

HrekfModel::Settings settings() {
    HrekfModel::Settings s{};
    s.gyro_psd = 1e-4;
    s.bias_walk_psd = 1e-6;
    s.accel_density2 = 1e-6;
    s.mag_density2 = 4e-6;
    s.interval_limit_s = 0.1;
    s.start.mode = StartMode::attitude;
    s.start.samples = 1;
    s.sigma_tilt = 0.1;
    s.start.sigma_heading = 0.3;
    s.sigma_bias = 0.05;
    s.reference_given = true;
    s.reference = {1, 1.0};
    s.ready_tilt_rad = 2 * deg;
    s.ready_heading_rad = 5 * deg;
    return s;
}

State random_state(const HrekfModel& model, test::Random& random, double rate = 3) {
    State s;
    std::memset(static_cast<void*>(&s), 0, sizeof s);
    model.begin(s);
    Eigen::Map<Quaternion>(s.x) = random.quaternion();
    Eigen::Map<Vector3>(s.x + 4) = random.vector(0.05);
    pack<7>(random.covariance<7>(0.01), s.x + 7);
    Eigen::Map<Vector3>(s.rate) = random.vector(rate);
    s.has_rate = s.started = 1;
    return s;
}

Vector35 flow(const HrekfModel& model, const State& s, const Vector35& x) {
    Vector35 dx;
    model.flow(s, x.data(), dx.data());
    return dx;
}

Event event_at(double t_s, const Vector3& force, const Vector3& field) {
    Event e{};
    e.t_s = t_s;
    Sample sample{t_s, accel, {force[0], force[1], force[2]}};
    e.add(sample);
    sample = {t_s, mag, {field[0], field[1], field[2]}};
    e.add(sample);
    return e;
}

Vector3 field_n(double dip) { return {std::cos(dip), 0, std::sin(dip)}; }

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
            HrekfModel::Settings with_noise = settings();
            with_noise.quaternion_psd = 1e-5;
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
    HrekfModel::Settings set = settings();
    set.gyro_psd = std::pow(0.3 * deg, 2);
    set.bias_walk_psd = std::pow(0.05 * deg, 2);
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
    // Whitened by the claim, the sample covariance has eigenvalues 1 +- a few root(2/runs); the extremes of 6 within 5 %.
    const Square<6> W = Square<6>(claimed).llt().matrixL();
    const Square<6> white = W.inverse() * sample * W.inverse().transpose();
    const auto eigenvalues = Eigen::SelfAdjointEigenSolver<Square<6>>(white).eigenvalues().eval();
    EXPECT_GT(eigenvalues[0], 0.95);
    EXPECT_LT(eigenvalues[5], 1.05);
}

TEST(HrekfJump, TheCorrectionEqualsTheInformationForm) {
    const HrekfModel model(settings());
    test::Random random(6);
    State s = random_state(model, random);
    s.last_correction_s = 0;
    for (double& t : s.last_s) t = 0;
    const Quaternion q(s.x);
    const Square<7> P = unpack<7>(s.x + 7);
    const Vector3 force = random.vector(), field = random.vector();
    model.jump(s, event_at(0.01, force, field));

    Eigen::Matrix<double, 6, 7> H = Eigen::Matrix<double, 6, 7>::Zero();
    H.topLeftCorner<3, 4>() = J_body_q(q, {0, 0, -1});
    H.bottomLeftCorner<3, 4>() = J_body_q(q, field_n(1.0));
    Eigen::Matrix<double, 6, 1> R, nu;
    R << Vector3::Constant(1e-6 / 0.01), Vector3::Constant(4e-6 / 0.01);
    const Matrix3 R_nb = rotation_matrix(q).transpose();
    nu << force.normalized() - R_nb * Vector3(0, 0, -1), field - R_nb * field_n(1.0);
    const Square<7> posterior = (P.inverse() + H.transpose() * R.cwiseInverse().asDiagonal() * H).inverse();
    HrekfModel::Vector7 x;
    x << q, Vector3::Zero();
    const HrekfModel::Vector7 step = posterior * H.transpose() * R.cwiseInverse().asDiagonal() * nu;
    const Quaternion raw = q + step.head<4>();
    EXPECT_LT(distance(Quaternion(s.x), raw.normalized()), 1e-9);

    Square<7> J = Square<7>::Identity();
    J.topLeftCorner<4, 4>() = (Eigen::Matrix4d::Identity() - raw.normalized() * raw.normalized().transpose()) / raw.norm();
    EXPECT_LT(distance(unpack<7>(s.x + 7), J * posterior * J.transpose()), 1e-9);
}

TEST(HrekfJump, LeavesAUnitQuaternionWithoutUncertaintyAlongItself) {
    const HrekfModel model(settings());
    test::Random random(7);
    State s = random_state(model, random);
    s.last_correction_s = 0;
    for (double& t : s.last_s) t = 0;
    model.jump(s, event_at(0.01, random.vector(), random.vector()));
    const Quaternion q(s.x);
    const Square<7> P = unpack<7>(s.x + 7);
    EXPECT_NEAR(q.norm(), 1, 1e-15);
    EXPECT_LT((P.topLeftCorner<7, 4>() * q).cwiseAbs().maxCoeff(), 1e-15);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Square<7>>(P).eigenvalues()[0], -1e-15);
    EXPECT_EQ(s.repaired, 0u);
}

TEST(HrekfJump, GammaTowardsInfinityIsTheHekfToRounding) {
    HrekfModel::Settings robust = settings();
    robust.robust.mode = GammaMode::fixed;
    robust.robust.gamma = 1e8;
    test::Random random(8);
    const HrekfModel hekf(settings()), hrekf(robust);
    State a = random_state(hekf, random);
    a.last_correction_s = 0;
    for (double& t : a.last_s) t = 0;
    State b = a;
    const Event e = event_at(0.01, random.vector(), random.vector());
    hekf.jump(a, e);
    hrekf.jump(b, e);
    for (int i = 0; i < 35; ++i) EXPECT_NEAR(a.x[i], b.x[i], 1e-13);
}

TEST(HrekfJump, AGatedSampleIsInflatedUntilItLiesOnTheGate) {
    HrekfModel::Settings set = settings();
    set.gate_nis[accel] = 13.9;
    const HrekfModel model(set);
    test::Random random(9);
    State s = random_state(model, random);
    pack<7>(Square<7>(1e-6 * Square<7>::Identity()), s.x + 7);
    s.tilt_information = s.heading_information = 1e9; // ready
    s.last_correction_s = 0;
    for (double& t : s.last_s) t = 0;
    const Quaternion q(s.x);
    const Matrix3 R_nb = rotation_matrix(q).transpose();
    const Vector3 push(0.5, 0, 0);
    State ungated = s;
    model.jump(s, event_at(0.01, R_nb * Vector3(0, 0, -1) + push, R_nb * field_n(1.0)));
    HrekfModel(settings()).jump(ungated, event_at(0.01, R_nb * Vector3(0, 0, -1) + push, R_nb * field_n(1.0)));
    EXPECT_EQ(s.gated[accel], 1u);
    EXPECT_EQ(s.gated[mag], 0u);
    EXPECT_GT(s.innovation[accel].noise_scale, 1);
    const double moved = std::acos(std::fmin(1, std::fabs(Quaternion(s.x).dot(q))));
    const double moved_ungated = std::acos(std::fmin(1, std::fabs(Quaternion(ungated.x).dot(q))));
    EXPECT_LT(moved, 0.5 * moved_ungated);
}

TEST(HrekfJump, TheHeadingRowEqualsAPerturbation) {
    // A heading sample of tiny noise pulls the yaw to itself and leaves roll and pitch, for any attitude but vertical.
    HrekfModel::Settings set = settings();
    const HrekfModel model(set);
    test::Random random(10);
    for (int i = 0; i < 20; ++i) {
        State s = random_state(model, random);
        const Quaternion q(s.x);
        const Vector3 before = roll_pitch_yaw(q);
        if (std::fabs(before[1]) > 1.2) continue;
        const Matrix34 T = [&] {
            Matrix34 t;
            t << -q[1], q[0], -q[3], q[2], -q[2], q[3], q[0], -q[1], -q[3], -q[2], q[1], q[0];
            return Matrix34(2 * t);
        }();
        Square<7> P = Square<7>::Zero();
        P.topLeftCorner<4, 4>() = T.transpose() * Vector3(1e-12, 1e-12, 1e-2).asDiagonal() * T / 16;
        pack<7>(P, s.x + 7);
        s.last_correction_s = 0;
        Event e{};
        e.t_s = 0.01;
        Sample sample{0.01, heading, {before[2] + 1e-3, 1e-6, 0}};
        e.add(sample);
        model.jump(s, e);
        const Vector3 after = roll_pitch_yaw(Quaternion(s.x));
        EXPECT_NEAR(after[2], before[2] + 1e-3, 2e-7);
        EXPECT_NEAR(after[0], before[0], 1e-6);
        EXPECT_NEAR(after[1], before[1], 1e-6);
    }
}

TEST(HrekfStart, WaitsForForceAndField) {
    HrekfModel::Settings set = settings();
    set.start.mode = StartMode::triad;
    set.reference_given = false;
    const HrekfModel model(set);
    State s;
    std::memset(static_cast<void*>(&s), 0, sizeof s);
    model.begin(s);
    const Quaternion q = test::Random(11).quaternion();
    const Matrix3 R_nb = rotation_matrix(q).transpose();
    const Vector3 force = R_nb * Vector3(0, 0, -9.81), field = R_nb * (5e-5 * field_n(0.9));
    Event e{};
    e.t_s = 1;
    Sample sample{1, accel, {force[0], force[1], force[2]}};
    e.add(sample);
    model.jump(s, e);
    EXPECT_FALSE(s.started);
    e = Event{};
    e.t_s = 1.5;
    sample = {1.5, mag, {field[0], field[1], field[2]}};
    e.add(sample);
    model.jump(s, e);
    ASSERT_TRUE(s.started);
    EXPECT_GT(std::fabs(Quaternion(s.x).dot(q)), 1 - 1e-12);
    EXPECT_NEAR(s.reference_strength, 5e-5, 1e-15);
    EXPECT_NEAR(std::atan2(s.reference_down, s.reference_north), 0.9, 1e-12);
    EXPECT_FALSE(model.estimate(s).heading_ready); // a first guess is not information
    const Vector3 variance = model.rotation_variances(s);
    EXPECT_LT(distance(variance, Vector3(0.01, 0.01, 0.09)), 1e-12);
}

TEST(HrekfReady, HeadingIsNotReadyWithoutAMagnetometerHoweverSmallTheClaim) {
    HrekfModel::Settings set = settings();
    set.start.mode = StartMode::heading;
    set.start.sigma_heading = 0.01; // below the threshold from the beginning
    set.sigma_tilt = 0.01;
    const HrekfModel model(set);
    State s;
    std::memset(static_cast<void*>(&s), 0, sizeof s);
    model.begin(s);
    for (int k = 0; k < 2000; ++k) {
        Event e{};
        e.t_s = 0.01 * k;
        Sample sample{e.t_s, accel, {0, 0, -9.81}};
        e.add(sample);
        sample = {e.t_s, gyro, {0, 0, 0}};
        e.add(sample);
        if (k > 0) model.flow_exactly(s, 0.01);
        model.jump(s, e);
    }
    EXPECT_TRUE(model.estimate(s).tilt_ready);
    EXPECT_FALSE(model.estimate(s).heading_ready);
    EXPECT_GT(std::sqrt(model.rotation_variances(s)[2]), 0.01);
}
