// The C boundary of the inertial and magnetic sensor.
#include "simulation/imu_mag_sensor.hpp"

#include "base/memory.hpp"
#include "c_api/sized.hpp"
#include "options/lists.hpp"

#include <cmath>

using hnav::ImuMagSensor;
using hnav::Quaternion;
using hnav::SensorModel;
using hnav::Vector3;

struct hnav_imu_mag_sensor : hnav::KeptMessage<160> {
    hnav_imu_mag_sensor(const hnav_imu_mag_sensor_options& options, double start_s, std::uint64_t fingerprint)
        : device(options, start_s), fingerprint(fingerprint) {}

    ImuMagSensor device;
    std::uint64_t fingerprint; // of options and start
};

namespace {

static_assert(ImuMagSensor::sensor_count == HNAV_SENSOR_MAG + 1);

// Conditions on several options.
template <class Options>
hnav_status check_time(const hnav::CallersMessage& caller, const char* sensor, const Options& o) {
    if (!(o.jitter_s < 0.5 * o.period_s))
        return caller.fail(HNAV_ERROR_OPTION, "%s.jitter_s = %g must be below half of %s.period_s = %g", sensor, o.jitter_s,
                           sensor, o.period_s);
    if (!(o.latency_s <= hnav::max_latency_periods * o.period_s))
        return caller.fail(HNAV_ERROR_OPTION, "%s.latency_s = %g is more than %g times %s.period_s = %g", sensor, o.latency_s,
                           hnav::max_latency_periods, sensor, o.period_s);
    return HNAV_OK;
}

hnav_status check_truth(const hnav_imu_mag_sensor* sensor, const hnav_truth& truth) {
    const struct {
        const char* name;
        const double* value;
        int count;
    } parts[] = {{"q_nb", truth.q_nb, 4},
                 {"rate_b_rad_s", truth.rate_b_rad_s, 3},
                 {"force_b_m_s2", truth.force_b_m_s2, 3},
                 {"field_b_tesla", truth.field_b_tesla, 3}};
    for (const auto& part : parts)
        for (int i = 0; i < part.count; ++i) {
            if (!std::isfinite(part.value[i]))
                return sensor->fail(HNAV_ERROR_NON_FINITE, "truth.%s[%d] = %g is not finite", part.name, i, part.value[i]);
            if (std::fabs(part.value[i]) > hnav::largest_truth)
                return sensor->fail(HNAV_ERROR_OUT_OF_RANGE, "truth.%s[%d] = %g lies beyond %g", part.name, i, part.value[i],
                                    hnav::largest_truth);
        }
    const double length = Quaternion(truth.q_nb).norm();
    if (!(length > 0.5)) return sensor->fail(HNAV_ERROR_ZERO_VECTOR, "truth.q_nb has length %g, which is no attitude", length);
    return HNAV_OK;
}

hnav_status check_kind(const hnav_imu_mag_sensor* sensor, hnav_sensor kind) {
    if (kind >= HNAV_SENSOR_GYRO && kind <= HNAV_SENSOR_MAG) return HNAV_OK;
    return sensor->fail(HNAV_ERROR_OUT_OF_RANGE, "sensor_kind = %d: it must be gyro, accel or mag (0, 1, 2)", (int)kind);
}

hnav::SavedState saved_state(const hnav_imu_mag_sensor* sensor) {
    return {hnav::SavedState::letters("HNAVSENS"), 2, sensor->fingerprint, sizeof(ImuMagSensor::State)};
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
    *sensor = hnav::make_object<hnav_imu_mag_sensor>(*options, start_s, fingerprint);
    return *sensor ? HNAV_OK : caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for the sensor");
}

void hnav_imu_mag_sensor_destroy(hnav_imu_mag_sensor* sensor) { hnav::destroy_object(sensor); }

const char* hnav_imu_mag_sensor_message(const hnav_imu_mag_sensor* sensor) { return sensor ? sensor->message : "sensor is null"; }

hnav_status hnav_imu_mag_sensor_reset(hnav_imu_mag_sensor* sensor) {
    if (!sensor) return HNAV_ERROR_NULL_ARGUMENT;
    sensor->device.reset();
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_sample(hnav_imu_mag_sensor* sensor, double t_s, const hnav_truth* truth) {
    REQUIRE_STRUCT(sensor, truth, hnav_truth);
    REQUIRE_FINITE(sensor, t_s);
    const hnav_truth given = hnav::take_in(*truth);
    if (const hnav_status status = check_truth(sensor, given)) return status;
    sensor->device.sample(t_s, {Quaternion(given.q_nb).normalized(), Vector3(given.rate_b_rad_s), Vector3(given.force_b_m_s2),
                                Vector3(given.field_b_tesla)});
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_advance(hnav_imu_mag_sensor* sensor, double t_s) {
    if (!sensor) return HNAV_ERROR_NULL_ARGUMENT;
    REQUIRE_FINITE(sensor, t_s);
    sensor->device.advance(t_s);
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_next_event_s(const hnav_imu_mag_sensor* sensor, double* next_s) {
    REQUIRE(sensor, next_s);
    *next_s = sensor->device.next_event_s();
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_reading(const hnav_imu_mag_sensor* sensor, hnav_sensor sensor_kind, hnav_reading* reading) {
    REQUIRE_STRUCT(sensor, reading, hnav_reading);
    if (const hnav_status status = check_kind(sensor, sensor_kind)) return status;
    const SensorModel::State& state = sensor->device.state().of[sensor_kind];
    hnav_reading result{};
    for (int i = 0; i < 3; ++i) result.value[i] = state.delivery.newest.value[i];
    result.t_meas_s = state.delivery.newest.t_meas_s;
    result.count = static_cast<std::uint64_t>(state.delivery.count);
    result.missed = static_cast<std::uint64_t>(state.missed);
    result.dropped = static_cast<std::uint64_t>(state.dropped);
    hnav::hand_out(result, reading);
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_noise_psd(const hnav_imu_mag_sensor* sensor, hnav_sensor sensor_kind, double* psd) {
    REQUIRE(sensor, psd);
    if (const hnav_status status = check_kind(sensor, sensor_kind)) return status;
    *psd = sensor->device.model(sensor_kind).noise.white_psd();
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_state_size(const hnav_imu_mag_sensor* sensor, size_t* bytes) {
    REQUIRE(sensor, bytes);
    *bytes = saved_state(sensor).bytes();
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_save(const hnav_imu_mag_sensor* sensor, void* buffer, size_t bytes) {
    REQUIRE(sensor, buffer);
    return hnav::save_numbers(*sensor, saved_state(sensor), &sensor->device.state(), buffer, bytes);
}

hnav_status hnav_imu_mag_sensor_load(hnav_imu_mag_sensor* sensor, const void* buffer, size_t bytes) {
    REQUIRE(sensor, buffer);
    return hnav::load_numbers<ImuMagSensor::State>(
        *sensor, saved_state(sensor), buffer, bytes, "sensor",
        [&](const ImuMagSensor::State& state) { return sensor->device.assign(state); });
}

} // extern "C"
