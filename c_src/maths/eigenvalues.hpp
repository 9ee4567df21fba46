// Eigenvalues of a small symmetric matrix, in ascending order, without vectors. Eigen's solver uses code for large matrices
// and accumulates the rotations of the vectors; for 7 rows this takes a fifth of its time.
#pragma once

#include "maths/covariance.hpp"
#include "maths/unroll.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace hnav {

// Householder's tridiagonal form: the diagonal and the squared off-diagonal.
template <int n, class R>
struct Tridiagonal {
    R diagonal[n];
    R beside2[n]; // the last is 0

    // Reads the lower triangle.
    explicit Tridiagonal(Square<n, R> A) {
        HNAV_UNROLL
        for (int k = 0; k + 2 < n; ++k) beside2[k] = reflect(A, k);
        if constexpr (n > 1) beside2[n - 2] = A(n - 1, n - 2) * A(n - 1, n - 2);
        beside2[n - 1] = 0;
        for (int i = 0; i < n; ++i) diagonal[i] = A(i, i);
    }

private:
    // Eliminates column k below its subdiagonal element and returns the square of that element.
    static R reflect(Square<n, R>& A, int k) {
        R below2 = 0;
        for (int i = k + 2; i < n; ++i) below2 += A(i, k) * A(i, k);
        const R first = A(k + 1, k), length2 = first * first + below2;
        if (!(below2 > 0)) return length2;
        R v[n], w[n];
        const R to = -std::copysign(std::sqrt(length2), first), scale = 1 / (length2 - first * to);
        v[k + 1] = first - to;
        for (int i = k + 2; i < n; ++i) v[i] = A(i, k);
        R along = 0;
        for (int i = k + 1; i < n; ++i) {
            R sum = 0;
            for (int j = k + 1; j <= i; ++j) sum += A(i, j) * v[j];
            for (int j = i + 1; j < n; ++j) sum += A(j, i) * v[j];
            w[i] = sum * scale;
            along += w[i] * v[i];
        }
        for (int i = k + 1; i < n; ++i) w[i] -= R(0.5) * along * scale * v[i];
        for (int j = k + 1; j < n; ++j)
            for (int i = j; i < n; ++i) A(i, j) -= v[i] * w[j] + w[i] * v[j];
        return length2;
    }
};

// One step of the QL iteration without square roots (Pal, Walker and Kahan) on rows l to m.
template <class R>
void ql_step(R* d, R* e2, int l, int m) {
    const R root = std::sqrt(e2[l]), half = (d[l + 1] - d[l]) / (2 * root);
    const R shift = d[l] - root / (half + std::copysign(std::sqrt(1 + half * half), half));
    R c = 1, s = 0, gamma = d[m] - shift, p = gamma * gamma;
    for (int i = m - 1; i >= l; --i) {
        const R beside = e2[i], r = p + beside, before = gamma, c_before = c;
        if (i != m - 1) e2[i + 1] = s * r;
        c = p / r;
        s = beside / r;
        gamma = c * (d[i] - shift) - s * before;
        d[i + 1] = before + (d[i] - gamma);
        p = c != 0 ? gamma * gamma / c : c_before * beside;
    }
    e2[l] = s * p;
    d[l] = shift + gamma;
}

// Reads the lower triangle.
template <int n, class R = double>
Eigen::Matrix<R, n, 1> eigenvalues(const Square<n, std::common_type_t<R>>& A) {
    constexpr R precision = std::numeric_limits<R>::epsilon();
    constexpr int most_steps = 30; // three are usual
    R largest = 0;
    for (int j = 0; j < n; ++j)
        for (int i = j; i < n; ++i) largest = std::fmax(largest, std::fabs(A(i, j)));
    const R scale = largest == 0 ? 1 : largest; // with elements within [-1, 1] no square overflows
    Tridiagonal<n, R> T(A / scale);
    R *d = T.diagonal, *e2 = T.beside2;
    const auto splits_after = [&](int i) {
        return !(e2[i] > precision * precision * (std::fabs(d[i] * d[i + 1]) + precision * precision));
    };
    for (int l = 0; l < n - 1; ++l)
        for (int step = 0; step < most_steps && !splits_after(l); ++step) {
            int m = l + 1;
            while (m < n - 1 && !splits_after(m)) ++m;
            ql_step(d, e2, l, m);
        }
    // Insertion sort for a few numbers; std::sort would add code of the C++ library to a static link.
    for (int i = 1; i < n; ++i)
        for (int j = i; j > 0 && d[j] < d[j - 1]; --j) std::swap(d[j], d[j - 1]);
    return Eigen::Map<const Eigen::Matrix<R, n, 1>>(d) * scale;
}

} // namespace hnav
