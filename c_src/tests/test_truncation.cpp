// A Gaussian truncated by bounds, against sums over its density.
#include "estimation/truncation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>

namespace hnav {
namespace {

// With so many points between the bounds, or where the density is not negligible.
CutNormal summed(double a, double b) {
    constexpr int points = 2000000;
    const double first = std::max(a, b < -9 ? b - 5 : -9.0), last = std::min(b, a > 9 ? a + 5 : 9.0);
    const double nearest = std::clamp(0.0, first, last);
    double mass = 0, sum = 0, squares = 0;
    for (int i = 0; i < points; ++i) {
        const double x = first + (i + 0.5) * (last - first) / points;
        const double w = std::exp(0.5 * (nearest * nearest - x * x));
        mass += w;
        sum += w * x;
        squares += w * x * x;
    }
    const double mean = sum / mass;
    return {mean, squares / mass - mean * mean};
}

TEST(Truncation, is_what_is_left_of_a_normal) {
    const double bounds[][2] = {{0, HUGE_VAL}, {-1, 2},          {-HUGE_VAL, -0.5}, {3, HUGE_VAL},
                                {-0.1, 0.1},   {-HUGE_VAL, -12}, {8, 8.5}};
    for (const auto& [a, b] : bounds) {
        const CutNormal cut = cut_normal(a, b), expected = summed(a, b);
        EXPECT_NEAR(cut.mean, expected.mean, 1e-6 * std::max(1.0, std::fabs(expected.mean))) << a << " to " << b;
        EXPECT_NEAR(cut.variance, expected.variance, 1e-4 * expected.variance) << a << " to " << b;
    }
}

TEST(Truncation, has_a_mean_within_the_bounds_however_far_they_are) {
    for (const double far : {26.0, 40.0, 1e3, 1e5}) {
        const CutNormal above = cut_normal(far, HUGE_VAL), narrow = cut_normal(far, far + 1e-3 / far);
        EXPECT_GT(above.mean, far);
        EXPECT_NEAR(far * (above.mean - far), 1, 0.01);
        EXPECT_NEAR(far * far * above.variance, 1, 0.01);
        EXPECT_GE(narrow.mean, far);
        EXPECT_LE(narrow.mean, far + 1e-3 / far);
        EXPECT_EQ(cut_normal(-HUGE_VAL, -far).mean, -above.mean);
    }
}

// x0 of two correlated numbers is known to be positive: x1 follows, and its variance decreases by the decrease of that of x0.
TEST(Truncation, takes_what_is_correlated_along) {
    const double low[] = {0, -HUGE_VAL}, high[] = {HUGE_VAL, HUGE_VAL};
    double X[] = {0, 5}, P[] = {4, 3, 3, 9};
    EXPECT_TRUE(truncate(2, low, high, X, P));
    const double half = std::sqrt(2 / M_PI), left = 1 - 2 / M_PI;
    EXPECT_NEAR(X[0], 2 * half, 1e-12);
    EXPECT_NEAR(X[1], 5 + 1.5 * half, 1e-12);
    EXPECT_NEAR(P[0], 4 * left, 1e-12);
    EXPECT_NEAR(P[1], 3 * left, 1e-12);
    EXPECT_EQ(P[1], P[2]);
    EXPECT_NEAR(P[3], 9 - 9.0 / 4 * (1 - left), 1e-12);
}

TEST(Truncation, leaves_what_is_far_from_its_bounds_as_it_is) {
    const double low[] = {-6.1, -HUGE_VAL}, high[] = {HUGE_VAL, 6.1};
    double X[] = {0, 0}, P[] = {1, 0.5, 0.5, 1};
    EXPECT_FALSE(truncate(2, low, high, X, P));
    EXPECT_EQ(X[0], 0);
    EXPECT_EQ(P[1], 0.5);
}

TEST(Truncation, puts_what_is_certain_to_its_bound) {
    const double low[] = {1}, high[] = {2};
    double X[] = {0}, P[] = {0};
    EXPECT_TRUE(truncate(1, low, high, X, P));
    EXPECT_EQ(X[0], 1);
    X[0] = 1.5;
    EXPECT_FALSE(truncate(1, low, high, X, P));
}

} // namespace
} // namespace hnav
