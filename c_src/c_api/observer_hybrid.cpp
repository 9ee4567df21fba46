// The C boundary of the observer for an integrator of the caller: what flows, and what samples do to it.
#include "c_api/observer.hpp"

#include <algorithm>
#include <cmath>

namespace {

hnav_status check_point(const hnav_observer* o, double t_s, const double* x) {
    if (!std::isfinite(t_s)) return o->fail(HNAV_ERROR_NON_FINITE, "t_s = %g is not finite", t_s);
    const int nx = o->filter.nx();
    const int at = static_cast<int>(std::find_if(x, x + nx, [](double v) { return !std::isfinite(v); }) - x);
    return at == nx ? HNAV_OK : o->fail(HNAV_ERROR_NON_FINITE, "x[%d] = %g is not finite", at, x[at]);
}

// An integrator outside does not know where the plant's own events lie, nor the parts that they split an estimate into.
hnav_status check_plant(const hnav_observer* o) {
    if (!o->filter.model().crosses()) return HNAV_OK;
    return o->fail(HNAV_ERROR_UNSUPPORTED,
                   "the plant has events of its own, which an integrator outside does not cross: use advance");
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
    if (const hnav_status status = check_plant(observer)) return status;
    const auto& filter = observer->filter;
    if (!filter.model().flows(filter.newest())) {
        std::fill_n(dx, filter.nx(), 0.0);
        return HNAV_OK;
    }
    if (filter.model().flow(filter.newest(), x, dx) == 0) return HNAV_OK;
    return observer->fail(HNAV_ERROR_SOLVER, "the plant has no derivatives there%s%s", *observer->plant->said() ? ": " : "",
                          observer->plant->said());
}

hnav_status hnav_observer_next_event_s(const hnav_observer* observer, double* t_s) {
    REQUIRE(observer, t_s);
    *t_s = observer->filter.next_event_s();
    return HNAV_OK;
}

hnav_status hnav_observer_jump(hnav_observer* observer, double t_s, const double* x_minus, double* x_plus) {
    REQUIRE(observer, x_minus);
    REQUIRE(observer, x_plus);
    if (const hnav_status status = check_plant(observer)) return status;
    if (const hnav_status status = check_point(observer, t_s, x_minus)) return status;
    const int waited = observer->filter.waiting();
    if (observer->filter.jump(t_s, x_minus, x_plus) == hnav::Outcome::ok) return HNAV_OK;
    observer->dropped += static_cast<std::uint64_t>(waited - observer->filter.waiting());
    return observer->fail(HNAV_ERROR_SOLVER, "samples up to t = %.9g s led to no usable estimate and were dropped", t_s);
}

hnav_status hnav_observer_show(hnav_observer* observer, double t_s, const double* x) {
    REQUIRE(observer, x);
    if (const hnav_status status = check_point(observer, t_s, x)) return status;
    observer->filter.show(t_s, x);
    return HNAV_OK;
}

} // extern "C"
