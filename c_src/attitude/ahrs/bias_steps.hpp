// Whether the gyro bias has stepped (estimation/steps.hpp). A small variance holds a bias that has become wrong, and its drift then tilts the
// horizon: after a step of 0.7 deg/s simulated cars and quadrotors would be off by 6 and 4 deg in tilt, ready for a third of the time.
#pragma once

#include "base/instant.hpp"
#include "estimation/steps.hpp"

#include <algorithm>
#include <cmath>

namespace hnav {

// Iron on a body that turns moves the azimuth of the field, which looks like a drift of the heading. So the evidence is of steps and of iron:
// what iron explains shows no step. A step that has turned the horizon or the heading by far makes true fields look false; fields that the gates
// reject count as evidence as soon as a step explains them better than chance does.
//
// Part of a filter's state: numbers of one kind only. Errors that respond: the horizontal velocity, and `rows` others, the rotation first.
template <class R, int rows>
struct BiasSteps {
    static constexpr int parts = 6; // steps of the bias, 3, rad/s; iron in body axes, 3, in units of the field's strength
    using Evidence = StepEvidence<parts, R>;

    // Of the error, column by column: to unit steps at the begin of the window, and to unit iron since the start of the attitude.
    R response[parts * rows], velocity_response[parts * 2];
    Evidence evidence;
    Evidence rejected; // of fields that the gates reject
    Evidence hidden; // what may also come from lasting velocities
    R suspected_tilt2,
        suspected_heading2; // rad^2, squares of the angles by a step that is possible, or likely with both; 0: none is
    R since_s, rate_power; // length of the window, s, and the integral of the squared rate over it, rad^2/s
    R unseen_s; // since the last look
    R likely_s; // a step has been likely for so long
    R iron_sigma; // of each axis: the option residual_iron

    // Begins a window. bias: its row in the response.
    void begin(int bias, R sigma_of_iron) {
        BiasSteps begun{};
        begun.iron_sigma = sigma_of_iron;
        std::copy(response + 3 * rows, response + parts * rows, begun.response + 3 * rows);
        std::copy(velocity_response + 3 * 2, velocity_response + parts * 2, begun.velocity_response + 3 * 2);
        for (int i = 0; i < 3; ++i) begun.response[rows * i + bias + i] = 1;
        *this = begun;
    }
    // At a start of the attitude.
    void forget_iron() {
        std::fill(response + 3 * rows, response + parts * rows, R(0));
        std::fill(velocity_response + 3 * 2, velocity_response + parts * 2, R(0));
    }

    // A field that is rejected. nis: of its innovation.
    void reject(const Eigen::Matrix<R, 3, parts>& stepped, const Eigen::Matrix<R, 3, parts>& weighted,
                const Eigen::Matrix<R, 3, 1>& innovation, R nis) {
        // NIS of an outlier, so what a step may leave unexplained. Chosen, of simulations: without rejected fields the tilt of an excavator after a
        // step of 1 deg/s is 6.6 instead of 1.8 deg; with 0.3 a skier without a step has 2.5 instead of 1.9 deg.
        constexpr R outlier_nis = R(0.1);
        rejected.add(stepped, weighted, innovation);
        rejected.excess += nis - outlier_nis;
    }

    // T seconds later, with the integral of the squared rate over them. True: a step has been likely for long enough.
    bool look(R T, R power) {
        // Chosen: a look factorises a few matrices, and one in seven corrections suffices; a swing of fast turns looks like a step for a second
        // or two (CROP trial 07, fast rotation: 1.8 -> 4.6 deg without the wait).
        constexpr R look_s = R(0.25), lasts_s = 3;
        since_s += T;
        rate_power += power;
        unseen_s += T;
        if (is_within(unseen_s, look_s)) return false;
        admit_rejected();
        // Twice the logarithm of the ratio. Errors of the motion are not white, so chance exceeds the limit of white ones. Chosen: with 24 a phone in
        // the pocket of a cyclist and one on a turntable step without a fault (heading of the first up to 32 deg off), with 60 the tilt of ships
        // after a step of 1 deg/s is 8.3 instead of 7.8 deg.
        constexpr R limit = 40;
        const R ratio = twice_log_ratio(evidence);
        likely_s = ratio > limit ? likely_s + unseen_s : 0;
        suspect(ratio);
        unseen_s = 0;
        return has_lasted(likely_s, lasts_s);
    }

    // The window ends without a likely or suspected step.
    bool is_over() const {
        return has_lasted(since_s, R(steps_window_s)) && !(likely_s > 0) && !(suspected_tilt2 + suspected_heading2 > 0);
    }

    Steps<parts, R> with_step() const { return with_step(evidence); }

    // Variance of the heading, rad^2: iron is a consider state (Schmidt), it corrects nothing.
    R heading_variance_by_iron() const {
        R sum = 0;
        for (int j = 3; j < parts; ++j) sum += response[rows * j + 2] * response[rows * j + 2];
        return iron_sigma * iron_sigma * sum;
    }

private:
    static constexpr R step_rad_s = R(0.01); // sigma of a step, of each axis; chosen: half a degree per second, as a start has it

    // Variance of errors that are proportional to the rate and not modelled: they look like a bias while the body turns fast, (rad/s)^2.
    R unmodelled2() const {
        // Chosen: with a share of 3e-4 the recorded hands of BROAD show steps (1.72 -> 1.75 deg), with 1e-3 the step of a moving arm is found
        // late (MOTION arm, 0.7 deg/s: 1.1 -> 3.5 deg). The least, far below any bias, is there so that no variance is 0 at rest.
        constexpr R share = R(5e-4), least2 = R(1e-10);
        return share * share * rate_power / since_s + least2;
    }

    // variance: of a step, (rad/s)^2.
    Steps<parts, R> with(const Evidence& of, R variance) const {
        const R step = std::sqrt(variance), sigmas[] = {step, step, step, iron_sigma, iron_sigma, iron_sigma};
        return {of, sigmas};
    }
    Steps<parts, R> with_step(const Evidence& of) const { return with(of, step_rad_s * step_rad_s + unmodelled2()); }

    // Twice the logarithm of the ratio of the likelihoods with and without a step.
    R twice_log_ratio(const Evidence& of) const {
        return with_step(of).twice_log_ratio() - with(of, unmodelled2()).twice_log_ratio();
    }

    void admit_rejected() {
        if (!(rejected.information[0] > 0)) return;
        Evidence all = evidence;
        all.add(rejected);
        if (!(with_step(all).twice_log_ratio() > with_step(evidence).twice_log_ratio())) return;
        evidence = all;
        rejected = {};
    }

    // A drift looks like a velocity that lasts, and the noise of the one hides the other. Nothing here decides between them, but an angle that a step would turn is not ready, and its sigma is larger. The same
    // holds for steps that are possible, but not likely enough to be taken. ratio: of the evidence.
    void suspect(R ratio) {
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
        const Eigen::Map<const Eigen::Matrix<R, rows, 3>> by_step(response);
        const Eigen::Matrix<R, 3, 1> turn = by_step.template topRows<3>() * with_step(both).mean().template head<3>();
        const R tilt2 = turn[0] * turn[0] + turn[1] * turn[1], heading2 = turn[2] * turn[2];
        if (tilt2 > least_tilt_rad * least_tilt_rad) suspected_tilt2 = tilt2;
        if (heading2 > least_heading_rad * least_heading_rad) suspected_heading2 = heading2;
    }
};

} // namespace hnav
