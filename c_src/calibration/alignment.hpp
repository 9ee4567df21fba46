// The rotation that an ellipsoid does not determine, from specific force.
//
// The ellipsoid determines |B (m - o)| = 1, which any rotation of B satisfies. The angle of field and gravity is constant for every
// attitude: with a = -down the direction of specific force at rest,  a . R u = -sin(dip)  for u = B (m - o)
// (Kok, Hol, Schon, Gustafsson, Luinge, "Calibration of a magnetometer in combination with inertial sensors", 2012,
// section 4.2).
#pragma once

#include "calibration/robust.hpp"
#include "maths/rotation.hpp"

namespace hnav {

struct Alignment {
    Matrix3 R; // turns u into the axes of the force
    double sin_dip;
    double condition; // of the linear problem: largest over second smallest eigenvalue
};

// u: fields of length about 1; a: directions of force; use: 0 leaves a sample out. outlier_sigma as for the ellipsoid.
// False when no sample is in use.
bool align(const Columns& u, const Columns& a, const Values& use, double outlier_sigma, Values& residual, Values& scratch,
           Alignment* alignment);

} // namespace hnav
