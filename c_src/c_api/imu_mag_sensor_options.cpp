// The options of the inertial and magnetic sensor as rows.
#include "hnav/simulation.h"
#define HNAV_OPTIONS hnav_imu_mag_sensor_options
#include "c_api/option_rows.hpp"

namespace hnav {
namespace {

const char* const stuck_sensors[] = {"none", "gyro", "accel", "mag"};

// What the three sensors share: unit of the reading, and of its drift.
#define SENSOR_TIME(s)                                                                                                           \
    ABOVE(s.period_s, "s", 0, 1e6, 1, "Sampling period"),                                                                        \
        REAL(s.latency_s, "s", 0, 1e6, 1, "From sample to delivery; at most 30 periods"),                                        \
        REAL(s.jitter_s, "s", 0, 1e6, 1, "A sample is due uniformly within +- this of its time; below half a period"),           \
        REAL(s.dropout, "", 0, 1, 1, "Probability that a sample is never delivered")
#define SENSOR_BIAS(s, bias, bias_sigma, drift, drift_sigma, unit, drift_unit)                                                   \
    REAL(s.bias, unit, -1e6, 1e6, 3, "Bias"),                                                                                    \
        REAL(s.bias_sigma, unit, 0, 1e6, 1, "Standard deviation of the turn-on bias, drawn from seed"),                          \
        REAL(s.drift, drift_unit, -1e6, 1e6, 3, "Steady drift of the bias"),                                                     \
        REAL(s.drift_sigma, drift_unit, 0, 1e6, 1, "Standard deviation of the drift, drawn from seed")
#define SENSOR_AXES(s)                                                                                                           \
    REAL(s.scale_factor, "", -1, 1, 3, "Scale factor error; 0: exact"),                                                          \
        REAL(s.scale_factor_sigma, "", 0, 1, 1, "Standard deviation of further scale factor errors, drawn from seed"),           \
        REAL(s.misalignment_rad, "rad", -1, 1, 6, "Misalignment xy xz yx yz zx zy: of y seen in x, ..."),                        \
        REAL(s.misalignment_sigma_rad, "rad", 0, 1, 1, "Standard deviation of further misalignments, drawn from seed")
#define SENSOR_CONVERTER(s, range, resolution, unit)                                                                             \
    REAL(s.range, unit, 0, 1e6, 1, "Readings end here; 0: unlimited"),                                                           \
        REAL(s.resolution, unit, 0, 1e6, 1, "Readings are multiples of this; 0: continuous")
#define FAULT_WINDOW(f)                                                                                                          \
    REAL(fault.f.start_s, "s", -1e9, 1e9, 1, "Start of the fault"),                                                              \
        REAL(fault.f.stop_s, "s", -1e9, 1e9, 1, "End of the fault, excluded; not after the start: no fault")

const hnav_option_info sensor_rows[] = {
    INTEGER(seed, 0, 2147483647, "Seed of everything random"),

    SENSOR_TIME(gyro),
    REAL(gyro.noise_deg_per_sqrt_h, "", 0, 1e6, 1, "Angle random walk in deg/sqrt(h): white noise of the rate"),
    REAL(gyro.bias_instability_rad_s, "rad/s", 0, 1e6, 1, "Bias instability: floor of the Allan deviation"),
    REAL(gyro.random_walk_deg_per_h_per_sqrt_h, "", 0, 1e9, 1, "Rate random walk in deg/h/sqrt(h)"),
    SENSOR_BIAS(gyro, bias_rad_s, bias_sigma_rad_s, drift_rad_s2, drift_sigma_rad_s2, "rad/s", "rad/s2"),
    SENSOR_AXES(gyro),
    REAL(gyro.g_sensitivity_deg_per_h_per_g, "", -1e6, 1e6, 1, "Bias of each axis by the force along it, in deg/h/g"),
    SENSOR_CONVERTER(gyro, range_rad_s, resolution_rad_s, "rad/s"),

    SENSOR_TIME(accel),
    REAL(accel.noise_ug_per_sqrt_hz, "", 0, 1e9, 1, "White noise in ug/sqrt(Hz)"),
    REAL(accel.bias_instability_m_s2, "m/s2", 0, 1e6, 1, "Bias instability: floor of the Allan deviation"),
    REAL(accel.random_walk_ug_per_sqrt_h, "", 0, 1e9, 1, "Random walk of the bias in ug/sqrt(h)"),
    SENSOR_BIAS(accel, bias_m_s2, bias_sigma_m_s2, drift_m_s3, drift_sigma_m_s3, "m/s2", "m/s3"),
    SENSOR_AXES(accel),
    SENSOR_CONVERTER(accel, range_m_s2, resolution_m_s2, "m/s2"),

    SENSOR_TIME(mag),
    REAL(mag.noise_nt_per_sqrt_hz, "", 0, 1e12, 1, "White noise in nT/sqrt(Hz)"),
    REAL(mag.bias_instability_tesla, "T", 0, 1, 1, "Bias instability: floor of the Allan deviation"),
    REAL(mag.random_walk_nt_per_sqrt_h, "", 0, 1e12, 1, "Random walk of the bias in nT/sqrt(h)"),
    SENSOR_BIAS(mag, bias_tesla, bias_sigma_tesla, drift_tesla_s, drift_sigma_tesla_s, "T", "T/s"),
    SENSOR_AXES(mag),
    REAL(mag.hard_iron_tesla, "T", -1, 1, 3, "Hard iron: field of what turns with the sensor"),
    REAL(mag.hard_iron_sigma_tesla, "T", 0, 1, 1, "Standard deviation of further hard iron, drawn from seed"),
    REAL(mag.soft_iron, "", -1, 1, 9, "Soft iron, 3 x 3 by rows: the field becomes (I + this) field; 0: none"),
    REAL(mag.soft_iron_sigma, "", 0, 1, 1, "Standard deviation of further soft iron, drawn from seed"),
    SENSOR_CONVERTER(mag, range_tesla, resolution_tesla, "T"),

    FAULT_WINDOW(mag_disturbance),
    REAL(fault.mag_disturbance.field_n_tesla, "T", -1, 1, 3, "Field added outside, in navigation axes"),
    REAL(fault.mag_disturbance.strength_tesla, "T", 0, 1, 1, "And this much in a direction drawn from seed"),
    FAULT_WINDOW(outliers),
    REAL(fault.outliers.probability, "", 0, 1, 1, "Probability of an outlier, for each sample of each sensor"),
    REAL(fault.outliers.gyro_sigma_rad_s, "rad/s", 0, 1e6, 1, "Standard deviation of outliers of the gyroscope"),
    REAL(fault.outliers.accel_sigma_m_s2, "m/s2", 0, 1e6, 1, "Standard deviation of outliers of the accelerometer"),
    REAL(fault.outliers.mag_sigma_tesla, "T", 0, 1, 1, "Standard deviation of outliers of the magnetometer"),
    FAULT_WINDOW(stuck),
    CHOICE(fault.stuck.sensor, stuck_sensors, "Sensor with an axis that repeats its last reading"),
    INTEGER(fault.stuck.axis, 1, 3, "That axis"),
    FAULT_WINDOW(bias_jump),
    REAL(fault.bias_jump.gyro_rad_s, "rad/s", -1e6, 1e6, 3, "Added to the gyroscope"),
    REAL(fault.bias_jump.accel_m_s2, "m/s2", -1e6, 1e6, 3, "Added to the accelerometer"),
    REAL(fault.bias_jump.mag_tesla, "T", -1, 1, 3, "Added to the magnetometer"),
    FAULT_WINDOW(noise_increase),
    REAL(fault.noise_increase.gyro_factor, "", 0, 1e6, 1, "Factor on the white noise of the gyroscope"),
    REAL(fault.noise_increase.accel_factor, "", 0, 1e6, 1, "Factor on the white noise of the accelerometer"),
    REAL(fault.noise_increase.mag_factor, "", 0, 1e6, 1, "Factor on the white noise of the magnetometer"),
};

} // namespace

OptionTable imu_mag_sensor_option_table() { return {sensor_rows, sizeof sensor_rows / sizeof *sensor_rows}; }

} // namespace hnav
