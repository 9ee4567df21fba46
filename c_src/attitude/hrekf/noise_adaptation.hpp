// Robbins-Monro adaptation of the bias walk Q_b (3 x 3, per second).
//
//   as printed    Q <- (1 - alpha) Q + alpha K nu nu' K'
//   corrected     Qhat = [ |sum K0 nu|^2 + sum tr(P0+ - P+_{k-1}) ] / 3W  over a window of W seconds of corrections,
//                 q <- (1 - alpha) q + alpha Qhat,  q = tr(Q) / 3, within bounds;  Q <- Q q+ / q
//
// K0 and P0+ are of the plain Kalman correction: the inflated gain would feed its own inflation back. A filter whose Q is
// right expects Qhat = q (the bias does not flow, so Phi = I). The square is taken of the sum, not the sum of squares: with
// Q too large the corrections chase noise to and fro and the sum stays small, with Q too small they all push one way; that is
// what brings q back from both sides. Nothing is adapted until the start has settled, whose errors are no walk, and nothing is
// projected but the mean over a window: single samples, made positive, would only ever raise q.
// The step alpha falls when successive estimates lie on different sides of q (Kesten, Ann. Math. Stat. 29(1), 1958), so that a
// wrong q is left in a few windows and a right one is kept.
#pragma once

#include "base/instant.hpp"
#include "maths/rotation.hpp"
#include "maths/scalar.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hnav {

enum class Adaptation { off, paper, corrected };

template <class R>
struct AdaptationSettings {
    Adaptation mode = Adaptation::off;
    R gain = R(0.02);   // as printed alpha, corrected the least alpha
    R min = 0, max = 1; // bounds of q, (rad/s)^2/s
};

template <class R>
inline Matrix3Of<R> adapt_as_printed(const Matrix3Of<Exactly<R>>& Q, const AdaptationSettings<R>& settings,
                                     const Vector3Of<Exactly<R>>& bias_step) {
    return (1 - settings.gain) * Q + settings.gain * bias_step * bias_step.transpose();
}

// The corrections since the last estimate. Numbers of eight bytes only.
template <class R>
struct AdaptationWindow {
    static constexpr double settling_s = 20, window_s = 10;

    double settled_s;  // NaN until the first correction
    double elapsed_s;
    R sum[3];          // of K0 nu
    R change;          // of tr P
    R direction;       // of the last estimate from q: 1 or -1, 0 before the first
    double swings;     // how often the direction changed

    void clear() { *this = {std::numeric_limits<double>::quiet_NaN(), 0, {0, 0, 0}, 0, 0, 0}; }

    // Adds a correction at t_s, interval_s after the one before: bias_step = K0 nu, change = tr(P0+ - P+_{k-1}). Returns true when
    // the window is full.
    bool add(double t_s, double interval_s, const Vector3Of<R>& bias_step, R change_of_trace) {
        if (std::isnan(settled_s)) settled_s = t_s + settling_s;
        if (!(t_s - interval_s >= settled_s - instant_s(t_s, interval_s))) return false;
        elapsed_s += interval_s;
        for (int i = 0; i < 3; ++i) sum[i] += bias_step[i];
        change += change_of_trace;
        return has_lasted(elapsed_s, double(window_s));
    }

    // Returns the factor on Q, whose level is q, and starts a new window.
    R factor(const AdaptationSettings<R>& settings, R level) {
        constexpr R first_step = R(0.9), least_factor = R(0.05);
        const R estimate = (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2] + change) / (3 * R(elapsed_s));
        const R toward = estimate > level ? R(1) : R(-1);
        swings += toward * direction < 0;
        direction = toward;
        elapsed_s = 0;
        std::fill(sum, sum + 3, R(0));
        change = 0;
        const R alpha = std::fmax(settings.gain, first_step / R(1 + swings));
        const R next = std::fmax((1 - alpha) * level + alpha * estimate, least_factor * level);
        return std::fmin(std::fmax(next, settings.min), settings.max) / level;
    }
};

} // namespace hnav
