// The field of the place, if its strength and dip are given (by a model of the Earth's field, for place and date).
//
// A field of another strength or dip contains a disturbance, whose direction is unknown. Averaged over all directions its azimuth is wrong by
// as much as its intensities are. Such a field has an unknown declination: it can hold a heading while the body stays near the
// disturbance, but cannot determine one.
#pragma once

#include "attitude/ahrs/reference_field.hpp"
#include "attitude/common/start.hpp"
#include "hnav/options/ahrs.h"
#include "maths/square.hpp"

namespace hnav {

template <class R>
struct GivenField {
    bool is_given;
    R horizontal, down; // in units of the strength
    R strength_tolerance, dip_tolerance_rad;

    explicit GivenField(const hnav_ahrs_options& o)
        : is_given(reference_given(o)),
          horizontal(R(std::cos(o.reference_dip_rad))),
          down(R(std::sin(o.reference_dip_rad))),
          strength_tolerance(R(o.reference_strength_tolerance)),
          dip_tolerance_rad(R(o.reference_dip_tolerance_rad)) {}

    // h, z: horizontal and vertical intensity, in units of the strength. Without a given field: true.
    bool is_of_place(R h, R z) const {
        if (!is_given) return true;
        const R dip = std::atan2(horizontal * z - down * h, horizontal * h + down * z); // difference from the given dip
        return std::fabs(length(h, z) - 1) <= strength_tolerance && std::fabs(dip) <= dip_tolerance_rad;
    }

    // Variance of the azimuth, rad^2: the disturbance is assumed to be as large across the meridian as in each of the two intensities.
    R azimuth_variance(R h, R z) const {
        const R north = h - horizontal, vertical = z - down, across2 = (north * north + vertical * vertical) / 2;
        return std::fmin(any_angle_variance<R>, across2 / (h * h + across2 / any_angle_variance<R>));
    }
};

} // namespace hnav
