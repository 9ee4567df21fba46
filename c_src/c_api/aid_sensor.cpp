// The C boundary of the sensors that aid an inertial one.
#include "simulation/aid_sensor.hpp"

#include "base/memory.hpp"
#include "c_api/sized.hpp"
#include "options/lists.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

using hnav::AidSensor;
using hnav::Quaternion;
using hnav::Vector3;

struct hnav_aid_sensor : hnav::KeptMessage<160> {
    hnav_aid_sensor(hnav_aid_sensor_kind kind, const hnav_aid_sensor_options& options, double start_s, std::uint64_t fingerprint)
        : device(kind, options, start_s), fingerprint(fingerprint) {}

    AidSensor device;
    std::uint64_t fingerprint; // of kind, options and start
};

namespace {

// Conditions on several options.
hnav_status check_latency(const hnav::CallersMessage& caller, const char* what, double latency_s, double period_s) {
    if (latency_s <= hnav::max_latency_periods * period_s) return HNAV_OK;
    return caller.fail(HNAV_ERROR_OPTION, "%s = %g is more than %g times %.*s.period_s = %g", what, latency_s,
                       hnav::max_latency_periods, static_cast<int>(std::strcspn(what, ".")), what, period_s);
}

hnav_status check_truth(const hnav_aid_sensor* sensor, const hnav_vehicle_truth& truth) {
    const auto check = [&](const char* name, const double* value, int count) {
        for (int i = 0; i < count; ++i) {
            if (!std::isfinite(value[i]))
                return sensor->fail(HNAV_ERROR_NON_FINITE, "truth.%s = %g is not finite", name, value[i]);
            if (std::fabs(value[i]) > hnav::largest_truth)
                return sensor->fail(HNAV_ERROR_OUT_OF_RANGE, "truth.%s = %g lies beyond %g", name, value[i], hnav::largest_truth);
        }
        return HNAV_OK;
    };
    for (const hnav_status status :
         {check("latitude_rad", &truth.latitude_rad, 1), check("longitude_rad", &truth.longitude_rad, 1),
          check("height_m", &truth.height_m, 1), check("velocity_n_m_s", truth.velocity_n_m_s, 3), check("q_nb", truth.q_nb, 4),
          check("rate_b_rad_s", truth.rate_b_rad_s, 3)})
        if (status != HNAV_OK) return status;
    const double length = Quaternion(truth.q_nb).norm();
    if (length > 0.5) return HNAV_OK;
    return sensor->fail(HNAV_ERROR_ZERO_VECTOR, "truth.q_nb has length %g, which is no attitude", length);
}

hnav::SavedState saved_state(const hnav_aid_sensor* sensor) {
    return {hnav::SavedState::letters("HNAVAIDS"), 1, sensor->fingerprint, sizeof(AidSensor::State)};
}

} // namespace

extern "C" {

hnav_status hnav_aid_sensor_create(hnav_aid_sensor** sensor, hnav_aid_sensor_kind kind, const hnav_aid_sensor_options* options,
                                   double start_s, char* message, size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    if (const hnav_status status = caller.begin(sensor, "sensor", {{options, "options"}})) return status;
    if (kind < HNAV_AID_GNSS || kind > HNAV_AID_WHEEL)
        return caller.fail(HNAV_ERROR_OUT_OF_RANGE, "kind = %d: it must be gnss, baro or wheel (0, 1, 2)",
                           static_cast<int>(kind));
    hnav_status status = caller.check_options(options, hnav::aid_sensor_options);
    const hnav_gnss_options& gnss = options->gnss;
    if (status == HNAV_OK)
        status = check_latency(caller, "gnss.latency_s + gnss.stamp_error_s", gnss.latency_s + gnss.stamp_error_s, gnss.period_s);
    if (status == HNAV_OK) status = check_latency(caller, "baro.latency_s", options->baro.latency_s, options->baro.period_s);
    if (status == HNAV_OK) status = check_latency(caller, "wheel.latency_s", options->wheel.latency_s, options->wheel.period_s);
    if (status != HNAV_OK) return status;
    if (!std::isfinite(start_s)) return caller.fail(HNAV_ERROR_NON_FINITE, "start_s = %g is not finite", start_s);
    const double identity[] = {static_cast<double>(kind), start_s};
    const std::uint64_t fingerprint = hnav::hash(identity, sizeof identity, hnav::fingerprint(hnav::aid_sensor_options, options));
    *sensor = hnav::make_object<hnav_aid_sensor>(kind, *options, start_s, fingerprint);
    return *sensor ? HNAV_OK : caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for the sensor");
}

void hnav_aid_sensor_destroy(hnav_aid_sensor* sensor) { hnav::destroy_object(sensor); }

const char* hnav_aid_sensor_message(const hnav_aid_sensor* sensor) { return sensor ? sensor->message : "sensor is null"; }

hnav_status hnav_aid_sensor_reset(hnav_aid_sensor* sensor) {
    if (!sensor) return HNAV_ERROR_NULL_ARGUMENT;
    sensor->device.reset();
    return HNAV_OK;
}

hnav_status hnav_aid_sensor_sample(hnav_aid_sensor* sensor, double t_s, const hnav_vehicle_truth* truth) {
    REQUIRE_STRUCT(sensor, truth, hnav_vehicle_truth);
    REQUIRE_FINITE(sensor, t_s);
    const hnav_vehicle_truth given = hnav::take_in(*truth);
    if (const hnav_status status = check_truth(sensor, given)) return status;
    hnav::Vehicle::Seen seen{};
    seen.place = {given.latitude_rad, given.longitude_rad, given.height_m};
    seen.velocity_n = Vector3(given.velocity_n_m_s);
    seen.rate_b = Vector3(given.rate_b_rad_s);
    seen.q_nb = Quaternion(given.q_nb).normalized();
    sensor->device.sample(t_s, seen);
    return HNAV_OK;
}

hnav_status hnav_aid_sensor_advance(hnav_aid_sensor* sensor, double t_s) {
    if (!sensor) return HNAV_ERROR_NULL_ARGUMENT;
    REQUIRE_FINITE(sensor, t_s);
    sensor->device.advance(t_s);
    return HNAV_OK;
}

hnav_status hnav_aid_sensor_next_event_s(const hnav_aid_sensor* sensor, double* next_s) {
    REQUIRE(sensor, next_s);
    *next_s = sensor->device.next_event_s();
    return HNAV_OK;
}

hnav_status hnav_aid_sensor_reading(const hnav_aid_sensor* sensor, hnav_aid_reading* reading) {
    REQUIRE_STRUCT(sensor, reading, hnav_aid_reading);
    const AidSensor::State& state = sensor->device.state();
    hnav_aid_reading result{};
    std::copy_n(state.delivery.newest.value, AidSensor::values, result.value);
    sensor->device.sigma(result.sigma);
    result.t_meas_s = state.delivery.newest.t_meas_s;
    result.count = static_cast<std::uint64_t>(state.delivery.count);
    result.missed = static_cast<std::uint64_t>(state.missed);
    result.dropped = static_cast<std::uint64_t>(state.dropped);
    result.valid = sensor->device.is_valid();
    hnav::hand_out(result, reading);
    return HNAV_OK;
}

hnav_status hnav_aid_sensor_state_size(const hnav_aid_sensor* sensor, size_t* bytes) {
    REQUIRE(sensor, bytes);
    *bytes = saved_state(sensor).bytes();
    return HNAV_OK;
}

hnav_status hnav_aid_sensor_save(const hnav_aid_sensor* sensor, void* buffer, size_t bytes) {
    REQUIRE(sensor, buffer);
    return hnav::save_numbers(*sensor, saved_state(sensor), &sensor->device.state(), buffer, bytes);
}

hnav_status hnav_aid_sensor_load(hnav_aid_sensor* sensor, const void* buffer, size_t bytes) {
    REQUIRE(sensor, buffer);
    return hnav::load_numbers<AidSensor::State>(*sensor, saved_state(sensor), buffer, bytes, "sensor",
                                                [&](const AidSensor::State& state) { return sensor->device.assign(state); });
}

} // extern "C"
