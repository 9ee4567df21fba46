// The C boundary of the INS: the smoother of whole recordings.
#include "base/instant.hpp"
#include "base/memory.hpp"
#include "c_api/ins_object.hpp"
#include "ins/smoother/smoother.hpp"

#include <algorithm>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>

using namespace hnav;
using namespace hnav::ins_boundary;

namespace {

// The arrays and the filter's options as the smoother's interface. Times are those that the filter gives the stamps.
class Arrays final : public ins::Recording {
public:
    Arrays(InsObject* object, std::size_t n, const hnav_ins_run_input& in, const hnav_ins_run_output& out)
        : object_(object), n_(n), in_(in), out_(out), every_(out.every > 0 ? out.every : 1) {}
    ~Arrays() {
        release_block(rows_s_);
        release_block(readings_);
    }
    Arrays(const Arrays&) = delete;
    Arrays& operator=(const Arrays&) = delete;

    // Places all samples. Samples that push refuses for their value are not used.
    hnav_status place();

    std::size_t rows() const override { return n_; }
    double t_s(std::size_t row) const override { return rows_s_[row]; }
    std::size_t samples() const override { return count_; }
    double sample_s(std::size_t i) const override { return readings_[i].t_s; }
    int channel(std::size_t i) const override { return readings_[i].channel; }
    bool begins_time_base(std::size_t i) const override { return readings_[i].begins_time_base; }
    ins::Sample sample(std::size_t i) const override {
        const Reading& of = readings_[i];
        ins::Sample sample;
        if (of.channel == ins::imu) imu_of(of.from, &sample);
        else aid_of(of.from, &sample);
        sample.t_s = of.t_s;
        return sample;
    }

    unsigned char write(std::size_t row, const ins::State& shown, double ahead_s) override {
        const hnav_navigation n = navigation(object_->filter.model(), shown, ahead_s, rows_s_[row]);
        if (is_written(row)) write_row(n, out_, row / every_);
        return static_cast<unsigned char>(n.tilt_ready | n.heading_ready << 1 | n.velocity_ready << 2 | n.position_ready << 3);
    }
    void write(std::size_t row, const ins::SmoothedRow& smoothed) override;

private:
    using Timing = std::decay_t<decltype(std::declval<InsObject>().filter.stamps())>;

    // A sample, by the row or aid that has its values.
    struct Reading {
        double t_s;
        std::size_t from;
        std::uint32_t turn; // number of samples that arrived before it; in the end, of its instant and channel
        std::int16_t channel;
        bool begins_time_base;
    };

    // The last of so many rows.
    bool is_written(std::size_t row) const { return (row + 1) % every_ == 0; }
    hnav_status imu_of(std::size_t row, ins::Sample* sample) const;
    hnav_status aid_of(std::size_t aid, ins::Sample* sample) const;
    hnav_status place_row(std::size_t i, std::size_t* aid);
    bool place_one(const ins::Sample& sample, std::size_t from);
    void sort_into_events();

    InsObject* object_;
    std::size_t n_;
    const hnav_ins_run_input in_;
    hnav_ins_run_output out_;
    std::size_t every_, count_ = 0;
    double* rows_s_ = nullptr;
    Reading* readings_ = nullptr;
    Timing stamps_;
    double shown_s_ = -std::numeric_limits<double>::infinity(), newest_s_ = shown_s_; // of the last row; of all samples and rows
};

hnav_status Arrays::imu_of(std::size_t row, ins::Sample* sample) const {
    const double *rate = in_.rate_b_rad_s + 3 * row, *force = in_.force_b_m_s2 + 3 * row;
    const double value[6] = {rate[0], rate[1], rate[2], force[0], force[1], force[2]};
    return sample_of(object_, in_.t_s[row], ins::imu, value, sample);
}

hnav_status Arrays::aid_of(std::size_t aid, ins::Sample* sample) const {
    return sample_of(object_, in_.aid_t_s[aid], channel_of(in_.aid_sensor[aid]), in_.aid_value + max_values * aid, sample);
}

// Returns false if its stamp is rejected.
bool Arrays::place_one(const ins::Sample& sample, std::size_t from) {
    constexpr double none_is_late_s = -std::numeric_limits<double>::infinity();
    const double limit_s = object_->filter.model().options().time_jump_limit_s;
    const auto placed =
        stamps_.place(sample.channel, sample.t_s, shown_s_, none_is_late_s, limit_s, [this] { return newest_s_; });
    if (placed.how == Timing::Place::left_out) return false;
    readings_[count_] = {placed.t_s, from, static_cast<std::uint32_t>(count_), static_cast<std::int16_t>(sample.channel),
                         placed.how == Timing::Place::jumped};
    ++count_;
    newest_s_ = std::fmax(newest_s_, placed.t_s);
    return true;
}

hnav_status Arrays::place() {
    rows_s_ = static_cast<double*>(take_block(n_ * sizeof(double) + 1));
    readings_ = static_cast<Reading*>(take_block((n_ + in_.aids) * sizeof(Reading) + 1));
    if (!rows_s_ || !readings_)
        return object_->fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory to smooth %zu rows and %zu aids", n_, in_.aids);
    std::size_t aid = 0;
    for (std::size_t i = 0; i < n_; ++i)
        if (const hnav_status status = place_row(i, &aid)) return in_row(object_, status, i);
    for (; aid < in_.aids; ++aid)
        if (const hnav_status none = check_aid(object_, in_, aid)) return none;
    sort_into_events();
    return HNAV_OK;
}

// As take_row of a filter that waits for late samples: places the samples of a row and the aids that have arrived by then.
hnav_status Arrays::place_row(std::size_t i, std::size_t* aid) {
    if (const hnav_status status = check_time(object_, in_.t_s[i])) return status;
    ins::Sample sample;
    const bool has_imu =
        !is_missing(in_.rate_b_rad_s + 3 * i) && !is_missing(in_.force_b_m_s2 + 3 * i) && imu_of(i, &sample) == HNAV_OK;
    rows_s_[i] = shown_s_;
    if (has_imu && !place_one(sample, i)) return HNAV_OK; // the row has no time
    const double* received_s = in_.aid_received_s ? in_.aid_received_s : in_.aid_t_s;
    for (; *aid < in_.aids && received_s[*aid] <= in_.t_s[i]; ++*aid) {
        if (const hnav_status none = check_aid(object_, in_, *aid)) return none;
        if (aid_of(*aid, &sample) == HNAV_OK) place_one(sample, *aid);
    }
    const double row_s = clock_time(in_.t_s[i]) + stamps_.offset_s();
    if (!has_imu && row_s < shown_s_ - sample_instant_s(shown_s_))
        return object_->fail(HNAV_ERROR_TIME_BACKWARDS, "t_s = %.9g s is before that of the row before it", in_.t_s[i]);
    rows_s_[i] = shown_s_ = std::fmax(shown_s_, row_s);
    newest_s_ = std::fmax(newest_s_, shown_s_);
    return HNAV_OK;
}

// By time, and within an instant in the events of the filter's queue: the first samples of all channels, then the second ones.
void Arrays::sort_into_events() {
    const auto sort_by = [this](auto key) {
        std::sort(readings_, readings_ + count_, [key](const Reading& a, const Reading& b) { return key(a) < key(b); });
    };
    sort_by([](const Reading& r) { return std::tuple(r.t_s, r.turn); });
    std::uint32_t turns[ins::channel_count] = {};
    double instant_s = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < count_; ++i) {
        Reading& r = readings_[i];
        if (!(r.t_s <= instant_s + sample_instant_s(instant_s))) {
            instant_s = r.t_s;
            std::fill_n(turns, ins::channel_count, 0);
        }
        r.t_s = instant_s;
        r.turn = turns[r.channel]++;
    }
    sort_by([](const Reading& r) { return std::tuple(r.t_s, r.turn, r.channel); });
}

// at_rest is that of the filter.
void Arrays::write(std::size_t row, const ins::SmoothedRow& smoothed) {
    if (!is_written(row)) return;
    const std::size_t i = row / every_;
    hnav_navigation n{};
    n.t_s = rows_s_[row];
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
    if (const hnav_status status = arrays.place()) return status;
    if (ins::smooth(object->filter.model(), arrays) != ins::Smoothing::done)
        return object->fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory to smooth %zu rows", n);
    return HNAV_OK;
}
