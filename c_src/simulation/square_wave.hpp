// A square wave, the command that keeps an aircraft moving: amplitude times the sign of sin(2 pi t / period + phase).
#pragma once

#include <cmath>

namespace hnav {

struct SquareWave {
    double amplitude = 0;
    double period_s = 1;
    double phase_rad = 0;

    double at(double t_s) const {
        // Rounding must not decide the sign where the sine is zero.
        const double sine = std::nearbyint(1e9 * std::sin(6.283185307179586 * t_s / period_s + phase_rad));
        return sine > 0 ? amplitude : sine < 0 ? -amplitude : 0;
    }
};

} // namespace hnav
