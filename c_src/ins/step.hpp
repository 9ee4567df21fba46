// What a correction has done to the estimate, for a smoother that goes back over it.
#pragma once

#include "ins/measurement.hpp"

namespace hnav::ins {

constexpr int moved = 9; // rows of the error that the flow changes: d, v, phi
constexpr int movers = 20; // columns that change them: these, biases, scales, u

// How errors have grown since the correction before: of rows that are not moved each stays as it is, but for the slow error of
// the satellites and the direction of the field, of which a share stays.
struct Transition {
    double M[moved][movers] = {};
    double colour_kept[3] = {1, 1, 1}, direction_kept = 1;

    void put(int row, int column, const Matrix3& block) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) M[row + i][column + j] = block(i, j);
    }
};

struct Step {
    Transition transition;
    Covariance before;     // any sample, at the time of the correction
    double axes[9];        // at that time; the anchor may move afterwards
    double change[errors]; // of the estimate by all samples, in these axes

    void begin(const Transition& flown, const Covariance& P, const double* axes_then) {
        transition = flown;
        before = P;
        mat(axes) = mat(axes_then);
        for (double& c : change) c = 0;
    }
    // A row is known less well by this factor on its sigma, as are those that depend on it.
    void scaled(int row, double factor) { before.scale(row, factor); }
    // The state itself has changed, by so much or more.
    void jumped(int row, double variance) { before[row][row] += variance; }
    void add(const double* error) {
        const Quaternion turned = multiply(rotation_quaternion(vec(error + row_phi)), rotation_quaternion(vec(change + row_phi)));
        for (int i = 0; i < errors; ++i) change[i] += error[i];
        vec(change + row_phi) = rotation_vector(turned);
    }
};

} // namespace hnav::ins
