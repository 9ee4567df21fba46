// Pieces of one block of memory, for objects that learn their sizes at run time and ask the heap once.
#pragma once

#include <cstddef>

namespace hnav {

// Hands out pieces of a block one after the other. Without a block it only counts: build the object once on a counting
// arena to learn its size, then again on the real one.
class Arena {
public:
    explicit Arena(void* block = nullptr) : block_(static_cast<char*>(block)) {}

    template <class T>
    T* rows(int count) {
        return static_cast<T*>(take(count * sizeof(T)));
    }
    double* doubles(int count) { return rows<double>(count); }
    int* integers(int count) { return rows<int>(count); }

    std::size_t used() const { return used_; }

private:
    void* take(std::size_t bytes) {
        void* piece = block_ ? block_ + used_ : nullptr;
        used_ += (bytes + 7) / 8 * 8;
        return piece;
    }

    char* block_;
    std::size_t used_ = 0;
};

} // namespace hnav
