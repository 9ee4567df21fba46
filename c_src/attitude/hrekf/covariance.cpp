// What the filter does to its whole covariance, and to that of the bias, whatever it corrects by. Compiled once: eigenvalues
// and vectors take seconds of compile time wherever they are used.
#include "attitude/hrekf/correction.hpp"

namespace hnav {

template bool repair<7>(Square<7, Scalar>& P);
template Square<7, Scalar> inflate<7>(const Square<7, Scalar>& P, const Eigen::Matrix<Scalar, 7, 1>& L, Scalar interval_s,
                                      const RobustSettings<Scalar>& settings, RobustReport<Scalar>* report);
template Matrix3Of<Scalar> adapt_corrected<Scalar>(const Matrix3Of<Scalar>& Q, const AdaptationSettings<Scalar>& settings,
                                                   const Vector3Of<Scalar>& bias_step, const Matrix3Of<Scalar>& posterior,
                                                   const Matrix3Of<Scalar>& previous, Scalar interval_s, Scalar k);

} // namespace hnav
