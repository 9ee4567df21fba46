#include "maths/modes.hpp"

#include <Eigen/Eigenvalues>

namespace hnav {

double smallest_eigenvalue(const Small& S) {
    return Eigen::SelfAdjointEigenSolver<Small>(S, Eigen::EigenvaluesOnly).eigenvalues()[0]; // in increasing order
}

} // namespace hnav
