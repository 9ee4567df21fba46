// Navigation filters that live through random streams: what they answer stays finite and uncertain whatever they are given.
#pragma once

#include "invariant.hpp"

namespace fuzz {

// Every output: finite, and nothing that is estimated is certain; nothing before there is a tilt.
inline void look_at_ins(const hnav_filter* filter) {
    auto n = hnav_sized<hnav_navigation>();
    HOLDS(hnav_ins_navigation(filter, &n) == HNAV_OK);
    HOLDS(n.phase >= HNAV_INS_PHASE_WAITING && n.phase <= HNAV_INS_PHASE_NAVIGATING);
    const bool started = n.phase >= HNAV_INS_PHASE_ANY_HEADING;
    HOLDS(started || (std::isnan(n.q_nb[0]) && !n.tilt_ready && !n.heading_ready && !n.velocity_ready && !n.position_ready));
    if (!started) return;
    HOLDS(unit(n.q_nb));
    const double* const shown[] = {&n.latitude_rad, n.velocity_n_m_s, n.euler_rad, n.gyro_bias_rad_s, n.accel_bias_m_s2};
    for (const double* v : shown) HOLDS(finite(v, 3));
    for (const double* sigma : {n.sigma_position_m, n.sigma_velocity_m_s, n.sigma_rotation_rad})
        HOLDS(finite(sigma, 3) && positive(sigma, 3));
    HOLDS(finite(n.protection_m, 2) && positive(n.protection_m, 2) && n.protection_heading_rad > 0);
    double P[15 * 15];
    HOLDS(hnav_filter_covariance(filter, P) == HNAV_OK);
    covariance(P, 15);
}

} // namespace fuzz
