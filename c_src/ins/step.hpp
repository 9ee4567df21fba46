// Record of one correction for the smoother, which undoes it.
#pragma once

#include "ins/measurement.hpp"

namespace hnav::ins {

constexpr int moved = 9; // rows of the error that the flow changes: d, v, phi
constexpr int movers = 26; // columns that change them: these, biases, axes, u

// Transition of the errors since the previous correction. Rows beyond `moved` are constant.
struct Transition {
    double M[moved][movers] = {};

    void put(int row, int column, const Matrix3& block) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) M[row + i][column + j] = block(i, j);
    }
};

// The sum of two errors, the second of the state that the first has led to.
inline void add_errors(const double* first, const double* second, double* sum) {
    const Quaternion turned = multiply(rotation_quaternion(vec(second + row_phi)), rotation_quaternion(vec(first + row_phi)));
    for (int i = 0; i < errors; ++i) sum[i] = first[i] + second[i];
    vec(sum + row_phi) = rotation_vector(turned);
}

struct Step {
    Transition transition;
    double kept[errors]; // factor of each row after the transition: errors decay, or are found to be larger
    double larger[errors]; // the second kind alone
    Covariance before; // covariance before the samples, at the time of the correction
    double axes[9]; // at that time; the anchor may move afterwards
    double change[errors]; // of the estimate by all samples of this correction, in these axes

    void begin(const Transition& flown, const Covariance& P, const double* axes_then) {
        transition = flown;
        for (int i = 0; i < errors; ++i) kept[i] = larger[i] = 1;
        before = P;
        mat(axes) = mat(axes_then);
        for (double& c : change) c = 0;
    }
    // An inconsistency shows that an error is so much larger than its sigma; its correlations are kept.
    void scaled(int row, double factor) {
        kept[row] *= factor;
        larger[row] *= factor;
        before.scale(row, factor);
    }
    // The state has stepped, as the estimate now has; what is known of it is P. Samples have not corrected it.
    void stepped(const Covariance& P) {
        before = P;
        for (double& c : change) c = 0;
    }
    // The state may have stepped: its variance grows, without correlation to others.
    void jumped(int row, double variance) { before[row][row] += variance; }
    void add(const double* error) { add_errors(change, error, change); }
};

} // namespace hnav::ins
