// Memory of the objects that create calls make: without exceptions, and aligned for every type, including vector registers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

namespace hnav {

constexpr std::size_t block_alignment = 64; // a cache line, and the widest vector

// Zeros; null without memory.
inline void* take_block(std::size_t bytes) {
    if (bytes > PTRDIFF_MAX - 2 * block_alignment) return nullptr; // no object is larger
    void* taken = std::calloc(1, bytes + block_alignment + sizeof taken);
    if (!taken) return nullptr;
    const auto first = reinterpret_cast<std::uintptr_t>(taken) + sizeof taken;
    const auto offset = sizeof taken + (block_alignment - first % block_alignment) % block_alignment;
    char* block = static_cast<char*>(taken) + offset;
    std::memcpy(block - sizeof taken, &taken, sizeof taken); // the way back
    return block;
}

inline void release_block(void* block) {
    if (!block) return;
    void* taken;
    std::memcpy(&taken, static_cast<char*>(block) - sizeof taken, sizeof taken);
    std::free(taken);
}

// A block that ends with its scope.
class Block {
public:
    explicit Block(std::size_t bytes) : block_(take_block(bytes)) {}
    ~Block() { release_block(block_); }
    Block(const Block&) = delete;
    Block& operator=(const Block&) = delete;

    double* doubles() const { return static_cast<double*>(block_); } // null without memory

private:
    void* block_;
};

// Null without memory.
template <class T, class... Arguments>
T* make_object(Arguments&&... arguments) {
    static_assert(alignof(T) <= block_alignment);
    void* block = take_block(sizeof(T));
    return block ? new (block) T(std::forward<Arguments>(arguments)...) : nullptr;
}

// Null is allowed.
template <class T>
void destroy_object(T* object) {
    if (!object) return;
    object->~T();
    release_block(object);
}

} // namespace hnav
