// Faults of sensors and clocks through the C API: the attitude recovers within seconds, and no wrong attitude is ready until
// then.
#include "hnav/hnav.h"
#include "maths/rotation.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <vector>

using namespace hnav;

namespace {

constexpr double deg = M_PI / 180, interval_s = 0.01;
const Vector3 field_n(2e-5, 0, 4e-5); // tesla; north, east, down

struct Sample {
    double t_s;
    Vector3 rate, force, field;
};

// A hand that turns and shakes, with the noise of consumer sensors; damage changes samples from from_s on.
class Hand {
public:
    Hand(bool ahrs, std::function<void(Sample&)> damage, std::int32_t start_mode = HNAV_START_TRIAD)
        : damage_(std::move(damage)) {
        char message[256];
        hnav_ahrs_options a = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
        hnav_hrekf_options h = hnav_hrekf_defaults(HNAV_PRESET_DEFAULT);
        a.start_mode = h.start_mode = start_mode;
        h.gyro_hold = HNAV_GYRO_HOLD_BACKWARD;
        const hnav_status status = ahrs ? hnav_ahrs_create(&filter_, &a, message, sizeof message)
                                        : hnav_hrekf_create(&filter_, &h, message, sizeof message);
        EXPECT_EQ(status, HNAV_OK) << message;
    }
    Hand(const Hand&) = delete;
    ~Hand() { hnav_filter_destroy(filter_); }

    // Continues for so long; the mean rate of an interval is that of the sample at its end.
    void run(double duration_s) {
        for (const double end_s = t_s_ + duration_s; t_s_ < end_s; t_s_ += interval_s) {
            const Vector3 rate(std::sin(1.3 * t_s_), 0.8 * std::cos(0.9 * t_s_), 0.7 * std::sin(0.5 * t_s_));
            q_ = multiply(q_, rotation_quaternion(rate * interval_s)).normalized();
            const Matrix3 to_body = rotation_matrix(q_).transpose();
            const Vector3 shake(std::sin(7 * t_s_), 0.5 * std::cos(9 * t_s_), 0);
            Sample s{t_s_, rate + noise(0.002), to_body * (shake - Vector3(0, 0, 9.80665)) + noise(0.02),
                     to_body * field_n + noise(3e-7)};
            if (damaged) damage_(s);
            EXPECT_EQ(hnav_filter_push_imu(filter_, s.t_s, s.rate.data(), s.force.data()), HNAV_OK)
                << hnav_filter_message(filter_);
            EXPECT_EQ(hnav_filter_push_mag(filter_, s.t_s, s.field.data()), HNAV_OK) << hnav_filter_message(filter_);
            EXPECT_EQ(hnav_filter_advance(filter_, s.t_s), HNAV_OK) << hnav_filter_message(filter_);
            look();
        }
    }

    void turn(double angle_rad) { q_ = multiply(q_, rotation_quaternion({angle_rad, 0, 0})); }
    void turn_about_field(double angle_rad) { q_ = multiply(rotation_quaternion(angle_rad * field_n.normalized()), q_); }
    void skip(double duration_s) { t_s_ += duration_s; }

    double tilt_error() const {
        const Vector3 down(0, 0, 1);
        const Vector3 estimated = rotation_matrix(q_of(attitude())).transpose() * down,
                      truth = rotation_matrix(q_).transpose() * down;
        return std::acos(std::fmin(1.0, estimated.dot(truth)));
    }

    // Angle between estimate and truth, and its stated sigma: the root of the sum of the variances.
    double rotation_error() const { return 2 * std::acos(std::fmin(1.0, std::fabs(q_of(attitude()).dot(q_)))); }
    double rotation_sigma() const { return Vector3(attitude().sigma_rad).norm(); }

    hnav_attitude attitude() const {
        auto a = hnav_sized<hnav_attitude>();
        EXPECT_EQ(hnav_filter_attitude(filter_, &a), HNAV_OK);
        return a;
    }

    hnav_attitude shown(double silence_s) {
        EXPECT_EQ(hnav_filter_advance(filter_, t_s_ - interval_s + silence_s), HNAV_OK);
        return attitude();
    }

    hnav_attitude shown_by_integrator(double silence_s) {
        int32_t nx = 0;
        EXPECT_EQ(hnav_filter_nx(filter_, &nx), HNAV_OK);
        std::vector<double> x(nx);
        EXPECT_EQ(hnav_filter_get_x(filter_, x.data()), HNAV_OK);
        EXPECT_EQ(hnav_filter_show(filter_, t_s_ - interval_s + silence_s, x.data()), HNAV_OK);
        return attitude();
    }

    hnav_health health() const {
        auto h = hnav_sized<hnav_health>();
        EXPECT_EQ(hnav_filter_health(filter_, &h), HNAV_OK);
        return h;
    }

    bool damaged = false;
    int rows = 0, falsely_ready = 0; // ready with an error above 5 deg and 5 sigma

private:
    static Quaternion q_of(const hnav_attitude& a) { return Quaternion(a.q_nb); }

    Vector3 noise(double sigma) { return sigma * Vector3(normal_(random_), normal_(random_), normal_(random_)); }

    void look() {
        auto a = hnav_sized<hnav_attitude>();
        ++rows;
        if (hnav_filter_attitude(filter_, &a) != HNAV_OK || !a.tilt_ready) return;
        const double sigma = std::fmax(a.sigma_rad[0], a.sigma_rad[1]), error = tilt_error();
        falsely_ready += error > 5 * deg && error > 5 * sigma;
    }

    std::function<void(Sample&)> damage_;
    hnav_filter* filter_ = nullptr;
    Quaternion q_ = Quaternion(0.9, 0.3, -0.2, 0.1).normalized();
    double t_s_ = 0;
    std::mt19937 random_{3};
    std::normal_distribution<double> normal_;
};

struct Fault {
    const char* name;
    double duration_s;
    std::function<void(Sample&)> damage;
    hnav_sensor sensor;
    hnav_sensor_state state; // the offset at its end
};

const Fault faults[] = {
    {"clipped gyroscope", 5, [](Sample& s) { s.rate = (3 * s.rate).cwiseMin(1.8).cwiseMax(-1.8); }, HNAV_SENSOR_GYRO,
     HNAV_SENSOR_STATE_OK},
    {"dead axis", 5, [](Sample& s) { s.rate[0] = 0; }, HNAV_SENSOR_GYRO, HNAV_SENSOR_STATE_STUCK},
    {"shock", 1, [](Sample& s) { s.force[1] += 157; }, HNAV_SENSOR_ACCEL, HNAV_SENSOR_STATE_OK},
    {"clipped shock", 0.5, [](Sample& s) { s.force[1] = 157; }, HNAV_SENSOR_ACCEL, HNAV_SENSOR_STATE_SATURATED},
    {"gyro spike", interval_s / 2, [](Sample& s) { s.rate[2] += 35; }, HNAV_SENSOR_GYRO, HNAV_SENSOR_STATE_OUTLIER},
    {"stuck field", 5, [](Sample& s) { s.field = Vector3(1e-5, 2e-5, 3e-5); }, HNAV_SENSOR_MAG, HNAV_SENSOR_STATE_STUCK},
};

} // namespace

TEST(Recovery, TheTiltIsBackWithinSecondsOfAnyFault) {
    for (const bool ahrs : {true, false})
        for (const Fault& fault : faults) {
            SCOPED_TRACE(testing::Message() << (ahrs ? "ahrs" : "hrekf") << ", " << fault.name);
            Hand hand(ahrs, fault.damage);
            hand.run(30);
            hand.damaged = true;
            hand.run(fault.duration_s);
            if (fault.state != HNAV_SENSOR_STATE_OK) EXPECT_EQ(hand.health().sensor[fault.sensor].state, fault.state);
            hand.damaged = false;
            hand.run(6);
            for (int k = 0; k < 20; ++k) {
                EXPECT_LT(hand.tilt_error(), 5 * deg);
                hand.run(0.5);
            }
            EXPECT_LT(hand.falsely_ready, 0.01 * hand.rows);
            EXPECT_EQ(hand.health().sensor[HNAV_SENSOR_GYRO].state, HNAV_SENSOR_STATE_OK);
        }
}

// A magnetometer whose x and y axes are negated, a constant magnet that turns with the body: the strength does not change.
TEST(Recovery, AHeadingThatTheFieldSpeaksAgainstIsNotReady) {
    for (const bool ahrs : {true, false}) {
        SCOPED_TRACE(ahrs ? "ahrs" : "hrekf");
        Hand hand(ahrs, [](Sample& s) { s.field.head<2>() *= -1; });
        hand.run(60);
        EXPECT_EQ(hand.attitude().heading_ready, 1);
        hand.damaged = true;
        hand.run(5);
        for (int k = 0; k < 30; ++k) {
            hand.run(0.5);
            EXPECT_EQ(hand.attitude().heading_ready, 0) << 5 + 0.5 * k << " s after it began";
        }
        hand.damaged = false;
        hand.run(120);
        EXPECT_EQ(hand.attitude().heading_ready, 1);
    }
}

// The samples of a turning body end: the stated sigma grows, and the estimate is no longer ready.
TEST(Recovery, AnEstimateThatNoSampleTouchesGrowsUncertain) {
    for (const bool ahrs : {true, false}) {
        SCOPED_TRACE(ahrs ? "ahrs" : "hrekf");
        Hand hand(ahrs, [](Sample&) {});
        hand.run(60);
        const hnav_attitude before = hand.attitude();
        EXPECT_EQ(before.tilt_ready, ahrs);
        double sigma = before.sigma_rad[0];
        for (const double silence_s : {0.3, 0.9, 1.5, 100.0}) {
            const hnav_attitude a = hand.shown(silence_s);
            EXPECT_GT(a.sigma_rad[0], sigma);
            sigma = a.sigma_rad[0];
            if (silence_s > 1) EXPECT_FALSE(a.tilt_ready || a.heading_ready) << silence_s;
        }
        EXPECT_GT(sigma, 1.5);
    }
}

// A caller's integrator shows times between events: flags and health change at the next event, as the rules of FMI require.
TEST(Recovery, WhatIsNotContinuousChangesAtEventsOnly) {
    for (const bool ahrs : {true, false}) {
        Hand hand(ahrs, [](Sample&) {});
        hand.run(60);
        const hnav_attitude before = hand.attitude();
        const hnav_attitude after = hand.shown_by_integrator(5);
        EXPECT_EQ(after.tilt_ready, before.tilt_ready);
        EXPECT_GT(after.sigma_rad[0], before.sigma_rad[0]);
        EXPECT_EQ(hand.health().sensor[HNAV_SENSOR_GYRO].state, HNAV_SENSOR_STATE_OK);
        hand.shown(5);
        EXPECT_EQ(hand.health().sensor[HNAV_SENSOR_GYRO].state, HNAV_SENSOR_STATE_MISSING);
    }
}

TEST(Recovery, AGapInWhichTheBodyTurnedIsFoundOut) {
    for (const bool ahrs : {true, false}) {
        Hand hand(ahrs, [](Sample&) {});
        hand.run(30);
        hand.skip(86400);
        hand.turn(M_PI / 2);
        hand.run(3);
        for (int k = 0; k < 20; ++k) {
            EXPECT_LT(hand.tilt_error(), 5 * deg);
            hand.run(0.5);
        }
        EXPECT_LT(hand.falsely_ready, 0.01 * hand.rows);
        EXPECT_GE(hand.health().times_lost, 1u);
        EXPECT_EQ(hand.health().lost, 0);
    }
}

// The given attitude is that of the first start.
TEST(Recovery, AfterAGapTheGivenAttitudeIsNotTheFirstOneAgain) {
    for (const std::int32_t start_mode : {HNAV_START_ATTITUDE, HNAV_START_HEADING}) {
        for (const bool ahrs : {true, false}) {
            Hand hand(ahrs, [](Sample&) {}, start_mode);
            hand.run(30);
            hand.skip(86400);
            hand.turn(M_PI / 2);
            hand.run(10);
            EXPECT_LT(hand.rotation_error(), 3 * hand.rotation_sigma()) << start_mode << ahrs;
            EXPECT_LT(hand.falsely_ready, 0.01 * hand.rows) << start_mode << ahrs;
        }
    }
}

// The body turned about the field, which is measured as before. The samples of the field that were gathered before the horizon was found
// have to turn with the horizon; else the heading is wrong at a small sigma.
TEST(Recovery, AfterATurnAboutTheFieldTheFirstHeadingIsRight) {
    for (const double angle_rad : {1.0, 1.5, -1.5, 2.5}) {
        Hand hand(true, [](Sample&) {});
        hand.run(30);
        hand.skip(86400);
        hand.turn_about_field(angle_rad);
        hand.run(0.3);
        while (hand.health().lost) hand.run(interval_s);
        EXPECT_LT(hand.rotation_error(), hand.rotation_sigma()) << angle_rad;
    }
}

// Without a magnetometer after the gap: the variance of the rotation in the gap follows from how the rate changed before.
TEST(Recovery, AfterAShortGapTheHeadingIsAsUncertainAsTheRateWasRestless) {
    const auto added = [](double restless_rad_s) {
        hnav_hrekf_options options = hnav_hrekf_defaults(HNAV_PRESET_DEFAULT);
        hnav_filter* filter = nullptr;
        EXPECT_EQ(hnav_hrekf_create(&filter, &options, nullptr, 0), HNAV_OK);
        const double force[3] = {0, 0, -9.80665}, field[3] = {2e-5, 0, 4e-5};
        auto before = hnav_sized<hnav_attitude>(), after = before;
        for (int k = 0; k <= 1000; ++k) {
            const double rate[3] = {0, 0, k % 2 ? restless_rad_s : -restless_rad_s}, t_s = k * interval_s;
            EXPECT_EQ(hnav_filter_push_imu(filter, t_s, rate, force), HNAV_OK);
            EXPECT_EQ(hnav_filter_push_mag(filter, t_s, field), HNAV_OK);
            EXPECT_EQ(hnav_filter_advance(filter, t_s), HNAV_OK);
        }
        EXPECT_EQ(hnav_filter_attitude(filter, &before), HNAV_OK);
        const double end_s = 10.4, rate[3] = {};
        EXPECT_EQ(hnav_filter_push_imu(filter, end_s, rate, force), HNAV_OK);
        EXPECT_EQ(hnav_filter_advance(filter, end_s), HNAV_OK);
        EXPECT_EQ(hnav_filter_attitude(filter, &after), HNAV_OK);
        hnav_filter_destroy(filter);
        return std::pow(after.sigma_rad[2], 2) - std::pow(before.sigma_rad[2], 2);
    };
    const double calm = added(0), restless = added(0.01), twice = added(0.02);
    EXPECT_GT(calm, 0);
    EXPECT_GT(restless, calm + 0.01);
    EXPECT_NEAR(twice - calm, 4 * (restless - calm), 0.2 * (restless - calm));
}

TEST(Recovery, AClockThatIsSetBackCostsNothing) {
    for (const bool ahrs : {true, false}) {
        double set_s = 0;
        Hand hand(ahrs, [&](Sample& s) { s.t_s -= set_s; });
        hand.run(30);
        hand.damaged = true;
        set_s = 30;
        hand.run(20);
        EXPECT_LT(hand.tilt_error(), 2 * deg);
        EXPECT_EQ(hand.health().clock_jumps, 1u);
        EXPECT_NEAR(hand.attitude().t_s, 20, 0.1);
    }
}

TEST(Health, AHealthySensorIsOkAndOneThatNeverCameIsMissing) {
    Hand hand(true, [](Sample&) {});
    hand.run(20);
    const hnav_health h = hand.health();
    for (const hnav_sensor sensor : {HNAV_SENSOR_GYRO, HNAV_SENSOR_ACCEL, HNAV_SENSOR_MAG}) {
        EXPECT_EQ(h.sensor[sensor].state, HNAV_SENSOR_STATE_OK);
        EXPECT_EQ(h.sensor[sensor].left_out, 0u);
    }
    EXPECT_EQ(h.sensor[HNAV_SENSOR_HEADING].state, HNAV_SENSOR_STATE_MISSING);
    EXPECT_TRUE(std::isnan(h.sensor[HNAV_SENSOR_HEADING].since_s));
    EXPECT_EQ(h.times_lost + h.clock_jumps + h.stamps_left_out, 0u);
}
