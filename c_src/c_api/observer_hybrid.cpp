// The C boundary of the observer for an integrator of the caller: what flows, and what samples do to it.
#include "c_api/observer.hpp"

#include <algorithm>
#include <cmath>

using hnav::observer::Answer;

namespace {

hnav_status check_point(const hnav_observer* o, double t_s, const double* x) {
    if (!std::isfinite(t_s)) return o->fail(HNAV_ERROR_NON_FINITE, "t_s = %g is not finite", t_s);
    const int nx = o->filter.nx();
    const int at = static_cast<int>(std::find_if(x, x + nx, [](double v) { return !std::isfinite(v); }) - x);
    return at == nx ? HNAV_OK : o->fail(HNAV_ERROR_NON_FINITE, "x[%d] = %g is not finite", at, x[at]);
}

} // namespace

extern "C" {

hnav_status hnav_observer_nx(const hnav_observer* observer, int32_t* nx) {
    REQUIRE(observer, nx);
    *nx = observer->filter.nx();
    return HNAV_OK;
}

hnav_status hnav_observer_get_x(const hnav_observer* observer, double* x) {
    REQUIRE(observer, x);
    std::copy_n(observer->filter.newest().x(), observer->filter.nx(), x);
    return HNAV_OK;
}

hnav_status hnav_observer_nominal_x(const hnav_observer* observer, double* x) {
    REQUIRE(observer, x);
    observer->filter.model().nominal(x);
    return HNAV_OK;
}

hnav_status hnav_observer_derivative(const hnav_observer* observer, const double* x, double* dx) {
    REQUIRE(observer, x);
    REQUIRE(observer, dx);
    const auto& filter = observer->filter;
    if (!filter.model().flows(filter.newest())) {
        std::fill_n(dx, filter.nx(), 0.0);
        return HNAV_OK;
    }
    if (observer->plant->recall(filter.newest().x() + observer->layout().memory) == Answer::ok &&
        filter.model().flow(filter.newest(), x, dx) == 0)
        return HNAV_OK;
    return observer->fail(HNAV_ERROR_SOLVER, "the plant has no derivatives there%s%s", *observer->plant->said() ? ": " : "",
                          observer->plant->said());
}

hnav_status hnav_observer_next_event_s(const hnav_observer* observer, double* t_s) {
    REQUIRE(observer, t_s);
    const auto& filter = observer->filter;
    *t_s = std::fmin(filter.next_event_s(), filter.stamp_of(filter.model().next_event_of_plant_s(filter.newest())));
    return HNAV_OK;
}

hnav_status hnav_observer_indicators(const hnav_observer* observer, const double* x, double* z) {
    REQUIRE(observer, z);
    const auto& filter = observer->filter;
    const hnav::RuntimeState& state = x ? filter.newest() : filter.shown();
    if (filter.model().indicators_at(state, x ? x : state.x(), z)) return HNAV_OK;
    return observer->fail(HNAV_ERROR_SOLVER, "the plant has no indicators there%s%s", *observer->plant->said() ? ": " : "",
                          observer->plant->said());
}

hnav_status hnav_observer_step_done(hnav_observer* observer, const double* x, int32_t* wants_event) {
    REQUIRE(observer, x);
    REQUIRE(observer, wants_event);
    const auto& model = observer->filter.model();
    const bool done = observer->filter.note([&](hnav::RuntimeState& s) { return model.step_outside_done(s, x); });
    *wants_event = done && model.wants_event(observer->filter.newest());
    if (done) return HNAV_OK;
    return observer->fail(HNAV_ERROR_SOLVER, "the plant failed at the end of a step%s%s", *observer->plant->said() ? ": " : "",
                          observer->plant->said());
}

hnav_status hnav_observer_jump(hnav_observer* observer, double t_s, const double* x_minus, double* x_plus) {
    REQUIRE(observer, x_minus);
    REQUIRE(observer, x_plus);
    if (const hnav_status status = check_point(observer, t_s, x_minus)) return status;
    const int waited = observer->filter.waiting();
    if (observer->filter.jump(t_s, x_minus, x_plus) == hnav::Outcome::ok) return HNAV_OK;
    observer->dropped += static_cast<std::uint64_t>(waited - observer->filter.waiting());
    return observer->fail(HNAV_ERROR_SOLVER, "events and samples up to t = %.9g s led to no usable estimate and were dropped%s%s",
                          t_s, *observer->plant->said() ? ": " : "", observer->plant->said());
}

hnav_status hnav_observer_show(hnav_observer* observer, double t_s, const double* x) {
    REQUIRE(observer, x);
    if (const hnav_status status = check_point(observer, t_s, x)) return status;
    observer->filter.show(t_s, x);
    return HNAV_OK;
}

} // extern "C"
