// The format of every saved object: a header, then the numbers of the object.
//
// A buffer is loaded only if its checksum is right. Header and checksum have the same form in all versions, so that a
// complete buffer of another version is recognised as such.
#pragma once

#include "base/hash.hpp"

namespace hnav {

enum class LoadOutcome {
    ok,
    size,          // not of the size that the object needs
    damaged,       // the checksum is wrong
    other_version, // complete, but of another format
    other_object   // complete, but of an object with another model or other options
};

struct SavedState {
    std::uint64_t kind;        // of the object: eight letters, see letters()
    std::uint64_t version;     // of its numbers
    std::uint64_t fingerprint; // of its model and options: objects with equal values can load each other's states
    std::size_t numbers_bytes;

    static constexpr std::uint64_t letters(const char (&text)[9]) {
        std::uint64_t word = 0;
        for (int i = 8; i-- > 0;) word = word << 8 | static_cast<unsigned char>(text[i]);
        return word;
    }

    std::size_t bytes() const { return sizeof(Header) + numbers_bytes; }

    // Where the numbers stand in a buffer.
    static unsigned char* numbers(void* buffer) { return static_cast<unsigned char*>(buffer) + sizeof(Header); }
    static const unsigned char* numbers(const void* buffer) { return static_cast<const unsigned char*>(buffer) + sizeof(Header); }

    // Writes the header before the numbers, which are already in place.
    void seal(void* buffer) const {
        Header header{kind, version, bytes(), fingerprint, 0};
        header.checksum = checksum(header, numbers(buffer));
        std::memcpy(buffer, &header, sizeof header);
    }

    // Whether the numbers of a buffer of this size can be loaded.
    LoadOutcome check(const void* buffer, std::size_t size) const {
        if (is_of_hnav_0_1(buffer, size)) return LoadOutcome::other_version;
        Header header{};
        if (size >= sizeof header) std::memcpy(&header, buffer, sizeof header);
        const bool whole = size >= sizeof header && header.bytes == size && header.checksum == checksum(header, numbers(buffer));
        if (!whole) return size != bytes() ? LoadOutcome::size : LoadOutcome::damaged;
        if (header.kind == kind && header.version != version) return LoadOutcome::other_version;
        if (size != bytes()) return LoadOutcome::size;
        return header.kind == kind && header.fingerprint == fingerprint ? LoadOutcome::ok : LoadOutcome::other_object;
    }

private:
    struct Header {
        std::uint64_t kind, version, bytes, fingerprint;
        std::uint64_t checksum; // of all the rest
    };

    static std::uint64_t checksum(const Header& header, const unsigned char* numbers) {
        return hash(numbers, header.bytes - sizeof header, hash(&header, offsetof(Header, checksum)));
    }

    // Version 0.1 had no version in its states; each object began with letters of its own.
    static bool is_of_hnav_0_1(const void* buffer, std::size_t size) {
        const struct {
            const char* letters;
            std::size_t count;
        } starts[] = {{"HNAV01", 6}, {"hnavcol", 8}, {"hnavcr\0", 8}, {"HNAVIMS1", 8}};
        for (const auto& start : starts)
            if (size >= 8 && std::memcmp(buffer, start.letters, start.count) == 0) return true;
        return false;
    }
};

} // namespace hnav
