// The C boundary of the INS: creation and samples.
#include "c_api/ins_object.hpp"

#include "base/memory.hpp"
#include "c_api/engine_settings.hpp"
#include "maths/square.hpp"
#include "options/lists.hpp"

#include <new>

using namespace hnav;
using namespace hnav::ins_boundary;

namespace {

constexpr double max_reading = 1e6;

const char* name_of(int channel) {
    static constexpr const char* names[] = {"imu", "rest", "speed", "pressure", "velocity", "position", "heading", "mag"};
    static_assert(sizeof names / sizeof *names == ins::channel_count);
    return names[channel];
}

// Number of values of a sample of a sensor, and the index of the first sigma.
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

hnav_status out_of_range(const InsObject* f, double t_s, int sensor, const char* what, double value, const char* wanted) {
    return f->fail(HNAV_ERROR_OUT_OF_RANGE, "%s sample at t = %g s has a %s of %g: it must be %s", name_of(sensor), t_s, what,
                   value, wanted);
}

hnav_status check_numbers(const InsObject* f, double t_s, int sensor, const double* value) {
    const Shape shape = shape_of(sensor);
    const bool no_vertical = sensor == ins::velocity && std::isnan(value[2]);
    for (int i = 0; i < shape.values; ++i) {
        if (no_vertical && i % 3 == 2) continue;
        if (!std::isfinite(value[i]))
            return f->fail(HNAV_ERROR_NON_FINITE, "%s sample at t = %g s holds %g", name_of(sensor), t_s, value[i]);
        if (std::fabs(value[i]) > max_reading) return out_of_range(f, t_s, sensor, "value", value[i], "within 1e6");
        if (sensor == ins::imu && i < 3 && std::fabs(value[i]) > max_rate_rad_s)
            return out_of_range(f, t_s, sensor, "rate", value[i], "within 1e4 rad/s");
        if (i >= shape.sigmas && !(value[i] > 0)) return out_of_range(f, t_s, sensor, "sigma", value[i], "above 0");
    }
    return HNAV_OK;
}

hnav_status check_values(const InsObject* f, double t_s, int sensor, const double* value) {
    if (const hnav_status status = check_time(f, t_s)) return status;
    if (const hnav_status status = check_numbers(f, t_s, sensor, value)) return status;
    if (sensor == ins::position && std::fabs(value[0]) > M_PI / 2)
        return out_of_range(f, t_s, sensor, "latitude", value[0], "in rad, -pi/2 to pi/2");
    if (sensor == ins::position && std::fabs(value[1]) > 2 * M_PI)
        return out_of_range(f, t_s, sensor, "longitude", value[1], "in rad, -2 pi to 2 pi");
    if (sensor == ins::pressure && !(value[0] > 2e3 && value[0] < 2e5))
        return out_of_range(f, t_s, sensor, "pressure", value[0], "in Pa, 2e3 to 2e5");
    if (sensor == ins::field && !(Vector3(value).squaredNorm() > 0))
        return f->fail(HNAV_ERROR_ZERO_VECTOR, "mag sample at t = %g s is zero: leave it out while the sensor is off", t_s);
    if (sensor == ins::pressure && value[1] > 1e3) return out_of_range(f, t_s, sensor, "sigma", value[1], "in Pa, at most 1e3");
    return HNAV_OK;
}

} // namespace

namespace hnav::ins_boundary {

int channel_of(int sensor) {
    static constexpr int channels[] = {ins::imu,  ins::imu,      ins::field,    ins::heading, ins::speed,
                                       ins::rest, ins::pressure, ins::velocity, ins::position};
    static_assert(sizeof channels / sizeof *channels == HNAV_SENSOR_COUNT);
    return channels[sensor];
}

hnav_status sample_of(InsObject* f, double t_s, int sensor, const double* value, ins::Sample* sample) {
    if (const hnav_status status = check_values(f, t_s, sensor, value)) {
        ++f->filter.refused.non_finite;
        return status;
    }
    *sample = {clock_time(t_s), sensor, {}};
    const int values = shape_of(sensor).values;
    copy(value, values, sample->value);
    if (sensor == ins::imu || sensor == ins::field)
        for (int i = 0; i < values; i += 3) store(Vector3(f->mounting * Vector3(value + i)), sample->value + i);
    if (sensor == ins::heading) sample->value[0] = wrap_angle(value[0] + f->declination_rad);
    return HNAV_OK;
}

} // namespace hnav::ins_boundary

namespace hnav {

hnav_status InsObject::take(int sensor, double t_s, const double* value) {
    if (sensor == HNAV_SENSOR_GYRO || sensor == HNAV_SENSOR_ACCEL)
        return fail(HNAV_ERROR_UNSUPPORTED, "the INS takes rate and force of one instant together: hnav_filter_push_imu");
    return push(t_s, channel_of(sensor), value);
}

hnav_status InsObject::take_imu(double t_s, const double* rate, const double* force) {
    const double value[max_values] = {rate[0], rate[1], rate[2], force[0], force[1], force[2]};
    return push(t_s, ins::imu, value);
}

hnav_status InsObject::push(double t_s, int channel, const double* value) {
    ins::Sample sample;
    if (const hnav_status status = sample_of(this, t_s, channel, value, &sample)) return status;
    return queued(this, filter.push(sample), name_of(channel), sample.t_s, filter.late_limit_s());
}

void InsObject::destroy() { destroy_object(this); }

void InsObject::reset() {
    filter.reset();
    flows_outside = false;
}

} // namespace hnav

extern "C" {

hnav_ins_options hnav_ins_defaults(hnav_ins_preset preset) { return made_from<hnav_ins_options>(ins_options, preset); }

hnav_status hnav_ins_create(hnav_filter** object, const hnav_ins_options* options, char* message, size_t message_size) {
    const CallersMessage caller{message, message_size};
    if (const hnav_status status = check_creation(caller, object, options, ins_options)) return status;
    const ins::Model model(*options);
    const auto settings = engine_settings<ins::Model>(*options, ins_options);
    if (const hnav_status status = check_memory(caller, model, settings, options->queue_capacity)) return status;
    auto* made = make_object<InsObject>();
    if (made) {
        made->mounting = rotation_matrix(Quaternion(options->q_body_sensor).normalized());
        made->declination_rad = options->declination_rad;
        made->goes_back = options->horizon_s > 0;
        if (made->filter.create(model, settings)) {
            *object = made;
            return HNAV_OK;
        }
        destroy_object(made);
    }
    return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for a filter with queue_capacity = %d", options->queue_capacity);
}

} // extern "C"
