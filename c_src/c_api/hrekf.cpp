// Options of the paper's filter, and the filter made from them.
#include "attitude/hrekf/hrekf_model.hpp"
#include "c_api/creation.hpp"

#include <cmath>

namespace {

using hnav::HrekfModel;

constexpr double deg = M_PI / 180;

// The model's enumerations are the API's, one to one.
static_assert(int(hnav::GammaMode::kl) == HNAV_GAMMA_KL && int(hnav::GammaMode::relative) == HNAV_GAMMA_RELATIVE);
static_assert(int(hnav::Adaptation::corrected) == HNAV_ADAPTATION_CORRECTED);
static_assert(int(hnav::StartMode::heading) == HNAV_START_HEADING);
static_assert(int(hnav::heading) == HNAV_SENSOR_HEADING && int(hnav::channel_count) == HNAV_SENSOR_COUNT);

HrekfModel::Settings settings_of(const hnav_hrekf_options& o, const hnav::Frames& frames) {
    HrekfModel::Settings s{};
    s.gyro_psd = hnav::square(o.gyro_noise_rad_per_sqrt_s);
    s.quaternion_psd = hnav::square(o.quaternion_noise_per_sqrt_s);
    s.bias_walk_psd = hnav::square(o.gyro_bias_walk_rad_s_per_sqrt_s);
    s.accel_density2 = hnav::square(o.accel_noise_per_sqrt_hz);
    s.mag_density2 = hnav::square(o.mag_noise_per_sqrt_hz);
    s.interval_limit_s = o.interval_limit_s;
    s.backward_hold = o.gyro_hold == HNAV_GYRO_HOLD_BACKWARD;
    s.robust.mode = static_cast<hnav::GammaMode>(o.gamma_mode);
    s.robust.gamma = o.gamma;
    s.robust.relative_rate = o.gamma_relative_rate_1_s;
    s.robust.kl_rate = o.gamma_kl_rate_1_s;
    s.weight.head<4>().setConstant(o.gamma_weight_attitude);
    s.weight.tail<3>().setConstant(o.gamma_weight_bias);
    s.adaptation.mode = static_cast<hnav::Adaptation>(o.adaptation);
    s.adaptation.gain = o.adaptation_gain;
    s.adaptation.least = hnav::square(o.adaptation_floor_rad_s_per_sqrt_s);
    s.adaptation.most = hnav::square(o.adaptation_cap_rad_s_per_sqrt_s);
    s.start = hnav::start_of(o, frames);
    s.start_bias = hnav::Vector3(o.start_gyro_bias_rad_s);
    s.sigma_tilt = o.start_sigma_tilt_rad;
    s.sigma_bias = o.start_sigma_bias_rad_s;
    s.reference_given = o.reference_mode == HNAV_REFERENCE_GIVEN;
    s.reference = {o.reference_strength_tesla, o.reference_dip_rad};
    s.gate_nis[hnav::accel] = o.accel_gate_nis;
    s.gate_nis[hnav::mag] = o.mag_gate_nis;
    s.gate_nis[hnav::heading] = o.heading_gate_nis;
    s.ready_tilt_rad = o.ready_tilt_rad;
    s.ready_heading_rad = o.ready_heading_rad;
    return s;
}

// Conditions that no single field can break. Null when all hold.
const char* contradiction(const hnav_hrekf_options& o) {
    if (o.adaptation_floor_rad_s_per_sqrt_s > o.adaptation_cap_rad_s_per_sqrt_s)
        return "adaptation_floor_rad_s_per_sqrt_s exceeds adaptation_cap_rad_s_per_sqrt_s";
    return nullptr;
}

} // namespace

extern "C" {

hnav_hrekf_options hnav_hrekf_defaults(hnav_preset preset) {
    hnav_hrekf_options o{};
    if (preset != HNAV_PRESET_DEFAULT && preset != HNAV_PRESET_PAPER) return o; // no cookie: create refuses it
    o.cookie = hnav::hrekf_cookie;
    // Real sensors: one setting for all, found on the BROAD recordings. The measurement noise is far above any datasheet:
    // it stands for the accelerations and field distortions that the filter does not model. Accelerations have heavy
    // tails, so the gate of force lies far inside that noise, like the threshold of a Huber loss. It cannot shut for
    // good: while it rejects, sigma grows, and beyond ready_tilt_rad the gate opens.
    o.gyro_noise_rad_per_sqrt_s = 1e-2;
    o.gyro_bias_walk_rad_s_per_sqrt_s = 1e-4;
    o.accel_noise_per_sqrt_hz = 0.115;
    o.mag_noise_per_sqrt_hz = 0.16;
    o.interval_limit_s = 0.1;
    o.gamma = 1;
    o.gamma_relative_rate_1_s = 1.5;
    o.gamma_kl_rate_1_s = 0.1;
    o.gamma_weight_attitude = 1;
    o.gamma_weight_bias = 1;
    o.adaptation_gain = 0.02;
    o.adaptation_floor_rad_s_per_sqrt_s = 1e-6;
    o.adaptation_cap_rad_s_per_sqrt_s = 1e-2;
    o.start_q_nb[0] = 1;
    o.start_sigma_tilt_rad = 0.1;
    o.start_sigma_heading_rad = 0.35;
    o.start_sigma_bias_rad_s = 0.01;
    o.reference_strength_tesla = 5e-5;
    o.reference_dip_rad = 60 * deg;
    o.accel_gate_nis = 0.13; // with noise from a datasheet take 13.9: 99.7 % of chi square with 3 degrees of freedom
    o.mag_gate_nis = 13.9;
    o.heading_gate_nis = 8.8; // 99.7 % with 1
    o.ready_tilt_rad = 2 * deg;
    o.ready_heading_rad = 5 * deg;
    o.q_body_sensor[0] = 1;
    o.solver_rtol = 1e-8;
    o.solver_atol = 1e-8;
    o.euler_step_s = 0.005;
    o.gyro_hold = HNAV_GYRO_HOLD_FORWARD;
    o.gamma_mode = HNAV_GAMMA_OFF;
    o.adaptation = HNAV_ADAPTATION_OFF;
    o.start_mode = HNAV_START_TRIAD;
    o.start_samples = 1;
    o.reference_mode = HNAV_REFERENCE_LEARNT;
    o.navigation_frame = HNAV_FRAME_NED;
    o.solver = HNAV_SOLVER_ERKSTEP;
    o.queue_capacity = 64;
    if (preset == HNAV_PRESET_PAPER) {
        // Q = 1e-6 I7, R = 1e-2 I6 at 100 Hz, P0 = 1e-6 I7, L = I, two Euler steps per sample. P0 and the rate of
        // gamma (rho = 0.015 at 100 Hz) are fitted: with them the ratios of the paper's Table 1 come back.
        o.gyro_noise_rad_per_sqrt_s = 0;
        o.quaternion_noise_per_sqrt_s = 1e-3;
        o.gyro_bias_walk_rad_s_per_sqrt_s = 1e-3;
        o.accel_noise_per_sqrt_hz = 1e-2;
        o.mag_noise_per_sqrt_hz = 1e-2;
        o.gamma_mode = HNAV_GAMMA_RELATIVE;
        o.gamma_relative_rate_1_s = -std::log1p(-0.015) / 0.01;
        o.adaptation_gain = 0.5;
        o.start_sigma_tilt_rad = 2e-3; // 1e-3 on each component of q
        o.start_sigma_heading_rad = 2e-3;
        o.start_sigma_bias_rad_s = 1e-3;
        o.accel_gate_nis = o.mag_gate_nis = o.heading_gate_nis = 0;
        o.solver = HNAV_SOLVER_EULER;
    }
    return o;
}

const hnav_option_info* hnav_hrekf_option(int32_t index) {
    const hnav::OptionTable table = hnav::hrekf_option_table();
    return index >= 0 && index < table.count ? &table.rows[index] : nullptr;
}

hnav_status hnav_hrekf_create(hnav_filter** filter, const hnav_hrekf_options* options, char* message, size_t message_size) {
    const hnav::Creation creation{{message, message_size}, hnav::hrekf_option_table(), hnav::hrekf_cookie, "hnav_hrekf_defaults"};
    hnav_status status = creation.check(filter, options);
    if (status != HNAV_OK) return status;
    if (const char* reason = contradiction(*options)) return creation.fail(HNAV_ERROR_OPTION, "%s", reason);
    const hnav::Frames frames = hnav::frames_of(*options);
    return creation.make(filter, HrekfModel(settings_of(*options, frames)), frames, *options);
}

} // extern "C"
