#include "attitude/hrekf/decay_rate.hpp"

#include "maths/eigenvalues.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace hnav {

double decay_rate(const ErrorMap& e) {
    if (!(e.interval_s > 0)) return 0;
    const Eigen::LLT<Square<6>> before(unpack<6>(e.before)), after(unpack<6>(e.after));
    if (before.info() != Eigen::Success || after.info() != Eigen::Success) return 0;
    Square<6> Z = Eigen::Map<const Square<6>>(e.M) * Square<6>(before.matrixL());
    after.matrixL().solveInPlace(Z);
    const double largest = eigenvalues<6>(Z * Z.transpose())[5];
    return largest > 0 && std::isfinite(largest) ? -0.5 * std::log(largest) / e.interval_s : 0;
}

} // namespace hnav
