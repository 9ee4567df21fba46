// Cholesky factors A = L L' of several matrices of one size at once, and L^-1 b for one right side. The elements of the matrices lie side
// by side, so that their square roots and divisions overlap and their products become vector code.
#pragma once

#include "maths/log_product.hpp"
#include "maths/matrix_arena.hpp"

#include <cmath>

namespace hnav {

template <int count>
class CholeskyLanes {
public:
    CholeskyLanes(MatrixArena& arena, int capacity) : width_(capacity + 1), L_(arena.doubles(count * capacity * width_)) {}

    // Element (i, j), j <= i, of each matrix, and element i of b: written before decompose, which replaces them by L and L^-1 b.
    double* element(int i, int j) { return L_ + (j * width_ + i) * count; }
    double* right(int i) { return L_ + (i * width_ + width_ - 1) * count; }

    // False: one of the matrices is not positive definite.
    bool decompose(int n) {
        bool good = true;
        for (int k = 0; k < n; ++k) {
            double inverse[count], *pivot = element(k, k), *solved = right(k);
            for (int p = 0; p < count; ++p) {
                good = good && pivot[p] > 0; // NaN too
                pivot[p] = std::sqrt(pivot[p]);
                inverse[p] = 1 / pivot[p];
                solved[p] *= inverse[p];
            }
            for (int j = k + 1; j < n; ++j)
                for (int p = 0; p < count; ++p) element(j, k)[p] *= inverse[p];
            for (int i = k + 1; i < n; ++i) {
                const double* above = element(i, k);
                for (int p = 0; p < count; ++p) right(i)[p] -= above[p] * solved[p];
                double* __restrict row = element(i, i);
                for (int j = 0; j < n - i; ++j)
                    for (int p = 0; p < count; ++p) row[j * count + p] -= above[p] * above[j * count + p];
            }
        }
        return good;
    }

    double factor(int i, int j, int p) const { return L_[(j * width_ + i) * count + p]; }
    double solved(int i, int p) const { return L_[(i * width_ + width_ - 1) * count + p]; }

    // log N(b; 0, A) without the constant.
    double log_density(int n, int p) const {
        LogProduct roots;
        double square = 0;
        for (int i = 0; i < n; ++i) {
            roots.times(factor(i, i, p));
            square += solved(i, p) * solved(i, p);
        }
        return -0.5 * square - roots.log();
    }

private:
    int width_;
    double* L_; // L' by rows, the right side in the last column
};

} // namespace hnav
