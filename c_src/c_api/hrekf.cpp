// Options of the paper's filter, and the filter made from them.
#include "attitude/hrekf/model.hpp"
#include "c_api/creation.hpp"

#include <cmath>

namespace {

using hnav::HrekfModel;

// The model's enumerations are the API's, one to one.
static_assert(int(hnav::GammaMode::kl) == HNAV_GAMMA_KL && int(hnav::GammaMode::relative) == HNAV_GAMMA_RELATIVE);
static_assert(int(hnav::Adaptation::corrected) == HNAV_ADAPTATION_CORRECTED);
static_assert(int(hnav::StartMode::heading) == HNAV_START_HEADING);

HrekfModel::Settings settings_of(const hnav_hrekf_options& o, const hnav::Frames& frames) {
    HrekfModel::Settings s{};
    s.gyro_psd = hnav::square(o.gyro_noise_rad_per_sqrt_s);
    s.quaternion_psd = hnav::square(o.quaternion_noise_per_sqrt_s);
    s.bias_walk_psd = hnav::square(o.gyro_bias_walk_rad_s_per_sqrt_s);
    s.accel_density2 = hnav::square(o.accel_noise_per_sqrt_hz);
    s.mag_density2 = hnav::square(o.mag_noise_per_sqrt_hz);
    s.max_interval_s = o.max_interval_s;
    s.backward_hold = o.gyro_hold == HNAV_GYRO_HOLD_BACKWARD;
    s.robust.mode = static_cast<hnav::GammaMode>(o.gamma_mode);
    s.robust.gamma = o.gamma;
    s.robust.relative_rate = o.gamma_relative_rate_1_s;
    s.robust.kl_rate = o.gamma_kl_rate_1_s;
    s.weight.head<4>().setConstant(o.gamma_weight_attitude);
    s.weight.tail<3>().setConstant(o.gamma_weight_bias);
    s.adaptation.mode = static_cast<hnav::Adaptation>(o.adaptation);
    s.adaptation.gain = o.adaptation_gain;
    s.adaptation.min = hnav::square(o.adaptation_min_rad_s_per_sqrt_s);
    s.adaptation.max = hnav::square(o.adaptation_max_rad_s_per_sqrt_s);
    s.start = hnav::start_of(o, frames);
    s.start_bias = hnav::Vector3(o.start_gyro_bias_rad_s);
    s.sigma_tilt = o.start_sigma_tilt_rad;
    s.sigma_bias = o.start_sigma_bias_rad_s;
    s.reference_given = o.reference_mode == HNAV_REFERENCE_GIVEN;
    s.reference = {o.reference_strength_tesla, o.reference_dip_rad};
    s.gate_nis[hnav::accel] = o.accel_gate_nis;
    s.gate_nis[hnav::mag] = o.mag_gate_nis;
    s.gate_nis[hnav::heading] = o.heading_gate_nis;
    hnav::set_checks(o, s.check);
    s.ready_tilt_rad = o.ready_tilt_rad;
    s.ready_heading_rad = o.ready_heading_rad;
    return s;
}

// Conditions that no single field can break. Null when all hold.
const char* contradiction(const hnav_hrekf_options& o) {
    if (o.adaptation_min_rad_s_per_sqrt_s > o.adaptation_max_rad_s_per_sqrt_s)
        return "adaptation_min_rad_s_per_sqrt_s exceeds adaptation_max_rad_s_per_sqrt_s";
    return nullptr;
}

} // namespace

extern "C" {

hnav_status hnav_hrekf_create(hnav_filter** filter, const hnav_hrekf_options* options, char* message, size_t message_size) {
    const hnav::Creation creation{{message, message_size}, hnav::hrekf_options};
    hnav_status status = creation.check(filter, options);
    if (status != HNAV_OK) return status;
    if (const char* reason = contradiction(*options)) return creation.fail(HNAV_ERROR_OPTION, "%s", reason);
    const hnav::Frames frames = hnav::frames_of(*options);
    return creation.make(filter, HrekfModel(settings_of(*options, frames)), frames, *options);
}

} // extern "C"
