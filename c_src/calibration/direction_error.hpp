// How far the direction of the corrected field is from the true one: root mean squares over all directions of the sphere,
// not only those that were sampled, so that the part of the sphere that was left out shows.
#pragma once

#include "calibration/joint_fit.hpp"

namespace hnav {

// What a fit was free to choose.
enum class Unknowns {
    all,
    no_rotation,      // without force: the rotation is taken as it is
    centre_and_radius // hard iron alone
};

// Takes off what noise pushes the fit by, and returns how far that turns directions, in rad. Noise lengthens the field on the
// mean and moves the samples at which the equations are differentiated: where part of the sphere is missing, the ellipsoid
// comes out too small by the variance of the noise times a leverage that no number of samples makes less.
double take_off_push(double outlier_sigma, Unknowns unknowns, Samples& samples, Correction* correction);

// The error in rad that nine of ten fits stay below, or more.
double direction_error(double outlier_sigma, Unknowns unknowns, Samples& samples, const Correction& correction);

// Part of the sphere without samples, but for one in a hundred: they lie further than the angle from the direction.
struct Gap {
    Vector3 direction;
    double angle_rad;
};

// The largest, of the columns whose use is not zero. lengths, scratch: room for a number of each column.
Gap largest_gap(const Columns& u, const Values& use, Values& lengths, Values& scratch);

// Between the directions that two corrections give one field, in rad.
double direction_difference(const Correction& one, const Correction& other);

} // namespace hnav
