#include "hybrid/sundials_memory.hpp"

#include "hybrid/sundials_memory.h"

#include <atomic>
#include <cstdint>
#include <cstring>
#include <new>
#include <thread>

namespace hnav {
namespace {

enum class From { block, text, heap };

// In front of every piece, and as long as the strictest alignment.
struct alignas(16) Head {
    std::size_t bytes;
    From from;
};

// The thread that makes a solver, and its block. The first guards the second.
std::atomic<std::thread::id> maker;
SundialsMemory* block = nullptr;

// For the text of one error, given back at once; of two threads that fail together one goes to the heap.
alignas(Head) char text[1024];
std::atomic_flag text_is_taken = ATOMIC_FLAG_INIT;

bool is_maker() { return maker.load(std::memory_order_relaxed) == std::this_thread::get_id(); }

void* take_piece(std::size_t bytes) {
    if (bytes > PTRDIFF_MAX - 2 * sizeof(Head)) return nullptr;
    const std::size_t whole = sizeof(Head) + (bytes + sizeof(Head) - 1) / sizeof(Head) * sizeof(Head);
    const auto headed = [&](void* piece, From from) -> void* { return piece ? new (piece) Head{bytes, from} + 1 : nullptr; };
    if (is_maker()) {
        if (void* piece = block ? block->take(whole) : nullptr) return headed(piece, From::block);
    } else if (whole <= sizeof text && !text_is_taken.test_and_set(std::memory_order_acquire)) {
        return headed(text, From::text);
    }
    return headed(std::malloc(whole), From::heap);
}

Head* head_of(void* piece) { return static_cast<Head*>(piece) - 1; }

} // namespace

SundialsMemory::SundialsMemory(void* memory, std::size_t bytes) : next_(static_cast<char*>(memory)), left_(bytes) {
    std::thread::id nobody;
    while (!maker.compare_exchange_weak(nobody, std::this_thread::get_id(), std::memory_order_acquire)) {
        nobody = std::thread::id();
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

// A piece of the block goes with the block.
void hnav_sundials_free(void* piece) {
    if (!piece) return;
    hnav::Head* head = hnav::head_of(piece);
    const hnav::From from = head->from;
    if (from == hnav::From::text) hnav::text_is_taken.clear(std::memory_order_release);
    if (from == hnav::From::heap) std::free(head);
}

} // extern "C"
