// A speed along body x, and for how long it says that the body travels.
#pragma once

#include "maths/rotation.hpp"

#include <cmath>

namespace hnav {

// Part of a filter's state: numbers of one kind only.
template <class R>
struct GivenSpeed {
    R m_s, sigma_m_s; // of the last sample
    R left_s; // time for which it still holds; 0: no speed

    bool is_fresh() const { return left_s > 0; }

    // A body at rest has no such speed.
    bool moves() const {
        constexpr R sigmas = 3, slowest_m_s = R(0.2);
        return is_fresh() && std::fabs(m_s) > sigmas * sigma_m_s + slowest_m_s;
    }

    // Covariance of the horizontal velocity, of a body whose x axis has this horizontal part. slip_rad: sigma of the angle between the
    // velocity and body x.
    Eigen::Matrix<R, 2, 2> covariance(const Eigen::Matrix<R, 2, 1>& ahead, R slip_rad) const {
        const R along2 = sigma_m_s * sigma_m_s, slip = slip_rad * m_s;
        const Eigen::Matrix<R, 2, 1> across(-ahead[1], ahead[0]);
        Eigen::Matrix<R, 2, 2> C = slip * slip * across * across.transpose();
        C.diagonal().array() += along2;
        return C;
    }
};

} // namespace hnav
