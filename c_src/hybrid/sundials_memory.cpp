#include "hybrid/sundials_memory.hpp"

#include "hybrid/sundials_memory.h"

#include <atomic>
#include <cstdint>
#include <cstring>
#include <new>
#include <thread>

namespace hnav {
namespace {

// Header of each piece, with the size of the strictest alignment.
struct alignas(16) Head {
    std::size_t bytes;
    bool from_heap;
};

// The thread that creates a solver, and its block. The first guards the second.
std::atomic<std::thread::id> maker;
SundialsMemory* block = nullptr;

bool is_maker() { return maker.load(std::memory_order_relaxed) == std::this_thread::get_id(); }

void* take_piece(std::size_t bytes) {
    if (bytes > PTRDIFF_MAX - 2 * sizeof(Head)) return nullptr;
    const std::size_t whole = sizeof(Head) + (bytes + sizeof(Head) - 1) / sizeof(Head) * sizeof(Head);
    void* piece = is_maker() && block ? block->take(whole) : nullptr;
    const bool from_heap = !piece;
    if (from_heap) piece = std::malloc(whole);
    return piece ? new (piece) Head{bytes, from_heap} + 1 : nullptr;
}

Head* head_of(void* piece) { return static_cast<Head*>(piece) - 1; }

} // namespace

SundialsMemory::SundialsMemory(void* memory, std::size_t bytes) : next_(static_cast<char*>(memory)), left_(bytes) {
    std::thread::id none;
    while (!maker.compare_exchange_weak(none, std::this_thread::get_id(), std::memory_order_acquire)) {
        none = std::thread::id();
        std::this_thread::yield();
    }
    block = this;
}

SundialsMemory::~SundialsMemory() {
    block = nullptr;
    maker.store(std::thread::id(), std::memory_order_release);
}

void* SundialsMemory::take(std::size_t bytes) {
    if (bytes > left_) return nullptr;
    void* piece = next_;
    next_ += bytes;
    left_ -= bytes;
    return piece;
}

} // namespace hnav

extern "C" {

void* hnav_sundials_malloc(size_t bytes) { return hnav::take_piece(bytes); }

void* hnav_sundials_calloc(size_t count, size_t bytes) {
    if (bytes != 0 && count > PTRDIFF_MAX / bytes) return nullptr;
    void* piece = hnav_sundials_malloc(count * bytes);
    return piece ? std::memset(piece, 0, count * bytes) : nullptr;
}

void* hnav_sundials_realloc(void* piece, size_t bytes) {
    if (!piece) return hnav_sundials_malloc(bytes);
    void* larger = hnav_sundials_malloc(bytes);
    if (!larger) return nullptr;
    const size_t before = hnav::head_of(piece)->bytes;
    std::memcpy(larger, piece, before < bytes ? before : bytes);
    hnav_sundials_free(piece);
    return larger;
}

// A piece of the block is freed with the block.
void hnav_sundials_free(void* piece) {
    if (piece && hnav::head_of(piece)->from_heap) std::free(hnav::head_of(piece));
}

} // extern "C"
