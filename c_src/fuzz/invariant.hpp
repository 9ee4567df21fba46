// What must hold whatever was called with whatever. A broken promise ends the process with its text, so that the fuzzer
// keeps the input that led there.
#pragma once

#include "hnav/hnav.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#define HOLDS(condition)                                                                                                         \
    do {                                                                                                                         \
        if (!(condition)) fuzz::broken(#condition, __FILE__, __LINE__);                                                          \
    } while (0)

namespace fuzz {

[[noreturn]] inline void broken(const char* promise, const char* file, int line) {
    std::fprintf(stderr, "%s:%d: this does not hold: %s\n", file, line, promise);
    std::abort();
}

inline bool finite(const double* v, int n) {
    for (int i = 0; i < n; ++i)
        if (!std::isfinite(v[i])) return false;
    return true;
}

inline bool not_negative(const double* v, int n) {
    for (int i = 0; i < n; ++i)
        if (!(v[i] >= 0)) return false;
    return true;
}

// What a sigma is: nothing that is estimated is certain.
inline bool positive(const double* v, int n) {
    for (int i = 0; i < n; ++i)
        if (!(v[i] > 0)) return false;
    return true;
}

inline bool unit(const double* q) { return std::fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) < 1e-9; }

// A call that fails gives its reason; a call that succeeds gives a status alone.
inline void answered(hnav_status status, const char* message) {
    HOLDS(std::strcmp(hnav_status_text(status), "unknown status") != 0);
    HOLDS(status == HNAV_OK || message[0] != '\0');
    HOLDS(std::strlen(message) < 256);
}

// n x n, row-major: symmetric to the bit, and no variance below zero.
inline void covariance(const double* P, int n) {
    HOLDS(finite(P, n * n));
    for (int i = 0; i < n; ++i) {
        HOLDS(P[i * n + i] >= 0);
        for (int j = 0; j < i; ++j) HOLDS(P[i * n + j] == P[j * n + i]);
    }
}

// No direction has a variance below zero, but for rounding of the largest: n x n, at most 6, by the factors of L D L'.
inline bool semidefinite(const double* P, int n) {
    double A[36], shift = 0;
    for (int i = 0; i < n; ++i) shift += 1e-9 * P[i * n + i];
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) A[i * n + j] = P[i * n + j] + (i == j ? shift : 0);
    for (int k = 0; k < n; ++k) {
        if (!(A[k * n + k] > 0)) return false;
        for (int i = k + 1; i < n; ++i)
            for (int j = k + 1; j < n; ++j) A[i * n + j] -= A[i * n + k] * A[k * n + j] / A[k * n + k];
    }
    return true;
}

inline std::vector<unsigned char> saved(const hnav_filter* filter) {
    std::size_t size = 0;
    HOLDS(hnav_filter_state_size(filter, &size) == HNAV_OK && size > 0);
    std::vector<unsigned char> state(size);
    HOLDS(hnav_filter_save(filter, state.data(), size) == HNAV_OK);
    return state;
}

} // namespace fuzz
