// The C boundary of every filter for callers with their own integrator.
#include "c_api/arrays.hpp"
#include "c_api/filter_object.hpp"

using hnav::check_time;

namespace {

hnav_status check_state(const hnav_filter* f, const double* x) {
    constexpr double max_state = 1e50; // beyond this, products overflow
    const int q = f->quaternion_at();
    if (const hnav_status status = hnav::check_numbers(*f, "x", x, f->nx(), q < 0 ? HUGE_VAL : max_state)) return status;
    if (q < 0) return HNAV_OK;
    // Only its direction is used.
    const double square = x[q] * x[q] + x[q + 1] * x[q + 1] + x[q + 2] * x[q + 2] + x[q + 3] * x[q + 3];
    if (square > 1e-12) return HNAV_OK;
    return f->fail(HNAV_ERROR_OUT_OF_RANGE, "x holds a quaternion of length %g, which is no attitude", std::sqrt(square));
}

hnav_status check_point(const hnav_filter* f, double t_s, const double* x) {
    const hnav_status status = check_time(f, t_s);
    return status == HNAV_OK ? check_state(f, x) : status;
}

} // namespace

extern "C" {

hnav_status hnav_filter_nx(const hnav_filter* filter, int32_t* nx) {
    REQUIRE(filter, nx);
    *nx = filter->nx();
    return HNAV_OK;
}

hnav_status hnav_filter_get_x(const hnav_filter* filter, double* x) {
    REQUIRE(filter, x);
    filter->get_x(x);
    return HNAV_OK;
}

hnav_status hnav_filter_nominal_x(const hnav_filter* filter, double* nominal_x) {
    REQUIRE(filter, nominal_x);
    filter->nominal_x(nominal_x);
    return HNAV_OK;
}

hnav_status hnav_filter_derivative(const hnav_filter* filter, double t_s, const double* x, double* dx) {
    REQUIRE(filter, x);
    REQUIRE(filter, dx);
    if (const hnav_status status = check_time(filter, t_s)) return status;
    return filter->derivative(x, dx);
}

hnav_status hnav_filter_derivative_along(const hnav_filter* filter, double t_s, const double* x, const double* seed,
                                         double* out) {
    REQUIRE(filter, x);
    REQUIRE(filter, seed);
    REQUIRE(filter, out);
    if (const hnav_status status = check_time(filter, t_s)) return status;
    return filter->derivative_along(x, seed, out);
}

hnav_status hnav_filter_next_event_s(const hnav_filter* filter, double* t_s) {
    REQUIRE(filter, t_s);
    *t_s = filter->next_event_s();
    return HNAV_OK;
}

hnav_status hnav_filter_jump(hnav_filter* filter, double t_s, const double* x_minus, double* x_plus) {
    REQUIRE(filter, x_minus);
    REQUIRE(filter, x_plus);
    if (const hnav_status status = check_point(filter, t_s, x_minus)) return status;
    if (const char* why = filter->cannot_jump()) return filter->fail(HNAV_ERROR_OPTION, "%s", why);
    return filter->jump(t_s, x_minus, x_plus) == hnav::Outcome::ok ? HNAV_OK : filter->no_estimate(t_s);
}

hnav_status hnav_filter_show(hnav_filter* filter, double t_s, const double* x) {
    REQUIRE(filter, x);
    if (const hnav_status status = check_point(filter, t_s, x)) return status;
    filter->show(t_s, x);
    return HNAV_OK;
}

} // extern "C"
