// The prior covariance, and the initial attitude.
#include "attitude/hrekf/model.hpp"

namespace hnav {

// Valid for any attitude, because the rotation error is about the navigation axes.
void HrekfModel::put_covariance(State& s, R sigma_heading, const Matrix3R& of_bias) const {
    const R tilt = R(options_.start_sigma_tilt_rad);
    Covariance P = Covariance::Zero();
    diagonal<3>(P, 0) = Vector3R(tilt * tilt, tilt * tilt, sigma_heading * sigma_heading);
    block<3, 3>(P, 3, 3) = of_bias;
    pack<6>(P, s.P);
    s.forget_integrals();
}

void HrekfModel::begin(State& s) const {
    put_q(s, {1, 0, 0, 0});
    begin_bias(s);
    s.gamma = std::numeric_limits<R>::infinity();
    s.gamma_margin = 1;
    for (InnovationOf<R>& i : s.innovation) i = {};
    forget_attitude(s);
}

void HrekfModel::begin_bias(State& s) const {
    Eigen::Map<Vector3R>(s.bias) = Vector3(options_.start_gyro_bias_rad_s).cast<R>();
    const R bias = R(options_.start_sigma_bias_rad_s);
    put_covariance(s, start_.sigma_heading, bias * bias * Matrix3R::Identity());
    pack<3>(Matrix3R(density_.bias_walk_psd * Matrix3R::Identity()), s.bias_psd);
}

void HrekfModel::realign(State& s) const {
    put_q(s, {1, 0, 0, 0});
    put_covariance(s, start_.sigma_heading, bias_covariance(s));
    forget_attitude(s);
}

void HrekfModel::forget_attitude(State& s) const {
    s.started = 0;
    for (double& t : s.last_s) t = nan;
    s.start.clear();
    s.information = {};
    s.field_far_s = 0;
    s.last_correction_s = nan;
    s.error_map.interval_s = 0;
    s.has_reference = reference_given(options_);
    put_reference(s, reference_of<R>(options_));
    s.previous_bias_trace = bias_covariance(s).trace();
    s.adaptation.clear();
}

void HrekfModel::collect_for_start(State& s, const Event& event) const {
    FirstAttitude<R> found;
    const StartSettings<R> settings = s.lost ? start_.after_loss() : start_;
    if (!s.start.add(event, s.usable(event), turn_rate(s), settings, &found)) return;
    put_q(s, found.q);
    put_covariance(s, found.sigma_heading, bias_covariance(s));
    if (!s.has_reference && s.start.has_field(start_)) learn(s, found.q, s.start.field());
    s.error_map.begin();
    s.last_correction_s = event.t_s;
    s.started = 1;
    s.lost = 0;
}

void HrekfModel::put_reference(State& s, const ReferenceFieldOf<R>& reference) {
    s.reference_strength = reference.strength;
    s.reference_north = std::cos(reference.dip_rad);
    s.reference_down = std::sin(reference.dip_rad);
}

void HrekfModel::learn(State& s, const QuaternionR& q, const Vector3R& field_b) {
    put_reference(s, learn_reference<R>(q, field_b));
    s.has_reference = 1;
}

} // namespace hnav
