// The C boundary of the inertial and magnetic sensor: datasheet units become SI, spreads become numbers.
#include "simulation/imu_mag_sensor.hpp"

#include "c_api/message.hpp"
#include "hnav/simulation.h"
#include "options/lists.hpp"
#include "simulation/streams.hpp"

#include <cstdlib>
#include <new>

using hnav::Constants;
using hnav::Quaternion;
using hnav::SensorModel;
using hnav::Vector3;

struct hnav_imu_mag_sensor {
    SensorModel models[3]; // gyro, accel, mag
    SensorModel::State states[3];
    std::uint64_t stamp; // of saved states: options and start
};

namespace {

namespace streams = hnav::streams;

constexpr double standard_gravity_m_s2 = 9.80665;
constexpr double deg = M_PI / 180;
constexpr double ug_m_s2 = 1e-6 * standard_gravity_m_s2;
constexpr double root_hour_s = 60; // sqrt(3600 s)
constexpr std::uint64_t state_magic = 0x31534d4956414e48ull; // "HNAVIMS1"

struct SavedHeader {
    std::uint64_t magic, stamp;
};

// Places of Constants.
enum Place : std::uint64_t { bias_place, drift_place, scale_place, misalignment_place, hard_iron_place, soft_iron_place };

// The parts that are named alike in all three sensors.
template <class Options>
SensorModel model_of(const Options& o, int sensor, std::uint64_t seed, double start_s, const hnav::NoiseDensities& densities) {
    SensorModel m;
    const auto stream = [&](streams::Source source) { return hnav::RandomStream(seed, streams::of(sensor, source)); };
    m.clock = {start_s, o.period_s, o.jitter_s, stream(streams::jitter)};
    m.latency_s = o.latency_s;
    m.dropout = o.dropout;
    m.dropout_chance = stream(streams::dropout);
    m.noise = hnav::Noise(densities, o.period_s, seed, streams::of(sensor, streams::white), streams::of(sensor, streams::flicker),
                          streams::of(sensor, streams::walk));
    const Constants constants(seed, streams::of(sensor, streams::constants));
    const Vector3 scale = Vector3(o.scale_factor) + constants.vector(scale_place, o.scale_factor_sigma);
    const hnav::Matrix3 chance = constants.matrix(misalignment_place, o.misalignment_sigma_rad);
    double misalignment[6];
    for (int i = 0, k = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (i != j) {
                misalignment[k] = o.misalignment_rad[k] + chance(i, j);
                ++k;
            }
    m.error.matrix = hnav::scale_and_misalignment(scale, misalignment);
    return m;
}

void set_bias(SensorModel* m, const Constants& constants, const double* bias, double bias_sigma, const double* drift,
              double drift_sigma) {
    m->error.after = Vector3(bias) + constants.vector(bias_place, bias_sigma);
    m->error.drift = Vector3(drift) + constants.vector(drift_place, drift_sigma);
}

// What faults need of one sensor: size of its outliers, its jump, the factor on its noise.
void set_faults(SensorModel* m, const hnav_sensor_faults& f, int sensor, std::uint64_t seed, double outlier_sigma,
                const double* jump, double noise_factor) {
    m->faults.outliers = {f.outliers.start_s, f.outliers.stop_s};
    m->faults.outlier_probability = f.outliers.probability;
    m->faults.outlier_sigma = outlier_sigma;
    m->faults.outlier_chance = hnav::RandomStream(seed, streams::of(sensor, streams::outlier_chance));
    m->faults.outlier_size = hnav::RandomStream(seed, streams::of(sensor, streams::outlier_size));
    m->faults.stuck = {f.stuck.start_s, f.stuck.stop_s};
    m->faults.stuck_axis = f.stuck.sensor == sensor + 1 ? f.stuck.axis - 1 : -1;
    m->faults.jump = {f.bias_jump.start_s, f.bias_jump.stop_s};
    m->faults.jump_size = Vector3(jump);
    m->faults.noise = {f.noise_increase.start_s, f.noise_increase.stop_s};
    m->faults.noise_factor = noise_factor;
}

void fill_models(const hnav_imu_mag_sensor_options& o, double start_s, SensorModel* models) {
    const auto seed = static_cast<std::uint64_t>(o.seed);
    const hnav_sensor_faults& f = o.fault;

    const Constants gyro_constants(seed, streams::of(HNAV_SENSOR_GYRO, streams::constants));
    SensorModel& gyro = models[HNAV_SENSOR_GYRO];
    // deg/sqrt(h) = deg/h/sqrt(Hz)/60; deg/h/sqrt(h) over 3600 s and 60 sqrt(s).
    gyro = model_of(o.gyro, HNAV_SENSOR_GYRO, seed, start_s,
                    {o.gyro.noise_deg_per_sqrt_h * deg / root_hour_s, o.gyro.bias_instability_rad_s,
                     o.gyro.random_walk_deg_per_h_per_sqrt_h * deg / 3600 / root_hour_s});
    set_bias(&gyro, gyro_constants, o.gyro.bias_rad_s, o.gyro.bias_sigma_rad_s, o.gyro.drift_rad_s2, o.gyro.drift_sigma_rad_s2);
    gyro.g_sensitivity = o.gyro.g_sensitivity_deg_per_h_per_g * deg / 3600 / standard_gravity_m_s2;
    gyro.quantiser = {o.gyro.range_rad_s, o.gyro.resolution_rad_s};
    set_faults(&gyro, f, HNAV_SENSOR_GYRO, seed, f.outliers.gyro_sigma_rad_s, f.bias_jump.gyro_rad_s,
               f.noise_increase.gyro_factor);

    const Constants accel_constants(seed, streams::of(HNAV_SENSOR_ACCEL, streams::constants));
    SensorModel& accel = models[HNAV_SENSOR_ACCEL];
    accel = model_of(o.accel, HNAV_SENSOR_ACCEL, seed, start_s,
                     {o.accel.noise_ug_per_sqrt_hz * ug_m_s2, o.accel.bias_instability_m_s2,
                      o.accel.random_walk_ug_per_sqrt_h * ug_m_s2 / root_hour_s});
    set_bias(&accel, accel_constants, o.accel.bias_m_s2, o.accel.bias_sigma_m_s2, o.accel.drift_m_s3, o.accel.drift_sigma_m_s3);
    accel.quantiser = {o.accel.range_m_s2, o.accel.resolution_m_s2};
    set_faults(&accel, f, HNAV_SENSOR_ACCEL, seed, f.outliers.accel_sigma_m_s2, f.bias_jump.accel_m_s2,
               f.noise_increase.accel_factor);

    const Constants mag_constants(seed, streams::of(HNAV_SENSOR_MAG, streams::constants));
    SensorModel& mag = models[HNAV_SENSOR_MAG];
    mag = model_of(
        o.mag, HNAV_SENSOR_MAG, seed, start_s,
        {o.mag.noise_nt_per_sqrt_hz * 1e-9, o.mag.bias_instability_tesla, o.mag.random_walk_nt_per_sqrt_h * 1e-9 / root_hour_s});
    set_bias(&mag, mag_constants, o.mag.bias_tesla, o.mag.bias_sigma_tesla, o.mag.drift_tesla_s, o.mag.drift_sigma_tesla_s);
    // Iron changes the field before the chip reads it: matrix ((I + soft) field + hard).
    const hnav::Matrix3 soft = hnav::Matrix3::Identity() +
                               hnav::Matrix3(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(o.mag.soft_iron)) +
                               mag_constants.matrix(soft_iron_place, o.mag.soft_iron_sigma);
    const Vector3 hard = Vector3(o.mag.hard_iron_tesla) + mag_constants.vector(hard_iron_place, o.mag.hard_iron_sigma_tesla);
    mag.error.after += mag.error.matrix * hard;
    mag.error.matrix = mag.error.matrix * soft;
    mag.quantiser = {o.mag.range_tesla, o.mag.resolution_tesla};
    set_faults(&mag, f, HNAV_SENSOR_MAG, seed, f.outliers.mag_sigma_tesla, f.bias_jump.mag_tesla, f.noise_increase.mag_factor);
    mag.faults.disturbance = {f.mag_disturbance.start_s, f.mag_disturbance.stop_s};
    const Vector3 direction = Constants(seed, streams::of(HNAV_SENSOR_MAG, streams::disturbance)).vector(0, 1);
    mag.faults.disturbance_n =
        Vector3(f.mag_disturbance.field_n_tesla) + f.mag_disturbance.strength_tesla * direction.normalized();
}

// What no single row can refuse.
template <class Options>
hnav_status check_time(const hnav::CallersMessage& caller, const char* sensor, const Options& o) {
    if (!(o.jitter_s < 0.5 * o.period_s))
        return caller.fail(HNAV_ERROR_OPTION, "%s.jitter_s = %g must be below half of %s.period_s = %g", sensor, o.jitter_s,
                           sensor, o.period_s);
    if (!(o.latency_s <= hnav::longest_latency_periods * o.period_s))
        return caller.fail(HNAV_ERROR_OPTION, "%s.latency_s = %g is more than %g times %s.period_s = %g", sensor, o.latency_s,
                           hnav::longest_latency_periods, sensor, o.period_s);
    return HNAV_OK;
}

bool finite(const double* v, int n) {
    for (int i = 0; i < n; ++i)
        if (!std::isfinite(v[i])) return false;
    return true;
}

} // namespace

extern "C" {

hnav_status hnav_imu_mag_sensor_create(hnav_imu_mag_sensor** sensor, const hnav_imu_mag_sensor_options* options, double start_s,
                                       char* message, size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    caller.clear();
    if (!sensor) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "sensor is null");
    *sensor = nullptr;
    if (!options) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "options is null");
    hnav_status status = caller.check_options(options, hnav::imu_mag_sensor_options);
    if (status == HNAV_OK) status = check_time(caller, "gyro", options->gyro);
    if (status == HNAV_OK) status = check_time(caller, "accel", options->accel);
    if (status == HNAV_OK) status = check_time(caller, "mag", options->mag);
    if (status != HNAV_OK) return status;
    if (!std::isfinite(start_s)) return caller.fail(HNAV_ERROR_NON_FINITE, "start_s = %g is not finite", start_s);
    void* memory = std::malloc(sizeof(hnav_imu_mag_sensor));
    if (!memory) return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for the sensor");
    auto* self = new (memory) hnav_imu_mag_sensor;
    fill_models(*options, start_s, self->models);
    std::uint64_t start_word;
    std::memcpy(&start_word, &start_s, sizeof start_word);
    self->stamp = hnav::fingerprint(hnav::imu_mag_sensor_options, options) ^ (start_word * 1099511628211ull);
    hnav_imu_mag_sensor_reset(self);
    *sensor = self;
    return HNAV_OK;
}

void hnav_imu_mag_sensor_destroy(hnav_imu_mag_sensor* sensor) { std::free(sensor); }

hnav_status hnav_imu_mag_sensor_reset(hnav_imu_mag_sensor* sensor) {
    if (!sensor) return HNAV_ERROR_NULL_ARGUMENT;
    for (SensorModel::State& state : sensor->states) state = {};
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_sample(hnav_imu_mag_sensor* sensor, double t_s, const hnav_truth* truth) {
    if (!sensor || !truth) return HNAV_ERROR_NULL_ARGUMENT;
    if (!std::isfinite(t_s) || !finite(truth->q_nb, 4) || !finite(truth->rate_b_rad_s, 3) || !finite(truth->force_b_m_s2, 3) ||
        !finite(truth->field_b_tesla, 3))
        return HNAV_ERROR_NON_FINITE;
    const Quaternion q(truth->q_nb);
    if (!(q.norm() > 0.5)) return HNAV_ERROR_ZERO_VECTOR;
    const Quaternion unit = q.normalized();
    const Vector3 force(truth->force_b_m_s2);
    const double* inputs[] = {truth->rate_b_rad_s, truth->force_b_m_s2, truth->field_b_tesla};
    for (int s = 0; s < 3; ++s) {
        // Nothing waits beyond its latency, so the queue has room for one more.
        hnav::Delivery::advance(&sensor->states[s].delivery, t_s);
        sensor->models[s].sample(t_s, Vector3(inputs[s]), force, unit, &sensor->states[s]);
    }
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_advance(hnav_imu_mag_sensor* sensor, double t_s) {
    if (!sensor) return HNAV_ERROR_NULL_ARGUMENT;
    if (!std::isfinite(t_s)) return HNAV_ERROR_NON_FINITE;
    for (SensorModel::State& state : sensor->states) hnav::Delivery::advance(&state.delivery, t_s);
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_next_event_s(const hnav_imu_mag_sensor* sensor, double* next_s) {
    if (!sensor || !next_s) return HNAV_ERROR_NULL_ARGUMENT;
    *next_s = std::numeric_limits<double>::infinity();
    for (int s = 0; s < 3; ++s) {
        const SensorModel::State& state = sensor->states[s];
        *next_s =
            std::fmin(*next_s, std::fmin(sensor->models[s].clock.due_s(state.next), hnav::Delivery::next_s(state.delivery)));
    }
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_reading(const hnav_imu_mag_sensor* sensor, hnav_sensor sensor_kind, hnav_reading* reading) {
    if (!sensor || !reading) return HNAV_ERROR_NULL_ARGUMENT;
    if (sensor_kind < HNAV_SENSOR_GYRO || sensor_kind > HNAV_SENSOR_MAG) return HNAV_ERROR_OUT_OF_RANGE;
    const SensorModel::State& state = sensor->states[sensor_kind];
    for (int i = 0; i < 3; ++i) reading->value[i] = state.delivery.newest.value[i];
    reading->t_meas_s = state.delivery.newest.t_meas_s;
    reading->count = static_cast<std::uint64_t>(state.delivery.count);
    reading->missed = static_cast<std::uint64_t>(state.missed);
    reading->dropped = static_cast<std::uint64_t>(state.dropped);
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_noise_psd(const hnav_imu_mag_sensor* sensor, hnav_sensor sensor_kind, double* psd) {
    if (!sensor || !psd) return HNAV_ERROR_NULL_ARGUMENT;
    if (sensor_kind < HNAV_SENSOR_GYRO || sensor_kind > HNAV_SENSOR_MAG) return HNAV_ERROR_OUT_OF_RANGE;
    *psd = sensor->models[sensor_kind].noise.white_psd();
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_state_size(const hnav_imu_mag_sensor* sensor, size_t* bytes) {
    if (!sensor || !bytes) return HNAV_ERROR_NULL_ARGUMENT;
    *bytes = sizeof(SavedHeader) + sizeof sensor->states;
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_save(const hnav_imu_mag_sensor* sensor, void* buffer, size_t bytes) {
    if (!sensor || !buffer) return HNAV_ERROR_NULL_ARGUMENT;
    if (bytes < sizeof(SavedHeader) + sizeof sensor->states) return HNAV_ERROR_SIZE;
    const SavedHeader header{state_magic, sensor->stamp};
    std::memcpy(buffer, &header, sizeof header);
    std::memcpy(static_cast<char*>(buffer) + sizeof header, sensor->states, sizeof sensor->states);
    return HNAV_OK;
}

hnav_status hnav_imu_mag_sensor_load(hnav_imu_mag_sensor* sensor, const void* buffer, size_t bytes) {
    if (!sensor || !buffer) return HNAV_ERROR_NULL_ARGUMENT;
    if (bytes != sizeof(SavedHeader) + sizeof sensor->states) return HNAV_ERROR_SIZE;
    SavedHeader header;
    std::memcpy(&header, buffer, sizeof header);
    if (header.magic != state_magic || header.stamp != sensor->stamp) return HNAV_ERROR_STATE_CORRUPT;
    SensorModel::State states[3];
    std::memcpy(states, static_cast<const char*>(buffer) + sizeof header, sizeof states);
    for (const SensorModel::State& state : states)
        if (!(state.delivery.waiting >= 0 && state.delivery.waiting < hnav::most_in_flight) || !(state.next >= 0))
            return HNAV_ERROR_STATE_CORRUPT;
    std::memcpy(sensor->states, states, sizeof states);
    return HNAV_OK;
}

} // extern "C"
