#include "simulation/imu_mag_sensor.hpp"

#include "maths/earth.hpp"
#include "simulation/streams.hpp"

namespace hnav {
namespace {

using earth::standard_gravity_m_s2;
constexpr double deg = M_PI / 180;
constexpr double ug_m_s2 = 1e-6 * standard_gravity_m_s2;
constexpr double root_hour_s = 60; // sqrt(3600 s)

// Places of Constants.
enum Place : std::uint64_t { bias_place, drift_place, scale_place, misalignment_place, hard_iron_place, soft_iron_place };

// Settings of one sensor beside its own options.
struct Device {
    std::uint64_t seed;
    double start_s;
    const hnav_sensor_faults& faults;

    Constants constants(int sensor) const { return {seed, streams::of(sensor, streams::constants)}; }
};

// The parts that are named alike in all three sensors.
template <class Options>
SensorModel model_of(const Options& o, int sensor, const Device& device, const NoiseDensities& densities) {
    SensorModel m;
    const std::uint64_t seed = device.seed;
    const auto stream = [&](streams::Source source) { return RandomStream(seed, streams::of(sensor, source)); };
    m.clock = {device.start_s, o.period_s, o.jitter_s, stream(streams::jitter)};
    m.latency_s = o.latency_s;
    m.dropout = o.dropout;
    m.dropout_chance = stream(streams::dropout);
    m.noise = Noise(densities, o.period_s, seed, streams::of(sensor, streams::white), streams::of(sensor, streams::flicker),
                    streams::of(sensor, streams::walk));
    const Constants constants = device.constants(sensor);
    const Vector3 scale = Vector3(o.scale_factor) + constants.vector(scale_place, o.scale_factor_sigma);
    const Matrix3 chance = constants.matrix(misalignment_place, o.misalignment_sigma_rad);
    double misalignment[6];
    for (int i = 0, k = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (i != j) {
                misalignment[k] = o.misalignment_rad[k] + chance(i, j);
                ++k;
            }
    m.error.matrix = scale_and_misalignment(scale, misalignment);
    return m;
}

void set_bias(SensorModel* m, const Constants& constants, const double* bias, double bias_sigma, const double* drift,
              double drift_sigma) {
    m->error.after = Vector3(bias) + constants.vector(bias_place, bias_sigma);
    m->error.drift = Vector3(drift) + constants.vector(drift_place, drift_sigma);
}

// Fault parameters of one sensor: size of its outliers, its jump, the factor on its noise.
void set_faults(SensorModel* m, const Device& device, int sensor, double outlier_sigma, const double* jump, double noise_factor) {
    const hnav_sensor_faults& f = device.faults;
    m->faults.outliers = {f.outliers.start_s, f.outliers.stop_s};
    m->faults.outlier_probability = f.outliers.probability;
    m->faults.outlier_sigma = outlier_sigma;
    m->faults.outlier_chance = RandomStream(device.seed, streams::of(sensor, streams::outlier_chance));
    m->faults.outlier_size = RandomStream(device.seed, streams::of(sensor, streams::outlier_size));
    m->faults.stuck = {f.stuck.start_s, f.stuck.stop_s};
    m->faults.stuck_axis = f.stuck.sensor == sensor + 1 ? f.stuck.axis - 1 : -1;
    m->faults.jump = {f.bias_jump.start_s, f.bias_jump.stop_s};
    m->faults.jump_size = Vector3(jump);
    m->faults.noise = {f.noise_increase.start_s, f.noise_increase.stop_s};
    m->faults.noise_factor = noise_factor;
}

SensorModel gyro_model(const hnav_gyro_options& o, const Device& device) {
    constexpr int sensor = HNAV_SENSOR_GYRO;
    const hnav_sensor_faults& f = device.faults;
    // deg/sqrt(h) = deg/h/sqrt(Hz)/60; deg/h/sqrt(h) over 3600 s and 60 sqrt(s).
    SensorModel m = model_of(o, sensor, device,
                             {o.noise_deg_per_sqrt_h * deg / root_hour_s, o.bias_instability_rad_s,
                              o.random_walk_deg_per_h_per_sqrt_h * deg / 3600 / root_hour_s});
    set_bias(&m, device.constants(sensor), o.bias_rad_s, o.bias_sigma_rad_s, o.drift_rad_s2, o.drift_sigma_rad_s2);
    m.g_sensitivity = o.g_sensitivity_deg_per_h_per_g * deg / 3600 / standard_gravity_m_s2;
    m.quantiser = {o.range_rad_s, o.resolution_rad_s};
    set_faults(&m, device, sensor, f.outliers.gyro_sigma_rad_s, f.bias_jump.gyro_rad_s, f.noise_increase.gyro_factor);
    return m;
}

SensorModel accel_model(const hnav_accel_options& o, const Device& device) {
    constexpr int sensor = HNAV_SENSOR_ACCEL;
    const hnav_sensor_faults& f = device.faults;
    SensorModel m = model_of(
        o, sensor, device,
        {o.noise_ug_per_sqrt_hz * ug_m_s2, o.bias_instability_m_s2, o.random_walk_ug_per_sqrt_h * ug_m_s2 / root_hour_s});
    set_bias(&m, device.constants(sensor), o.bias_m_s2, o.bias_sigma_m_s2, o.drift_m_s3, o.drift_sigma_m_s3);
    m.quantiser = {o.range_m_s2, o.resolution_m_s2};
    set_faults(&m, device, sensor, f.outliers.accel_sigma_m_s2, f.bias_jump.accel_m_s2, f.noise_increase.accel_factor);
    return m;
}

SensorModel mag_model(const hnav_mag_options& o, const Device& device) {
    constexpr int sensor = HNAV_SENSOR_MAG;
    const hnav_sensor_faults& f = device.faults;
    const Constants constants = device.constants(sensor);
    SensorModel m =
        model_of(o, sensor, device,
                 {o.noise_nt_per_sqrt_hz * 1e-9, o.bias_instability_tesla, o.random_walk_nt_per_sqrt_h * 1e-9 / root_hour_s});
    set_bias(&m, constants, o.bias_tesla, o.bias_sigma_tesla, o.drift_tesla_s, o.drift_sigma_tesla_s);
    // Iron changes the field before the chip measures it: matrix ((I + soft) field + hard).
    const Matrix3 soft = Matrix3::Identity() +
                         Matrix3(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(o.soft_iron)) +
                         constants.matrix(soft_iron_place, o.soft_iron_sigma);
    const Vector3 hard = Vector3(o.hard_iron_tesla) + constants.vector(hard_iron_place, o.hard_iron_sigma_tesla);
    m.error.after += m.error.matrix * hard;
    m.error.matrix = m.error.matrix * soft;
    m.quantiser = {o.range_tesla, o.resolution_tesla};
    set_faults(&m, device, sensor, f.outliers.mag_sigma_tesla, f.bias_jump.mag_tesla, f.noise_increase.mag_factor);
    m.faults.disturbance = {f.mag_disturbance.start_s, f.mag_disturbance.stop_s};
    const Vector3 direction = Constants(device.seed, streams::of(sensor, streams::disturbance)).vector(0, 1);
    m.faults.disturbance_n = Vector3(f.mag_disturbance.field_n_tesla) + f.mag_disturbance.strength_tesla * direction.normalized();
    return m;
}

} // namespace

ImuMagSensor::ImuMagSensor(const hnav_imu_mag_sensor_options& options, double start_s) {
    const Device device{static_cast<std::uint64_t>(options.seed), start_s, options.fault};
    models_[HNAV_SENSOR_GYRO] = gyro_model(options.gyro, device);
    models_[HNAV_SENSOR_ACCEL] = accel_model(options.accel, device);
    models_[HNAV_SENSOR_MAG] = mag_model(options.mag, device);
}

void ImuMagSensor::sample(double t_s, const Truth& truth) {
    const Vector3* inputs[] = {&truth.rate, &truth.force, &truth.field};
    for (int s = 0; s < sensor_count; ++s) {
        // No sample waits beyond its latency, so the queue has space for one more.
        Delivery<3>::advance(&state_.of[s].delivery, t_s);
        models_[s].sample(t_s, *inputs[s], truth.force, truth.q, &state_.of[s]);
    }
}

void ImuMagSensor::advance(double t_s) {
    for (SensorModel::State& s : state_.of) Delivery<3>::advance(&s.delivery, t_s);
}

double ImuMagSensor::next_event_s() const {
    double next = std::numeric_limits<double>::infinity();
    for (int s = 0; s < sensor_count; ++s)
        next = std::fmin(next, std::fmin(models_[s].clock.due_s(state_.of[s].next), Delivery<3>::next_s(state_.of[s].delivery)));
    return next;
}

bool ImuMagSensor::assign(const State& state) {
    for (const SensorModel::State& s : state.of)
        if (!(s.delivery.waiting >= 0 && s.delivery.waiting < max_in_flight) || !(s.next >= 0)) return false;
    state_ = state;
    return true;
}

} // namespace hnav
