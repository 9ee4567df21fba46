// First-order Gauss-Markov error: white noise through a low pass, correlated over a time constant tau.
//
//   lambda(k) = phi lambda(k-1) + sqrt(1 - phi^2) sigma n(k),   lambda(0) = sigma n(0),   n ~ (0, 1)
//
// With this drive sigma is the standard deviation at every step, for any phi.
//   R. G. Brown, P. Y. C. Hwang, Introduction to Random Signals and Applied Kalman Filtering, 4th ed., section 4.6.
#pragma once

#include <cmath>

namespace hnav {

struct GaussMarkov {
    double phi = 0;
    double sigma = 0;

    // euler: phi = 1 - dt/tau, as Hajiyev and Hacizade (2023) print it, in place of the exact exp(-dt/tau).
    static GaussMarkov over(double dt_s, double sigma, double tau_s, bool euler) {
        const double ratio = dt_s / tau_s;
        return {euler ? 1 - ratio : std::exp(-ratio), sigma};
    }

    double drive_variance() const { return sigma * sigma * (1 - phi * phi); }
    double start(double n) const { return sigma * n; }
    double next(double lambda, double n) const { return phi * lambda + std::sqrt(drive_variance()) * n; }
};

} // namespace hnav
