#include "laws.hpp"
#include "maths/cholesky.hpp"
#include "maths/eigenvalues.hpp"
#include "maths/modes.hpp"
#include "maths/repair.hpp"

#include <algorithm>

using namespace hnav;
using hnav::test::distance;

TEST(Covariance, PackingLosesNothing) {
    const Square<7> P = test::Random(1).covariance<7>();
    double upper[28];
    pack<7>(P, upper);
    EXPECT_EQ(distance(unpack<7>(upper), 0.5 * (P + P.transpose()).eval()) < 1e-15, true);
    EXPECT_EQ(upper[1], P(0, 1));
    EXPECT_EQ(upper[27], P(6, 6));
}

TEST(Cholesky, Solves) {
    test::Random random(2);
    for (int i = 0; i < 20; ++i) {
        const Square<6> A = random.covariance<6>();
        Eigen::Matrix<double, 6, 7, Eigen::RowMajor> B = Eigen::Matrix<double, 6, 7>::Random();
        const auto x = Cholesky<6>(A).solve<7>(B);
        EXPECT_LT(distance(A * x, B), 1e-10);
        Square<7> form = Square<7>::Zero();
        Cholesky<6>(A).add_quadratic_form<7>(B, form);
        EXPECT_LT(distance(form, B.transpose() * x), 1e-9);
        EXPECT_NEAR(Cholesky<6>(A).quadratic_form(B.col(0)), form(0, 0), 1e-9);
    }
}

TEST(Jacobi, MakesASymmetricMatrixFromItsVectorsAndValues) {
    test::Random random(5);
    for (int i = 0; i < 20; ++i) {
        const Square<7> A = random.covariance<7>() - 0.5 * random.covariance<7>();
        Square<7> D = A;
        const Jacobi<7, double> jacobi(D);
        EXPECT_LT(distance(jacobi.V * jacobi.V.transpose(), Square<7>::Identity()), 1e-13);
        EXPECT_LT(distance(jacobi.V * D.diagonal().asDiagonal() * jacobi.V.transpose(), A), 1e-13 * A.norm());
        EXPECT_LT(distance(D, D.diagonal().asDiagonal().toDenseMatrix()), 1e-13 * A.norm());
    }
    Square<3> zero = Square<3>::Zero();
    EXPECT_EQ(distance(Jacobi<3, double>(zero).V, Square<3>::Identity()), 0);
}

TEST(Cholesky, SaysWhenAMatrixIsNotPositive) {
    Square<3> A = Square<3>::Identity();
    EXPECT_TRUE(Cholesky<3>(A).positive());
    A(2, 2) = -1e-9;
    EXPECT_FALSE(Cholesky<3>(A).positive());
    A(2, 2) = std::nan("");
    EXPECT_FALSE(Cholesky<3>(A).positive());
}

TEST(Repair, LeavesSingularCovariancesAlone) {
    Square<3> P = Square<3>::Identity();
    P(2, 2) = 0;
    const Square<3> before = P;
    EXPECT_FALSE(repair<3>(P));
    EXPECT_EQ(distance(P, before), 0);
    P.setZero();
    EXPECT_FALSE(repair<3>(P));
}

TEST(Repair, TakesNegativeEigenvaluesOutAndKeepsTheOthers) {
    const Matrix3 V = rotation_matrix(test::Random(3).quaternion());
    Matrix3 P = V * Vector3(-1e-3, 1, 2).asDiagonal() * V.transpose();
    EXPECT_TRUE(repair<3>(P));
    EXPECT_LT(distance(eigenvalues<3>(P), Vector3(0, 1, 2)), 1e-12);
    EXPECT_EQ(distance(P, P.transpose()), 0);
}

TEST(Variances, AreAsTheyAreAndNeverCertain) {
    const Vector3 sound(1e-6, 2, 1e-14), broken(4, -0.25, 0);
    EXPECT_EQ(distance(honest_variances(sound), sound), 0);
    EXPECT_EQ(distance(honest_variances(broken).head<2>(), Vector3(4, 0.25, 0).head<2>()), 0);
    EXPECT_GT(honest_variances(broken)[2], 0);
    EXPECT_LT(honest_variances(broken)[2], 1e-14);
    EXPECT_GT(honest_variances(Vector3(Vector3::Zero())).minCoeff(), 0);
}

template <int n>
void expect_eigenvalues(test::Random& random, Eigen::Matrix<double, n, 1> made_of) {
    Small vectors;
    symmetric_eigenvalues(random.covariance<n>(), &vectors); // Eigen's
    const Square<n> V = vectors;
    const Square<n> made = V * made_of.asDiagonal() * V.transpose();
    std::sort(made_of.data(), made_of.data() + n);
    const double size = made_of.cwiseAbs().maxCoeff();
    EXPECT_LT(distance(eigenvalues<n>(made), made_of), 2e-14 * size) << made_of.transpose();
    EXPECT_LT(distance(eigenvalues<n>(Square<n>(made_of.asDiagonal())), made_of), 1e-15 * size);
}

TEST(Eigenvalues, MayBeEqualZeroNegativeOrOfAllSizes) {
    test::Random random(5);
    using Seven = Eigen::Matrix<double, 7, 1>;
    for (int i = 0; i < 200; ++i) {
        expect_eigenvalues<7>(random, random.numbers<7>());
        expect_eigenvalues<7>(random, (8 * random.numbers<7>()).array().exp().matrix());
        expect_eigenvalues<2>(random, random.numbers<2>());
        expect_eigenvalues<1>(random, random.numbers<1>());
    }
    expect_eigenvalues<7>(random, Seven::Constant(3));
    expect_eigenvalues<7>(random, (Seven() << 0, 0, 0, 1e-12, 1, 1, 1).finished());
    expect_eigenvalues<7>(random, (Seven() << 1e-300, -2, -2, 5, 5, 5, 1e-20).finished());
}

TEST(Eigenvalues, AreThoseThatTheMatrixWasMadeOfAtAnyScale) {
    const Matrix3 V = rotation_matrix(test::Random(4).quaternion());
    for (const double scale : {1e-200, 1.0, 1e200}) {
        const Vector3 made_of = scale * Vector3(-2, 1e-3, 5);
        const Matrix3 A = V * made_of.asDiagonal() * V.transpose();
        EXPECT_LT(distance(eigenvalues<3>(A), made_of), 1e-14 * scale);
    }
    EXPECT_EQ(distance(eigenvalues<3>(Matrix3(Matrix3::Zero())), Vector3::Zero()), 0);
}
