// Counts what a test asks of the heap, by taking the place of malloc; included by one file of a program. Where that cannot
// be (another C library, a sanitizer in the same place) HNAV_HEAP_IS_COUNTED is not defined.
#pragma once

#include <cstdlib>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define HNAV_HEAP_IS_COUNTED

namespace heap {
inline thread_local bool counting = false;
inline thread_local long allocations = 0;
} // namespace heap

extern "C" void* __libc_malloc(std::size_t);
extern "C" void* malloc(std::size_t size) {
    heap::allocations += heap::counting;
    return __libc_malloc(size);
}
#endif
