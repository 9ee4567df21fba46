// Propagation of the difference of two estimates over one correction, from which the decay rate (decay_rate.hpp) is computed.
//
// Two estimates with the same gains and samples differ by e = (theta, e_b): theta the rotation about the navigation axes, e_b the
// difference of the biases, in body axes. From just after one correction to just after the next
//     flow    theta- = theta - A e_b,   A = integral of R_bn over the interval: in these axes nothing else moves
//     jump    theta+ = D_theta theta-,  e_b+ = e_b + D_b theta-,   D_b = -K_b H,  D_theta = (I - K_theta H) seen from the new attitude
// together e+ = M e.
#pragma once

#include "maths/blocks.hpp"
#include "maths/rotation.hpp"

#include <algorithm>

namespace hnav {

// Part of a filter's state: numbers only.
template <class R>
struct ErrorMap {
    R before[21]; // upper triangle of the covariance of (theta, e_b) after the correction before
    R D[18]; // D_theta above D_b, column by column
    R A[9]; // s, column by column
    double interval_s; // from one to the other

    // After a new start there is no rate until the next correction.
    void begin() { interval_s = 0; }

    // since_s: the correction before, after which the covariance was P; 0 for a second one at the same instant, which joins the first.
    void jump(double since_s, const Eigen::Matrix<R, 6, 3>& kept, const R* path, const R* P) {
        Eigen::Map<Eigen::Matrix<R, 6, 3>> map(D);
        if (since_s > 0) {
            map = kept;
            std::copy(path, path + 9, A);
            std::copy(P, P + 21, before);
            interval_s = since_s;
        } else {
            const Matrix3Of<R> first = rows<3>(map, 0);
            rows<3>(map, 0).noalias() = rows<3>(kept, 0) * first;
            rows<3>(map, 3).noalias() += rows<3>(kept, 3) * first;
        }
    }

    Square<6, R> matrix() const {
        const Eigen::Map<const Eigen::Matrix<R, 6, 3>> map(D);
        Square<6, R> M;
        columns<3>(M, 0) = map;
        columns<3>(M, 3).noalias() = -map * Eigen::Map<const Matrix3Of<R>>(A);
        diagonal<3>(M, 3).array() += 1;
        return M;
    }
};

} // namespace hnav
