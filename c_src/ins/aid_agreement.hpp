// Whether the fixes move as the velocities say. The two aids need no model of the body to contradict each other: a velocity in other axes or in
// another unit or not connected, a latitude in the place of the longitude. While the heading is unknown nothing else shows it.
#pragma once

#include "base/instant.hpp"
#include "maths/earth.hpp"
#include "maths/square.hpp"

#include <algorithm>
#include <cmath>

namespace hnav::ins {

// Part of the state: numbers of eight bytes only. Horizontal, in the axes north and east of the fixes.
struct AidAgreement {
    static constexpr double window_s = 5; // chosen: several fixes of any receiver, and a way of ten sigmas at the pace of a car
    static constexpr double longest_s = 10; // between two fixes; chosen: a receiver of 0.1 Hz

    double place_e[3]; // first fix of the window
    double begin_s, velocity_s; // NaN: none yet
    double velocity[2], way_m[2]; // newest velocity; its integral since the begin
    double verdicts; // of windows that have ended
    double in_row; // of them that contradict
    double moved_s; // way_m ends here

    void begin() {
        *this = {};
        begin_s = velocity_s = std::nan("");
    }

    void note_velocity(const double* v, double t_s) {
        advance(t_s);
        for (int i = 0; i < 2; ++i) {
            // The velocity has changed evenly since the one before.
            if (is_within(t_s - velocity_s, longest_s)) way_m[i] += 0.5 * (t_s - velocity_s) * (v[i] - velocity[i]);
            velocity[i] = v[i];
        }
        velocity_s = t_s;
    }

    // axes: of the fix, columns north, east, down in Earth-fixed axes. sigma_m: of its horizontal position.
    void note_position(const Vector3& at_e, const Matrix3& axes, double sigma_m, double t_s) {
        advance(t_s);
        const double since_s = t_s - begin_s;
        const bool has_velocity = is_within(t_s - velocity_s, longest_s);
        if (!has_velocity || !is_within(since_s, 2 * longest_s)) return begin_window(at_e, t_s);
        if (!has_lasted(since_s, window_s)) return;
        const Vector3 moved = axes.transpose() * (at_e - Eigen::Map<const Vector3>(place_e));
        const double off_m = std::hypot(moved[0] - way_m[0], moved[1] - way_m[1]);
        const double length_m = std::fmax(std::hypot(moved[0], moved[1]), std::hypot(way_m[0], way_m[1]));
        verdicts += 1;
        if (!(off_m > sigmas * std::sqrt(2.0) * sigma_m + share * length_m)) {
            in_row = 0;
        } else {
            in_row += 1;
            if (in_row < outliers) return; // a single fix may be wrong: the window goes on
        }
        begin_window(at_e, t_s);
    }

    // Both aids have come, and they agree; or there is one of them alone.
    bool holds(double now_s) const {
        const bool both = is_within(now_s - velocity_s, longest_s) && is_within(now_s - begin_s, 2 * longest_s);
        return !both || (verdicts > 0 && in_row < outliers);
    }

private:
    // Chosen: an interruption of the velocities or a latency of a second changes a way by less.
    static constexpr double sigmas = 5, share = 0.3, outliers = 2;

    void advance(double t_s) {
        if (is_within(t_s - velocity_s, longest_s))
            for (int i = 0; i < 2; ++i) way_m[i] += (t_s - moved_s) * velocity[i];
        moved_s = t_s;
    }

    void begin_window(const Vector3& at_e, double t_s) {
        for (int i = 0; i < 3; ++i) place_e[i] = at_e[i];
        begin_s = t_s;
        way_m[0] = way_m[1] = 0;
    }
};

} // namespace hnav::ins
