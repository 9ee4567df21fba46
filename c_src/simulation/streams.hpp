// The random stream of each source, so that equal seeds in several models do not give equal noise.
#pragma once

#include <cstdint>

namespace hnav::streams {

// Sources within a sensor; sensors stand 16 apart.
enum Source : std::uint64_t { white, flicker, walk, constants, jitter, dropout, outlier_chance, outlier_size, disturbance };

constexpr std::uint64_t of(int sensor, Source source) { return 16 * (static_cast<std::uint64_t>(sensor) + 1) + source; }

constexpr std::uint64_t turntable = 0x100;
constexpr std::uint64_t vehicle = 0x200; // and those that follow, for its signals
constexpr std::uint64_t aid_sensor = 0x300; // likewise, 16 for each sensor

} // namespace hnav::streams
