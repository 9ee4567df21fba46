// Laws of gates and of readiness.
#include "estimation/gate.hpp"
#include "estimation/readiness.hpp"

#include <gtest/gtest.h>

using namespace hnav;

TEST(Gate, WithinItNothingChangesAndBeyondItTheRatioCounts) {
    EXPECT_EQ(beyond_gate(8.0, 9.0), 1);
    EXPECT_EQ(beyond_gate(9.0, 9.0), 1);
    EXPECT_EQ(beyond_gate(18.0, 9.0), 2);
    EXPECT_EQ(beyond_gate(1e9, 0.0), 1); // no gate
}

TEST(Gate, FewerRowsHaveAsRareALimit) {
    const double limit = 16.27; // chi square, 3 degrees of freedom, 99.9 %
    EXPECT_NEAR(gate_for_rows(1, limit), 10.83, 0.15);
    EXPECT_NEAR(gate_for_rows(2, limit), 13.82, 0.15);
    EXPECT_EQ(gate_for_rows(3, limit), limit);
}

TEST(Readiness, ASmallSigmaHasToBeEarned) {
    EXPECT_TRUE(angle_ready(0.9e-4, 1.1e4, 0.01));
    EXPECT_FALSE(angle_ready(1.1e-4, 1.1e4, 0.01));
    EXPECT_FALSE(angle_ready(0.9e-4, 0.9e4, 0.01));
    EXPECT_FALSE(angle_ready(-1e-9, 1.1e4, 0.01)); // no variance
}

TEST(Readiness, TheLargerVarianceCountsForTheTilt) {
    EXPECT_EQ(tilt_variance<double>({1, 2, 9}), 2);
    EXPECT_EQ(tilt_variance<double>({3, 2, 9}), 3);
}

TEST(Readiness, WhatACorrectionBringsIsAddedToItsAngle) {
    AngleInformation<double> information{};
    information.gain_tilt({1, 4, 9}, {1, 2, 3}); // from 4 to 2
    information.gain_heading({1, 4, 8}, {1, 2, 4});
    EXPECT_NEAR(information.tilt, 0.25, 1e-15);
    EXPECT_NEAR(information.heading, 0.125, 1e-15);
}

TEST(Readiness, InformationIsTheDifferenceOfInverseVariances) {
    EXPECT_NEAR(information_gained(0.5, 0.25), 2, 1e-15);
    EXPECT_EQ(information_gained(0.25, 0.5), 0);
    EXPECT_EQ(information_gained(0.25, 0.0), 0);
}
