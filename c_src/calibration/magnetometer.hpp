// Magnetometer calibration: hard iron, soft iron, scale and misalignment from field and force of a sensor that was turned
// about all axes.
//
//   measured field  y = D R' m_n + o     corrected field  D^-1 (y - o), in the axes of the force
//
// Three steps, as in Kok, Hol, Schon, Gustafsson, Luinge (2012): an ellipsoid determines o and D up to a rotation; gravity
// determines the rotation, because its angle to the field is constant; both equations are refined together.
#pragma once

#include "calibration/direction_error.hpp"
#include "hnav/options/magnetometer.h"
#include "maths/rotation.hpp"

namespace hnav {

// Outcome for the rotation between the axes of field and force.
enum class Rotation {
    found,
    no_gravity,      // too few forces of the length of gravity
    not_gravity,     // the angle of force and field is not constant
    uncertain,       // too inaccurate
    explains_little, // of the scatter of the angle between field and force
};

struct MagnetometerCalibration {
    Vector3 offset = Vector3::Zero();          // unit of the input
    Matrix3 matrix = Matrix3::Identity();      // corrected = matrix (field - offset); determinant 1
    double strength = 0;                       // of the corrected field
    double dip_rad = 0;                        // NaN without force
    double residual_before = 0;                // scatter of |field|, relative, over the samples that are no outliers
    double residual_after = 0;
    double dip_spread_before_rad = 0;          // robust standard deviation; NaN without force
    double dip_spread_after_rad = 0;
    double outlier_fraction = 0;               // of the used samples
    double coverage = 0;                       // 1: directions spread evenly over the sphere, 0: in a plane
    double condition = 0, ambiguity = 0;       // of the ellipsoid (ellipsoid.hpp)
    double axis_ratio = 1;                     // longest over shortest axis of the ellipsoid
    double direction_sigma_rad = 0;            // error of the corrected direction exceeded by one of ten, rms
    Gap gap{Vector3::UnitX(), 0};              // the largest part of the sphere without a sample
    Index samples = 0;                         // rows with a field
    Index used_samples = 0;                    // of these, rows with a new attitude
    Index force_samples = 0;                   // of these, rows whose force was taken for gravity
    int offset_axes = 0;                       // directions in which the offset is determined
    bool full = false;                         // else hard iron only
    Rotation rotation = Rotation::no_gravity;
    double rotation_rad = 0;                   // rotation of directions; if it was estimated
    double tilt_rad = 0;                       // largest angle of gravity to one direction
    double shape_sigma_rad = 0;                // as direction_sigma_rad, of the ellipsoid alone
};

enum class FitRefusal {
    none,
    no_memory,
    too_few_samples,
    too_little_motion, // too few different attitudes
    constant_field,   // there is nothing to fit
    planar,           // turned about one axis only
    ill_conditioned,  // several ellipsoids fit
    not_an_ellipsoid,
    stretched,        // axes too unequal for a sensor
    uncertain,        // an ellipsoid, but too inaccurate
    little_coverage,
    little_tilt,      // the sensor was hardly tilted
    worse,            // the corrected field would be less constant than the measured one
};

// field: n x 3, finite, a row of three NaN is missing; force: the same, or null. refusal: the reason for hard iron only
// or for no result. True with a result.
bool calibrate_magnetometer(Index n, const double* field, const double* force, const hnav_magnetometer_options& options,
                            MagnetometerCalibration* calibration, FitRefusal* refusal);

} // namespace hnav
