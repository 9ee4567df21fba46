// A diffusing number z > 0 that ends at 0. Its density there is zero, unlike that of a Gaussian, which cut again and again at 0 would lose
// the same share in any interval however short. A family that a diffusion without drift does not leave:
//
//     f(z) = (phi((z - m) / s) - phi((z + m) / s)) / (s E(m / s))      z > 0, E(a) = erf(a / sqrt(2))
//
// Over a time in which s^2 grows by q the share E(m / s') / E(m / s) stays; of two intervals in a row the shares multiply to that of both. m and s follow
// from mean and variance of z.
#pragma once

#include <algorithm>
#include <cmath>

namespace hnav {

struct Absorption {
    double ended; // share
    double variance; // of what has ended about 0, had it gone on
};

// E, mean and mean square of f for s = 1. As m tends to 0 it tends to Rayleigh's density.
struct Survivors {
    explicit Survivors(double m)
        : share(std::erf(m / M_SQRT2)),
          mean(m / share),
          square(m * m + 1 + 2 * m * std::exp(-0.5 * m * m) / (std::sqrt(2 * M_PI) * share)) {}
    double share, mean, square;
};

inline Absorption absorb(double mean, double variance, double added) {
    constexpr double least = 1e-3, far = 8; // m / s, within which the family is no Gaussian
    const double ratio = mean / std::sqrt(variance);
    double low = least, high = std::max(least, std::min(ratio, far));
    for (int k = 0; k < 40 && ratio < far; ++k) {
        const double middle = 0.5 * (low + high);
        const Survivors at(middle);
        (at.mean < ratio * std::sqrt(at.square - at.mean * at.mean) ? low : high) = middle;
    }
    const double a = ratio < far ? high : ratio, s = mean / Survivors(a).mean, s_after = std::sqrt(s * s + added);
    const double a_after = std::max(1e-6, a * s / s_after);
    const Survivors after(a_after);
    const double ended = (std::erfc(a_after / M_SQRT2) - std::erfc(a / M_SQRT2)) / std::erf(a / M_SQRT2);
    if (!(ended > 0)) return {0, 0};
    const double square = mean * mean + variance + added - (1 - ended) * s_after * s_after * after.square;
    return {ended, std::clamp(square / ended, 0.0, added)};
}

} // namespace hnav
