// Calibration through the C API: laws without noise, effects of outliers and poor motion, every refusal.
#include "hnav/hnav.h"

#include "laws.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cstdio>
#include <functional>
#include <limits>
#include <string>
#include <vector>

using namespace hnav;
using hnav::test::distance;
using hnav::test::Random;

namespace {

constexpr double deg = M_PI / 180;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double gravity = 9.81;

// A distorted magnetometer and an accelerometer that rotate, and the field of a perfect magnetometer.
struct Recording {
    std::vector<Vector3> field, force, truth;
    std::vector<bool> outlier;
    Matrix3 D; // field = D truth + offset
    Vector3 offset;

    std::size_t size() const { return field.size(); }
};

struct Scenario {
    std::size_t samples = 600;
    double dip_rad = 54 * deg;
    double field_sigma = 0, force_sigma = 0; // in units of field and of gravity
    double outliers = 0;                     // share of field samples with an error of half the field
    double tilt_rad = M_PI;                  // roll and pitch within +- this; M_PI: any attitude
    bool rotated = true;                     // field axes turned against force axes by a few degrees
};

Matrix3 turn(const Vector3& phi) { return rotation_matrix(rotation_quaternion(phi)); }

Recording record(const Scenario& scenario, unsigned seed) {
    Random random(seed);
    Recording r;
    Matrix3 soft;
    for (int i = 0; i < 9; ++i) soft(i) = 0.1 * random.normal();
    r.D = turn(scenario.rotated ? random.vector(0.05) : Vector3(0, 0, 0)) * (Matrix3::Identity() + soft);
    if (!scenario.rotated) r.D = 0.5 * (r.D + r.D.transpose()).eval();
    r.offset = random.vector(0.3);
    const Vector3 field_n(std::cos(scenario.dip_rad), 0, std::sin(scenario.dip_rad));
    std::mt19937_64 engine(seed + 1000);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (std::size_t i = 0; i < scenario.samples; ++i) {
        Quaternion q = random.quaternion();
        if (scenario.tilt_rad < M_PI)
            q = multiply(multiply(rotation_quaternion({0, 0, M_PI * uniform(engine)}),
                                  rotation_quaternion({0, scenario.tilt_rad * uniform(engine), 0})),
                         rotation_quaternion({scenario.tilt_rad * uniform(engine), 0, 0}));
        const Matrix3 R_nb = rotation_matrix(q).transpose();
        r.truth.push_back(R_nb * field_n);
        r.outlier.push_back(std::fabs(uniform(engine)) < scenario.outliers);
        r.field.push_back(r.D * r.truth.back() + r.offset + random.vector(scenario.field_sigma) +
                          (r.outlier.back() ? random.vector(0.5) : Vector3(0, 0, 0)));
        r.force.push_back(gravity * (R_nb * Vector3(0, 0, -1) + random.vector(scenario.force_sigma)));
    }
    return r;
}

struct Answer {
    hnav_status status;
    hnav_magnetometer_calibration c = hnav_sized<hnav_magnetometer_calibration>();
    std::string message;

    Vector3 offset() const { return Vector3(c.offset); }
    Matrix3 matrix() const { return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(c.matrix); }
    Vector3 corrected(const Vector3& field) const { return matrix() * (field - offset()); }
};

Answer calibrate(
    const Recording& r, bool with_force = true,
    const std::function<void(hnav_magnetometer_options&)>& change = [](hnav_magnetometer_options&) {}) {
    hnav_magnetometer_options options = hnav_magnetometer_defaults();
    change(options);
    Answer answer{};
    char message[320] = "";
    answer.status = hnav_calibrate_magnetometer(r.size(), r.field.data()->data(), with_force ? r.force.data()->data() : nullptr,
                                                &options, &answer.c, message, sizeof message);
    answer.message = message;
    return answer;
}

double angle(const Vector3& a, const Vector3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// Root mean square angle between corrected and true field over the samples that are no outliers.
double direction_error(const Recording& r, const std::function<Vector3(const Vector3&)>& corrected) {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < r.size(); ++i) {
        if (r.outlier[i]) continue;
        sum += std::pow(angle(corrected(r.field[i]), r.truth[i]), 2);
        ++count;
    }
    return std::sqrt(sum / count);
}

double direction_error(const Recording& r, const Answer& a) {
    return direction_error(r, [&](const Vector3& field) { return a.corrected(field); });
}

// The same without noise: the remaining error is that of the calibration.
Recording clean_of(const Recording& r) {
    Recording clean = r;
    for (std::size_t i = 0; i < r.size(); ++i) clean.field[i] = r.D * r.truth[i] + r.offset;
    return clean;
}

double middle(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
}

} // namespace

// ------------------------------------------------------------------------------------------------ laws

TEST(MagnetometerCalibration, AKnownDistortionIsRecoveredExactlyWithoutNoise) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        const Recording r = record({}, seed);
        const Answer a = calibrate(r);
        ASSERT_EQ(a.status, HNAV_OK) << a.message;
        EXPECT_EQ(a.c.fit, HNAV_MAGNETOMETER_FULL);
        EXPECT_EQ(a.c.offset_axes, 3);
        EXPECT_LT(distance(a.offset(), r.offset), 1e-9);
        EXPECT_LT(distance(a.matrix() / std::cbrt(r.D.determinant()), r.D.inverse()), 1e-9);
        EXPECT_NEAR(a.c.strength, std::cbrt(r.D.determinant()), 1e-9);
        EXPECT_NEAR(a.c.dip_rad, 54 * deg, 1e-9);
        EXPECT_LT(a.c.residual_after, 1e-9);
        EXPECT_LT(a.c.dip_spread_after_rad, 1e-9);
        EXPECT_GT(a.c.residual_before, 0.01);
        EXPECT_EQ(a.c.outlier_fraction, 0);
        EXPECT_NEAR(a.matrix().determinant(), 1, 1e-12);
    }
}

TEST(MagnetometerCalibration, WithoutForceTheMatrixIsSymmetricAndTheEllipsoidIsTheSame) {
    const Recording r = record({}, 3);
    const Answer a = calibrate(r, false);
    ASSERT_EQ(a.status, HNAV_OK) << a.message;
    EXPECT_EQ(a.c.fit, HNAV_MAGNETOMETER_NO_ROTATION);
    EXPECT_TRUE(std::isnan(a.c.dip_rad));
    EXPECT_TRUE(std::isnan(a.c.dip_spread_after_rad));
    EXPECT_LT(distance(a.matrix(), a.matrix().transpose()), 1e-12);
    EXPECT_LT(distance(a.offset(), r.offset), 1e-9);
    const Matrix3 D_inverse = r.D.inverse() * std::cbrt(r.D.determinant());
    EXPECT_LT(distance(a.matrix().transpose() * a.matrix(), D_inverse.transpose() * D_inverse), 1e-9);
}

TEST(MagnetometerCalibration, TurnedSensorAxesTurnTheAnswer) {
    const Recording r = record({600, 54 * deg, 0.005, 0.01, 0.05}, 4);
    const Matrix3 Q = turn({0.4, -1.1, 2.0});
    Recording turned = r;
    for (std::size_t i = 0; i < r.size(); ++i) {
        turned.field[i] = Q * r.field[i];
        turned.force[i] = Q * r.force[i];
    }
    const Answer a = calibrate(r), b = calibrate(turned);
    ASSERT_EQ(a.status, HNAV_OK) << a.message;
    ASSERT_EQ(b.status, HNAV_OK) << b.message;
    EXPECT_LT(distance(b.offset(), Q * a.offset()), 1e-8);
    EXPECT_LT(distance(b.matrix(), Q * a.matrix() * Q.transpose()), 1e-8);
    EXPECT_NEAR(b.c.dip_rad, a.c.dip_rad, 1e-8);
    EXPECT_NEAR(b.c.direction_sigma_rad, a.c.direction_sigma_rad, 1e-3 * a.c.direction_sigma_rad); // summed over 64 directions
}

TEST(MagnetometerCalibration, AnotherUnitOfTheFieldScalesOffsetAndStrengthOnly) {
    const Recording r = record({600, 54 * deg, 0.005, 0.01}, 5);
    Recording tesla = r;
    for (Vector3& field : tesla.field) field *= 5e-5;
    for (Vector3& force : tesla.force) force /= gravity;
    const Answer a = calibrate(r), b = calibrate(tesla);
    ASSERT_EQ(b.status, HNAV_OK) << b.message;
    EXPECT_LT(distance(b.offset() / 5e-5, a.offset()), 1e-9);
    EXPECT_LT(distance(b.matrix(), a.matrix()), 1e-9);
    EXPECT_NEAR(b.c.strength / 5e-5, a.c.strength, 1e-9);
    EXPECT_NEAR(b.c.residual_after, a.c.residual_after, 1e-9);
}

TEST(MagnetometerCalibration, MissingRowsAreAsIfTheyWereNotThere) {
    const Recording r = record({600, 54 * deg, 0.005, 0.01}, 6);
    Recording gaps = r, without_some_forces = r;
    for (std::size_t i = 0; i < 100; ++i) {
        gaps.field.insert(gaps.field.begin() + 6 * i, Vector3::Constant(not_a_number));
        gaps.force.insert(gaps.force.begin() + 6 * i, Vector3(1, 2, 3));
    }
    for (std::size_t i = 0; i < 500; ++i) without_some_forces.force[i].setConstant(not_a_number);
    const Answer a = calibrate(r), b = calibrate(gaps), c = calibrate(without_some_forces);
    ASSERT_EQ(b.status, HNAV_OK) << b.message;
    EXPECT_EQ(distance(a.matrix(), b.matrix()), 0);
    EXPECT_EQ(distance(a.offset(), b.offset()), 0);
    EXPECT_EQ(b.c.samples, 600u);
    ASSERT_EQ(c.status, HNAV_OK) << c.message;
    EXPECT_EQ(c.c.force_samples, 100u);
    EXPECT_EQ(c.c.fit, HNAV_MAGNETOMETER_FULL);
    EXPECT_LT(direction_error(r, c), 1 * deg);
}

TEST(MagnetometerCalibration, ARestCountsAsOneSample) {
    const Recording r = record({600, 54 * deg, 0.005, 0.01}, 12);
    Recording rested = r;
    for (int i = 0; i < 3000; ++i) {
        rested.field.push_back(r.field.back());
        rested.force.push_back(r.force.back());
    }
    const Answer a = calibrate(r), b = calibrate(rested);
    ASSERT_EQ(b.status, HNAV_OK) << b.message;
    EXPECT_EQ(b.c.samples, 3600u);
    EXPECT_EQ(b.c.used_samples, a.c.used_samples);
    EXPECT_LT(distance(a.matrix(), b.matrix()), 1e-8);
    EXPECT_LT(distance(a.offset(), b.offset()), 1e-8);
}

TEST(MagnetometerCalibration, AnEllipsoidTwoAndAHalfTimesAsLongAsWideIsStillExact) {
    Recording r = record({}, 7);
    for (std::size_t i = 0; i < r.size(); ++i) r.field[i] = Vector3(0.4, 0.9, 1.0).asDiagonal() * r.truth[i] + r.offset;
    const Answer a = calibrate(r);
    ASSERT_EQ(a.status, HNAV_OK) << a.message;
    EXPECT_NEAR(a.c.axis_ratio, 2.5, 1e-8);
    EXPECT_LT(direction_error(r, a), 1e-8);
}

// ------------------------------------------------------------------------------------------------ noise

TEST(MagnetometerCalibration, FivePercentOfOutliersCostThePlainFitDegreesAndTheRobustOneNothing) {
    std::vector<double> plain, robust;
    for (unsigned seed = 1; seed <= 50; ++seed) {
        const Recording r = record({600, 54 * deg, 0.005, 0.01, 0.05}, seed);
        const Answer a = calibrate(r);
        ASSERT_EQ(a.status, HNAV_OK) << a.message;
        EXPECT_NEAR(a.c.outlier_fraction, 0.05, 0.03);
        robust.push_back(direction_error(r, a) / deg);
        const Answer b = calibrate(r, true, [](hnav_magnetometer_options& o) {
            o.robust = 0;
            o.max_condition = 1e6; // let it answer
            o.max_ambiguity = 1;
            o.max_direction_sigma_rad = 1;
        });
        ASSERT_EQ(b.status, HNAV_OK) << b.message;
        plain.push_back(direction_error(r, b) / deg);
    }
    std::printf("median direction error with 5 %% outliers: plain %.2f deg, robust %.2f deg\n", middle(plain), middle(robust));
    EXPECT_LE(middle(robust), 0.5);
    EXPECT_GE(middle(plain), 3 * middle(robust));
}

// The overflow of a chip, up to a tesla where the field of the Earth is 50 microtesla.
TEST(MagnetometerCalibration, SamplesThatNoFieldExplainsChangeNothing) {
    const Recording clean = record({600, 54 * deg, 0.002, 0.01}, 3);
    const Answer right = calibrate(clean);
    ASSERT_EQ(right.status, HNAV_OK) << right.message;
    for (const double size : {3.0, 10.0, 30.0, 100.0, 1e4, 2e4}) {
        Recording r = clean;
        for (const std::size_t i : {100U, 350U, 351U, 580U}) {
            r.field[i] = size * Vector3(0.6, -0.48, 0.64);
            r.outlier[i] = true;
        }
        const Answer a = calibrate(r);
        ASSERT_EQ(a.status, HNAV_OK) << size << ": " << a.message;
        EXPECT_EQ(a.c.samples, r.size());
        EXPECT_LT(direction_error(r, a), 1.1 * direction_error(r, right)) << size;
    }
}

TEST(MagnetometerCalibration, TheStatedErrorCoversNineOfTenAndIsNotTwiceTheTrueOne) {
    double errors = 0, sigmas = 0;
    int covered = 0;
    for (unsigned seed = 1; seed <= 60; ++seed) {
        const Recording r = record({600, 54 * deg, 0.005, 0.01}, seed);
        const Answer a = calibrate(r);
        ASSERT_EQ(a.status, HNAV_OK) << a.message;
        const Recording clean = clean_of(r);
        errors += std::pow(direction_error(clean, a), 2);
        covered += direction_error(clean, a) <= a.c.direction_sigma_rad;
        sigmas += std::pow(a.c.direction_sigma_rad, 2);
    }
    std::printf("rms direction error %.4f deg, stated %.4f deg, %d of 60 covered\n", std::sqrt(errors / 60) / deg,
                std::sqrt(sigmas / 60) / deg, covered);
    EXPECT_GE(covered, 54);
    EXPECT_LT(std::sqrt(sigmas / errors), 2);
}

TEST(MagnetometerCalibration, AccelerationsOfAThirdOfTheSamplesDoNotMatter) {
    Recording r = record({900, 54 * deg, 0.002, 0.005}, 8);
    Random random(80);
    for (std::size_t i = 0; i < r.size(); i += 3) r.force[i] += random.vector(4);
    const Answer a = calibrate(r);
    ASSERT_EQ(a.status, HNAV_OK) << a.message;
    EXPECT_LT(a.c.force_samples, 750u);
    EXPECT_LT(direction_error(r, a), 0.3 * deg);
    EXPECT_NEAR(a.c.dip_rad, 54 * deg, 0.3 * deg);
}

TEST(MagnetometerCalibration, ARotationThatExplainsNothingIsNotTaken) {
    const Recording r = record({600, 54 * deg, 0.005, 0.01, 0, M_PI, false}, 9);
    const Answer a = calibrate(r);
    ASSERT_EQ(a.status, HNAV_OK) << a.message;
    EXPECT_EQ(a.c.fit, HNAV_MAGNETOMETER_NO_ROTATION);
    EXPECT_LT(direction_error(r, a), 0.5 * deg);
    EXPECT_NE(a.message.find("would explain too little"), std::string::npos) << a.message;
    Recording alone = r; // the ellipsoid's error alone is smaller: the omitted part is in the other
    EXPECT_GT(a.c.direction_sigma_rad, 1.2 * calibrate(alone, false).c.direction_sigma_rad);
}

TEST(MagnetometerCalibration, WhatOfTheSphereHasNoSampleIsSaid) {
    const Answer whole = calibrate(record({600, 54 * deg, 0.002, 0.01}, 20));
    ASSERT_EQ(whole.status, HNAV_OK) << whole.message;
    EXPECT_LT(whole.c.gap_rad, 20 * deg);
    EXPECT_NE(whole.message.find("every direction has a sample"), std::string::npos) << whole.message;
    // The upward angle of the field is limited by dip and tilt.
    const Answer part = calibrate(record({600, 54 * deg, 0.002, 0.01, 0, 45 * deg}, 20));
    ASSERT_EQ(part.status, HNAV_OK) << part.message;
    EXPECT_NEAR(part.c.gap_rad, 80 * deg, 15 * deg);
    EXPECT_LT(angle(Vector3(part.c.gap_direction), {0, 0, -1}), 25 * deg);
    EXPECT_NE(part.message.find("no sample within"), std::string::npos) << part.message;
}

// ------------------------------------------------------------------------------------------------ poor motion

TEST(MagnetometerCalibration, TurningAboutOneAxisOnlyIsRefusedByName) {
    const Answer a = calibrate(record({600, 54 * deg, 0.005, 0.01, 0, 0}, 10));
    EXPECT_EQ(a.status, HNAV_ERROR_ILL_CONDITIONED);
    EXPECT_NE(a.message.find("one axis only"), std::string::npos) << a.message;
}

TEST(MagnetometerCalibration, TurningAboutOneAxisGivesHardIronInThePlaneWhenAskedFor) {
    Recording r = record({600, 54 * deg, 0, 0, 0, 0}, 11);
    for (std::size_t i = 0; i < r.size(); ++i) r.field[i] = r.truth[i] + Vector3(0.3, -0.2, 0.5);
    const Answer a = calibrate(r, true, [](hnav_magnetometer_options& o) { o.allow_hard_iron_only = 1; });
    ASSERT_EQ(a.status, HNAV_OK) << a.message;
    EXPECT_EQ(a.c.fit, HNAV_MAGNETOMETER_HARD_IRON_ONLY);
    EXPECT_EQ(a.c.offset_axes, 2);
    EXPECT_LT(distance(a.offset(), Vector3(0.3, -0.2, 0)), 1e-9); // the sensor turned about its z axis
    EXPECT_LT(distance(a.matrix(), Matrix3::Identity()), 1e-15);
    EXPECT_NE(a.message.find("one axis only"), std::string::npos) << a.message;
}

TEST(MagnetometerCalibration, NoSilentAnswerIsFarOff) {
    // Decreasing tilt: every result that is not refused must be within 3 deg.
    int answered = 0, refused = 0, covered = 0;
    for (const double tilt : {90., 60., 45., 30., 20., 10., 5., 2., 0.})
        for (unsigned seed = 1; seed <= 10; ++seed) {
            const Recording r = record({600, 54 * deg, 0.005, 0.01, 0.02, tilt * deg}, seed);
            const Answer a = calibrate(r);
            if (a.status == HNAV_OK) {
                ++answered;
                covered += direction_error(clean_of(r), a) <= a.c.direction_sigma_rad;
                EXPECT_FALSE(a.message.empty());
                EXPECT_LT(direction_error(r, a), 3 * deg) << "tilt " << tilt << ", seed " << seed;
            } else {
                ++refused;
                EXPECT_EQ(a.status, HNAV_ERROR_ILL_CONDITIONED);
                EXPECT_LT(tilt, 45) << a.message;
            }
        }
    std::printf("%d answered, %d refused\n", answered, refused);
    EXPECT_GE(answered, 30);
    EXPECT_GE(covered, 0.9 * answered);
    EXPECT_GE(refused, 40);
}

// ------------------------------------------------------------------------------------------------ refusals

namespace {

bool out_of_memory = false;

void expect_refusal(const Answer& a, hnav_status status, const char* named) {
    EXPECT_EQ(a.status, status) << a.message;
    EXPECT_NE(a.message.find(named), std::string::npos) << a.message;
    EXPECT_EQ(a.message.find('\n'), std::string::npos);
    EXPECT_EQ(a.c.samples, 0u); // nothing was written
}

} // namespace

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
extern "C" void* __libc_calloc(size_t, size_t);
extern "C" void* calloc(size_t count, size_t size) { return out_of_memory ? nullptr : __libc_calloc(count, size); }

TEST(MagnetometerCalibrationRefuses, WhenThereIsNoMemory) {
    const Recording r = record({}, 1);
    out_of_memory = true;
    const Answer a = calibrate(r);
    out_of_memory = false;
    expect_refusal(a, HNAV_ERROR_OUT_OF_MEMORY, "memory");
}
#endif

TEST(MagnetometerCalibrationRefuses, NullPointers) {
    const Recording r = record({}, 1);
    auto c = hnav_sized<hnav_magnetometer_calibration>();
    char message[80];
    EXPECT_EQ(hnav_calibrate_magnetometer(3, nullptr, nullptr, nullptr, &c, message, sizeof message), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_STREQ(message, "field is null");
    EXPECT_EQ(hnav_calibrate_magnetometer(3, r.field[0].data(), nullptr, nullptr, nullptr, message, sizeof message),
              HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_STREQ(message, "calibration is null");
    EXPECT_EQ(hnav_calibrate_magnetometer(3, r.field[0].data(), nullptr, nullptr, nullptr, nullptr, 0), HNAV_ERROR_NULL_ARGUMENT);
    EXPECT_EQ(hnav_calibrate_magnetometer(r.size(), r.field[0].data(), nullptr, nullptr, &c, nullptr, 0), HNAV_OK);
}

TEST(MagnetometerCalibrationRefuses, OptionsWithoutStampOrOutOfRange) {
    const Recording r = record({}, 1);
    expect_refusal(calibrate(r, true, [](auto& o) { o.stamp = 0; }), HNAV_ERROR_OPTIONS_STAMP, "hnav_magnetometer_defaults");
    const struct {
        const char* name;
        std::function<void(hnav_magnetometer_options&)> change;
    } cases[] = {
        {"outlier_sigma", [](auto& o) { o.outlier_sigma = 0.5; }},
        {"max_condition", [](auto& o) { o.max_condition = not_a_number; }},
        {"max_ambiguity", [](auto& o) { o.max_ambiguity = 0; }},
        {"min_coverage", [](auto& o) { o.min_coverage = 1; }},
        {"max_axis_ratio", [](auto& o) { o.max_axis_ratio = 1; }},
        {"max_direction_sigma_rad", [](auto& o) { o.max_direction_sigma_rad = 0; }},
        {"force_tolerance", [](auto& o) { o.force_tolerance = -1; }},
        {"min_samples", [](auto& o) { o.min_samples = 12; }},
        {"robust", [](auto& o) { o.robust = 2; }},
        {"allow_hard_iron_only", [](auto& o) { o.allow_hard_iron_only = -1; }},
    };
    for (const auto& c : cases) expect_refusal(calibrate(r, true, c.change), HNAV_ERROR_OPTION, c.name);
}

TEST(MagnetometerCalibrationRefuses, NumbersThatAreNone) {
    const Recording good = record({}, 1);
    Recording r = good;
    r.field[7][1] = std::numeric_limits<double>::infinity();
    expect_refusal(calibrate(r), HNAV_ERROR_NON_FINITE, "field row 7");
    r = good;
    r.force[8][2] = not_a_number; // one of three is no missing sample
    expect_refusal(calibrate(r), HNAV_ERROR_NON_FINITE, "force_b_m_s2 row 8");
    r = good;
    r.field[9][0] = 1e200;
    expect_refusal(calibrate(r), HNAV_ERROR_OUT_OF_RANGE, "field row 9");
}

TEST(MagnetometerCalibrationRefuses, DataThatDoNotTell) {
    Scenario few;
    few.samples = 49;
    expect_refusal(calibrate(record(few, 1)), HNAV_ERROR_ILL_CONDITIONED, "too few samples: 49");

    Recording r = record({}, 1);
    for (Vector3& field : r.field) field = Vector3(1, 2, 3);
    expect_refusal(calibrate(r), HNAV_ERROR_ILL_CONDITIONED, "never changes");

    r = record({}, 1);
    for (std::size_t i = 0; i < r.size(); ++i) {
        r.field[i] = r.field[i / 30 * 30];
        r.force[i] = r.force[i / 30 * 30];
    }
    expect_refusal(calibrate(r), HNAV_ERROR_ILL_CONDITIONED, "only 20 of 600 rows saw a new attitude");

    r = record({}, 1);
    for (std::size_t i = 0; i < r.size(); ++i) r.field[i] = Vector3(0.2, 0.9, 1.0).asDiagonal() * r.truth[i];
    expect_refusal(calibrate(r), HNAV_ERROR_ILL_CONDITIONED, "max_axis_ratio");

    expect_refusal(calibrate(record({600, 54 * deg, 0.005, 0.01, 0, 15 * deg}, 1)), HNAV_ERROR_ILL_CONDITIONED,
                   "several ellipsoids");
    expect_refusal(
        calibrate(record({600, 54 * deg, 0.0005, 0.001, 0.02, 12 * deg}, 1), true, [](auto& o) { o.max_condition = 1e6; }),
        HNAV_ERROR_ILL_CONDITIONED, "gravity stayed within");
    expect_refusal(calibrate(record({600, 54 * deg, 0.03, 0.03}, 1), true, [](auto& o) { o.max_direction_sigma_rad = 1e-4; }),
                   HNAV_ERROR_ILL_CONDITIONED, "max_direction_sigma_rad");
    expect_refusal(calibrate(record({600, 54 * deg, 0.005, 0.01, 0, 30 * deg}, 1), true, [](auto& o) { o.min_coverage = 0.9; }),
                   HNAV_ERROR_ILL_CONDITIONED, "cover too little");
}

TEST(MagnetometerCalibrationRefuses, HardIronTooWhereNoCircleFits) {
    // A small cap of a sphere: circles through a filled disc have no meaning.
    const Recording r = record({6000}, 2);
    Random random(3);
    Recording cap;
    for (const Vector3& field : r.truth)
        if (angle(field, {1, 0, 0}) < 12 * deg) cap.field.push_back(field + random.vector(0.005));
    ASSERT_GT(cap.size(), 40u);
    const auto options = [](hnav_magnetometer_options& o) {
        o.min_samples = 13;
        o.allow_hard_iron_only = 1;
    };
    expect_refusal(calibrate(cap, false, options), HNAV_ERROR_ILL_CONDITIONED, "nor is hard iron alone");
}
