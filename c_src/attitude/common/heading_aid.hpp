// A heading aid: the true heading of body x, about down from north, from a second antenna, a gyrocompass, a star.
//
// Heading = atan2(east, north) of body x in navigation axes. A body x that points up or down has none.
#pragma once

#include "attitude/common/estimate.hpp"

namespace hnav {

template <class R>
class HeadingAid {
public:
    HeadingAid(const QuaternionOf<R>& q, const AttitudeEvent& event)
        : body_x_(rotation_matrix<R>(q).col(0)),
          level_(body_x_.template head<2>().squaredNorm()),
          measured_rad_(R(event.value[heading][0])),
          sigma_rad_(R(event.value[heading][1])) {}

    // Body x is more than 0.6 deg away from the vertical.
    bool is_defined() const { return level_ > R(1e-4); }

    R variance() const { return sigma_rad_ * sigma_rad_; }

    // The heading of the aid minus that of the estimate, within half a turn.
    R residual() const { return wrap_angle(measured_rad_ - std::atan2(body_x_[1], body_x_[0])); }

    // Derivative of the heading by a rotation about the navigation axes: theta x body_x, seen about down.
    Vector3Of<R> by_rotation() const { return {-body_x_[2] * body_x_[0] / level_, -body_x_[2] * body_x_[1] / level_, 1}; }

private:
    Vector3Of<R> body_x_;
    R level_; // square of the horizontal part of body x
    R measured_rad_, sigma_rad_;
};

// Stores the innovation, its variance S with the noise before inflation, and its NIS.
template <class R>
inline InnovationOf<R>& record_heading(InnovationOf<R>* innovations, double t_s, R innovation, R S, R nis) {
    InnovationOf<R>& i = innovations[heading];
    i = {};
    i.t_s = t_s;
    i.dimension = 1;
    i.value[0] = innovation;
    i.S[0] = S;
    i.nis = nis;
    return i;
}

} // namespace hnav
