// The aircraft with an INS of given options and model: its flight, and the model of a filter for it.
#pragma once

#include "hnav/simulation.h"
#include "simulation/aircraft_flight.hpp"

namespace hnav {

class Aircraft {
public:
    Aircraft(const hnav_aircraft_options& options, const hnav_aircraft_model& model);

    AircraftFlight flight;

    // False if the flow over an interval overflows.
    bool is_finite() const;

    // Equal options and model, equal fingerprint.
    std::uint64_t fingerprint() const;

    // Pointers into this object.
    hnav_ins_error_model filter_model() const;

private:
    // Matrices of a filter for this aircraft, beside the flow, row-major.
    RowMajor H_, An_, Qv_, QU_, Lambda0_, P0_;
};

} // namespace hnav
