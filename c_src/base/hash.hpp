// A hash that detects damage and distinguishes options; it does not protect against forgery.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace hnav {

// FNV-1a over 8-byte words, the last one padded with zeros; start continues from the hash of earlier bytes. A product carries
// bits upward only, so the shift brings the high ones down: otherwise two changed signs would cancel.
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
