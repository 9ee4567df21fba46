// The Earth as a rotating ellipsoid (WGS 84): places, axes, gravity. Valid at poles and date line.
#pragma once

#include "maths/rotation.hpp"

#include <cmath>

namespace hnav::earth {

constexpr double standard_gravity_m_s2 = 9.80665; // by which "g" is defined; about that of 45 deg latitude
constexpr double rate_rad_s = 7.292115e-5;
constexpr double equator_m = 6378137.0;
constexpr double flattening = 1 / 298.257223563;
constexpr double eccentricity2 = flattening * (2 - flattening);

// height_m: above the ellipsoid.
struct Place {
    double latitude_rad, longitude_rad, height_m;
};

// Earth-centred, Earth-fixed.
inline Vector3 position_of(const Place& p) {
    const double sine = std::sin(p.latitude_rad), cosine = std::cos(p.latitude_rad);
    const double normal_m = equator_m / std::sqrt(1 - eccentricity2 * sine * sine);
    return {(normal_m + p.height_m) * cosine * std::cos(p.longitude_rad),
            (normal_m + p.height_m) * cosine * std::sin(p.longitude_rad), (normal_m * (1 - eccentricity2) + p.height_m) * sine};
}

// Bowring (1976): one step is exact to a micrometre up to the heights that aircraft reach.
inline Place place_of(const Vector3& e) {
    const double polar_m = equator_m * std::sqrt(1 - eccentricity2), second2 = eccentricity2 / (1 - eccentricity2);
    const double axis_m = std::hypot(e[0], e[1]);
    // Sine and cosine of the parametric latitude, without the angle.
    const double z = e[2] * equator_m, r = axis_m * polar_m, length = std::hypot(z, r);
    const double sine_u = z / length, cosine_u = r / length;
    const double up = e[2] + second2 * polar_m * sine_u * sine_u * sine_u;
    const double out = axis_m - eccentricity2 * equator_m * cosine_u * cosine_u * cosine_u;
    const double slant = std::hypot(up, out), sine = up / slant, cosine = out / slant;
    const double root = std::sqrt(1 - eccentricity2 * sine * sine);
    return {std::atan2(up, out), std::atan2(e[1], e[0]), axis_m * cosine + e[2] * sine - equator_m * root};
}

// Columns: north, east, down at the place, in Earth-fixed axes.
inline Matrix3 axes_at(const Place& p) {
    const double sl = std::sin(p.latitude_rad), cl = std::cos(p.latitude_rad);
    const double so = std::sin(p.longitude_rad), co = std::cos(p.longitude_rad);
    Matrix3 T;
    T << -sl * co, -so, -cl * co, //
        -sl * so, co, -cl * so,   //
        cl, 0, -sl;
    return T;
}

// Change of a place by a displacement north, east and down. The derivative of the longitude has no limit at a pole; 0 is returned.
inline Place place_along(const Place& p, const Vector3& way_n_m) {
    const double sine = std::sin(p.latitude_rad), cosine = std::cos(p.latitude_rad);
    const double root2 = 1 - eccentricity2 * sine * sine, normal_m = equator_m / std::sqrt(root2);
    const double meridian_m = normal_m * (1 - eccentricity2) / root2, axis_m = (normal_m + p.height_m) * cosine;
    return {way_n_m[0] / (meridian_m + p.height_m), axis_m > 0 ? way_n_m[1] / axis_m : 0, -way_n_m[2]};
}

// The rotation of the local axes for that change, in these axes.
inline Vector3 turn_along(const Place& p, const Place& along) {
    return {along.longitude_rad * std::cos(p.latitude_rad), -along.latitude_rad, -along.longitude_rad * std::sin(p.latitude_rad)};
}

// Level axes by parallel transport: those of a start, as columns, turned the shortest way to the present down. They have no pole
// and no date line, except on the other side of the globe.
inline Matrix3 carried_axes(const Matrix3& start, const Vector3& down) {
    const Vector3 before = start.col(2), across = before.cross(down);
    const Quaternion half_way{1 + before.dot(down), across[0], across[1], across[2]};
    return rotation_matrix(half_way.normalized()) * start;
}

// Somigliana's formula on the ellipsoid, second order in height; includes the centrifugal acceleration.
inline double gravity_m_s2(double sine_latitude, double height_m) {
    constexpr double m = 0.00344978650684; // centrifugal over gravity at the equator
    const double s2 = sine_latitude * sine_latitude, h = height_m / equator_m;
    const double ground = 9.7803253359 * (1 + 0.00193185265241 * s2) / std::sqrt(1 - eccentricity2 * s2);
    return ground * (1 - 2 * h * (1 + flattening + m - 2 * flattening * s2) + 3 * h * h);
}

// Gravity as a vector in Earth-fixed axes, along the normal of the ellipsoid at the place itself.
inline Vector3 gravity_at(const Vector3& e) {
    const Place p = place_of(e);
    const double sine = std::sin(p.latitude_rad), cosine = std::cos(p.latitude_rad);
    const double strength = gravity_m_s2(sine, p.height_m);
    return {-strength * cosine * std::cos(p.longitude_rad), -strength * cosine * std::sin(p.longitude_rad), -strength * sine};
}

// Height above the level of 1013.25 hPa in the standard atmosphere, below 11 km.
inline double pressure_height_m(double pressure_pa) { return 44330.77 * (1 - std::pow(pressure_pa / 101325.0, 0.190263)); }

// Its inverse.
inline double pressure_pa(double pressure_height_m) {
    return 101325.0 * std::pow(1 - pressure_height_m / 44330.77, 1 / 0.190263);
}

} // namespace hnav::earth
