// Correction by a heading aid: one row. It does not correct the horizon either.
#include "attitude/ahrs/condition.hpp"
#include "attitude/common/heading_aid.hpp"
#include "estimation/gate.hpp"

namespace hnav {

void AhrsModel::correct_heading(State& s, Correction& c, const Event& event) const {
    using Row1 = Eigen::Matrix<R, 1, 1>;
    const HeadingAid<R> aid(QuaternionR(s.x), event);
    if (!aid.is_defined()) return;
    const Vector3R h = aid.by_rotation();
    const Vector PHt = h[0] * c.column(rotation) + h[1] * c.column(rotation + 1) + h[2] * c.column(rotation + 2);
    const R noise = aid.variance(), before = c.heading_variance();
    R S = h.dot(segment<3>(PHt, rotation)) + noise;
    const R innovation = aid.residual() - h.dot(segment<3>(c.error, rotation));
    const R nis = normalised_square<1, R>(Row1(S), Row1(innovation));
    InnovationOf<R>& i = record_heading(s.innovation, event.t_s, innovation, S, nis);
    const R over = beyond_gate(nis, R(options_.heading_gate_nis));
    if (over > 1 && heading_ready(s)) {
        i.noise_scale = 1 + (over - 1) * S / noise;
        S *= over;
        ++s.gated[heading];
    }
    condition<1, considered>(c, PHt, Row1(S), Row1(innovation), h.transpose() * c.stepped<3>(rotation), &s.steps.evidence);
    s.information.heading += information_gained(before, c.heading_variance());
    s.reference_variance = 0;
    s.heading_confirmed = 1; // an external heading needs no evidence of a field
}

} // namespace hnav
