// The scalar of the attitude filters. A build for processors without double precision sets HNAV_SCALAR to float; times and
// outputs stay double.
#pragma once

#ifndef HNAV_SCALAR
#define HNAV_SCALAR double
#endif

namespace hnav {

using Scalar = HNAV_SCALAR;

} // namespace hnav
