// Correction by a heading aid: one row. It does not correct the horizon either.
#pragma once

#include "attitude/ahrs/correction.hpp"
#include "attitude/common/heading_aid.hpp"

namespace hnav {

template <class R>
void AhrsModelOf<R>::correct_heading(State& s, Correction& c, const Event& event) const {
    using Row1 = Eigen::Matrix<R, 1, 1>;
    const HeadingAid<R> aid(QuaternionR(s.x), event);
    if (!aid.is_defined()) return;
    const Vector3R h = aid.by_rotation();
    const Vector PHt = columns<3>(c.P, rotation) * h;
    const R noise = aid.variance(), before = c.heading_variance();
    R S = h.dot(segment<3>(PHt, rotation)) + noise;
    const R innovation = aid.residual() - h.dot(segment<3>(c.error, rotation));
    const R nis = normalised_square<1, R>(Row1(S), Row1(innovation));
    InnovationOf<R>& i = record_heading(s.innovation, event.t_s, innovation, S, nis);
    const R limit = settings_.heading_gate_nis;
    if (limit > 0 && nis > limit && heading_ready(s)) {
        i.noise_scale = 1 + (nis / limit - 1) * S / noise;
        S *= nis / limit;
        ++s.gated[heading];
    }
    condition<1, considered>(c, PHt, Row1(S), Row1(innovation));
    s.information.heading += information_gained(before, c.heading_variance());
    s.heading_confirmed = 1; // heading from elsewhere needs no evidence of a field
}

} // namespace hnav
