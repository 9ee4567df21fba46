// The rate at which corrections reduce the influence of the initial error: the figure of the stability certificate that needs no solver.
//
// With e+ = M e over one correction (error_map.hpp) the rate is -ln |L+^-1 M L| / T, where P = L L' is the filter's
// covariance after the correction before and P+ = L+ L+' that after this one: sqrt(e' P^-1 e) decays at least so fast. A
// correction stores what is needed; the rate is computed on request. Sampled-data form of Theorem 1 of the paper
// (model.hpp), one P for each correction.
#include "attitude/hrekf/model.hpp"
#include "base/small.hpp"
#include "maths/eigenvalues.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace hnav {

// 1/s; 0 before the first correction and while a covariance is singular. Negative when the gains do not belong to P.
double HrekfModel::decay_rate(const State& s) const {
    if constexpr (small_build) return 0; // the small build leaves it out
    const ErrorMap<R>& e = s.error_map;
    if (!(e.interval_s > 0)) return 0;
    const Eigen::LLT<Square<6, R>> before(unpack<6>(e.before)), after(unpack<6>(s.P));
    if (before.info() != Eigen::Success || after.info() != Eigen::Success) return 0;
    Square<6, R> Z = e.matrix() * Square<6, R>(before.matrixL());
    after.matrixL().solveInPlace(Z);
    const double largest = eigenvalues<6, R>(Z * Z.transpose())[5];
    return largest > 0 && std::isfinite(largest) ? -0.5 * std::log(largest) / e.interval_s : 0;
}

} // namespace hnav
