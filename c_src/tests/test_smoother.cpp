// Laws of the smoother: the combination of two estimates, and the passes over a recording.
#include "attitude/common/smoother.hpp"
#include "laws.hpp"

#include <vector>

using namespace hnav;
using hnav::test::distance;

namespace {

PassEstimate estimate(test::Random& random) {
    return {random.quaternion(), random.covariance<3>(1e-4), random.vector(0.01), Vector3(1e-6, 4e-6, 9e-6), true, true, true};
}

// Records the calls of the smoother.
struct Log {
    struct Row {
        std::size_t row;
        double t_s;
        std::size_t rate_row;
        double rate_sign;
    };
    std::vector<Row> taken;
    std::vector<double> turned_back_at;
    std::vector<std::size_t> written, recorded;
    bool backward = false, has_attitude = true;
    std::size_t stops_at_call = SIZE_MAX;

    std::size_t size() const { return 3; }
    double t_s(std::size_t row) const { return 10 + 0.5 * static_cast<double>(row); }
    Hold hold() const { return backward ? Hold::backward : Hold::forward; }
    bool take(std::size_t row, double t, std::size_t rate_row, double rate_sign) {
        taken.push_back({row, t, rate_row, rate_sign});
        return taken.size() != stops_at_call;
    }
    bool started() { return has_attitude; }
    void turn_back(double t) { turned_back_at.push_back(t); }
    PassEstimate estimate() const {
        return {{1, 0, 0, 0}, Matrix3::Identity(), Vector3::Constant(taken.back().rate_sign), Vector3::Ones(), true, true, true};
    }
    void record(std::size_t row) { recorded.push_back(row); }
    void write(std::size_t row, const PassEstimate& e) {
        EXPECT_LT(distance(e.bias, Vector3::Ones()), 1e-15); // that of the backward pass has its sign changed back
        written.push_back(row);
    }
};

bool smooth(Log& log) {
    PassEstimate room[6];
    return Smoother<Log>(log, room).run();
}

} // namespace

TEST(Fusion, OfTwoEqualEstimatesIsTheirAttitudeAndKnownNoBetter) {
    test::Random random(1);
    const PassEstimate e = estimate(random), fused = fuse(e, e);
    EXPECT_LT(distance(fused.q_bn, e.q_bn), 1e-15);
    EXPECT_LT(distance(fused.rotation_covariance, e.rotation_covariance), 1e-18);
    EXPECT_LT(distance(fused.bias_variance, 0.5 * e.bias_variance), 1e-20);
}

TEST(Fusion, IsTheMeanWeightedByInformationWhicheverComesFirst) {
    test::Random random(2);
    PassEstimate a = estimate(random), b = estimate(random);
    b.q_bn = multiply(rotation_quaternion(random.vector(1e-4)), a.q_bn);
    const PassEstimate ab = fuse(a, b), ba = fuse(b, a);
    EXPECT_LT(distance(ab.q_bn, ba.q_bn), 1e-8); // rotations as small as these commute
    EXPECT_LT(distance(ab.rotation_covariance, ba.rotation_covariance), 1e-18);
    for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(ab.bias[k], (a.bias[k] / a.bias_variance[k] + b.bias[k] / b.bias_variance[k]) * ab.bias_variance[k], 1e-15);
}

TEST(Fusion, OfTwoThatDisagreeIsAsUncertainAsTheyAreApart) {
    test::Random random(4);
    PassEstimate a = estimate(random), b = a;
    for (PassEstimate* e : {&a, &b}) e->rotation_covariance = 1e-4 * Matrix3::Identity();
    b.q_bn = multiply(rotation_quaternion({0, 0, 0.1}), a.q_bn);
    const Matrix3 P = fuse(a, b).rotation_covariance;
    EXPECT_NEAR(P(0, 0), 1e-4, 1e-12);
    EXPECT_NEAR(P(2, 2), 1e-4 + 0.05 * 0.05, 1e-9);
}

TEST(Fusion, IsReadyWhereTheEstimateIsThatKnowsTheAngleBetter) {
    test::Random random(3);
    PassEstimate a = estimate(random), b = a;
    b.rotation_covariance.diagonal() += Vector3(1e-4, 0, -1e-6); // a has the better tilt, b the better heading
    for (const bool tilt : {false, true})
        for (const bool heading : {false, true}) {
            a.tilt_ready = tilt;
            b.tilt_ready = !tilt;
            a.heading_ready = !heading;
            b.heading_ready = heading;
            for (const PassEstimate& fused : {fuse(a, b), fuse(b, a)}) {
                EXPECT_EQ(fused.tilt_ready, tilt);
                EXPECT_EQ(fused.heading_ready, heading);
            }
        }
}

namespace {

// A smoothed heading that departs from the filter's by a multiple of the filter's sigma, for ten seconds.
bool less_likely(double sigmas) {
    test::Random random(5);
    const PassEstimate filter = estimate(random);
    PassEstimate smoothed = filter;
    const double angle = sigmas * std::sqrt(filter.rotation_covariance(2, 2));
    smoothed.q_bn = multiply(rotation_quaternion({0, 0, angle}), filter.q_bn);
    Hindsight hindsight;
    for (int k = 0; k < 10; ++k) hindsight.note(filter, smoothed, 1);
    return hindsight.is_less_likely();
}

} // namespace

TEST(Hindsight, IsLessLikelyBetweenHalfOfTheVarianceOfTheFilterAndThreeSigmas) {
    EXPECT_FALSE(less_likely(0.65));
    EXPECT_TRUE(less_likely(0.75));
    EXPECT_TRUE(less_likely(2.9));
    EXPECT_FALSE(less_likely(3.1)); // the filter was misled
}

TEST(Hindsight, KeepsTheHeadingOfTheFilterAndTheTiltOfTheSmoother) {
    test::Random random(6);
    const PassEstimate filter = estimate(random);
    PassEstimate smoothed = estimate(random);
    smoothed.heading_ready = false;
    smoothed.q_bn = multiply(rotation_quaternion({1e-4, -2e-4, 0.05}), filter.q_bn);
    const PassEstimate kept = keep_heading(filter, smoothed);
    const Vector3 apart = rotation_vector(multiply(kept.q_bn, conjugate(filter.q_bn)));
    EXPECT_NEAR(apart[0], 1e-4, 1e-5);
    EXPECT_NEAR(apart[1], -2e-4, 1e-5);
    EXPECT_NEAR(apart[2], 0, 1e-7);
    EXPECT_TRUE(kept.heading_ready);
    EXPECT_EQ(kept.rotation_covariance(2, 2), filter.rotation_covariance(2, 2));
    EXPECT_EQ(kept.rotation_covariance(0, 0), smoothed.rotation_covariance(0, 0));
}

TEST(Smoother, GoesForwardAndTwiceThereAndBackAndWritesInTheLastPass) {
    Log log;
    ASSERT_TRUE(smooth(log));
    ASSERT_EQ(log.taken.size(), 15u);
    EXPECT_EQ(log.turned_back_at, (std::vector<double>{0, 10, 0, 10}));
    EXPECT_EQ(log.written, (std::vector<std::size_t>{0, 1, 2}));
    EXPECT_EQ(log.recorded, log.written);
    for (int pass = 0; pass < 5; ++pass)
        for (std::size_t k = 0; k < 3; ++k) {
            const Log::Row& row = log.taken[3 * pass + k];
            const bool there = pass % 2 == 0;
            EXPECT_EQ(row.row, there ? k : 2 - k);
            EXPECT_EQ(row.t_s, there ? log.t_s(k) : 0.5 * static_cast<double>(k));
            EXPECT_EQ(row.rate_sign, there ? 1 : -1);
        }
}

// Held forward, the rate of row i acts over the interval from i to i + 1: in the backward pass it belongs to row i + 1.
TEST(Smoother, ARateStandsForTheSameIntervalInBothSensesOfTime) {
    Log forward, backward;
    backward.backward = true;
    ASSERT_TRUE(smooth(forward) && smooth(backward));
    const std::size_t held_forward[] = {1, 0, 3}, held_backward[] = {3, 2, 1}; // 3: none
    for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(forward.taken[3 + k].rate_row, held_forward[k]);
        EXPECT_EQ(backward.taken[3 + k].rate_row, held_backward[k]);
    }
}

TEST(Smoother, StopsAtARowThatCannotBeTakenAndWithoutAnAttitude) {
    Log bad_row;
    bad_row.stops_at_call = 5;
    EXPECT_FALSE(smooth(bad_row));
    EXPECT_EQ(bad_row.taken.size(), 5u);
    Log no_attitude;
    no_attitude.has_attitude = false;
    EXPECT_FALSE(smooth(no_attitude));
    EXPECT_EQ(no_attitude.taken.size(), 3u);
    EXPECT_TRUE(no_attitude.written.empty());
}
