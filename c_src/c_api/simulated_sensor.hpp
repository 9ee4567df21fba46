// What the simulated sensors share behind their handles: truth, time, readings, saved states.
#pragma once

#include "c_api/arrays.hpp"
#include "c_api/saved_object.hpp"
#include "c_api/sized.hpp"
#include "maths/rotation.hpp"
#include "simulation/delivery.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>

namespace hnav {

template <class Device>
struct SimulatedSensor : KeptMessage<160> {
    using State = typename Device::State;

    template <class... Arguments>
    explicit SimulatedSensor(std::uint64_t fingerprint, const Arguments&... arguments)
        : device(arguments...), fingerprint(fingerprint) {}

    void reset() { device.reset(); }
    const void* numbers() const { return &device.state(); }
    bool assign(const void* numbers) {
        State state;
        std::memcpy(&state, numbers, sizeof state);
        return device.assign(state);
    }

    Device device;
    std::uint64_t fingerprint; // of options and start
};

// A condition on several options. what: the latency as a text, after the name of the sensor.
inline hnav_status check_latency(const CallersMessage& caller, const char* sensor, const char* what, double latency_s,
                                 double period_s) {
    if (latency_s <= max_latency_periods * period_s) return HNAV_OK;
    return caller.fail(HNAV_ERROR_OPTION, "%s.%s = %g is more than %g times %s.period_s = %g", sensor, what, latency_s,
                       max_latency_periods, sensor, period_s);
}

// A field of a truth, by its name.
struct TruthField {
    const char* name;
    const double* value;
    int count;
};

template <class Sensor>
hnav_status check_truth(const Sensor& sensor, const double* q_nb, std::initializer_list<TruthField> fields) {
    for (const TruthField& field : fields)
        if (const hnav_status status = check_numbers(sensor, field.name, field.value, field.count, largest_truth)) return status;
    const double length = Quaternion(q_nb).norm();
    if (length > 0.5) return HNAV_OK;
    return sensor.fail(HNAV_ERROR_ZERO_VECTOR, "truth.q_nb has length %g, which is no attitude", length);
}

template <class Sensor>
hnav_status advance_sensor(Sensor* sensor, double t_s) {
    if (!sensor) return HNAV_ERROR_NULL_ARGUMENT;
    REQUIRE_FINITE(sensor, t_s);
    sensor->device.advance(t_s);
    return HNAV_OK;
}

template <class Sensor>
hnav_status give_next_event_s(const Sensor* sensor, double* next_s) {
    REQUIRE(sensor, next_s);
    *next_s = sensor->device.next_event_s();
    return HNAV_OK;
}

template <class State, class Reading>
void fill_reading(const State& state, Reading* out) {
    const auto& newest = state.delivery.newest;
    std::copy(std::begin(newest.value), std::end(newest.value), out->value);
    out->t_meas_s = newest.t_meas_s;
    out->count = static_cast<std::uint64_t>(state.delivery.count);
    out->missed = static_cast<std::uint64_t>(state.missed);
    out->dropped = static_cast<std::uint64_t>(state.dropped);
}

} // namespace hnav
