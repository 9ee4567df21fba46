// The robust inflation of a covariance: before each correction P is replaced by
//
//     Sigma = (P^-1 - gamma^-2 L'L)^-1        (the paper's Algorithm 2; gamma = infinity gives P back: the EKF)
//
// without an inverse of P: with W = gamma^2 I - L P L',  Sigma = P + (L P)' W^-1 (L P). That is exact for a singular P
// and positive semidefinite by form. It exists while lmax(L P L') < gamma^2; where the asked gamma leaves
// less than a twentieth of margin, gamma is raised and the raise reported.
#pragma once

#include "maths/blocks.hpp"
#include "maths/cholesky.hpp"
#include "maths/eigenvalues.hpp"
#include "maths/square.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hnav {

enum class GammaMode {
    off,      // gamma = infinity
    fixed,    // the paper's constant
    relative, // gamma^-2 = rho / lmax(L P L'), rho = 1 - exp(-rate T): independent of the sample rate
    // From a tolerance on relative entropy (Levy and Nikoukhah, IEEE TAC 58(3), 2013): (rate T)^2 for each correction. For small
    // theta the entropy is theta^2 sum(l^2) / 4, so theta is in proportion to T and the sample rate drops out, as in relative.
    kl
};

template <class R>
struct RobustSettings {
    GammaMode mode = GammaMode::off;
    R gamma = 1; // fixed
    R relative_rate = 1; // relative, 1/s
    R kl_rate = 1; // kl, 1/s: a correction may spend (rate T)^2 nats

    RobustSettings() = default;
    template <class Options>
    explicit RobustSettings(const Options& o)
        : mode(static_cast<GammaMode>(o.gamma_mode)),
          gamma(R(o.gamma)),
          relative_rate(R(o.gamma_relative_rate_1_s)),
          kl_rate(R(o.gamma_kl_rate_1_s)) {}
};

template <class R>
struct RobustReport {
    R gamma = std::numeric_limits<R>::infinity();
    R margin = 1; // 1 - lmax(L P L') / gamma^2
    bool raised = false;
};

// Relative entropy between the worst-case and the nominal Gaussian at theta = gamma^-2, for eigenvalues of L P L'.
template <int n, class R>
inline R kl_divergence(const Eigen::Matrix<R, n, 1>& eigenvalues, R theta, R* slope) {
    R sum = 0, product = 1, derivative = 0;
    for (int i = 0; i < n; ++i) {
        const R z = 1 - theta * eigenvalues[i];
        const R ratio = eigenvalues[i] / z;
        sum += 1 / z - 1;
        product *= z;
        derivative += ratio * ratio;
    }
    *slope = R(0.5) * theta * derivative;
    return R(0.5) * (sum + std::log(product));
}

// The theta at which the divergence equals c, or limit if it stays below. Newton within a shrinking bracket.
template <int n, class R>
R theta_for_kl(const Eigen::Matrix<R, n, 1>& eigenvalues, R c, R limit) {
    constexpr R precision = std::max(R(1e-13), 4 * std::numeric_limits<R>::epsilon());
    R slope;
    if (!(c > 0)) return 0;
    if (kl_divergence(eigenvalues, limit, &slope) <= c) return limit;
    R low = 0, high = limit;
    // For small theta.
    R theta = std::fmin(R(0.5) * limit, 2 * std::sqrt(c / eigenvalues.squaredNorm()));
    for (int i = 0; i < 60; ++i) {
        const R excess = kl_divergence(eigenvalues, theta, &slope) - c;
        (excess > 0 ? high : low) = theta;
        R next = theta - excess / slope;
        if (!(next > low && next < high)) next = R(0.5) * (low + high);
        if (std::fabs(next - theta) <= precision * next) return next;
        theta = next;
    }
    return theta;
}

// theta = gamma^-2 for the eigenvalues of L P L', in ascending order; 0 where there is nothing to inflate.
template <int n, class R>
R inflation_theta(const Eigen::Matrix<R, n, 1>& eigenvalues, R interval_s, const RobustSettings<R>& settings,
                  RobustReport<R>* report) {
    constexpr R max_share = R(0.95); // of gamma^2 that lmax(L P L') may take
    const R lmax = eigenvalues[n - 1];
    if (!(lmax > 0)) return 0;
    const R limit = max_share / lmax;
    R theta = 0;
    switch (settings.mode) {
    case GammaMode::fixed: theta = 1 / (settings.gamma * settings.gamma); break;
    case GammaMode::relative: theta = -std::expm1(-settings.relative_rate * interval_s) / lmax; break;
    case GammaMode::kl: {
        // A hair above the limit, so that a gamma which had to be raised is distinguished from one at the limit by itself.
        constexpr R above = 1 + std::max(R(1e-12), 4 * std::numeric_limits<R>::epsilon());
        theta = theta_for_kl<n, R>(eigenvalues, square(settings.kl_rate * interval_s), limit * above);
        break;
    }
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

// P becomes Sigma at theta > 0. LP: the k rows L P; LPL: L P L'.
template <int n, int k, class R>
void inflate_by(Square<n, R>& P, const Eigen::Matrix<R, k, n>& LP, const Square<k, R>& LPL, std::common_type_t<R> theta) {
    Square<k, R> W = -LPL;
    W.diagonal().array() += 1 / theta;
    Cholesky<k, R>(W).template add_quadratic_form<n>(LP, P);
}

// P becomes Sigma. interval_s: since the last correction; a second one at the same instant (a heading aid beside force and field) is not
// inflated again.
template <int n, int k, class R>
void inflate(Square<n, R>& P, const Eigen::Matrix<R, k, n>& LP, const Square<k, R>& LPL, std::common_type_t<R> interval_s,
             const RobustSettings<R>& settings, RobustReport<R>* report) {
    *report = {};
    if (settings.mode == GammaMode::off || !(interval_s > 0)) return;
    const R theta = inflation_theta<k, R>(eigenvalues<k, R>(LPL), interval_s, settings, report);
    if (theta > 0) inflate_by<n, k, R>(P, LP, LPL, theta);
}

} // namespace hnav
