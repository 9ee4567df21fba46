// What the samples of one sensor tell about its health, before a filter believes them.
//
//   outlier    one sample that lies far from the last, far beyond its usual change. A second one beside it is believed: a
//              real step or shock lasts.
//   saturated  an axis repeats the largest value that was ever seen, or reaches the range that was stated.
//   stuck      an axis repeats one value although the body moves.
//
// A repeated value is suspicious only where noise is seen: a simulated sensor without noise repeats what is constant. Noise
// changes its course from sample to sample, a movement or a constant does not; so the share of changes that turn back tells
// them apart.
#pragma once

#include "maths/rotation.hpp"

#include <algorithm>
#include <cstdint>

namespace hnav {

enum class SensorFault : std::uint64_t { none, outlier, stuck, saturated };

template <class R>
struct SensorCheckSettings {
    R outlier = 0;   // no smaller change makes one; 0: none are looked for
    R range = 0;     // where an axis saturates; 0: not stated
    R min_range = 0; // no sensor of the kind saturates below it
};

// Part of a filter's state: numbers of eight bytes only.
template <class R>
struct SensorCheck {
    static constexpr R change_memory = R(1) / 64; // weight of a sample in the running means
    static constexpr R outlier_changes = 10;      // an outlier is so many usual changes away
    static constexpr std::uint64_t min_known = 8; // samples before there is a usual change
    static constexpr std::uint64_t max_outliers = 3; // in a row; then they are what the sensor measures
    static constexpr R min_turning_back = R(0.25); // of a sensor with noise; of white noise 3/4
    static constexpr R min_saturated = 4, surely_saturated = 8; // samples that repeat the largest value, or any large one
    static constexpr R min_stuck = 20, min_stuck_s = R(0.25), stuck_runs = 20; // samples, time, and usual runs

    R last[3];         // the newest believed sample
    R outlier[3];      // the newest that was not
    R change2;         // running mean of the squared change
    R slope, bend, turning_back; // change of the sum of axes, change of that, and how often its sign changes
    R largest;         // magnitude of any axis
    R limit;           // where axes saturate, as far as it has shown; 0: not known
    R run[3], run_s[3]; // samples and time for which an axis repeats its value while the body moves
    R usual_run;       // length of a run that means nothing, in samples
    std::uint64_t known, outliers_in_row;
    std::uint64_t axes; // bit i: axis i is at fault
    SensorFault fault;  // of the newest sample
    std::uint64_t outliers, stuck, saturated, left_out; // samples so far
    double since_s;     // the fault began, or ended
    double outlier_s;   // time of the newest outlier

    bool has_noise() const { return turning_back > min_turning_back; }
    bool is_at_fault(int axis) const { return (axes >> axis) & 1; }

    // Of a gyroscope: variance of the rotation about an axis that went by unseen in the sample at t_s, when the rate may have
    // been anything that a hand does; 0 for an axis that is well. A fault is found at the end of the samples that show it:
    // they count when it is.
    R lost_rotation(int axis, R interval_s, double t_s) const {
        constexpr R rate_rad_s = 2, memory_s = R(0.3);
        if (!is_at_fault(axis)) return 0;
        const R before_s = since_s == t_s ? run[axis] * interval_s : 0;
        return rate_rad_s * rate_rad_s * (2 * memory_s * interval_s + before_s * before_s);
    }

    // moves: other sensors say so. noisy: noise has been seen, in this sensor or another.
    void examine(const SensorCheckSettings<R>& settings, const Vector3Of<R>& y, R interval_s, double t_s, bool moves,
                 bool noisy) {
        const Vector3Of<R> change = y - Vector3Of<R>(last);
        const R change_squared = change.squaredNorm();
        const SensorFault before = fault;
        if (is_outlier(settings, y, change_squared)) {
            Eigen::Map<Vector3Of<R>> kept(outlier);
            kept = y;
            ++outliers_in_row;
            ++outliers;
            outlier_s = t_s;
            outlier_s = t_s;
            fault = SensorFault::outlier;
        } else {
            outliers_in_row = 0;
            change2 += change_memory * (change_squared - change2);
            known += known < min_known;
            const bool repeats = change[0] == 0 || change[1] == 0 || change[2] == 0;
            // One that is stuck says nothing of its noise.
            if (change_squared > 0 || run[0] < min_stuck) note_course(change.sum());
            const R size = y.cwiseAbs().maxCoeff();
            fault = SensorFault::none;
            axes = 0;
            if (repeats || size >= ceiling(settings)) look_at_axes(settings, y, change, interval_s, moves, noisy);
            else forget_runs();
            largest = std::fmax(largest, size);
            Eigen::Map<Vector3Of<R>> kept(last);
            kept = y;
        }
        if (fault != before) since_s = t_s;
    }

private:
    bool is_outlier(const SensorCheckSettings<R>& settings, const Vector3Of<R>& y, R change_squared) const {
        if (!(settings.outlier > 0) || change_squared <= settings.outlier * settings.outlier) return false;
        if (known < min_known || change_squared <= outlier_changes * outlier_changes * change2) return false;
        if (outliers_in_row == 0) return true;
        // Two that agree with each other rather than with what went before are a step.
        const R apart = (y - Vector3Of<R>(outlier)).squaredNorm();
        return outliers_in_row < max_outliers && apart > R(0.25) * change_squared;
    }

    void note_course(R change) {
        const R bends = change - slope;
        turning_back += change_memory * (R(bends * bend < 0) - turning_back);
        slope = change;
        bend = bends;
    }

    R ceiling(const SensorCheckSettings<R>& settings) const {
        if (settings.range > 0) return settings.range;
        return limit > 0 ? limit : std::numeric_limits<R>::infinity();
    }

    void forget_runs() {
        for (int i = 0; i < 3; ++i) {
            if (run[i] > 0) usual_run += R(0.2) * (run[i] - usual_run);
            run[i] = run_s[i] = 0;
        }
    }

    void look_at_axes(const SensorCheckSettings<R>& settings, const Vector3Of<R>& y, const Vector3Of<R>& change, R interval_s,
                      bool moves, bool noisy) {
        if (limit > 0 && y.cwiseAbs().maxCoeff() > limit) limit = 0; // it was none
        for (int i = 0; i < 3; ++i) {
            if (change[i] != 0) {
                if (run[i] > 0) usual_run += R(0.2) * (run[i] - usual_run);
                run[i] = run_s[i] = 0;
            } else {
                run[i] += 1;
                if (moves) run_s[i] += interval_s;
            }
            const R size = std::fabs(y[i]);
            // The first sample of a run does not repeat any.
            const R needed = size >= largest ? min_saturated : surely_saturated;
            if (settings.range <= 0 && noisy && run[i] + 1 >= needed && size > settings.min_range) limit = size;
            if (size >= ceiling(settings)) mark(i, SensorFault::saturated);
            else if (noisy && run[i] >= std::fmax(min_stuck, stuck_runs * usual_run) && run_s[i] >= min_stuck_s)
                mark(i, SensorFault::stuck);
        }
        stuck += fault == SensorFault::stuck;
        saturated += fault == SensorFault::saturated;
    }

    void mark(int axis, SensorFault what) {
        axes |= std::uint64_t{1} << axis;
        fault = std::max(fault, what);
    }
};

} // namespace hnav
