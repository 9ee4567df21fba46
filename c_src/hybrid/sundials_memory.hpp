// Memory for the solvers of SUNDIALS. SUNDIALS does not check every result of malloc: without memory its create calls crash,
// leak or write to stderr. So one block is reserved first, the only call that can fail. All memory that SUNDIALS and our
// vectors request while a solver is created is cut from it and is freed with it.
//
// malloc has no argument for the block, so it is global while one thread creates a solver; other threads that create one wait
// some microseconds. Requests at any other time, or beyond the block, go to the heap: version 7 writes the texts of its
// errors there, and a later version may need more than was reserved.
//
// An installed SUNDIALS (HNAV_SYSTEM_SUNDIALS) calls malloc itself: then only our vectors are cut from the block.
#pragma once

#include <cstddef>

namespace hnav {

class SundialsMemory {
public:
    // Enough to create and warm up the solvers of nx states: twice the use of version 6.4.
    static std::size_t bytes(int nx) { return 50 * 1024 + 70 * static_cast<std::size_t>(nx) * sizeof(double); }

    // SUNDIALS uses the block during the life of this object; the block must outlive the objects that SUNDIALS created in it.
    explicit SundialsMemory(void* block, std::size_t bytes);
    ~SundialsMemory();
    SundialsMemory(const SundialsMemory&) = delete;
    SundialsMemory& operator=(const SundialsMemory&) = delete;

    // Null when the block is used up.
    void* take(std::size_t bytes);

private:
    char* next_;
    std::size_t left_;
};

} // namespace hnav
