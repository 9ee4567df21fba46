// Structs that begin with their size: every call refuses a size that no version had, and serves callers of older versions.
#include "c_api/sized.hpp"
#include "hnav/hnav.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace {

// ------------------------------------------------------------------------------------------------ growth

// A struct that began with one number and has gained another.
struct Grown {
    std::size_t size;
    double old_field, new_field;
};
constexpr std::size_t grown_at_first = offsetof(Grown, new_field);

} // namespace

namespace hnav {
template <>
inline constexpr std::size_t first_size<Grown> = grown_at_first;
}

namespace {

const hnav::KeptMessage<200> object;

bool known(std::size_t size) {
    const Grown given{size, 1, 2};
    return hnav::check_size(object, given, "given", "Grown") == HNAV_OK;
}

TEST(Sized, AStructThatHasGrownIsKnownByEverySizeSinceTheFirst) {
    EXPECT_TRUE(known(sizeof(Grown)));
    EXPECT_TRUE(known(grown_at_first));
    for (const std::size_t size : {std::size_t{0}, grown_at_first - 1, sizeof(Grown) + 1, ~std::size_t{0}})
        EXPECT_FALSE(known(size)) << size;
    EXPECT_STREQ(object.message, ("given.size = " + std::to_string(~std::size_t{0}) +
                                  " is no size of Grown: begin with Grown given = {.size = sizeof given}")
                                     .c_str());
}

TEST(Sized, AnOlderCallerGetsTheFieldsThatItKnowsAndNothingBehindThem) {
    Grown caller{grown_at_first, 0, 77};
    hnav::hand_out(Grown{0, 3, 4}, &caller);
    EXPECT_EQ(caller.size, grown_at_first);
    EXPECT_EQ(caller.old_field, 3);
    EXPECT_EQ(caller.new_field, 77);
    const Grown taken = hnav::take_in(caller);
    EXPECT_EQ(taken.old_field, 3);
    EXPECT_EQ(taken.new_field, 0);

    caller.size = sizeof caller;
    hnav::hand_out(Grown{0, 3, 4}, &caller);
    EXPECT_EQ(caller.new_field, 4);
    EXPECT_EQ(hnav::take_in(caller).new_field, 4);
}

// ------------------------------------------------------------------------------------------------ every call

// call: takes a pointer to the struct and returns its status. message: of the last failure.
template <class Struct, class Call, class Message>
void refuses_unknown_sizes(const char* type, const Struct& good, Call&& call, Message&& message) {
    Struct given = good;
    EXPECT_EQ(call(&given), HNAV_OK) << type << ": " << message();
    for (const std::size_t size : {std::size_t{0}, std::size_t{8}, sizeof(Struct) - 1, sizeof(Struct) + 1, sizeof(Struct) + 8}) {
        given = good;
        given.size = size;
        std::vector<char> before(sizeof given), after(sizeof given);
        std::memcpy(before.data(), &given, sizeof given);
        EXPECT_EQ(call(&given), HNAV_ERROR_SIZE) << type << ", size " << size;
        std::memcpy(after.data(), &given, sizeof given);
        EXPECT_EQ(before, after) << type;
        const std::string said = message();
        EXPECT_NE(said.find(".size = " + std::to_string(size) + " is no size of " + type), std::string::npos) << said;
        EXPECT_NE(said.find(std::string("begin with ") + type), std::string::npos) << said;
    }
}

// A filter that has started.
hnav_filter* started() {
    const hnav_ahrs_options options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    hnav_filter* filter;
    EXPECT_EQ(hnav_ahrs_create(&filter, &options, nullptr, 0), HNAV_OK);
    const double rate[3] = {0, 0, 0}, force[3] = {0, 0, -9.81}, field[3] = {2e-5, 0, 4.5e-5};
    for (int k = 0; k < 10; ++k) {
        hnav_filter_push_imu(filter, 0.01 * k, rate, force);
        hnav_filter_push_mag(filter, 0.01 * k, field);
        hnav_filter_advance(filter, 0.01 * k);
    }
    return filter;
}

TEST(Sized, ResultsOfAnAttitudeFilter) {
    hnav_filter* f = started();
    const auto message = [&] { return std::string(hnav_filter_message(f)); };
    const auto of = [&](const char* type, auto good, auto call) {
        refuses_unknown_sizes(type, good, [&](auto* result) { return call(f, result); }, message);
    };
    of("hnav_attitude", hnav_sized<hnav_attitude>(), hnav_filter_attitude);
    of("hnav_posterior", hnav_sized<hnav_posterior>(), hnav_filter_posterior);
    of("hnav_field", hnav_sized<hnav_field>(), hnav_filter_field);
    of("hnav_diagnostics", hnav_sized<hnav_diagnostics>(), hnav_filter_diagnostics);
    of("hnav_health", hnav_sized<hnav_health>(), hnav_filter_health);
    of("hnav_innovation", hnav_sized<hnav_innovation>(),
       [](const hnav_filter* filter, hnav_innovation* i) { return hnav_filter_innovation(filter, HNAV_SENSOR_MAG, i); });
    hnav_filter_destroy(f);
}

TEST(Sized, ArraysOfAnAttitudeFilter) {
    hnav_filter* f = started();
    const auto message = [&] { return std::string(hnav_filter_message(f)); };
    const double t_s[] = {1, 1.01}, force[] = {0, 0, -9.81, 0, 0, -9.81}, field[] = {2e-5, 0, 4.5e-5, 2e-5, 0, 4.5e-5};
    auto input = hnav_sized<hnav_run_input>();
    input.t_s = t_s;
    input.force_b_m_s2 = force;
    input.field_b_tesla = field;
    const auto output = hnav_sized<hnav_run_output>();
    refuses_unknown_sizes(
        "hnav_run_input", input, [&](auto* in) { return hnav_filter_run(f, 1, in, &output, nullptr); }, message);
    refuses_unknown_sizes(
        "hnav_run_output", output, [&](auto* out) { return hnav_filter_run(f, 1, &input, out, nullptr); }, message);
    refuses_unknown_sizes("hnav_run_input", input, [&](auto* in) { return hnav_filter_smooth(f, 2, in, &output); }, message);
    refuses_unknown_sizes("hnav_run_output", output, [&](auto* out) { return hnav_filter_smooth(f, 2, &input, out); }, message);
    hnav_filter_destroy(f);
}

// One state, seen with noise.
hnav_ins_error_model one_state() {
    static const double half = 0.5, one = 1;
    auto model = hnav_sized<hnav_ins_error_model>();
    model.nx = model.nz = model.nw = 1;
    model.A = &half;
    model.H = model.Qw = model.Qv = model.P0 = &one;
    return model;
}

TEST(Sized, StructsOfTheInsErrorFilter) {
    const hnav_ins_error_options options = hnav_ins_error_defaults();
    const hnav_ins_error_model model = one_state();
    char text[320] = "";
    refuses_unknown_sizes(
        "hnav_ins_error_model", model,
        [&](auto* m) {
            hnav_ins_error_filter* made;
            const hnav_status status = hnav_ins_error_filter_create(&made, &options, m, text, sizeof text);
            hnav_ins_error_filter_destroy(made);
            return status;
        },
        [&] { return std::string(text); });

    hnav_ins_error_filter* f;
    ASSERT_EQ(hnav_ins_error_filter_create(&f, &options, &model, nullptr, 0), HNAV_OK);
    const auto message = [&] { return std::string(hnav_ins_error_filter_message(f)); };
    refuses_unknown_sizes(
        "hnav_ins_error_model", model, [&](auto* m) { return hnav_ins_error_filter_replace_model(f, m); }, message);
    refuses_unknown_sizes(
        "hnav_ins_error_info", hnav_sized<hnav_ins_error_info>(), [&](auto* info) { return hnav_ins_error_filter_info(f, info); },
        message);
    const double z = 1;
    auto input = hnav_sized<hnav_ins_error_run_input>();
    input.z = &z;
    const auto output = hnav_sized<hnav_ins_error_run_output>();
    refuses_unknown_sizes(
        "hnav_ins_error_run_input", input, [&](auto* in) { return hnav_ins_error_filter_run(f, 1, in, &output, nullptr); },
        message);
    refuses_unknown_sizes(
        "hnav_ins_error_run_output", output, [&](auto* out) { return hnav_ins_error_filter_run(f, 1, &input, out, nullptr); },
        message);
    hnav_ins_error_filter_destroy(f);
}

TEST(Sized, TheMagnetometerCalibration) {
    std::vector<double> field;
    for (int i = 0; i < 100; ++i) {
        const double height = 1 - (2 * i + 1) / 100.0, across = std::sqrt(1 - height * height);
        field.insert(field.end(), {across * std::cos(2.4 * i), across * std::sin(2.4 * i), height});
    }
    char text[320] = "";
    refuses_unknown_sizes(
        "hnav_magnetometer_calibration", hnav_sized<hnav_magnetometer_calibration>(),
        [&](auto* c) { return hnav_calibrate_magnetometer(100, field.data(), nullptr, nullptr, c, text, sizeof text); },
        [&] { return std::string(text); });
}

TEST(Sized, TruthAndReadings) {
    const hnav_turntable_options table_options = hnav_turntable_defaults();
    hnav_turntable* table;
    ASSERT_EQ(hnav_turntable_create(&table, &table_options, nullptr, 0), HNAV_OK);
    const auto said_by_table = [&] { return std::string(hnav_turntable_message(table)); };
    const auto nothing = hnav_sized<hnav_truth>();
    refuses_unknown_sizes("hnav_truth", nothing, [&](auto* t) { return hnav_turntable_at(table, 1, t); }, said_by_table);
    refuses_unknown_sizes("hnav_truth", nothing, [&](auto* t) { return hnav_turntable_in_piece(table, 1, 2, t); }, said_by_table);
    auto truth = nothing;
    ASSERT_EQ(hnav_turntable_at(table, 1, &truth), HNAV_OK);

    const hnav_imu_mag_sensor_options sensor_options = hnav_imu_mag_sensor_defaults();
    hnav_imu_mag_sensor* sensor;
    ASSERT_EQ(hnav_imu_mag_sensor_create(&sensor, &sensor_options, 0, nullptr, 0), HNAV_OK);
    const auto said_by_sensor = [&] { return std::string(hnav_imu_mag_sensor_message(sensor)); };
    refuses_unknown_sizes("hnav_truth", truth, [&](auto* t) { return hnav_imu_mag_sensor_sample(sensor, 1, t); }, said_by_sensor);
    refuses_unknown_sizes(
        "hnav_reading", hnav_sized<hnav_reading>(),
        [&](auto* r) { return hnav_imu_mag_sensor_reading(sensor, HNAV_SENSOR_ACCEL, r); }, said_by_sensor);
    hnav_imu_mag_sensor_destroy(sensor);
    hnav_turntable_destroy(table);
}

TEST(Sized, TruthOfVehiclesAndReadingsOfAids) {
    const hnav_vehicle_options vehicle_options = hnav_vehicle_defaults();
    hnav_vehicle* vehicle;
    ASSERT_EQ(hnav_vehicle_create(&vehicle, &vehicle_options, 0, nullptr, 0), HNAV_OK);
    const auto said_by_vehicle = [&] { return std::string(hnav_vehicle_message(vehicle)); };
    double x[HNAV_VEHICLE_STATES];
    ASSERT_EQ(hnav_vehicle_start(vehicle, x), HNAV_OK);
    const auto nothing = hnav_sized<hnav_vehicle_truth>();
    refuses_unknown_sizes(
        "hnav_vehicle_truth", nothing, [&](auto* t) { return hnav_vehicle_at(vehicle, 1, x, t); }, said_by_vehicle);
    auto truth = nothing;
    ASSERT_EQ(hnav_vehicle_at(vehicle, 1, x, &truth), HNAV_OK);

    const hnav_aid_sensor_options options = hnav_aid_sensor_defaults();
    hnav_aid_sensor* sensor;
    ASSERT_EQ(hnav_aid_sensor_create(&sensor, HNAV_AID_GNSS, &options, 0, nullptr, 0), HNAV_OK);
    const auto said_by_sensor = [&] { return std::string(hnav_aid_sensor_message(sensor)); };
    refuses_unknown_sizes(
        "hnav_vehicle_truth", truth, [&](auto* t) { return hnav_aid_sensor_sample(sensor, 1, t); }, said_by_sensor);
    refuses_unknown_sizes(
        "hnav_aid_reading", hnav_sized<hnav_aid_reading>(), [&](auto* r) { return hnav_aid_sensor_reading(sensor, r); },
        said_by_sensor);
    hnav_aid_sensor_destroy(sensor);
    hnav_vehicle_destroy(vehicle);
}

TEST(Sized, StructsOfTheAircraft) {
    const hnav_aircraft_options options = hnav_aircraft_defaults();
    const double decay = -1, one = 1;
    auto model = hnav_sized<hnav_aircraft_model>();
    model.nx = 1;
    model.interval_s = 0.1;
    model.A_1_s = &decay;
    model.process_noise_per_sqrt_s = model.measurement_sigma = model.start_sigma = &one;
    char text[320] = "";
    refuses_unknown_sizes(
        "hnav_aircraft_model", model,
        [&](auto* m) {
            hnav_aircraft* made;
            const hnav_status status = hnav_aircraft_create(&made, &options, m, text, sizeof text);
            hnav_aircraft_destroy(made);
            return status;
        },
        [&] { return std::string(text); });

    hnav_aircraft* plant;
    ASSERT_EQ(hnav_aircraft_create(&plant, &options, &model, nullptr, 0), HNAV_OK);
    const auto message = [&] { return std::string(hnav_aircraft_message(plant)); };
    const auto sample = hnav_sized<hnav_aircraft_sample>();
    refuses_unknown_sizes("hnav_aircraft_sample", sample, [&](auto* s) { return hnav_aircraft_get_sample(plant, s); }, message);
    refuses_unknown_sizes(
        "hnav_aircraft_sample", sample, [&](auto* s) { return hnav_aircraft_run(plant, 2, nullptr, s); }, message);
    refuses_unknown_sizes(
        "hnav_ins_error_model", hnav_sized<hnav_ins_error_model>(), [&](auto* m) { return hnav_aircraft_filter_model(plant, m); },
        message);
    hnav_aircraft_destroy(plant);
}

} // namespace
