// Objects share nothing: eight threads, each with its own filters, give the same bits as one thread alone. Under the thread
// sanitizer (preset tsan) it also proves that no memory is shared.
#include "hnav/hnav.h"

#include <gtest/gtest.h>
#include <cmath>
#include <thread>
#include <vector>

namespace {

constexpr int threads = 8;
constexpr int samples = 300;

// The work of one thread, from create to destroy: motion that differs by thread. Returns the saved states at the end.
template <class Options>
std::vector<unsigned char> life_of_a_filter(hnav_status (*create)(hnav_filter**, const Options*, char*, size_t), Options options,
                                            int solver, int thread) {
    options.solver = solver;
    hnav_filter* filter = nullptr;
    EXPECT_EQ(create(&filter, &options, nullptr, 0), HNAV_OK);
    for (int k = 0; k < samples; ++k) {
        const double t_s = 0.01 * k, turn = 0.3 + 0.1 * thread;
        const double rate[3] = {0.02, -0.01, turn}, force[3] = {0.3, 0.1 * thread, -9.79};
        const double field[3] = {2e-5 * std::cos(turn * t_s), -2e-5 * std::sin(turn * t_s), 4.3e-5};
        EXPECT_EQ(hnav_filter_push_imu(filter, t_s, rate, force), HNAV_OK);
        if (k % 2 == 0) {
            EXPECT_EQ(hnav_filter_push_mag(filter, t_s, field), HNAV_OK);
        }
        EXPECT_EQ(hnav_filter_advance(filter, t_s), HNAV_OK);
    }
    size_t bytes = 0;
    EXPECT_EQ(hnav_filter_state_size(filter, &bytes), HNAV_OK);
    std::vector<unsigned char> state(bytes);
    EXPECT_EQ(hnav_filter_save(filter, state.data(), bytes), HNAV_OK);
    hnav_filter_destroy(filter);
    return state;
}

std::vector<unsigned char> life_of_an_ins_error_filter(int thread) {
    const double one = 1, A = 0.9 + 0.01 * thread, An = 0.8, Q = 0.01;
    auto model = hnav_sized<hnav_ins_error_model>();
    model.nx = model.nz = model.nw = model.nl = 1;
    model.A = &A;
    model.H = model.P0 = &one;
    model.An = &An;
    model.Qw = model.Qv = model.QU = &Q;
    const hnav_ins_error_options options = hnav_ins_error_defaults();
    hnav_ins_error_filter* filter = nullptr;
    EXPECT_EQ(hnav_ins_error_filter_create(&filter, &options, &model, nullptr, 0), HNAV_OK);
    for (int k = 0; k < samples; ++k) {
        const double z = std::sin(0.1 * k + thread);
        EXPECT_EQ(hnav_ins_error_filter_step(filter, nullptr, &z, nullptr), HNAV_OK);
    }
    size_t bytes = 0;
    EXPECT_EQ(hnav_ins_error_filter_state_size(filter, &bytes), HNAV_OK);
    std::vector<unsigned char> state(bytes);
    EXPECT_EQ(hnav_ins_error_filter_save(filter, state.data(), bytes), HNAV_OK);
    hnav_ins_error_filter_destroy(filter);
    return state;
}

using State = std::vector<unsigned char>;

std::vector<State> all_lives(int thread) {
    const auto hrekf = hnav_hrekf_defaults(HNAV_PRESET_DEFAULT);
    const auto ahrs = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    return {life_of_a_filter(hnav_hrekf_create, hrekf, HNAV_SOLVER_ERKSTEP, thread),
            life_of_a_filter(hnav_hrekf_create, hrekf, HNAV_SOLVER_ADAMS, thread),
            life_of_a_filter(hnav_ahrs_create, ahrs, HNAV_SOLVER_CLOSED_FORM, thread),
            life_of_a_filter(hnav_ahrs_create, ahrs, HNAV_SOLVER_ERKSTEP, thread), life_of_an_ins_error_filter(thread)};
}

} // namespace

TEST(Threads, EightOfThemGiveTheBitsOfOne) {
    std::vector<std::vector<State>> alone, together(threads);
    for (int i = 0; i < threads; ++i) alone.push_back(all_lives(i));
    std::vector<std::thread> running;
    for (int i = 0; i < threads; ++i) running.emplace_back([i, &together] { together[i] = all_lives(i); });
    for (std::thread& t : running) t.join();
    for (int i = 0; i < threads; ++i) EXPECT_EQ(together[i], alone[i]) << "thread " << i;
    EXPECT_NE(alone[0], alone[1]); // so that equality is significant
}
