// The C boundary of the navigation filter: what it tells, whole recordings, saved states.
#include "c_api/ins_object.hpp"

#include "c_api/health.hpp"
#include "maths/repair.hpp"

using namespace hnav;
using namespace hnav::ins_boundary;

namespace {

void store(const Vector3& v, double* out) {
    for (int i = 0; i < 3; ++i) out[i] = v[i];
}

void fill_motion(const ins::Motion& n, hnav_navigation* out) {
    out->latitude_rad = n.place.latitude_rad;
    out->longitude_rad = n.place.longitude_rad;
    out->height_m = n.place.height_m;
    store(n.velocity_n, out->velocity_n_m_s);
    for (int i = 0; i < 4; ++i) out->q_nb[i] = n.q_nb[i];
    store(roll_pitch_yaw(n.q_nb), out->euler_rad);
    store(n.position_e, out->position_e_m);
    store(n.velocity_e, out->velocity_e_m_s);
}

void fill(const ins::State& s, const ins::Navigation& n, hnav_navigation* out) {
    fill_motion(n, out);
    store(Vector3(s.gyro_bias), out->gyro_bias_rad_s);
    store(Vector3(s.accel_bias), out->accel_bias_m_s2);
    store(Vector3(s.gyro_scale), out->gyro_scale);
    store(n.sigma_position, out->sigma_position_m);
    store(n.sigma_velocity, out->sigma_velocity_m_s);
    store(n.sigma_rotation, out->sigma_rotation_rad);
    for (int i = 0; i < 3; ++i) {
        const auto sigma = [&](int row) { return std::sqrt(std::fmax(0, s.P[ins::packed(row + i, row + i)])); };
        out->sigma_gyro_bias_rad_s[i] = sigma(ins::row_gyro);
        out->sigma_accel_bias_m_s2[i] = sigma(ins::row_accel);
        out->sigma_gyro_scale[i] = sigma(ins::row_gyro_scale);
    }
    out->heading_second_rad = n.circle.second_rad;
    out->heading_second_share = n.circle.second_share;
    out->latency_s = s.latency;
    out->sigma_latency_s = std::sqrt(std::fmax(0, s.P[ins::packed(ins::row_latency, ins::row_latency)]));
    out->tilt_ready = n.tilt_ready;
    out->heading_ready = n.heading_ready;
    out->velocity_ready = n.velocity_ready;
    out->position_ready = n.position_ready;
}

// A row of the output, of `width` numbers; null: not asked for.
template <class Number>
Number* row(Number* rows, std::size_t i, std::size_t width) {
    return rows ? rows + i * width : nullptr;
}

void copy(const double* from, int count, double* to) {
    if (to) std::copy(from, from + count, to);
}

// What push refuses for its value or its age is counted there, and the recording goes on without it, as a stream does.
hnav_status tolerated(hnav_status status) { return status == HNAV_ERROR_QUEUE_FULL ? status : HNAV_OK; }

// The sample of the IMU first: a row whose stamp is left out, or late, stands for no time, and brings no aids.
hnav_status take_row(hnav_ins* f, const hnav_ins_run_input& in, std::size_t i, std::size_t* aid) {
    using Place = std::decay_t<decltype(f->filter.stamps())>::Place;
    hnav_status status = HNAV_OK;
    const double *rate = in.rate_b_rad_s + 3 * i, *force = in.force_b_m_s2 + 3 * i;
    const double* received_s = in.aid_received_s ? in.aid_received_s : in.aid_t_s;
    if (!is_missing(rate) && !is_missing(force)) {
        status = push_imu(f, in.t_s[i], rate, force);
        const bool left_out = status == HNAV_OK && f->filter.stamps().last() == Place::left_out;
        if (left_out || status == HNAV_ERROR_LATE_SAMPLE) return HNAV_OK;
        status = tolerated(status);
    }
    for (; *aid < in.aids && received_s[*aid] <= in.t_s[i] && status == HNAV_OK; ++*aid) {
        const int32_t sensor = in.aid_sensor[*aid];
        if (sensor <= HNAV_INS_IMU || sensor >= HNAV_INS_SENSOR_COUNT)
            return f->fail(HNAV_ERROR_OUT_OF_RANGE, "aid %zu: sensor %d does not exist", *aid, static_cast<int>(sensor));
        status = tolerated(push(f, in.aid_t_s[*aid], sensor, in.aid_value + 6 * *aid));
    }
    return status == HNAV_OK ? advance(f, in.t_s[i]) : status;
}

// All that is told but the motion, which alone flows between events where an integrator outside moves it.
struct Told {
    const ins::State& state;
    double ahead_s; // beyond its last event
};

Told told(const hnav_ins* f) {
    if (f->flows_outside) return {f->filter.newest(), 0};
    return {f->filter.shown(), f->filter.looked_ahead_s()};
}

hnav_navigation navigation_now(const hnav_ins* f) {
    const Told at = told(f);
    hnav_navigation n = navigation(f->filter.model(), at.state, at.ahead_s, f->filter.event_now_s());
    n.t_s = f->filter.now_s();
    if (f->flows_outside && at.state.started()) fill_motion(ins::motion_of(f->filter.shown()), &n);
    return n;
}

} // namespace

namespace hnav::ins_boundary {

bool is_missing(const double* v) { return std::isnan(v[0]) && std::isnan(v[1]) && std::isnan(v[2]); }

hnav_status check_arrays(hnav_ins* f, std::size_t n, const hnav_ins_run_input* input, const hnav_ins_run_output* output) {
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
        fill(s, model.navigation(s, ahead_s, now_s), &out);
    } else {
        // Its numbers are the doubles between t_s and phase.
        double* first = &out.latitude_rad;
        for (double* p = first; p <= &out.sigma_latency_s; ++p) *p = none;
        for (int i = 0; i < 3; ++i) out.gyro_scale[i] = out.sigma_gyro_scale[i] = none;
    }
    out.t_s = now_s;
    out.phase = static_cast<std::int32_t>(s.phase);
    out.at_rest = model.at_rest(s, now_s);
    return out;
}

} // namespace hnav::ins_boundary

extern "C" {

hnav_status hnav_ins_navigation(const hnav_ins* object, hnav_navigation* to) {
    REQUIRE_STRUCT(object, to, hnav_navigation);
    hand_out(navigation_now(object), to);
    return HNAV_OK;
}

hnav_status hnav_ins_covariance(const hnav_ins* object, double covariance[225]) {
    REQUIRE(object, covariance);
    const Told at = told(object);
    if (!at.state.started()) return object->fail(HNAV_ERROR_NOT_STARTED, "no tilt yet: the start waits for samples and a fix");
    const ins::Covariance P = object->filter.model().covariance_at(at.state, at.ahead_s);
    for (int i = 0; i < 15; ++i)
        for (int j = 0; j < 15; ++j) covariance[15 * i + j] = 0.5 * (P[i][j] + P[j][i]);
    return HNAV_OK;
}

hnav_status hnav_ins_observed(const hnav_ins* object, hnav_observed* observed) {
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
    hand_out(result, observed);
    return HNAV_OK;
}

hnav_status hnav_ins_last_innovation(const hnav_ins* object, hnav_ins_sensor sensor, hnav_ins_innovation* innovation) {
    REQUIRE_STRUCT(object, innovation, hnav_ins_innovation);
    if (int(sensor) <= HNAV_INS_IMU || int(sensor) >= HNAV_INS_SENSOR_COUNT)
        return object->fail(HNAV_ERROR_OUT_OF_RANGE, "sensor %d has no innovation", int(sensor));
    const ins::Innovation& i = object->filter.newest().innovation[sensor];
    if (std::isnan(i.t_s)) return object->fail(HNAV_ERROR_NO_DATA, "no sample of sensor %d has been used yet", int(sensor));
    hnav_ins_innovation result{};
    result.t_s = object->filter.stamp_of(i.t_s);
    copy(i.value, 3, result.value);
    copy(i.variance, 3, result.variance);
    result.nis = i.nis;
    result.noise_scale = i.noise_scale;
    result.dimension = static_cast<int32_t>(i.dimension);
    hand_out(result, innovation);
    return HNAV_OK;
}

hnav_status hnav_ins_get_diagnostics(const hnav_ins* object, hnav_ins_diagnostics* diagnostics) {
    REQUIRE_STRUCT(object, diagnostics, hnav_ins_diagnostics);
    const auto& filter = object->filter;
    const ins::State& s = filter.newest();
    hnav_ins_diagnostics result{};
    result.newest_sample_s = std::isfinite(filter.newest_s()) ? filter.newest_s() : ins::nan;
    result.mean_nis = s.nis_mean;
    result.gyro_vibration_rad_s = std::sqrt(s.held.vibration_rate2);
    result.accel_vibration_m_s2 = std::sqrt(s.held.vibration_force2);
    for (int c = 0; c < HNAV_INS_SENSOR_COUNT; ++c) {
        result.used[c] = s.used[c];
        result.inflated[c] = s.inflated[c];
    }
    result.late = filter.refused.late;
    result.non_finite = filter.refused.non_finite;
    result.times_lost = s.times_lost;
    result.corrections = s.corrections;
    result.solver_rhs_evals = filter.propagator().rhs_evals();
    result.solver_steps = filter.propagator().steps();
    hand_out(result, diagnostics);
    return HNAV_OK;
}

hnav_status hnav_ins_get_health(const hnav_ins* object, hnav_ins_health* health) {
    REQUIRE_STRUCT(object, health, hnav_ins_health);
    const auto& filter = object->filter;
    const ins::State& s = filter.newest();
    const auto of = [&](int channel, const SensorCheck<double>* check) {
        hnav_sensor_health h = sensor_health(check, filter.stamps(), channel, filter.event_now_s());
        h.since_s = filter.stamp_of(h.since_s);
        return h;
    };
    hnav_ins_health result{};
    for (const int part : {checked_gyro, checked_accel}) result.unit[part] = of(ins::imu, &s.check[part]);
    for (int c = 0; c < HNAV_INS_SENSOR_COUNT; ++c) result.sensor[c] = of(c, c == ins::field ? &s.check[checked_mag] : nullptr);
    result.times_lost = s.times_lost;
    result.clock_jumps = filter.stamps().jumps();
    result.stamps_left_out = filter.stamps().left_out();
    hand_out(result, health);
    return HNAV_OK;
}

hnav_status hnav_ins_run(hnav_ins* object, size_t n, const hnav_ins_run_input* input, const hnav_ins_run_output* output,
                         size_t* rows_done) {
    if (rows_done) *rows_done = 0;
    if (const hnav_status status = check_arrays(object, n, input, output)) return status;
    const hnav_ins_run_input in = take_in(*input);
    const hnav_ins_run_output out = take_in(*output);
    const std::size_t every = out.every > 0 ? out.every : 1;
    std::size_t aid = 0, written = 0;
    for (std::size_t i = 0; i < n; ++i) {
        if (const hnav_status status = take_row(object, in, i, &aid)) {
            char reason[sizeof object->message];
            std::memcpy(reason, object->message, sizeof reason);
            return object->fail(status, "row %zu: %.280s", i, reason);
        }
        if ((i + 1) % every == 0) write_row(navigation_now(object), out, written++);
        if (rows_done) *rows_done = i + 1;
    }
    return HNAV_OK;
}

hnav_status hnav_ins_state_size(const hnav_ins* object, size_t* bytes) {
    REQUIRE(object, bytes);
    *bytes = object->filter.state_size();
    return HNAV_OK;
}

hnav_status hnav_ins_save(const hnav_ins* object, void* buffer, size_t bytes) {
    REQUIRE(object, buffer);
    if (const hnav_status status = save_status(*object, bytes, object->filter.state_size())) return status;
    object->filter.save(buffer);
    return HNAV_OK;
}

hnav_status hnav_ins_load(hnav_ins* object, const void* buffer, size_t bytes) {
    REQUIRE(object, buffer);
    return load_status(*object, object->filter.load(buffer, bytes), "filter", bytes, object->filter.state_size());
}

} // extern "C"
