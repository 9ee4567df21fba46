#include "base/memory.hpp"
#include "base/saved_state.hpp"

#include <gtest/gtest.h>

#include <vector>

using namespace hnav;

namespace {

constexpr SavedState good{SavedState::letters("HNAVTEST"), 2, 17, 40};

std::vector<unsigned char> saved(const SavedState& state) {
    std::vector<unsigned char> buffer(state.bytes());
    for (std::size_t i = 0; i < state.numbers_bytes; ++i) SavedState::numbers(buffer.data())[i] = static_cast<unsigned char>(i);
    state.seal(buffer.data());
    return buffer;
}

LoadOutcome checked(const SavedState& state, const std::vector<unsigned char>& buffer) {
    return state.check(buffer.data(), buffer.size());
}

} // namespace

TEST(Hash, ChangesWithEveryByteAndWithTheOrder) {
    const unsigned char bytes[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
    for (std::size_t size = 1; size <= sizeof bytes; ++size)
        for (std::size_t i = 0; i < size; ++i) {
            unsigned char other[sizeof bytes];
            std::memcpy(other, bytes, sizeof bytes);
            other[i] ^= 0x40;
            EXPECT_NE(hash(bytes, size), hash(other, size)) << "byte " << i << " of " << size;
        }
    const double a = 1, b = 2;
    EXPECT_NE(hash(&a, sizeof a, hash(&b, sizeof b)), hash(&b, sizeof b, hash(&a, sizeof a)));
}

TEST(Hash, GoesOnFromWhatStandsBefore) {
    const double both[] = {1, 2};
    EXPECT_EQ(hash(both, sizeof both), hash(both + 1, sizeof(double), hash(both, sizeof(double))));
}

TEST(Memory, IsAlignedForVectorsOfTheProcessorAndZero) {
    for (std::size_t bytes = 1; bytes < 300; bytes += 7) {
        auto* block = static_cast<unsigned char*>(take_block(bytes));
        ASSERT_TRUE(block);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(block) % block_alignment, 0u);
        for (std::size_t i = 0; i < bytes; ++i) EXPECT_EQ(block[i], 0);
        std::memset(block, 1, bytes);
        release_block(block);
    }
    release_block(nullptr);
}

TEST(Memory, WhatNoMachineHasIsNull) {
    EXPECT_EQ(take_block(SIZE_MAX), nullptr);
    EXPECT_EQ(take_block(SIZE_MAX / 2), nullptr);
}

TEST(Memory, ObjectsAreMadeInPlaceAndDestroyed) {
    static int alive;
    struct alignas(64) Wide {
        explicit Wide(int n) : number(n) { ++alive; }
        ~Wide() { --alive; }
        int number;
    };
    alive = 0;
    Wide* wide = make_object<Wide>(7);
    ASSERT_TRUE(wide);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(wide) % alignof(Wide), 0u);
    EXPECT_EQ(wide->number, 7);
    EXPECT_EQ(alive, 1);
    destroy_object(wide);
    EXPECT_EQ(alive, 0);
    destroy_object<Wide>(nullptr);
}

TEST(SavedState, IsTakenByItsLike) { EXPECT_EQ(checked(good, saved(good)), LoadOutcome::ok); }

TEST(SavedState, EveryFlippedBitIsDamage) {
    std::vector<unsigned char> buffer = saved(good);
    for (std::size_t bit = 0; bit < 8 * buffer.size(); ++bit) {
        buffer[bit / 8] ^= static_cast<unsigned char>(1u << bit % 8);
        EXPECT_EQ(checked(good, buffer), LoadOutcome::damaged) << "bit " << bit;
        buffer[bit / 8] ^= static_cast<unsigned char>(1u << bit % 8);
    }
}

TEST(SavedState, AWholeBufferOfAnotherVersionIsNotDamagedWhateverItsSize) {
    for (const std::size_t numbers_bytes : {good.numbers_bytes, good.numbers_bytes + 8}) {
        SavedState other = good;
        other.version = 3;
        other.numbers_bytes = numbers_bytes;
        EXPECT_EQ(checked(good, saved(other)), LoadOutcome::other_version);
    }
}

TEST(SavedState, AWholeBufferOfAnotherObjectIsNotDamaged) {
    SavedState options = good, kind = good;
    options.fingerprint = 18;
    kind.kind = SavedState::letters("HNAVTASK");
    EXPECT_EQ(checked(good, saved(options)), LoadOutcome::other_object);
    EXPECT_EQ(checked(good, saved(kind)), LoadOutcome::other_object);
}

TEST(SavedState, BuffersOfOtherSizesAreOfTheWrongSize) {
    const std::vector<unsigned char> buffer = saved(good);
    for (std::size_t size = 0; size < buffer.size(); ++size)
        EXPECT_EQ(good.check(buffer.data(), size), LoadOutcome::size) << size << " bytes";
    SavedState longer = good;
    longer.numbers_bytes += 8;
    EXPECT_EQ(checked(good, saved(longer)), LoadOutcome::size);
}

TEST(SavedState, LettersStandInTheBufferAsTheyAreRead) {
    const std::vector<unsigned char> buffer = saved(good);
    EXPECT_EQ(std::string(buffer.begin(), buffer.begin() + 8), "HNAVTEST");
}
