// What the filter does to its whole covariance, and to that of the bias, whatever it corrects by. Compiled once: eigenvalues
// and vectors take seconds of compile time wherever they are used.
#include "attitude/hrekf/correction.hpp"

namespace hnav {

template bool repair<7>(Square<7>& P);
template Square<7> inflate<7>(const Square<7>& P, const Eigen::Matrix<double, 7, 1>& L, double interval_s,
                              const RobustSettings<double>& settings, RobustReport<double>* report);
template Matrix3 adapt_corrected<double>(const Matrix3& Q, const AdaptationSettings<double>& settings, const Vector3& bias_step,
                                         const Matrix3& posterior, const Matrix3& previous, double interval_s, double k);

} // namespace hnav
