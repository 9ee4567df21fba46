// Calls for importers of FMUs beside the estimate: steps without a look-ahead, steps back, and derivatives.
#include "hnav/hnav.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace {

using FilterPtr = std::unique_ptr<hnav_filter, decltype(&hnav_filter_destroy)>;

FilterPtr make(bool ahrs, double horizon_s = 0) {
    hnav_filter* filter = nullptr;
    if (ahrs) {
        hnav_ahrs_options options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
        options.horizon_s = horizon_s;
        EXPECT_EQ(hnav_ahrs_create(&filter, &options, nullptr, 0), HNAV_OK);
    } else {
        hnav_hrekf_options options = hnav_hrekf_defaults(HNAV_PRESET_DEFAULT);
        options.horizon_s = horizon_s;
        EXPECT_EQ(hnav_hrekf_create(&filter, &options, nullptr, 0), HNAV_OK);
    }
    return {filter, hnav_filter_destroy};
}

void push(hnav_filter* filter, int k) {
    const double t_s = 0.01 * k, rate[3] = {0.1, std::sin(t_s), 0}, force[3] = {0.5, 0, -9.8}, field[3] = {2e-5, 0, 4e-5};
    ASSERT_EQ(hnav_filter_push_imu(filter, t_s, rate, force), HNAV_OK);
    ASSERT_EQ(hnav_filter_push_mag(filter, t_s, field), HNAV_OK);
}

std::vector<double> shown(const hnav_filter* filter) {
    auto a = hnav_sized<hnav_attitude>();
    EXPECT_EQ(hnav_filter_attitude(filter, &a), HNAV_OK);
    std::vector<double> all(a.q_nb, a.q_nb + 4);
    all.insert(all.end(), a.sigma_rad, a.sigma_rad + 3);
    all.push_back(a.t_s);
    std::vector<double> covariance(36);
    EXPECT_EQ(hnav_filter_covariance(filter, covariance.data()), HNAV_OK);
    all.insert(all.end(), covariance.begin(), covariance.end());
    return all;
}

class ImporterCalls : public testing::TestWithParam<bool> {};

TEST_P(ImporterCalls, CommitIsAdvanceWithoutTheLookAhead) {
    const auto looking = make(GetParam()), still = make(GetParam());
    for (int k = 0; k < 50; ++k) {
        push(looking.get(), k);
        push(still.get(), k);
        ASSERT_EQ(hnav_filter_advance(looking.get(), 0.01 * k + 0.007), HNAV_OK);
        ASSERT_EQ(hnav_filter_commit(still.get(), 0.01 * k + 0.007), HNAV_OK);
    }
    auto newest = hnav_sized<hnav_posterior>();
    ASSERT_EQ(hnav_filter_posterior(still.get(), &newest), HNAV_OK);
    auto now = hnav_sized<hnav_attitude>();
    ASSERT_EQ(hnav_filter_attitude(still.get(), &now), HNAV_OK);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(now.q_nb[i], newest.q_nb[i]); // it shows the estimate at the newest sample
    EXPECT_EQ(hnav_filter_commit(still.get(), 0.4), HNAV_ERROR_TIME_BACKWARDS);
    ASSERT_EQ(hnav_filter_advance(still.get(), 0.497), HNAV_OK);
    EXPECT_EQ(shown(still.get()), shown(looking.get()));
    auto few = hnav_sized<hnav_diagnostics>(), many = hnav_sized<hnav_diagnostics>();
    hnav_filter_diagnostics(still.get(), &few);
    hnav_filter_diagnostics(looking.get(), &many);
    EXPECT_LT(few.solver_rhs_evals, 0.6 * many.solver_rhs_evals);
}

TEST_P(ImporterCalls, SnapshotsOfAnySizeGoOnBitForBit) {
    const auto filter = make(GetParam(), 0.05), other = make(GetParam(), 0.05);
    const auto go = [](hnav_filter* f, int first) {
        for (int k = first; k < first + 3; ++k) {
            push(f, k);
            EXPECT_EQ(hnav_filter_advance(f, 0.01 * k + 0.004), HNAV_OK);
        }
        return shown(f);
    };
    std::vector<std::vector<unsigned char>> snapshots;
    std::vector<std::vector<double>> ends;
    for (int part = 0; part < 5; ++part) { // the first are shorter than the horizon
        size_t bytes = 0;
        ASSERT_EQ(hnav_filter_snapshot_size(filter.get(), &bytes), HNAV_OK);
        snapshots.emplace_back(bytes);
        ASSERT_EQ(hnav_filter_take_snapshot(filter.get(), snapshots.back().data(), bytes), HNAV_OK);
        EXPECT_EQ(hnav_filter_take_snapshot(filter.get(), snapshots.back().data(), bytes - 1), HNAV_ERROR_SIZE);
        ends.push_back(go(filter.get(), 3 * part));
    }
    EXPECT_NE(snapshots[0].size(), snapshots[2].size());
    for (const int part : {3, 0, 4, 1, 2})
        for (hnav_filter* f : {filter.get(), other.get()}) {
            ASSERT_EQ(hnav_filter_restore_snapshot(f, snapshots[part].data(), snapshots[part].size()), HNAV_OK);
            EXPECT_EQ(go(f, 3 * part), ends[part]);
        }
    const auto before = shown(filter.get());
    for (const size_t bytes : {size_t{0}, size_t{8}, snapshots[2].size() - 1})
        EXPECT_EQ(hnav_filter_restore_snapshot(filter.get(), snapshots[2].data(), bytes), HNAV_ERROR_STATE_CORRUPT);
    EXPECT_EQ(shown(filter.get()), before);
}

// A wrong element changes sums of products of the outputs; all pairs are compared through the FMUs.
TEST_P(ImporterCalls, WhatIsShownChangesAsItsDerivativeSays) {
    const auto filter = make(GetParam());
    int32_t nx = 0;
    hnav_filter_nx(filter.get(), &nx);
    std::vector<double> x(nx), seed(nx);
    hnav_filter_get_x(filter.get(), x.data());
    for (int k = 0; k < 2; ++k) { // a start takes two samples
        push(filter.get(), k);
        ASSERT_EQ(hnav_filter_jump(filter.get(), 0.01 * k, x.data(), x.data()), HNAV_OK);
    }
    for (int i = 0; i < nx; ++i) seed[i] = (i < 4 ? 1 : 1e-3) * std::sin(1 + i);
    const auto at = [&](double step) {
        std::vector<double> moved(x);
        for (int i = 0; i < nx; ++i) moved[i] += step * seed[i];
        EXPECT_EQ(hnav_filter_show(filter.get(), 0.012, moved.data()), HNAV_OK);
        return shown(filter.get());
    };
    constexpr double step = 1e-5;
    const auto plus = at(step), minus = at(-step);
    at(0);
    auto along = hnav_sized<hnav_shown_along>();
    ASSERT_EQ(hnav_filter_shown_along(filter.get(), seed.data(), &along), HNAV_OK);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(along.q_nb[i], (plus[i] - minus[i]) / (2 * step), 1e-8);
    for (int i = 0; i < 36; ++i) EXPECT_NEAR(along.covariance[i], (plus[8 + i] - minus[8 + i]) / (2 * step), 1e-8);

    EXPECT_EQ(hnav_filter_shown_along(filter.get(), nullptr, &along), HNAV_ERROR_NULL_ARGUMENT);
    along.size = 1;
    EXPECT_EQ(hnav_filter_shown_along(filter.get(), seed.data(), &along), HNAV_ERROR_SIZE);
}

INSTANTIATE_TEST_SUITE_P(Filters, ImporterCalls, testing::Bool(),
                         [](const auto& which) { return which.param ? "ahrs" : "hrekf"; });

} // namespace
