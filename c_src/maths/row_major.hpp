// Matrices whose size is known at run time, as rows of numbers. Flat loops in one fixed order: the same bits everywhere.
#pragma once

#include <algorithm>
#include <cmath>

namespace hnav {

// Of g'X, where X has the covariance P, n x n.
inline double variance_along(const double* g, const double* P, int n) {
    double variance = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) variance += g[i] * P[i * n + j] * g[j];
    return variance;
}

// The first rows of M v, of a v whose other numbers stay.
inline void times_rows(const double* M, int rows, int n, const double* v, double* out) {
    for (int i = 0; i < rows; ++i) {
        out[i] = 0;
        for (int k = 0; k < n; ++k) out[i] += M[i * n + k] * v[k];
    }
}

// Upper triangles, row by row.
inline void unpack_upper(const double* upper, int n, double factor, double* full) {
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) full[i * n + j] = full[j * n + i] = factor * *upper++;
}

inline void pack_upper(const double* full, int n, double* upper) {
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) *upper++ = full[i * n + j];
}

// a b, of an a that may be sparse.
inline void multiply(int n, const double* a, const double* b, double* out) {
    std::fill_n(out, n * n, 0.0);
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k)
            if (const double factor = a[i * n + k]; factor != 0)
                for (int j = 0; j < n; ++j) out[i * n + j] += factor * b[k * n + j];
}

// Adds a b a' to a symmetric matrix.
inline void add_congruence(int n, const double* a, const double* b, double* work, double* to) {
    multiply(n, a, b, work);
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) {
            double sum = to[i * n + j];
            for (int k = 0; k < n; ++k) sum += work[i * n + k] * a[j * n + k];
            to[i * n + j] = to[j * n + i] = sum;
        }
}

// L L' = P, of a P that may be singular: a column with less than this share of a variance of its own is zero.
inline void root_of(int n, const double* P, double singular, double* L) {
    std::fill_n(L, n * n, 0.0);
    for (int j = 0; j < n; ++j) {
        double left = P[j * n + j];
        for (int k = 0; k < j; ++k) left -= L[j * n + k] * L[j * n + k];
        if (!(left > singular * P[j * n + j])) continue;
        L[j * n + j] = std::sqrt(left);
        for (int i = j + 1; i < n; ++i) {
            double sum = P[i * n + j];
            for (int k = 0; k < j; ++k) sum -= L[i * n + k] * L[j * n + k];
            L[i * n + j] = sum / L[j * n + j];
        }
    }
}

} // namespace hnav
