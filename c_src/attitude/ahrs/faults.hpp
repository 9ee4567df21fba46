// Sensors at fault: which samples of an event are believed, and what an axis that shows nothing costs the estimate.
#pragma once

#include "attitude/ahrs/model.hpp"

namespace hnav {

// Before anything acts on the event. Samples that are not believed are as if they were missing; the rate of a faulty axis is
// taken as it stands, because nothing better is known, and the rotation about it is known less and less.
template <class R>
void AhrsModelOf<R>::examine(State& s, const Event& event) const {
    constexpr R turns_rad_s = R(0.2); // more than a rate at rest is
    s.disbelieved = 0;
    SensorCheck<R>& rate = s.check[gyro];
    const double t_s = event.t_s;
    if (event.has(gyro)) {
        const Vector3R y = vector_of<R>(event, gyro);
        rate.note_course(y);
        const bool moves = !(s.rest.force_still > 0);
        if (rate.examine(settings_.check[gyro], y, R(t_s - s.last_s[gyro]), t_s, moves, rate.has_noise())) {
            if (rate.fault == SensorFault::outlier) disbelieve(s, gyro);
            else lose_rate(s, t_s);
        }
    }
    const bool turns = Vector3R(s.rate).squaredNorm() > turns_rad_s * turns_rad_s;
    for (const int c : {accel, mag})
        if (event.has(c) &&
            s.check[c].examine(settings_.check[c], vector_of<R>(event, c), R(t_s - s.last_s[c]), t_s, turns, rate.has_noise()))
            disbelieve(s, c);
}

// The rotation about the axes at fault.
template <class R>
void AhrsModelOf<R>::lose_rate(State& s, double t_s) const {
    s.rest.still_s = 0;
    if (!s.started) return;
    ++s.seldom_changes;
    const Matrix3R R_bn = rotation_matrix<R>(QuaternionR(s.x));
    for (int axis = 0; axis < 3; ++axis) {
        const R variance = s.check[gyro].lost_rotation(axis, interval(s, gyro, t_s), t_s);
        const Vector3R n = R_bn.col(axis);
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j) s.P[packed(rotation + i, rotation + j)] += variance * n[i] * n[j];
    }
    s.information = {};
}

} // namespace hnav
