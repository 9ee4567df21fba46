// Options of the AHRS, and the filter made from them.
#include "attitude/ahrs/ahrs_model.hpp"
#include "c_api/creation.hpp"

namespace {

using hnav::AhrsModel;
using hnav::square;

constexpr double deg = M_PI / 180;

AhrsModel::Settings settings_of(const hnav_ahrs_options& o, const hnav::Frames& frames) {
    AhrsModel::Settings s{};
    s.gyro_psd = square(o.gyro_noise_rad_per_sqrt_s);
    s.gyro_rate_psd = square(o.gyro_rate_noise_sqrt_s);
    s.bias_walk_psd = square(o.gyro_bias_walk_rad_s_per_sqrt_s);
    s.reference_psd = square(o.reference_walk_per_sqrt_s);
    s.velocity_density2 = square(o.velocity_noise_m_s_per_sqrt_hz);
    s.azimuth_density2 = square(o.mag_azimuth_noise_per_sqrt_hz);
    s.intensity_density2 = square(o.mag_intensity_noise_per_sqrt_hz);
    s.rest_field_factor = o.mag_rest_factor;
    s.rest_bias_density2 = square(o.rest_bias_noise_rad_s_per_sqrt_hz);
    s.correction_interval_s = o.correction_interval_s;
    s.interval_limit_s = o.interval_limit_s;
    s.unseen_acceleration_m_s2 = o.unseen_acceleration_m_s2;
    s.unseen_turn_factor = o.unseen_turn_factor;
    s.backward_hold = o.gyro_hold == HNAV_GYRO_HOLD_BACKWARD;
    s.robust.mode = static_cast<hnav::GammaMode>(o.gamma_mode);
    s.robust.gamma = o.gamma;
    s.robust.relative_rate = o.gamma_relative_rate_1_s;
    s.robust.kl_rate = o.gamma_kl_rate_1_s;
    s.rest.rate_rad_s = o.rest_rate_rad_s;
    s.rest.force_m_s2 = o.rest_force_m_s2;
    s.rest.mean_rate_rad_s = o.rest_mean_rate_rad_s;
    s.rest.duration_s = o.rest_duration_s;
    s.rest.filter_s = o.rest_filter_s;
    s.field.gate = o.mag_gate;
    s.field.gate_longest_s = o.mag_gate_longest_s;
    s.field.gate_share = o.mag_gate_share;
    s.field.turning_rad_s = o.turning_rad_s;
    s.field.still_weight = o.still_weight;
    s.field.candidate_radius = o.candidate_radius;
    s.field.candidate_mean_s = o.candidate_mean_s;
    s.field.candidate_first_s = o.candidate_first_s;
    s.field.candidate_share = o.candidate_share;
    s.field.trust_s = o.trust_s;
    s.field.heading_least_rad = o.turn_least_rad;
    s.field.heading_sigmas = o.turn_sigmas;
    s.field.heading_added_rad = o.turn_sigma_rad;
    s.start = hnav::start_of(o, frames);
    s.start.field_wait_s = o.start_field_wait_s;
    s.start_bias = hnav::Vector3(o.start_gyro_bias_rad_s);
    s.sigma = {o.start_sigma_tilt_rad,  o.start_sigma_heading_rad, o.start_sigma_bias_rad_s, o.start_sigma_velocity_m_s,
               o.start_sigma_reference, o.start_sigma_latency_s,   o.start_sigma_gyro_scale, o.start_sigma_gyro_misalignment_rad};
    s.reference_given = o.reference_mode == HNAV_REFERENCE_GIVEN;
    s.reference = {o.reference_strength_tesla, o.reference_dip_rad};
    s.heading_gate_nis = o.heading_gate_nis;
    s.ready_tilt_rad = o.ready_tilt_rad;
    s.ready_heading_rad = o.ready_heading_rad;
    s.ready_evidence_s = o.ready_evidence_s;
    s.ready_calm_s = o.ready_calm_s;
    s.output_latency_s = o.output_latency_s;
    return s;
}

} // namespace

extern "C" {

hnav_ahrs_options hnav_ahrs_defaults(hnav_preset preset) {
    hnav_ahrs_options o{};
    if (preset != HNAV_PRESET_DEFAULT) return o; // no cookie: create refuses it
    o.cookie = hnav::ahrs_cookie;
    o.gyro_noise_rad_per_sqrt_s = 1.2e-4;
    o.gyro_rate_noise_sqrt_s = 2.4e-3;
    o.gyro_bias_walk_rad_s_per_sqrt_s = 1.4e-4;
    o.velocity_noise_m_s_per_sqrt_hz = 0.52;
    o.unseen_acceleration_m_s2 = 2;
    o.unseen_turn_factor = 1.5;
    o.mag_azimuth_noise_per_sqrt_hz = 0.026;
    o.mag_intensity_noise_per_sqrt_hz = 0.018;
    o.mag_rest_factor = 1.5;
    o.reference_walk_per_sqrt_s = 4.4e-3;
    o.correction_interval_s = 0.035;
    o.interval_limit_s = 0.1;
    o.rest_rate_rad_s = 2 * deg;
    o.rest_force_m_s2 = 0.5;
    o.rest_mean_rate_rad_s = 2 * deg;
    o.rest_duration_s = 1.5;
    o.rest_filter_s = 0.5;
    o.rest_bias_noise_rad_s_per_sqrt_hz = 4e-5;
    o.mag_gate = 0.035;
    o.mag_gate_longest_s = 60;
    o.mag_gate_share = 3;
    o.turning_rad_s = 0.35;
    o.still_weight = 0.35;
    o.candidate_radius = 0.17;
    o.candidate_mean_s = 5;
    o.candidate_first_s = 1.6;
    o.candidate_share = 0.4;
    o.trust_s = 60;
    o.turn_least_rad = 0.13;
    o.turn_sigmas = 3.75;
    o.turn_sigma_rad = 0.12;
    o.gamma = 1;
    o.gamma_relative_rate_1_s = 0.3;
    o.gamma_kl_rate_1_s = 0.1;
    o.start_q_nb[0] = 1;
    o.start_field_wait_s = 1;
    o.start_sigma_tilt_rad = 0.08;
    o.start_sigma_heading_rad = 0.28;
    o.start_sigma_bias_rad_s = 0.008;
    o.start_sigma_velocity_m_s = 0.08;
    o.start_sigma_reference = 0.11;
    o.start_sigma_latency_s = 0.016;
    o.start_sigma_gyro_scale = 1.6e-3;
    o.start_sigma_gyro_misalignment_rad = 0.8e-3;
    o.reference_strength_tesla = 5e-5;
    o.reference_dip_rad = 60 * deg;
    o.heading_gate_nis = 8.8;
    o.ready_tilt_rad = 2 * deg;
    o.ready_heading_rad = 5 * deg;
    o.ready_evidence_s = 3;
    o.ready_calm_s = 8;
    o.q_body_sensor[0] = 1;
    o.solver_rtol = 1e-8;
    o.solver_atol = 1e-8;
    o.euler_step_s = 0.001;
    o.gyro_hold = HNAV_GYRO_HOLD_BACKWARD;
    o.gamma_mode = HNAV_GAMMA_RELATIVE;
    o.start_mode = HNAV_START_TRIAD;
    o.start_samples = 1;
    o.reference_mode = HNAV_REFERENCE_LEARNT;
    o.navigation_frame = HNAV_FRAME_NED;
    o.solver = HNAV_SOLVER_ERKSTEP;
    o.queue_capacity = 64;
    return o;
}

const hnav_option_info* hnav_ahrs_option(int32_t index) {
    const hnav::OptionTable table = hnav::ahrs_option_table();
    return index >= 0 && index < table.count ? &table.rows[index] : nullptr;
}

hnav_status hnav_ahrs_create(hnav_filter** filter, const hnav_ahrs_options* options, char* message, size_t message_size) {
    const hnav::Creation creation{{message, message_size}, hnav::ahrs_option_table(), hnav::ahrs_cookie, "hnav_ahrs_defaults"};
    const hnav_status status = creation.check(filter, options);
    if (status != HNAV_OK) return status;
    const hnav::Frames frames = hnav::frames_of(*options);
    return creation.make(filter, AhrsModel(settings_of(*options, frames)), frames, *options);
}

} // extern "C"
