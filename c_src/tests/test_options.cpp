// Options through the C API: stamps that identify their version, and fields that are read and written by their rows.
#include "hnav/hnav.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <string>

namespace {

// The message and status of create for options.
struct Answer {
    hnav_status status;
    std::string message;
};

// Each kind of options: created, changed and passed to its object.
template <class Options>
struct Kind {
    std::function<Options()> defaults;
    std::function<hnav_status(const Options*, char*)> create;
    const char* list;
    const char* call; // that makes them

    Answer answer(const Options& options) const {
        char message[320] = "";
        const hnav_status status = create(&options, message);
        return {status, message};
    }
};

constexpr std::size_t bytes = 320;

const Kind<hnav_ahrs_options> ahrs = {[] { return hnav_ahrs_defaults(HNAV_PRESET_DEFAULT); },
                                      [](const hnav_ahrs_options* o, char* message) {
                                          hnav_filter* filter;
                                          const hnav_status status = hnav_ahrs_create(&filter, o, message, bytes);
                                          hnav_filter_destroy(filter);
                                          return status;
                                      },
                                      "ahrs", "hnav_ahrs_defaults"};

const Kind<hnav_hrekf_options> hrekf = {[] { return hnav_hrekf_defaults(HNAV_PRESET_DEFAULT); },
                                        [](const hnav_hrekf_options* o, char* message) {
                                            hnav_filter* filter;
                                            const hnav_status status = hnav_hrekf_create(&filter, o, message, bytes);
                                            hnav_filter_destroy(filter);
                                            return status;
                                        },
                                        "hrekf", "hnav_hrekf_defaults"};

const Kind<hnav_ins_error_options> ins_error = {[] { return hnav_ins_error_defaults(); },
                                                [](const hnav_ins_error_options* o, char* message) {
                                                    const double one = 1;
                                                    auto model = hnav_sized<hnav_ins_error_model>();
                                                    model.nx = model.nz = model.nw = 1;
                                                    model.A = model.H = model.Qw = model.Qv = model.P0 = &one;
                                                    hnav_ins_error_filter* filter;
                                                    const hnav_status status =
                                                        hnav_ins_error_filter_create(&filter, o, &model, message, bytes);
                                                    hnav_ins_error_filter_destroy(filter);
                                                    return status;
                                                },
                                                "ins_error", "hnav_ins_error_defaults"};

const Kind<hnav_magnetometer_options> magnetometer = {[] { return hnav_magnetometer_defaults(); },
                                                      [](const hnav_magnetometer_options* o, char* message) {
                                                          double field[300];
                                                          for (int i = 0; i < 100; ++i) {
                                                              const double height = 1 - (2 * i + 1) / 100.0, turn = 2.4 * i;
                                                              field[3 * i] = std::sqrt(1 - height * height) * std::cos(turn);
                                                              field[3 * i + 1] = std::sqrt(1 - height * height) * std::sin(turn);
                                                              field[3 * i + 2] = height;
                                                          }
                                                          auto calibration = hnav_sized<hnav_magnetometer_calibration>();
                                                          return hnav_calibrate_magnetometer(100, field, nullptr, o, &calibration,
                                                                                             message, bytes);
                                                      },
                                                      "magnetometer", "hnav_magnetometer_defaults"};

const Kind<hnav_turntable_options> turntable = {[] { return hnav_turntable_defaults(); },
                                                [](const hnav_turntable_options* o, char* message) {
                                                    hnav_turntable* table;
                                                    const hnav_status status = hnav_turntable_create(&table, o, message, bytes);
                                                    hnav_turntable_destroy(table);
                                                    return status;
                                                },
                                                "turntable", "hnav_turntable_defaults"};

const Kind<hnav_imu_mag_sensor_options> sensor = {[] { return hnav_imu_mag_sensor_defaults(); },
                                                  [](const hnav_imu_mag_sensor_options* o, char* message) {
                                                      hnav_imu_mag_sensor* made;
                                                      const hnav_status status =
                                                          hnav_imu_mag_sensor_create(&made, o, 0, message, bytes);
                                                      hnav_imu_mag_sensor_destroy(made);
                                                      return status;
                                                  },
                                                  "imu_mag_sensor", "hnav_imu_mag_sensor_defaults"};

const Kind<hnav_vehicle_options> vehicle = {[] { return hnav_vehicle_defaults(); },
                                            [](const hnav_vehicle_options* o, char* message) {
                                                hnav_vehicle* made;
                                                const hnav_status status = hnav_vehicle_create(&made, o, 0, message, bytes);
                                                hnav_vehicle_destroy(made);
                                                return status;
                                            },
                                            "vehicle", "hnav_vehicle_defaults"};

const Kind<hnav_aid_sensor_options> aid_sensor = {[] { return hnav_aid_sensor_defaults(); },
                                                  [](const hnav_aid_sensor_options* o, char* message) {
                                                      hnav_aid_sensor* made;
                                                      const hnav_status status =
                                                          hnav_aid_sensor_create(&made, HNAV_AID_BARO, o, 0, message, bytes);
                                                      hnav_aid_sensor_destroy(made);
                                                      return status;
                                                  },
                                                  "aid_sensor", "hnav_aid_sensor_defaults"};

const Kind<hnav_aircraft_options> aircraft = {
    [] { return hnav_aircraft_defaults(); },
    [](const hnav_aircraft_options* o, char* message) {
        const double A = -1, one = 1;
        auto model = hnav_sized<hnav_aircraft_model>();
        model.nx = 1;
        model.interval_s = 0.1;
        model.A_1_s = &A;
        model.process_noise_per_sqrt_s = model.measurement_sigma = model.start_sigma = &one;
        hnav_aircraft* made;
        const hnav_status status = hnav_aircraft_create(&made, o, &model, message, bytes);
        hnav_aircraft_destroy(made);
        return status;
    },
    "aircraft", "hnav_aircraft_defaults"};

// A plant for the create call: exponential decay.
int decay(void*, double, const double* x, const double*, const double*, double* dx) {
    dx[0] = -x[0];
    return 0;
}

const Kind<hnav_observer_options> observer = {[] { return hnav_observer_defaults(); },
                                              [](const hnav_observer_options* o, char* message) {
                                                  const double one = 1;
                                                  auto plant = hnav_sized<hnav_plant>();
                                                  plant.n_states = plant.n_outputs = 1;
                                                  plant.derivatives = plant.outputs = decay;
                                                  auto known = hnav_sized<hnav_observer_statistics>();
                                                  known.start_sigma = known.sensor_sigma = &one;
                                                  hnav_filter* made;
                                                  const hnav_status status =
                                                      hnav_observer_create(&made, o, &plant, &known, message, bytes);
                                                  hnav_filter_destroy(made);
                                                  return status;
                                              },
                                              "observer", "hnav_observer_defaults"};

// Calls law with each kind.
template <class Law>
void of_every_kind(Law&& law) {
    law(ahrs);
    law(hrekf);
    law(ins_error);
    law(magnetometer);
    law(turntable);
    law(sensor);
    law(vehicle);
    law(aid_sensor);
    law(aircraft);
    law(observer);
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Options, OfADefaultsCallAreTaken) {
    of_every_kind([](const auto& kind) {
        const auto options = kind.defaults();
        EXPECT_EQ(options.size, sizeof options) << kind.call;
        const Answer answer = kind.answer(options);
        EXPECT_EQ(answer.status, HNAV_OK) << kind.call << ": " << answer.message;
    });
}

TEST(Options, ThatNobodyMadeAreRefusedWithTheCallThatMakesThem) {
    of_every_kind([](const auto& kind) {
        auto options = kind.defaults();
        std::memset(&options, 0, sizeof options);
        Answer answer = kind.answer(options);
        EXPECT_EQ(answer.status, HNAV_ERROR_OPTIONS_STAMP);
        EXPECT_TRUE(contains(answer.message, kind.call)) << answer.message;
        std::memset(&options, 0xa5, sizeof options);
        answer = kind.answer(options);
        EXPECT_EQ(answer.status, HNAV_ERROR_OPTIONS_STAMP);
        EXPECT_TRUE(contains(answer.message, kind.call)) << answer.message;
    });
}

TEST(Options, OfAnotherVersionAreRefusedWithBothVersions) {
    of_every_kind([](const auto& kind) {
        auto options = kind.defaults();
        options.stamp += 3 << 8; // three minor versions later
        Answer answer = kind.answer(options);
        EXPECT_EQ(answer.status, HNAV_ERROR_OPTIONS_STAMP);
        const std::string later = "hnav " + std::to_string(HNAV_VERSION_MAJOR) + "." + std::to_string(HNAV_VERSION_MINOR + 3);
        EXPECT_TRUE(contains(answer.message, later)) << answer.message;
        EXPECT_TRUE(contains(answer.message, std::string("hnav ") + hnav_version())) << answer.message;
        options = kind.defaults();
        options.size += 8;
        EXPECT_EQ(kind.answer(options).status, HNAV_ERROR_OPTIONS_STAMP);
        options = kind.defaults();
        options.stamp += 1; // a patch release changes no options
        EXPECT_EQ(kind.answer(options).status, HNAV_OK);
    });
}

TEST(Options, OfAnotherListAreRefused) {
    of_every_kind([](const auto& kind) {
        auto options = kind.defaults();
        options.stamp ^= uint64_t{64} << 24;
        const Answer answer = kind.answer(options);
        EXPECT_EQ(answer.status, HNAV_ERROR_OPTIONS_STAMP);
        EXPECT_TRUE(contains(answer.message, kind.call)) << answer.message;
    });
}

TEST(Options, OfAPresetThatIsNotThereHaveNoStamp) {
    EXPECT_EQ(hnav_ahrs_defaults(HNAV_PRESET_PAPER).stamp, 0u);
    EXPECT_EQ(hnav_hrekf_defaults(static_cast<hnav_preset>(2)).stamp, 0u);
    EXPECT_NE(hnav_hrekf_defaults(HNAV_PRESET_PAPER).stamp, 0u);
}

TEST(Options, ArePresetsByName) {
    ASSERT_NE(hnav_preset_of("hrekf", 1), nullptr);
    EXPECT_STREQ(hnav_preset_of("hrekf", 1)->name, "paper");
    EXPECT_EQ(hnav_preset_of("hrekf", 1)->value, HNAV_PRESET_PAPER);
    EXPECT_STREQ(hnav_preset_of("ahrs", 0)->name, "default");
    EXPECT_EQ(hnav_preset_of("ahrs", 1), nullptr);
    EXPECT_EQ(hnav_preset_of("hrekf", -1), nullptr);
}

TEST(Options, HoldTheDefaultsThatTheirRowsState) {
    of_every_kind([](const auto& kind) {
        const auto options = kind.defaults();
        for (int k = 0; const hnav_option_info* row = hnav_option(kind.list, k); ++k)
            for (int i = 0; i < row->count; ++i)
                EXPECT_EQ(hnav_option_value(row, &options, i), row->default_values[i]) << row->name;
        EXPECT_EQ(hnav_option(kind.list, -1), nullptr);
    });
}

TEST(Options, AreWrittenAndReadByTheirRows) {
    hnav_turntable_options options = hnav_turntable_defaults();
    for (int k = 0; const hnav_option_info* row = hnav_option("turntable", k); ++k) {
        if (!std::strcmp(row->name, "pitch.amplitude_rad")) hnav_set_option_value(row, &options, 0, 0.25);
        if (!std::strcmp(row->name, "pitch.motion")) hnav_set_option_value(row, &options, 0, HNAV_MOTION_SINE);
    }
    EXPECT_EQ(options.pitch.amplitude_rad, 0.25);
    EXPECT_EQ(options.pitch.motion, HNAV_MOTION_SINE);

    hnav_imu_mag_sensor_options many = hnav_imu_mag_sensor_defaults();
    for (int k = 0; const hnav_option_info* row = hnav_option("imu_mag_sensor", k); ++k) {
        if (std::strcmp(row->name, "mag.soft_iron")) continue;
        for (int i = 0; i < row->count; ++i) EXPECT_EQ(hnav_set_option_value(row, &many, i, i), HNAV_OK);
    }
    for (int i = 0; i < 9; ++i) EXPECT_EQ(many.mag.soft_iron[i], i);
}

TEST(Options, HaveNoComponentBeyondTheLast) {
    hnav_ahrs_options options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    const hnav_option_info* row = hnav_option("ahrs", 0);
    EXPECT_TRUE(std::isnan(hnav_option_value(row, &options, row->count)));
    EXPECT_TRUE(std::isnan(hnav_option_value(row, nullptr, 0)));
    EXPECT_TRUE(std::isnan(hnav_option_value(nullptr, &options, 0)));
    EXPECT_EQ(hnav_set_option_value(row, &options, -1, 0), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_set_option_value(row, nullptr, 0, 0), HNAV_ERROR_NULL_ARGUMENT);
}

// Each component in turn outside its range.
template <class Options>
void refuse_beyond(const Kind<Options>& kind) {
    for (int k = 0; const hnav_option_info* row = hnav_option(kind.list, k); ++k) {
        const auto refused = [&](double value) {
            Options options = kind.defaults();
            hnav_set_option_value(row, &options, row->count - 1, value);
            const Answer answer = kind.answer(options);
            EXPECT_EQ(answer.status, HNAV_ERROR_OPTION) << row->name << " = " << value;
            EXPECT_TRUE(contains(answer.message, row->name)) << answer.message;
        };
        if (row->kind == HNAV_OPTION_REAL) refused(std::nan(""));
        if (row->min > -2147483648.0) refused(row->min_is_open ? row->min : row->min - 1);
        if (row->max < 2147483647.0) refused(row->max_is_open ? row->max : row->max + 1 + 0.01 * std::fabs(row->max));
    }
}

TEST(Options, OutsideTheirRangesAreRefusedByName) {
    of_every_kind([](const auto& kind) { refuse_beyond(kind); });
}

} // namespace
