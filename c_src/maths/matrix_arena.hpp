// Matrices of run-time size without allocation of their own: views into one block of the caller's
// memory.
#pragma once

#include "base/arena.hpp"

#include <Eigen/Core>

namespace hnav {

// At most 64 rows and columns, so that Eigen's temporaries stay on the stack.
using Matrix = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, 64, 64>>;
using Vector = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 64, 1>>;

class MatrixArena : public Arena {
public:
    using Arena::Arena;

    Matrix matrix(int rows, int columns) { return Matrix(doubles(rows * columns), rows, columns); }
    Vector vector(int size) { return Vector(doubles(size), size); }
};

// Copies the upper triangle to the lower one.
inline void mirror_upper(Matrix& P) {
    for (int i = 0; i < P.rows(); ++i)
        for (int j = 0; j < i; ++j) P(i, j) = P(j, i);
}

inline void symmetrise(Matrix& P) {
    for (int i = 0; i < P.rows(); ++i)
        for (int j = i + 1; j < P.cols(); ++j) P(i, j) = P(j, i) = 0.5 * (P(i, j) + P(j, i));
}

} // namespace hnav
