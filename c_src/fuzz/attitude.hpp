// What the targets of the attitude filters share: a filter with options of the fuzzer's, a look at all its outputs, and
// the good samples that every filter must take.
#pragma once

#include "input.hpp"
#include "invariant.hpp"

#include <vector>

namespace fuzz {

struct Options {
    bool ahrs = false;
    hnav_hrekf_options hrekf_options{};
    hnav_ahrs_options ahrs_options{};

    // Byte by byte: the model, then up to seven fields of any value. Many are impossible; create is to say so.
    static Options from(Input& in) {
        Options o;
        const int head = in.byte();
        o.ahrs = head & 1;
        o.hrekf_options = hnav_hrekf_defaults(head & 2 ? HNAV_PRESET_PAPER : HNAV_PRESET_DEFAULT);
        o.ahrs_options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
        // Small, so that it is full before the bytes are spent.
        o.hrekf_options.queue_capacity = o.ahrs_options.queue_capacity = 16;
        for (int i = head >> 5; i > 0; --i) o.change_field(in);
        return o;
    }

    const hnav_option_info* row(int i) const { return ahrs ? hnav_option("ahrs", i) : hnav_option("hrekf", i); }

    void change_field(Input& in) {
        const int which = in.byte();
        int rows = 0;
        while (row(rows)) ++rows;
        const hnav_option_info* info = row(which % rows);
        auto* fields = ahrs ? reinterpret_cast<unsigned char*>(&ahrs_options) : reinterpret_cast<unsigned char*>(&hrekf_options);
        if (info->kind == HNAV_OPTION_REAL) {
            for (int k = 0; k < info->count; ++k) {
                const double value = in.number();
                std::memcpy(fields + info->offset + 8 * k, &value, 8);
            }
        } else {
            // One byte, so that memory stays small; -1 and the number beyond the last choice are among them.
            const std::int32_t value = static_cast<std::int8_t>(in.byte());
            std::memcpy(fields + info->offset, &value, 4);
        }
    }

    hnav_filter* create(hnav_status* status, char* message, std::size_t size) const {
        hnav_filter* filter = nullptr;
        *status = ahrs ? hnav_ahrs_create(&filter, &ahrs_options, message, size)
                       : hnav_hrekf_create(&filter, &hrekf_options, message, size);
        return filter;
    }
};

// A filter, or none where the options are impossible: then there was a reason.
inline hnav_filter* make(const Options& options) {
    hnav_status status;
    char message[256] = "";
    hnav_filter* filter = options.create(&status, message, sizeof message);
    answered(status, message);
    HOLDS((filter != nullptr) == (status == HNAV_OK));
    return filter;
}

// Every output: finite, or refused with a reason.
inline void look(const hnav_filter* filter) {
    auto attitude = hnav_sized<hnav_attitude>();
    hnav_status status = hnav_filter_attitude(filter, &attitude);
    HOLDS(status == HNAV_OK || status == HNAV_ERROR_NOT_STARTED);
    const bool started = status == HNAV_OK;
    if (started) {
        HOLDS(unit(attitude.q_nb));
        HOLDS(finite(attitude.euler_rad, 3) && std::isfinite(attitude.heading_rad) && !std::isnan(attitude.t_s));
        HOLDS(std::fabs(attitude.heading_rad) <= M_PI);
        HOLDS(finite(attitude.sigma_rad, 3) && positive(attitude.sigma_rad, 3));
    }

    double rate[3], bias[3], sigma[3];
    HOLDS(hnav_filter_rate(filter, rate) == HNAV_OK && finite(rate, 3));
    HOLDS(hnav_filter_gyro_bias(filter, bias, sigma) == HNAV_OK && finite(bias, 3));
    HOLDS(finite(sigma, 3) && positive(sigma, 3));

    double P[36];
    status = hnav_filter_covariance(filter, P);
    HOLDS(status == (started ? HNAV_OK : HNAV_ERROR_NOT_STARTED));
    if (started) {
        covariance(P, 6);
        HOLDS(semidefinite(P, 6));
    }

    auto posterior = hnav_sized<hnav_posterior>();
    status = hnav_filter_posterior(filter, &posterior);
    HOLDS(status == HNAV_OK || status == HNAV_ERROR_NOT_STARTED);
    if (status == HNAV_OK) {
        HOLDS(unit(posterior.q_nb) && finite(posterior.gyro_bias_rad_s, 3));
        HOLDS(finite(posterior.sigma, 6) && positive(posterior.sigma, 6));
    }

    for (int sensor = HNAV_SENSOR_ACCEL; sensor <= HNAV_SENSOR_HEADING; ++sensor) {
        auto innovation = hnav_sized<hnav_innovation>();
        status = hnav_filter_innovation(filter, static_cast<hnav_sensor>(sensor), &innovation);
        HOLDS(status == HNAV_OK || status == HNAV_ERROR_NO_DATA);
        if (status != HNAV_OK) continue;
        HOLDS(innovation.dimension >= 1 && innovation.dimension <= 3);
        HOLDS(finite(innovation.value, innovation.dimension) && innovation.nis >= 0 && std::isfinite(innovation.nis));
        HOLDS(innovation.noise_scale >= 1);
    }

    auto field = hnav_sized<hnav_field>();
    HOLDS(hnav_filter_field(filter, &field) == HNAV_OK);
    HOLDS(std::isnan(field.strength_tesla) || (field.strength_tesla > 0 && std::fabs(field.dip_rad) <= M_PI / 2));
    HOLDS(std::isfinite(field.latency_s) && std::isfinite(field.latency_sigma_s) && field.latency_sigma_s >= 0);
    HOLDS(std::isfinite(field.evidence_s) && std::isfinite(field.heading_trust_s));
    double matrix[9], matrix_sigma[9];
    HOLDS(hnav_filter_gyro_calibration(filter, matrix, matrix_sigma) == HNAV_OK);
    HOLDS(finite(matrix, 9) && finite(matrix_sigma, 9) && not_negative(matrix_sigma, 9));

    auto s = hnav_sized<hnav_diagnostics>();
    HOLDS(hnav_filter_diagnostics(filter, &s) == HNAV_OK);
    HOLDS(s.gamma_margin > 0 && s.gamma_used > 0 && s.waiting >= 0);
    HOLDS(std::isfinite(s.adapted_bias_walk_rad_s_per_sqrt_s) && s.adapted_bias_walk_rad_s_per_sqrt_s >= 0);

    std::int32_t nx;
    HOLDS(hnav_filter_nx(filter, &nx) == HNAV_OK && nx > 0 && nx <= 64);
    double x[64], nominal[64];
    HOLDS(hnav_filter_get_x(filter, x) == HNAV_OK && finite(x, nx));
    HOLDS(hnav_filter_nominal_x(filter, nominal) == HNAV_OK && finite(nominal, nx));
    for (int i = 0; i < nx; ++i) HOLDS(nominal[i] > 0);
}

// Samples of a body at rest in mid latitudes, slightly turned, that no filter has reason to refuse.
inline hnav_status push_good_imu(hnav_filter* filter, double t_s) {
    const double rate[3] = {1e-3, -2e-3, 5e-4}, force[3] = {0.4, -0.3, -9.79};
    return hnav_filter_push_imu(filter, t_s, rate, force);
}

inline hnav_status push_good_mag(hnav_filter* filter, double t_s) {
    const double field[3] = {2.0e-5, 1.0e-6, 4.3e-5};
    return hnav_filter_push_mag(filter, t_s, field);
}

inline hnav_status push_good(hnav_filter* filter, double t_s) {
    const hnav_status status = push_good_imu(filter, t_s);
    return status == HNAV_OK ? push_good_mag(filter, t_s) : status;
}

// Pushes; where the queue is full, again after an advance to advance_s. That advance may fail: it drops all that it failed over.
inline hnav_status push_with_advance(hnav_status (*push)(hnav_filter*, double), hnav_filter* filter, double t_s,
                                     double advance_s) {
    hnav_status status = push(filter, t_s);
    if (status == HNAV_ERROR_QUEUE_FULL) {
        hnav_filter_advance(filter, advance_s);
        status = push(filter, t_s);
    }
    return status;
}

// After any calls, good samples later than all others enter. latest_s: the time of the others. After clocks were set, each
// sensor may need a place of its own in the queue.
inline void enters(hnav_filter* filter, double latest_s, double t_s) {
    HOLDS(push_with_advance(push_good_imu, filter, t_s, latest_s) == HNAV_OK);
    HOLDS(push_with_advance(push_good_mag, filter, t_s, t_s) == HNAV_OK);
}

inline void takes_good_sample(hnav_filter* filter, double latest_s) {
    const double t_s = latest_s + 0.01 * std::fmax(1, std::fabs(latest_s));
    if (t_s <= 1e12) enters(filter, latest_s, t_s); // the API takes no later times
}

// After a reset nothing of the past is left: the same samples give the same bits as in a filter just made.
inline void resets(hnav_filter* filter, const Options& options) {
    hnav_filter* fresh = make(options);
    HOLDS(fresh && hnav_filter_reset(filter) == HNAV_OK);
    for (int k = 0; k < 12; ++k) {
        for (hnav_filter* f : {filter, fresh}) push_good(f, 0.01 * k);
        HOLDS(hnav_filter_advance(filter, 0.01 * k) == hnav_filter_advance(fresh, 0.01 * k));
    }
    HOLDS(saved(filter) == saved(fresh));
    look(filter);
    hnav_filter_destroy(fresh);
}

} // namespace fuzz
