// Made by c_src/options/generate.py from imu_mag_sensor.toml: change that, then ./run generate.
#include "options/lists.hpp"

#include "hnav/options/imu_mag_sensor.h"

#include <cmath>
#include <cstddef>

// clang-format off
namespace hnav {
namespace {

const char* const stuck_names[] = {text("none"), text("gyro"), text("accel"), text("mag")};
const char* const stuck_meanings[] = {
    text("none"),
    text("the gyroscope"),
    text("the accelerometer"),
    text("the magnetometer"),
};

constexpr double defaults[] = {
    0, // seed
    0.01, // gyro.period_s
    0, // gyro.latency_s
    0, // gyro.jitter_s
    0, // gyro.dropout
    0, // gyro.noise_deg_per_sqrt_h
    0, // gyro.bias_instability_rad_s
    0, // gyro.random_walk_deg_per_h_per_sqrt_h
    0, 0, 0, // gyro.bias_rad_s
    0, // gyro.bias_sigma_rad_s
    0, 0, 0, // gyro.drift_rad_s2
    0, // gyro.drift_sigma_rad_s2
    0, 0, 0, // gyro.scale_factor
    0, // gyro.scale_factor_sigma
    0, 0, 0, 0, 0, 0, // gyro.misalignment_rad
    0, // gyro.misalignment_sigma_rad
    0, // gyro.g_sensitivity_deg_per_h_per_g
    0, // gyro.range_rad_s
    0, // gyro.resolution_rad_s
    0.01, // accel.period_s
    0, // accel.latency_s
    0, // accel.jitter_s
    0, // accel.dropout
    0, // accel.noise_ug_per_sqrt_hz
    0, // accel.bias_instability_m_s2
    0, // accel.random_walk_ug_per_sqrt_h
    0, 0, 0, // accel.bias_m_s2
    0, // accel.bias_sigma_m_s2
    0, 0, 0, // accel.drift_m_s3
    0, // accel.drift_sigma_m_s3
    0, 0, 0, // accel.scale_factor
    0, // accel.scale_factor_sigma
    0, 0, 0, 0, 0, 0, // accel.misalignment_rad
    0, // accel.misalignment_sigma_rad
    0, // accel.range_m_s2
    0, // accel.resolution_m_s2
    0.01, // mag.period_s
    0, // mag.latency_s
    0, // mag.jitter_s
    0, // mag.dropout
    0, // mag.noise_nt_per_sqrt_hz
    0, // mag.bias_instability_tesla
    0, // mag.random_walk_nt_per_sqrt_h
    0, 0, 0, // mag.bias_tesla
    0, // mag.bias_sigma_tesla
    0, 0, 0, // mag.drift_tesla_s
    0, // mag.drift_sigma_tesla_s
    0, 0, 0, // mag.scale_factor
    0, // mag.scale_factor_sigma
    0, 0, 0, 0, 0, 0, // mag.misalignment_rad
    0, // mag.misalignment_sigma_rad
    0, 0, 0, // mag.hard_iron_tesla
    0, // mag.hard_iron_sigma_tesla
    0, 0, 0, 0, 0, 0, 0, 0, 0, // mag.soft_iron
    0, // mag.soft_iron_sigma
    0, // mag.range_tesla
    0, // mag.resolution_tesla
    0, // fault.mag_disturbance.start_s
    0, // fault.mag_disturbance.stop_s
    0, 0, 0, // fault.mag_disturbance.field_n_tesla
    0, // fault.mag_disturbance.strength_tesla
    0, // fault.outliers.start_s
    0, // fault.outliers.stop_s
    0, // fault.outliers.probability
    0, // fault.outliers.gyro_sigma_rad_s
    0, // fault.outliers.accel_sigma_m_s2
    0, // fault.outliers.mag_sigma_tesla
    0, // fault.stuck.start_s
    0, // fault.stuck.stop_s
    0, // fault.stuck.sensor
    1, // fault.stuck.axis
    0, // fault.bias_jump.start_s
    0, // fault.bias_jump.stop_s
    0, 0, 0, // fault.bias_jump.gyro_rad_s
    0, 0, 0, // fault.bias_jump.accel_m_s2
    0, 0, 0, // fault.bias_jump.mag_tesla
    0, // fault.noise_increase.start_s
    0, // fault.noise_increase.stop_s
    1, // fault.noise_increase.gyro_factor
    1, // fault.noise_increase.accel_factor
    1, // fault.noise_increase.mag_factor
};

const OptionRow rows[] = {
    {"seed", text("chance"), text(""),
     text("Seed of everything random"),
     text("Any seed is as good as any other."),
     nullptr, nullptr, defaults + 0, offsetof(hnav_imu_mag_sensor_options, seed),
     0, 2147483647, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 0},
    {"gyro.period_s", text("gyro"), text("s"),
     text("Sampling period"),
     text("100 Hz, as usual sensors."),
     nullptr, nullptr, defaults + 1, offsetof(hnav_imu_mag_sensor_options, gyro.period_s),
     1e-06, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gyro.latency_s", text("gyro"), text("s"),
     text("From sample to delivery; at most 30 periods"),
     text("Delivered at once."),
     nullptr, nullptr, defaults + 2, offsetof(hnav_imu_mag_sensor_options, gyro.latency_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gyro.jitter_s", text("gyro"), text("s"),
     text("A sample is due uniformly within +- this of its time; below half a period"),
     text("On time."),
     nullptr, nullptr, defaults + 3, offsetof(hnav_imu_mag_sensor_options, gyro.jitter_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.dropout", text("gyro"), text(""),
     text("Probability that a sample is never delivered"),
     text("None is lost."),
     nullptr, nullptr, defaults + 4, offsetof(hnav_imu_mag_sensor_options, gyro.dropout),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.noise_deg_per_sqrt_h", text("gyro"), text(""),
     text("Angle random walk in deg/sqrt(h): white noise of the rate"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 5, offsetof(hnav_imu_mag_sensor_options, gyro.noise_deg_per_sqrt_h),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gyro.bias_instability_rad_s", text("gyro"), text("rad/s"),
     text("Bias instability: floor of the Allan deviation"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 6, offsetof(hnav_imu_mag_sensor_options, gyro.bias_instability_rad_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gyro.random_walk_deg_per_h_per_sqrt_h", text("gyro"), text(""),
     text("Rate random walk in deg/h/sqrt(h)"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 7, offsetof(hnav_imu_mag_sensor_options, gyro.random_walk_deg_per_h_per_sqrt_h),
     0, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.bias_rad_s", text("gyro"), text("rad/s"),
     text("Bias"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 8, offsetof(hnav_imu_mag_sensor_options, gyro.bias_rad_s),
     -1e+06, 1e+06, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.bias_sigma_rad_s", text("gyro"), text("rad/s"),
     text("Standard deviation of the turn-on bias, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 11, offsetof(hnav_imu_mag_sensor_options, gyro.bias_sigma_rad_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"gyro.drift_rad_s2", text("gyro"), text("rad/s2"),
     text("Steady drift of the bias"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 12, offsetof(hnav_imu_mag_sensor_options, gyro.drift_rad_s2),
     -1e+06, 1e+06, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.drift_sigma_rad_s2", text("gyro"), text("rad/s2"),
     text("Standard deviation of the drift, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 15, offsetof(hnav_imu_mag_sensor_options, gyro.drift_sigma_rad_s2),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.scale_factor", text("gyro"), text(""),
     text("Scale factor error; 0: exact"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 16, offsetof(hnav_imu_mag_sensor_options, gyro.scale_factor),
     -1, 1, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.scale_factor_sigma", text("gyro"), text(""),
     text("Standard deviation of further scale factor errors, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 19, offsetof(hnav_imu_mag_sensor_options, gyro.scale_factor_sigma),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.misalignment_rad", text("gyro"), text("rad"),
     text("Misalignment xy xz yx yz zx zy: of y seen in x, and so on"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 20, offsetof(hnav_imu_mag_sensor_options, gyro.misalignment_rad),
     -1, 1, 6, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.misalignment_sigma_rad", text("gyro"), text("rad"),
     text("Standard deviation of further misalignments, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 26, offsetof(hnav_imu_mag_sensor_options, gyro.misalignment_sigma_rad),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.g_sensitivity_deg_per_h_per_g", text("gyro"), text(""),
     text("Bias of each axis by the force along it, in deg/h/g"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 27, offsetof(hnav_imu_mag_sensor_options, gyro.g_sensitivity_deg_per_h_per_g),
     -1e+06, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.range_rad_s", text("gyro"), text("rad/s"),
     text("Readings end here; 0: unlimited"),
     text("Unlimited."),
     nullptr, nullptr, defaults + 28, offsetof(hnav_imu_mag_sensor_options, gyro.range_rad_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"gyro.resolution_rad_s", text("gyro"), text("rad/s"),
     text("Readings are multiples of this; 0: continuous"),
     text("Continuous."),
     nullptr, nullptr, defaults + 29, offsetof(hnav_imu_mag_sensor_options, gyro.resolution_rad_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.period_s", text("accel"), text("s"),
     text("Sampling period"),
     text("100 Hz, as usual sensors."),
     nullptr, nullptr, defaults + 30, offsetof(hnav_imu_mag_sensor_options, accel.period_s),
     1e-06, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"accel.latency_s", text("accel"), text("s"),
     text("From sample to delivery; at most 30 periods"),
     text("Delivered at once."),
     nullptr, nullptr, defaults + 31, offsetof(hnav_imu_mag_sensor_options, accel.latency_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"accel.jitter_s", text("accel"), text("s"),
     text("A sample is due uniformly within +- this of its time; below half a period"),
     text("On time."),
     nullptr, nullptr, defaults + 32, offsetof(hnav_imu_mag_sensor_options, accel.jitter_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.dropout", text("accel"), text(""),
     text("Probability that a sample is never delivered"),
     text("None is lost."),
     nullptr, nullptr, defaults + 33, offsetof(hnav_imu_mag_sensor_options, accel.dropout),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.noise_ug_per_sqrt_hz", text("accel"), text(""),
     text("White noise in ug/sqrt(Hz)"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 34, offsetof(hnav_imu_mag_sensor_options, accel.noise_ug_per_sqrt_hz),
     0, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"accel.bias_instability_m_s2", text("accel"), text("m/s2"),
     text("Bias instability: floor of the Allan deviation"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 35, offsetof(hnav_imu_mag_sensor_options, accel.bias_instability_m_s2),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"accel.random_walk_ug_per_sqrt_h", text("accel"), text(""),
     text("Random walk of the bias in ug/sqrt(h)"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 36, offsetof(hnav_imu_mag_sensor_options, accel.random_walk_ug_per_sqrt_h),
     0, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.bias_m_s2", text("accel"), text("m/s2"),
     text("Bias"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 37, offsetof(hnav_imu_mag_sensor_options, accel.bias_m_s2),
     -1e+06, 1e+06, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.bias_sigma_m_s2", text("accel"), text("m/s2"),
     text("Standard deviation of the turn-on bias, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 40, offsetof(hnav_imu_mag_sensor_options, accel.bias_sigma_m_s2),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"accel.drift_m_s3", text("accel"), text("m/s3"),
     text("Steady drift of the bias"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 41, offsetof(hnav_imu_mag_sensor_options, accel.drift_m_s3),
     -1e+06, 1e+06, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.drift_sigma_m_s3", text("accel"), text("m/s3"),
     text("Standard deviation of the drift, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 44, offsetof(hnav_imu_mag_sensor_options, accel.drift_sigma_m_s3),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.scale_factor", text("accel"), text(""),
     text("Scale factor error; 0: exact"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 45, offsetof(hnav_imu_mag_sensor_options, accel.scale_factor),
     -1, 1, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.scale_factor_sigma", text("accel"), text(""),
     text("Standard deviation of further scale factor errors, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 48, offsetof(hnav_imu_mag_sensor_options, accel.scale_factor_sigma),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.misalignment_rad", text("accel"), text("rad"),
     text("Misalignment xy xz yx yz zx zy: of y seen in x, and so on"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 49, offsetof(hnav_imu_mag_sensor_options, accel.misalignment_rad),
     -1, 1, 6, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.misalignment_sigma_rad", text("accel"), text("rad"),
     text("Standard deviation of further misalignments, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 55, offsetof(hnav_imu_mag_sensor_options, accel.misalignment_sigma_rad),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.range_m_s2", text("accel"), text("m/s2"),
     text("Readings end here; 0: unlimited"),
     text("Unlimited."),
     nullptr, nullptr, defaults + 56, offsetof(hnav_imu_mag_sensor_options, accel.range_m_s2),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"accel.resolution_m_s2", text("accel"), text("m/s2"),
     text("Readings are multiples of this; 0: continuous"),
     text("Continuous."),
     nullptr, nullptr, defaults + 57, offsetof(hnav_imu_mag_sensor_options, accel.resolution_m_s2),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.period_s", text("mag"), text("s"),
     text("Sampling period"),
     text("100 Hz, as usual sensors."),
     nullptr, nullptr, defaults + 58, offsetof(hnav_imu_mag_sensor_options, mag.period_s),
     1e-06, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"mag.latency_s", text("mag"), text("s"),
     text("From sample to delivery; at most 30 periods"),
     text("Delivered at once."),
     nullptr, nullptr, defaults + 59, offsetof(hnav_imu_mag_sensor_options, mag.latency_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"mag.jitter_s", text("mag"), text("s"),
     text("A sample is due uniformly within +- this of its time; below half a period"),
     text("On time."),
     nullptr, nullptr, defaults + 60, offsetof(hnav_imu_mag_sensor_options, mag.jitter_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.dropout", text("mag"), text(""),
     text("Probability that a sample is never delivered"),
     text("None is lost."),
     nullptr, nullptr, defaults + 61, offsetof(hnav_imu_mag_sensor_options, mag.dropout),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.noise_nt_per_sqrt_hz", text("mag"), text(""),
     text("White noise in nT/sqrt(Hz)"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 62, offsetof(hnav_imu_mag_sensor_options, mag.noise_nt_per_sqrt_hz),
     0, 1e+12, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"mag.bias_instability_tesla", text("mag"), text("T"),
     text("Bias instability: floor of the Allan deviation"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 63, offsetof(hnav_imu_mag_sensor_options, mag.bias_instability_tesla),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"mag.random_walk_nt_per_sqrt_h", text("mag"), text(""),
     text("Random walk of the bias in nT/sqrt(h)"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 64, offsetof(hnav_imu_mag_sensor_options, mag.random_walk_nt_per_sqrt_h),
     0, 1e+12, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.bias_tesla", text("mag"), text("T"),
     text("Bias"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 65, offsetof(hnav_imu_mag_sensor_options, mag.bias_tesla),
     -1e+06, 1e+06, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.bias_sigma_tesla", text("mag"), text("T"),
     text("Standard deviation of the turn-on bias, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 68, offsetof(hnav_imu_mag_sensor_options, mag.bias_sigma_tesla),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 0},
    {"mag.drift_tesla_s", text("mag"), text("T/s"),
     text("Steady drift of the bias"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 69, offsetof(hnav_imu_mag_sensor_options, mag.drift_tesla_s),
     -1e+06, 1e+06, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.drift_sigma_tesla_s", text("mag"), text("T/s"),
     text("Standard deviation of the drift, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 72, offsetof(hnav_imu_mag_sensor_options, mag.drift_sigma_tesla_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.scale_factor", text("mag"), text(""),
     text("Scale factor error; 0: exact"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 73, offsetof(hnav_imu_mag_sensor_options, mag.scale_factor),
     -1, 1, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.scale_factor_sigma", text("mag"), text(""),
     text("Standard deviation of further scale factor errors, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 76, offsetof(hnav_imu_mag_sensor_options, mag.scale_factor_sigma),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.misalignment_rad", text("mag"), text("rad"),
     text("Misalignment xy xz yx yz zx zy: of y seen in x, and so on"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 77, offsetof(hnav_imu_mag_sensor_options, mag.misalignment_rad),
     -1, 1, 6, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.misalignment_sigma_rad", text("mag"), text("rad"),
     text("Standard deviation of further misalignments, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 83, offsetof(hnav_imu_mag_sensor_options, mag.misalignment_sigma_rad),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.hard_iron_tesla", text("mag"), text("T"),
     text("Hard iron: field of iron and currents that turn with the sensor"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 84, offsetof(hnav_imu_mag_sensor_options, mag.hard_iron_tesla),
     -1, 1, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.hard_iron_sigma_tesla", text("mag"), text("T"),
     text("Standard deviation of further hard iron, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 87, offsetof(hnav_imu_mag_sensor_options, mag.hard_iron_sigma_tesla),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.soft_iron", text("mag"), text(""),
     text("Soft iron, 3 x 3 by rows: the field becomes (I + this) field; 0: none"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 88, offsetof(hnav_imu_mag_sensor_options, mag.soft_iron),
     -1, 1, 9, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.soft_iron_sigma", text("mag"), text(""),
     text("Standard deviation of further soft iron, drawn from seed"),
     text("No error until a datasheet says one."),
     nullptr, nullptr, defaults + 97, offsetof(hnav_imu_mag_sensor_options, mag.soft_iron_sigma),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.range_tesla", text("mag"), text("T"),
     text("Readings end here; 0: unlimited"),
     text("Unlimited."),
     nullptr, nullptr, defaults + 98, offsetof(hnav_imu_mag_sensor_options, mag.range_tesla),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"mag.resolution_tesla", text("mag"), text("T"),
     text("Readings are multiples of this; 0: continuous"),
     text("Continuous."),
     nullptr, nullptr, defaults + 99, offsetof(hnav_imu_mag_sensor_options, mag.resolution_tesla),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.mag_disturbance.start_s", text("fault.mag_disturbance"), text("s"),
     text("Start of the fault"),
     text("The window is empty."),
     nullptr, nullptr, defaults + 100, offsetof(hnav_imu_mag_sensor_options, fault.mag_disturbance.start_s),
     -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.mag_disturbance.stop_s", text("fault.mag_disturbance"), text("s"),
     text("End of the fault, excluded; not after the start: no fault"),
     text("The window is empty."),
     nullptr, nullptr, defaults + 101, offsetof(hnav_imu_mag_sensor_options, fault.mag_disturbance.stop_s),
     -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.mag_disturbance.field_n_tesla", text("fault.mag_disturbance"), text("T"),
     text("Field added outside, in navigation axes"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 102, offsetof(hnav_imu_mag_sensor_options, fault.mag_disturbance.field_n_tesla),
     -1, 1, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.mag_disturbance.strength_tesla", text("fault.mag_disturbance"), text("T"),
     text("And this much in a direction drawn from seed"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 105, offsetof(hnav_imu_mag_sensor_options, fault.mag_disturbance.strength_tesla),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.outliers.start_s", text("fault.outliers"), text("s"),
     text("Start of the fault"),
     text("The window is empty."),
     nullptr, nullptr, defaults + 106, offsetof(hnav_imu_mag_sensor_options, fault.outliers.start_s),
     -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.outliers.stop_s", text("fault.outliers"), text("s"),
     text("End of the fault, excluded; not after the start: no fault"),
     text("The window is empty."),
     nullptr, nullptr, defaults + 107, offsetof(hnav_imu_mag_sensor_options, fault.outliers.stop_s),
     -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.outliers.probability", text("fault.outliers"), text(""),
     text("Probability of an outlier, for each sample of each sensor"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 108, offsetof(hnav_imu_mag_sensor_options, fault.outliers.probability),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.outliers.gyro_sigma_rad_s", text("fault.outliers"), text("rad/s"),
     text("Standard deviation of outliers of the gyroscope"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 109, offsetof(hnav_imu_mag_sensor_options, fault.outliers.gyro_sigma_rad_s),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.outliers.accel_sigma_m_s2", text("fault.outliers"), text("m/s2"),
     text("Standard deviation of outliers of the accelerometer"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 110, offsetof(hnav_imu_mag_sensor_options, fault.outliers.accel_sigma_m_s2),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.outliers.mag_sigma_tesla", text("fault.outliers"), text("T"),
     text("Standard deviation of outliers of the magnetometer"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 111, offsetof(hnav_imu_mag_sensor_options, fault.outliers.mag_sigma_tesla),
     0, 1, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.stuck.start_s", text("fault.stuck"), text("s"),
     text("Start of the fault"),
     text("The window is empty."),
     nullptr, nullptr, defaults + 112, offsetof(hnav_imu_mag_sensor_options, fault.stuck.start_s),
     -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.stuck.stop_s", text("fault.stuck"), text("s"),
     text("End of the fault, excluded; not after the start: no fault"),
     text("The window is empty."),
     nullptr, nullptr, defaults + 113, offsetof(hnav_imu_mag_sensor_options, fault.stuck.stop_s),
     -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.stuck.sensor", text("fault.stuck"), text(""),
     text("Sensor with an axis that repeats its last reading"),
     text("Nothing happens, even within the window."),
     stuck_names, stuck_meanings, defaults + 114, offsetof(hnav_imu_mag_sensor_options, fault.stuck.sensor),
     0, 3, 1, 4, HNAV_OPTION_CHOICE, 0, 0, 1},
    {"fault.stuck.axis", text("fault.stuck"), text(""),
     text("That axis"),
     text("The first."),
     nullptr, nullptr, defaults + 115, offsetof(hnav_imu_mag_sensor_options, fault.stuck.axis),
     1, 3, 1, 0, HNAV_OPTION_INTEGER, 0, 0, 1},
    {"fault.bias_jump.start_s", text("fault.bias_jump"), text("s"),
     text("Start of the fault"),
     text("The window is empty."),
     nullptr, nullptr, defaults + 116, offsetof(hnav_imu_mag_sensor_options, fault.bias_jump.start_s),
     -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.bias_jump.stop_s", text("fault.bias_jump"), text("s"),
     text("End of the fault, excluded; not after the start: no fault"),
     text("The window is empty."),
     nullptr, nullptr, defaults + 117, offsetof(hnav_imu_mag_sensor_options, fault.bias_jump.stop_s),
     -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.bias_jump.gyro_rad_s", text("fault.bias_jump"), text("rad/s"),
     text("Added to the gyroscope"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 118, offsetof(hnav_imu_mag_sensor_options, fault.bias_jump.gyro_rad_s),
     -1e+06, 1e+06, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.bias_jump.accel_m_s2", text("fault.bias_jump"), text("m/s2"),
     text("Added to the accelerometer"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 121, offsetof(hnav_imu_mag_sensor_options, fault.bias_jump.accel_m_s2),
     -1e+06, 1e+06, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.bias_jump.mag_tesla", text("fault.bias_jump"), text("T"),
     text("Added to the magnetometer"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 124, offsetof(hnav_imu_mag_sensor_options, fault.bias_jump.mag_tesla),
     -1, 1, 3, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.noise_increase.start_s", text("fault.noise_increase"), text("s"),
     text("Start of the fault"),
     text("The window is empty."),
     nullptr, nullptr, defaults + 127, offsetof(hnav_imu_mag_sensor_options, fault.noise_increase.start_s),
     -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.noise_increase.stop_s", text("fault.noise_increase"), text("s"),
     text("End of the fault, excluded; not after the start: no fault"),
     text("The window is empty."),
     nullptr, nullptr, defaults + 128, offsetof(hnav_imu_mag_sensor_options, fault.noise_increase.stop_s),
     -1e+09, 1e+09, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.noise_increase.gyro_factor", text("fault.noise_increase"), text(""),
     text("Factor on the white noise of the gyroscope"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 129, offsetof(hnav_imu_mag_sensor_options, fault.noise_increase.gyro_factor),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.noise_increase.accel_factor", text("fault.noise_increase"), text(""),
     text("Factor on the white noise of the accelerometer"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 130, offsetof(hnav_imu_mag_sensor_options, fault.noise_increase.accel_factor),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
    {"fault.noise_increase.mag_factor", text("fault.noise_increase"), text(""),
     text("Factor on the white noise of the magnetometer"),
     text("Nothing happens, even within the window."),
     nullptr, nullptr, defaults + 131, offsetof(hnav_imu_mag_sensor_options, fault.noise_increase.mag_factor),
     0, 1e+06, 1, 0, HNAV_OPTION_REAL, 0, 0, 1},
};

constexpr Preset presets[] = {
    {{"default", text("The defaults."), 0}, nullptr, 0},
};

} // namespace

const OptionList imu_mag_sensor_options = {
    "hnav_imu_mag_sensor_defaults", 7, sizeof(hnav_imu_mag_sensor_options), rows, 81, presets, 1};

} // namespace hnav
