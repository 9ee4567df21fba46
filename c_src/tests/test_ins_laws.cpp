// Laws of the navigation filter's parts: the density on the circle, aids one by one, monitors, and the record of corrections.
#include "ins.hpp"
#include "ins/circle.hpp"
#include "ins/smoother/hindsight.hpp"

#include <vector>

namespace hnav {
namespace {

using namespace test;

const earth::Place town{0.8, 0.2, 500};

// ------------------------------------------------------------------------------------------------ the circle

// Density of the heading by its definition, without normalisation.
struct Density {
    double m[2], S[2][2];
    ins::ExternalHeading external;

    double operator()(double alpha) const {
        const double determinant = S[0][0] * S[1][1] - S[0][1] * S[1][0], x = std::cos(alpha) - m[0], y = std::sin(alpha) - m[1];
        const double by_motion = std::exp(-0.5 * (S[1][1] * x * x - 2 * S[0][1] * x * y + S[0][0] * y * y) / determinant);
        constexpr double wrong = 1e-4;
        if (!(external.information > 0)) return by_motion;
        const double off = std::remainder(alpha - external.alpha_rad, 2 * M_PI);
        const double likelihood = std::sqrt(2 * M_PI * external.information) * std::exp(-0.5 * external.information * off * off);
        return by_motion * (wrong + (1 - wrong) * likelihood);
    }
};

TEST(InsCircle, ModesAndMomentsAreThoseOfTheDensity) {
    test::Random random(5);
    for (int k = 0; k < 60; ++k) {
        const Eigen::Matrix2d A = random.covariance<2>(k % 3 ? 0.1 : 0.01);
        Density density{{random.normal(0.7), random.normal(0.7)}, {{A(0, 0), A(0, 1)}, {A(0, 1), A(1, 1)}}, {}};
        if (k % 2) density.external = {random.normal(2), 1 / square(0.1 + std::fabs(random.normal(0.4)))};
        const ins::Circle c = ins::heading_on_circle(density.m, density.S, density.external);
        constexpr int n = 20000;
        double mass = 0, square_off = 0, highest = 0, chord[3] = {};
        for (int i = 0; i < n; ++i) {
            const double alpha = 2 * M_PI * i / n, p = density(alpha), off = std::remainder(alpha - c.mode_rad, 2 * M_PI);
            const double x = std::cos(off) - 1, y = std::sin(off);
            mass += p;
            highest = std::fmax(highest, p);
            square_off += p * off * off;
            chord[0] += p * x * x;
            chord[1] += p * x * y;
            chord[2] += p * y * y;
        }
        EXPECT_GT(density(c.mode_rad), 0.9 * highest) << k;
        EXPECT_NEAR(c.spread_rad, std::sqrt(square_off / mass), 0.01 * c.spread_rad) << k;
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(c.square[i], chord[i] / mass, 0.02 * c.spread_rad * c.spread_rad) << k;
    }
}

// An axis without a sign, and a heading from elsewhere near one of its ends: the density of their product has three modes, two of them
// beside the direction opposite to the external heading.
TEST(InsCircle, TheSecondModeIsTheHigherOneOfThoseThatAreLeft) {
    for (const double external_rad : {-0.15, 0.15}) {
        const Density density{{0, 0}, {{1e3, 0}, {0, 0.05}}, {external_rad, 1}};
        const ins::Circle c = ins::heading_on_circle(density.m, density.S, density.external);
        EXPECT_NEAR(c.mode_rad, 0, 0.1);
        const double other = std::remainder(2 * (external_rad + M_PI) - c.second_rad, 2 * M_PI); // on the other side
        EXPECT_GT(density(c.second_rad), density(other)) << external_rad;
    }
}

TEST(InsCircle, ACertainOneHasNoSpreadAndNoSecondMode) {
    const double m[2] = {0.6, 0.8}, S[2][2] = {};
    const ins::Circle c = ins::heading_on_circle(m, S, {});
    EXPECT_EQ(c.mode_rad, std::atan2(0.8, 0.6));
    for (const double zero : {c.spread_rad, c.second_rad, c.second_share, c.square[0], c.square[1], c.square[2]})
        EXPECT_EQ(zero, 0);
}

// ------------------------------------------------------------------------------------------------ glides

TEST(InsGlide, TheMeanOfEqualVelocitiesIsThatVelocityAndSmallSigmasWeighMore) {
    const double a[2] = {0.3, -0.4}, b[2] = {0.6, -0.8};
    ins::Glide glide;
    glide.begin(0);
    for (int i = 1; i < 9; ++i) {
        glide.note(0.4 * i, a, 0.1 * i);
        EXPECT_NEAR(glide.always.speed_m_s(), 0.5, 1e-12);
        EXPECT_NEAR(glide.recent.speed_m_s(), 0.5, 1e-12);
    }
    glide.begin(0);
    glide.note(1, a, 0.1);
    glide.note(2, b, 0.2);
    EXPECT_NEAR(glide.always.speed_m_s(), (4 * 0.5 + 1 * 1.0) / 5, 1e-12);
}

// ------------------------------------------------------------------------------------------------ starts

ins::Options given(const Truth& truth) {
    ins::Options o = usual();
    o.start = HNAV_INS_START_STATE;
    const earth::Place p = earth::place_of(truth.position_e(0));
    const Matrix3 N = earth::axes_at(p);
    const Vector3 v = N.transpose() * truth.velocity_e(0);
    const Quaternion q = multiply(quaternion_from_matrix(N.transpose()), truth.q_eb(0));
    for (int i = 0; i < 3; ++i) o.start_velocity_n_m_s[i] = v[i];
    for (int i = 0; i < 4; ++i) o.start_q_nb[i] = q[i];
    o.start_sigma_velocity_m_s = 0.1;
    o.start_sigma_tilt_rad = 0.2 * deg;
    o.start_sigma_heading_rad = 0.5 * deg;
    return o;
}

TEST(InsStart, AGivenStateIsTheFirstOne) {
    const Truth truth = winding(town, 1);
    Flight run(given(truth));
    for (int i = 1; i <= 20; ++i) {
        feed(run, truth, i);
        ASSERT_EQ(run.filter.advance(0.01 * i), Outcome::ok);
    }
    const ins::Navigation n = run.shown();
    EXPECT_EQ(run.filter.shown().phase, Phase::navigating);
    EXPECT_LT((n.velocity_e - truth.velocity_e(0.2)).norm(), 4); // that of 0.2 s before, until the next fixes
    EXPECT_NEAR(wrap_angle(roll_pitch_yaw(n.q_nb)[2] - truth.heading(0.2)), 0, 2 * deg);
}

// While no samples came the vehicle went on and turned.
TEST(InsStart, AfterAGapTheGivenStateIsNotTheFirstOneAgain) {
    const Truth truth = winding(town, 1);
    Flight run(given(truth));
    for (int i = 1; i <= 6000; ++i) {
        if (i > 1000 && i < 1500) continue;
        feed(run, truth, i);
        ASSERT_EQ(run.filter.advance(0.01 * i), Outcome::ok);
        if (!run.filter.shown().started()) continue;
        const ins::Navigation n = run.shown();
        const double off = std::fabs(wrap_angle(roll_pitch_yaw(n.q_nb)[2] - truth.heading(0.01 * i)));
        if (n.heading_ready) {
            ASSERT_LT(off, 5 * deg) << i;
        }
        if (i > 1500 && run.filter.shown().phase == Phase::navigating) {
            ASSERT_LT(off, 4 * n.sigma_rotation[2] + 1 * deg) << i;
        }
    }
    EXPECT_EQ(run.filter.newest().times_lost, 1u);
    EXPECT_EQ(run.filter.newest().phase, Phase::navigating);
}

TEST(InsStart, AfterAGapTheGivenPlaceIsNotTheFirstOneAgain) {
    const Truth truth = winding(town, 1);
    ins::Options o = usual();
    give_place(o, town);
    Flight run(o);
    for (int i = 1; i <= 6000; ++i) {
        if (i > 4000 && i < 4350) continue;
        feed(run, truth, i);
        ASSERT_EQ(run.filter.advance(0.01 * i), Outcome::ok);
        if (i < 4350 || !run.filter.shown().started()) continue;
        const ins::Navigation n = run.shown();
        ASSERT_LT((n.position_e - truth.position_e(0.01 * i)).norm(), 4 * n.sigma_position.norm()) << i;
    }
    EXPECT_EQ(run.filter.newest().times_lost, 1u);
    EXPECT_TRUE(run.filter.shown().started());
}

// ------------------------------------------------------------------------------------------------ covariance

// While the heading is unknown the rate of the Earth is linear in u: so is its effect on velocity and attitude.
TEST(InsCovariance, TheTransitionOfAnUnknownHeadingIsTheDerivativeOfTheFlow) {
    const ins::Model model(usual());
    const Truth truth = winding(town, 1, 80);
    const auto flown = [&](int row, double by) {
        ins::State s = started_at(model, truth, 0);
        s.phase = Phase::any_heading;
        s.circle = ins::any;
        s.x[5] = 50;
        s.u[0] = 0.3 + (row == 0 ? by : 0);
        s.u[1] = 0.2 + (row == 1 ? by : 0);
        const double h = earth::rate_rad_s * std::hypot(s.axes[6], s.axes[7]);
        s.earth_rate[0] = h * s.u[0];
        s.earth_rate[1] = -h * s.u[1];
        flow_uncorrected(model, truth, s);
        return s;
    };
    ins::Step step;
    ins::Model recording(usual());
    recording.record_corrections(&step);
    for (int k = 0; k < 2; ++k) {
        constexpr double by = 1e3; // linear
        ins::State moved = flown(k, by), base = flown(k, 0);
        const Vector3 dv = (ins::vec(moved.x + 3) - ins::vec(base.x + 3)) / by;
        const Vector3 turned = rotation_vector(multiply(ins::quat(moved.x + 6), conjugate(ins::quat(base.x + 6)))) / by;
        base.last_correction_s = -1;
        const ins::Event e = truth.at(0.1);
        recording.before_flow(base, e);
        const double T = 0.1, done = base.window.length_s;
        recording.jump(base, e);
        const double longer = T / done;
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(step.transition.M[ins::row_v + i][ins::row_u + k], longer * dv[i], 2e-2 * dv.norm()) << k << i;
            EXPECT_NEAR(step.transition.M[ins::row_phi + i][ins::row_u + k], longer * turned[i], 2e-2 * turned.norm()) << k << i;
        }
    }
}

// White noise of the force: the velocity walks, and the position is the integral of the walk.
TEST(InsCovariance, ForceNoiseSpreadsPositionAndVelocityLikeTheIntegralsOfWhiteNoise) {
    ins::Options o = usual();
    o.accel_noise_m_s_per_sqrt_s = 0.5;
    o.correction_interval_s = 100;
    const ins::Model model(o);
    const Truth truth = winding(town, 1);
    ins::State s = started_at(model, truth, 0);
    for (double& p : s.P) p = 0;
    for (int k = 1; k <= 40; ++k) {
        const ins::Event e = truth.at(0.01 * k);
        model.before_flow(s, e);
        model.flow_exactly(s, 0.01);
        model.jump(s, e);
    }
    const ins::Covariance P = model.covariance_at(s, 0);
    const double T = 0.4, q = 0.25, due[] = {q * T * T * T / 3, q * T * T / 2, q * T};
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(P[i][i], due[0], 1e-2 * due[0]);
        EXPECT_NEAR(P[i][3 + i], due[1], 1e-2 * due[1]);
        EXPECT_NEAR(P[3 + i][3 + i], due[2], 1e-2 * due[2]);
    }
}

// ------------------------------------------------------------------------------------------------ the record of corrections

// A filter with a fix in every 20th event of 0.01 s, and the record of its last correction.
struct Recorded {
    const Truth truth = winding(town, 1);
    ins::Model model{usual()};
    ins::Step step;
    ins::State s;

    Recorded() {
        model.record_corrections(&step);
        s = started_at(model, truth, 0);
        for (int i = 0; i < ins::row_u; ++i) s.P[ins::packed(i, i)] = i < ins::row_phi ? 1 : 1e-4;
    }

    // Event k, from 1 on; the state before its samples.
    ins::State pass(int k) {
        const ins::Event e = truth.at(0.01 * k, k % 20 == 0);
        model.before_flow(s, e);
        model.flow_exactly(s, 0.01);
        const ins::State before = s;
        model.jump(s, e);
        return before;
    }
};

TEST(InsRecord, OfACorrectionIsWhatTheSmootherNeedsToUndoIt) {
    Recorded run;
    const auto& [truth, model, step, s] = run;
    for (int k = 1; k <= 40; ++k) {
        const ins::State before = run.pass(k);
        if (k % 20 != 0) continue;
        // What is recorded lies between the covariance before and that afterwards.
        const ins::Covariance predicted = model.covariance_at(before, 0);
        for (int i = 0; i < 6; ++i) {
            EXPECT_NEAR(step.before[i][i], predicted[i][i], 0.05 * predicted[i][i]) << i;
            EXPECT_GT(step.before[i][i], s.P[ins::packed(i, i)]);
            EXPECT_NEAR(step.change[i], s.x[i] - before.x[i], 1e-9);
        }
    }
}

// An inconsistency shows the predicted errors to be larger than their sigmas: seen from later errors that are as much larger, the
// earlier ones are the same, and their sigmas as much larger.
TEST(InsRecord, AnInconsistencyWidensTheSigmasBeforeItAndNotTheErrors) {
    Recorded run;
    ins::Step& step = run.step;
    const ins::Hindsight filtered{{}, ins::Covariance::of(run.s)};
    for (int k = 1; k <= 20; ++k) run.pass(k);
    test::Random random(4);
    ins::Hindsight after{{}, ins::Covariance::of(run.s)}, plain = filtered;
    for (int i = 0; i < after.P.n; ++i) after.error[i] = random.normal(std::sqrt(after.P[i][i]));
    ASSERT_TRUE(ins::step_back(step, after, &plain));
    for (const int row : std::initializer_list<int>{ins::row_v, ins::row_phi + 1, ins::row_gyro, ins::row_accel + 2}) {
        const double by = 2 + row;
        step.scaled(row, by);
        after.P.scale(row, by);
        after.error[row] *= by;
    }
    ins::Hindsight grown = filtered;
    ASSERT_TRUE(ins::step_back(step, after, &grown));
    for (int i = 0; i < filtered.P.n; ++i) {
        const double sigma = std::sqrt(plain.P[i][i]);
        EXPECT_NEAR(grown.error[i], plain.error[i], 1e-6 * sigma) << i;
        EXPECT_NEAR(std::sqrt(grown.P[i][i]), step.larger[i] * sigma, 1e-6 * sigma) << i;
    }
}

// ------------------------------------------------------------------------------------------------ faulty axes

// The error of a stuck axis is constant: the rotation that it has missed grows with the time, its variance with the square. It is a brisk turn and as
// large as the swing of the body.
TEST(InsFaults, WhatAStuckAxisMissesGrowsWithTheTimeForWhichItIsStuck) {
    ins::Options o = usual();
    o.correction_interval_s = 100;
    const Truth truth = winding(town, 1);
    const ins::Model model(o);
    test::Random random(1);
    ins::State s = started_at(model, truth, 0);
    std::vector<double> lasted_s, variance, unseen2;
    for (int k = 1; k <= 400; ++k) {
        ins::Event e{};
        e.t_s = 0.01 * k;
        ins::Sample sample{e.t_s, imu, {}};
        truth.sample(e.t_s, sample.value);
        for (int i = 0; i < 6; ++i) sample.value[i] += random.normal(1e-3);
        if (k > 100) sample.value[2] = 0.3;
        e.add(sample);
        model.before_flow(s, e);
        model.flow_exactly(s, 0.01);
        model.jump(s, e);
        if (!s.check[checked_gyro].is_at_fault(2)) continue;
        lasted_s.push_back(e.t_s - s.check[checked_gyro].since_s +
                           truth.interval_s); // with the interval of the first equal sample
        variance.push_back(s.window.lost_turn2[2]);
        unseen2.push_back(0.2 * 0.2 + s.rest.rate2 / 3);
    }
    ASSERT_GT(variance.size(), 200u);
    double due = 0;
    for (std::size_t k = 10; k < variance.size(); ++k) due += unseen2[k] * (square(lasted_s[k]) - square(lasted_s[k - 1]));
    EXPECT_GT(unseen2[9], 1.005 * square(0.2));
    EXPECT_NEAR(variance.back() - variance[9], due, 1e-3 * due);
}

// ------------------------------------------------------------------------------------------------ aids

// A drive that gets a sample of one more sensor every `every` samples of the IMU.
void drive_with(Flight& run, const Truth& truth, int from, int to, int every, const std::function<void(double)>& push) {
    for (int i = from + 1; i <= to; ++i) {
        feed(run, truth, i);
        if (i % every == 0) push(0.01 * i);
        ASSERT_EQ(run.filter.advance(0.01 * i), Outcome::ok);
    }
}

ins::Options with_field() {
    ins::Options o = usual();
    o.field_noise = 0.05;
    o.field_colour_s = 10;
    o.field_direction_rad = 0.1;
    o.field_direction_s = 200;
    o.start_sigma_iron = 1;
    return o;
}

// Of the Earth, without iron, with the noise of a sensor.
ins::Sample field_of(const Truth& truth, double t, test::Random& random) {
    const Matrix3 N = earth::axes_at(earth::place_of(truth.position_e(t)));
    const Vector3 body = rotation_matrix(truth.q_eb(t)).transpose() * (N * Vector3(20e-6, 0, 40e-6)) + random.vector(4e-7);
    return {t, ins::field, {body[0], body[1], body[2]}};
}

TEST(InsField, EverySampleAtTheRateOfCorrectionsIsUsedAndASteadyFieldIsNeverRefused) {
    const Truth truth = winding(town, 1);
    test::Random random(2);
    Flight run(with_field());
    drive_with(run, truth, 0, 6000, 10, [&](double t) {
        run.filter.push(field_of(truth, t, random));
        const ins::State& now = run.filter.newest();
        if (now.started() && now.field_unit > 0) {
            EXPECT_GT(now.field_used_s, t - 0.101);
        }
    });
    EXPECT_EQ(run.filter.newest().inflated[ins::field], 0u);
    EXPECT_TRUE(run.shown().heading_ready);
}

TEST(InsField, TheCovarianceOnTheCircleIsSymmetric) {
    const Truth truth = winding(town, 1, 0.2); // too slow for the satellites to find a heading
    test::Random random(2);
    Flight run(with_field());
    drive_with(run, truth, 0, 1000, 10, [&](double t) { run.filter.push(field_of(truth, t, random)); });
    ins::State now = run.filter.newest();
    ASSERT_EQ(now.phase, Phase::any_heading);
    ins::vec(now.x + 3) = Vector3(0.2, 0.1, 1);
    const ins::Covariance P = run.filter.model().covariance_at(now, 0);
    ASSERT_EQ(P.n, ins::errors);
    double largest = 0;
    for (int i = 0; i < P.n; ++i)
        for (int j = 0; j < i; ++j) {
            const double scale = std::sqrt(P[i][i] * P[j][j]);
            EXPECT_NEAR(P[i][j], P[j][i], 1e-9 * scale) << i << " " << j;
            if (i == ins::row_direction && scale > 0) largest = std::fmax(largest, std::fabs(P[i][j]) / scale);
        }
    EXPECT_GT(largest, 1e-3); // the direction of the field is correlated with others
}

// Headings within heading_colour_s have the same error.
TEST(InsHeading, ManyReadingsOfOneCompassWeighNoMoreThanOne) {
    const Vector3 p = earth::position_of(town);
    const Quaternion q = quaternion_from_matrix(earth::axes_at(town));
    const Truth rest{[=](double) { return p; }, [=](double) { return q; }};
    double sigma[2] = {};
    for (const bool many : {false, true}) {
        ins::Options o = given(rest);
        o.heading_colour_s = 1000;
        o.start_sigma_heading_rad = 20 * deg;
        o.rest_rate_rad_s = 0;
        Flight run(o);
        drive_with(run, rest, 0, 1000, many ? 10 : 1000, [&](double t) { run.filter.push({t, ins::heading, {0.02, 10 * deg}}); });
        sigma[many] = run.shown().sigma_rotation[2];
    }
    EXPECT_GT(sigma[1], 0.8 * sigma[0]);
    EXPECT_LT(sigma[0], 0.6 * 20 * deg);
}

TEST(InsPressure, ThatOfTheHeightChangesNothingAndItsVarianceIsThatOfTheSigma) {
    const Truth truth = winding(town, 1);
    const auto pressure_at = [](double height_m) {
        double low = 1e4, high = 1.1e5;
        for (int i = 0; i < 60; ++i) (earth::pressure_height_m(0.5 * (low + high)) > height_m ? low : high) = 0.5 * (low + high);
        return low;
    };
    double variance[2] = {};
    for (const int k : {0, 1}) {
        Flight run(usual());
        const double sigma_pa = 10 + 10 * k;
        drive_with(run, truth, 0, 4000, 20, [&](double t) {
            const double height = earth::place_of(truth.position_e(t)).height_m;
            run.filter.push({t, ins::pressure, {pressure_at(height), sigma_pa}});
        });
        const ins::State& now = run.filter.newest();
        EXPECT_LT(std::fabs(now.offset), 5);
        EXPECT_LT(std::fabs(now.innovation[ins::pressure].value[0]), 1);
        EXPECT_EQ(now.inflated[ins::pressure], 0u);
        variance[k] = now.innovation[ins::pressure].variance[0];
    }
    const double metres =
        0.5 * (earth::pressure_height_m(pressure_at(500) - 10) - earth::pressure_height_m(pressure_at(500) + 10));
    EXPECT_GT(variance[0], metres * metres);
    EXPECT_NEAR(variance[1] - variance[0], 3 * metres * metres, 0.3 * metres * metres);
}

TEST(InsHeading, OneThatContradictsMotionIsWeighedDown) {
    const Truth truth = winding(town, 1);
    double off[2] = {};
    for (const double wrong_rad : {0.02, 1.5}) {
        Flight run(given(truth));
        drive_with(run, truth, 0, 1500, 10,
                   [&](double t) { run.filter.push({t, ins::heading, {wrap_angle(truth.heading(t) + wrong_rad), 1 * deg}}); });
        const ins::State& now = run.filter.newest();
        if (wrong_rad > 1) {
            EXPECT_NEAR(now.innovation[ins::heading].value[0], wrong_rad, 0.02);
        }
        EXPECT_EQ(now.inflated[ins::heading] > 100, wrong_rad > 1);
        off[wrong_rad > 1] = std::fabs(wrap_angle(roll_pitch_yaw(run.shown().q_nb)[2] - truth.heading(15)));
    }
    EXPECT_LT(off[1], 1 * deg);
}

// Along a straight way, where the pitch changes and nothing observes the roll.
Truth straight() {
    const Vector3 p = earth::position_of(town);
    const Matrix3 N = earth::axes_at(town);
    return {[=](double t) { return Vector3(p + N * Vector3(10 * t, 0, 0)); },
            [=](double t) {
                return multiply(quaternion_from_matrix(N), rotation_quaternion(Vector3(0, 0.2 * std::sin(0.7 * t), 0)));
            }};
}

// What the pitch is known to within, a heading corrected by 17 deg must not give to the roll: its sigma would be halved.
TEST(InsHeading, ACorrectedOneMakesNoRollKnown) {
    const Truth truth = straight();
    double roll[2] = {}, pitch[2] = {};
    for (const bool off : {false, true}) {
        ins::Options o = given(truth);
        const Quaternion wrong = rotation_quaternion(Vector3(0, 0, off ? 0.3 : 0));
        ins::quat(o.start_q_nb) = multiply(wrong, ins::quat(o.start_q_nb));
        o.start_sigma_heading_rad = 0.3;
        o.start_sigma_tilt_rad = 0.03;
        o.start_sigma_accel_bias_m_s2 = 0.3;
        Flight run(o);
        drive_with(run, truth, 0, 3000, 20, [](double) {});
        drive_with(run, truth, 3000, 3500, 20, [&](double t) { run.filter.push({t, ins::heading, {0, 1 * deg}}); });
        const ins::State& now = run.filter.newest();
        EXPECT_LT(std::fabs(wrap_angle(roll_pitch_yaw(run.shown().q_nb)[2])), 1 * deg) << off;
        roll[off] = std::sqrt(now.P[ins::packed(ins::row_phi, ins::row_phi)]);
        pitch[off] = std::sqrt(now.P[ins::packed(ins::row_phi + 1, ins::row_phi + 1)]);
    }
    EXPECT_GT(roll[0], 3 * pitch[0]);
    EXPECT_NEAR(roll[1], roll[0], 0.002 * roll[0]);
    EXPECT_NEAR(pitch[1], pitch[0], 0.002 * pitch[0]);
}

// On a turntable.
Truth standing(double turn_rad_s = 0) {
    const Vector3 p = earth::position_of(town);
    const Quaternion q = quaternion_from_matrix(earth::axes_at(town));
    return {[=](double) { return p; }, [=](double t) { return multiply(q, rotation_quaternion(Vector3(0, 0, turn_rad_s * t))); }};
}

// The mean of white noise over the time is what is left; noise_rad_per_sqrt_s of the gyroscopes and of the base.
TEST(InsRest, ABiasIsKnownNoBetterThanTheNoiseOfItsMean) {
    const Truth truth = standing();
    ins::Options o = given(truth);
    o.start_sigma_heading_rad = 0.1 * deg;
    Flight run(o);
    drive_with(run, truth, 0, 3000, 3000, [](double) {});
    const double noise2 = square(o.gyro_noise_rad_per_sqrt_s) + square(o.rest_rate_noise_rad_per_sqrt_s);
    EXPECT_TRUE(run.filter.model().at_rest(run.filter.newest(), 30));
    for (int i = 0; i < 3; ++i) {
        const int row = ins::row_gyro + i;
        EXPECT_GT(run.filter.newest().P[ins::packed(row, row)], 0.5 * square(o.gyro_noise_rad_per_sqrt_s) / 30);
    }
    EXPECT_GT(run.filter.newest().P[ins::packed(ins::row_gyro + 2, ins::row_gyro + 2)], 0.5 * noise2 / 30);
}

TEST(InsRest, ASteadyTurnThatNoBiasCanBeIsATurn) {
    const Truth truth = standing(20 * deg);
    ins::Options o = usual();
    o.start_sigma_gyro_bias_rad_s = 0.5 * deg;
    Flight run(o);
    drive(run, truth, 60, [](ins::Sample&) {});
    EXPECT_LT(ins::vec(run.filter.newest().gyro_bias).norm(), 0.5 * deg);
}

// Receivers repeat positions when they have no fix. At rest they are equal because nothing moves.
TEST(InsFaults, EqualPositionsAreUsedAtRestAndRejectedInMotion) {
    for (const bool moves : {false, true}) {
        const Truth truth = moves ? winding(town, 1) : standing();
        Flight run(given(truth));
        std::uint64_t used = 0;
        ins::Sample frozen{};
        for (int i = 1; i <= 3000; ++i) {
            const double t = 0.01 * i;
            run.push_imu(truth, t);
            if (i % 20 == 0) {
                if (t < 20) frozen = truth.position_fix(t);
                frozen.t_s = t;
                run.filter.push(truth.velocity_fix(t));
                run.filter.push(frozen);
            }
            ASSERT_EQ(run.filter.advance(t), Outcome::ok);
            if (i == 2000) used = run.filter.newest().used[position];
        }
        EXPECT_EQ(run.filter.newest().used[position] - used, moves ? 0u : 50u);
    }
}

// A body that stands, without rest being looked for, and with gyroscopes whose bias turns its heading: the search restarts.
TEST(InsRest, AHeadingThatTheGyroscopesHaveLostIsSearchedAgainFromAWidePosition) {
    const Truth truth = standing();
    ins::Options o = usual();
    o.rest_rate_rad_s = 0;
    o.start_sigma_gyro_bias_rad_s = 0.02;
    Flight run(o);
    drive_with(run, truth, 0, 6000, 6000, [](double) {});
    const ins::State& now = run.filter.newest();
    EXPECT_GE(now.times_lost, 1u);
    EXPECT_LE(now.times_lost, 3u);
    EXPECT_EQ(now.phase, Phase::any_heading);
    EXPECT_LT((run.shown().position_e - truth.position_e(60)).norm(), 3);
}

// A body that rests at its given place and has no satellites aligns itself again.
TEST(InsStart, AfterAGapWithoutAnyFixTheGivenPlaceIsUncertain) {
    const Truth truth = standing();
    ins::Options o = usual();
    give_place(o, earth::place_of(truth.position_e(0)));
    Flight run(o);
    for (int i = 1; i <= 4000; ++i) {
        if (i > 2000 && i < 2300) continue;
        run.push_imu(truth, 0.01 * i);
        ASSERT_EQ(run.filter.advance(0.01 * i), Outcome::ok);
        if (i == 2000) {
            EXPECT_TRUE(run.shown().position_ready);
        }
    }
    EXPECT_EQ(run.filter.newest().times_lost, 1u);
    EXPECT_TRUE(run.filter.shown().started());
    EXPECT_FALSE(run.shown().position_ready);
    EXPECT_GT(run.shown().sigma_position[0], 0.9 * o.start_sigma_position_m);
}

// ------------------------------------------------------------------------------------------------ monitors

// Velocities in other axes, in another unit, or of a receiver that is not connected; latitude and longitude exchanged.
TEST(InsReadiness, AidsThatContradictEachOtherAreNotReady) {
    const Truth truth = winding(town, 1);
    const std::function<void(ins::Sample&, ins::Sample&)> wrong[] = {
        [](ins::Sample&, ins::Sample& v) { std::swap(v.value[0], v.value[1]); },
        [](ins::Sample&, ins::Sample& v) {
            for (int i = 0; i < 3; ++i) v.value[i] *= 3.6;
        },
        [](ins::Sample&, ins::Sample& v) {
            for (int i = 0; i < 3; ++i) v.value[i] = 0;
        },
        [](ins::Sample& p, ins::Sample&) { std::swap(p.value[0], p.value[1]); },
        [](ins::Sample&, ins::Sample&) {},
    };
    for (const auto& change : wrong) {
        const bool right = &change == std::end(wrong) - 1;
        Flight run(usual());
        int ready = 0, shown = 0;
        for (int i = 1; i <= 6000; ++i) {
            run.push_imu(truth, 0.01 * i);
            if (i % 20 == 0) {
                ins::Sample p = truth.position_fix(0.01 * i), v = truth.velocity_fix(0.01 * i);
                change(p, v);
                ASSERT_EQ(run.filter.push(p), Outcome::ok);
                ASSERT_EQ(run.filter.push(v), Outcome::ok);
            }
            ASSERT_EQ(run.filter.advance(0.01 * i), Outcome::ok);
            if (i % 10) continue;
            const ins::Navigation n = run.shown();
            ++shown;
            ready += n.velocity_ready;
        }
        if (right) EXPECT_GT(ready, 0.8 * shown);
        else EXPECT_LT(ready, 0.15 * shown) << &change - wrong; // exchanged axes agree while the heading is near 45 deg
    }
}

// A single wrong fix, and a receiver that moves its positions once, are no contradiction of the velocities for longer than a window.
TEST(InsReadiness, AfterAJumpOfThePositionsTheAidsAgreeAgain) {
    const Truth truth = winding(town, 1);
    for (const double lasts_s : {0.2, 1000.0}) {
        ins::AidAgreement aids;
        aids.begin();
        int contradicts = 0;
        for (int k = 0; k < 300; ++k) {
            const double t = 0.2 * k;
            const ins::Sample v = truth.velocity_fix(t);
            Vector3 at = truth.position_e(t);
            const Matrix3 axes = earth::axes_at(earth::place_of(at));
            if (t > 20 && t < 20.01 + lasts_s) at += axes.col(0) * 300;
            aids.note_velocity(v.value, t);
            aids.note_position(at, axes, 1, t);
            contradicts += t > 6 && !aids.holds(t);
        }
        EXPECT_LE(contradicts, lasts_s < 1 ? 0 : 40);
        EXPECT_TRUE(aids.holds(60));
    }
}

TEST(InsReadiness, AHeadingIsReadyAfterItsSigmaWasBelowTheLimitForTheHoldTime) {
    const Truth truth = winding(town, 1);
    ins::Options o = usual();
    Flight run(o);
    double below_since_s = 1e9;
    bool was_ready = false;
    for (int i = 1; i <= 4000; ++i) {
        feed(run, truth, i);
        ASSERT_EQ(run.filter.advance(0.01 * i), Outcome::ok);
        if (!run.filter.shown().started()) continue;
        const ins::Navigation n = run.shown();
        const ins::State& now = run.filter.shown();
        if (now.phase == Phase::any_heading && now.circle.spread_rad < 0.3) {
            EXPECT_LT(n.sigma_rotation[2], 2 * now.circle.spread_rad);
        }
        EXPECT_EQ(now.drifted, 0); // the positions are exact
        if (!(n.sigma_rotation[2] < o.ready_heading_rad)) below_since_s = 1e9;
        else if (below_since_s > 1e8) below_since_s = 0.01 * i;
        if (n.heading_ready) {
            ASSERT_GT(0.01 * i - below_since_s, o.ready_hold_s - 0.35) << i;
        }
        was_ready = was_ready || n.heading_ready;
    }
    EXPECT_TRUE(was_ready);
}

// Velocities that contradict both force and positions are wrong, and not the state.
TEST(InsMonitors, VelocitiesThatPositionsContradictMakeNoStateInconsistent) {
    const Truth truth = winding(town, 1);
    Flight run(usual());
    drive(run, truth, 60, [](ins::Sample& sample) {
        if (sample.channel == velocity && sample.t_s > 40) sample.value[0] += 20;
    });
    const ins::State& now = run.filter.newest();
    EXPECT_TRUE(std::isinf(now.inconsistent_s)) << now.inconsistent_s;
    EXPECT_EQ(now.times_lost, 0u);
    EXPECT_LT((run.shown().position_e - truth.position_e(60)).norm(), 2);
}

// Innovations with a mean widen all states that could explain them, those of small variance too.
TEST(InsMonitors, AStateThatIsWrongIsWidenedUntilItFits) {
    const Truth truth = winding(town, 1);
    Flight run(usual());
    double before[2] = {}, largest[2] = {};
    for (int i = 1; i <= 5000; ++i) {
        const double t = 0.01 * i;
        ins::Sample turn{t, imu, {}};
        truth.sample(t, turn.value);
        if (t > 40) turn.value[3] += 2;
        run.filter.push(turn);
        if (i % 20 == 0) {
            run.filter.push(truth.velocity_fix(t));
            run.filter.push(truth.position_fix(t));
        }
        ASSERT_EQ(run.filter.advance(t), Outcome::ok);
        const ins::State& now = run.filter.newest();
        for (const int k : {0, 1}) {
            const int row = k ? ins::row_gyro : ins::row_phi;
            const double variance = now.P[ins::packed(row, row)];
            if (t < 40) before[k] = variance;
            else largest[k] = std::fmax(largest[k], variance);
        }
    }
    EXPECT_GT(run.filter.newest().inconsistent_s, 40);
    for (const int k : {0, 1}) EXPECT_GT(largest[k], 4 * before[k]) << k;
}

} // namespace
} // namespace hnav
