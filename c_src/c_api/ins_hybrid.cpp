// The C boundary of the navigation filter for an integrator of the caller: what flows, and what samples do to it.
#include "c_api/callers_state.hpp"
#include "c_api/ins_object.hpp"

#include <algorithm>

using namespace hnav;
using namespace hnav::ins_boundary;

namespace {

constexpr int quaternion = 6; // in x, behind displacement and velocity

bool flows(const hnav_ins* f) { return f->filter.model().flows(f->filter.newest()); }

// A point of the caller's, at which samples act or the filter is shown.
hnav_status check_point(const hnav_ins* f, double t_s, const double* x) {
    if (const hnav_status status = check_time(f, t_s)) return status;
    return check_callers_state(*f, x, ins::nx, quaternion);
}

// Late samples lead back over what an integrator outside has crossed already: then the estimate is integrated inside, and x follows
// it from event to event.
Outcome jump(Filter<ins::Model>& filter, bool goes_back, double t_s, const double* x_minus, double* x_plus) {
    if (!goes_back) return filter.jump(t_s, x_minus, x_plus);
    filter.show(t_s, x_minus); // the time, which a trial step may have run beyond
    const Outcome outcome = filter.advance(t_s);
    std::copy_n(filter.shown().x, ins::nx, x_plus);
    return outcome;
}

} // namespace

extern "C" {

hnav_status hnav_ins_nx(const hnav_ins* object, int32_t* nx) {
    REQUIRE(object, nx);
    *nx = ins::nx;
    return HNAV_OK;
}

hnav_status hnav_ins_get_x(const hnav_ins* object, double* x) {
    REQUIRE(object, x);
    std::copy_n(object->filter.newest().x, ins::nx, x);
    return HNAV_OK;
}

hnav_status hnav_ins_nominal_x(const hnav_ins* object, double* nominal_x) {
    REQUIRE(object, nominal_x);
    object->filter.model().nominal(nominal_x);
    return HNAV_OK;
}

hnav_status hnav_ins_derivative(const hnav_ins* object, double t_s, const double* x, double* dx) {
    REQUIRE(object, x);
    REQUIRE(object, dx);
    if (const hnav_status status = check_time(object, t_s)) return status;
    if (flows(object)) object->filter.derivative(x, dx);
    else std::fill_n(dx, ins::nx, 0.0);
    return HNAV_OK;
}

hnav_status hnav_ins_derivative_along(const hnav_ins* object, double t_s, const double* x, const double* seed, double* out) {
    REQUIRE(object, x);
    REQUIRE(object, seed);
    REQUIRE(object, out);
    if (const hnav_status status = check_time(object, t_s)) return status;
    const auto& filter = object->filter;
    if (flows(object)) filter.model().flow_along(filter.newest(), x, seed, out);
    else std::fill_n(out, ins::nx, 0.0);
    return HNAV_OK;
}

hnav_status hnav_ins_next_event_s(const hnav_ins* object, double* t_s) {
    REQUIRE(object, t_s);
    *t_s = object->filter.next_event_s();
    return HNAV_OK;
}

hnav_status hnav_ins_jump(hnav_ins* object, double t_s, const double* x_minus, double* x_plus) {
    REQUIRE(object, x_minus);
    REQUIRE(object, x_plus);
    if (const hnav_status status = check_point(object, t_s, x_minus)) return status;
    object->flows_outside = true;
    if (jump(object->filter, object->goes_back, t_s, x_minus, x_plus) == Outcome::ok) return HNAV_OK;
    return object->fail(HNAV_ERROR_SOLVER, "samples up to t = %.9g s led to no usable estimate and were dropped", t_s);
}

hnav_status hnav_ins_show(hnav_ins* object, double t_s, const double* x) {
    REQUIRE(object, x);
    if (const hnav_status status = check_point(object, t_s, x)) return status;
    object->flows_outside = true;
    object->filter.show(t_s, x);
    return HNAV_OK;
}

hnav_status hnav_ins_navigation_along(const hnav_ins* object, const double* seed, hnav_navigation_along* along) {
    REQUIRE_STRUCT(object, along, hnav_navigation_along);
    REQUIRE(object, seed);
    const ins::State& shown = object->filter.shown();
    hnav_navigation_along result{};
    if (shown.started()) {
        const ins::MotionAlong motion = ins::motion_along(shown, seed);
        result.latitude_rad = motion.place.latitude_rad;
        result.longitude_rad = motion.place.longitude_rad;
        result.height_m = motion.place.height_m;
        Eigen::Map<Vector3>{result.velocity_n_m_s} = motion.velocity_n;
        Eigen::Map<Quaternion>{result.q_nb} = motion.q_nb;
        Eigen::Map<Vector3>{result.euler_rad} = motion.euler;
    }
    hand_out(result, along);
    return HNAV_OK;
}

} // extern "C"
