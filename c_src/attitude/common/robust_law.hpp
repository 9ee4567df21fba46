// The robust inflation of a covariance: before each correction P is replaced by
//
//     Sigma = (P^-1 - gamma^-2 L'L)^-1        (the paper's Algorithm 2; gamma = infinity gives P back: the EKF)
//
// without an inverse of P: with W = gamma^2 I - L P L',  Sigma = P + (L P)' W^-1 (L P). That is exact for a singular P
// and positive semidefinite by form. It exists while lmax(L P L') < gamma^2; where the asked gamma leaves
// less than a twentieth of margin, gamma is raised and the raise reported.
#pragma once

#include "maths/cholesky.hpp"
#include "maths/eigenvalues.hpp"

#include <cmath>
#include <limits>

namespace hnav {

enum class GammaMode {
    off,      // gamma = infinity
    fixed,    // the paper's constant
    relative, // gamma^-2 = rho / lmax(L P L'), rho = 1 - exp(-rate T): independent of the sample rate
    kl        // from a tolerance on relative entropy (Levy and Nikoukhah, IEEE TAC 58(3), 2013)
};

struct RobustSettings {
    GammaMode mode = GammaMode::off;
    double gamma = 1;          // fixed
    double relative_rate = 1;  // relative, 1/s
    double kl_rate = 1;        // kl, nats per second
};

struct RobustReport {
    double gamma = std::numeric_limits<double>::infinity();
    double margin = 1; // 1 - lmax(L P L') / gamma^2
    bool raised = false;
};

// Relative entropy between the worst-case and the nominal Gaussian at theta = gamma^-2, for eigenvalues of L P L'.
template <class Eigenvalues>
inline double kl_divergence(const Eigenvalues& eigenvalues, double theta, double* slope) {
    double sum = 0, product = 1, derivative = 0;
    for (int i = 0; i < eigenvalues.size(); ++i) {
        const double z = 1 - theta * eigenvalues[i];
        const double ratio = eigenvalues[i] / z;
        sum += 1 / z - 1;
        product *= z;
        derivative += ratio * ratio;
    }
    *slope = 0.5 * theta * derivative;
    return 0.5 * (sum + std::log(product));
}

// The theta at which the divergence equals c, or limit if it stays below. Newton within a shrinking bracket.
template <class Eigenvalues>
inline double theta_for_kl(const Eigenvalues& eigenvalues, double c, double limit) {
    double slope;
    if (!(c > 0)) return 0;
    if (kl_divergence(eigenvalues, limit, &slope) <= c) return limit;
    double low = 0, high = limit;
    // For small theta the divergence is theta^2 sum(l^2) / 4.
    double theta = std::fmin(0.5 * limit, 2 * std::sqrt(c / eigenvalues.squaredNorm()));
    for (int i = 0; i < 60; ++i) {
        const double excess = kl_divergence(eigenvalues, theta, &slope) - c;
        (excess > 0 ? high : low) = theta;
        double next = theta - excess / slope;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        if (std::fabs(next - theta) <= 1e-13 * next) return next;
        theta = next;
    }
    return theta;
}

// theta = gamma^-2 for the eigenvalues of L P L', in ascending order; 0 where there is nothing to inflate.
template <class Eigenvalues>
inline double inflation_theta(const Eigenvalues& eigenvalues, double interval_s, const RobustSettings& settings,
                              RobustReport* report) {
    constexpr double largest_share = 0.95; // of gamma^2 that lmax(L P L') may take
    const double lmax = eigenvalues[eigenvalues.size() - 1];
    if (!(lmax > 0)) return 0;
    const double limit = largest_share / lmax;
    double theta = 0;
    switch (settings.mode) {
    case GammaMode::fixed: theta = 1 / (settings.gamma * settings.gamma); break;
    case GammaMode::relative: theta = -std::expm1(-settings.relative_rate * interval_s) / lmax; break;
    case GammaMode::kl: theta = theta_for_kl(eigenvalues, settings.kl_rate * interval_s, limit * (1 + 1e-12)); break;
    case GammaMode::off: break;
    }
    if (theta > limit) {
        theta = limit;
        report->raised = true;
    }
    if (!(theta > 0)) return 0;
    report->gamma = 1 / std::sqrt(theta);
    report->margin = 1 - theta * lmax;
    return theta;
}

// Sigma from P, with L = [0 D 0] over the k states from `first` on, D diagonal. interval_s: since the last correction; a
// second one at the same instant (a heading aid beside force and field) is not inflated again.
template <int n, int k>
inline Square<n> inflate_block(const Square<n>& P, int first, const Eigen::Matrix<double, k, 1>& D, double interval_s,
                               const RobustSettings& settings, RobustReport* report) {
    *report = {};
    if (settings.mode == GammaMode::off || !(interval_s > 0)) return P;

    const Eigen::Matrix<double, k, n> LP = D.asDiagonal() * P.template middleRows<k>(first);
    const Square<k> LPL = LP.template middleCols<k>(first) * D.asDiagonal();
    const double theta = inflation_theta(eigenvalues<k>(LPL), interval_s, settings, report);
    if (!(theta > 0)) return P;

    Square<k> W = -LPL;
    W.diagonal().array() += 1 / theta;
    return P + Cholesky<k>(W).template quadratic_form<n>(LP);
}

template <int n>
inline Square<n> inflate(const Square<n>& P, const Eigen::Matrix<double, n, 1>& L, double interval_s,
                         const RobustSettings& settings, RobustReport* report) {
    return inflate_block<n, n>(P, 0, L, interval_s, settings, report);
}

} // namespace hnav
