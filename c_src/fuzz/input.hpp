// The bytes of the fuzzer read as decisions and numbers. Every byte string is a program: what lies beyond its end reads
// as zero, and end() says when to stop. Small changes of the bytes are small changes of the program, which is what a
// fuzzer guided by coverage needs.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

namespace fuzz {

class Input {
public:
    Input(const std::uint8_t* bytes, std::size_t size) : place_(bytes), end_(bytes + size) {}

    bool end() const { return place_ == end_; }
    std::size_t left() const { return static_cast<std::size_t>(end_ - place_); }

    std::uint8_t byte() { return end() ? 0 : *place_++; }
    bool flag() { return byte() & 1; }
    // 0 ... count - 1
    int choice(int count) { return byte() % count; }

    // Four kinds: the values at which arithmetic breaks, any bit pattern, a decimal of any size, and a usual one.
    double number() {
        const int kind = byte();
        switch (kind % 8) {
        case 0: return special();
        case 1: return pattern();
        case 2: return fraction() * std::pow(10.0, static_cast<std::int8_t>(byte()) * 2.5);
        default: return fraction() * std::pow(10.0, kind / 8 % 8 - 4);
        }
    }

    // -1 ... 1
    double fraction() {
        const int high = static_cast<std::int8_t>(byte());
        return (high * 256 + byte()) / 32768.0;
    }

    void vector(double* v, int n) {
        for (int i = 0; i < n; ++i) v[i] = number();
    }

private:
    double special() {
        constexpr double values[] = {0.0,
                                     -0.0,
                                     std::numeric_limits<double>::quiet_NaN(),
                                     std::numeric_limits<double>::infinity(),
                                     -std::numeric_limits<double>::infinity(),
                                     std::numeric_limits<double>::denorm_min(),
                                     std::numeric_limits<double>::min(),
                                     std::numeric_limits<double>::max(),
                                     -std::numeric_limits<double>::max(),
                                     1e6,
                                     -1e6,
                                     1e-150,
                                     1e150,
                                     1.0,
                                     -1.0,
                                     M_PI};
        return values[byte() % (sizeof values / sizeof *values)];
    }

    double pattern() {
        std::uint64_t bits = 0;
        for (int k = 0; k < 64; k += 8) bits |= static_cast<std::uint64_t>(byte()) << k;
        double value;
        std::memcpy(&value, &bits, sizeof value);
        return value;
    }

    const std::uint8_t *place_, *end_;
};

} // namespace fuzz
