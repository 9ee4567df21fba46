// The heading on the whole circle.
//
// With the prior N(0, I/2) of u = (cos alpha, sin alpha) every alpha is as likely as any other. A linear filter then holds
// u ~ N(m, S), and on the circle |u| = 1 that is the posterior of alpha, with all its modes:
//     p(alpha) ~ exp(-1/2 (u(alpha) - m)' S^-1 (u(alpha) - m))
// A heading from elsewhere multiplies it by a Gaussian about what it tells, and a uniform part: it may be wrong by any angle.
#pragma once

#include "ins/state.hpp"

namespace hnav::ins {

// Of a heading of which nothing is known.
constexpr Circle any = {0, 1.8137993642342178, 0, 0, {1.5, 0, 0.5}};

// m: 2, S: 2 x 2, symmetric.
Circle heading_on_circle(const double* m, const double S[2][2], const ToldHeading& told);

} // namespace hnav::ins
