// Before the start: what the filter is sure of, and the attitude it starts from.
#pragma once

#include "attitude/hrekf/model.hpp"

namespace hnav {

template <class R>
inline Square<4, R> hrekf_attitude_covariance(const QuaternionOf<R>& q, R sigma_tilt, R sigma_heading) {
    const Matrix34Of<R> T = rotation_from_error<R>(q);
    const Vector3Of<R> variance(sigma_tilt * sigma_tilt, sigma_tilt * sigma_tilt, sigma_heading * sigma_heading);
    return T.transpose() * variance.asDiagonal() * T / 16;
}

template <class R>
void HrekfModelOf<R>::begin(State& s) const {
    const QuaternionR identity(1, 0, 0, 0);
    put_q(s, identity);
    Eigen::Map<Vector3R>(s.x + 4) = Vector3(options_.start_gyro_bias_rad_s).cast<R>();
    Covariance P = Covariance::Zero();
    block<4, 4>(P, 0, 0) = hrekf_attitude_covariance<R>(identity, R(options_.start_sigma_tilt_rad), start_.sigma_heading);
    diagonal<3>(P, 4).setConstant(R(options_.start_sigma_bias_rad_s) * R(options_.start_sigma_bias_rad_s));
    pack<7>(P, s.x + 7);
    pack<3>(Matrix3R(density_.bias_walk_psd * Matrix3R::Identity()), s.bias_psd);
    s.gamma = std::numeric_limits<R>::infinity();
    s.gamma_margin = 1;
    for (InnovationOf<R>& i : s.innovation) i = {};
    forget_attitude(s);
}

template <class R>
void HrekfModelOf<R>::realign(State& s) const {
    put_q(s, {1, 0, 0, 0});
    forget_attitude(s);
}

template <class R>
void HrekfModelOf<R>::forget_attitude(State& s) const {
    s.started = 0;
    for (double& t : s.last_s) t = nan;
    s.start.clear();
    s.information = {};
    s.field_far_s = 0;
    s.last_correction_s = nan;
    s.error_map.interval_s = 0;
    s.has_reference = reference_given(options_);
    put_reference(s, reference_of<R>(options_));
    s.previous_bias_trace = Blocks(s.x + 7).bb.trace();
    s.adaptation.clear();
}

template <class R>
void HrekfModelOf<R>::collect_for_start(State& s, const Event& event) const {
    FirstAttitude<R> found;
    if (!s.start.add(event, s.usable(event), turn_rate(s, s.x), start_, &found)) return;
    put_q(s, found.q);
    Covariance P = Covariance::Zero();
    block<4, 4>(P, 0, 0) = hrekf_attitude_covariance<R>(found.q, R(options_.start_sigma_tilt_rad), found.sigma_heading);
    block<3, 3>(P, 4, 4) = Blocks(s.x + 7).bb;
    pack<7>(P, s.x + 7);
    if (!s.has_reference && s.start.has_field(start_)) learn(s, found.q, s.start.field());
    s.error_map.begin(event.t_s, found.q, s.x + 7);
    s.last_correction_s = event.t_s;
    s.started = 1;
    s.lost = 0;
}

template <class R>
void HrekfModelOf<R>::put_reference(State& s, const ReferenceFieldOf<R>& reference) {
    s.reference_strength = reference.strength;
    s.reference_north = std::cos(reference.dip_rad);
    s.reference_down = std::sin(reference.dip_rad);
}

template <class R>
void HrekfModelOf<R>::learn(State& s, const QuaternionR& q, const Vector3R& field_b) {
    put_reference(s, learn_reference<R>(q, field_b));
    s.has_reference = 1;
}

template <class R>
inline void hrekf_nominal_sizes(R tilt, R heading_sigma, R bias, R* x) {
    Eigen::Matrix<R, 7, 1> sigma;
    segment<4>(sigma, 0).setConstant(R(0.5) * std::fmax(tilt, heading_sigma));
    segment<3>(sigma, 4).setConstant(bias);
    for (int i = 0; i < 4; ++i) x[i] = 1;
    for (int i = 4; i < 7; ++i) x[i] = std::fmax(bias, R(1e-6));
    // The gain is a quotient of covariances, and correlations are often far below one: an absolute tolerance on the
    // scale of the product of two sigmas would be felt in the bias. Hence a hundredth of it.
    pack<7>(Square<7, R>((R(0.01) * sigma * sigma.transpose()).cwiseMax(R(1e-14))), x + 7);
}

template <class R>
void HrekfModelOf<R>::nominal(R* x) const {
    hrekf_nominal_sizes(R(options_.start_sigma_tilt_rad), start_.sigma_heading, R(options_.start_sigma_bias_rad_s), x);
}

// Never below a ten-thousandth of the sizes at the start.
template <class R>
void HrekfModelOf<R>::nominal(const State& s, R* x) const {
    constexpr R share = R(1e-4);
    const Covariance P = unpack<7>(s.x + 7);
    const R tilt = 2 * std::sqrt(std::fmax(R(0), block<4, 4>(P, 0, 0).trace()));
    const R bias = std::sqrt(std::fmax(R(0), block<3, 3>(P, 4, 4).trace()));
    hrekf_nominal_sizes(std::fmax(tilt, share * R(options_.start_sigma_tilt_rad)), std::fmax(tilt, share * start_.sigma_heading),
                        std::fmax(bias, share * R(options_.start_sigma_bias_rad_s)), x);
}

} // namespace hnav
