// Laws of the paper's filter at an event, at the start and of its readiness; for its flow see test_hrekf_flow.cpp.
#include "hrekf.hpp"
#include "maths/eigenvalues.hpp"

using namespace hnav;
using Event = AttitudeEvent;
using Sample = AttitudeSample;
using hnav::test::distance, hnav::test::random_state;

namespace {

using State = HrekfModel::State;

hnav_hrekf_options settings() { return test::hrekf_options(); }

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

TEST(HrekfJump, TheCorrectionEqualsTheInformationForm) {
    hnav_hrekf_options set = settings();
    set.quaternion_noise_per_sqrt_s = 1;
    const HrekfModel model(set);
    test::Random random(6);
    State s = random_state(model, random);
    const Vector3 bias(s.bias);
    s.x[AttitudeFlow<double>::t] = 0.01; // with a variance of the length
    s.last_correction_s = 0;
    for (double& t : s.last_s) t = 0;
    const Quaternion q(s.x);
    const Square<7> P = test::full_covariance(model, s, 0.01);
    const Vector3 force = random.vector(), field = random.vector();
    model.jump(s, event_at(0.01, force, field));

    Eigen::Matrix<double, 6, 7> H = Eigen::Matrix<double, 6, 7>::Zero();
    H.topLeftCorner<3, 4>() = J_body_q(q, {0, 0, -1});
    H.bottomLeftCorner<3, 4>() = J_body_q(q, field_n(1.0));
    Eigen::Matrix<double, 6, 1> R, nu;
    R << Vector3::Constant(1e-6 / 0.01), Vector3::Constant(4e-6 / 0.01);
    const Matrix3 R_nb = rotation_matrix(q).transpose();
    nu << force.normalized() - R_nb * Vector3(0, 0, -1), field - R_nb * field_n(1.0);
    const auto inverse = [](const Square<7>& A) -> Square<7> { return Cholesky<7>(A).solve<7>(Square<7>::Identity()); };
    const Square<7> posterior = inverse(inverse(P) + H.transpose() * R.cwiseInverse().asDiagonal() * H);
    const Eigen::Matrix<double, 7, 1> step = posterior * H.transpose() * R.cwiseInverse().asDiagonal() * nu;
    const Quaternion raw = q + step.head<4>();
    EXPECT_LT(distance(Quaternion(s.x), raw.normalized()), 1e-9);
    EXPECT_LT(distance(Vector3(s.bias), bias + step.tail<3>()), 1e-9);

    Square<7> J = Square<7>::Identity();
    J.topLeftCorner<4, 4>() = (Eigen::Matrix4d::Identity() - raw.normalized() * raw.normalized().transpose()) / raw.norm();
    EXPECT_LT(distance(test::full_covariance(model, s), J * posterior * J.transpose()), 1e-9);
}

TEST(HrekfJump, LeavesAUnitQuaternionAndACovariance) {
    const HrekfModel model(settings());
    test::Random random(7);
    State s = random_state(model, random);
    s.last_correction_s = 0;
    for (double& t : s.last_s) t = 0;
    model.jump(s, event_at(0.01, random.vector(), random.vector()));
    const Quaternion q(s.x);
    EXPECT_NEAR(q.norm(), 1, 1e-15);
    EXPECT_GT(eigenvalues<6>(unpack<6>(s.P))[0], -1e-15);
    EXPECT_EQ(s.repaired, 0u);
}

// Sigma - K H Sigma subtracts what the Joseph form adds, so it is tested with sensors far better than the prior, repeated
// samples, and priors of very different sizes.
TEST(HrekfJump, TheCovarianceStaysOneWhateverTheSensorsAreWorth) {
    test::Random random(11);
    for (const double density : {1e-3, 1e-6, 1e-9})
        for (const GammaMode mode : {GammaMode::off, GammaMode::relative}) {
            hnav_hrekf_options set = settings();
            set.accel_noise_per_sqrt_hz = set.mag_noise_per_sqrt_hz = density;
            set.gamma_mode = static_cast<int32_t>(mode);
            const HrekfModel model(set);
            State s = random_state(model, random);
            s.last_correction_s = 0;
            for (double& t : s.last_s) t = 0;
            for (int k = 1; k <= 200; ++k) {
                const double t_s = 0.01 * k;
                const Matrix3 R_nb = rotation_matrix(Quaternion(s.x)).transpose();
                const Vector3 force = R_nb * Vector3(0, 0, -9.81), field = R_nb * field_n(1.0);
                model.flow_exactly(s, 0.01);
                model.jump(s, event_at(t_s, force + 1e-3 * random.vector(), field + 1e-3 * random.vector()));
                const Square<6> P = unpack<6>(s.P);
                ASSERT_GT(eigenvalues<6>(P)[0], -1e-14 * P.trace()) << density << " at " << t_s;
            }
            EXPECT_EQ(s.repaired, 0u) << density;
        }
}

TEST(HrekfJump, GammaTowardsInfinityIsTheHekfToRounding) {
    hnav_hrekf_options robust = settings();
    robust.gamma_mode = HNAV_GAMMA_FIXED;
    robust.gamma = 1e8;
    test::Random random(8);
    const HrekfModel hekf(settings()), hrekf(robust);
    State a = random_state(hekf, random);
    a.last_correction_s = 0;
    for (double& t : a.last_s) t = 0;
    State b = a;
    const Event e = event_at(0.01, random.vector(), random.vector());
    hekf.jump(a, e);
    hrekf.jump(b, e);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(a.x[i], b.x[i], 1e-13);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a.bias[i], b.bias[i], 1e-13);
    for (int i = 0; i < 21; ++i) EXPECT_NEAR(a.P[i], b.P[i], 1e-13);
}

TEST(HrekfJump, AGatedSampleIsInflatedUntilItLiesOnTheGate) {
    hnav_hrekf_options set = settings();
    set.accel_gate_nis = 13.9;
    const HrekfModel model(set);
    test::Random random(9);
    State s = random_state(model, random);
    pack<6>(Square<6>(1e-6 * Square<6>::Identity()), s.P);
    s.information = {1e9, 1e9}; // ready
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

TEST(HrekfGates, OfForceStaysAtOneInnovationUnlessItIsSet) {
    hnav_hrekf_options set = settings();
    const auto nis = [&](double noise, double gate) {
        set.accel_noise_per_sqrt_hz = noise;
        set.accel_gate_nis = gate;
        return HrekfGates(set).nis[accel];
    };
    EXPECT_EQ(nis(0.115, -1), 0.13);
    EXPECT_DOUBLE_EQ(nis(0.0575, -1), 4 * 0.13);
    EXPECT_EQ(nis(1e-3, -1), 13.9);
    EXPECT_EQ(nis(1, -1), 0.13);
    EXPECT_EQ(nis(1e-3, 0), 0);
    EXPECT_EQ(nis(1e-3, 5), 5);
}

TEST(HrekfJump, TheHeadingRowEqualsAPerturbation) {
    // A heading sample with very small noise sets the yaw and leaves roll and pitch, for any attitude that is not vertical.
    hnav_hrekf_options set = settings();
    const HrekfModel model(set);
    test::Random random(10);
    for (int i = 0; i < 20; ++i) {
        State s = random_state(model, random);
        const Quaternion q(s.x);
        const Vector3 before = roll_pitch_yaw(q);
        if (std::fabs(before[1]) > 1.2) continue;
        Square<6> P = Square<6>::Zero();
        P.diagonal() << 1e-12, 1e-12, 1e-2, 0, 0, 0;
        pack<6>(P, s.P);
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
    hnav_hrekf_options set = settings();
    set.start_mode = HNAV_START_TRIAD;
    set.reference_mode = HNAV_REFERENCE_LEARNT;
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
    const Vector3 variance = model.rotation_covariance(s).diagonal();
    EXPECT_LT(distance(variance, Vector3(0.01, 0.01, 0.09)), 1e-12);
}

TEST(HrekfReady, HeadingIsNotReadyWithoutAMagnetometerHoweverSmallTheClaim) {
    hnav_hrekf_options set = settings();
    set.start_mode = HNAV_START_HEADING;
    set.start_sigma_heading_rad = 0.01; // below the threshold from the beginning
    set.start_sigma_tilt_rad = 0.01;
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
    EXPECT_GT(std::sqrt(model.rotation_covariance(s)(2, 2)), 0.01);
}
