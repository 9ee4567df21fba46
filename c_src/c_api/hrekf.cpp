// Options of the paper's filter, and the filter made from them.
#include "attitude/hrekf/model.hpp"
#include "c_api/creation.hpp"

#include <cmath>

namespace {

using R = hnav::Scalar;
using HrekfModel = hnav::HrekfModelOf<R>;

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
    s.start_bias = hnav::Vector3(o.start_gyro_bias_rad_s).cast<R>();
    s.sigma_tilt = o.start_sigma_tilt_rad;
    s.sigma_bias = o.start_sigma_bias_rad_s;
    s.reference_given = o.reference_mode == HNAV_REFERENCE_GIVEN;
    s.reference = {R(o.reference_strength_tesla), R(o.reference_dip_rad)};
    s.gate_nis[hnav::accel] = o.accel_gate_nis;
    s.gate_nis[hnav::mag] = o.mag_gate_nis;
    s.gate_nis[hnav::heading] = o.heading_gate_nis;
    hnav::set_checks(o, s.check);
    s.ready_tilt_rad = o.ready_tilt_rad;
    s.ready_heading_rad = o.ready_heading_rad;
    return s;
}

// Conditions that no single field can break stand behind those of each.
hnav_status check(const hnav::Creation& creation, hnav_filter** filter, const hnav_hrekf_options* options) {
    const hnav_status status = creation.check(filter, options);
    if (status == HNAV_OK && options->adaptation_min_rad_s_per_sqrt_s > options->adaptation_max_rad_s_per_sqrt_s)
        return creation.fail(HNAV_ERROR_OPTION, "adaptation_min_rad_s_per_sqrt_s exceeds adaptation_max_rad_s_per_sqrt_s");
    return status;
}

} // namespace

extern "C" {

hnav_hrekf_options hnav_hrekf_defaults(hnav_preset preset) {
    return hnav::made_from<hnav_hrekf_options>(hnav::hrekf_options, preset);
}

hnav_status hnav_hrekf_create(hnav_filter** filter, const hnav_hrekf_options* options, char* message, size_t message_size) {
    const hnav::Creation creation{{message, message_size}, hnav::hrekf_options};
    const hnav_status status = check(creation, filter, options);
    if (status != HNAV_OK) return status;
    const hnav::Frames frames = hnav::frames_of(*options);
    return creation.make(filter, HrekfModel(settings_of(*options, frames)), frames, *options);
}

size_t hnav_hrekf_memory_bytes(const hnav_hrekf_options* options) {
    return hnav::Creation{{nullptr, 0}, hnav::hrekf_options}.bytes_for<HrekfModel>(options);
}

hnav_status hnav_hrekf_create_in(void* memory, size_t bytes, hnav_filter** filter, const hnav_hrekf_options* options,
                                 char* message, size_t message_size) {
    const hnav::Creation creation{{message, message_size}, hnav::hrekf_options};
    const hnav_status status = check(creation, filter, options);
    if (status != HNAV_OK) return status;
    const hnav::Frames frames = hnav::frames_of(*options);
    return creation.make_in(memory, bytes, filter, HrekfModel(settings_of(*options, frames)), frames, *options);
}

} // extern "C"
