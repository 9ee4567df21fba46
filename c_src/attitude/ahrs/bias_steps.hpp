// Whether the gyro bias has stepped (estimation/steps.hpp). A small variance holds a bias that has become wrong, and its drift then tilts the
// horizon: after a step of 0.7 deg/s simulated cars and quadrotors would be off by 6 and 4 deg in tilt, ready for a third of the time.
#pragma once

#include "base/instant.hpp"
#include "estimation/steps.hpp"

#include <cmath>

namespace hnav {

// Part of a filter's state: numbers of one kind only. errors: rows of the error state.
template <class R, int errors>
struct BiasSteps {
    R response[3 * errors]; // of the error to unit steps at the begin of the window, column by column
    StepEvidence<3, R> evidence;
    StepEvidence<3, R> hidden; // what may also come from lasting velocities, or from iron around a body that has turned
    R suspected_tilt2,
        suspected_heading2; // rad^2, squares of the angles by a step that is possible, or likely with both; 0: none is
    R since_s, rate_power; // length of the window, s, and the integral of the squared rate over it, rad^2/s
    R attitude[4]; // at the begin of the window
    R turned; // 1: the body has been turned by more than 0.7 rad since
    R unseen_s; // since the last look
    R likely_s; // a step has been likely for so long

    // Begins a window. bias: row of the bias. q: the attitude, 4.
    void begin(int bias, const R* q) {
        *this = {};
        for (int i = 0; i < 4; ++i) attitude[i] = q[i];
        for (int i = 0; i < 3; ++i) response[errors * i + bias + i] = 1;
    }

    // T seconds later, with the integral of the squared rate over them. rotation: row of the tilt. True: a step has been likely for long
    // enough.
    bool look(R T, R power, int rotation) {
        // Chosen: a look factorises two matrices, and one in seven corrections suffices; a swing of fast turns looks like a step for a second
        // or two (CROP trial 07, fast rotation: 1.8 -> 4.6 deg without the wait).
        constexpr R look_s = R(0.25), lasts_s = 3;
        since_s += T;
        rate_power += power;
        unseen_s += T;
        if (is_within(unseen_s, look_s)) return false;
        // Twice the logarithm of the ratio. Errors of the motion are not white, so chance exceeds the limit of white ones. Chosen: with 24 a phone in
        // the pocket of a cyclist and one on a turntable step without a fault (heading of the first up to 32 deg off), with 60 the tilt of ships
        // after a step of 1 deg/s is 8.3 instead of 7.8 deg.
        constexpr R limit = 40;
        const R ratio = twice_log_ratio(evidence);
        likely_s = ratio > limit ? likely_s + unseen_s : 0;
        suspect(ratio, rotation);
        unseen_s = 0;
        return has_lasted(likely_s, lasts_s);
    }

    // q: the present attitude. Iron on a turning body changes the azimuth of the field, which looks like a drift, also while the
    // body turns back. Chosen: with 0.6 rad the tilt of a quadrotor with a step is ready and wrong for 6 % of the time instead of 5.
    void note_attitude(const R* q) {
        constexpr R cosine_of_half = R(0.94);
        R product = 0, before2 = 0, now2 = 0;
        for (int i = 0; i < 4; ++i) {
            product += attitude[i] * q[i];
            before2 += attitude[i] * attitude[i];
            now2 += q[i] * q[i];
        }
        if (product * product < cosine_of_half * cosine_of_half * before2 * now2) turned = 1;
    }
    bool has_turned() const { return turned > 0; }

    // The window ends without a likely or suspected step.
    bool is_over() const {
        return has_lasted(since_s, R(steps_window_s)) && !(likely_s > 0) && !(suspected_tilt2 + suspected_heading2 > 0);
    }

    Steps<3, R> with_step() const { return with_step(evidence); }

private:
    static constexpr R step_rad_s = R(0.01); // sigma of a step, of each axis; chosen: half a degree per second, as a start has it

    // Variance of errors that are proportional to the rate and not modelled: they look like a bias while the body turns fast, (rad/s)^2.
    R unmodelled2() const {
        // Chosen: with a share of 3e-4 the recorded hands of BROAD show steps (1.72 -> 1.75 deg), with 1e-3 the step of a moving arm is found
        // late (MOTION arm, 0.7 deg/s: 1.1 -> 3.5 deg). The least, far below any bias, is there so that no variance is 0 at rest.
        constexpr R share = R(5e-4), least2 = R(1e-10);
        return share * share * rate_power / since_s + least2;
    }

    using Evidence = StepEvidence<3, R>;
    static Steps<3, R> with(const Evidence& of, R variance) {
        const R sigma = std::sqrt(variance), sigmas[] = {sigma, sigma, sigma};
        return {of, sigmas};
    }
    Steps<3, R> with_step(const Evidence& of) const { return with(of, step_rad_s * step_rad_s + unmodelled2()); }

    // Twice the logarithm of the ratio of the likelihoods with and without a step.
    R twice_log_ratio(const Evidence& of) const {
        return with_step(of).twice_log_ratio() - with(of, unmodelled2()).twice_log_ratio();
    }

    // A drift looks like a velocity that lasts, and the noise of the one hides the other; it also looks like iron that turns the azimuth of a
    // body that turns. Nothing here decides between them, but an angle that a step would turn is not ready, and its sigma is larger. The same
    // holds for steps that are possible, but not likely enough to be taken. ratio: of the evidence.
    void suspect(R ratio, int rotation) {
        suspected_tilt2 = suspected_heading2 = 0;
        // Chosen: without it quadrotors after a step of 0.7 deg/s are beyond three sigmas for 9 % of the time instead of 1.5.
        constexpr R possible = 24;
        // Chosen: with 50 a simulated walker without a fault is ready for 97 % of the time instead of 100 %, and after a step of 1 deg/s as often
        // ready and more than 3 deg off, 5 %; without this law 13 %.
        constexpr R limit = 100;
        // One degree: the tilt by a step in the past has been corrected, and the window must end to see the next one (MOTION waist with its word,
        // seed 1: ready and wrong for 87 % of the time without this limit).
        constexpr R least_tilt_rad = R(0.0175);
        // Chosen: between 0.04 and 0.08 the share of ready headings that are wrong after a step in a hand is 0.5 to 0.6 %.
        constexpr R least_heading_rad = R(0.04);
        Evidence both = evidence;
        both.add(hidden);
        const bool hides = hidden.information[0] > 0 && twice_log_ratio(both) > limit;
        if (!hides && !(ratio > possible)) return;
        const Eigen::Map<const Eigen::Matrix<R, errors, 3>> by_step(response);
        const Eigen::Matrix<R, 3, 1> turn = by_step.template middleRows<3>(rotation) * with_step(both).mean();
        const R tilt2 = turn[0] * turn[0] + turn[1] * turn[1], heading2 = turn[2] * turn[2];
        if (tilt2 > least_tilt_rad * least_tilt_rad) suspected_tilt2 = tilt2;
        if (heading2 > least_heading_rad * least_heading_rad) suspected_heading2 = heading2;
    }
};

} // namespace hnav
