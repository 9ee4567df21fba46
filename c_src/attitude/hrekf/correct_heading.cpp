// Correction by a heading aid: one row.
#include "attitude/common/heading_aid.hpp"
#include "attitude/hrekf/correction.hpp"
#include "attitude/hrekf/model.hpp"
#include "estimation/gate.hpp"

namespace hnav {

void HrekfModel::correct_heading(State& s, const Event& event) const {
    const HeadingAid<R> aid(QuaternionR(s.x), event);
    if (!aid.is_defined()) return;
    const Vector3R h = aid.by_rotation();
    const R variance = aid.variance(), nu = aid.residual();
    HrekfCorrection correction(law_, s, event.t_s, covariance(s), length_variance(s));
    const R S = std::fmax(R(0), correction.gaussian().seen_by(h)) + variance; // rounding, after ages without a sample
    R noise = variance;
    InnovationOf<R>& i = record_heading(s.innovation, event.t_s, nu, S, S > 0 ? nu * nu / S : 0);
    const R over = beyond_gate(i.nis, gate_nis(heading));
    if (over > 1 && gate_works(s, heading, correction.rotation_variances())) {
        noise += (over - 1) * S;
        i.noise_scale = noise / variance;
        ++s.gated[heading];
    }
    correction.take(h, nu, noise);
    correction.apply(false, true);
}

} // namespace hnav
