// The aircraft with an INS that options and a model describe: its flight, and the filter that fits it.
#pragma once

#include "hnav/simulation.h"
#include "simulation/aircraft_flight.hpp"

namespace hnav {

class Aircraft {
public:
    Aircraft(const hnav_aircraft_options& options, const hnav_aircraft_model& model);

    AircraftFlight flight;

    // False when the flow over an interval is beyond what numbers hold.
    bool is_finite() const;

    // Equal options and model, equal fingerprint.
    std::uint64_t fingerprint() const;

    // Pointers into this object.
    hnav_ins_error_model filter_model() const;

private:
    // What a filter of this aircraft is made from beside the flow, row-major.
    RowMajor H_, An_, Qv_, QU_, Lambda0_, P0_;
};

} // namespace hnav
