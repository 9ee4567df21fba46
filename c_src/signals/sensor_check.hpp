// The health of one sensor from its samples, before a filter uses them.
//
//   outlier    one sample that lies far from the last, far beyond its usual change. A second one beside it is accepted: a
//              real step or shock lasts.
//   saturated  an axis repeats a large value, or reaches the range that was stated.
//   stuck      an axis repeats one value although the body moves.
//
// A repeated value is suspicious only where noise is seen: a simulated sensor without noise repeats what is constant. Noise
// changes its course from sample to sample, a movement or a constant does not; so the share of changes that turn back measures
// them apart.
//
// Almost every sample is well, and this is asked of each: what is rare stands in functions of its own.
#pragma once

#include "base/instant.hpp"
#include "base/rare.hpp"
#include "maths/rotation.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace hnav {

enum class SensorFault : std::uint64_t { none, outlier, stuck, saturated };

template <class R>
struct SensorCheckSettings {
    R outlier = 0;   // no smaller change makes one; 0: none are looked for
    R range = 0;     // where an axis saturates; 0: not stated
    R min_range = 0; // no sensor of the kind saturates below it
};

// Check of a sensor with `count` axes. Part of a filter's state: numbers of eight bytes only.
template <class R, int count = 3>
struct SensorCheck {
    using Vector = Eigen::Matrix<R, count, 1>;
    static constexpr R memory = R(1) / 64;           // weight of a sample in the running means
    static constexpr R outlier_changes = 10;         // an outlier differs by so many usual changes
    static constexpr std::uint64_t max_outliers = 3; // in a row; then they are what the sensor measures
    static constexpr R min_turning_back = R(0.25);   // of a sensor with noise; of white noise 3/4
    static constexpr R min_saturated = 7;            // repeats of a large value
    static constexpr R min_stuck = 20, min_stuck_s = R(0.25), stuck_runs = 20; // samples, time, and usual runs

    R last[count];                   // the newest accepted sample
    R outlier[count];                // the newest that was not
    R change2;                   // running mean of the squared change
    R slope, bend, turning_back; // change of the sum of axes, change of that, and share of its changes of sign
    R limit;                     // where axes saturate, as observed; 0: not known
    R run[count];                    // samples for which an axis repeats its value while the body moves
    R usual_run;                 // length of an insignificant run, in samples
    std::uint64_t outliers_in_row;
    std::uint64_t repeated; // bit i: axis i repeated its value once; quantised noise does that all the time
    std::uint64_t running;  // an axis still repeats its value
    std::uint64_t at_ease;  // no axis needs to be watched from sample to sample
    std::uint64_t axes;    // bit i: axis i is at fault
    SensorFault fault;     // of the newest sample
    std::uint64_t outliers, stuck, saturated, left_out; // samples so far
    double since_s;        // the fault began, or ended
    double outlier_s;      // time of the newest outlier

    bool has_noise() const { return turning_back > min_turning_back; }
    bool is_at_fault(int axis) const { return (axes >> axis) & 1; }

    // Variance of the integral about an axis that went by unmeasured in the sample at t_s, when the quantity may have had the
    // size of `usual`, in one direction for memory_s; 0 for an axis that is well. A fault is found at the end of the samples that
    // show it: they count when it is.
    R lost(int axis, R interval_s, double t_s, R usual, R memory_s) const {
        if (!is_at_fault(axis)) return 0;
        const R before_s = since_s == t_s ? run[axis] * interval_s : 0;
        return usual * usual * (2 * memory_s * interval_s + before_s * before_s);
    }

    // Variance of the rotation that is lost without samples of a gyroscope in a hand.
    R lost_rotation(int axis, R interval_s, double t_s) const {
        constexpr R rate_rad_s = 2, memory_s = R(0.3);
        return lost(axis, interval_s, t_s, rate_rad_s, memory_s);
    }

    // moves: the other sensors measure motion. noisy: noise has been measured, in this sensor or another. True: there is a
    // fault.
    bool examine(const SensorCheckSettings<R>& settings, const Vector& y, R interval_s, double t_s, bool moves, bool noisy) {
        const Vector change = y - Vector(last);
        if (settings.outlier > 0) {
            const R change_squared = change.squaredNorm();
            if (change_squared > settings.outlier * settings.outlier && is_outlier(y, change_squared)) {
                take_outlier(y, t_s);
                return true;
            }
            change2 += memory * (change_squared - change2);
        }
        Eigen::Map<Vector> kept(last);
        kept = y;
        if (at_ease && change.prod() != 0) { // no axis repeats its value
            repeated = 0;
            return false;
        }
        return look_closer(settings, y, change, interval_s, t_s, moves, noisy);
    }

    // For the sensor whose noise is examined. A stuck sensor has none to examine.
    void note_course(const Vector& y) {
        if (running && run[0] >= min_stuck) return;
        const R change = y.sum() - Vector(last).sum(), bends = change - slope;
        if (change == 0) return; // a value that is held until the next one: its steps would look like noise
        turning_back += memory * ((bends * bend < 0 ? R(1) : R(0)) - turning_back);
        slope = change;
        bend = bends;
    }

private:
    HNAV_RARE bool is_outlier(const Vector& y, R change_squared) const {
        if (change_squared <= outlier_changes * outlier_changes * change2) return false;
        if (outliers_in_row == 0) return true;
        // Two samples that agree with each other but not with earlier ones are a step.
        const R apart = (y - Vector(outlier)).squaredNorm();
        return outliers_in_row < max_outliers && apart > R(0.25) * change_squared;
    }

    HNAV_RARE void take_outlier(const Vector& y, double t_s) {
        const SensorFault before = fault;
        Eigen::Map<Vector> kept(outlier);
        kept = y;
        ++outliers_in_row;
        ++outliers;
        outlier_s = t_s;
        fault = SensorFault::outlier;
        at_ease = 0;
        if (before != fault) since_s = t_s;
    }

    // True: something is wrong.
    HNAV_RARE bool look_closer(const SensorCheckSettings<R>& settings, const Vector& y, const Vector& change, R interval_s,
                               double t_s, bool moves, bool noisy) {
        const SensorFault before = fault;
        std::uint64_t repeats = 0;
        for (int i = 0; i < count; ++i) repeats |= std::uint64_t{change[i] == 0} << i;
        const bool again = (repeats & repeated) != 0;
        repeated = repeats;
        if (again || is_watched(settings)) look_at_axes(settings, y, change, interval_s, moves, noisy);
        at_ease = !is_watched(settings);
        if (fault != before) since_s = t_s;
        return fault != SensorFault::none;
    }

    // An axis repeats its value, may be saturated, or is at fault.
    bool is_watched(const SensorCheckSettings<R>& settings) const {
        return running || limit > 0 || settings.range > 0 || fault != SensorFault::none;
    }

    R ceiling(const SensorCheckSettings<R>& settings) const {
        if (settings.range > 0) return settings.range;
        return limit > 0 ? limit : std::numeric_limits<R>::infinity();
    }

    void look_at_axes(const SensorCheckSettings<R>& settings, const Vector& y, const Vector& change, R interval_s, bool moves,
                      bool noisy) {
        fault = SensorFault::none;
        axes = running = outliers_in_row = 0;
        if (limit > 0 && y.cwiseAbs().maxCoeff() > limit) limit = 0; // it was none
        for (int i = 0; i < count; ++i) {
            const R size = std::fabs(y[i]);
            count_run(i, change[i] == 0, moves || size > settings.min_range);
            if (settings.range <= 0 && noisy && run[i] >= min_saturated && size > settings.min_range) limit = size;
            if (size >= ceiling(settings)) mark(i, SensorFault::saturated);
            else if (noisy && is_stuck(i, interval_s)) mark(i, SensorFault::stuck);
        }
        stuck += fault == SensorFault::stuck;
        saturated += fault == SensorFault::saturated;
    }

    // The usual length of a run is learnt from those that were too short to be a fault.
    void count_run(int axis, bool repeats, bool moves) {
        if (repeats) {
            running = 1;
            if (moves) run[axis] += 1;
        } else {
            if (run[axis] > 0) usual_run += R(0.2) * (std::min(run[axis], min_stuck) - usual_run);
            run[axis] = 0;
        }
    }

    bool is_stuck(int axis, R interval_s) const {
        return run[axis] >= std::max(min_stuck, stuck_runs * usual_run) && has_lasted(run[axis] * interval_s, min_stuck_s);
    }

    void mark(int axis, SensorFault what) {
        axes |= std::uint64_t{1} << axis;
        fault = std::max(fault, what);
    }
};

} // namespace hnav
