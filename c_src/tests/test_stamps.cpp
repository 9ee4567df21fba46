// From stamps to the time of a filter: bursts, clocks that are set, implausible stamps.
#include "hybrid/stamps.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

using hnav::Stamps;

namespace {

constexpr double limit_s = 1, interval_s = 0.01;

// A filter that uses each sample at once and shows its time.
struct Clock {
    Stamps<2> stamps;
    double newest_s = -std::numeric_limits<double>::infinity();

    Stamps<2>::Placed take(int channel, double stamp_s) {
        const auto placed = stamps.place(channel, stamp_s, newest_s, newest_s, limit_s, [this] { return newest_s; });
        if (placed.how != Stamps<2>::Place::left_out) newest_s = std::fmax(newest_s, placed.t_s);
        return placed;
    }

    void run(double from_s, int count) {
        for (int k = 0; k < count; ++k) take(0, from_s + k * interval_s);
    }
};

} // namespace

TEST(Stamps, TwoSamplesOfOneStampAreNoBurstInAChannelThatHasNone) {
    Stamps<2, false, 1> stamps;
    for (const int channel : {0, 1}) {
        double placed_s = 0;
        for (int k = 0; k < 6; ++k) {
            const double stamp_s = 0.1 * (k / 2);
            placed_s = stamps.place(channel, stamp_s, 0, 0, limit_s, [] { return 0.0; }).t_s;
            if (k == 4) EXPECT_EQ(placed_s < stamp_s, channel == 0);
        }
        EXPECT_EQ(placed_s, 0.1 * 2);
    }
}

TEST(Stamps, OrdinaryOnesAreTheTimeBitForBit) {
    Clock clock;
    for (int k = 0; k < 100; ++k) {
        const double t_s = 1.7e9 + 0.0031 * k;
        EXPECT_EQ(clock.take(0, t_s).t_s, t_s);
        EXPECT_EQ(clock.take(1, t_s).t_s, t_s);
    }
    EXPECT_EQ(clock.stamps.offset_s(), 0);
}

TEST(Stamps, PlacedTogetherTheyAreWhatTheyAreOneAfterTheOtherAndOnesThatNeedALookAreRefusedUntouched) {
    Clock apart, together;
    for (int k = 0; k < 50; ++k) {
        const double t_s = 5 + interval_s * (k + (k % 3) * 0.1) + (k > 30 ? 0.5 : 0); // jitter, and a gap
        for (const int c : {0, 1}) apart.take(c, t_s);
        const bool usual = k > 1 && k != 31;
        EXPECT_EQ(together.stamps.place_together(3, t_s, together.newest_s, limit_s), usual) << k;
        if (usual) together.newest_s = t_s;
        else
            for (const int c : {0, 1}) together.take(c, t_s);
        EXPECT_EQ(std::memcmp(&apart.stamps, &together.stamps, sizeof apart.stamps), 0) << k;
    }
    const Stamps<2> before = together.stamps;
    EXPECT_FALSE(together.stamps.place_together(3, 1000, together.newest_s, limit_s)); // far ahead
    EXPECT_FALSE(together.stamps.place_together(2, 5, together.newest_s, limit_s));    // back
    EXPECT_EQ(std::memcmp(&before, &together.stamps, sizeof before), 0);
}

TEST(Stamps, ABurstIsSpreadOverTheTimeSinceTheOneBefore) {
    Clock clock;
    std::vector<double> times;
    for (int burst = 1; burst <= 4; ++burst)
        for (int k = 0; k < 5; ++k) times.push_back(clock.take(0, 0.1 * burst).t_s);
    for (std::size_t i = 5; i < times.size(); ++i)
        EXPECT_NEAR(times[i], 0.1 + 0.02 * (double(i) - 4), 1e-12) << i; // from the second on
}

TEST(Stamps, AfterABurstSingleSamplesHaveTheirStampsAgain) {
    Clock clock;
    for (int burst = 1; burst <= 3; ++burst)
        for (int k = 0; k < 5; ++k) clock.take(0, 0.1 * burst);
    clock.take(0, 0.4);
    EXPECT_EQ(clock.take(0, 0.5).t_s, 0.5);
    EXPECT_EQ(clock.take(0, 0.6).t_s, 0.6);
}

TEST(Stamps, AClockThatIsSetBackBeginsATimeBaseAndLosesNothing) {
    Clock clock;
    clock.run(1000, 50);
    const double before_s = clock.newest_s;
    const auto placed = clock.take(0, 0);
    EXPECT_EQ(placed.how, Stamps<2>::Place::jumped);
    EXPECT_NEAR(placed.t_s, before_s + interval_s, 1e-9);
    EXPECT_NEAR(clock.take(0, interval_s).t_s, before_s + 2 * interval_s, 1e-9);
    EXPECT_EQ(clock.stamps.jumps(), 1u);
}

TEST(Stamps, ASensorThatIsAlwaysLateBeginsNoTimeBase) {
    Clock clock;
    for (int k = 0; k < 500; ++k) {
        clock.take(0, k * interval_s);
        EXPECT_EQ(clock.take(1, k * interval_s - 2).how, Stamps<2>::Place::stamped);
    }
    EXPECT_EQ(clock.stamps.jumps(), 0u);
}

TEST(Stamps, ASingleStampFarAheadIsLeftOutAndASecondOneIsBelieved) {
    Clock clock;
    clock.run(0, 50);
    EXPECT_EQ(clock.take(0, 3600).how, Stamps<2>::Place::left_out);
    EXPECT_EQ(clock.take(0, 0.5).how, Stamps<2>::Place::stamped);
    EXPECT_EQ(clock.take(0, 3601).how, Stamps<2>::Place::stamped);
    EXPECT_EQ(clock.stamps.left_out(0), 1u);
}

TEST(Stamps, WhatFollowsAStampFarAheadIsBelievedWithinTenLimits) {
    for (const double limit : {0.1, 20.0})
        for (const double limits : {9.0, 11.0}) {
            Stamps<1> stamps;
            const auto newest = [] { return 0.0; };
            const auto how = [&](double stamp_s) { return stamps.place(0, stamp_s, 0, 0, limit, newest).how; };
            EXPECT_EQ(how(1000 * limit), Stamps<1>::Place::left_out);
            EXPECT_EQ(how((1000 + limits) * limit), limits < 10 ? Stamps<1>::Place::stamped : Stamps<1>::Place::left_out)
                << limit << ", " << limits;
        }
}

TEST(Stamps, WithoutALimitStampsAreTakenAsTheyStand) {
    Stamps<1> stamps;
    const auto newest = [] { return 5.0; };
    EXPECT_EQ(stamps.place(0, 5, 5, 5, 0, newest).t_s, 5);
    EXPECT_EQ(stamps.place(0, 1e9, 5, 5, 0, newest).t_s, 1e9);
    EXPECT_EQ(stamps.place(0, 0, 5, 5, 0, newest).t_s, 0);
    EXPECT_EQ(stamps.jumps(), 0u);
}
