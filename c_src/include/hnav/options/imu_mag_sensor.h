/* Made by c_src/options/generate.py from imu_mag_sensor.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_IMU_MAG_SENSOR_H
#define HNAV_OPTIONS_IMU_MAG_SENSOR_H

#include <stddef.h>
#include <stdint.h>

/* The sensor with a stuck axis. */
typedef enum hnav_stuck_sensor {
    HNAV_STUCK_NONE = 0,  /* none */
    HNAV_STUCK_GYRO = 1,  /* the gyroscope */
    HNAV_STUCK_ACCEL = 2, /* the accelerometer */
    HNAV_STUCK_MAG = 3    /* the magnetometer */
} hnav_stuck_sensor;

/* Gyroscope. */
typedef struct hnav_gyro_options {
    /* Sampling period.
     * [1e-6, 1e6] s, default 0.01. 100 Hz, as usual sensors. */
    double period_s;
    /* From sample to delivery; at most 30 periods.
     * [0, 1e6] s, default 0. Delivered at once. */
    double latency_s;
    /* A sample is due uniformly within +- this of its time; below half a period.
     * [0, 1e6] s, default 0. On time. */
    double jitter_s;
    /* Probability that a sample is never delivered.
     * [0, 1], default 0. None is lost. */
    double dropout;
    /* Angle random walk in deg/sqrt(h): white noise of the rate.
     * [0, 1e6], default 0. No error until a datasheet says one. */
    double noise_deg_per_sqrt_h;
    /* Bias instability: floor of the Allan deviation.
     * [0, 1e6] rad/s, default 0. No error until a datasheet says one. */
    double bias_instability_rad_s;
    /* Rate random walk in deg/h/sqrt(h).
     * [0, 1e9], default 0. No error until a datasheet says one. */
    double random_walk_deg_per_h_per_sqrt_h;
    /* Bias.
     * [-1e6, 1e6] rad/s, default 0, 0, 0. No error until a datasheet says one. */
    double bias_rad_s[3];
    /* Standard deviation of the turn-on bias, drawn from seed.
     * [0, 1e6] rad/s, default 0. No error until a datasheet says one. */
    double bias_sigma_rad_s;
    /* Steady drift of the bias.
     * [-1e6, 1e6] rad/s2, default 0, 0, 0. No error until a datasheet says one. */
    double drift_rad_s2[3];
    /* Standard deviation of the drift, drawn from seed.
     * [0, 1e6] rad/s2, default 0. No error until a datasheet says one. */
    double drift_sigma_rad_s2;
    /* Scale factor error; 0: exact.
     * [-1, 1], default 0, 0, 0. No error until a datasheet says one. */
    double scale_factor[3];
    /* Standard deviation of further scale factor errors, drawn from seed.
     * [0, 1], default 0. No error until a datasheet says one. */
    double scale_factor_sigma;
    /* Misalignment xy xz yx yz zx zy: of y seen in x, and so on.
     * [-1, 1] rad, default 0, 0, 0, 0, 0, 0. No error until a datasheet says one. */
    double misalignment_rad[6];
    /* Standard deviation of further misalignments, drawn from seed.
     * [0, 1] rad, default 0. No error until a datasheet says one. */
    double misalignment_sigma_rad;
    /* Bias of each axis by the force along it, in deg/h/g.
     * [-1e6, 1e6], default 0. No error until a datasheet says one. */
    double g_sensitivity_deg_per_h_per_g;
    /* Readings end here; 0: unlimited.
     * [0, 1e6] rad/s, default 0. Unlimited. */
    double range_rad_s;
    /* Readings are multiples of this; 0: continuous.
     * [0, 1e6] rad/s, default 0. Continuous. */
    double resolution_rad_s;
} hnav_gyro_options;

/* Accelerometer. */
typedef struct hnav_accel_options {
    /* Sampling period.
     * [1e-6, 1e6] s, default 0.01. 100 Hz, as usual sensors. */
    double period_s;
    /* From sample to delivery; at most 30 periods.
     * [0, 1e6] s, default 0. Delivered at once. */
    double latency_s;
    /* A sample is due uniformly within +- this of its time; below half a period.
     * [0, 1e6] s, default 0. On time. */
    double jitter_s;
    /* Probability that a sample is never delivered.
     * [0, 1], default 0. None is lost. */
    double dropout;
    /* White noise in ug/sqrt(Hz).
     * [0, 1e9], default 0. No error until a datasheet says one. */
    double noise_ug_per_sqrt_hz;
    /* Bias instability: floor of the Allan deviation.
     * [0, 1e6] m/s2, default 0. No error until a datasheet says one. */
    double bias_instability_m_s2;
    /* Random walk of the bias in ug/sqrt(h).
     * [0, 1e9], default 0. No error until a datasheet says one. */
    double random_walk_ug_per_sqrt_h;
    /* Bias.
     * [-1e6, 1e6] m/s2, default 0, 0, 0. No error until a datasheet says one. */
    double bias_m_s2[3];
    /* Standard deviation of the turn-on bias, drawn from seed.
     * [0, 1e6] m/s2, default 0. No error until a datasheet says one. */
    double bias_sigma_m_s2;
    /* Steady drift of the bias.
     * [-1e6, 1e6] m/s3, default 0, 0, 0. No error until a datasheet says one. */
    double drift_m_s3[3];
    /* Standard deviation of the drift, drawn from seed.
     * [0, 1e6] m/s3, default 0. No error until a datasheet says one. */
    double drift_sigma_m_s3;
    /* Scale factor error; 0: exact.
     * [-1, 1], default 0, 0, 0. No error until a datasheet says one. */
    double scale_factor[3];
    /* Standard deviation of further scale factor errors, drawn from seed.
     * [0, 1], default 0. No error until a datasheet says one. */
    double scale_factor_sigma;
    /* Misalignment xy xz yx yz zx zy: of y seen in x, and so on.
     * [-1, 1] rad, default 0, 0, 0, 0, 0, 0. No error until a datasheet says one. */
    double misalignment_rad[6];
    /* Standard deviation of further misalignments, drawn from seed.
     * [0, 1] rad, default 0. No error until a datasheet says one. */
    double misalignment_sigma_rad;
    /* Readings end here; 0: unlimited.
     * [0, 1e6] m/s2, default 0. Unlimited. */
    double range_m_s2;
    /* Readings are multiples of this; 0: continuous.
     * [0, 1e6] m/s2, default 0. Continuous. */
    double resolution_m_s2;
} hnav_accel_options;

/* Magnetometer. */
typedef struct hnav_mag_options {
    /* Sampling period.
     * [1e-6, 1e6] s, default 0.01. 100 Hz, as usual sensors. */
    double period_s;
    /* From sample to delivery; at most 30 periods.
     * [0, 1e6] s, default 0. Delivered at once. */
    double latency_s;
    /* A sample is due uniformly within +- this of its time; below half a period.
     * [0, 1e6] s, default 0. On time. */
    double jitter_s;
    /* Probability that a sample is never delivered.
     * [0, 1], default 0. None is lost. */
    double dropout;
    /* White noise in nT/sqrt(Hz).
     * [0, 1e12], default 0. No error until a datasheet says one. */
    double noise_nt_per_sqrt_hz;
    /* Bias instability: floor of the Allan deviation.
     * [0, 1] T, default 0. No error until a datasheet says one. */
    double bias_instability_tesla;
    /* Random walk of the bias in nT/sqrt(h).
     * [0, 1e12], default 0. No error until a datasheet says one. */
    double random_walk_nt_per_sqrt_h;
    /* Bias.
     * [-1e6, 1e6] T, default 0, 0, 0. No error until a datasheet says one. */
    double bias_tesla[3];
    /* Standard deviation of the turn-on bias, drawn from seed.
     * [0, 1e6] T, default 0. No error until a datasheet says one. */
    double bias_sigma_tesla;
    /* Steady drift of the bias.
     * [-1e6, 1e6] T/s, default 0, 0, 0. No error until a datasheet says one. */
    double drift_tesla_s[3];
    /* Standard deviation of the drift, drawn from seed.
     * [0, 1e6] T/s, default 0. No error until a datasheet says one. */
    double drift_sigma_tesla_s;
    /* Scale factor error; 0: exact.
     * [-1, 1], default 0, 0, 0. No error until a datasheet says one. */
    double scale_factor[3];
    /* Standard deviation of further scale factor errors, drawn from seed.
     * [0, 1], default 0. No error until a datasheet says one. */
    double scale_factor_sigma;
    /* Misalignment xy xz yx yz zx zy: of y seen in x, and so on.
     * [-1, 1] rad, default 0, 0, 0, 0, 0, 0. No error until a datasheet says one. */
    double misalignment_rad[6];
    /* Standard deviation of further misalignments, drawn from seed.
     * [0, 1] rad, default 0. No error until a datasheet says one. */
    double misalignment_sigma_rad;
    /* Hard iron: field of iron and currents that turn with the sensor.
     * [-1, 1] T, default 0, 0, 0. No error until a datasheet says one. */
    double hard_iron_tesla[3];
    /* Standard deviation of further hard iron, drawn from seed.
     * [0, 1] T, default 0. No error until a datasheet says one. */
    double hard_iron_sigma_tesla;
    /* Soft iron, 3 x 3 by rows: the field becomes (I + this) field; 0: none.
     * [-1, 1], default 0, 0, 0, 0, 0, 0, 0, 0, 0. No error until a datasheet says one. */
    double soft_iron[9];
    /* Standard deviation of further soft iron, drawn from seed.
     * [0, 1], default 0. No error until a datasheet says one. */
    double soft_iron_sigma;
    /* Readings end here; 0: unlimited.
     * [0, 1e6] T, default 0. Unlimited. */
    double range_tesla;
    /* Readings are multiples of this; 0: continuous.
     * [0, 1e6] T, default 0. Continuous. */
    double resolution_tesla;
} hnav_mag_options;

/* Faults work on samples stamped in [start_s, stop_s). An empty window: no fault. */
typedef struct hnav_sensor_faults {
    /* A field from outside. */
    struct {
        /* Start of the fault.
         * [-1e9, 1e9] s, default 0. The window is empty. */
        double start_s;
        /* End of the fault, excluded; not after the start: no fault.
         * [-1e9, 1e9] s, default 0. The window is empty. */
        double stop_s;
        /* Field added outside, in navigation axes.
         * [-1, 1] T, default 0, 0, 0. Nothing happens, even within the window. */
        double field_n_tesla[3];
        /* And this much in a direction drawn from seed.
         * [0, 1] T, default 0. Nothing happens, even within the window. */
        double strength_tesla;
    } mag_disturbance;

    /* Samples that are far off. */
    struct {
        /* Start of the fault.
         * [-1e9, 1e9] s, default 0. The window is empty. */
        double start_s;
        /* End of the fault, excluded; not after the start: no fault.
         * [-1e9, 1e9] s, default 0. The window is empty. */
        double stop_s;
        /* Probability of an outlier, for each sample of each sensor.
         * [0, 1], default 0. Nothing happens, even within the window. */
        double probability;
        /* Standard deviation of outliers of the gyroscope.
         * [0, 1e6] rad/s, default 0. Nothing happens, even within the window. */
        double gyro_sigma_rad_s;
        /* Standard deviation of outliers of the accelerometer.
         * [0, 1e6] m/s2, default 0. Nothing happens, even within the window. */
        double accel_sigma_m_s2;
        /* Standard deviation of outliers of the magnetometer.
         * [0, 1] T, default 0. Nothing happens, even within the window. */
        double mag_sigma_tesla;
    } outliers;

    /* An axis that repeats its last reading. */
    struct {
        /* Start of the fault.
         * [-1e9, 1e9] s, default 0. The window is empty. */
        double start_s;
        /* End of the fault, excluded; not after the start: no fault.
         * [-1e9, 1e9] s, default 0. The window is empty. */
        double stop_s;
        /* Sensor with an axis that repeats its last reading.
         * hnav_stuck_sensor, default none. Nothing happens, even within the window. */
        int32_t sensor;
        /* That axis.
         * [1, 3], default 1. The first. */
        int32_t axis;
    } stuck;

    /* A bias that comes and goes. */
    struct {
        /* Start of the fault.
         * [-1e9, 1e9] s, default 0. The window is empty. */
        double start_s;
        /* End of the fault, excluded; not after the start: no fault.
         * [-1e9, 1e9] s, default 0. The window is empty. */
        double stop_s;
        /* Added to the gyroscope.
         * [-1e6, 1e6] rad/s, default 0, 0, 0. Nothing happens, even within the window. */
        double gyro_rad_s[3];
        /* Added to the accelerometer.
         * [-1e6, 1e6] m/s2, default 0, 0, 0. Nothing happens, even within the window. */
        double accel_m_s2[3];
        /* Added to the magnetometer.
         * [-1, 1] T, default 0, 0, 0. Nothing happens, even within the window. */
        double mag_tesla[3];
    } bias_jump;

    /* More white noise. */
    struct {
        /* Start of the fault.
         * [-1e9, 1e9] s, default 0. The window is empty. */
        double start_s;
        /* End of the fault, excluded; not after the start: no fault.
         * [-1e9, 1e9] s, default 0. The window is empty. */
        double stop_s;
        /* Factor on the white noise of the gyroscope.
         * [0, 1e6], default 1. Nothing happens, even within the window. */
        double gyro_factor;
        /* Factor on the white noise of the accelerometer.
         * [0, 1e6], default 1. Nothing happens, even within the window. */
        double accel_factor;
        /* Factor on the white noise of the magnetometer.
         * [0, 1e6], default 1. Nothing happens, even within the window. */
        double mag_factor;
    } noise_increase;
} hnav_sensor_faults;

/* Options of the inertial and magnetic sensor, in the units of datasheets where the names say so. The defaults are sensors
 * without any error, 100 Hz.
 * Make them with hnav_imu_mag_sensor_defaults, then change what you need; hnav_option("imu_mag_sensor", i) states all this
 * at run time. */
typedef struct hnav_imu_mag_sensor_options {
    size_t size;    /* of this struct in bytes; set by hnav_imu_mag_sensor_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    /* ------------------------ chance
     * What is drawn at random. */

    /* Seed of everything random.
     * [0, 2147483647], default 0. Any seed is as good as any other. */
    int32_t seed;

    hnav_gyro_options gyro; /* gyroscope */

    hnav_accel_options accel; /* accelerometer */

    hnav_mag_options mag; /* magnetometer */

    hnav_sensor_faults fault; /* faults work on samples stamped in [start_s, stop_s). An empty window: no fault */
} hnav_imu_mag_sensor_options;

#endif /* HNAV_OPTIONS_IMU_MAG_SENSOR_H */
