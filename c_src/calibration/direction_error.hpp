// Error of the direction of the corrected field: root mean square over all directions of the sphere, not only the sampled
// ones, so that a part of the sphere without samples increases it.
#pragma once

#include "calibration/joint_fit.hpp"

namespace hnav {

// Free unknowns of a fit.
enum class Unknowns {
    all,
    no_rotation,      // without force: the rotation is taken as it is
    centre_and_radius // hard iron alone
};

// Subtracts the bias of the fit caused by noise, and returns the rotation of directions by it, in rad. Noise lengthens the field on
// the mean and moves the points of linearisation: if part of the sphere is missing, the ellipsoid is too small by the variance of
// the noise times a factor that more samples do not reduce.
double take_off_push(double outlier_sigma, Unknowns unknowns, Samples& samples, Correction* correction);

// The error in rad that is exceeded by at most one of ten fits.
double direction_error(double outlier_sigma, Unknowns unknowns, Samples& samples, const Correction& correction);

// A part of the sphere with at most one in a hundred samples: all directions within angle_rad of `direction`.
struct Gap {
    Vector3 direction;
    double angle_rad;
};

// The largest, of the columns whose use is not zero. lengths, scratch: room for a number of each column.
Gap largest_gap(const Columns& u, const Values& use, Values& lengths, Values& scratch);

// Angle between the directions of one field by two corrections, in rad.
double direction_difference(const Correction& one, const Correction& other);

} // namespace hnav
