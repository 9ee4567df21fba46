// Random numbers of the plants: the i-th number of a stream is a function of seed, stream and i only. A repeated step
// therefore draws the same numbers, noise sources are independent of each other, and a saved state contains no
// generator.
//
// Philox4x64-10: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011. The stream is that of
// numpy.random.Philox(key=[seed, stream]).
#pragma once

#include <cmath>
#include <cstdint>

namespace hnav {

class RandomStream {
public:
    RandomStream(std::uint64_t seed, std::uint64_t stream) : key_{seed, stream} {}

    // The same bits on every machine.
    std::uint64_t word(std::uint64_t i) const {
        std::uint64_t block[4];
        // NumPy counts up before it draws: the first block has counter 1.
        cipher(i / 4 + 1, block);
        return block[i % 4];
    }

    // In [0, 1), a multiple of 2^-53: the same bits on every machine.
    double uniform(std::uint64_t i) const { return static_cast<double>(word(i) >> 11) * 0x1p-53; }

    // Mean 0, variance 1, by Box and Muller: 2 k and 2 k + 1 from the uniforms of these numbers. log, cos and sin of the
    // C library differ between machines in the last bits.
    double normal(std::uint64_t i) const {
        std::uint64_t block[4];
        cipher(i / 4 + 1, block);
        const std::uint64_t* pair = block + (i % 4 & 2u);
        const double radius = std::sqrt(-2 * std::log(1 - static_cast<double>(pair[0] >> 11) * 0x1p-53)); // not log(0)
        const double angle = 6.283185307179586 * (static_cast<double>(pair[1] >> 11) * 0x1p-53);
        return radius * (i % 2 ? std::sin(angle) : std::cos(angle));
    }

private:
    static std::uint64_t product(std::uint64_t a, std::uint64_t b, std::uint64_t* high) {
        __extension__ using Wide = unsigned __int128;
        const Wide wide = static_cast<Wide>(a) * b;
        *high = static_cast<std::uint64_t>(wide >> 64);
        return static_cast<std::uint64_t>(wide);
    }

    void cipher(std::uint64_t counter, std::uint64_t* block) const {
        std::uint64_t key0 = key_[0], key1 = key_[1];
        block[0] = counter;
        block[1] = block[2] = block[3] = 0;
        for (int round = 0; round < 10; ++round) {
            std::uint64_t high0, high1;
            const std::uint64_t low0 = product(0xD2E7470EE14C6C93u, block[0], &high0);
            const std::uint64_t low1 = product(0xCA5A826395121157u, block[2], &high1);
            block[0] = high1 ^ block[1] ^ key0;
            block[1] = low1;
            block[2] = high0 ^ block[3] ^ key1;
            block[3] = low0;
            key0 += 0x9E3779B97F4A7C15u; // golden ratio
            key1 += 0xBB67AE8584CAA73Bu; // sqrt(3) - 1
        }
    }

    std::uint64_t key_[2];
};

} // namespace hnav
