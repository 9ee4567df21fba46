// A Gaussian that is cut by bounds on its components: mean and covariance of what is left (D. Simon and D. L. Simon, "Constrained
// Kalman filtering via density function truncation for turbofan engine health estimation", Int. J. Systems Science 41, 2010).
#pragma once

#include <algorithm>
#include <cmath>

namespace hnav {

// Of a standard normal number: its density, and the probability that it is below x.
inline double normal_density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2 * M_PI); }
inline double normal_below(double x) { return 0.5 * std::erfc(-x / M_SQRT2); }

struct CutNormal {
    double mean, variance;
};

// Mean and variance of a standard normal truncated to a < b; an infinite limit does not truncate.
inline CutNormal cut_normal(double a, double b) {
    if (a + b > 0) {
        const CutNormal mirrored = cut_normal(-b, -a);
        return {-mirrored.mean, mirrored.variance};
    }
    // Beyond this limit the difference of the tails cancels in double precision; the density is taken as exponential.
    constexpr double far = -25;
    if (b < far) {
        const double widest = std::isinf(a) ? HUGE_VAL : b - a;
        return {std::max(b + 1 / b, b - 0.5 * widest), std::min(1 / (b * b), widest * widest / 12)};
    }
    const double mass = normal_below(b) - normal_below(a), at_a = normal_density(a), at_b = normal_density(b);
    const double mean = (at_a - at_b) / mass;
    const double moment = (std::isinf(a) ? 0 : a * at_a) - (std::isinf(b) ? 0 : b * at_b);
    return {mean, std::clamp(1 + moment / mass - mean * mean, 0.0, 1.0)};
}

// X and P, n x n, between low and high, component after component. True: some of it was cut. Less than a billionth is none.
inline bool truncate(int n, const double* low, const double* high, double* X, double* P) {
    constexpr double far_sigma = 6;
    bool any = false;
    for (int i = 0; i < n; ++i) {
        const double sigma = std::sqrt(std::max(0.0, P[i * n + i]));
        if (X[i] - low[i] > far_sigma * sigma && high[i] - X[i] > far_sigma * sigma) continue;
        if (!(sigma > 0)) {
            any = any || X[i] < low[i] || X[i] > high[i];
            X[i] = std::clamp(X[i], low[i], high[i]);
            continue;
        }
        any = true;
        const CutNormal cut = cut_normal((low[i] - X[i]) / sigma, (high[i] - X[i]) / sigma);
        const double shift = cut.mean / sigma, share = (1 - cut.variance) / (sigma * sigma);
        for (int j = 0; j < n; ++j) X[j] += shift * P[i * n + j];
        for (int j = 0; j < n; ++j) {
            if (j == i) continue;
            const double k = share * P[i * n + j];
            for (int l = 0; l < n; ++l)
                if (l != i) P[j * n + l] -= k * P[i * n + l];
        }
        for (int j = 0; j < n; ++j)
            if (j != i) P[i * n + j] = P[j * n + i] *= cut.variance;
        P[i * n + i] *= cut.variance;
        X[i] = std::clamp(X[i], low[i], high[i]);
    }
    return any;
}

} // namespace hnav
