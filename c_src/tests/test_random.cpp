// Numbers from numpy.random.Philox(key=[seed, stream]).random_raw(n).
#include "simulation/random.hpp"

#include <gtest/gtest.h>

namespace {

using hnav::RandomStream;

TEST(Random, WordsAreThoseOfNumpysPhilox) {
    {
        const RandomStream random(0u, 0u);
        const std::uint64_t words[] = {0x2f4ba6408e4d89bu,  0x3dd62b0b9ca8c5b2u, 0x1c8667a55d902e79u,
                                       0x907d7a052fd5b4dcu, 0x809bf322883987c3u, 0x471128b9e807f7ddu,
                                       0xf250ba0dbec065b7u, 0xfc6ed66767a457bcu, 0x40fa86f0f781945du};
        for (int i = 0; i < 9; ++i) EXPECT_EQ(random.word(i), words[i]) << i;
    }
    {
        const RandomStream random(1u, 0u);
        const std::uint64_t words[] = {0x4db6a27b756282dfu, 0xd944fa03babe0e2fu, 0x27f872e577060d32u,
                                       0x7f697696a0482a2u,  0xe677fe4bbd0452ecu, 0xd543dba56d1e799u,
                                       0xbebe12cad0eb4d9eu, 0x3f0b4abd55f61f3du, 0x6883d8d6d20a1807u};
        for (int i = 0; i < 9; ++i) EXPECT_EQ(random.word(i), words[i]) << i;
    }
    {
        const RandomStream random(18446744073709551615u, 7u);
        const std::uint64_t words[] = {0x132b66d32865281eu, 0xd96a83b4814b47c1u, 0xee2fffd72252ae08u,
                                       0x120a90e67b54ba1fu, 0x5606de1ec52ead99u, 0xe7badc1a8d7de76au,
                                       0x6e249235b12e192cu, 0x192835fa5f6c209fu, 0xb91e0caed5118b33u};
        for (int i = 0; i < 9; ++i) EXPECT_EQ(random.word(i), words[i]) << i;
    }
}

TEST(Random, ANumberDependsOnNothingDrawnBefore) {
    const RandomStream random(3, 4);
    const double late = random.normal(1001);
    for (int i = 0; i < 2000; ++i) random.normal(i);
    EXPECT_EQ(random.normal(1001), late);
}

TEST(Random, SeedsAndStreamsDiffer) {
    EXPECT_NE(RandomStream(0, 0).word(0), RandomStream(1, 0).word(0));
    EXPECT_NE(RandomStream(0, 0).word(0), RandomStream(0, 1).word(0));
    EXPECT_NE(RandomStream(0, 1).word(0), RandomStream(1, 0).word(0));
}

TEST(Random, NormalsHaveTheMomentsOfANormalDistribution) {
    const RandomStream random(1, 2);
    const int n = 200000;
    double sum[5] = {}, neighbours = 0, before = 0;
    for (int i = 0; i < n; ++i) {
        const double z = random.normal(i);
        sum[1] += z;
        sum[2] += z * z;
        sum[3] += z * z * z;
        sum[4] += z * z * z * z;
        neighbours += z * before;
        before = z;
    }
    // Four standard errors: the variances of z, z^2, z^3, z^4 are 1, 2, 15, 96.
    EXPECT_NEAR(sum[1] / n, 0, 4 / std::sqrt(n));
    EXPECT_NEAR(sum[2] / n, 1, 4 * std::sqrt(2.0 / n));
    EXPECT_NEAR(sum[3] / n, 0, 4 * std::sqrt(15.0 / n));
    EXPECT_NEAR(sum[4] / n, 3, 4 * std::sqrt(96.0 / n));
    EXPECT_NEAR(neighbours / n, 0, 4 / std::sqrt(n));
}

} // namespace
