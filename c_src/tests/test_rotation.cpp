#include "attitude/common/first_attitude.hpp"
#include "attitude/common/frames.hpp"
#include "laws.hpp"

using namespace hnav;
using hnav::test::distance;

TEST(Rotation, AQuaternionTimesItsConjugateIsOne) {
    test::Random random(1);
    for (int i = 0; i < 100; ++i) {
        const Quaternion q = random.quaternion();
        EXPECT_LT(distance(multiply(q, conjugate(q)), Quaternion(1, 0, 0, 0)), 1e-15);
    }
}

TEST(Rotation, TheMatrixTurnsVectorsAsTheQuaternionDoes) {
    test::Random random(2);
    for (int i = 0; i < 100; ++i) {
        const Quaternion q = random.quaternion();
        const Vector3 v = random.vector();
        const Quaternion turned = multiply(multiply(q, Quaternion(0, v[0], v[1], v[2])), conjugate(q));
        EXPECT_LT(distance(rotation_matrix(q) * v, turned.tail<3>()), 1e-14);
    }
}

TEST(Rotation, XiIsHalfTheProductWithAPureQuaternion) {
    test::Random random(3);
    const Quaternion q = random.quaternion();
    const Vector3 u = random.vector();
    EXPECT_LT(distance(Xi(q) * u, 0.5 * multiply(q, Quaternion(0, u[0], u[1], u[2]))), 1e-15);
    EXPECT_LT(distance(Xi(q).transpose() * Xi(q), 0.25 * Matrix3::Identity()), 1e-15);
}

TEST(Rotation, TheJacobianOfABodyVectorEqualsAPerturbation) {
    test::Random random(4);
    for (int i = 0; i < 20; ++i) {
        const Quaternion q = random.quaternion();
        const Vector3 v = random.vector();
        const auto f = [&](const Quaternion& p) -> Vector3 { return rotation_matrix(p).transpose() * v; };
        EXPECT_LT(distance(J_body_q(q, v), (test::perturbation_jacobian<3, 4>(f, q))), 1e-7);
    }
}

// h is quadratic, so h(q + e) = h(q) + H e + h(e) without remainder (theory of the corrected equation 16).
TEST(Rotation, TheMeasurementOfASumIsExactlyQuadratic) {
    test::Random random(5);
    const Quaternion q = random.quaternion(), e(random.normal(), random.normal(), random.normal(), random.normal());
    const Vector3 v = random.vector();
    const auto h = [&](const Quaternion& p) -> Vector3 { return rotation_matrix(p).transpose() * v; };
    EXPECT_LT(distance(h(q + e), h(q) + J_body_q(q, v) * e + h(e)), 1e-13);
}

TEST(Rotation, RollPitchYawAreTheAnglesThatBuiltTheQuaternion) {
    const double roll = 0.3, pitch = -0.7, yaw = 2.1;
    const Quaternion q = multiply(multiply(rotation_quaternion({0, 0, yaw}), rotation_quaternion({0, pitch, 0})),
                                  rotation_quaternion({roll, 0, 0}));
    EXPECT_LT(distance(roll_pitch_yaw(q), Vector3(roll, pitch, yaw)), 1e-14);
}

TEST(Rotation, TinyRotationsAreTheLimitOfLargeOnes) {
    const Vector3 axis = Vector3(1, -2, 3).normalized();
    EXPECT_LT(distance(rotation_quaternion(axis * 0.99e-4), rotation_quaternion(axis * 1.01e-4)), 2e-6);
    EXPECT_LT(distance(rotation_quaternion(axis * 0.99e-4).normalized(), rotation_quaternion(axis * 0.99e-4)), 1e-15);
}

TEST(Frames, ALevelBodyThatPointsNorthHasYawNinetyInEastNorthUpWithItsOwnAxesUp) {
    // Body axes forward-left-up, forward pointing north: in north-east-down it is turned by half a turn about forward.
    const double identity[4] = {1, 0, 0, 0};
    Frames enu;
    enu.set(true, 0, identity);
    const Vector3 euler = roll_pitch_yaw(enu.to_user({0, 1, 0, 0}));
    EXPECT_NEAR(euler[0], 0, 1e-12);
    EXPECT_NEAR(euler[1], 0, 1e-12);
    EXPECT_NEAR(euler[2], M_PI / 2, 1e-12);
}

TEST(Frames, DeclinationTurnsMagneticHeadingIntoTrueHeading) {
    const double identity[4] = {1, 0, 0, 0};
    Frames ned;
    ned.set(false, 0.1, identity);
    EXPECT_NEAR(roll_pitch_yaw(ned.to_user(rotation_quaternion({0, 0, 0.5})))[2], 0.6, 1e-12);
    EXPECT_LT(distance(ned.to_internal(ned.to_user({0.5, 0.5, 0.5, 0.5})), Quaternion(0.5, 0.5, 0.5, 0.5)), 1e-15);
}

TEST(FirstAttitude, TriadFindsTheAttitudeThatMadeTheSamples) {
    test::Random random(6);
    for (int i = 0; i < 50; ++i) {
        const Quaternion q = random.quaternion();
        const Matrix3 R_nb = rotation_matrix(q).transpose();
        Quaternion found;
        ASSERT_TRUE(triad(R_nb * Vector3(0, 0, -9.81), R_nb * Vector3(2e-5, 0, 4e-5), &found));
        EXPECT_GT(std::fabs(found.dot(q)), 1 - 1e-14);
    }
}

TEST(FirstAttitude, TriadRefusesAFieldAlongTheVertical) {
    Quaternion q;
    EXPECT_FALSE(triad({0, 0, -9.81}, {0, 0, 5e-5}, &q));
    EXPECT_FALSE(triad({0, 0, -9.81}, {1e-9, 0, 5e-5}, &q));
}

TEST(FirstAttitude, LevelWithHeadingAgreesWithTriad) {
    test::Random random(7);
    for (int i = 0; i < 50; ++i) {
        const Quaternion q = random.quaternion();
        const Matrix3 R_nb = rotation_matrix(q).transpose();
        const Quaternion found = level_with_heading(R_nb * Vector3(0, 0, -9.81), roll_pitch_yaw(q)[2]);
        EXPECT_GT(std::fabs(found.dot(q)), 1 - 1e-12);
    }
}

TEST(FirstAttitude, TheReferenceIsWhatTheFieldWas) {
    const Quaternion q = test::Random(8).quaternion();
    const Vector3 field_n = 48e-6 * Vector3(std::cos(1.1), 0, std::sin(1.1));
    const ReferenceField found = learn_reference(q, rotation_matrix(q).transpose() * field_n);
    EXPECT_NEAR(found.strength, 48e-6, 1e-18);
    EXPECT_NEAR(found.dip_rad, 1.1, 1e-12);
}
