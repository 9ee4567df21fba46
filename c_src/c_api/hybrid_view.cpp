// The C boundary of an attitude filter for callers that bring their own integrator.
#include "c_api/boundary.hpp"
#include "c_api/callers_state.hpp"

using hnav::Outcome;
using namespace hnav::boundary;

namespace {

// Every model has its quaternion in front.
hnav_status check_state(const hnav_filter* f, const double* x) { return hnav::check_callers_state(*f, x, f->nx(), 0); }

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
    filter->derivative(x, dx);
    return HNAV_OK;
}

hnav_status hnav_filter_derivative_along(const hnav_filter* filter, double t_s, const double* x, const double* seed,
                                         double* out) {
    REQUIRE(filter, x);
    REQUIRE(filter, seed);
    REQUIRE(filter, out);
    if (const hnav_status status = check_time(filter, t_s)) return status;
    filter->derivative_along(x, seed, out);
    return HNAV_OK;
}

hnav_status hnav_filter_next_event_s(const hnav_filter* filter, double* t_s) {
    REQUIRE(filter, t_s);
    *t_s = filter->next_event_s();
    return HNAV_OK;
}

hnav_status hnav_filter_jump(hnav_filter* filter, double t_s, const double* x_minus, double* x_plus) {
    REQUIRE(filter, x_minus);
    REQUIRE(filter, x_plus);
    if (const hnav_status status = check_time(filter, t_s)) return status;
    if (const hnav_status status = check_state(filter, x_minus)) return status;
    if (filter->causal_only)
        return filter->fail(HNAV_ERROR_OPTION,
                            "gyro_hold = backward: an integrator outside cannot know the rate before its sample");
    if (filter->jump(t_s, x_minus, x_plus) != Outcome::ok)
        return filter->fail(HNAV_ERROR_SOLVER, "samples up to t = %.9g s led to no usable estimate and were dropped", t_s);
    return HNAV_OK;
}

hnav_status hnav_filter_show(hnav_filter* filter, double t_s, const double* x) {
    REQUIRE(filter, x);
    if (const hnav_status status = check_time(filter, t_s)) return status;
    if (const hnav_status status = check_state(filter, x)) return status;
    filter->show(t_s, x);
    return HNAV_OK;
}

} // extern "C"
