// Ellipsoid and sphere through field samples.
//
// The samples of a magnetometer turning in a constant field are on a sphere; hard iron shifts it, soft iron, scale and
// misalignment deform it to an ellipsoid:  (z - o)' A (z - o) = 1.
#pragma once

#include "calibration/robust.hpp"
#include "maths/rotation.hpp"

namespace hnav {

struct Ellipsoid {
    Vector3 centre;      // o
    Matrix3 root;        // upper triangle B with B'B = A: |B (z - o)| = 1
    double condition;    // of the scatter matrix of the quadric: largest over second smallest eigenvalue
    double ambiguity;    // smallest over second smallest eigenvalue: 0 one quadric fits, 1 two fit equally well
};

// z: samples about their mean, scaled to a root mean square distance of 1, for the conditioning of the problem.
// outlier_sigma: 0 for the plain fit, else samples beyond this many robust standard deviations are down-weighted.
// On return weight holds the last weights. False when no ellipsoid fits; condition and ambiguity are set all the same.
bool fit_ellipsoid(const Columns& z, double outlier_sigma, Values& weight, Values& residual, Values& scratch,
                   Ellipsoid* ellipsoid);

struct Sphere {
    Vector3 centre;
    Matrix3 plane; // projection onto the directions in which the samples determine the centre
    int axes;      // number of those directions: 3, or 2 when the samples lie in a plane
};

// The same for hard iron alone. thin: smallest spread across the samples over the largest that still counts as
// three-dimensional. Across the plane of flat samples the centre is their mean.
Sphere fit_sphere(const Columns& z, double outlier_sigma, double thin, Values& weight, Values& residual, Values& scratch);

} // namespace hnav
