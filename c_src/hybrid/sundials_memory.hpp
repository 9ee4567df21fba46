// Where the solvers of SUNDIALS have their memory. SUNDIALS does not look at all that malloc answers: out of memory its create
// calls crash, leak or write to stderr. So one block is reserved before, the only call that can fail, and all that SUNDIALS and
// our vectors ask for while a solver is made is cut from it and goes with it.
//
// malloc has no argument to name the block by, so it is known to the process for as long as one thread makes a solver; others
// that want to wait their turn, some microseconds. What SUNDIALS asks for at any other time, or beyond the block, comes from the
// heap: version 7 writes the texts of its errors there, and a later one may need more than was reserved.
//
// An installed SUNDIALS (HNAV_SYSTEM_SUNDIALS) calls malloc itself: only our vectors are cut from the block then.
#pragma once

#include <cstddef>

namespace hnav {

class SundialsMemory {
public:
    // Enough to make and warm up the solvers of nx states: twice what those of version 6.4 take.
    static std::size_t bytes(int nx) { return 50 * 1024 + 70 * static_cast<std::size_t>(nx) * sizeof(double); }

    // The block is given to SUNDIALS for the life of this object, and has to outlive what SUNDIALS made in it.
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
