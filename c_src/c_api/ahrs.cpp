// Options of the AHRS, and the filter made from them.
#include "attitude/ahrs/model.hpp"
#include "c_api/creation.hpp"

namespace {

using R = hnav::Scalar;
using AhrsModel = hnav::AhrsModelOf<R>;
using hnav::square;

AhrsModel::Sigmas sigmas_of(const hnav_ahrs_options& o) {
    return {R(o.start_sigma_tilt_rad),        R(o.start_sigma_heading_rad),
            R(o.start_sigma_bias_rad_s),      R(o.start_sigma_velocity_m_s),
            R(o.start_sigma_reference),       R(o.start_sigma_latency_s),
            R(o.start_sigma_gyro_scale),      R(o.start_sigma_gyro_misalignment_rad),
            R(o.start_sigma_accel_bias_m_s2), R(o.start_sigma_accel_latency),
            R(o.local_declination_rad)};
}

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
    s.force_latency = o.start_accel_latency;
    s.declination_s = o.local_declination_s;
    s.rest_bias_density2 = square(o.rest_bias_noise_rad_s_per_sqrt_hz);
    s.velocity_gate_nis = o.velocity_gate_nis;
    s.azimuth_gate = o.mag_azimuth_gate_sigmas;
    hnav::set_checks(o, s.check);
    s.correction_interval_s = o.correction_interval_s;
    s.max_interval_s = o.max_interval_s;
    s.gap_acceleration_m_s2 = o.gap_acceleration_m_s2;
    s.gap_turn_factor = o.gap_turn_factor;
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
    s.field.gate_max_s = o.mag_gate_max_s;
    s.field.gate_share = o.mag_gate_share;
    s.field.turning_rad_s = o.turning_rad_s;
    s.field.still_weight = o.still_weight;
    s.field.candidate_radius = o.candidate_radius;
    s.field.candidate_mean_s = o.candidate_mean_s;
    s.field.candidate_first_s = o.candidate_first_s;
    s.field.candidate_share = o.candidate_share;
    s.field.trust_s = o.trust_s;
    s.field.heading_min_rad = o.turn_min_rad;
    s.field.heading_sigmas = o.turn_sigmas;
    s.field.heading_added_rad = o.turn_sigma_rad;
    s.start = hnav::start_of(o, frames);
    s.start.field_wait_s = o.start_field_wait_s;
    s.start_bias = hnav::Vector3(o.start_gyro_bias_rad_s).cast<R>();
    s.sigma = sigmas_of(o);
    s.reference_given = o.reference_mode == HNAV_REFERENCE_GIVEN;
    s.reference = {R(o.reference_strength_tesla), R(o.reference_dip_rad)};
    s.heading_gate_nis = o.heading_gate_nis;
    s.ready_tilt_rad = o.ready_tilt_rad;
    s.ready_heading_rad = o.ready_heading_rad;
    s.ready_evidence_s = o.ready_evidence_s;
    s.ready_undisturbed_s = o.ready_undisturbed_s;
    s.output_latency_s = o.output_latency_s;
    return s;
}

} // namespace

extern "C" {

hnav_ahrs_options hnav_ahrs_defaults(hnav_preset preset) {
    return hnav::made_from<hnav_ahrs_options>(hnav::ahrs_options, preset);
}

hnav_status hnav_ahrs_create(hnav_filter** filter, const hnav_ahrs_options* options, char* message, size_t message_size) {
    const hnav::Creation creation{{message, message_size}, hnav::ahrs_options};
    const hnav_status status = creation.check(filter, options);
    if (status != HNAV_OK) return status;
    const hnav::Frames frames = hnav::frames_of(*options);
    return creation.make(filter, AhrsModel(settings_of(*options, frames)), frames, *options);
}

size_t hnav_ahrs_memory_bytes(const hnav_ahrs_options* options) {
    return hnav::Creation{{nullptr, 0}, hnav::ahrs_options}.bytes_for<AhrsModel>(options);
}

hnav_status hnav_ahrs_create_in(void* memory, size_t bytes, hnav_filter** filter, const hnav_ahrs_options* options, char* message,
                                size_t message_size) {
    const hnav::Creation creation{{message, message_size}, hnav::ahrs_options};
    const hnav_status status = creation.check(filter, options);
    if (status != HNAV_OK) return status;
    const hnav::Frames frames = hnav::frames_of(*options);
    return creation.make_in(memory, bytes, filter, AhrsModel(settings_of(*options, frames)), frames, *options);
}

} // extern "C"
