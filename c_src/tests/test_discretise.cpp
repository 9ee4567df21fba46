// Discretisation against closed forms, and against itself over two half intervals.
#include "maths/discretise.hpp"

#include <gtest/gtest.h>
#include <cmath>

using hnav::discretise;
using hnav::Small;

TEST(Discretise, ADoubleIntegratorHasItsClosedForm) {
    const double T = 0.3, q = 2;
    Small A = Small::Zero(2, 2), B = Small::Zero(2, 1), Q = Small::Zero(2, 2);
    A(0, 1) = B(1, 0) = 1;
    Q(1, 1) = q;
    const hnav::Discrete d = discretise(A, B, Q, T);
    Small A_expected(2, 2), B_expected(2, 1), Q_expected(2, 2);
    A_expected << 1, T, 0, 1;
    B_expected << T * T / 2, T;
    Q_expected << q * T * T * T / 3, q * T * T / 2, q * T * T / 2, q * T;
    EXPECT_LT((d.A - A_expected).norm(), 1e-15);
    EXPECT_LT((d.B - B_expected).norm(), 1e-15);
    EXPECT_LT((d.Q - Q_expected).norm(), 1e-15);
}

TEST(Discretise, AGaussMarkovProcessKeepsItsVariance) {
    const double T = 0.1, tau = 60, variance = 4;
    const Small A = Small::Constant(1, 1, -1 / tau), Q = Small::Constant(1, 1, 2 * variance / tau);
    const hnav::Discrete d = discretise(A, Small(1, 0), Q, T);
    EXPECT_NEAR(d.A(0, 0), std::exp(-T / tau), 1e-15);
    EXPECT_NEAR(d.Q(0, 0), variance * (1 - std::exp(-2 * T / tau)), 1e-15);
    EXPECT_EQ(d.B.cols(), 0);
}

TEST(Discretise, TwoHalfIntervalsAreOneWhole) {
    Small A(3, 3), B(3, 2), Q(3, 3);
    A << -0.5, 8, 0.2, -9, -0.4, 1, 0.3, 0, -2;
    B << 1, 0, 0.5, 2, -1, 3;
    Q << 2, 0.3, 0, 0.3, 1, 0.1, 0, 0.1, 0.5;
    const hnav::Discrete half = discretise(A, B, Q, 0.2), whole = discretise(A, B, Q, 0.4);
    EXPECT_LT((half.A * half.A - whole.A).norm(), 1e-13);
    EXPECT_LT((half.A * half.B + half.B - whole.B).norm(), 1e-13);
    EXPECT_LT((half.A * half.Q * half.A.transpose() + half.Q - whole.Q).norm(), 1e-13);
}

TEST(Discretise, TheLargestSizeFits) {
    const int n = hnav::max_dimension;
    const Small A = -Small::Identity(n, n), B = Small::Identity(n, n), Q = Small::Identity(n, n);
    const hnav::Discrete d = discretise(A, B, Q, 0.5);
    EXPECT_NEAR(d.A(n - 1, n - 1), std::exp(-0.5), 1e-15);
    EXPECT_NEAR(d.B(n - 1, n - 1), 1 - std::exp(-0.5), 1e-15);
    EXPECT_NEAR(d.Q(n - 1, n - 1), 0.5 * (1 - std::exp(-1.0)), 1e-15);
}
