// A hash that finds damage and distinguishes options; it is no protection against forgery.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace hnav {

// FNV-1a over 8-byte words, the last one filled up with zeros; start goes on from the hash of what stands before. A product
// carries bits upwards only, so the shift brings the high ones down: without it the changed signs of two numbers cancel.
inline std::uint64_t hash(const void* data, std::size_t bytes, std::uint64_t start = 14695981039346656037ull) {
    const auto* place = static_cast<const unsigned char*>(data);
    for (std::size_t left = bytes; left > 0;) {
        const std::size_t taken = left < 8 ? left : 8;
        std::uint64_t word = 0;
        std::memcpy(&word, place, taken);
        start = (start ^ word) * 1099511628211ull;
        start ^= start >> 32;
        place += taken;
        left -= taken;
    }
    return start;
}

} // namespace hnav
