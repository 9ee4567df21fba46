// What the targets of the filters for coloured INS errors share: a good model, and a look at all outputs.
#pragma once

#include "input.hpp"
#include "invariant.hpp"

#include <vector>

namespace fuzz {

// Two states that turn and decay, both measured with errors of the first order.
struct InsErrorModel {
    double A[4] = {0.95, 0.1, -0.1, 0.95}, B[2] = {0.1, 0.02}, G[4] = {1, 0, 0, 1}, H[4] = {1, 0, 0, 1};
    double An[4] = {0.99, 0, 0, 0.7}, Bn[4] = {1, 0, 0, 1}, Qw[4] = {1e-4, 0, 0, 1e-4}, Qv[4] = {1e-2, 0, 0, 1e-2};
    double QU[4] = {1e-3, 0, 0, 1e-3}, Lambda0[4] = {0.05, 0, 0, 0.002}, x0[2] = {0, 0}, P0[4] = {1, 0, 0, 1};
    hnav_ins_error_model view{sizeof(hnav_ins_error_model), 2, 1, 2, 2, 2, 0, A, B, G, H, An, Bn, Qw, Qv, QU, Lambda0, x0, P0};

    InsErrorModel() = default;
    InsErrorModel(const InsErrorModel&) = delete;
};

inline std::vector<unsigned char> saved(const hnav_ins_error_filter* filter) {
    std::size_t size = 0;
    HOLDS(hnav_ins_error_filter_state_size(filter, &size) == HNAV_OK && size > 0);
    std::vector<unsigned char> state(size);
    HOLDS(hnav_ins_error_filter_save(filter, state.data(), size) == HNAV_OK);
    return state;
}

// printed: MDKF and AMDKF, whose innovation covariance need not be one.
inline void look(const hnav_ins_error_filter* filter, bool printed = false) {
    auto s = hnav_sized<hnav_ins_error_info>();
    HOLDS(hnav_ins_error_filter_info(filter, &s) == HNAV_OK);
    HOLDS(s.nx >= 1 && s.nx <= 32 && s.nz >= 1 && s.nz <= 32 && s.shown_step <= s.steps);
    double x[32], sigma[32], P[32 * 32], scale[32], fault[32];
    HOLDS(hnav_ins_error_filter_estimate(filter, x, sigma) == HNAV_OK);
    HOLDS(finite(x, s.nx) && finite(sigma, s.nx) && not_negative(sigma, s.nx));
    HOLDS(hnav_ins_error_filter_covariance(filter, P) == HNAV_OK);
    covariance(P, s.nx);
    HOLDS(hnav_ins_error_filter_noise(filter, scale, fault) == HNAV_OK);
    for (int i = 0; i < s.nz; ++i) HOLDS(scale[i] > 0 && std::isfinite(scale[i]) && fault[i] >= 0 && fault[i] <= 1);
    double innovation[32], S[32 * 32], nis, lambda[32], lambda_sigma[32], compensated[32];
    const hnav_status status = hnav_ins_error_filter_innovation(filter, innovation, S, &nis);
    HOLDS(status == HNAV_OK || status == HNAV_ERROR_NO_DATA);
    bool none = true; // without a channel there is no innovation
    for (int i = 0; i < s.nz && status == HNAV_OK; ++i) none = none && std::isnan(innovation[i]);
    if (status == HNAV_OK) HOLDS(none ? std::isnan(nis) || nis == 0 : (nis >= 0 || printed) && std::isfinite(nis));
    answered(hnav_ins_error_filter_coloured_error(filter, lambda, lambda_sigma, compensated), "no data");
    HOLDS(hnav_ins_error_filter_warning(filter) != nullptr);
}

} // namespace fuzz
