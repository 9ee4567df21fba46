// Matrices whose sizes are known at run time, without an allocation of their own: views into memory that someone else
// took in one piece.
#pragma once

#include <Eigen/Core>

#include <cstddef>

namespace hnav {

// Of at most 64 rows and columns, so that what Eigen needs in between stays on the stack.
using Matrix = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, 64, 64>>;
using Vector = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 64, 1>>;

// Hands out pieces of a block one after the other. Without a block it only counts: build the object once on a counting
// arena to learn its size, then again on the real one.
class Arena {
public:
    explicit Arena(void* block = nullptr) : block_(static_cast<char*>(block)) {}

    double* doubles(int count) { return static_cast<double*>(take(count * sizeof(double))); }
    int* integers(int count) { return static_cast<int*>(take(count * sizeof(int))); }
    Matrix matrix(int rows, int columns) { return Matrix(doubles(rows * columns), rows, columns); }
    Vector vector(int size) { return Vector(doubles(size), size); }

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

// Takes the upper triangle for the truth.
inline void mirror_upper(Matrix& P) {
    for (int i = 0; i < P.rows(); ++i)
        for (int j = 0; j < i; ++j) P(i, j) = P(j, i);
}

inline void symmetrise(Matrix& P) {
    for (int i = 0; i < P.rows(); ++i)
        for (int j = i + 1; j < P.cols(); ++j) P(i, j) = P(j, i) = 0.5 * (P(i, j) + P(j, i));
}

} // namespace hnav
