// Whole recordings: arrays in, arrays out; forward as the samples came, or smoothed with the benefit of hindsight.
#include "c_api/boundary.hpp"
#include "maths/cholesky.hpp"

#include <cstdlib>

using namespace hnav;
using namespace hnav::boundary;

namespace {

bool all_nan(const double* v, int n) {
    for (int i = 0; i < n; ++i)
        if (!std::isnan(v[i])) return false;
    return true;
}

// One row of a batch: NaN in all three components is a missing sample, anything else not finite is counted.
hnav_status push_row(hnav_filter* f, double t_s, const double* value, int channel) {
    if (!value || all_nan(value, 3)) return HNAV_OK;
    const hnav_status status = push_vector(f, t_s, value, channel);
    const bool dropped = status == HNAV_ERROR_NON_FINITE || status == HNAV_ERROR_ZERO_VECTOR;
    return dropped && std::isfinite(t_s) ? HNAV_OK : status;
}

double nis_at(const hnav_filter* f, int channel, double t_s) {
    const Innovation& i = f->innovation(channel);
    return i.t_s == t_s ? i.nis : hnav::nan;
}

void write_row(const hnav_filter* f, double t_s, const hnav_run_output& out, size_t i) {
    const Estimate e = f->estimate(At::shown);
    const Quaternion q = f->frames.to_user(e.q_bn);
    if (!e.started) {
        for (double* column : {out.euler_rad, out.sigma_rad, out.gyro_bias_rad_s, out.gyro_bias_sigma_rad_s})
            if (column) store(Vector3(Vector3::Constant(hnav::nan)), column + 3 * i);
        if (out.q_nb) store(Quaternion(Quaternion::Constant(hnav::nan)), out.q_nb + 4 * i);
    } else {
        if (out.q_nb) store(q, out.q_nb + 4 * i);
        if (out.euler_rad) store(roll_pitch_yaw(q), out.euler_rad + 3 * i);
        if (out.sigma_rad) rotation_sigma(f, At::shown, out.sigma_rad + 3 * i);
        if (out.gyro_bias_rad_s) store(e.bias_b, out.gyro_bias_rad_s + 3 * i);
        if (out.gyro_bias_sigma_rad_s) bias_sigma(f, At::shown, out.gyro_bias_sigma_rad_s + 3 * i);
    }
    if (out.accel_nis) out.accel_nis[i] = nis_at(f, hnav::accel, t_s);
    if (out.mag_nis) out.mag_nis[i] = nis_at(f, hnav::mag, t_s);
    if (out.ready) {
        out.ready[2 * i] = e.tilt_ready;
        out.ready[2 * i + 1] = e.heading_ready;
    }
}

const double* row(const double* rows, size_t i) { return rows ? rows + 3 * i : nullptr; }

hnav_status in_row(hnav_filter* f, hnav_status status, size_t i) {
    char reason[sizeof f->message];
    std::memcpy(reason, f->message, sizeof reason);
    return f->fail(status, "row %zu: %.200s", i, reason);
}

hnav_status take_row(hnav_filter* f, double t_s, const double* rate, const double* force, const double* field) {
    if (const hnav_status status = check_time(f, t_s)) return status;
    hnav_status status = push_row(f, t_s, rate, gyro);
    if (status == HNAV_OK) status = push_row(f, t_s, force, accel);
    if (status == HNAV_OK) status = push_row(f, t_s, field, mag);
    return status == HNAV_OK ? advance(f, t_s) : status;
}

// ------------------------------------------------------------------------------------------------ smoothing

// One row of the pass that goes backwards.
struct Hindsight {
    double q[4], rotation_covariance[9], bias[3], bias_variance[3];
};

class Smoother {
public:
    Smoother(hnav_filter* filter, size_t n, const hnav_run_input& input, const hnav_run_output& output, Hindsight* hindsight)
        : filter_(filter), n_(n), input_(input), output_(output), hindsight_(hindsight) {}

    // Forward, then twice backwards and forward, each pass started at the end of the one before: what was learnt of the
    // sensors serves all of the recording. The last two passes are fused.
    hnav_status run() {
        hnav_status status = forward(false);
        if (status == HNAV_OK && !filter_->estimate(At::newest).started)
            return filter_->fail(HNAV_ERROR_NOT_STARTED, "no attitude by the end of the recording: there is nothing to smooth");
        for (int pass = 0; pass < 2 && status == HNAV_OK; ++pass) {
            filter_->turn_back(0);
            status = backwards();
            if (status != HNAV_OK) break;
            filter_->turn_back(input_.t_s[0]);
            status = forward(pass == 1);
        }
        return status;
    }

private:
    hnav_status forward(bool fused) {
        for (size_t i = 0; i < n_; ++i) {
            const hnav_status status = take_row(filter_, input_.t_s[i], row(input_.rate_b_rad_s, i), row(input_.force_b_m_s2, i),
                                                row(input_.field_b_tesla, i));
            if (status != HNAV_OK) return in_row(filter_, status, i);
            if (fused) fuse(i);
        }
        return HNAV_OK;
    }

    // Time runs from the last row to the first. The rate changes its sign, and the sample that stood for an interval
    // stands on the interval's other end.
    hnav_status backwards() {
        for (size_t i = n_; i-- > 0;) {
            const bool has_rate = filter_->backward_hold ? i + 1 < n_ : i > 0;
            const double* rate = has_rate ? row(input_.rate_b_rad_s, filter_->backward_hold ? i + 1 : i - 1) : nullptr;
            double opposite[3];
            for (int k = 0; rate && k < 3; ++k) opposite[k] = -rate[k];
            const hnav_status status = take_row(filter_, input_.t_s[n_ - 1] - input_.t_s[i], rate ? opposite : nullptr,
                                                row(input_.force_b_m_s2, i), row(input_.field_b_tesla, i));
            if (status != HNAV_OK) return in_row(filter_, status, i);
            Hindsight& h = hindsight_[i];
            const Estimate e = filter_->estimate(At::shown);
            store(e.q_bn, h.q);
            Eigen::Map<Matrix3>(h.rotation_covariance) = filter_->rotation_covariance(At::shown);
            store(Vector3(-e.bias_b), h.bias);
            store(filter_->bias_variances(At::shown), h.bias_variance);
        }
        return HNAV_OK;
    }

    // Two estimates of one attitude, weighted by their covariances: q = exp(W v) q_f, v = log(q_b conj(q_f)),
    // W = P_f (P_f + P_b)^-1, P = (I - W) P_f.
    void fuse(size_t i) const {
        const Hindsight& h = hindsight_[i];
        const Estimate e = filter_->estimate(At::shown);
        const Matrix3 P_f = filter_->rotation_covariance(At::shown);
        const Matrix3 P_b = Eigen::Map<const Matrix3>(h.rotation_covariance);
        const Matrix3 W = Cholesky<3>(P_f + P_b).solve<3>(P_f).transpose();
        const Vector3 v = rotation_vector(multiply(Quaternion(h.q), conjugate(e.q_bn)));
        const Quaternion q_internal = multiply(rotation_quaternion(W * v), e.q_bn);
        const Quaternion q = filter_->frames.to_user(q_internal);
        if (output_.q_nb) store(q, output_.q_nb + 4 * i);
        if (output_.euler_rad) store(roll_pitch_yaw(q), output_.euler_rad + 3 * i);
        if (output_.sigma_rad) {
            const Matrix3 N = filter_->frames.navigation;
            store(Vector3((N * (P_f - W * P_f) * N.transpose()).diagonal().cwiseMax(0).cwiseSqrt()), output_.sigma_rad + 3 * i);
        }
        const Vector3 bias_variance = filter_->bias_variances(At::shown);
        for (int k = 0; k < 3; ++k) {
            const double weight = bias_variance[k] / (bias_variance[k] + h.bias_variance[k]);
            if (output_.gyro_bias_rad_s) output_.gyro_bias_rad_s[3 * i + k] = e.bias_b[k] + weight * (h.bias[k] - e.bias_b[k]);
            if (output_.gyro_bias_sigma_rad_s)
                output_.gyro_bias_sigma_rad_s[3 * i + k] = std::sqrt(std::fmax(0, (1 - weight) * bias_variance[k]));
        }
        const double t_s = input_.t_s[i];
        if (output_.accel_nis) output_.accel_nis[i] = nis_at(filter_, accel, t_s);
        if (output_.mag_nis) output_.mag_nis[i] = nis_at(filter_, mag, t_s);
        if (output_.ready) output_.ready[2 * i] = output_.ready[2 * i + 1] = 1;
    }

    hnav_filter* filter_;
    size_t n_;
    const hnav_run_input& input_;
    const hnav_run_output& output_;
    Hindsight* hindsight_;
};

hnav_status check_arrays(hnav_filter* filter, size_t n, const hnav_run_input* input, const hnav_run_output* output) {
    REQUIRE(filter, input);
    REQUIRE(filter, output);
    if (n > 0) REQUIRE(filter, input->t_s);
    return HNAV_OK;
}

} // namespace

extern "C" {

hnav_status hnav_filter_run(hnav_filter* filter, size_t n, const hnav_run_input* input, const hnav_run_output* output,
                            size_t* rows_done) {
    if (rows_done) *rows_done = 0;
    hnav_status status = check_arrays(filter, n, input, output);
    if (status != HNAV_OK) return status;
    for (size_t i = 0; i < n; ++i) {
        const double t_s = input->t_s[i];
        status = take_row(filter, t_s, row(input->rate_b_rad_s, i), row(input->force_b_m_s2, i), row(input->field_b_tesla, i));
        if (status != HNAV_OK) return in_row(filter, status, i);
        write_row(filter, t_s, *output, i);
        if (rows_done) *rows_done = i + 1;
    }
    return HNAV_OK;
}

hnav_status hnav_filter_smooth(hnav_filter* filter, size_t n, const hnav_run_input* input, const hnav_run_output* output) {
    hnav_status status = check_arrays(filter, n, input, output);
    if (status != HNAV_OK || n == 0) return status;
    if (!filter->turns_back()) return filter->fail(HNAV_ERROR_UNSUPPORTED, "this filter has no smoother: the AHRS has");
    auto* hindsight = static_cast<Hindsight*>(std::malloc(n * sizeof(Hindsight)));
    if (!hindsight) return filter->fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory to smooth %zu rows", n);
    filter->reset();
    status = Smoother(filter, n, *input, *output, hindsight).run();
    std::free(hindsight);
    filter->reset();
    return status;
}

} // extern "C"
