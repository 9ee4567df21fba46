// What of the measured force is motion: the rest is vibration, noise, and gravity along a tilt that is wrong.
#include "ins/model.hpp"

#include "maths/square.hpp"

namespace hnav::ins {
namespace {

// Chosen: what may be left of vibration in the mean force, and its longest averaging time; memory of mean squares.
constexpr double small_m_s2 = 0.1, longest_s = 1, memory_s = 10;

// Variance of vibration and noise of a force sample and axis, at the low frequencies that an estimate integrates.
double force_noise2(const State& s) { return s.slow_noise.at_most(s.held.vibration_force2, SlowNoise::force); }

// Averaging time that reduces vibration to small_m_s2.
double mean_force_over_s(const State& s) {
    return std::fmin(longest_s, force_noise2(s) * s.usual_interval_s / (2 * small_m_s2 * small_m_s2));
}

// Its power spectral density, of both horizontal axes together.
double noise2_s(const State& s) { return 2 * force_noise2(s) * s.usual_interval_s; }

// The part of a mean square along the horizontal that is motion.
double moved2_of(const State& s, double mean2, double noise2) { return std::fmax(0, mean2 - s.false_force2 - noise2); }

} // namespace

// The part of the force in t, averaged over over_s, that turns attitude errors into velocity errors.
Vector3 moving_force(const State& s, const Vector3& raw, double over_s) {
    const double density2 = noise2_s(s);
    if (!(density2 > 0)) return raw;
    const double by_noise2 = density2 / (2 * mean_force_over_s(s) + s.usual_interval_s);
    const double moved2 = moved2_of(s, s.mean_force2, by_noise2);
    Vector3 steady = vec(s.in_t.mean_force);
    if (s.mean_force2 > 0) steady.head<2>() *= moved2 / s.mean_force2;
    return steady + moved2 / (moved2 + density2 / over_s) * (raw - steady);
}

// Variance of the horizontal force that errors of tilt and accelerometer bias put into t. Those of a body that stands cancel each other: with the
// tilt alone, consumer boats at a mooring find headings with a z2 of 3.2 instead of .8. body_to_t: rotation matrix.
double false_force2(const State& s, const Matrix3& body_to_t) {
    const auto P = [&](int i, int j) { return s.P[i < j ? packed(i, j) : packed(j, i)]; };
    const double g = vec(s.gravity).norm();
    double sum = g * g * (P(row_phi, row_phi) + P(row_phi + 1, row_phi + 1));
    for (int j = 0; j < 3; ++j) {
        sum += 2 * g * (body_to_t(0, j) * P(row_phi + 1, row_accel + j) - body_to_t(1, j) * P(row_phi, row_accel + j));
        for (int k = 0; k < 3; ++k)
            sum += body_to_t.col(j).head<2>().dot(body_to_t.col(k).head<2>()) * P(row_accel + j, row_accel + k);
    }
    return sum;
}

// Vibration of an accelerometer is force that causes no motion, and so is gravity along a tilt that is wrong. Used as force in the transition,
// they would make the heading look observable although it is not: of consumer quadrotors that hover first, headings have a z2 of 4.8 without the
// share of the errors, 1.0 with it.
void note_mean_force(State& s, const Vector3& force, double interval_s) {
    const double T = interval_s;
    if (std::isnan(s.in_t.mean_force[0])) vec(s.in_t.mean_force) = force;
    vec(s.in_t.mean_force) += T / (mean_force_over_s(s) + T) * (force - vec(s.in_t.mean_force));
    s.mean_force2 += T / (memory_s + T) * (vec(s.in_t.mean_force).head<2>().squaredNorm() - s.mean_force2);
    s.false_force2 += T / (memory_s + T) * (s.window.false_force2 - s.false_force2);
}

// A stuck or saturated axis measures no force, so it cannot make an attitude error observable in the velocity; nor does an axis that repeats a large
// value, before it is found to be saturated.
Vector3 shown_force(const State& s) {
    const SensorCheck<double>& check = s.check[checked_accel];
    Vector3 force = specific_force(s);
    for (int i = 0; i < 3; ++i)
        if (check.is_at_fault(i) || (check.run[i] > 0 && std::fabs(check.last[i]) > least_accel_range_m_s2)) force[i] = 0;
    return force;
}

namespace {

// Least averaging time of the acceleration that a late velocity misses; it leaves a tenth of a vibration of 17 Hz. The last sample alone made the
// latency look observed: that of a simulated motorcycle was .05 s at a sigma of .03, true .3, its tilt ready and wrong for 5 % of the time.
constexpr double shortest_age_s = 0.1;

double age_s(const State& s) { return std::fmax(shortest_age_s, 0.5 * s.latency); }

} // namespace

void note_acceleration(State& s, const Vector3& acceleration, double interval_s) {
    const double T = interval_s;
    vec(s.in_t.recent_acceleration) += T / (age_s(s) + T) * (acceleration - vec(s.in_t.recent_acceleration));
    s.recent2 += T / (memory_s + T) * (vec(s.in_t.recent_acceleration).head<2>().squaredNorm() - s.recent2);
}

// The mean of the recent acceleration contains noise, which the velocity has integrated as well. Taken for motion, it looks like a latency of twice
// the averaging time: that of consumer quadrotors was .1 to .2 s too large at a sigma of .02. Given the mean, motion and noise are its shares by
// their variances (regression dilution, Fuller 1987, 1.1). Corrections have taken back part of what was integrated.
Missed missed_of(const State& s, double taken_back_per_s) {
    const double density2 = noise2_s(s), noise2 = density2 / (2 * age_s(s)), moved2 = moved2_of(s, s.recent2, noise2);
    const double all2 = moved2 + s.false_force2 + noise2;
    const Vector3 recent = vec(s.in_t.recent_acceleration);
    if (!(all2 > 0)) return {recent, Vector3::Zero()};
    return {moved2 / all2 * recent, density2 / all2 / (1 + age_s(s) * taken_back_per_s) * recent};
}

} // namespace hnav::ins
