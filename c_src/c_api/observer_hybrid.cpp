// The observer for a caller's integrator: flow and jumps.
#include "c_api/observer.hpp"

#include <algorithm>
#include <cmath>

using hnav::ObserverObject;

namespace hnav {

hnav_status ObserverObject::derivative(const double* x, double* dx) const {
    if (!filter.model().flows(filter.newest())) {
        std::fill_n(dx, filter.nx(), 0.0);
        return HNAV_OK;
    }
    if (plant->recall(filter.newest().x() + layout().memory) == observer::Answer::ok &&
        filter.model().flow(filter.newest(), x, dx) == 0)
        return HNAV_OK;
    return fail(HNAV_ERROR_SOLVER, "the plant has no derivatives there%s%s", colon(), plant->said());
}

double ObserverObject::next_event_s() const {
    return std::fmin(filter.next_event_s(), filter.stamp_of(filter.model().next_event_of_plant_s(filter.newest())));
}

Outcome ObserverObject::jump(double t_s, const double* x_minus, double* x_plus) {
    const int waited = filter.waiting();
    trouble = {};
    const Outcome outcome = filter.jump(t_s, x_minus, x_plus);
    if (outcome != Outcome::ok) dropped += static_cast<std::uint64_t>(waited - filter.waiting());
    return outcome;
}

} // namespace hnav

extern "C" {

hnav_status hnav_observer_indicators(const hnav_filter* handle, const double* x, double* z) {
    REQUIRE_OBJECT(const ObserverObject, object, handle);
    REQUIRE(object, z);
    const auto& filter = object->filter;
    const hnav::RuntimeState& state = x ? filter.newest() : filter.shown();
    if (filter.model().indicators_at(state, x ? x : state.x(), z)) return HNAV_OK;
    return object->fail(HNAV_ERROR_SOLVER, "the plant has no indicators there%s%s", object->colon(), object->plant->said());
}

hnav_status hnav_observer_step_done(hnav_filter* handle, const double* x, int32_t* wants_event) {
    REQUIRE_OBJECT(ObserverObject, object, handle);
    REQUIRE(object, x);
    REQUIRE(object, wants_event);
    const auto& model = object->filter.model();
    const bool done = object->filter.note([&](hnav::RuntimeState& s) { return model.step_outside_done(s, x); });
    *wants_event = done && model.wants_event(object->filter.newest());
    if (done) return HNAV_OK;
    return object->fail(HNAV_ERROR_SOLVER, "the plant failed at the end of a step%s%s", object->colon(), object->plant->said());
}

} // extern "C"
