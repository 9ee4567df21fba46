// The C boundary of the navigation filter: options, life, samples.
#include "c_api/ins_object.hpp"

#include "base/memory.hpp"
#include "c_api/engine_settings.hpp"
#include "maths/square.hpp"
#include "options/lists.hpp"

#include <new>

using namespace hnav;
using namespace hnav::ins_boundary;

namespace {

constexpr double max_time_s = 1e12, max_reading = 1e6;

const char* name_of(int sensor) {
    static constexpr const char* names[] = {"imu", "rest", "speed", "pressure", "velocity", "position", "heading", "mag"};
    static_assert(sizeof names / sizeof *names == HNAV_INS_SENSOR_COUNT);
    return names[sensor];
}
static_assert(int(ins::imu) == HNAV_INS_IMU && int(ins::field) == HNAV_INS_MAG);
static_assert(int(ins::channel_count) == HNAV_INS_SENSOR_COUNT);

// How many values a sample of a sensor has, and from which on they are sigmas.
struct Shape {
    int values, sigmas;
};
Shape shape_of(int sensor) {
    switch (sensor) {
    case ins::imu: return {6, 6};
    case ins::rest: return {1, 0};
    case ins::field: return {3, 3};
    case ins::velocity:
    case ins::position: return {6, 3};
    default: return {2, 1};
    }
}

hnav_status non_finite(hnav_ins* f, double t_s, int sensor, double value) {
    ++f->filter.refused.non_finite;
    return f->fail(HNAV_ERROR_NON_FINITE, "%s sample at t = %g s holds %g", name_of(sensor), t_s, value);
}

hnav_status out_of_range(hnav_ins* f, double t_s, int sensor, const char* what, double value, const char* wanted) {
    ++f->filter.refused.non_finite;
    return f->fail(HNAV_ERROR_OUT_OF_RANGE, "%s sample at t = %g s has a %s of %g: it must be %s", name_of(sensor), t_s, what,
                   value, wanted);
}

hnav_status check_numbers(hnav_ins* f, double t_s, int sensor, const double* value) {
    const Shape shape = shape_of(sensor);
    const bool no_vertical = sensor == ins::velocity && std::isnan(value[2]);
    for (int i = 0; i < shape.values; ++i) {
        if (no_vertical && i % 3 == 2) continue;
        if (!std::isfinite(value[i])) return non_finite(f, t_s, sensor, value[i]);
        if (std::fabs(value[i]) > max_reading) return out_of_range(f, t_s, sensor, "value", value[i], "within 1e6");
        if (i >= shape.sigmas && !(value[i] > 0)) return out_of_range(f, t_s, sensor, "sigma", value[i], "above 0");
    }
    return HNAV_OK;
}

hnav_status check_values(hnav_ins* f, double t_s, int sensor, const double* value) {
    if (const hnav_status status = check_numbers(f, t_s, sensor, value)) return status;
    if (sensor == ins::position && std::fabs(value[0]) > M_PI / 2)
        return out_of_range(f, t_s, sensor, "latitude", value[0], "in rad, -pi/2 to pi/2");
    if (sensor == ins::position && std::fabs(value[1]) > 2 * M_PI)
        return out_of_range(f, t_s, sensor, "longitude", value[1], "in rad, -2 pi to 2 pi");
    if (sensor == ins::pressure && !(value[0] > 2e3 && value[0] < 2e5))
        return out_of_range(f, t_s, sensor, "pressure", value[0], "in Pa, 2e3 to 2e5");
    if (sensor == ins::field && !(Vector3(value).squaredNorm() > 0)) {
        ++f->filter.refused.non_finite;
        return f->fail(HNAV_ERROR_ZERO_VECTOR, "mag sample at t = %g s is zero: leave it out while the sensor is off", t_s);
    }
    if (sensor == ins::pressure && value[1] > 1e3) return out_of_range(f, t_s, sensor, "sigma", value[1], "in Pa, at most 1e3");
    return HNAV_OK;
}

hnav_status put(hnav_ins* f, const ins::Sample& sample) {
    switch (f->filter.push(sample)) {
    case Outcome::ok: return HNAV_OK;
    case Outcome::late:
        return f->fail(HNAV_ERROR_LATE_SAMPLE, "%s sample at t = %.9g s is late: samples before %.9g s are closed",
                       name_of(sample.channel), sample.t_s, f->filter.late_limit_s());
    default:
        return f->fail(HNAV_ERROR_QUEUE_FULL,
                       "the queue is full: advance before pushing the %s sample at t = %.9g s, or raise queue_capacity",
                       name_of(sample.channel), sample.t_s);
    }
}

} // namespace

namespace hnav::ins_boundary {

hnav_status check_time(const hnav_ins* f, double t_s) {
    if (!std::isfinite(t_s)) return f->fail(HNAV_ERROR_NON_FINITE, "t_s = %g is not finite", t_s);
    if (std::fabs(t_s) > max_time_s) return f->fail(HNAV_ERROR_OUT_OF_RANGE, "t_s = %g lies beyond %g s", t_s, max_time_s);
    return HNAV_OK;
}

hnav_status sample_of(hnav_ins* f, double t_s, int sensor, const double* value, ins::Sample* sample) {
    if (const hnav_status status = check_time(f, t_s)) {
        ++f->filter.refused.non_finite;
        return status;
    }
    if (const hnav_status status = check_values(f, t_s, sensor, value)) return status;
    *sample = {std::fabs(t_s) < 1e-12 ? 0 : t_s, sensor, {}};
    for (int i = 0; i < shape_of(sensor).values; ++i) sample->value[i] = value[i];
    if (sensor == ins::imu) {
        const Vector3 rate = f->mounting * Vector3(value), force = f->mounting * Vector3(value + 3);
        for (int i = 0; i < 3; ++i) {
            sample->value[i] = rate[i];
            sample->value[3 + i] = force[i];
        }
    } else if (sensor == ins::field) {
        const Vector3 field = f->mounting * Vector3(value);
        for (int i = 0; i < 3; ++i) sample->value[i] = field[i];
    } else if (sensor == ins::heading) {
        sample->value[0] = wrap_angle(value[0] + f->declination_rad);
    }
    return HNAV_OK;
}

hnav_status push(hnav_ins* f, double t_s, int sensor, const double* value) {
    ins::Sample sample;
    const hnav_status status = sample_of(f, t_s, sensor, value, &sample);
    return status == HNAV_OK ? put(f, sample) : status;
}

hnav_status push_imu(hnav_ins* f, double t_s, const double* rate, const double* force) {
    const double value[6] = {rate[0], rate[1], rate[2], force[0], force[1], force[2]};
    return push(f, t_s, ins::imu, value);
}

hnav_status advance(hnav_ins* f, double t_s) {
    if (const hnav_status status = check_time(f, t_s)) return status;
    switch (f->filter.advance(std::fabs(t_s) < 1e-12 ? 0 : t_s)) {
    case Outcome::ok: return HNAV_OK;
    case Outcome::backwards:
        return f->fail(HNAV_ERROR_TIME_BACKWARDS, "t_s = %.9g s is before the last advance to %.9g s", t_s, f->filter.now_s());
    default: return f->fail(HNAV_ERROR_SOLVER, "samples up to t = %.9g s led to no usable estimate and were dropped", t_s);
    }
}

} // namespace hnav::ins_boundary

extern "C" {

hnav_ins_options hnav_ins_defaults(hnav_ins_preset preset) {
    hnav_ins_options options;
    set_defaults(ins_options, preset, &options);
    return options;
}
const hnav_option_info* hnav_ins_option(int32_t index) { return option_at(ins_options, index); }
const hnav_preset_info* hnav_ins_preset_info(int32_t index) { return preset_at(ins_options, index); }

hnav_status hnav_ins_create(hnav_ins** object, const hnav_ins_options* options, char* message, size_t message_size) {
    const CallersMessage caller{message, message_size};
    caller.clear();
    if (!object) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "ins is null");
    *object = nullptr;
    if (!options) return caller.fail(HNAV_ERROR_NULL_ARGUMENT, "options is null");
    if (const hnav_status status = caller.check_options(options, ins_options)) return status;
    for (const double* q : {options->start_q_nb, options->q_body_sensor})
        if (Quaternion(q).norm() < 0.1)
            return caller.fail(HNAV_ERROR_OPTION, "%s is no attitude: its length is below 0.1",
                               q == options->start_q_nb ? "start_q_nb" : "q_body_sensor");
    auto* made = make_object<hnav_ins>();
    if (made) {
        made->mounting = rotation_matrix(Quaternion(options->q_body_sensor).normalized());
        made->declination_rad = options->declination_rad;
        made->goes_back = options->horizon_s > 0;
        if (made->filter.create(ins::Model(*options), engine_settings<ins::Model>(*options, ins_options))) {
            *object = made;
            return HNAV_OK;
        }
        destroy_object(made);
    }
    return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for a filter with queue_capacity = %d", options->queue_capacity);
}

void hnav_ins_destroy(hnav_ins* object) { destroy_object(object); }

hnav_status hnav_ins_reset(hnav_ins* object) {
    if (!object) return HNAV_ERROR_NULL_ARGUMENT;
    object->filter.reset();
    object->flows_outside = false;
    return HNAV_OK;
}

const char* hnav_ins_message(const hnav_ins* object) { return object ? object->message : "ins is null"; }

hnav_status hnav_ins_push_imu(hnav_ins* object, double t_s, const double rate_b_rad_s[3], const double force_b_m_s2[3]) {
    REQUIRE(object, rate_b_rad_s);
    REQUIRE(object, force_b_m_s2);
    return push_imu(object, t_s, rate_b_rad_s, force_b_m_s2);
}

hnav_status hnav_ins_push_position(hnav_ins* object, double t_s, double latitude_rad, double longitude_rad, double height_m,
                                   const double sigma_n_m[3]) {
    REQUIRE(object, sigma_n_m);
    const double value[6] = {latitude_rad, longitude_rad, height_m, sigma_n_m[0], sigma_n_m[1], sigma_n_m[2]};
    return push(object, t_s, ins::position, value);
}

hnav_status hnav_ins_push_velocity(hnav_ins* object, double t_s, const double velocity_n_m_s[3], const double sigma_n_m_s[3]) {
    REQUIRE(object, velocity_n_m_s);
    REQUIRE(object, sigma_n_m_s);
    double value[6];
    for (int i = 0; i < 3; ++i) {
        value[i] = velocity_n_m_s[i];
        value[3 + i] = sigma_n_m_s[i];
    }
    return push(object, t_s, ins::velocity, value);
}

hnav_status hnav_ins_push_pressure(hnav_ins* object, double t_s, double pressure_pa, double sigma_pa) {
    if (!object) return HNAV_ERROR_NULL_ARGUMENT;
    const double value[6] = {pressure_pa, sigma_pa};
    return push(object, t_s, ins::pressure, value);
}

hnav_status hnav_ins_push_speed(hnav_ins* object, double t_s, double speed_m_s, double sigma_m_s) {
    if (!object) return HNAV_ERROR_NULL_ARGUMENT;
    const double value[6] = {speed_m_s, sigma_m_s};
    return push(object, t_s, ins::speed, value);
}

hnav_status hnav_ins_push_rest(hnav_ins* object, double t_s, double sigma_m_s) {
    if (!object) return HNAV_ERROR_NULL_ARGUMENT;
    const double value[6] = {sigma_m_s};
    return push(object, t_s, ins::rest, value);
}

hnav_status hnav_ins_push_heading(hnav_ins* object, double t_s, double heading_rad, double sigma_rad) {
    if (!object) return HNAV_ERROR_NULL_ARGUMENT;
    const double value[6] = {heading_rad, sigma_rad};
    return push(object, t_s, ins::heading, value);
}

hnav_status hnav_ins_push_mag(hnav_ins* object, double t_s, const double field_b[3]) {
    REQUIRE(object, field_b);
    const double value[6] = {field_b[0], field_b[1], field_b[2]};
    return push(object, t_s, ins::field, value);
}

hnav_status hnav_ins_advance(hnav_ins* object, double t_s) { return object ? advance(object, t_s) : HNAV_ERROR_NULL_ARGUMENT; }

} // extern "C"
