// Whole recordings: arrays in, arrays out; forward in the order of the samples, or smoothed.
#include "attitude/common/smoother.hpp"
#include "base/memory.hpp"
#include "c_api/attitude_boundary.hpp"
#include "c_api/sized.hpp"

using namespace hnav;
using namespace hnav::boundary;

namespace {

// The samples of a row; null: none.
struct Samples {
    const double *rate, *force, *field;
    double speed, speed_sigma; // NaN: none
};

// Samples that push refuses for their value are counted, and the recording continues without them, as a stream does.
hnav_status unless_dropped(hnav_status status) {
    const bool dropped = status == HNAV_ERROR_NON_FINITE || status == HNAV_ERROR_ZERO_VECTOR || status == HNAV_ERROR_OUT_OF_RANGE;
    return dropped ? HNAV_OK : status;
}

// One row of a batch with a checked time: NaN in all three components is a missing sample.
hnav_status push_row(AttitudeObject* f, double t_s, const double* value, int channel) {
    return is_missing(value) ? HNAV_OK : unless_dropped(push_vector(f, t_s, value, channel));
}

// A row of valid samples without an aid, the usual case. False: nothing was taken.
bool push_whole_row(AttitudeObject* f, double t_s, const Samples& of) {
    if (!std::isnan(of.speed)) return false;
    AttitudeEvent event;
    event.t_s = clock_time(t_s);
    event.present = 0;
    const Vector3 nothing = Vector3::Zero();
    for (const int c : {heading, speed}) store(nothing, event.value[c]);
    const double* const rows[] = {of.rate, of.force, of.field};
    for (const int c : {gyro, accel, mag}) {
        const double* v = rows[c];
        const double size = v ? std::fabs(v[0]) + std::fabs(v[1]) + std::fabs(v[2]) : hnav::nan;
        if (!(size <= max_of(c))) { // NaN too
            if (!is_missing(v)) return false;
            store(nothing, event.value[c]);
            continue;
        }
        if (!(c == gyro || size > 3 * min_direction_length)) return false;
        event.present |= std::uint64_t{1} << c;
        f->frames.to_body(v, event.value[c]);
    }
    return event.present != 0 && f->push_event(event);
}

// NIS of the correction in this row, NaN without one.
double nis_after(const AttitudeObject* f, int channel, double before_s) {
    const Innovation& i = f->last_innovation(channel);
    return i.t_s > before_s ? i.nis : hnav::nan;
}

void write_nothing_known(const hnav_run_output& out, size_t i) {
    for (double* column : {out.euler_rad, out.sigma_rad, out.gyro_bias_rad_s, out.gyro_bias_sigma_rad_s})
        if (column) store(Vector3(Vector3::Constant(hnav::nan)), column + 3 * i);
    if (out.q_nb) store(Quaternion(Quaternion::Constant(hnav::nan)), out.q_nb + 4 * i);
}

// Whether a sample of this row corrected with the stated noise.
std::uint8_t accepted_after(const AttitudeObject* f, int channel, double before_s) {
    const Innovation& i = f->last_innovation(channel);
    return i.t_s > before_s && !(i.noise_scale > 1);
}

// Only requested outputs are computed.
void write_estimate(const AttitudeObject* f, const hnav_run_output& out, size_t i) {
    if (out.q_nb || out.euler_rad) {
        const Quaternion q = f->frames.to_user(f->q_bn(At::shown));
        if (out.q_nb) store(q, out.q_nb + 4 * i);
        if (out.euler_rad) store(roll_pitch_yaw(q), out.euler_rad + 3 * i);
    }
    if (out.sigma_rad) rotation_sigma(f, At::shown, out.sigma_rad + 3 * i);
    if (out.gyro_bias_rad_s) store(f->estimate(At::shown).bias_b, out.gyro_bias_rad_s + 3 * i);
    if (out.gyro_bias_sigma_rad_s) bias_sigma(f, At::shown, out.gyro_bias_sigma_rad_s + 3 * i);
}

// NIS, verdicts and health of the row. before_s: newest_time_s before it.
inline void write_course(const AttitudeObject* f, double before_s, const hnav_run_output& out, size_t i) {
    if (out.accel_nis) out.accel_nis[i] = nis_after(f, hnav::accel, before_s);
    if (out.mag_nis) out.mag_nis[i] = nis_after(f, hnav::mag, before_s);
    if (out.accepted)
        for (const int c : {accel, mag}) out.accepted[2 * i + c - accel] = accepted_after(f, c, before_s);
    if (out.health)
        for (const int c : {gyro, accel, mag}) out.health[3 * i + c] = static_cast<uint8_t>(f->sensor_health(c).state);
}

template <class AnyEstimate>
void write_ready(const AnyEstimate& e, const hnav_run_output& out, size_t i) {
    out.ready[2 * i] = e.tilt_ready;
    out.ready[2 * i + 1] = e.heading_ready;
}

hnav_status take_row(AttitudeObject* f, double t_s, const Samples& of) {
    if (const hnav_status status = check_time(f, t_s)) return status;
    if (push_whole_row(f, t_s, of)) return advanced(f, t_s, f->advance_row(clock_time(t_s)));
    hnav_status status = push_row(f, t_s, of.rate, gyro);
    if (status == HNAV_OK) status = push_row(f, t_s, of.force, accel);
    if (status == HNAV_OK) status = push_row(f, t_s, of.field, mag);
    if (status == HNAV_OK && !std::isnan(of.speed)) status = unless_dropped(push_speed(f, t_s, of.speed, of.speed_sigma));
    if (status != HNAV_OK) return status;
    const bool empty = is_missing(of.rate) && is_missing(of.force) && is_missing(of.field) && std::isnan(of.speed);
    return advanced(f, t_s, empty ? f->advance(clock_time(t_s)) : f->advance_row(clock_time(t_s)));
}

Samples samples_of(const hnav_run_input& in, size_t i) {
    Samples of{row(in.rate_b_rad_s, i, 3), row(in.force_b_m_s2, i, 3), row(in.field_b_tesla, i, 3), hnav::nan, hnav::nan};
    if (in.speed_m_s) {
        of.speed = in.speed_m_s[i];
        of.speed_sigma = in.speed_sigma_m_s[i];
    }
    return of;
}

// ------------------------------------------------------------------------------------------------ smoothing

// The arrays and the filter as the smoother's interface.
class Recording {
public:
    Recording(AttitudeObject* filter, size_t n, const hnav_run_input& input, const hnav_run_output& output)
        : filter_(filter), n_(n), input_(input), output_(output) {}

    hnav_status status() const { return status_; }

    std::size_t size() const { return n_; }
    double t_s(std::size_t i) const { return input_.t_s[i]; }
    hnav::Hold hold() const { return filter_->hold; }

    bool take(std::size_t i, double t_s, std::size_t rate_row, double rate_sign) {
        const double* rate = rate_row < n_ ? row(input_.rate_b_rad_s, rate_row, 3) : nullptr;
        double signed_rate[3];
        for (int k = 0; rate && k < 3; ++k) signed_rate[k] = rate_sign * rate[k];
        before_s_ = filter_->newest_time_s();
        Samples samples = samples_of(input_, i);
        samples.rate = rate ? signed_rate : nullptr;
        status_ = take_row(filter_, t_s, samples);
        if (status_ != HNAV_OK) status_ = in_row(filter_, status_, i);
        return status_ == HNAV_OK;
    }

    bool started() {
        if (filter_->started(At::newest)) return true;
        status_ = filter_->fail(HNAV_ERROR_NOT_STARTED, "no attitude by the end of the recording: there is nothing to smooth");
        return false;
    }

    void turn_back(double t_s) { filter_->turn_back(t_s); }

    PassEstimate estimate() const {
        const Estimate e = filter_->estimate(At::shown);
        return {e.q_bn,       filter_->rotation_covariance(At::shown),
                e.bias_b,     filter_->bias_variances(At::shown),
                e.tilt_ready, e.heading_ready,
                e.started};
    }

    void write(std::size_t i, const PassEstimate& e) const {
        const Quaternion q = filter_->frames.to_user(e.q_bn);
        if (output_.q_nb) store(q, output_.q_nb + 4 * i);
        if (output_.euler_rad) store(roll_pitch_yaw(q), output_.euler_rad + 3 * i);
        if (output_.sigma_rad)
            store(sigmas(filter_->frames.variances_to_user<double>(e.rotation_covariance)), output_.sigma_rad + 3 * i);
        if (output_.gyro_bias_rad_s) store(e.bias, output_.gyro_bias_rad_s + 3 * i);
        if (output_.gyro_bias_sigma_rad_s) store(sigmas(e.bias_variance), output_.gyro_bias_sigma_rad_s + 3 * i);
        if (output_.ready) write_ready(e, output_, i);
    }

    void record(std::size_t i) const { write_course(filter_, before_s_, output_, i); }

private:
    AttitudeObject* filter_;
    size_t n_;
    const hnav_run_input input_;
    const hnav_run_output output_;
    double before_s_ = 0; // newest_time_s before the last row
    hnav_status status_ = HNAV_OK;
};

hnav_status check_arrays(AttitudeObject* filter, size_t n, const hnav_run_input* input, const hnav_run_output* output) {
    REQUIRE_STRUCT(filter, input, hnav_run_input);
    REQUIRE_STRUCT(filter, output, hnav_run_output);
    if (n > 0) REQUIRE(filter, input->t_s);
    if (input->speed_m_s) REQUIRE(filter, input->speed_sigma_m_s);
    return HNAV_OK;
}

} // namespace

extern "C" {

hnav_status hnav_filter_run(hnav_filter* filter, size_t n, const hnav_run_input* input, const hnav_run_output* output,
                            size_t* rows_done) {
    if (rows_done) *rows_done = 0;
    REQUIRE_OBJECT(AttitudeObject, object, filter);
    if (const hnav_status status = check_arrays(object, n, input, output)) return status;
    const hnav_run_input in = take_in(*input);
    const hnav_run_output out = take_in(*output);
    const bool wants_course = out.accel_nis || out.mag_nis || out.accepted || out.health || out.ready;
    for (size_t i = 0; i < n; ++i) {
        const double before_s = wants_course ? object->newest_time_s() : 0;
        if (const hnav_status status = take_row(object, in.t_s[i], samples_of(in, i))) return in_row(object, status, i);
        if (object->started(At::shown)) write_estimate(object, out, i);
        else write_nothing_known(out, i);
        if (wants_course) write_course(object, before_s, out, i);
        if (wants_course && out.ready) write_ready(object->estimate(At::shown), out, i);
        if (rows_done) *rows_done = i + 1;
    }
    return HNAV_OK;
}

hnav_status hnav_filter_smooth(hnav_filter* filter, size_t n, const hnav_run_input* input, const hnav_run_output* output) {
    REQUIRE_OBJECT(AttitudeObject, object, filter);
    const hnav_status status = check_arrays(object, n, input, output);
    if (status != HNAV_OK || n == 0) return status;
    if (!object->turns_back())
        return object->fail(HNAV_ERROR_UNSUPPORTED, "this filter has no smoother: the AHRS and the INS have one");
    auto* room = static_cast<PassEstimate*>(take_block(2 * n * sizeof(PassEstimate)));
    if (!room) return object->fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory to smooth %zu rows", n);
    object->reset();
    object->prefer_closed_form(true);
    Recording recording(object, n, take_in(*input), take_in(*output));
    Smoother<Recording>(recording, room).run();
    object->prefer_closed_form(false);
    release_block(room);
    object->reset();
    return recording.status();
}

} // extern "C"
