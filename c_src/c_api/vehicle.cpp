// The C boundary of the vehicle.
#include "simulation/vehicle.hpp"

#include "base/memory.hpp"
#include "c_api/arrays.hpp"
#include "c_api/sized.hpp"
#include "options/lists.hpp"

#include <algorithm>
#include <cmath>

using hnav::Vehicle;
using hnav::Way;

struct hnav_vehicle : hnav::KeptMessage<160> {
    hnav_vehicle(const hnav_vehicle_options& options, double start_s) : body(options, start_s), start_s(start_s) {}

    Vehicle body;
    double start_s;
};

namespace {

// Largest averaging time that reaches back before the start.
constexpr double before_start_s = 1;

// Chosen: fifteen radii of the Earth, and as many radians; farther out gravity, a series in the height, is not defined.
constexpr double largest_state = 1e8;

hnav_status check_time(const hnav_vehicle* vehicle, double t_s) {
    REQUIRE_FINITE(vehicle, t_s);
    if (t_s >= vehicle->start_s - before_start_s) return HNAV_OK;
    return vehicle->fail(HNAV_ERROR_OUT_OF_RANGE, "t_s = %g is before the start at %g s", t_s, vehicle->start_s);
}

Vehicle::State state_of(const double* x) { return {hnav::Vector3(x), x[3]}; }

void store(const Vehicle::State& state, double* x) {
    hnav::store(state.displacement_m, x);
    x[3] = state.course_rad;
}

hnav_status check_state(const hnav_vehicle* vehicle, const double* x) {
    return hnav::check_numbers(*vehicle, "x", x, HNAV_VEHICLE_STATES, largest_state);
}

void store(const Vehicle::Seen& seen, hnav_vehicle_truth* truth) {
    truth->latitude_rad = seen.place.latitude_rad;
    truth->longitude_rad = seen.place.longitude_rad;
    truth->height_m = seen.place.height_m;
    hnav::store(seen.velocity_n, truth->velocity_n_m_s);
    hnav::store(seen.q_nb, truth->q_nb);
    hnav::store(hnav::roll_pitch_yaw(seen.q_nb), truth->euler_rad);
    hnav::store(seen.rate_b, truth->rate_b_rad_s);
    hnav::store(seen.force_b, truth->force_b_m_s2);
    hnav::store(seen.field_b, truth->field_b_tesla);
}

hnav_status make_vehicle(const hnav::CallersMessage& caller, hnav_vehicle** vehicle, const hnav_vehicle_options* options,
                         double start_s) {
    if (const hnav_status status = caller.begin(vehicle, "vehicle", {{options, "options"}})) return status;
    if (const hnav_status status = caller.check_options(options, hnav::vehicle_options)) return status;
    if (!std::isfinite(start_s)) return caller.fail(HNAV_ERROR_NON_FINITE, "start_s = %g is not finite", start_s);
    *vehicle = hnav::make_object<hnav_vehicle>(*options, start_s);
    return *vehicle ? HNAV_OK : caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for the vehicle");
}

void drop(hnav_vehicle** vehicle) {
    hnav::destroy_object(*vehicle);
    *vehicle = nullptr;
}

// Reason why a path cannot be followed.
hnav_status fail(const hnav::CallersMessage& caller, const Way::Made& made) {
    switch (made.fault) {
    case Way::Fault::none: return HNAV_OK;
    case Way::Fault::no_memory: return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for the points of the way");
    case Way::Fault::not_finite: return caller.fail(HNAV_ERROR_NON_FINITE, "point %zu of the way is not finite", made.point);
    case Way::Fault::too_far:
        return caller.fail(HNAV_ERROR_OPTION, "point %zu of the way lies farther than %g m from the start", made.point,
                           Way::farthest_m);
    case Way::Fault::times:
        return caller.fail(HNAV_ERROR_OPTION, "point %zu of the way comes less than %g s after the one before", made.point,
                           Way::shortest_s);
    case Way::Fault::no_length:
        return caller.fail(HNAV_ERROR_OPTION, "a way needs two points or more at different places; what stands is the kind rest");
    case Way::Fault::turns_back:
        return caller.fail(HNAV_ERROR_OPTION, "the way turns back on itself at point %zu: put another beside it", made.point);
    default:
        return caller.fail(HNAV_ERROR_OPTION, "the way climbs straight up behind point %zu, where a body has no heading",
                           made.point);
    }
}

} // namespace

extern "C" {

hnav_status hnav_vehicle_create(hnav_vehicle** vehicle, const hnav_vehicle_options* options, double start_s, char* message,
                                size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    const hnav_status status = make_vehicle(caller, vehicle, options, start_s);
    if (status != HNAV_OK || options->kind != HNAV_VEHICLE_WAY) return status;
    drop(vehicle);
    return caller.fail(HNAV_ERROR_OPTION, "kind = way: needs points, which hnav_vehicle_create_along takes");
}

hnav_status hnav_way_point_at(const double start[3], const double place[3], hnav_way_point* point) {
    if (!start || !place || !point) return HNAV_ERROR_NULL_ARGUMENT;
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(start[i]) || !std::isfinite(place[i])) return HNAV_ERROR_NON_FINITE;
    const bool seen = Way::seen_from({start[0], start[1], start[2]}, {place[0], place[1], place[2]}, point);
    return seen ? HNAV_OK : HNAV_ERROR_OUT_OF_RANGE;
}

hnav_status hnav_vehicle_create_along(hnav_vehicle** vehicle, const hnav_vehicle_options* options, double start_s,
                                      const hnav_way_point* points, size_t n, char* message, size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    hnav_status status = make_vehicle(caller, vehicle, options, start_s);
    if (status != HNAV_OK) return status;
    if (!points) status = caller.fail(HNAV_ERROR_NULL_ARGUMENT, "points is null");
    else if (options->kind != HNAV_VEHICLE_WAY) status = caller.fail(HNAV_ERROR_OPTION, "kind: points are for the kind way");
    else status = fail(caller, (*vehicle)->body.follow(points, n));
    if (status != HNAV_OK) drop(vehicle);
    return status;
}

void hnav_vehicle_destroy(hnav_vehicle* vehicle) { hnav::destroy_object(vehicle); }

const char* hnav_vehicle_message(const hnav_vehicle* vehicle) { return vehicle ? vehicle->message : "vehicle is null"; }

hnav_status hnav_vehicle_start(const hnav_vehicle* vehicle, double* x) {
    REQUIRE(vehicle, x);
    store(vehicle->body.start(), x);
    return HNAV_OK;
}

hnav_status hnav_vehicle_carry(const hnav_vehicle* vehicle, double from_s, double* x, double to_s) {
    REQUIRE(vehicle, x);
    for (const double t_s : {from_s, to_s})
        if (const hnav_status status = check_time(vehicle, t_s)) return status;
    if (const hnav_status status = check_state(vehicle, x)) return status;
    store(vehicle->body.carry(from_s, state_of(x), to_s), x);
    return HNAV_OK;
}

hnav_status hnav_vehicle_flow(const hnav_vehicle* vehicle, double t_s, const double* x, double* dx_dt) {
    REQUIRE(vehicle, x);
    REQUIRE(vehicle, dx_dt);
    hnav_status status = check_time(vehicle, t_s);
    if (status == HNAV_OK) status = check_state(vehicle, x);
    if (status == HNAV_OK) store(vehicle->body.flow(t_s, state_of(x)), dx_dt);
    return status;
}

hnav_status hnav_vehicle_at(const hnav_vehicle* vehicle, double t_s, const double* x, hnav_vehicle_truth* truth) {
    REQUIRE(vehicle, x);
    REQUIRE_STRUCT(vehicle, truth, hnav_vehicle_truth);
    hnav_status status = check_time(vehicle, t_s);
    if (status == HNAV_OK) status = check_state(vehicle, x);
    if (status != HNAV_OK) return status;
    hnav_vehicle_truth result{};
    result.t_s = t_s;
    store(vehicle->body.seen(t_s, state_of(x)), &result);
    return hnav::hand_out(result, truth);
}

} // extern "C"
