// Correction by force and field: the directions of gravity and of the magnetic field, each known in navigation axes and
// measured in body axes. Force and field of one event correct together: the six rows of the paper.
#pragma once

#include "attitude/hrekf/correction.hpp"
#include "attitude/hrekf/model.hpp"
#include "estimation/gate.hpp"

namespace hnav {

template <class R>
struct HrekfDirection {
    int channel;
    Vector3Of<R> reference_n;
    Vector3Of<R> measured_b;
    R variance;
};

// Of a field a thousand times the reference no more than the direction is to be believed: taken at its word it would throw
// the bias beyond all rates.
template <class R>
inline Vector3Of<R> field_in_units(const AttitudeEvent& event, R strength) {
    const Vector3Of<R> field = vector_of<R>(event, mag) / strength;
    const R length = field.norm();
    return length > R(1e3) ? Vector3Of<R>(field * (R(1e3) / length)) : field;
}

template <class R>
void HrekfModelOf<R>::correct_directions(State& s, const Event& event) const {
    const R T_accel = s.has(event, accel) ? interval(s, accel, event.t_s) : 0;
    R T_mag = s.has(event, mag) ? interval(s, mag, event.t_s) : 0;
    if (s.has(event, mag) && !s.has_reference) { // started without a field: this one becomes the reference
        learn(s, QuaternionR(s.x).normalized(), vector_of<R>(event, mag));
        T_mag = 0;
    }
    const HrekfDirection<R> force{accel, Vector3R(0, 0, -1), vector_of<R>(event, accel).normalized(),
                                  density_.accel_density2 / T_accel};
    const HrekfDirection<R> field{mag, Vector3R(s.reference_north, 0, s.reference_down),
                                  field_in_units(event, s.reference_strength), density_.mag_density2 / T_mag};
    if (T_accel > 0 && T_mag > 0) correct_by<2>(s, event.t_s, {force, field});
    else if (T_accel > 0) correct_by<1>(s, event.t_s, {force});
    else if (T_mag > 0) correct_by<1>(s, event.t_s, {field});
    if (T_mag > 0) doubt_heading(s, T_mag);
}

template <class R>
template <int count>
void HrekfModelOf<R>::correct_by(State& s, double t_s, const HrekfDirection<R> (&directions)[count]) const {
    constexpr int m = 3 * count;
    const QuaternionR q(s.x);
    const Matrix3R R_nb = rotation_matrix<R>(q).transpose();
    Eigen::Matrix<R, m, 1> nu;
    Eigen::Matrix<R, m, 4> H;
    Square<m, R> noise = Square<m, R>::Zero();
    for (int k = 0; k < count; ++k) {
        const HrekfDirection<R>& d = directions[k];
        segment<3>(nu, 3 * k) = d.measured_b - R_nb * d.reference_n;
        rows<3>(H, 3 * k) = J_body_q<R>(q, d.reference_n);
        diagonal<3>(noise, 3 * k).setConstant(d.variance);
    }

    HrekfCorrection<m, R> correction(law_, s, t_s, H, noise);
    const Square<m, R> S = correction.innovation_covariance();
    bool gated = false;
    for (int k = 0; k < count; ++k) {
        const HrekfDirection<R>& d = directions[k];
        const Matrix3R S_k = block<3, 3>(S, 3 * k, 3 * k);
        const InnovationOf<R>& innovation = record(s, d, t_s, segment<3>(nu, 3 * k), S_k);
        if (!(innovation.noise_scale > 1)) continue;
        // A sample beyond its gate is not dropped: its noise grows until its distance is at the limit.
        gated = true;
        block<3, 3>(noise, 3 * k, 3 * k) += (innovation.nis / gate_nis(d.channel) - 1) * S_k;
        ++s.gated[d.channel];
    }
    if (gated) correction.change_noise(noise);
    const bool by_force = directions[0].channel == accel;
    const bool by_field = directions[count - 1].channel == mag;
    correction.apply(nu, by_force, by_field);
}

// Keeps what a sensor said, and the factor by which its gate inflates the noise.
template <class R>
const InnovationOf<R>& HrekfModelOf<R>::record(State& s, const HrekfDirection<R>& direction, double t_s, const Vector3R& nu,
                                               const Matrix3R& S) const {
    InnovationOf<R>& i = s.innovation[direction.channel];
    i.t_s = t_s;
    i.dimension = 3;
    Eigen::Map<Vector3R>(i.value) = nu;
    Eigen::Map<Matrix3R>(i.S) = S;
    const R nis = Cholesky<3, R>(S).quadratic_form(nu);
    i.nis = std::fmax(R(0), nis); // rounding, where S is nearly singular
    i.noise_scale = 1;
    const R over = beyond_gate(i.nis, gate_nis(direction.channel));
    if (over > 1 && gate_works(s, direction.channel)) i.noise_scale = 1 + (over - 1) * S.trace() / (3 * direction.variance);
    return i;
}

} // namespace hnav
