// The pseudo-inverse (Moore and Penrose), compiled once.
#pragma once

#include "maths/discretise.hpp"

namespace hnav {

Small pseudo_inverse(const Small& A);

} // namespace hnav
