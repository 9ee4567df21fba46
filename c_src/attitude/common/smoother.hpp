// Smoothing: a recording is filtered forward and backwards in time, and the two estimates of each row are fused.
//
// Forward, then twice backwards and forward, each pass started at the end of the one before, so that the sensor errors estimated by one
// pass are used by the next. The estimates of the last two passes are fused. If the smoothed heading departs from that of the first pass,
// which is the filter, by more than the filter's covariance allows, the heading of the filter is kept (Hindsight).
#pragma once

#include "maths/cholesky.hpp"
#include "maths/rotation.hpp"
#include "signals/hold.hpp"

#include <cmath>
#include <cstddef>

namespace hnav {

// The estimate of one row by one pass, in the time direction of the recording.
struct PassEstimate {
    Quaternion q_bn;
    Matrix3 rotation_covariance; // about the navigation axes
    Vector3 bias, bias_variance;
    bool tilt_ready, heading_ready, started;
};

// Two estimates of one attitude, weighted by their covariances: q = exp(W v) q_f, v = log(q_b conj(q_f)),
// W = P_f (P_f + P_b)^-1. Both passes use the same magnetic disturbances and the same sensors, so the covariance is not that of
// independent estimates, P_i = (I - W) P_f, but twice as large; and where the two disagree it contains both:
// P = 2 P_i + (W v) ((I - W) v)', made symmetric. The biases are fused component by component. An angle is ready if it is ready in the
// estimate with the smaller variance, which dominates the fusion.
inline PassEstimate fuse(const PassEstimate& forward, const PassEstimate& backward) {
    const Matrix3& P = forward.rotation_covariance;
    const Matrix3 W = Cholesky<3>(P + backward.rotation_covariance).solve<3>(P).transpose();
    const Vector3 v = rotation_vector(multiply(backward.q_bn, conjugate(forward.q_bn)));
    PassEstimate fused;
    fused.started = forward.started;
    fused.q_bn = multiply(rotation_quaternion(W * v), forward.q_bn);
    const Vector3 to_forward = W * v, to_backward = v - to_forward;
    const Matrix3 apart = to_forward * to_backward.transpose();
    fused.rotation_covariance = 2 * (P - W * P) + 0.5 * (apart + apart.transpose());
    for (int k = 0; k < 3; ++k) {
        const double variance = forward.bias_variance[k], weight = variance / (variance + backward.bias_variance[k]);
        fused.bias[k] = forward.bias[k] + weight * (backward.bias[k] - forward.bias[k]);
        fused.bias_variance[k] = (1 - weight) * variance;
    }
    const Vector3 f = P.diagonal(), b = backward.rotation_covariance.diagonal();
    fused.tilt_ready = (std::fmax(f[0], f[1]) <= std::fmax(b[0], b[1]) ? forward : backward).tilt_ready;
    fused.heading_ready = (f[2] <= b[2] ? forward : backward).heading_ready;
    return fused;
}

// Compares the smoothed heading of a whole recording with the filter's.
//
// If the models hold, the departure d of the smoothed heading has the variance P_f - P_s (Rauch, Tung and Striebel 1965), so the mean of
// d^2 / P_f is below 1, and as sigmas are on the safe side, below half of that. A larger mean contradicts the smoother. A mean above 9,
// three sigmas over the whole recording, contradicts the filter: a false field misled it from the start.
class Hindsight {
public:
    // Adds a row of weight T, s.
    void note(const PassEstimate& filter, const PassEstimate& smoothed, double T) {
        const double d = departure(filter, smoothed);
        departure_ += T * d * d / filter.rotation_covariance(2, 2);
        time_s_ += T;
    }

    bool is_less_likely() const {
        // Squared heading errors of recorded hands are half of the stated variance or less. Chosen: with 1 one of them would be 2.4 deg off in
        // hindsight, 1.0 deg without.
        constexpr double usual = 0.5, filter_wrong = 9;
        return departure_ > usual * time_s_ && departure_ < filter_wrong * time_s_;
    }

    // Departure of the smoothed heading from the filter's, about down, rad.
    static double departure(const PassEstimate& filter, const PassEstimate& smoothed) {
        return rotation_vector(multiply(smoothed.q_bn, conjugate(filter.q_bn)))[2];
    }

private:
    double departure_ = 0, time_s_ = 0;
};

// The smoothed estimate with the heading of the filter.
inline PassEstimate keep_heading(const PassEstimate& filter, const PassEstimate& smoothed) {
    PassEstimate e = smoothed;
    e.q_bn = multiply(rotation_quaternion<double>({0, 0, -Hindsight::departure(filter, smoothed)}), smoothed.q_bn);
    e.rotation_covariance.row(2).setZero();
    e.rotation_covariance.col(2).setZero();
    e.rotation_covariance(2, 2) = filter.rotation_covariance(2, 2);
    e.heading_ready = filter.heading_ready;
    return e;
}

// A Recording gives access to its rows and to the filter:
//     std::size_t size() const                      rows, at least one
//     double t_s(std::size_t row) const
//     Hold hold() const                             what a rate sample stands for
//     bool take(std::size_t row, double t_s, std::size_t rate_row, double rate_sign)
//                                                   processes a row at the filter's time t_s, with the rate of rate_row (size():
//                                                   none); false stops the smoother
//     bool started()                                the filter has an attitude; false stops the smoother
//     void turn_back(double t_s)                    time is reversed from here on, the next row at t_s
//     PassEstimate estimate() const                 of the row processed last
//     void record(std::size_t row)                  stores the verdicts of the filter on the row, in the last pass
//     void write(std::size_t row, const PassEstimate&)
template <class Recording>
class Smoother {
public:
    // Memory for two estimates of each row.
    Smoother(Recording& recording, PassEstimate* room)
        : recording_(recording), filter_(room), smoothed_(room + recording.size()) {}

    bool run() {
        if (!pass_forward(Pass::first) || !recording_.started()) return false;
        for (const Pass pass : {Pass::second, Pass::last}) {
            recording_.turn_back(0);
            if (!pass_backward(pass)) return false;
            recording_.turn_back(recording_.t_s(0));
            if (!pass_forward(pass)) return false;
        }
        write();
        return true;
    }

private:
    enum class Pass { first, second, last };

    bool pass_forward(Pass pass) {
        for (std::size_t i = 0; i < recording_.size(); ++i) {
            if (!recording_.take(i, recording_.t_s(i), i, 1)) return false;
            if (pass == Pass::first) filter_[i] = recording_.estimate();
            if (pass != Pass::last) continue;
            smoothed_[i] = fuse(recording_.estimate(), smoothed_[i]);
            recording_.record(i);
        }
        return true;
    }

    void write() {
        Hindsight hindsight;
        for (std::size_t i = 1; i < recording_.size(); ++i)
            if (filter_[i].started) hindsight.note(filter_[i], smoothed_[i], recording_.t_s(i) - recording_.t_s(i - 1));
        const bool forgo = hindsight.is_less_likely();
        for (std::size_t i = 0; i < recording_.size(); ++i)
            recording_.write(i, forgo && filter_[i].started ? keep_heading(filter_[i], smoothed_[i]) : smoothed_[i]);
    }

    // Time runs from the last row to the first. The rate changes its sign, and with it the bias; the sample that stood for
    // an interval stands on the interval's other end.
    bool pass_backward(Pass pass) {
        const std::size_t n = recording_.size();
        for (std::size_t i = n; i-- > 0;) {
            if (!recording_.take(i, recording_.t_s(n - 1) - recording_.t_s(i), rate_row_back(i), -1)) return false;
            if (pass != Pass::last) continue;
            smoothed_[i] = recording_.estimate();
            smoothed_[i].bias = -smoothed_[i].bias;
        }
        return true;
    }

    // Row whose rate ends the interval before row i in reversed time; size(): none.
    std::size_t rate_row_back(std::size_t i) const {
        if (recording_.hold() == Hold::instant) return i;
        if (recording_.hold() == Hold::backward) return i + 1;
        return i > 0 ? i - 1 : recording_.size();
    }

    Recording& recording_;
    PassEstimate* filter_;
    PassEstimate* smoothed_; // of the last pass backwards, until it is fused
};

} // namespace hnav
