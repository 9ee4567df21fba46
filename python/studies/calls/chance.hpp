// Random numbers, ordinary ones and those at which arithmetic breaks.
#pragma once

#include "fuzz/input.hpp"
#include "plan.hpp"

#include <cmath>
#include <cstdint>
#include <random>

class Chance {
public:
    explicit Chance(unsigned long long seed) : engine_(seed) {}

    int choice(int count) { return static_cast<int>(engine_() % static_cast<unsigned long long>(count)); }
    double within(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53; }

    // A value that the variable takes: within its range, in orders of magnitude where that is positive or has no end.
    double ordinary(const Variable& v) {
        const bool low = std::isfinite(v.min), high = std::isfinite(v.max);
        if (v.type != 'r') return std::floor(within(low ? v.min : 0, (high ? v.max : 3) + 1));
        if (!low && !high) return (choice(2) ? 1 : -1) * std::pow(10, within(-4, 1.5));
        if (!high) return v.min + std::pow(10, within(-4, 1.5));
        if (!low) return v.max - std::pow(10, within(-4, 1.5));
        if (v.min >= 0 && v.max > 0)
            return std::fmax(v.min, v.max * std::pow(10, within(std::log10(std::fmax(v.min / v.max, 1e-9)), 0)));
        return within(v.min, v.max);
    }

    // Of any size, or one at which arithmetic breaks.
    double wild() {
        std::uint8_t bytes[16];
        for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(engine_());
        return fuzz::Input(bytes, sizeof bytes).number();
    }

private:
    std::mt19937_64 engine_;
};
