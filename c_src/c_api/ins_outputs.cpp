// The C boundary of the INS: its outputs, and whole recordings.
#include "c_api/ins_object.hpp"

#include "c_api/health.hpp"
#include "maths/repair.hpp"

using namespace hnav;
using namespace hnav::ins_boundary;

namespace {

hnav_status not_started(const InsObject* f) {
    return f->fail(HNAV_ERROR_NOT_STARTED, "no tilt yet: the start waits for samples and a fix");
}

void fill_motion(const ins::Motion& n, hnav_navigation* out) {
    out->latitude_rad = n.place.latitude_rad;
    out->longitude_rad = n.place.longitude_rad;
    out->height_m = n.place.height_m;
    store(n.velocity_n, out->velocity_n_m_s);
    store(n.q_nb, out->q_nb);
    store(roll_pitch_yaw(n.q_nb), out->euler_rad);
    store(n.position_e, out->position_e_m);
    store(n.velocity_e, out->velocity_e_m_s);
}

void fill_state(const ins::State& s, hnav_navigation* out) {
    store(Vector3(s.gyro_bias), out->gyro_bias_rad_s);
    store(Vector3(s.accel_bias), out->accel_bias_m_s2);
    store(Vector3(ins::mat(s.gyro_axes).diagonal()), out->gyro_scale);
    for (int i = 0; i < 3; ++i) {
        const auto sigma = [&](int row) { return std::sqrt(std::fmax(0, s.P[ins::packed(row, row)])); };
        out->sigma_gyro_bias_rad_s[i] = sigma(ins::row_gyro + i);
        out->sigma_accel_bias_m_s2[i] = sigma(ins::row_accel + i);
        out->sigma_gyro_scale[i] = sigma(ins::row_axes + 4 * i);
    }
    out->latency_s = s.latency;
    out->sigma_latency_s = std::sqrt(std::fmax(0, s.P[ins::packed(ins::row_latency, ins::row_latency)]));
}

// Samples that push refuses for their value or age are counted, and the recording continues without them, as a stream does.
hnav_status tolerated(hnav_status status) { return status == HNAV_ERROR_QUEUE_FULL ? status : HNAV_OK; }

// The IMU sample first: a row with a rejected or late stamp has no time, and its aids are not used.
hnav_status take_row(InsObject* f, const hnav_ins_run_input& in, std::size_t i, std::size_t* aid) {
    using Place = std::decay_t<decltype(f->filter.stamps())>::Place;
    hnav_status status = HNAV_OK;
    const double *rate = in.rate_b_rad_s + 3 * i, *force = in.force_b_m_s2 + 3 * i;
    const double* received_s = in.aid_received_s ? in.aid_received_s : in.aid_t_s;
    if (!is_missing(rate) && !is_missing(force)) {
        status = f->take_imu(in.t_s[i], rate, force);
        const bool left_out = status == HNAV_OK && f->filter.stamps().last() == Place::left_out;
        if (left_out || status == HNAV_ERROR_LATE_SAMPLE) return HNAV_OK;
        status = tolerated(status);
    }
    for (; *aid < in.aids && received_s[*aid] <= in.t_s[i] && status == HNAV_OK; ++*aid) {
        if (const hnav_status none = check_aid(f, in, *aid)) return none;
        status = tolerated(f->take(in.aid_sensor[*aid], in.aid_t_s[*aid], in.aid_value + max_values * *aid));
    }
    if (status == HNAV_OK) status = check_time(f, in.t_s[i]);
    return status == HNAV_OK ? advanced(f, in.t_s[i], f->filter.advance_or_stay(clock_time(in.t_s[i]))) : status;
}

// All outputs except the motion, the only continuous states under an external integrator.
struct Shown {
    const ins::State& state;
    double ahead_s; // beyond its last event
};

Shown shown_of(const InsObject* f) {
    if (f->flows_outside) return {f->filter.newest(), 0};
    return {f->filter.shown(), f->filter.looked_ahead_s()};
}

} // namespace

namespace hnav::ins_boundary {

hnav_status check_aid(const InsObject* f, const hnav_ins_run_input& in, std::size_t i) {
    const int sensor = in.aid_sensor[i];
    if (sensor >= HNAV_SENSOR_MAG && sensor < HNAV_SENSOR_COUNT) return HNAV_OK;
    return f->fail(HNAV_ERROR_OUT_OF_RANGE, "aid %zu: sensor %d is none", i, sensor);
}

void fill(const ins::Navigation& n, hnav_navigation* out) {
    fill_motion(n, out);
    store(n.sigma_position, out->sigma_position_m);
    store(n.sigma_velocity, out->sigma_velocity_m_s);
    store(n.sigma_rotation, out->sigma_rotation_rad);
    out->heading_second_rad = n.circle.second_rad;
    out->heading_second_share = n.circle.second_share;
    out->protection_m[0] = n.protection.horizontal_m;
    out->protection_m[1] = n.protection.vertical_m;
    out->protection_heading_rad = n.protection.heading_rad;
    out->tilt_ready = n.tilt_ready;
    out->heading_ready = n.heading_ready;
    out->velocity_ready = n.velocity_ready;
    out->position_ready = n.position_ready;
}

hnav_status check_arrays(InsObject* f, std::size_t n, const hnav_ins_run_input* input, const hnav_ins_run_output* output) {
    REQUIRE_STRUCT(f, input, hnav_ins_run_input);
    REQUIRE_STRUCT(f, output, hnav_ins_run_output);
    if (n > 0) {
        REQUIRE(f, input->t_s);
        REQUIRE(f, input->rate_b_rad_s);
        REQUIRE(f, input->force_b_m_s2);
    }
    if (input->aids > 0) {
        REQUIRE(f, input->aid_t_s);
        REQUIRE(f, input->aid_sensor);
        REQUIRE(f, input->aid_value);
    }
    return HNAV_OK;
}

void write_row(const hnav_navigation& n, const hnav_ins_run_output& out, std::size_t i) {
    if (out.t_s) out.t_s[i] = n.t_s;
    copy(&n.latitude_rad, 3, row(out.place, i, 3));
    copy(n.velocity_n_m_s, 3, row(out.velocity_n_m_s, i, 3));
    copy(n.q_nb, 4, row(out.q_nb, i, 4));
    copy(n.sigma_position_m, 3, row(out.sigma_position_m, i, 3));
    copy(n.sigma_velocity_m_s, 3, row(out.sigma_velocity_m_s, i, 3));
    copy(n.sigma_rotation_rad, 3, row(out.sigma_rotation_rad, i, 3));
    copy(n.gyro_bias_rad_s, 3, row(out.gyro_bias_rad_s, i, 3));
    copy(n.accel_bias_m_s2, 3, row(out.accel_bias_m_s2, i, 3));
    copy(&n.heading_second_rad, 2, row(out.heading_second, i, 2));
    copy(n.protection_m, 2, row(out.protection_m, i, 2));
    copy(&n.protection_heading_rad, 1, row(out.protection_heading_rad, i, 1));
    if (out.phase) out.phase[i] = static_cast<std::uint8_t>(n.phase);
    if (out.at_rest) out.at_rest[i] = n.at_rest != 0;
    if (!out.ready) return;
    const int32_t ready[4] = {n.tilt_ready, n.heading_ready, n.velocity_ready, n.position_ready};
    for (int k = 0; k < 4; ++k) out.ready[4 * i + k] = ready[k] != 0;
}

hnav_navigation navigation(const ins::Model& model, const ins::State& s, double ahead_s, double now_s) {
    const double none = ins::nan;
    hnav_navigation out{};
    if (s.started()) {
        fill(model.navigation(s, ahead_s, now_s), &out);
        fill_state(s, &out);
    } else {
        // Its numbers are the doubles between t_s and phase.
        double* first = &out.latitude_rad;
        for (double* p = first; p <= &out.sigma_latency_s; ++p) *p = none;
        for (int i = 0; i < 3; ++i) out.gyro_scale[i] = out.sigma_gyro_scale[i] = none;
        out.protection_m[0] = out.protection_m[1] = out.protection_heading_rad = none;
    }
    out.t_s = now_s;
    out.phase = static_cast<std::int32_t>(s.phase);
    out.at_rest = model.at_rest(s, now_s);
    return out;
}

} // namespace hnav::ins_boundary

namespace hnav {

hnav_navigation InsObject::navigation() const {
    const Shown at = shown_of(this);
    hnav_navigation n = ins_boundary::navigation(filter.model(), at.state, at.ahead_s, filter.event_now_s());
    n.t_s = filter.now_s();
    if (flows_outside && at.state.started()) fill_motion(ins::motion_of(filter.shown()), &n);
    return n;
}

hnav_status InsObject::attitude(hnav_attitude* out) const {
    const hnav_navigation n = navigation();
    if (std::isnan(n.q_nb[0])) return not_started(this);
    out->t_s = n.t_s;
    copy(n.q_nb, 4, out->q_nb);
    copy(n.euler_rad, 3, out->euler_rad);
    out->heading_rad = n.euler_rad[2];
    copy(n.sigma_rotation_rad, 3, out->sigma_rad);
    out->near_singular = std::fabs(n.euler_rad[1]) > near_singular_pitch;
    out->tilt_ready = n.tilt_ready;
    out->heading_ready = n.heading_ready;
    return HNAV_OK;
}

hnav_status InsObject::rate(double* rate_b) const {
    const ins::State& s = shown_of(this).state;
    for (int i = 0; i < 3; ++i) rate_b[i] = s.started() ? s.held.rate[i] - s.gyro_bias[i] : 0;
    return HNAV_OK;
}

hnav_status InsObject::gyro_bias(double* bias_b, double* sigma) const {
    const hnav_navigation n = navigation();
    if (std::isnan(n.q_nb[0])) return not_started(this);
    copy(n.gyro_bias_rad_s, 3, bias_b);
    copy(n.sigma_gyro_bias_rad_s, 3, sigma);
    return HNAV_OK;
}

hnav_status InsObject::covariance(double* to) const {
    const Shown at = shown_of(this);
    if (!at.state.started()) return not_started(this);
    const ins::Covariance P = filter.model().covariance_at(at.state, at.ahead_s);
    for (int i = 0; i < 15; ++i)
        for (int j = 0; j < 15; ++j) to[15 * i + j] = 0.5 * (P[i][j] + P[j][i]);
    return HNAV_OK;
}

hnav_status InsObject::innovation(int sensor, hnav_innovation* out) const {
    if (sensor == HNAV_SENSOR_ACCEL) return fail(HNAV_ERROR_OUT_OF_RANGE, "the accelerometer of an INS has no innovation");
    const ins::Innovation& i = filter.newest().innovation[channel_of(sensor)];
    if (std::isnan(i.t_s)) return fail(HNAV_ERROR_NO_DATA, "no %s sample has been used yet", sensor_name(sensor));
    fill_innovation(i, filter.stamp_of(i.t_s), out);
    for (int k = 0; k < 3; ++k) out->S[4 * k] = i.variance[k];
    return HNAV_OK;
}

void InsObject::diagnostics(hnav_diagnostics* out) const {
    const ins::State& s = filter.newest();
    diagnose(filter, out);
    out->mean_nis = s.nis_mean;
    out->gyro_vibration_rad_s = std::sqrt(s.held.vibration_rate2);
    out->accel_vibration_m_s2 = std::sqrt(s.held.vibration_force2);
    for (int sensor = 0; sensor < HNAV_SENSOR_COUNT; ++sensor) {
        out->used[sensor] = s.used[channel_of(sensor)];
        out->gated[sensor] = s.inflated[channel_of(sensor)];
    }
    out->corrections = s.corrections;
    out->started = s.started();
}

void InsObject::health(hnav_health* out) const {
    const ins::State& s = filter.newest();
    const SensorCheck<double>* const checks[] = {&s.check[checked_gyro], &s.check[checked_accel], &s.check[checked_mag]};
    for (int sensor = 0; sensor < HNAV_SENSOR_COUNT; ++sensor) {
        const SensorCheck<double>* check = sensor < HNAV_SENSOR_HEADING ? checks[sensor] : nullptr;
        out->sensor[sensor] = sensor_health(check, filter, channel_of(sensor));
    }
    out->times_lost = s.times_lost;
    out->clock_jumps = filter.stamps().jumps();
    out->stamps_left_out = filter.stamps().left_out();
    out->lost = s.times_lost > 0 && s.phase != ins::Phase::navigating;
}

} // namespace hnav

extern "C" {

hnav_status hnav_ins_navigation(const hnav_filter* filter, hnav_navigation* to) {
    REQUIRE_OBJECT(const InsObject, object, filter);
    REQUIRE_STRUCT(object, to, hnav_navigation);
    return hand_out(object->navigation(), to);
}

hnav_status hnav_ins_observed(const hnav_filter* filter, hnav_observed* observed) {
    REQUIRE_OBJECT(const InsObject, object, filter);
    REQUIRE_STRUCT(object, observed, hnav_observed);
    const double* by = object->filter.newest().gained_nats;
    hnav_observed result{};
    result.by_rest = by[ins::rest];
    result.by_speed = by[ins::speed];
    result.by_pressure = by[ins::pressure];
    result.by_velocity = by[ins::velocity];
    result.by_position = by[ins::position];
    result.by_heading = by[ins::heading];
    result.by_field = by[ins::field];
    return hand_out(result, observed);
}

hnav_status hnav_ins_run(hnav_filter* filter, size_t n, const hnav_ins_run_input* input, const hnav_ins_run_output* output,
                         size_t* rows_done) {
    if (rows_done) *rows_done = 0;
    REQUIRE_OBJECT(InsObject, object, filter);
    if (const hnav_status status = check_arrays(object, n, input, output)) return status;
    const hnav_ins_run_input in = take_in(*input);
    const hnav_ins_run_output out = take_in(*output);
    const std::size_t every = out.every > 0 ? out.every : 1;
    std::size_t aid = 0, written = 0;
    for (std::size_t i = 0; i < n; ++i) {
        if (const hnav_status status = take_row(object, in, i, &aid)) return in_row(object, status, i);
        if ((i + 1) % every == 0) write_row(object->navigation(), out, written++);
        if (rows_done) *rows_done = i + 1;
    }
    return HNAV_OK;
}

} // extern "C"
