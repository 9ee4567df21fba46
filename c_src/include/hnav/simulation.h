/* hnav simulation: true motion and sensor models as inputs of filters. Conventions, status codes and promises are those of hnav.h,
 * except stability: names here may change between minor versions.
 *
 * Noise is a function of seed, source and sample: equal seeds give equal runs on one machine, whatever else is
 * simulated. */
#ifndef HNAV_SIMULATION_H
#define HNAV_SIMULATION_H

#include "hnav/ahrs.h"
#include "hnav/ins_error.h"
#include "hnav/options/aid_sensor.h"
#include "hnav/options/aircraft.h"
#include "hnav/options/imu_mag_sensor.h"
#include "hnav/options/turntable.h"
#include "hnav/options/vehicle.h"
#include "hnav/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------ aircraft with an INS
 *
 * A linear aircraft whose states an INS reads with white noise v and time-correlated errors lambda:
 *
 *     dx/dt = A x + B u + w                    u held from sample to sample
 *     z(k) = x(k) + v(k) + lambda(k)           k = 0, 1, ... at the times k interval_s
 *
 * lambda is the sum of two first-order Gauss-Markov errors, of the accelerometers and of the gravity model. Units are
 * the model's. Source: Hajiyev and Hacizade, WSEAS Trans. Systems and Control 18, 2023, doi 10.37394/23203.2023.18.51.
 *
 *     hnav_aircraft *aircraft;
 *     hnav_aircraft_options options = hnav_aircraft_defaults();
 *     hnav_aircraft_create(&aircraft, &options, &model, message, sizeof message);
 *     for (;;) {
 *         hnav_aircraft_get_sample(aircraft, &sample);
 *         hnav_aircraft_step(aircraft, NULL);
 *     } */
typedef struct hnav_aircraft hnav_aircraft;

typedef struct hnav_gauss_markov { /* stationary, one process for each channel */
    const double* sigma; /* nx, standard deviations, >= 0; null: none */
    const double* time_constant_s; /* nx, above 0; not read when sigma is null */
} hnav_gauss_markov;

typedef struct hnav_square_wave { /* amplitude times the sign of sin(2 pi t / period + phase) */
    double amplitude;
    double period_s; /* above 0 */
    double phase_rad;
} hnav_square_wave;

typedef struct hnav_noise_fault { /* samples from start_s to stop_s, both included */
    double start_s, stop_s;
    double factor; /* on the standard deviation of v, >= 0; 1: no fault */
} hnav_noise_fault;

/* Row-major, owned by the caller, copied by create. */
typedef struct hnav_aircraft_model {
    size_t size; /* of this struct; set by the caller */
    int32_t nx, nu; /* 1 to 32, 0 to 32 */
    double interval_s; /* between samples, above 0 */
    const double* A_1_s; /* nx x nx; no eigenvalue with a real part above 1e-9 1/s */
    const double* B_1_s; /* nx x nu; not read when nu = 0 */
    const double* process_noise_per_sqrt_s; /* nx, standard deviations of w per root second, >= 0 */
    const double* measurement_sigma; /* nx, of v, >= 0 */
    hnav_gauss_markov accelerometer_error, gravity_error;
    const double* start; /* nx, mean of x(0); null: zero */
    const double* start_sigma; /* nx, >= 0 */
    const hnav_square_wave* commands; /* nu, added to the commands of step; null: none */
    const hnav_noise_fault* faults; /* nx; null: none */
} hnav_aircraft_model;

HNAV_API hnav_aircraft_options hnav_aircraft_defaults(void);

/* Refused, with a message that names the entry: sizes out of range (SIZE), null (NULL_ARGUMENT) or non-finite
 * (NON_FINITE) entries; numbers out of range, an A that grows, dt/tau of 2 or more in Euler's form (all OPTION). */
HNAV_API hnav_status hnav_aircraft_create(hnav_aircraft** aircraft, const hnav_aircraft_options* options,
                                          const hnav_aircraft_model* model, char* message, size_t message_size);
/* Null is allowed. */
HNAV_API void hnav_aircraft_destroy(hnav_aircraft* aircraft);
/* Restores sample 0 of the same flight. */
HNAV_API hnav_status hnav_aircraft_reset(hnav_aircraft* aircraft);
/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char* hnav_aircraft_message(const hnav_aircraft* aircraft);

/* To the next sample; command (nu, null for zero) is held meanwhile. Error: NON_FINITE; nothing is changed. */
HNAV_API hnav_status hnav_aircraft_step(hnav_aircraft* aircraft, const double* command);

/* Of the present sample; null pointers are not written. */
typedef struct hnav_aircraft_sample {
    size_t size; /* of this struct; set by the caller */
    uint64_t k; /* counted from 0 */
    double t_s; /* k interval_s */
    double* x; /* nx, truth */
    double* lambda; /* nx, coloured error, both parts */
    double* z; /* nx, measurement */
    double* u; /* nu, controls that were held up to this sample; zero at k = 0 */
    double* noise_factor; /* nx, on the standard deviation of v; 1 without fault */
} hnav_aircraft_sample;
HNAV_API hnav_status hnav_aircraft_get_sample(const hnav_aircraft* aircraft, hnav_aircraft_sample* sample);

/* n samples from the present one on, each a row: command n x nu (null for zero), row k held from sample k to k + 1;
 * arrays of output hold n rows each, k and t_s those of the last. Afterwards the sample after the last row is present. */
HNAV_API hnav_status hnav_aircraft_run(hnav_aircraft* aircraft, size_t n, const double* command, hnav_aircraft_sample* output);

/* The discrete model for hnav_ins_error_filter_create; its pointers belong to the aircraft and live as long. lambda of
 * the filter is the accelerometer error alone: a sum of two such processes is none. */
HNAV_API hnav_status hnav_aircraft_filter_model(const hnav_aircraft* aircraft, hnav_ins_error_model* model);

/* Numbers only; fits aircraft made with equal options and model. */
HNAV_API hnav_status hnav_aircraft_state_size(const hnav_aircraft* aircraft, size_t* bytes);
HNAV_API hnav_status hnav_aircraft_save(const hnav_aircraft* aircraft, void* buffer, size_t bytes);
/* SIZE, STATE_CORRUPT, STATE_VERSION: the aircraft is as it was. */
HNAV_API hnav_status hnav_aircraft_load(hnav_aircraft* aircraft, const void* buffer, size_t bytes);

/* ------------------------------------------------------------------------------------------------ truth
 *
 * What a body does and what error-free sensors at its centre would read. */
typedef struct hnav_truth {
    size_t size; /* of this struct; set by the caller */
    double t_s;
    double q_nb[4]; /* body to north-east-down of true north, scalar first */
    double euler_rad[3]; /* roll, pitch, yaw (rotation order z y x) */
    double rate_b_rad_s[3]; /* of the body against the navigation frame */
    double force_b_m_s2[3]; /* specific force */
    double field_b_tesla[3];
} hnav_truth;

/* For plants whose attitude an integrator outside holds. Errors: NULL_ARGUMENT. */
/* Roll, pitch, yaw (rotation order z y x) in rad, 3, of the unit quaternion q_nb, 4. */
/* The derivative of roll, pitch and yaw along dq_nb, a direction of the unit quaternion q_nb; that of pitch is 0 where it is
 * 90 degrees. */
HNAV_API hnav_status hnav_quaternion_to_euler_along(const double* q_nb, const double* dq_nb, double* along_rad);
HNAV_API hnav_status hnav_quaternion_to_euler(const double* q_nb, double* euler_rad);
/* q' = 1/2 q (x) (0, rate), 4, in 1/s: how q_nb, 4, of any length, flows at the body rate, 3. */
HNAV_API hnav_status hnav_quaternion_derivative(const double* q_nb, const double* rate_b_rad_s, double* derivative_1_s);

/* ------------------------------------------------------------------------------------------------ turntable
 *
 * Three axes, yaw outermost, roll innermost, each with a motion of its own in closed form. The body turns about its
 * centre: specific force is gravity alone. The rate is right-continuous where a motion has corners.
 *
 *     hnav_turntable *table;
 *     hnav_turntable_options options = hnav_turntable_defaults();
 *     hnav_turntable_create(&table, &options, message, sizeof message);
 *     hnav_turntable_at(table, t_s, &truth); */
typedef struct hnav_turntable hnav_turntable;

HNAV_API hnav_turntable_options hnav_turntable_defaults(void);

/* On failure *table is null and message (may be null) has the reason. */
HNAV_API hnav_status hnav_turntable_create(hnav_turntable** table, const hnav_turntable_options* options, char* message,
                                           size_t message_size);
/* Null is allowed. */
HNAV_API void hnav_turntable_destroy(hnav_turntable* table);
/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char* hnav_turntable_message(const hnav_turntable* table);

HNAV_API hnav_status hnav_turntable_at(const hnav_turntable* table, double t_s, hnav_truth* truth);
/* The next corner after t_s, where a rate jumps; infinity if there is none. */
HNAV_API hnav_status hnav_turntable_next_corner_s(const hnav_turntable* table, double t_s, double* corner_s);
/* For an integrator that steps across corners before it locates them: truth at t_s if the motion of piece_s continues
 * without a corner. */
HNAV_API hnav_status hnav_turntable_in_piece(const hnav_turntable* table, double piece_s, double t_s, hnav_truth* truth);
/* Specific force and field (3 each) as measured by a body with the attitude q_nb (normalised on use). */
HNAV_API hnav_status hnav_turntable_seen_from(const hnav_turntable* table, const double* q_nb, double* force_b_m_s2,
                                              double* field_b_tesla);

/* ------------------------------------------------------------------------------------------------ inertial and magnetic sensor
 *
 * Gyroscope, accelerometer and magnetometer by their datasheets. Each of them samples truth at its period, index
 * k = 0, 1, ... from start_s:
 *
 *     reading = quantise( (I + scale factor + misalignment) x  + turn-on bias + drift t + bias instability
 *                         + random walk + white noise )
 *     x       = rate + g-sensitivity force | force | (I + soft iron) field + hard iron
 *
 * A sample that is due is taken at the next communication point and stamped with the time of that point; it is delivered
 * latency_s later. Noise belongs to k: neither communication steps nor the other sensors change it. Noise terms after
 * IEEE Std 952 and 1139: a white density N gives samples of variance N^2/period; bias instability is flicker noise,
 * given by the floor of the Allan deviation and made of eight first-order Gauss-Markov processes with correlation times
 * 1/4, 1, ..., 4096 s, so the floor is flat within 5 % from 2 s to 1000 s; the random walk has variance K^2 t.
 * Each option that ends in _sigma is drawn once from seed, zero mean normal.
 *
 *     hnav_imu_mag_sensor_sample(sensor, t_s, &truth);
 *     hnav_imu_mag_sensor_advance(sensor, t_s);
 *     hnav_imu_mag_sensor_reading(sensor, HNAV_SENSOR_GYRO, &reading); */
typedef struct hnav_imu_mag_sensor hnav_imu_mag_sensor;

HNAV_API hnav_imu_mag_sensor_options hnav_imu_mag_sensor_defaults(void);

HNAV_API hnav_status hnav_imu_mag_sensor_create(hnav_imu_mag_sensor** sensor, const hnav_imu_mag_sensor_options* options,
                                                double start_s, char* message, size_t message_size);
/* Null is allowed. */
HNAV_API void hnav_imu_mag_sensor_destroy(hnav_imu_mag_sensor* sensor);
/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char* hnav_imu_mag_sensor_message(const hnav_imu_mag_sensor* sensor);
/* Restores the state after create. */
HNAV_API hnav_status hnav_imu_mag_sensor_reset(hnav_imu_mag_sensor* sensor);

/* A communication point: due sensors sample the truth with the stamp t_s; of several due samples the newest is taken and the
 * others are missed. A second call at t_s takes nothing. Errors, nothing is taken: NON_FINITE; OUT_OF_RANGE (a number
 * beyond 1e12); ZERO_VECTOR when q_nb is shorter than 0.5, as before a simulation has passed a truth on. */
HNAV_API hnav_status hnav_imu_mag_sensor_sample(hnav_imu_mag_sensor* sensor, double t_s, const hnav_truth* truth);
/* Delivers the samples that have arrived by t_s. */
HNAV_API hnav_status hnav_imu_mag_sensor_advance(hnav_imu_mag_sensor* sensor, double t_s);
/* Time at which the next sample is due or delivered. */
HNAV_API hnav_status hnav_imu_mag_sensor_next_event_s(const hnav_imu_mag_sensor* sensor, double* next_s);

typedef struct hnav_reading {
    size_t size; /* of this struct; set by the caller */
    double value[3]; /* rad/s, m/s2 or T */
    double t_meas_s; /* when it was sampled */
    uint64_t count; /* samples delivered so far; 0: none, the rest is zero */
    uint64_t missed; /* samples that the distance of the communication points lost */
    uint64_t dropped; /* samples taken that are never delivered */
} hnav_reading;
/* sensor_kind: GYRO, ACCEL or MAG. */
HNAV_API hnav_status hnav_imu_mag_sensor_reading(const hnav_imu_mag_sensor* sensor, hnav_sensor sensor_kind,
                                                 hnav_reading* reading);
/* Two-sided spectral density of the white noise: rad2/s, m2/s3 or T2 s. */
HNAV_API hnav_status hnav_imu_mag_sensor_noise_psd(const hnav_imu_mag_sensor* sensor, hnav_sensor sensor_kind, double* psd);

/* Numbers only; fits sensors made with equal options and start. */
HNAV_API hnav_status hnav_imu_mag_sensor_state_size(const hnav_imu_mag_sensor* sensor, size_t* bytes);
HNAV_API hnav_status hnav_imu_mag_sensor_save(const hnav_imu_mag_sensor* sensor, void* buffer, size_t bytes);
/* Errors: SIZE, STATE_CORRUPT, STATE_VERSION; the sensor is then unchanged. */
HNAV_API hnav_status hnav_imu_mag_sensor_load(hnav_imu_mag_sensor* sensor, const void* buffer, size_t bytes);

/* ------------------------------------------------------------------------------------------------ vehicles
 *
 * A car, an aircraft, a ship or a body at rest over the turning Earth. The motion is drawn from the seed: levels of speed, turn and
 * bank, each held for a random time, with soft edges; the kind way is given by points. All quantities except position and course are
 * functions of time. Position and course are integrated by hnav_vehicle_carry or outside. For paths within a quarter of the globe.
 *
 *     double x[HNAV_VEHICLE_STATES];
 *     hnav_vehicle_start(vehicle, x);
 *     hnav_vehicle_carry(vehicle, start_s, x, t_s);
 *     hnav_vehicle_at(vehicle, t_s, x, &truth); */
typedef struct hnav_vehicle hnav_vehicle;

typedef struct hnav_vehicle_truth {
    size_t size; /* of this struct; set by the caller */
    double t_s;
    double latitude_rad, longitude_rad, height_m; /* above the ellipsoid of WGS 84 */
    double velocity_n_m_s[3]; /* north, east, down, over the ground */
    double q_nb[4]; /* body to north-east-down of true north, scalar first */
    double euler_rad[3]; /* roll, pitch, yaw (rotation order z y x) */
    double rate_b_rad_s[3]; /* relative to inertial axes: includes the Earth's rate and the transport rate */
    double force_b_m_s2[3]; /* specific force */
    double field_b_tesla[3];
} hnav_vehicle_truth;

/* Displacement from the start in Earth-centred, Earth-fixed axes, m, and course in level axes that move with the vehicle, rad. */
#define HNAV_VEHICLE_STATES 4

HNAV_API hnav_vehicle_options hnav_vehicle_defaults(void);

/* On failure *vehicle is null and message (may be null) has the reason. start_s: of the motion. */
HNAV_API hnav_status hnav_vehicle_create(hnav_vehicle** vehicle, const hnav_vehicle_options* options, double start_s,
                                         char* message, size_t message_size);

/* A point of the kind way: displacement from the start along north and east there, and height above the start. Heights follow the
 * ellipsoid, also far from the start. */
typedef struct hnav_way_point {
    double t_s; /* since the start of the motion */
    double north_m, east_m, up_m;
} hnav_way_point;
/* Displacement of a place from a start: sets all fields except the time. Places are latitude, longitude in rad, height in m.
 * Errors: NULL_ARGUMENT, NON_FINITE, OUT_OF_RANGE (farther than a quarter of the globe). */
HNAV_API hnav_status hnav_way_point_at(const double start[3], const double place[3], hnav_way_point* point);
/* The same for the kind way. The vehicle passes the points at their times, with continuous velocity and acceleration; at a repeated point
 * it rests and keeps its direction. Before the first point and after the last it moves straight on. n: 2 or more, whose times
 * grow by 1e-3 s or more, within 1e6 m. OPTION, beside those of create: points that cannot be passed, with the
 * number of the point; a path that reverses or climbs straight up has no heading there. The points are copied. */
HNAV_API hnav_status hnav_vehicle_create_along(hnav_vehicle** vehicle, const hnav_vehicle_options* options, double start_s,
                                               const hnav_way_point* points, size_t n, char* message, size_t message_size);
/* Null is allowed. */
HNAV_API void hnav_vehicle_destroy(hnav_vehicle* vehicle);
/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char* hnav_vehicle_message(const hnav_vehicle* vehicle);

/* x: HNAV_VEHICLE_STATES numbers. Errors of all of them: NON_FINITE, OUT_OF_RANGE (more than a second before the start, or a number of
 * x beyond 1e8). */
HNAV_API hnav_status hnav_vehicle_start(const hnav_vehicle* vehicle, double* x);
/* x at from_s becomes x at to_s, later or earlier, to a rounding of the way; by a fixed step of 1/32 s or less. */
HNAV_API hnav_status hnav_vehicle_carry(const hnav_vehicle* vehicle, double from_s, double* x, double to_s);
HNAV_API hnav_status hnav_vehicle_flow(const hnav_vehicle* vehicle, double t_s, const double* x, double* dx_dt);
HNAV_API hnav_status hnav_vehicle_at(const hnav_vehicle* vehicle, double t_s, const double* x, hnav_vehicle_truth* truth);

/* ------------------------------------------------------------------------------------------------ aids
 *
 * A GNSS receiver, a barometer, or wheels in a vehicle. It samples the truth at its period, index k = 0, 1, ... from start_s; a
 * sample that is due is taken at the next communication point and stamped with the time of that point, it is delivered latency_s later.
 * Noise belongs to k: neither communication steps nor other sensors change it. Errors are white noise with a stated sigma, and a slow
 * error that is not stated (first-order Gauss-Markov); the scale factor of wheels and the weather are drawn once.
 *
 *     hnav_aid_sensor_sample(sensor, t_s, &truth);
 *     hnav_aid_sensor_advance(sensor, t_s);
 *     hnav_aid_sensor_reading(sensor, &reading); */
typedef struct hnav_aid_sensor hnav_aid_sensor;

typedef enum hnav_aid_sensor_kind { HNAV_AID_GNSS = 0, HNAV_AID_BARO = 1, HNAV_AID_WHEEL = 2 } hnav_aid_sensor_kind;

HNAV_API hnav_aid_sensor_options hnav_aid_sensor_defaults(void);

/* Of the options those of the kind's group count. On failure *sensor is null and message (may be null) has the reason. */
HNAV_API hnav_status hnav_aid_sensor_create(hnav_aid_sensor** sensor, hnav_aid_sensor_kind kind,
                                            const hnav_aid_sensor_options* options, double start_s, char* message,
                                            size_t message_size);
/* Null is allowed. */
HNAV_API void hnav_aid_sensor_destroy(hnav_aid_sensor* sensor);
/* Text of the last failure of this object, "" if there was none; valid until the next call on it. */
HNAV_API const char* hnav_aid_sensor_message(const hnav_aid_sensor* sensor);
/* Restores the state after create. */
HNAV_API hnav_status hnav_aid_sensor_reset(hnav_aid_sensor* sensor);

/* A communication point: a due sample is taken; of several the newest, and the others are missed. A second call at t_s takes
 * nothing. Uses place, velocity, attitude and rate of the truth. Errors, nothing is taken: NON_FINITE; OUT_OF_RANGE (a number
 * beyond 1e12); ZERO_VECTOR when q_nb is shorter than 0.5, as before a simulation has passed a truth on. */
HNAV_API hnav_status hnav_aid_sensor_sample(hnav_aid_sensor* sensor, double t_s, const hnav_vehicle_truth* truth);
/* Delivers the samples that have arrived by t_s. */
HNAV_API hnav_status hnav_aid_sensor_advance(hnav_aid_sensor* sensor, double t_s);
/* Time at which the next sample is due or delivered. */
HNAV_API hnav_status hnav_aid_sensor_next_event_s(const hnav_aid_sensor* sensor, double* next_s);

typedef struct hnav_aid_reading {
    size_t size; /* of this struct; set by the caller */
    double value[6]; /* latitude, longitude in rad, height in m, velocity north, east, down in m/s | Pa | m/s; the rest is 0 */
    double sigma[6]; /* as stated; north, east, down for the place */
    double t_meas_s; /* as stamped */
    uint64_t count; /* samples delivered so far; 0: none, value and t_meas_s are zero */
    uint64_t missed; /* samples that the distance of the communication points lost */
    uint64_t dropped; /* samples taken that are never delivered; those of an outage are not counted */
    int32_t valid; /* there is a sample, and no outage since */
    int32_t reserved; /* 0 */
} hnav_aid_reading;
HNAV_API hnav_status hnav_aid_sensor_reading(const hnav_aid_sensor* sensor, hnav_aid_reading* reading);

/* Numbers only; fits sensors made with equal kind, options and start. */
HNAV_API hnav_status hnav_aid_sensor_state_size(const hnav_aid_sensor* sensor, size_t* bytes);
HNAV_API hnav_status hnav_aid_sensor_save(const hnav_aid_sensor* sensor, void* buffer, size_t bytes);
/* Errors: SIZE, STATE_CORRUPT, STATE_VERSION; the sensor is then unchanged. */
HNAV_API hnav_status hnav_aid_sensor_load(hnav_aid_sensor* sensor, const void* buffer, size_t bytes);

#ifdef __cplusplus
}
#endif
#endif
