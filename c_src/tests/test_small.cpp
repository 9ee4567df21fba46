// The small build: the same answers as the library's closed form, in the caller's memory, without the heap. The library is
// loaded from its file at run time, because both have the same names. In single precision the answers differ by roundings of float.
#include "hnav/hrekf.h"

#include "counted_heap.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace {

constexpr std::size_t max_bytes = 26 * 1024; // of a filter in double precision
constexpr double interval_s = 0.005;
// Beside roundings: what counts as motion depends on a small difference of large variances (explained_force2), and amplifies them. Measured in
// float: 9e-6 of q (1e-3 deg), 2e-6 rad/s of the bias, and 5e-4 rad of a sigma of .3 rad with a finite gamma.
constexpr bool single = sizeof(HNAV_SCALAR) == sizeof(float);
constexpr double rounding = single ? 5e-5 : 5e-11, rounding_of_sigma = single ? 1e-3 : 5e-11;

// Functions of the library, by the types that its header gives them.
template <class Function>
Function* of_library(const char* name) {
    static void* const library = dlopen(HNAV_LIBRARY_FILE, RTLD_NOW | RTLD_LOCAL);
    return library ? reinterpret_cast<Function*>(dlsym(library, name)) : nullptr;
}
#define OF_LIBRARY(name) of_library<decltype(name)>(#name)

struct Ahrs {
    using Options = hnav_ahrs_options;
    static Options defaults() { return hnav_ahrs_defaults(HNAV_PRESET_DEFAULT); }
    static constexpr auto bytes = hnav_ahrs_memory_bytes;
    static constexpr auto create = hnav_ahrs_create;
    static constexpr auto create_in = hnav_ahrs_create_in;
    static auto create_of_library() { return OF_LIBRARY(hnav_ahrs_create); }
    static std::vector<Options> variants(const Options& options) { return {options}; }
};

struct Hrekf {
    using Options = hnav_hrekf_options;
    static Options defaults() { return hnav_hrekf_defaults(HNAV_PRESET_DEFAULT); }
    static constexpr auto bytes = hnav_hrekf_memory_bytes;
    static constexpr auto create = hnav_hrekf_create;
    static constexpr auto create_in = hnav_hrekf_create_in;
    static auto create_of_library() { return OF_LIBRARY(hnav_hrekf_create); }
    static std::vector<Options> variants(Options options) {
        std::vector<Options> all{options};
        options.gamma = 100;
        options.adaptation_min_rad_s_per_sqrt_s = 1e-5;
        options.adaptation_max_rad_s_per_sqrt_s = 1e-3;
        for (options.gamma_mode = HNAV_GAMMA_OFF; options.gamma_mode <= HNAV_GAMMA_KL; ++options.gamma_mode)
            for (const int adaptation : {HNAV_ADAPTATION_OFF, HNAV_ADAPTATION_CORRECTED}) {
                options.adaptation = adaptation;
                all.push_back(options);
            }
        return all;
    }
};

// The outputs as numbers; each build fills them by its own functions.
struct Shown {
    hnav_attitude attitude;
    double rate[3], bias[3], bias_sigma[3], covariance[36];
};

template <class Attitude, class Rate, class Bias, class Covariance>
hnav_status show(hnav_filter* filter, Attitude* attitude, Rate* rate, Bias* bias, Covariance* covariance, Shown* shown) {
    std::memset(shown, 0, sizeof *shown);
    shown->attitude.size = sizeof shown->attitude;
    hnav_status status = attitude(filter, &shown->attitude);
    if (status == HNAV_OK) status = rate(filter, shown->rate);
    if (status == HNAV_OK) status = bias(filter, shown->bias, shown->bias_sigma);
    if (status == HNAV_OK) status = covariance(filter, shown->covariance);
    return status;
}

void expect_near(const double* a, const double* b, int count, double limit, const char* what, int k) {
    for (int i = 0; i < count; ++i) EXPECT_NEAR(a[i], b[i], limit) << what << " " << i << " at sample " << k;
}

// A body that tumbles, with its samples at an instant.
struct Moment {
    double t_s, rate[3], force[3], field[3];
    explicit Moment(int k) : t_s(interval_s * k) {
        const double roll = 0.7 * std::sin(0.9 * t_s), pitch = 0.5 * std::sin(0.6 * t_s), g = 9.80665;
        rate[0] = 0.63 * std::cos(0.9 * t_s) + 0.01 + 1e-3 * std::sin(211.0 * k);
        rate[1] = 0.3 * std::cos(0.6 * t_s) * std::cos(roll) - 0.005 + 1e-3 * std::sin(127.0 * k);
        rate[2] = -0.3 * std::cos(0.6 * t_s) * std::sin(roll) + 1e-3 * std::sin(83.0 * k);
        force[0] = g * std::sin(pitch) + 0.05 * std::sin(97.0 * k);
        force[1] = -g * std::sin(roll) * std::cos(pitch) + 0.05 * std::sin(61.0 * k);
        force[2] = -g * std::cos(roll) * std::cos(pitch) + 0.05 * std::sin(31.0 * k);
        const double north = 2e-5, down = 4.4e-5; // of a heading of zero
        field[0] = north * std::cos(pitch) - down * std::sin(pitch);
        field[1] = (north * std::sin(pitch) + down * std::cos(pitch)) * std::sin(roll);
        field[2] = (north * std::sin(pitch) + down * std::cos(pitch)) * std::cos(roll);
    }
};

template <class Filter>
class Small : public testing::Test {
protected:
    Small() : options(Filter::defaults()) {
        options.solver = HNAV_SOLVER_CLOSED_FORM;
        options.queue_capacity = 4;
    }
    hnav_status make() { return Filter::create_in(memory + 1, sizeof memory - 1, &filter, &options, message, sizeof message); }

    typename Filter::Options options;
    unsigned char memory[max_bytes]; // anything but zeros; begun at an odd address
    hnav_filter* filter = nullptr;
    char message[200] = "";
};

using Filters = testing::Types<Ahrs, Hrekf>;
TYPED_TEST_SUITE(Small, Filters, );

// Samples of all sensors, a gap, an impact, one aid, and shown times between and ahead.
template <class Push>
void stream(int k, Push&& push) {
    Moment m(k);
    if (k >= 1500 && k < 1650) return;
    if (k == 2200) m.force[2] -= 60;
    if (k == 2600) m.rate[1] = 30;
    push(m, k % 3 == 0, k % 400 == 7);
}

// Both filters over the same samples.
template <class Filter>
void compare(const typename Filter::Options& options, hnav_filter* small) {
    hnav_filter* whole = nullptr;
    ASSERT_NE(Filter::create_of_library(), nullptr);
    ASSERT_EQ(Filter::create_of_library()(&whole, &options, nullptr, 0), HNAV_OK);
    const auto imu = OF_LIBRARY(hnav_filter_push_imu);
    const auto mag = OF_LIBRARY(hnav_filter_push_mag);
    const auto aid = OF_LIBRARY(hnav_filter_push_heading);
    const auto advance = OF_LIBRARY(hnav_filter_advance);
    int compared = 0;
    for (int k = 0; k < 4000; ++k)
        stream(k, [&](const Moment& m, bool has_field, bool has_aid) {
            EXPECT_EQ(hnav_filter_push_imu(small, m.t_s, m.rate, m.force), imu(whole, m.t_s, m.rate, m.force));
            if (has_field) {
                EXPECT_EQ(hnav_filter_push_mag(small, m.t_s, m.field), mag(whole, m.t_s, m.field));
            }
            if (has_aid) {
                EXPECT_EQ(hnav_filter_push_heading(small, m.t_s, 0, 0.05), aid(whole, m.t_s, 0, 0.05));
            }
            if (k % 2 == 1) return; // two events for one advance
            const double shown_s = m.t_s + (k % 4 == 0 ? 0.002 : 0);
            EXPECT_EQ(hnav_filter_advance(small, shown_s), advance(whole, shown_s));
            Shown a, b;
            const hnav_status status =
                show(small, hnav_filter_attitude, hnav_filter_rate, hnav_filter_gyro_bias, hnav_filter_covariance, &a);
            EXPECT_EQ(status, show(whole, OF_LIBRARY(hnav_filter_attitude), OF_LIBRARY(hnav_filter_rate),
                                   OF_LIBRARY(hnav_filter_gyro_bias), OF_LIBRARY(hnav_filter_covariance), &b));
            if (status != HNAV_OK) return;
            ++compared;
            expect_near(a.attitude.q_nb, b.attitude.q_nb, 4, rounding, "q", k);
            expect_near(a.attitude.sigma_rad, b.attitude.sigma_rad, 3, rounding_of_sigma, "sigma", k);
            expect_near(a.bias, b.bias, 3, rounding, "bias", k);
            expect_near(a.bias_sigma, b.bias_sigma, 3, rounding_of_sigma, "sigma of bias", k);
            expect_near(a.covariance, b.covariance, 36, rounding_of_sigma, "covariance", k);
            EXPECT_EQ(a.attitude.tilt_ready, b.attitude.tilt_ready);
            EXPECT_EQ(a.attitude.heading_ready, b.attitude.heading_ready);
        });
    EXPECT_GT(compared, 1500);
    auto a = hnav_sized<hnav_diagnostics>(), b = a;
    hnav_filter_diagnostics(small, &a);
    OF_LIBRARY(hnav_filter_diagnostics)(whole, &b);
    EXPECT_EQ(a.corrections, b.corrections);
    EXPECT_EQ(a.covariance_repaired, b.covariance_repaired);
    OF_LIBRARY(hnav_filter_destroy)(whole);
}

} // namespace

TYPED_TEST(Small, AnswersAsTheLibraryDoesByTheClosedForm) {
    for (const auto& options : TypeParam::variants(this->options)) {
        this->options = options;
        ASSERT_EQ(this->make(), HNAV_OK) << this->message;
        compare<TypeParam>(options, this->filter);
        hnav_filter_destroy(this->filter);
    }
}

#ifdef HNAV_HEAP_IS_COUNTED
TYPED_TEST(Small, TakesNothingFromTheHeap) {
    heap::allocations = 0;
    heap::counting = true;
    hnav_status worst = this->make();
    const auto note = [&](hnav_status status) { worst = worst == HNAV_OK ? status : worst; };
    for (int k = 0; k < 1000; ++k) {
        const Moment m(k);
        note(hnav_filter_push_imu(this->filter, m.t_s, m.rate, m.force));
        note(hnav_filter_push_mag(this->filter, m.t_s, m.field));
        note(hnav_filter_advance(this->filter, m.t_s));
    }
    const hnav_status none = hnav_filter_push_gyro(this->filter, std::nan(""), Moment(0).rate);
    note(hnav_filter_reset(this->filter));
    hnav_filter_destroy(this->filter);
    heap::counting = false;
    EXPECT_EQ(worst, HNAV_OK);
    EXPECT_EQ(none, HNAV_ERROR_NON_FINITE);
    EXPECT_EQ(heap::allocations, 0);
}
#endif

TYPED_TEST(Small, SaysHowMuchMemoryItNeedsAndTakesNoMore) {
    const std::size_t bytes = TypeParam::bytes(&this->options);
    EXPECT_GT(bytes, 1000u);
    EXPECT_LE(bytes, max_bytes - 1);
    std::vector<unsigned char> memory(bytes + 8, 0x5a);
    char* const text = this->message;
    EXPECT_EQ(TypeParam::create_in(memory.data(), bytes - 1, &this->filter, &this->options, text, 200), HNAV_ERROR_SIZE);
    EXPECT_EQ(this->filter, nullptr);
    EXPECT_EQ(TypeParam::create_in(nullptr, bytes, &this->filter, &this->options, text, 200), HNAV_ERROR_NULL_ARGUMENT);
    ASSERT_EQ(TypeParam::create_in(memory.data(), bytes, &this->filter, &this->options, text, 200), HNAV_OK);
    for (int k = 0; k < 300; ++k) {
        const Moment m(k);
        EXPECT_EQ(hnav_filter_push_imu(this->filter, m.t_s, m.rate, m.force), HNAV_OK);
        EXPECT_EQ(hnav_filter_push_mag(this->filter, m.t_s, m.field), HNAV_OK);
        EXPECT_EQ(hnav_filter_advance(this->filter, m.t_s), HNAV_OK);
    }
    for (std::size_t i = bytes; i < memory.size(); ++i) EXPECT_EQ(memory[i], 0x5a);
}

TYPED_TEST(Small, RefusesWhatItDoesNotHave) {
    EXPECT_EQ(TypeParam::create(&this->filter, &this->options, this->message, 200), HNAV_ERROR_UNSUPPORTED);
    EXPECT_EQ(this->filter, nullptr);
    this->options.solver = HNAV_SOLVER_ERKSTEP;
    EXPECT_EQ(this->make(), HNAV_ERROR_UNSUPPORTED);
    EXPECT_STREQ(this->message, hnav_status_text(HNAV_ERROR_UNSUPPORTED));
    this->options.solver = HNAV_SOLVER_CLOSED_FORM;
    this->options.gyro_noise_rad_per_sqrt_s = -1;
    EXPECT_EQ(this->make(), HNAV_ERROR_OPTION);
    EXPECT_NE(std::string(this->message).find("gyro_noise_rad_per_sqrt_s"), std::string::npos) << this->message;
    EXPECT_EQ(TypeParam::bytes(&this->options), 0u);
}

// Waiting events: as many as the queue has places, late ones within the horizon, and too many.
TYPED_TEST(Small, HoldsAsManyWaitingInstantsAsItsQueue) {
    this->options.horizon_s = 0.1;
    ASSERT_EQ(this->make(), HNAV_OK);
    int k = 0;
    for (; k < 40; ++k) {
        const Moment m(k);
        ASSERT_EQ(hnav_filter_push_imu(this->filter, m.t_s, m.rate, m.force), HNAV_OK);
        if (k > 0) {
            const Moment late(k - 1); // its field comes with the next rate
            ASSERT_EQ(hnav_filter_push_mag(this->filter, late.t_s, late.field), HNAV_OK) << k;
        }
        ASSERT_EQ(hnav_filter_advance(this->filter, m.t_s), HNAV_OK);
    }
    hnav_status status = HNAV_OK;
    for (int more = 0; more < 5 && status == HNAV_OK; ++more)
        status = hnav_filter_push_gyro(this->filter, Moment(k + more).t_s, Moment(k).rate);
    EXPECT_EQ(status, HNAV_ERROR_QUEUE_FULL);
    EXPECT_EQ(hnav_filter_advance(this->filter, Moment(k + 4).t_s), HNAV_OK);
    auto shown = hnav_sized<hnav_attitude>();
    EXPECT_EQ(hnav_filter_attitude(this->filter, &shown), HNAV_OK);
    EXPECT_NEAR(shown.q_nb[0] * shown.q_nb[0] + shown.q_nb[1] * shown.q_nb[1] + shown.q_nb[2] * shown.q_nb[2] +
                    shown.q_nb[3] * shown.q_nb[3],
                1, rounding);
}
