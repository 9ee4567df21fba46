// Compiled once: the exponential of a matrix takes seconds of compile time in each file.
#include "maths/discretise.hpp"

#include <unsupported/Eigen/MatrixFunctions>

namespace hnav {

Discrete discretise(const Small& A, const Small& B, const Small& Q, double T) {
    const Eigen::Index n = A.rows(), m = B.cols();
    Discrete d;

    using Pair = Bounded<2 * max_dimension>;
    Pair held = Pair::Zero(n + m, n + m);
    held.topLeftCorner(n, n) = A * T;
    held.topRightCorner(n, m) = B * T;
    const Pair flow = held.exp();
    d.A = flow.topLeftCorner(n, n);
    d.B = flow.topRightCorner(n, m);

    Pair hamiltonian = Pair::Zero(2 * n, 2 * n);
    hamiltonian.topLeftCorner(n, n) = -A * T;
    hamiltonian.topRightCorner(n, n) = Q * T;
    hamiltonian.bottomRightCorner(n, n) = A.transpose() * T;
    const Pair M = hamiltonian.exp();
    const Small Qd = M.bottomRightCorner(n, n).transpose() * M.topRightCorner(n, n);
    d.Q = 0.5 * (Qd + Qd.transpose());
    return d;
}

} // namespace hnav
