// The INS for a caller's integrator: flow and jumps.
#include "c_api/ins_object.hpp"

#include <algorithm>

namespace hnav {

hnav_status InsObject::derivative(const double* x, double* dx) const {
    if (filter.model().flows(filter.newest())) filter.derivative(x, dx);
    else std::fill_n(dx, ins::nx, 0.0);
    return HNAV_OK;
}

hnav_status InsObject::derivative_along(const double* x, const double* seed, double* out) const {
    if (filter.model().flows(filter.newest())) filter.model().flow_along(filter.newest(), x, seed, out);
    else std::fill_n(out, ins::nx, 0.0);
    return HNAV_OK;
}

// Late samples lead back before the time of an external integrator. With a horizon the estimate is therefore integrated
// internally, and x follows it from event to event.
Outcome InsObject::jump(double t_s, const double* x_minus, double* x_plus) {
    flows_outside = true;
    if (!goes_back) return filter.jump(t_s, x_minus, x_plus);
    filter.show(t_s, x_minus); // the time, which a trial step may have exceeded
    const Outcome outcome = filter.advance(t_s);
    std::copy_n(filter.shown().x, ins::nx, x_plus);
    return outcome;
}

void InsObject::show(double t_s, const double* x) {
    flows_outside = true;
    filter.show(t_s, x);
}

} // namespace hnav

using namespace hnav;

extern "C" {

hnav_status hnav_ins_navigation_along(const hnav_filter* filter, const double* seed, hnav_navigation_along* along) {
    REQUIRE_OBJECT(const InsObject, object, filter);
    REQUIRE_STRUCT(object, along, hnav_navigation_along);
    REQUIRE(object, seed);
    const ins::State& shown = object->filter.shown();
    hnav_navigation_along result{};
    if (shown.started()) {
        const ins::MotionAlong motion = ins::motion_along(shown, seed);
        result.latitude_rad = motion.place.latitude_rad;
        result.longitude_rad = motion.place.longitude_rad;
        result.height_m = motion.place.height_m;
        store(motion.velocity_n, result.velocity_n_m_s);
        store(motion.q_nb, result.q_nb);
        store(motion.euler, result.euler_rad);
    }
    return hand_out(result, along);
}

} // extern "C"
