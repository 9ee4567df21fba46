// The C boundary of the INS: the smoother of whole recordings.
#include "base/memory.hpp"
#include "c_api/ins_object.hpp"
#include "ins/smoother/smoother.hpp"

#include <algorithm>
#include <iterator>

using namespace hnav;
using namespace hnav::ins_boundary;

namespace {

// The arrays and the filter's options as the smoother's interface.
class Arrays final : public ins::Recording {
public:
    Arrays(InsObject* object, std::size_t n, const hnav_ins_run_input& in, const hnav_ins_run_output& out)
        : object_(object), n_(n), in_(in), out_(out), every_(out.every > 0 ? out.every : 1) {}
    ~Arrays() { release_block(aids_); }
    Arrays(const Arrays&) = delete;
    Arrays& operator=(const Arrays&) = delete;

    hnav_status take_aids();
    hnav_status check_times() const;

    std::size_t rows() const override { return n_; }
    double t_s(std::size_t row) const override { return in_.t_s[row]; }
    bool imu_sample(std::size_t row, ins::Sample* sample) override {
        const double *rate = in_.rate_b_rad_s + 3 * row, *force = in_.force_b_m_s2 + 3 * row;
        if (is_missing(rate) || is_missing(force)) return false;
        const double value[6] = {rate[0], rate[1], rate[2], force[0], force[1], force[2]};
        return sample_of(object_, in_.t_s[row], ins::imu, value, sample) == HNAV_OK;
    }
    std::size_t aids() const override { return count_; }
    const ins::Sample& aid(std::size_t i) const override { return aids_[i]; }

    unsigned char write(std::size_t row, const ins::State& shown, double ahead_s) override {
        const hnav_navigation n = navigation(object_->filter.model(), shown, ahead_s, in_.t_s[row]);
        if (is_written(row)) write_row(n, out_, row / every_);
        return static_cast<unsigned char>(n.tilt_ready | n.heading_ready << 1 | n.velocity_ready << 2 | n.position_ready << 3);
    }
    void write(std::size_t row, const ins::SmoothedRow& smoothed) override;

private:
    // The last of so many rows.
    bool is_written(std::size_t row) const { return (row + 1) % every_ == 0; }

    InsObject* object_;
    std::size_t n_;
    const hnav_ins_run_input in_;
    hnav_ins_run_output out_;
    std::size_t every_, count_ = 0;
    ins::Sample* aids_ = nullptr;
};

// By time, and within one time in an order that is independent of the arrival.
bool comes_before(const ins::Sample& a, const ins::Sample& b) {
    if (a.t_s != b.t_s) return a.t_s < b.t_s;
    if (a.channel != b.channel) return a.channel < b.channel;
    return std::lexicographical_compare(std::begin(a.value), std::end(a.value), std::begin(b.value), std::end(b.value));
}

// Aids that have arrived by the last row, in the order of their times. Values that push refuses are not used.
hnav_status Arrays::take_aids() {
    aids_ = static_cast<ins::Sample*>(take_block(in_.aids * sizeof(ins::Sample) + 1));
    if (!aids_) return object_->fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory to smooth %zu aids", in_.aids);
    for (std::size_t i = 0; i < in_.aids; ++i) {
        if (const hnav_status none = check_aid(object_, in_, i)) return none;
        const double received_s = in_.aid_received_s ? in_.aid_received_s[i] : in_.aid_t_s[i];
        if (!(n_ > 0 && received_s <= in_.t_s[n_ - 1] && in_.aid_t_s[i] <= in_.t_s[n_ - 1])) continue;
        const double* value = in_.aid_value + max_values * i;
        count_ += sample_of(object_, in_.aid_t_s[i], channel_of(in_.aid_sensor[i]), value, aids_ + count_) == HNAV_OK;
    }
    std::sort(aids_, aids_ + count_, comes_before);
    return HNAV_OK;
}

hnav_status Arrays::check_times() const {
    for (std::size_t i = 0; i < n_; ++i) {
        hnav_status status = check_time(object_, in_.t_s[i]);
        if (status == HNAV_OK && i > 0 && in_.t_s[i] < in_.t_s[i - 1])
            status = object_->fail(HNAV_ERROR_TIME_BACKWARDS, "t_s = %.9g s is before that of the row before it", in_.t_s[i]);
        if (status != HNAV_OK) return in_row(object_, status, i);
    }
    return HNAV_OK;
}

// at_rest is that of the filter.
void Arrays::write(std::size_t row, const ins::SmoothedRow& smoothed) {
    if (!is_written(row)) return;
    const std::size_t i = row / every_;
    hnav_navigation n{};
    n.t_s = in_.t_s[row];
    fill(smoothed.navigation, &n);
    store(smoothed.gyro_bias, n.gyro_bias_rad_s);
    store(smoothed.accel_bias, n.accel_bias_m_s2);
    n.phase = HNAV_INS_PHASE_NAVIGATING;
    hnav_ins_run_output out = out_;
    out.at_rest = nullptr;
    write_row(n, out, i);
}

} // namespace

extern "C" hnav_status hnav_ins_smooth(hnav_filter* filter, size_t n, const hnav_ins_run_input* input,
                                       const hnav_ins_run_output* output) {
    REQUIRE_OBJECT(InsObject, object, filter);
    if (const hnav_status status = check_arrays(object, n, input, output)) return status;
    Arrays arrays(object, n, take_in(*input), take_in(*output));
    hnav_status status = arrays.check_times();
    if (status == HNAV_OK) status = arrays.take_aids();
    if (status != HNAV_OK) return status;
    if (ins::smooth(object->filter.model(), arrays) != ins::Smoothing::done)
        return object->fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory to smooth %zu rows", n);
    return HNAV_OK;
}
