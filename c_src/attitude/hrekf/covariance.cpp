// What the filter does to its whole covariance, and to that of the bias, whatever it corrects by. Compiled once: eigenvalues
// and vectors take seconds of compile time wherever they are used.
#include "attitude/hrekf/correction.hpp"

namespace hnav {

template bool repair<7>(Square<7, Scalar>& P);
template Square<7, Scalar> inflate<7>(const Square<7, Scalar>& P, const Eigen::Matrix<Scalar, 7, 1>& L, Scalar interval_s,
                                      const RobustSettings<Scalar>& settings, RobustReport<Scalar>* report);

} // namespace hnav
