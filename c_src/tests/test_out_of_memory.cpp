// Out of memory: whichever request fails, the call returns OUT_OF_MEMORY, frees all that it had, creates nothing and writes
// nothing. The next call succeeds.
#include "hnav/hnav.h"

#include "counted_heap.hpp"
#include "fuzz/ins_error.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#ifdef HNAV_HEAP_IS_COUNTED

namespace {

// A call that allocates from the heap.
struct Call {
    std::string name;
    std::function<hnav_status(char* message, std::size_t size)> make;
    std::function<bool()> exists = [] { return false; }; // whether the call has left an object
    std::function<void()> destroy = [] {};
};

template <class Object>
Call creation(const std::string& name, void (*destroy)(Object*),
              std::function<hnav_status(Object**, char*, std::size_t)> create) {
    auto object = std::make_shared<Object*>(nullptr);
    return {name, [=](char* message, std::size_t size) { return create(object.get(), message, size); },
            [=] { return *object != nullptr; },
            [=] {
                destroy(*object);
                *object = nullptr;
            }};
}

template <class Options>
Call filter(const std::string& name, hnav_status (*create)(hnav_filter**, const Options*, char*, size_t), Options options,
            int solver) {
    options.solver = solver;
    return creation<hnav_filter>(
        name + ", solver " + std::to_string(solver), hnav_filter_destroy,
        [=](hnav_filter** out, char* text, std::size_t size) { return create(out, &options, text, size); });
}

std::vector<Call> attitude_filters() {
    std::vector<Call> calls;
    for (int solver : {HNAV_SOLVER_ERKSTEP, HNAV_SOLVER_CLOSED_FORM, HNAV_SOLVER_ADAMS, HNAV_SOLVER_EULER}) {
        calls.push_back(filter("ahrs", hnav_ahrs_create, hnav_ahrs_defaults(HNAV_PRESET_DEFAULT), solver));
        calls.push_back(filter("hrekf", hnav_hrekf_create, hnav_hrekf_defaults(HNAV_PRESET_DEFAULT), solver));
    }
    return calls;
}

std::vector<Call> ins_error_filters() {
    std::vector<Call> calls;
    for (int form = HNAV_INS_ERROR_MDKF; form <= HNAV_INS_ERROR_PLAIN; ++form) {
        hnav_ins_error_options options = hnav_ins_error_defaults();
        options.form = form;
        calls.push_back(
            creation<hnav_ins_error_filter>("INS error filter, form " + std::to_string(form), hnav_ins_error_filter_destroy,
                                            [=](hnav_ins_error_filter** out, char* text, std::size_t size) {
                                                const fuzz::InsErrorModel model;
                                                return hnav_ins_error_filter_create(out, &options, &model.view, text, size);
                                            }));
    }
    return calls;
}

int decay(void*, double, const double* x, const double*, const double*, double* dx) {
    dx[0] = -x[0];
    return 0;
}

Call observer() {
    return creation<hnav_filter>("observer", hnav_filter_destroy, [](hnav_filter** out, char* text, std::size_t size) {
        const double one = 1;
        auto plant = hnav_sized<hnav_plant>();
        plant.n_states = plant.n_outputs = 1;
        plant.derivatives = plant.outputs = decay;
        auto known = hnav_sized<hnav_observer_statistics>();
        known.start_sigma = known.sensor_sigma = &one;
        const hnav_observer_options options = hnav_observer_defaults();
        return hnav_observer_create(out, &options, &plant, &known, text, size);
    });
}

std::vector<Call> plants() {
    return {creation<hnav_turntable>("turntable", hnav_turntable_destroy,
                                     [](hnav_turntable** out, char* text, std::size_t size) {
                                         const hnav_turntable_options options = hnav_turntable_defaults();
                                         return hnav_turntable_create(out, &options, text, size);
                                     }),
            creation<hnav_imu_mag_sensor>("sensor", hnav_imu_mag_sensor_destroy,
                                          [](hnav_imu_mag_sensor** out, char* text, std::size_t size) {
                                              const auto options = hnav_imu_mag_sensor_defaults();
                                              return hnav_imu_mag_sensor_create(out, &options, 0, text, size);
                                          }),
            creation<hnav_vehicle>("vehicle", hnav_vehicle_destroy,
                                   [](hnav_vehicle** out, char* text, std::size_t size) {
                                       const hnav_vehicle_options options = hnav_vehicle_defaults();
                                       return hnav_vehicle_create(out, &options, 0, text, size);
                                   }),
            creation<hnav_vehicle>("way", hnav_vehicle_destroy,
                                   [](hnav_vehicle** out, char* text, std::size_t size) {
                                       hnav_vehicle_options options = hnav_vehicle_defaults();
                                       options.kind = HNAV_VEHICLE_WAY;
                                       const hnav_way_point points[] = {{0, 0, 0, 0}, {1, 2, 0, 0}};
                                       return hnav_vehicle_create_along(out, &options, 0, points, 2, text, size);
                                   }),
            creation<hnav_aid_sensor>("sensor", hnav_aid_sensor_destroy,
                                      [](hnav_aid_sensor** out, char* text, std::size_t size) {
                                          const auto options = hnav_aid_sensor_defaults();
                                          return hnav_aid_sensor_create(out, HNAV_AID_GNSS, &options, 0, text, size);
                                      }),
            creation<hnav_aircraft>("aircraft", hnav_aircraft_destroy, [](hnav_aircraft** out, char* text, std::size_t size) {
                const double A = -0.5, one = 1, tau = 6;
                auto model = hnav_sized<hnav_aircraft_model>();
                model.nx = 1;
                model.interval_s = 0.1;
                model.A_1_s = &A;
                model.process_noise_per_sqrt_s = model.measurement_sigma = model.start_sigma = &one;
                model.accelerometer_error = {&one, &tau};
                const hnav_aircraft_options options = hnav_aircraft_defaults();
                return hnav_aircraft_create(out, &options, &model, text, size);
            })};
}

// Directions on all sides, measured with an offset.
Call calibration() {
    std::mt19937 engine(1);
    std::normal_distribution<double> normal;
    std::vector<double> field, force;
    for (int i = 0; i < 400; ++i) {
        const double v[3] = {normal(engine), normal(engine), normal(engine)};
        const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        for (int k = 0; k < 3; ++k) field.push_back(v[k] / length + 0.1 * (k + 1));
        for (int k = 0; k < 3; ++k) force.push_back(9.81 * v[k] / length);
    }
    return {"calibration of a magnetometer", [=](char* text, std::size_t size) {
                auto calibration = hnav_sized<hnav_magnetometer_calibration>();
                return hnav_calibrate_magnetometer(400, field.data(), force.data(), nullptr, &calibration, text, size);
            }};
}

// A body at rest, smoothed.
Call smoother() {
    std::shared_ptr<hnav_filter> filter(
        [] {
            hnav_filter* made = nullptr;
            const auto options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
            EXPECT_EQ(hnav_ahrs_create(&made, &options, nullptr, 0), HNAV_OK);
            return made;
        }(),
        hnav_filter_destroy);
    std::vector<double> t_s, rate, force;
    for (int i = 0; i < 400; ++i) {
        t_s.push_back(0.01 * i);
        for (double v : {0.0, 0.0, 0.0}) rate.push_back(v);
        for (double v : {0.1, 0.2, -9.8}) force.push_back(v);
    }
    return {"smoother", [=](char* text, std::size_t size) {
                auto input = hnav_sized<hnav_run_input>();
                input.t_s = t_s.data();
                input.rate_b_rad_s = rate.data();
                input.force_b_m_s2 = force.data();
                const auto output = hnav_sized<hnav_run_output>();
                const hnav_status status = hnav_filter_smooth(filter.get(), t_s.size(), &input, &output);
                std::snprintf(text, size, "%s", hnav_filter_message(filter.get()));
                return status;
            }};
}

// The same for navigation.
Call navigation_smoother() {
    std::shared_ptr<hnav_filter> ins(
        [] {
            hnav_filter* made = nullptr;
            const auto options = hnav_ins_defaults(HNAV_INS_INDUSTRIAL);
            EXPECT_EQ(hnav_ins_create(&made, &options, nullptr, 0), HNAV_OK);
            return made;
        }(),
        hnav_filter_destroy);
    const std::vector<double> t_s{0, 0.01, 0.02}, zeros(9, 0.0), fix{0.8, 0.2, 100, 1, 1, 1};
    const std::vector<int32_t> sensor{HNAV_SENSOR_POSITION};
    return {"navigation smoother", [=](char* text, std::size_t size) {
                auto input = hnav_sized<hnav_ins_run_input>();
                input.t_s = t_s.data();
                input.rate_b_rad_s = input.force_b_m_s2 = zeros.data();
                input.aids = 1;
                input.aid_t_s = t_s.data();
                input.aid_sensor = sensor.data();
                input.aid_value = fix.data();
                const auto output = hnav_sized<hnav_ins_run_output>();
                const hnav_status status = hnav_ins_smooth(ins.get(), t_s.size(), &input, &output);
                std::snprintf(text, size, "%s", hnav_filter_message(ins.get()));
                return status;
            }};
}

// Number of heap requests of the call when every request succeeds.
long requests_of(const Call& call) {
    char message[320] = "";
    heap::allocations = heap::refused = heap::held = 0;
    heap::counting = true;
    const hnav_status status = call.make(message, sizeof message);
    call.destroy();
    heap::counting = false;
    EXPECT_EQ(status, HNAV_OK) << message;
    EXPECT_EQ(heap::held, 0) << "destroy gives back what create took";
    return heap::allocations;
}

void refuse(const Call& call, long n) {
    char message[320] = "";
    heap::allocations = heap::held = 0;
    heap::refused = n;
    heap::counting = true;
    const hnav_status status = call.make(message, sizeof message);
    heap::counting = false;
    heap::refused = 0;
    EXPECT_EQ(status, HNAV_ERROR_OUT_OF_MEMORY) << n << ": " << message;
    EXPECT_FALSE(call.exists()) << n;
    EXPECT_EQ(heap::held, 0) << n;
    EXPECT_STRNE(message, "") << n;
}

void fails_cleanly_at_every_request(const Call& call) {
    SCOPED_TRACE(call.name);
    const long requests = requests_of(call);
    EXPECT_GT(requests, 0);
    testing::internal::CaptureStderr();
    for (long n = 1; n <= requests; ++n) refuse(call, n);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(requests_of(call), requests);
}

} // namespace

TEST(OutOfMemory, OfAnAttitudeFilterByAnySolver) {
    for (const Call& call : attitude_filters()) fails_cleanly_at_every_request(call);
}

TEST(OutOfMemory, OfAnInsErrorFilterOfAnyForm) {
    for (const Call& call : ins_error_filters()) fails_cleanly_at_every_request(call);
}

TEST(OutOfMemory, OfAPlantAndItsSensors) {
    for (const Call& call : plants()) fails_cleanly_at_every_request(call);
}

TEST(OutOfMemory, OfAnObserver) { fails_cleanly_at_every_request(observer()); }

TEST(OutOfMemory, OfACalibration) { fails_cleanly_at_every_request(calibration()); }

TEST(OutOfMemory, OfTheSmoother) { fails_cleanly_at_every_request(smoother()); }

TEST(OutOfMemory, OfTheSmootherOfNavigation) { fails_cleanly_at_every_request(navigation_smoother()); }

#endif
