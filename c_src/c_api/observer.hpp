// The object behind hnav_observer: a plant, what is known of it, and Filter<observer::Model> over both.
#pragma once

#include "base/memory.hpp"
#include "c_api/message.hpp"
#include "c_api/sized.hpp"
#include "hnav/observer.h"
#include "hybrid/filter.hpp"
#include "hybrid/stiff_solver.hpp"
#include "observer/derivative_proof.hpp"
#include "observer/observer_model.hpp"

#include <optional>

struct hnav_observer : hnav::KeptMessage<512> {
    using Filter = hnav::Filter<hnav::observer::Model>;

    hnav_observer() = default;
    hnav_observer(const hnav_observer&) = delete;
    hnav_observer& operator=(const hnav_observer&) = delete;
    ~hnav_observer() {
        hnav::release_block(block);
        if (plant) plant->destroy();
    }

    // The state's number at this place of the layout.
    double number(int place) const { return filter.newest().x()[place]; }
    // Instants that were used or wait to be.
    double instants() const { return number(layout().events) + filter.waiting(); }
    const hnav::observer::Layout& layout() const { return filter.model().layout(); }

    hnav::observer::Plant* plant = nullptr;
    void* block = nullptr; // of problem and work
    std::optional<hnav::observer::Problem> problem;
    std::optional<hnav::observer::Workspace> work;
    hnav::observer::Trouble trouble{};
    hnav::StiffSolver stiff;
    hnav::observer::DerivativeProof proof{};
    Filter filter;
    std::optional<double> start_s; // when it is given
    std::uint64_t dropped = 0;
    std::uint64_t own_number = 0; // no other observer of this process has it
};

namespace hnav {

// As they were before they told of events.
template <>
inline constexpr std::size_t first_size<hnav_plant> = offsetof(hnav_plant, n_indicators);
template <>
inline constexpr std::size_t first_size<hnav_observer_info> = offsetof(hnav_observer_info, parts);
template <>
inline constexpr std::size_t first_size<hnav_observer_run_output> = offsetof(hnav_observer_run_output, parts);

// Makes the observer of a plant, which it takes over, whatever comes of it. prover: the instance of the plant that is asked for
// the proof.
hnav_status make_observer(hnav_observer** observer, const hnav_observer_options& options, observer::Plant* plant,
                          observer::Plant& prover, const observer::Statistics& known, std::uint64_t fingerprint,
                          const CallersMessage& caller);

hnav_status status_of(const observer::Refusal& why);

hnav_status advance(hnav_observer* observer, double t_s, bool look_ahead);
hnav_status advance_row(hnav_observer* observer, double t_s);

} // namespace hnav
