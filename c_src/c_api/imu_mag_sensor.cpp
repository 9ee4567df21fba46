// The C boundary of the inertial and magnetic sensor.
#include "simulation/imu_mag_sensor.hpp"

#include "base/memory.hpp"
#include "c_api/simulated_sensor.hpp"
#include "options/lists.hpp"

using hnav::ImuMagSensor;
using hnav::Quaternion;
using hnav::Vector3;

struct hnav_imu_mag_sensor : hnav::SimulatedSensor<ImuMagSensor> {
    using SimulatedSensor::SimulatedSensor;

    hnav::SavedState saved() const { return {hnav::SavedState::letters("HNAVSENS"), 2, fingerprint, sizeof(State)}; }
};

namespace {

static_assert(ImuMagSensor::sensor_count == HNAV_SENSOR_MAG + 1);

// Conditions on several options.
template <class Options>
hnav_status check_time(const hnav::CallersMessage& caller, const char* sensor, const Options& o) {
    if (!(o.jitter_s < 0.5 * o.period_s))
        return caller.fail(HNAV_ERROR_OPTION, "%s.jitter_s = %g must be below half of %s.period_s = %g", sensor, o.jitter_s,
                           sensor, o.period_s);
    return hnav::check_latency(caller, sensor, "latency_s", o.latency_s, o.period_s);
}

hnav_status check_kind(const hnav_imu_mag_sensor* sensor, hnav_sensor kind) {
    if (kind >= HNAV_SENSOR_GYRO && kind <= HNAV_SENSOR_MAG) return HNAV_OK;
    return sensor->fail(HNAV_ERROR_OUT_OF_RANGE, "sensor_kind = %d: it must be gyro, accel or mag (0, 1, 2)", (int)kind);
}

} // namespace

extern "C" {

hnav_status hnav_imu_mag_sensor_create(hnav_imu_mag_sensor** sensor, const hnav_imu_mag_sensor_options* options, double start_s,
                                       char* message, size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    if (const hnav_status status = caller.begin(sensor, "sensor", {{options, "options"}})) return status;
    hnav_status status = caller.check_options(options, hnav::imu_mag_sensor_options);
    if (status == HNAV_OK) status = check_time(caller, "gyro", options->gyro);
    if (status == HNAV_OK) status = check_time(caller, "accel", options->accel);
    if (status == HNAV_OK) status = check_time(caller, "mag", options->mag);
    if (status != HNAV_OK) return status;
    if (!std::isfinite(start_s)) return caller.fail(HNAV_ERROR_NON_FINITE, "start_s = %g is not finite", start_s);
    const std::uint64_t fingerprint =
        hnav::hash(&start_s, sizeof start_s, hnav::fingerprint(hnav::imu_mag_sensor_options, options));
    *sensor = hnav::make_object<hnav_imu_mag_sensor>(fingerprint, *options, start_s);
    return *sensor ? HNAV_OK : caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for the sensor");
}

void hnav_imu_mag_sensor_destroy(hnav_imu_mag_sensor* sensor) { hnav::destroy_object(sensor); }

const char* hnav_imu_mag_sensor_message(const hnav_imu_mag_sensor* sensor) { return sensor ? sensor->message : "sensor is null"; }

hnav_status hnav_imu_mag_sensor_reset(hnav_imu_mag_sensor* sensor) { return hnav::reset_object(sensor); }

hnav_status hnav_imu_mag_sensor_sample(hnav_imu_mag_sensor* sensor, double t_s, const hnav_truth* truth) {
    REQUIRE_STRUCT(sensor, truth, hnav_truth);
    REQUIRE_FINITE(sensor, t_s);
    const hnav_truth given = hnav::take_in(*truth);
    const hnav_status status = hnav::check_truth(*sensor, given.q_nb,
                                                 {{"truth.q_nb", given.q_nb, 4},
                                                  {"truth.rate_b_rad_s", given.rate_b_rad_s, 3},
                                                  {"truth.force_b_m_s2", given.force_b_m_s2, 3},
                                                  {"truth.field_b_tesla", given.field_b_tesla, 3}});
    if (status != HNAV_OK) return status;
    sensor->device.sample(t_s, {Quaternion(given.q_nb).normalized(), Vector3(given.rate_b_rad_s), Vector3(given.force_b_m_s2),
                                Vector3(given.field_b_tesla)});
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_advance(hnav_imu_mag_sensor* sensor, double t_s) { return hnav::advance_sensor(sensor, t_s); }

hnav_status hnav_imu_mag_sensor_next_event_s(const hnav_imu_mag_sensor* sensor, double* next_s) {
    return hnav::give_next_event_s(sensor, next_s);
}

hnav_status hnav_imu_mag_sensor_reading(const hnav_imu_mag_sensor* sensor, hnav_sensor sensor_kind, hnav_reading* reading) {
    REQUIRE_STRUCT(sensor, reading, hnav_reading);
    if (const hnav_status status = check_kind(sensor, sensor_kind)) return status;
    hnav_reading result{};
    hnav::fill_reading(sensor->device.state().of[sensor_kind], &result);
    return hnav::hand_out(result, reading);
}

hnav_status hnav_imu_mag_sensor_noise_psd(const hnav_imu_mag_sensor* sensor, hnav_sensor sensor_kind, double* psd) {
    REQUIRE(sensor, psd);
    if (const hnav_status status = check_kind(sensor, sensor_kind)) return status;
    *psd = sensor->device.model(sensor_kind).noise.white_psd();
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_state_size(const hnav_imu_mag_sensor* sensor, size_t* bytes) {
    return hnav::give_state_size(sensor, bytes);
}

hnav_status hnav_imu_mag_sensor_save(const hnav_imu_mag_sensor* sensor, void* buffer, size_t bytes) {
    return hnav::save_object(sensor, buffer, bytes);
}

hnav_status hnav_imu_mag_sensor_load(hnav_imu_mag_sensor* sensor, const void* buffer, size_t bytes) {
    return hnav::load_object(sensor, buffer, bytes, "sensor");
}

} // extern "C"
