// Turntable, and the errors of the inertial and magnetic sensor one at a time.
#include "hnav/simulation.h"
#include "maths/rotation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

using hnav::Matrix3;
using hnav::Quaternion;
using hnav::Vector3;

namespace {

constexpr double deg = M_PI / 180;

struct Table {
    hnav_turntable* table = nullptr;
    explicit Table(const hnav_turntable_options& options) {
        char message[256] = "";
        EXPECT_EQ(hnav_turntable_create(&table, &options, message, sizeof message), HNAV_OK) << message;
    }
    ~Table() { hnav_turntable_destroy(table); }
    hnav_truth at(double t) const {
        auto truth = hnav_sized<hnav_truth>();
        EXPECT_EQ(hnav_turntable_at(table, t, &truth), HNAV_OK);
        return truth;
    }
};

// All three axes move, in three ways.
hnav_turntable_options tumbling() {
    hnav_turntable_options o = hnav_turntable_defaults();
    o.roll.motion = HNAV_MOTION_SINE;
    o.roll.angle_rad = 0.2;
    o.roll.amplitude_rad = 0.7;
    o.roll.period_s = 3;
    o.pitch.motion = HNAV_MOTION_STEP;
    o.pitch.angle_rad = -0.3;
    o.pitch.amplitude_rad = 0.8;
    o.pitch.rate_rad_s = 0.25;
    o.pitch.start_s = 1;
    o.yaw.rate_rad_s = 1.3;
    o.declination_rad = 0.1;
    return o;
}

// A level body at rest, the smallest possible readings.
hnav_truth rest() {
    auto truth = hnav_sized<hnav_truth>();
    truth.q_nb[0] = 1;
    truth.force_b_m_s2[2] = -9.80665;
    truth.field_b_tesla[0] = 2e-5;
    truth.field_b_tesla[2] = 4.5e-5;
    return truth;
}

struct Sensor {
    hnav_imu_mag_sensor* sensor = nullptr;
    explicit Sensor(const hnav_imu_mag_sensor_options& options, double start_s = 0) {
        char message[256] = "";
        EXPECT_EQ(hnav_imu_mag_sensor_create(&sensor, &options, start_s, message, sizeof message), HNAV_OK) << message;
    }
    ~Sensor() { hnav_imu_mag_sensor_destroy(sensor); }

    hnav_reading read(hnav_sensor kind) const {
        auto reading = hnav_sized<hnav_reading>();
        EXPECT_EQ(hnav_imu_mag_sensor_reading(sensor, kind, &reading), HNAV_OK);
        return reading;
    }
    void sample(double t, const hnav_truth& truth) {
        ASSERT_EQ(hnav_imu_mag_sensor_sample(sensor, t, &truth), HNAV_OK);
        ASSERT_EQ(hnav_imu_mag_sensor_advance(sensor, t), HNAV_OK);
    }
    Vector3 value(double t, const hnav_truth& truth, hnav_sensor kind) {
        sample(t, truth);
        return Vector3(read(kind).value);
    }
};

std::string refusal(const hnav_imu_mag_sensor_options& o, hnav_status expected) {
    hnav_imu_mag_sensor* sensor = nullptr;
    char message[256] = "";
    EXPECT_EQ(hnav_imu_mag_sensor_create(&sensor, &o, 0, message, sizeof message), expected);
    EXPECT_EQ(sensor, nullptr);
    return message;
}

} // namespace

// ------------------------------------------------------------------------------------------------ turntable

TEST(Turntable, TheBodyRateIsTheDerivativeOfTheAttitude) {
    const Table table(tumbling());
    constexpr double h = 1e-3; // five-point rule: its error is h^4/30 of the fifth derivative
    for (double t = 0.3113; t < 12; t += 0.0977) {
        double corner;
        ASSERT_EQ(hnav_turntable_next_corner_s(table.table, t - 2.1 * h, &corner), HNAV_OK);
        if (corner < t + 2.1 * h) continue;
        const auto q = [&](double at) { return Quaternion(table.at(at).q_nb); };
        const Quaternion dq = (8 * (q(t + h) - q(t - h)) - (q(t + 2 * h) - q(t - 2 * h))) / (12 * h);
        const Vector3 u = 4 * hnav::Xi(q(t)).transpose() * dq;
        EXPECT_LT((u - Vector3(table.at(t).rate_b_rad_s)).norm(), 1e-9) << t;
    }
}

TEST(Turntable, IntegratingTheRateGivesTheAttitudeAcrossCorners) {
    const Table table(tumbling());
    Quaternion q(table.at(0).q_nb);
    constexpr double h = 1e-3;
    double t = 0;
    while (t < 8) {
        double corner;
        ASSERT_EQ(hnav_turntable_next_corner_s(table.table, t, &corner), HNAV_OK);
        const double end = std::fmin(std::fmin(t + h, corner), 8.0);
        const auto rate = [&](double at) {
            auto truth = hnav_sized<hnav_truth>();
            EXPECT_EQ(hnav_turntable_in_piece(table.table, t, at, &truth), HNAV_OK);
            return Vector3(truth.rate_b_rad_s);
        };
        const double step = end - t;
        const auto flow = [&](double at, const Quaternion& x) -> Quaternion { return hnav::Xi(x) * rate(at); };
        const Quaternion k1 = flow(t, q), k2 = flow(t + step / 2, q + step / 2 * k1), k3 = flow(t + step / 2, q + step / 2 * k2),
                         k4 = flow(end, q + step * k3);
        q += step / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
        t = end;
    }
    EXPECT_LT((q - Quaternion(table.at(8).q_nb)).norm(), 1e-9);
}

TEST(Turntable, APlantOutsideGetsEulerAnglesAndTheFlowOfItsAttitude) {
    const Table table(tumbling());
    for (double t = 0; t < 20; t += 0.37) {
        const hnav_truth truth = table.at(t);
        double euler[3], flow[4];
        ASSERT_EQ(hnav_quaternion_to_euler(truth.q_nb, euler), HNAV_OK);
        EXPECT_EQ(Vector3(euler), Vector3(truth.euler_rad));
        ASSERT_EQ(hnav_quaternion_derivative(truth.q_nb, truth.rate_b_rad_s, flow), HNAV_OK);
        const Vector3 u(truth.rate_b_rad_s);
        EXPECT_LT((2 * Quaternion(flow) - hnav::multiply(Quaternion(truth.q_nb), {0, u[0], u[1], u[2]})).norm(), 1e-15) << t;
    }
    double three[3], four[4] = {1, 0, 0, 0};
    EXPECT_EQ(hnav_quaternion_to_euler(nullptr, three), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_quaternion_to_euler(four, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_quaternion_derivative(nullptr, three, four), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_quaternion_derivative(four, nullptr, four), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_quaternion_derivative(four, three, nullptr), HNAV_ERROR_NULL_ARGUMENT);
}

TEST(Turntable, ForceIsGravityAndTheFieldHasItsStrengthDipAndDeclination) {
    const hnav_turntable_options options = tumbling();
    const Table table(options);
    for (double t = 0; t < 20; t += 0.37) {
        const hnav_truth truth = table.at(t);
        const Vector3 force(truth.force_b_m_s2), field(truth.field_b_tesla);
        EXPECT_NEAR(force.norm(), options.gravity_m_s2, 1e-12);
        EXPECT_NEAR(field.norm(), options.field_strength_tesla, 1e-18);
        const double sine_of_dip = -force.dot(field) / force.norm() / field.norm();
        EXPECT_NEAR(std::asin(sine_of_dip), options.field_dip_rad, 1e-12);
        const Vector3 field_n = hnav::rotation_matrix(Quaternion(truth.q_nb)) * field;
        EXPECT_NEAR(std::atan2(field_n[1], field_n[0]), options.declination_rad, 1e-12);
    }
}

TEST(Turntable, TheDefaultIsYawBetweenSixtyDegreesAtTenDegreesPerSecond) {
    const Table table(hnav_turntable_defaults());
    const double yaw_deg[][2] = {{0, 0}, {3, 30}, {6, 60}, {9, 30}, {12, 0}, {18, -60}, {21, -30}, {24, 0}, {54, 60}};
    for (const auto& row : yaw_deg) EXPECT_NEAR(table.at(row[0]).euler_rad[2] / deg, row[1], 1e-12) << row[0];
    for (const double t : {0.0, 5.99, 18.0, 24.0}) EXPECT_NEAR(table.at(t).rate_b_rad_s[2] / deg, 10, 1e-12) << t;
    for (const double t : {6.0, 12.0, 17.99}) EXPECT_NEAR(table.at(t).rate_b_rad_s[2] / deg, -10, 1e-12) << t;
    double corner;
    ASSERT_EQ(hnav_turntable_next_corner_s(table.table, 6, &corner), HNAV_OK);
    EXPECT_NEAR(corner, 18, 1e-12);
}

TEST(Turntable, AStepTurnsByItsAmplitudeAndStands) {
    hnav_turntable_options o = hnav_turntable_defaults();
    o.yaw.motion = HNAV_MOTION_STEP;
    o.yaw.angle_rad = 0.5;
    o.yaw.amplitude_rad = -1;
    o.yaw.rate_rad_s = 0.25;
    o.yaw.start_s = 2;
    const Table table(o);
    EXPECT_NEAR(table.at(1.99).euler_rad[2], 0.5, 1e-15);
    EXPECT_EQ(table.at(1.99).rate_b_rad_s[2], 0);
    EXPECT_NEAR(table.at(4).euler_rad[2], 0, 1e-15);
    EXPECT_NEAR(table.at(4).rate_b_rad_s[2], -0.25, 1e-15);
    EXPECT_NEAR(table.at(6).euler_rad[2], -0.5, 1e-15);
    EXPECT_EQ(table.at(6).rate_b_rad_s[2], 0);
}

TEST(Turntable, ACornerThatRoundingMissesBelongsToTheNextPiece) {
    const Table table(hnav_turntable_defaults());
    double t = 0;
    for (int k = 0; k < 600; ++k) t += 0.01; // 5.9999999999999
    ASSERT_NE(t, 6.0);
    EXPECT_NEAR(table.at(t).rate_b_rad_s[2] / deg, -10, 1e-12);
    EXPECT_NEAR(table.at(t).euler_rad[2] / deg, 60, 1e-9);
}

TEST(Turntable, APieceGoesOnSmoothlyBeyondItsCorner) {
    const Table table(hnav_turntable_defaults());
    auto truth = hnav_sized<hnav_truth>();
    ASSERT_EQ(hnav_turntable_in_piece(table.table, 5, 7, &truth), HNAV_OK);
    EXPECT_NEAR(truth.euler_rad[2] / deg, 70, 1e-12);
    EXPECT_NEAR(truth.rate_b_rad_s[2] / deg, 10, 1e-12);
}

TEST(Turntable, AnUnknownStartIsDrawnFromTheSeedWithinItsBounds) {
    hnav_turntable_options o = hnav_turntable_defaults();
    o.yaw.unknown_rad = 0.7;
    double sum = 0, largest = 0, previous = 9;
    for (o.seed = 0; o.seed < 400; ++o.seed) {
        const double yaw = Table(o).at(0).euler_rad[2];
        EXPECT_EQ(yaw, Table(o).at(0).euler_rad[2]);
        EXPECT_NE(yaw, previous);
        previous = yaw;
        sum += yaw * yaw;
        largest = std::fmax(largest, std::fabs(yaw));
    }
    EXPECT_LE(largest, 0.7);
    // Variance a^2/3 with a standard error of a^2 sqrt(4/45/400).
    EXPECT_NEAR(sum / 400, 0.49 / 3, 4 * 0.49 * std::sqrt(4.0 / 45 / 400));
}

TEST(Turntable, ImpossibleOptionsAreNamed) {
    hnav_turntable_options o = hnav_turntable_defaults();
    o.pitch.rate_rad_s = 0;
    hnav_turntable* table = nullptr;
    char message[256] = "";
    EXPECT_EQ(hnav_turntable_create(&table, &o, message, sizeof message), HNAV_ERROR_OPTION);
    EXPECT_NE(std::string(message).find("pitch.rate_rad_s = 0"), std::string::npos) << message;
    o = {};
    EXPECT_EQ(hnav_turntable_create(&table, &o, message, sizeof message), HNAV_ERROR_OPTIONS_STAMP);
    EXPECT_EQ(hnav_turntable_create(nullptr, &o, message, sizeof message), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_turntable_create(&table, nullptr, message, sizeof message), HNAV_ERROR_NULL_ARGUMENT);
    const Table good(hnav_turntable_defaults());
    auto truth = hnav_sized<hnav_truth>();
    EXPECT_EQ(hnav_turntable_at(good.table, NAN, &truth), HNAV_ERROR_NON_FINITE);
    EXPECT_EQ(hnav_turntable_at(good.table, 0, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    const double none[4] = {};
    double force[3], field[3];
    EXPECT_EQ(hnav_turntable_seen_from(good.table, none, force, field), HNAV_ERROR_ZERO_VECTOR);
}

TEST(Turntable, AMessageNamesWhatWasWrong) {
    const Table good(hnav_turntable_defaults());
    hnav_turntable* table = good.table;
    const auto said = [table](const char* what) {
        const std::string text = hnav_turntable_message(table);
        return text.find(what) != std::string::npos ? std::string() : text;
    };
    EXPECT_STREQ(hnav_turntable_message(table), "");
    EXPECT_STREQ(hnav_turntable_message(nullptr), "table is null");
    auto truth = hnav_sized<hnav_truth>();
    double corner, force[3], field[3];
    const double none[4] = {}, infinite[4] = {INFINITY, 0, 0, 0};
    hnav_turntable_at(table, 0, nullptr);
    EXPECT_EQ(said("truth is null"), "");
    hnav_turntable_at(table, NAN, &truth);
    EXPECT_EQ(said("t_s = nan is not finite"), "");
    hnav_turntable_in_piece(table, INFINITY, 0, &truth);
    EXPECT_EQ(said("piece_s = inf is not finite"), "");
    hnav_turntable_next_corner_s(table, -INFINITY, &corner);
    EXPECT_EQ(said("t_s = -inf is not finite"), "");
    hnav_turntable_seen_from(table, none, force, field);
    EXPECT_EQ(said("q_nb has length 0"), "");
    hnav_turntable_seen_from(table, infinite, force, field);
    EXPECT_EQ(said("q_nb is not finite"), "");
    hnav_turntable_seen_from(table, none, force, nullptr);
    EXPECT_EQ(said("field_b_tesla is null"), "");
}

// ------------------------------------------------------------------------------------------------ errors, one at a time

TEST(ImuMagSensor, WithoutErrorsReadsTheTruth) {
    const Table table(tumbling());
    Sensor sensor(hnav_imu_mag_sensor_defaults());
    for (int k = 0; k < 100; ++k) {
        const hnav_truth truth = table.at(0.01 * k);
        sensor.sample(0.01 * k, truth);
        for (int i = 0; i < 3; ++i) {
            EXPECT_EQ(sensor.read(HNAV_SENSOR_GYRO).value[i], truth.rate_b_rad_s[i]);
            EXPECT_EQ(sensor.read(HNAV_SENSOR_ACCEL).value[i], truth.force_b_m_s2[i]);
            EXPECT_EQ(sensor.read(HNAV_SENSOR_MAG).value[i], truth.field_b_tesla[i]);
        }
        EXPECT_EQ(sensor.read(HNAV_SENSOR_GYRO).count, static_cast<std::uint64_t>(k + 1));
        EXPECT_EQ(sensor.read(HNAV_SENSOR_GYRO).t_meas_s, 0.01 * k);
    }
}

TEST(ImuMagSensor, BiasDriftScaleFactorMisalignmentAndGSensitivityActAsTheirDefinitionsSay) {
    hnav_truth truth = rest();
    truth.rate_b_rad_s[0] = 1;
    truth.rate_b_rad_s[1] = 2;
    truth.rate_b_rad_s[2] = -3;
    const Vector3 rate(truth.rate_b_rad_s);
    const auto gyro_error = [&](const std::function<void(hnav_gyro_options&)>& change, double t = 0) {
        hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
        change(o.gyro);
        return Vector3(Sensor(o).value(t, truth, HNAV_SENSOR_GYRO) - rate);
    };
    EXPECT_TRUE(gyro_error([](auto& g) { g.bias_rad_s[1] = 0.25; }).isApprox(Vector3(0, 0.25, 0)));
    EXPECT_TRUE(gyro_error([](auto& g) { g.drift_rad_s2[2] = 0.5; }, 3).isApprox(Vector3(0, 0, 1.5)));
    EXPECT_TRUE(gyro_error([](auto& g) { g.scale_factor[2] = 0.25; }).isApprox(Vector3(0, 0, -0.75)));
    EXPECT_TRUE(gyro_error([](auto& g) { g.misalignment_rad[0] = 0.125; }).isApprox(Vector3(0.25, 0, 0))) << "of y seen in x";
    EXPECT_TRUE(gyro_error([](auto& g) { g.misalignment_rad[5] = 0.125; }).isApprox(Vector3(0, 0, 0.25))) << "of y seen in z";
    EXPECT_TRUE(gyro_error([](auto& g) { g.g_sensitivity_deg_per_h_per_g = 3600; }).isApprox(Vector3(0, 0, -deg), 1e-12));
}

TEST(ImuMagSensor, HardAndSoftIronChangeTheFieldBeforeTheChipReadsIt) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.mag.hard_iron_tesla[1] = 1e-5;
    o.mag.soft_iron[2] = 0.1; // of z seen in x
    o.mag.scale_factor[0] = 0.5;
    const Vector3 reading = Sensor(o).value(0, rest(), HNAV_SENSOR_MAG);
    EXPECT_TRUE(reading.isApprox(Vector3(1.5 * (2e-5 + 0.1 * 4.5e-5), 1e-5, 4.5e-5), 1e-14));
}

TEST(ImuMagSensor, SpreadsHaveTheirStandardDeviationOverSeeds) {
    constexpr int seeds = 600;
    double sum = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
        o.seed = seed;
        o.gyro.bias_sigma_rad_s = 2;
        sum += Sensor(o).value(0, rest(), HNAV_SENSOR_GYRO).squaredNorm();
    }
    constexpr double n = 3 * seeds;
    EXPECT_NEAR(sum / n, 4, 4 * 4 * std::sqrt(2 / n));
}

TEST(ImuMagSensor, WhiteNoiseHasTheVarianceOfItsDensityAtAnyRate) {
    for (const double period : {0.01, 0.002, 1.0}) {
        hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
        o.gyro.period_s = period;
        o.gyro.noise_deg_per_sqrt_h = 60; // 1 deg/s/sqrt(Hz)
        o.accel.period_s = o.mag.period_s = period;
        o.accel.noise_ug_per_sqrt_hz = 1e6;
        o.mag.noise_nt_per_sqrt_hz = 1e9;
        Sensor sensor(o);
        constexpr int n = 4000;
        Vector3 sum = Vector3::Zero();
        for (int k = 0; k < n; ++k) {
            sensor.sample(k * period, rest());
            sum[0] += Vector3(sensor.read(HNAV_SENSOR_GYRO).value).squaredNorm();
            sum[1] += (Vector3(sensor.read(HNAV_SENSOR_ACCEL).value) - Vector3(0, 0, -9.80665)).squaredNorm();
            sum[2] += (Vector3(sensor.read(HNAV_SENSOR_MAG).value) - Vector3(2e-5, 0, 4.5e-5)).squaredNorm();
        }
        const double tolerance = 4 * std::sqrt(2.0 / (3 * n));
        const double psd[] = {deg * deg, 9.80665 * 9.80665, 1};
        for (int s = 0; s < 3; ++s) {
            EXPECT_NEAR(sum[s] / (3 * n) * period / psd[s], 1, tolerance) << period << " s, sensor " << s;
            double published;
            ASSERT_EQ(hnav_imu_mag_sensor_noise_psd(sensor.sensor, static_cast<hnav_sensor>(s), &published), HNAV_OK);
            EXPECT_NEAR(published / psd[s], 1, 1e-12);
        }
    }
}

TEST(ImuMagSensor, ARandomWalkHasAVarianceThatGrowsWithTime) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.gyro.random_walk_deg_per_h_per_sqrt_h = 3600 * 60; // 1 deg/s/sqrt(s)
    constexpr int seeds = 300;
    double sum = 0;
    for (o.seed = 0; o.seed < seeds; ++o.seed) {
        Sensor sensor(o);
        EXPECT_EQ(sensor.value(0, rest(), HNAV_SENSOR_GYRO).norm(), 0);
        for (int k = 1; k < 200; ++k) sensor.sample(0.01 * k, rest());
        sum += sensor.value(2, rest(), HNAV_SENSOR_GYRO).squaredNorm();
    }
    EXPECT_NEAR(sum / (3 * seeds) / (2 * deg * deg), 1, 4 * std::sqrt(2.0 / (3 * seeds)));
}

TEST(ImuMagSensor, ReadingsEndAtTheRangeAndAreMultiplesOfTheResolution) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.gyro.range_rad_s = 2;
    o.gyro.resolution_rad_s = 0.125;
    o.gyro.noise_deg_per_sqrt_h = 60;
    Sensor sensor(o);
    hnav_truth truth = rest();
    truth.rate_b_rad_s[0] = 50;
    truth.rate_b_rad_s[1] = -50;
    double smallest = 1;
    for (int k = 0; k < 500; ++k) {
        const Vector3 y = sensor.value(0.01 * k, truth, HNAV_SENSOR_GYRO);
        EXPECT_EQ(y[0], 2);
        EXPECT_EQ(y[1], -2);
        EXPECT_EQ(std::remainder(y[2], 0.125), 0);
        if (y[2] != 0) smallest = std::fmin(smallest, std::fabs(y[2]));
    }
    EXPECT_EQ(smallest, 0.125);
}

TEST(ImuMagSensor, ASourceOfNoiseDoesNotDisturbTheOthers) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.gyro.noise_deg_per_sqrt_h = 1;
    Sensor alone(o);
    o.gyro.bias_sigma_rad_s = 0.1;
    o.accel.noise_ug_per_sqrt_hz = 100;
    o.mag.dropout = 0.5;
    Sensor together(o);
    const Vector3 bias = together.value(0, rest(), HNAV_SENSOR_GYRO) - alone.value(0, rest(), HNAV_SENSOR_GYRO);
    EXPECT_GT(bias.norm(), 0);
    for (int k = 1; k < 50; ++k) {
        const Vector3 difference =
            together.value(0.01 * k, rest(), HNAV_SENSOR_GYRO) - alone.value(0.01 * k, rest(), HNAV_SENSOR_GYRO);
        EXPECT_LT((difference - bias).norm(), 1e-15);
    }
}

TEST(ImuMagSensor, SeedsZeroAndOneDiffer) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.mag.noise_nt_per_sqrt_hz = 10;
    const Vector3 zero = Sensor(o).value(0, rest(), HNAV_SENSOR_MAG);
    o.seed = 1;
    EXPECT_NE(Sensor(o).value(0, rest(), HNAV_SENSOR_MAG), zero);
}

// ------------------------------------------------------------------------------------------------ time

TEST(ImuMagSensor, SamplesAreTakenAtTheNextPointStampedThereAndCountedOnce) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.mag.period_s = 0.025;
    Sensor sensor(o, 1);
    std::vector<double> stamps;
    std::uint64_t count = 0;
    for (int k = 0; k < 20; ++k) {
        const double t = 1 + 0.01 * k;
        sensor.sample(t, rest());
        sensor.sample(t, rest());
        const hnav_reading mag = sensor.read(HNAV_SENSOR_MAG);
        if (mag.count != count) stamps.push_back(mag.t_meas_s);
        EXPECT_LE(mag.count, count + 1);
        count = mag.count;
    }
    const double expected[] = {1, 1.03, 1.05, 1.08, 1.1, 1.13, 1.15, 1.18};
    ASSERT_EQ(stamps.size(), 8u);
    for (int i = 0; i < 8; ++i) EXPECT_NEAR(stamps[i], expected[i], 1e-12);
}

TEST(ImuMagSensor, WhatACoarseStepLosesIsMissedAndTheNoiseGoesOnAsIfSeen) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.gyro.noise_deg_per_sqrt_h = 1;
    o.gyro.bias_instability_rad_s = 1e-3;
    o.gyro.random_walk_deg_per_h_per_sqrt_h = 100;
    Sensor fine(o), coarse(o);
    for (int k = 0; k <= 100; ++k) fine.sample(0.01 * k, rest());
    for (int k = 0; k <= 20; ++k) coarse.sample(0.05 * k, rest());
    for (int i = 0; i < 3; ++i) EXPECT_EQ(coarse.read(HNAV_SENSOR_GYRO).value[i], fine.read(HNAV_SENSOR_GYRO).value[i]);
    EXPECT_EQ(coarse.read(HNAV_SENSOR_GYRO).missed, 80u);
    EXPECT_EQ(coarse.read(HNAV_SENSOR_GYRO).count, 21u);
    EXPECT_EQ(fine.read(HNAV_SENSOR_GYRO).missed, 0u);
}

TEST(ImuMagSensor, ALatencyDelaysDeliveryAndKeepsTheStamp) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.mag.latency_s = 0.025;
    Sensor sensor(o);
    for (int k = 0; k < 50; ++k) {
        const double t = 0.01 * k;
        sensor.sample(t, rest());
        EXPECT_EQ(sensor.read(HNAV_SENSOR_GYRO).t_meas_s, t);
        const hnav_reading mag = sensor.read(HNAV_SENSOR_MAG);
        if (k < 3) EXPECT_EQ(mag.count, 0u) << k;
        else {
            EXPECT_EQ(mag.t_meas_s, 0.01 * (k - 3)) << k;
            EXPECT_EQ(mag.count, static_cast<std::uint64_t>(k - 2));
        }
    }
}

TEST(ImuMagSensor, TheNextEventIsTheNextSampleOrDelivery) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.mag.latency_s = 0.025;
    Sensor sensor(o);
    double t = 0;
    std::vector<double> events;
    for (int k = 0; k < 6; ++k) {
        sensor.sample(t, rest());
        ASSERT_EQ(hnav_imu_mag_sensor_next_event_s(sensor.sensor, &t), HNAV_OK);
        events.push_back(t);
    }
    const double expected[] = {0.01, 0.02, 0.025, 0.03, 0.035, 0.04};
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(events[i], expected[i], 1e-12);
}

TEST(ImuMagSensor, ADroppedSampleIsNotCounted) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.accel.dropout = 0.3;
    Sensor sensor(o);
    constexpr int n = 2000;
    std::uint64_t count = 0;
    for (int k = 0; k < n; ++k) {
        sensor.sample(0.01 * k, rest());
        const hnav_reading accel = sensor.read(HNAV_SENSOR_ACCEL);
        EXPECT_EQ(accel.count + accel.dropped, static_cast<std::uint64_t>(k + 1));
        EXPECT_EQ(accel.count > 0 && accel.t_meas_s == 0.01 * k, accel.count == count + 1);
        count = accel.count;
    }
    EXPECT_NEAR(static_cast<double>(count) / n, 0.7, 4 * std::sqrt(0.21 / n));
    EXPECT_EQ(sensor.read(HNAV_SENSOR_GYRO).count, static_cast<std::uint64_t>(n));
}

TEST(ImuMagSensor, JitterMovesSamplesWithinItsBoundsAndLosesNone) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.gyro.jitter_s = 0.004;
    Sensor sensor(o);
    constexpr double grid = 1e-4;
    constexpr int n = 500;
    double square = 0, largest = 0;
    std::uint64_t count = 0;
    for (int k = 0; count < n; ++k) {
        sensor.sample(grid * k, rest());
        const hnav_reading gyro = sensor.read(HNAV_SENSOR_GYRO);
        if (gyro.count == count) continue;
        const double moved = gyro.t_meas_s - 0.01 * static_cast<double>(count);
        count = gyro.count;
        if (count == 1) continue; // no sample before the start
        largest = std::fmax(largest, std::fabs(moved));
        square += moved * moved;
    }
    EXPECT_EQ(sensor.read(HNAV_SENSOR_GYRO).missed, 0u);
    EXPECT_LE(largest, 0.004 + grid);
    EXPECT_NEAR(square / n, 0.004 * 0.004 / 3, 4 * 0.004 * 0.004 * std::sqrt(4.0 / 45 / n) + 1e-7);
}

// ------------------------------------------------------------------------------------------------ faults

TEST(ImuMagSensor, FaultWindowsBeginAndEndOnTime) {
    const auto active = [](const std::function<void(hnav_sensor_faults&, double, double)>& set, hnav_sensor kind) {
        hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
        o.gyro.noise_deg_per_sqrt_h = 0.01;
        set(o.fault, 0.3, 0.6);
        hnav_imu_mag_sensor_options healthy_options = o;
        healthy_options.fault = hnav_imu_mag_sensor_defaults().fault;
        Sensor faulty(o), healthy(healthy_options);
        double t = 0; // added up, as importers do
        std::vector<int> seen;
        for (int k = 0; k < 100; ++k, t += 0.01)
            if (faulty.value(t, rest(), kind) != healthy.value(t, rest(), kind)) seen.push_back(k);
        return seen;
    };
    std::vector<int> expected;
    for (int k = 30; k < 60; ++k) expected.push_back(k);
    EXPECT_EQ(active([](auto& f, double a, double b) { f.mag_disturbance = {a, b, {1e-6, 0, 0}, 0}; }, HNAV_SENSOR_MAG),
              expected);
    EXPECT_EQ(active([](auto& f, double a, double b) { f.mag_disturbance = {a, b, {0, 0, 0}, 1e-6}; }, HNAV_SENSOR_MAG),
              expected);
    EXPECT_EQ(active([](auto& f, double a, double b) { f.outliers = {a, b, 1, 1, 1, 1}; }, HNAV_SENSOR_GYRO), expected);
    EXPECT_EQ(active([](auto& f, double a, double b) { f.outliers = {a, b, 1, 1, 1, 1}; }, HNAV_SENSOR_ACCEL), expected);
    EXPECT_EQ(active([](auto& f, double a, double b) { f.bias_jump = {a, b, {0, 1, 0}, {}, {}}; }, HNAV_SENSOR_GYRO), expected);
    EXPECT_EQ(active([](auto& f, double a, double b) { f.noise_increase = {a, b, 5, 1, 1}; }, HNAV_SENSOR_GYRO), expected);
    EXPECT_EQ(active([](auto& f, double a, double b) { f.stuck = {a, b, HNAV_STUCK_GYRO, 2}; }, HNAV_SENSOR_GYRO), expected);
    EXPECT_TRUE(active([](auto& f, double a, double) { f.bias_jump = {a, a, {0, 1, 0}, {}, {}}; }, HNAV_SENSOR_GYRO).empty());
}

TEST(ImuMagSensor, AMagneticDisturbanceIsFixedInTheWorld) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.fault.mag_disturbance = {0, 100, {0, 0, 0}, 1.5e-5};
    const Table table(tumbling());
    Sensor sensor(o);
    Vector3 first = Vector3::Zero();
    for (int k = 0; k < 300; k += 10) {
        const hnav_truth truth = table.at(0.01 * k);
        const Vector3 seen = sensor.value(0.01 * k, truth, HNAV_SENSOR_MAG) - Vector3(truth.field_b_tesla);
        const Vector3 outside = hnav::rotation_matrix(Quaternion(truth.q_nb)) * seen;
        if (k == 0) first = outside;
        EXPECT_NEAR(outside.norm(), 1.5e-5, 1e-18);
        EXPECT_LT((outside - first).norm(), 1e-18);
    }
}

TEST(ImuMagSensor, AStuckAxisRepeatsItsLastReadingAndTheOthersGoOn) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.fault.stuck = {0.5, 1, HNAV_STUCK_ACCEL, 3};
    Sensor sensor(o);
    for (int k = 0; k < 150; ++k) {
        hnav_truth truth = rest();
        truth.force_b_m_s2[1] = truth.force_b_m_s2[2] = k;
        const Vector3 y = sensor.value(0.01 * k, truth, HNAV_SENSOR_ACCEL);
        EXPECT_EQ(y[1], k);
        EXPECT_EQ(y[2], k >= 50 && k < 100 ? 49 : k);
    }
}

TEST(ImuMagSensor, OutliersComeWithTheirProbabilityAndSize) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.fault.outliers = {0, 1000, 0.1, 0, 5, 0};
    Sensor sensor(o);
    constexpr int n = 5000;
    int hit = 0;
    double square = 0;
    for (int k = 0; k < n; ++k) {
        const Vector3 error = sensor.value(0.01 * k, rest(), HNAV_SENSOR_ACCEL) - Vector3(0, 0, -9.80665);
        EXPECT_EQ(Vector3(sensor.read(HNAV_SENSOR_GYRO).value).norm(), 0);
        hit += error.norm() > 0;
        square += error.squaredNorm();
    }
    EXPECT_NEAR(hit / double(n), 0.1, 4 * std::sqrt(0.09 / n));
    EXPECT_NEAR(square / (3 * hit) / 25, 1, 4 * std::sqrt(2.0 / (3 * hit)));
}

// ------------------------------------------------------------------------------------------------ state, refusals

TEST(ImuMagSensor, SaveWreckLoadGoesOnBitForBitAndResetStartsAnew) {
    hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    o.gyro.noise_deg_per_sqrt_h = 1;
    o.gyro.bias_instability_rad_s = 1e-3;
    o.gyro.random_walk_deg_per_h_per_sqrt_h = 10;
    o.mag.latency_s = 0.05;
    o.mag.noise_nt_per_sqrt_hz = 10;
    o.accel.dropout = 0.2;
    Sensor sensor(o);
    const auto run = [&](int from, int to) {
        std::vector<double> seen;
        for (int k = from; k < to; ++k) {
            sensor.sample(0.01 * k, rest());
            for (int s = 0; s < 3; ++s) {
                const hnav_reading r = sensor.read(static_cast<hnav_sensor>(s));
                seen.insert(seen.end(), {r.value[0], r.value[1], r.value[2], r.t_meas_s, static_cast<double>(r.count),
                                         static_cast<double>(r.dropped)});
            }
        }
        return seen;
    };
    const std::vector<double> beginning = run(0, 100);
    std::size_t bytes;
    ASSERT_EQ(hnav_imu_mag_sensor_state_size(sensor.sensor, &bytes), HNAV_OK);
    std::vector<char> state(bytes), again(bytes);
    ASSERT_EQ(hnav_imu_mag_sensor_save(sensor.sensor, state.data(), bytes), HNAV_OK);
    const std::vector<double> rest_of_it = run(100, 200);
    run(200, 300);
    ASSERT_EQ(hnav_imu_mag_sensor_load(sensor.sensor, state.data(), bytes), HNAV_OK);
    ASSERT_EQ(hnav_imu_mag_sensor_save(sensor.sensor, again.data(), bytes), HNAV_OK);
    EXPECT_EQ(state, again);
    EXPECT_EQ(run(100, 200), rest_of_it);
    ASSERT_EQ(hnav_imu_mag_sensor_reset(sensor.sensor), HNAV_OK);
    EXPECT_EQ(run(0, 100), beginning);

    EXPECT_EQ(hnav_imu_mag_sensor_load(sensor.sensor, state.data(), bytes - 1), HNAV_ERROR_SIZE);
    EXPECT_EQ(hnav_imu_mag_sensor_save(sensor.sensor, again.data(), bytes - 1), HNAV_ERROR_SIZE);
    o.seed = 7;
    Sensor other(o);
    EXPECT_EQ(hnav_imu_mag_sensor_load(other.sensor, state.data(), bytes), HNAV_ERROR_STATE_CORRUPT);
}

TEST(ImuMagSensor, ATruthThatIsNoneTakesNothing) {
    Sensor sensor(hnav_imu_mag_sensor_defaults());
    hnav_truth truth = rest();
    truth.q_nb[0] = 0;
    EXPECT_EQ(hnav_imu_mag_sensor_sample(sensor.sensor, 0, &truth), HNAV_ERROR_ZERO_VECTOR);
    truth = rest();
    truth.rate_b_rad_s[1] = NAN;
    EXPECT_EQ(hnav_imu_mag_sensor_sample(sensor.sensor, 0, &truth), HNAV_ERROR_NON_FINITE);
    EXPECT_EQ(sensor.read(HNAV_SENSOR_GYRO).count, 0u);
    sensor.sample(0.01, rest());
    EXPECT_EQ(sensor.read(HNAV_SENSOR_GYRO).count, 1u);
    EXPECT_EQ(sensor.read(HNAV_SENSOR_GYRO).t_meas_s, 0.01);
}

TEST(ImuMagSensor, ImpossibleOptionsAndArgumentsAreNamed) {
    const auto with = [](const std::function<void(hnav_imu_mag_sensor_options&)>& change) {
        hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
        change(o);
        return refusal(o, HNAV_ERROR_OPTION);
    };
    EXPECT_NE(with([](auto& o) { o.gyro.period_s = 0; }).find("gyro.period_s = 0"), std::string::npos);
    EXPECT_NE(with([](auto& o) { o.mag.soft_iron[4] = NAN; }).find("mag.soft_iron[4]"), std::string::npos);
    EXPECT_NE(with([](auto& o) { o.fault.outliers.probability = 2; }).find("fault.outliers.probability = 2"), std::string::npos);
    EXPECT_NE(with([](auto& o) { o.accel.jitter_s = 0.005; }).find("accel.jitter_s = 0.005 must be below half of accel.period_s"),
              std::string::npos);
    EXPECT_NE(with([](auto& o) { o.mag.latency_s = 1; }).find("mag.latency_s = 1 is more than 30 times mag.period_s"),
              std::string::npos);
    refusal({}, HNAV_ERROR_OPTIONS_STAMP);
    Sensor sensor(hnav_imu_mag_sensor_defaults());
    auto reading = hnav_sized<hnav_reading>();
    EXPECT_EQ(hnav_imu_mag_sensor_reading(sensor.sensor, HNAV_SENSOR_HEADING, &reading), HNAV_ERROR_OUT_OF_RANGE);
    EXPECT_EQ(hnav_imu_mag_sensor_reading(sensor.sensor, HNAV_SENSOR_GYRO, nullptr), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_imu_mag_sensor_advance(sensor.sensor, NAN), HNAV_ERROR_NON_FINITE);
    hnav_imu_mag_sensor* none = nullptr;
    const hnav_imu_mag_sensor_options o = hnav_imu_mag_sensor_defaults();
    EXPECT_EQ(hnav_imu_mag_sensor_create(&none, &o, NAN, nullptr, 0), HNAV_ERROR_NON_FINITE);
}

TEST(ImuMagSensor, AMessageNamesWhatWasWrong) {
    Sensor good(hnav_imu_mag_sensor_defaults());
    hnav_imu_mag_sensor* sensor = good.sensor;
    const auto said = [sensor](const char* what) {
        const std::string text = hnav_imu_mag_sensor_message(sensor);
        return text.find(what) != std::string::npos ? std::string() : text;
    };
    EXPECT_STREQ(hnav_imu_mag_sensor_message(sensor), "");
    EXPECT_STREQ(hnav_imu_mag_sensor_message(nullptr), "sensor is null");
    hnav_truth truth = rest();
    truth.force_b_m_s2[2] = NAN;
    hnav_imu_mag_sensor_sample(sensor, 0, &truth);
    EXPECT_EQ(said("truth.force_b_m_s2[2] = nan is not finite"), "");
    truth = rest();
    truth.q_nb[0] = 0.25;
    hnav_imu_mag_sensor_sample(sensor, 0, &truth);
    EXPECT_EQ(said("truth.q_nb has length 0.25"), "");
    hnav_imu_mag_sensor_sample(sensor, INFINITY, &truth);
    EXPECT_EQ(said("t_s = inf is not finite"), "");
    hnav_imu_mag_sensor_advance(sensor, NAN);
    EXPECT_EQ(said("t_s = nan is not finite"), "");
    hnav_imu_mag_sensor_next_event_s(sensor, nullptr);
    EXPECT_EQ(said("next_s is null"), "");
    auto reading = hnav_sized<hnav_reading>();
    hnav_imu_mag_sensor_reading(sensor, HNAV_SENSOR_HEADING, &reading);
    EXPECT_EQ(said("sensor_kind = 3"), "");
    double psd;
    hnav_imu_mag_sensor_noise_psd(sensor, static_cast<hnav_sensor>(-1), &psd);
    EXPECT_EQ(said("sensor_kind = -1"), "");
    unsigned char byte;
    hnav_imu_mag_sensor_save(sensor, &byte, 1);
    EXPECT_EQ(said("buffer has 1 bytes"), "");
}
