#include "laws.hpp"
#include "maths/cholesky.hpp"
#include "maths/repair.hpp"

#include <Eigen/Cholesky>

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

TEST(Cholesky, SolvesAsEigenDoes) {
    test::Random random(2);
    for (int i = 0; i < 20; ++i) {
        const Square<6> A = random.covariance<6>();
        Eigen::Matrix<double, 6, 7, Eigen::RowMajor> B = Eigen::Matrix<double, 6, 7>::Random();
        const auto x = Cholesky<6>(A).solve<7>(B);
        EXPECT_LT(distance(A * x, B), 1e-10);
        EXPECT_LT(distance(Cholesky<6>(A).quadratic_form<7>(B), B.transpose() * A.llt().solve(B)), 1e-9);
    }
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
    Square<4> P = Square<4>::Identity();
    P(3, 3) = 0;
    const Square<4> before = P;
    EXPECT_FALSE(repair<4>(P));
    EXPECT_EQ(distance(P, before), 0);
    P.setZero();
    EXPECT_FALSE(repair<4>(P));
}

TEST(Repair, TakesNegativeEigenvaluesOutAndKeepsTheOthers) {
    const Square<4> V = Eigen::SelfAdjointEigenSolver<Square<4>>(test::Random(3).covariance<4>()).eigenvectors();
    Square<4> P = V * Eigen::Vector4d(-1e-3, 1, 2, 3).asDiagonal() * V.transpose();
    EXPECT_TRUE(repair<4>(P));
    const Eigen::Vector4d eigenvalues = Eigen::SelfAdjointEigenSolver<Square<4>>(P).eigenvalues();
    EXPECT_LT(distance(eigenvalues, Eigen::Vector4d(0, 1, 2, 3)), 1e-12);
    EXPECT_EQ(distance(P, P.transpose()), 0);
}
