// Correction by a heading aid: one row.
#pragma once

#include "attitude/common/heading_aid.hpp"
#include "attitude/hrekf/correction.hpp"
#include "attitude/hrekf/model.hpp"
#include "estimation/gate.hpp"

namespace hnav {

template <class R>
void HrekfModelOf<R>::correct_heading(State& s, const Event& event) const {
    const HeadingAid<R> aid(QuaternionR(s.x), event);
    if (!aid.is_defined()) return;
    const Eigen::Matrix<R, 1, 4> H = aid.by_quaternion();
    const R noise = aid.variance(), nu = aid.residual();
    HrekfCorrection<1, R> correction(law_, s, event.t_s, H, Square<1, R>(noise));
    const R S = correction.innovation_covariance()(0, 0);
    InnovationOf<R>& i = record_heading(s.innovation, event.t_s, nu, S, nu * nu / S);
    const R over = beyond_gate(i.nis, gate_nis(heading));
    if (over > 1 && gate_works(s, heading)) {
        const R inflated = noise + (over - 1) * S;
        i.noise_scale = inflated / noise;
        ++s.gated[heading];
        correction.change_noise(Square<1, R>(inflated));
    }
    correction.apply(Eigen::Matrix<R, 1, 1>(nu), false, true);
}

} // namespace hnav
