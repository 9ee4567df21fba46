// The C boundary of every filter: creation, samples, estimate. Every function checks its arguments, calls the object, and
// writes a one-line message on failure.
#include "c_api/filter_object.hpp"
#include "c_api/sized.hpp"

using hnav::hand_out;

const char* hnav::sensor_name(int sensor) {
    static constexpr const char* names[] = {"gyro", "accel",    "mag",      "heading", "speed",
                                            "rest", "pressure", "velocity", "position"};
    static_assert(sizeof names / sizeof *names == HNAV_SENSOR_COUNT);
    return names[sensor];
}

extern "C" {

void hnav_filter_destroy(hnav_filter* filter) {
    if (filter) filter->destroy();
}

hnav_status hnav_filter_reset(hnav_filter* filter) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    filter->reset();
    return HNAV_OK;
}

const char* hnav_filter_message(const hnav_filter* filter) { return filter ? filter->message : "filter is null"; }

// ------------------------------------------------------------------------------------------------ samples

hnav_status hnav_filter_push_gyro(hnav_filter* filter, double t_s, const double rate_b_rad_s[3]) {
    REQUIRE(filter, rate_b_rad_s);
    return filter->take(HNAV_SENSOR_GYRO, t_s, rate_b_rad_s);
}

hnav_status hnav_filter_push_accel(hnav_filter* filter, double t_s, const double force_b_m_s2[3]) {
    REQUIRE(filter, force_b_m_s2);
    return filter->take(HNAV_SENSOR_ACCEL, t_s, force_b_m_s2);
}

hnav_status hnav_filter_push_mag(hnav_filter* filter, double t_s, const double field_b_tesla[3]) {
    REQUIRE(filter, field_b_tesla);
    return filter->take(HNAV_SENSOR_MAG, t_s, field_b_tesla);
}

hnav_status hnav_filter_push_imu(hnav_filter* filter, double t_s, const double rate_b_rad_s[3], const double force_b_m_s2[3]) {
    REQUIRE(filter, rate_b_rad_s);
    REQUIRE(filter, force_b_m_s2);
    return filter->take_imu(t_s, rate_b_rad_s, force_b_m_s2);
}

hnav_status hnav_filter_push_heading(hnav_filter* filter, double t_s, double heading_rad, double sigma_rad) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    const double value[hnav::max_values] = {heading_rad, sigma_rad};
    return filter->take(HNAV_SENSOR_HEADING, t_s, value);
}

hnav_status hnav_filter_push_position(hnav_filter* filter, double t_s, double latitude_rad, double longitude_rad, double height_m,
                                      const double sigma_n_m[3]) {
    REQUIRE(filter, sigma_n_m);
    const double value[hnav::max_values] = {latitude_rad, longitude_rad, height_m, sigma_n_m[0], sigma_n_m[1], sigma_n_m[2]};
    return filter->take(HNAV_SENSOR_POSITION, t_s, value);
}

hnav_status hnav_filter_push_velocity(hnav_filter* filter, double t_s, const double velocity_n_m_s[3],
                                      const double sigma_n_m_s[3]) {
    REQUIRE(filter, velocity_n_m_s);
    REQUIRE(filter, sigma_n_m_s);
    const double value[hnav::max_values] = {velocity_n_m_s[0], velocity_n_m_s[1], velocity_n_m_s[2],
                                            sigma_n_m_s[0],    sigma_n_m_s[1],    sigma_n_m_s[2]};
    return filter->take(HNAV_SENSOR_VELOCITY, t_s, value);
}

hnav_status hnav_filter_push_pressure(hnav_filter* filter, double t_s, double pressure_pa, double sigma_pa) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    const double value[hnav::max_values] = {pressure_pa, sigma_pa};
    return filter->take(HNAV_SENSOR_PRESSURE, t_s, value);
}

hnav_status hnav_filter_push_speed(hnav_filter* filter, double t_s, double speed_m_s, double sigma_m_s) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    const double value[hnav::max_values] = {speed_m_s, sigma_m_s};
    return filter->take(HNAV_SENSOR_SPEED, t_s, value);
}

hnav_status hnav_filter_push_rest(hnav_filter* filter, double t_s, double sigma_m_s) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    const double value[hnav::max_values] = {sigma_m_s};
    return filter->take(HNAV_SENSOR_REST, t_s, value);
}

hnav_status hnav_filter_advance(hnav_filter* filter, double t_s) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    if (const hnav_status status = hnav::check_time(filter, t_s)) return status;
    return hnav::advanced(filter, t_s, filter->advance(hnav::clock_time(t_s)));
}

hnav_status hnav_filter_commit(hnav_filter* filter, double t_s) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    if (const hnav_status status = hnav::check_time(filter, t_s)) return status;
    return hnav::advanced(filter, t_s, filter->commit(hnav::clock_time(t_s)));
}

// ------------------------------------------------------------------------------------------------ estimate

hnav_status hnav_filter_attitude(const hnav_filter* filter, hnav_attitude* attitude) {
    REQUIRE_STRUCT(filter, attitude, hnav_attitude);
    hnav_attitude result{};
    if (const hnav_status status = filter->attitude(&result)) return status;
    return hand_out(result, attitude);
}

hnav_status hnav_filter_rate(const hnav_filter* filter, double rate_b_rad_s[3]) {
    REQUIRE(filter, rate_b_rad_s);
    return filter->rate(rate_b_rad_s);
}

hnav_status hnav_filter_gyro_bias(const hnav_filter* filter, double bias_b_rad_s[3], double sigma_rad_s[3]) {
    REQUIRE(filter, bias_b_rad_s);
    REQUIRE(filter, sigma_rad_s);
    return filter->gyro_bias(bias_b_rad_s, sigma_rad_s);
}

hnav_status hnav_filter_covariance(const hnav_filter* filter, double* covariance) {
    REQUIRE(filter, covariance);
    return filter->covariance(covariance);
}

hnav_status hnav_filter_innovation(const hnav_filter* filter, hnav_sensor sensor, hnav_innovation* innovation) {
    REQUIRE_STRUCT(filter, innovation, hnav_innovation);
    if (int(sensor) <= HNAV_SENSOR_GYRO || int(sensor) >= HNAV_SENSOR_COUNT)
        return filter->fail(HNAV_ERROR_OUT_OF_RANGE, "sensor %d has no innovation: use accel, mag or an aid", int(sensor));
    hnav_innovation result{};
    if (const hnav_status status = filter->innovation(sensor, &result)) return status;
    return hand_out(result, innovation);
}

hnav_status hnav_filter_diagnostics(const hnav_filter* filter, hnav_diagnostics* diagnostics) {
    REQUIRE_STRUCT(filter, diagnostics, hnav_diagnostics);
    hnav_diagnostics result{};
    filter->diagnostics(&result);
    return hand_out(result, diagnostics);
}

hnav_status hnav_filter_health(const hnav_filter* filter, hnav_health* health) {
    REQUIRE_STRUCT(filter, health, hnav_health);
    hnav_health result{};
    filter->health(&result);
    return hand_out(result, health);
}

} // extern "C"
