// The C boundary of the sensors that aid an inertial one.
#include "simulation/aid_sensor.hpp"

#include "base/memory.hpp"
#include "c_api/simulated_sensor.hpp"
#include "options/lists.hpp"

using hnav::AidSensor;
using hnav::Quaternion;
using hnav::Vector3;

struct hnav_aid_sensor : hnav::SimulatedSensor<AidSensor> {
    using SimulatedSensor::SimulatedSensor;

    hnav::SavedState saved() const { return {hnav::SavedState::letters("HNAVAIDS"), 1, fingerprint, sizeof(State)}; }
};

extern "C" {

hnav_status hnav_aid_sensor_create(hnav_aid_sensor** sensor, hnav_aid_sensor_kind kind, const hnav_aid_sensor_options* options,
                                   double start_s, char* message, size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    if (const hnav_status status = caller.begin(sensor, "sensor", {{options, "options"}})) return status;
    if (kind < HNAV_AID_GNSS || kind > HNAV_AID_WHEEL)
        return caller.fail(HNAV_ERROR_OUT_OF_RANGE, "kind = %d: it must be gnss, baro or wheel (0, 1, 2)",
                           static_cast<int>(kind));
    hnav_status status = caller.check_options(options, hnav::aid_sensor_options);
    const auto check = [&](const char* of, const char* what, double latency_s, double period_s) {
        if (status == HNAV_OK) status = hnav::check_latency(caller, of, what, latency_s, period_s);
    };
    const hnav_gnss_options& gnss = options->gnss;
    check("gnss", "latency_s + gnss.stamp_error_s", gnss.latency_s + gnss.stamp_error_s, gnss.period_s);
    check("baro", "latency_s", options->baro.latency_s, options->baro.period_s);
    check("wheel", "latency_s", options->wheel.latency_s, options->wheel.period_s);
    if (status != HNAV_OK) return status;
    if (!std::isfinite(start_s)) return caller.fail(HNAV_ERROR_NON_FINITE, "start_s = %g is not finite", start_s);
    const double identity[] = {static_cast<double>(kind), start_s};
    const std::uint64_t fingerprint = hnav::hash(identity, sizeof identity, hnav::fingerprint(hnav::aid_sensor_options, options));
    *sensor = hnav::make_object<hnav_aid_sensor>(fingerprint, kind, *options, start_s);
    return *sensor ? HNAV_OK : caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for the sensor");
}

void hnav_aid_sensor_destroy(hnav_aid_sensor* sensor) { hnav::destroy_object(sensor); }

const char* hnav_aid_sensor_message(const hnav_aid_sensor* sensor) { return sensor ? sensor->message : "sensor is null"; }

hnav_status hnav_aid_sensor_reset(hnav_aid_sensor* sensor) { return hnav::reset_object(sensor); }

hnav_status hnav_aid_sensor_sample(hnav_aid_sensor* sensor, double t_s, const hnav_vehicle_truth* truth) {
    REQUIRE_STRUCT(sensor, truth, hnav_vehicle_truth);
    REQUIRE_FINITE(sensor, t_s);
    const hnav_vehicle_truth given = hnav::take_in(*truth);
    const hnav_status status = hnav::check_truth(*sensor, given.q_nb,
                                                 {{"truth.latitude_rad", &given.latitude_rad, 1},
                                                  {"truth.longitude_rad", &given.longitude_rad, 1},
                                                  {"truth.height_m", &given.height_m, 1},
                                                  {"truth.velocity_n_m_s", given.velocity_n_m_s, 3},
                                                  {"truth.q_nb", given.q_nb, 4},
                                                  {"truth.rate_b_rad_s", given.rate_b_rad_s, 3}});
    if (status != HNAV_OK) return status;
    hnav::Vehicle::Seen seen{};
    seen.place = {given.latitude_rad, given.longitude_rad, given.height_m};
    seen.velocity_n = Vector3(given.velocity_n_m_s);
    seen.rate_b = Vector3(given.rate_b_rad_s);
    seen.q_nb = Quaternion(given.q_nb).normalized();
    sensor->device.sample(t_s, seen);
    return HNAV_OK;
}

hnav_status hnav_aid_sensor_advance(hnav_aid_sensor* sensor, double t_s) { return hnav::advance_sensor(sensor, t_s); }

hnav_status hnav_aid_sensor_next_event_s(const hnav_aid_sensor* sensor, double* next_s) {
    return hnav::give_next_event_s(sensor, next_s);
}

hnav_status hnav_aid_sensor_reading(const hnav_aid_sensor* sensor, hnav_aid_reading* reading) {
    REQUIRE_STRUCT(sensor, reading, hnav_aid_reading);
    hnav_aid_reading result{};
    hnav::fill_reading(sensor->device.state(), &result);
    sensor->device.sigma(result.sigma);
    result.valid = sensor->device.is_valid();
    return hnav::hand_out(result, reading);
}

hnav_status hnav_aid_sensor_state_size(const hnav_aid_sensor* sensor, size_t* bytes) {
    return hnav::give_state_size(sensor, bytes);
}

hnav_status hnav_aid_sensor_save(const hnav_aid_sensor* sensor, void* buffer, size_t bytes) {
    return hnav::save_object(sensor, buffer, bytes);
}

hnav_status hnav_aid_sensor_load(hnav_aid_sensor* sensor, const void* buffer, size_t bytes) {
    return hnav::load_object(sensor, buffer, bytes, "sensor");
}

} // extern "C"
