// Ellipsoid and gravity together.
#pragma once

#include "calibration/samples.hpp"

namespace hnav {

// M (z - o) has length 1 and keeps its angle to gravity:  |p| = 1 and a . p / |p| = -sin(dip) for p = M (z - o).
struct Correction {
    Matrix3 M;
    Vector3 o;
    double sin_dip;
};

// Refines all 13 unknowns by Levenberg-Marquardt with robust weights. Each equation is divided by its observed scatter,
// which makes this maximum likelihood with the actual noise of the force (Kok et al. 2012, section 4). Without force
// the rotation in M is free and fixed by the damping. outlier_sigma: 0 for plain least squares.
void refine(double outlier_sigma, bool with_force, Samples& samples, Correction* correction);

} // namespace hnav
