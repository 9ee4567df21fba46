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

// Refines all 13 unknowns by Levenberg and Marquardt with robust weights. Each equation is divided by the scatter it
// shows, which makes this maximum likelihood with the force as noisy as it is (Kok et al. 2012, section 4). Without force
// the rotation in M is free; the damping holds it. outlier_sigma: 0 for plain least squares.
void refine(double outlier_sigma, bool with_force, Samples& samples, Correction* correction);

// What a fit was free to choose.
enum class Unknowns {
    all,
    no_rotation,      // without force: the rotation is taken as it is
    centre_and_radius // hard iron alone
};

// Standard error of the direction of the corrected field in rad, root mean square over all directions of the sphere, not
// only those that were sampled: the part of the sphere that was left out shows here.
double direction_sigma(double outlier_sigma, Unknowns unknowns, Samples& samples, const Correction& correction);

} // namespace hnav
