// The heading on the whole circle.
//
// With the prior N(0, I/2) of u = (cos alpha, sin alpha) every alpha is as likely as any other. A linear filter then holds
// u ~ N(m, S), and on the circle |u| = 1 that is the posterior of alpha, with all its modes:
//     p(alpha) ~ exp(-1/2 (u(alpha) - m)' S^-1 (u(alpha) - m))
// An external heading multiplies this by a Gaussian about its value plus a uniform part, because it may be wrong by any angle.
#pragma once

#include "ins/state.hpp"

namespace hnav::ins {

// The uniform distribution: the heading is unknown.
constexpr Circle any = {0, 1.8137993642342178, 0, 0, {1.5, 0, 0.5}};

// m: mean of u, 2; S: its covariance, 2 x 2, symmetric.
Circle heading_on_circle(const double* m, const double S[2][2], const ExternalHeading& external);

} // namespace hnav::ins
