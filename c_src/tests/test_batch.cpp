// Whole recordings: a batch accepts and refuses the same samples as a stream, and ready flags of the smoother follow those of
// the filter.
#include "hnav/hnav.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

namespace {

using Filter = std::unique_ptr<hnav_filter, decltype(&hnav_filter_destroy)>;

Filter make_ahrs() {
    hnav_filter* filter = nullptr;
    const auto options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    EXPECT_EQ(hnav_ahrs_create(&filter, &options, nullptr, 0), HNAV_OK);
    return {filter, hnav_filter_destroy};
}

// Columns of a level body that turns about the vertical, 100 Hz.
struct Recording {
    std::vector<double> t_s, rate, force, field;

    explicit Recording(int n) {
        std::mt19937 engine(1);
        std::normal_distribution<double> normal;
        for (int k = 0; k < n; ++k) {
            const double t = 0.01 * k, heading = 0.5 * t;
            t_s.push_back(t);
            for (double v : {0.0, 0.0, 0.5}) rate.push_back(v + 1e-3 * normal(engine));
            for (double v : {0.0, 0.0, -9.81}) force.push_back(v + 0.01 * normal(engine));
            for (double v : {2e-5 * std::cos(heading), -2e-5 * std::sin(heading), 4.5e-5})
                field.push_back(v + 1e-7 * normal(engine));
        }
    }
    std::size_t rows() const { return t_s.size(); }

    hnav_run_input view() const {
        auto input = hnav_sized<hnav_run_input>();
        input.t_s = t_s.data();
        input.rate_b_rad_s = rate.data();
        input.force_b_m_s2 = force.data();
        input.field_b_tesla = field.empty() ? nullptr : field.data();
        return input;
    }
};

hnav_diagnostics diagnostics(const Filter& filter) {
    auto s = hnav_sized<hnav_diagnostics>();
    EXPECT_EQ(hnav_filter_diagnostics(filter.get(), &s), HNAV_OK);
    return s;
}

std::vector<std::uint8_t> smoothed_ready(const Recording& recording) {
    std::vector<std::uint8_t> ready(2 * recording.rows());
    const hnav_run_input input = recording.view();
    auto output = hnav_sized<hnav_run_output>();
    output.ready = ready.data();
    const Filter filter = make_ahrs();
    EXPECT_EQ(hnav_filter_smooth(filter.get(), recording.rows(), &input, &output), HNAV_OK);
    return ready;
}

long count(const std::vector<std::uint8_t>& ready, std::size_t column) {
    long sum = 0;
    for (std::size_t i = column; i < ready.size(); i += 2) sum += ready[i];
    return sum;
}

} // namespace

// Out of range, infinite and without a direction: the same samples are omitted and counted.
TEST(Batch, ForgivesTheReadingsThatAStreamForgives) {
    Recording recording(300);
    recording.rate[3 * 50] = 1e7;
    recording.force[3 * 60 + 1] = std::numeric_limits<double>::infinity();
    recording.force[3 * 70] = std::nan("");
    for (int i = 0; i < 3; ++i) recording.field[3 * 80 + i] = 0;
    recording.field[3 * 90] = -2e6;
    const Filter batch = make_ahrs(), stream = make_ahrs();
    const hnav_run_input input = recording.view();
    const auto output = hnav_sized<hnav_run_output>();
    std::size_t done = 0;
    ASSERT_EQ(hnav_filter_run(batch.get(), recording.rows(), &input, &output, &done), HNAV_OK)
        << hnav_filter_message(batch.get());
    EXPECT_EQ(done, recording.rows());
    for (std::size_t k = 0; k < recording.rows(); ++k) {
        hnav_filter_push_gyro(stream.get(), recording.t_s[k], &recording.rate[3 * k]);
        hnav_filter_push_accel(stream.get(), recording.t_s[k], &recording.force[3 * k]);
        hnav_filter_push_mag(stream.get(), recording.t_s[k], &recording.field[3 * k]);
        ASSERT_EQ(hnav_filter_advance(stream.get(), recording.t_s[k]), HNAV_OK);
    }
    for (const Filter* filter : {&batch, &stream}) {
        const hnav_diagnostics s = diagnostics(*filter);
        EXPECT_EQ(s.non_finite, 4u);
        EXPECT_EQ(s.zero, 1u);
        EXPECT_EQ(s.used[HNAV_SENSOR_GYRO], 299u);
        EXPECT_EQ(s.used[HNAV_SENSOR_ACCEL], 298u);
        EXPECT_EQ(s.used[HNAV_SENSOR_MAG], 298u);
    }
    auto a = hnav_sized<hnav_attitude>(), b = hnav_sized<hnav_attitude>();
    ASSERT_EQ(hnav_filter_attitude(batch.get(), &a), HNAV_OK);
    ASSERT_EQ(hnav_filter_attitude(stream.get(), &b), HNAV_OK);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(a.q_nb[i], b.q_nb[i]);
}

TEST(Batch, AHeadingWithoutASensibleSigmaIsCountedToo) {
    const Filter filter = make_ahrs();
    EXPECT_EQ(hnav_filter_push_heading(filter.get(), 0, 1, 0), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(diagnostics(filter).non_finite, 1u);
}

TEST(Smoother, IsReadyOnEveryRowOfAGoodRecording) {
    const Recording recording(6000);
    const auto ready = smoothed_ready(recording);
    EXPECT_EQ(count(ready, 0), 6000);
    EXPECT_EQ(count(ready, 1), 6000);
}

TEST(Smoother, KnowsNoHeadingWithoutAMagnetometer) {
    Recording recording(6000);
    recording.field.clear();
    const auto ready = smoothed_ready(recording);
    EXPECT_EQ(count(ready, 0), 6000);
    EXPECT_EQ(count(ready, 1), 0);
}

// One second at rest is too short for readiness.
TEST(Smoother, IsNotReadyAfterAnInstant) {
    const auto ready = smoothed_ready(Recording(20));
    EXPECT_EQ(count(ready, 1), 0);
}
