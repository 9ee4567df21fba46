// A linear measurement of the errors, r = H error + noise, and the covariance that it corrects.
#pragma once

#include "ins/state.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace hnav::ins {

constexpr int row_length = 42; // even, so that rows are aligned

// Calls f with the number of used rows as a compile-time constant, because loops of known length are faster.
template <class F>
auto with_rows(int n, F f) {
    if (n == errors) return f(std::integral_constant<int, errors>{});
    return f(std::integral_constant<int, errors_without_field>{});
}

// The whole symmetric matrix; its first n rows are used. Plain loops over it compile quickly and are as fast as matrix products of
// fixed size.
struct Covariance {
    alignas(16) double P[errors][row_length], response[errors][responses];
    int n;

    static Covariance of(const State& s) {
        Covariance c;
        c.n = s.field_unit > 0 ? int(errors) : int(errors_without_field);
        with_rows(c.n, [&](auto rows) {
            const double* lower = s.P;
            for (int i = 0; i < rows; lower += ++i)
                for (int j = 0; j <= i; ++j) c.P[i][j] = c.P[j][i] = lower[j];
        });
        std::copy_n(s.response, c.n * responses, c.response[0]);
        return c;
    }
    void keep(State& s) const {
        with_rows(n, [&](auto rows) {
            double* lower = s.P;
            for (int i = 0; i < rows; lower += ++i) std::copy_n(P[i], i + 1, lower);
        });
        std::copy_n(response[0], n * responses, s.response);
    }
    // Adds rows of zero variance.
    void extend(int rows) {
        for (; n < rows; ++n) {
            for (int j = 0; j <= n; ++j) P[n][j] = P[j][n] = 0;
            std::fill_n(response[n], responses, 0.0);
        }
    }
    double* operator[](int i) { return P[i]; }
    const double* operator[](int i) const { return P[i]; }
    Matrix3 block(int row, int column) const {
        Matrix3 m;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) m(i, j) = P[row + i][column + j];
        return m;
    }
    void add(int row, int column, const Matrix3& block) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) P[row + i][column + j] += block(i, j);
    }
    // The larger variance of two horizontal rows, beginning with this one.
    double larger(int row) const { return std::fmax(P[row][row], P[row + 1][row + 1]); }
    void put_sigma(int row, double sigma) { P[row][row] = sigma * sigma; }
    void scale(int row, double factor) {
        for (int j = 0; j < n; ++j) P[row][j] *= factor;
        for (int j = 0; j < n; ++j) P[j][row] *= factor;
    }
    void forget(int row) {
        for (int j = 0; j < n; ++j) P[row][j] = P[j][row] = 0;
        std::fill_n(response[row], responses, 0.0);
    }
};

// Expresses the rows of a vector in axes turned by C.
void turn_rows(Covariance& P, int row, const Matrix3& C);

struct Measurement {
    int channel;
    int rows = 0;
    alignas(16) double H[3][row_length] = {};
    double r[3] = {}, R[3] = {}; // residual, variance of its noise
    bool gated = true;
    bool assumed = false; // no sample: a rest that the filter has detected
    double nis = -1, scale = 1; // result of an earlier gate; nis negative: there was none

    void put(int row, int column, const Matrix3& block) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) H[row + i][column + j] = block(i, j);
    }
};

// What a measurement would change. nis: before the gate; scale: factor on the noise variance, above 1 if the gate inflated it.
struct Correction {
    double nis, scale;
    bool sound;
    double innovation[3], variance[3]; // variance: with the noise before any gate
    double error[errors];
    StepEvidence<may_step> steps[step_windows]; // of three rows
    // Rows of P H' and its S^-1 multiple, and of the response of H error.
    alignas(16) double PHt[3][row_length], gain[3][row_length], HB[3][responses];
};

// mean: of the error before the correction. The gate inflates the noise of a sample beyond it, so that its influence decreases
// (redescending).
Correction correction_by(const Measurement& m, const Covariance& P, const double* mean, double gate_nis);
// Corrects the covariance and the responses.
void reduce(Covariance& P, const Correction& c, int rows);

} // namespace hnav::ins
