// The non-zero elements of a matrix, row by row. A block-diagonal transition diag(A, An) and a measurement [H I] are
// mostly zeros; products that skip them cost a fraction, and walk along rows, which compilers turn into vector code.
#pragma once

#include "maths/matrix_arena.hpp"

namespace hnav {

class SparseRows {
public:
    SparseRows(MatrixArena& arena, int rows, int columns)
        : rows_(rows),
          start_(arena.integers(rows + 1)),
          column_(arena.integers(rows * columns)),
          value_(arena.doubles(rows * columns)) {}

    int rows() const { return rows_; }

    // The matrix whose element (i, j) is element(i, j).
    template <class Element>
    void fill(int columns, Element element) {
        int count = 0;
        for (int i = 0; i < rows_; ++i) {
            start_[i] = count;
            for (int j = 0; j < columns; ++j) {
                const double v = element(i, j);
                if (v == 0) continue;
                column_[count] = j;
                value_[count++] = v;
            }
        }
        start_[rows_] = count;
    }

    // Row i times the vector x.
    double dot(int i, const double* x) const {
        double sum = 0;
        for (int k = start_[i]; k < start_[i + 1]; ++k) sum += value_[k] * x[column_[k]];
        return sum;
    }

    // out[from..] = (row i times B)[from..]; out is no part of B.
    void row_times(int i, const Matrix& B, double* __restrict out, int from = 0) const {
        const int n = static_cast<int>(B.cols());
        for (int j = from; j < n; ++j) out[j] = 0;
        for (int k = start_[i]; k < start_[i + 1]; ++k) {
            const double v = value_[k];
            const double* __restrict row = B.data() + column_[k] * n;
            for (int j = from; j < n; ++j) out[j] += v * row[j];
        }
    }

    void times(const Matrix& B, Matrix& out) const {
        for (int i = 0; i < rows_; ++i) row_times(i, B, out.data() + i * out.cols());
    }

private:
    int rows_;
    int* start_;
    int* column_;
    double* value_;
};

} // namespace hnav
