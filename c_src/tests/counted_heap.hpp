// Counts the heap requests of a test and refuses the nth one, by replacing malloc and its relatives; included by one file of
// a program. Where this is impossible (another C library, a sanitizer that replaces them too) HNAV_HEAP_IS_COUNTED is not
// defined.
#pragma once

#include <cstdlib>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define HNAV_HEAP_IS_COUNTED

namespace heap {
inline thread_local bool counting = false;
inline thread_local long allocations = 0; // requests while counting
inline thread_local long held = 0;        // requests that were served and not freed
inline thread_local long refused = 0;     // number of the request that fails, from 1; 0: none

inline bool refuses() {
    allocations += counting;
    return counting && allocations == refused;
}
inline void* count_held(void* block) {
    held += counting && block;
    return block;
}
} // namespace heap

extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_calloc(std::size_t, std::size_t);
extern "C" void* __libc_realloc(void*, std::size_t);
extern "C" void __libc_free(void*);
extern "C" void* malloc(std::size_t size) { return heap::refuses() ? nullptr : heap::count_held(__libc_malloc(size)); }
extern "C" void* calloc(std::size_t count, std::size_t size) {
    return heap::refuses() ? nullptr : heap::count_held(__libc_calloc(count, size));
}
extern "C" void* realloc(void* block, std::size_t size) {
    if (heap::refuses()) return nullptr;
    void* moved = __libc_realloc(block, size);
    return block ? moved : heap::count_held(moved);
}
extern "C" void free(void* block) {
    heap::held -= heap::counting && block;
    __libc_free(block);
}
#endif
