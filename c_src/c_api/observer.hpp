// The observer behind hnav_filter: a plant, its statistics, and Filter<observer::Model> over both.
#pragma once

#include "base/memory.hpp"
#include "c_api/over_filter.hpp"
#include "c_api/sized.hpp"
#include "hnav/observer.h"
#include "hybrid/stiff_solver.hpp"
#include "observer/derivative_proof.hpp"
#include "observer/observer_model.hpp"

#include <optional>

namespace hnav {

struct ObserverObject final : OverWholeFilter<OverFilter<hnav_filter, observer::Model>> {
    static constexpr Product of_product = Product::observer;
    static constexpr const char* whom = "observers";

    ObserverObject() : OverWholeFilter(Product::observer) {}
    ObserverObject(const ObserverObject&) = delete;
    ObserverObject& operator=(const ObserverObject&) = delete;
    ~ObserverObject() {
        release_block(block);
        if (plant) plant->destroy();
    }

    // The state's number at this place of the layout.
    double number(int place) const { return filter.newest().x()[place]; }
    // Number of used or queued instants.
    double instants() const { return number(layout().events) + filter.waiting(); }
    const observer::Layout& layout() const { return filter.model().layout(); }
    // Number of intervals whose remainder the plant could not simulate.
    double held() const { return number(layout().counts + observer::Layout::holding); }
    // Advances, and counts dropped instants.
    template <class Move>
    Outcome moved(Move&& move) {
        trouble = {};
        const double before = instants(), held_before = held();
        const Outcome outcome = move();
        dropped += static_cast<std::uint64_t>(before - instants());
        if (outcome == Outcome::ok && held() > held_before) log_held(filter.now_s());
        return outcome;
    }
    // ": " and the plant's message of its last failure; "" without one.
    const char* colon() const { return *plant->said() ? ": " : ""; }

    observer::Plant* plant = nullptr;
    void* block = nullptr; // of problem and work
    std::optional<observer::Problem> problem;
    std::optional<observer::Workspace> work;
    observer::Trouble trouble{};
    StiffSolver stiff;
    observer::DerivativeProof proof{};
    std::optional<double> start_s; // when it is given
    std::uint64_t dropped = 0;
    hnav_observer_options options{}; // as it was made with
    std::uint64_t fingerprint = 0; // of options and plan
    std::uint64_t own_number = 0; // unique among the observers of this process

    void destroy() override;
    void reset() override;
    hnav_status take(int, double, const double*) override { return no_fixed_sensors(); }
    hnav_status take_imu(double, const double*, const double*) override { return no_fixed_sensors(); }
    Outcome advance(double t_s) override {
        return moved([&] { return filter.advance(t_s); });
    }
    Outcome commit(double t_s) override {
        return moved([&] { return filter.commit(t_s); });
    }
    hnav_status no_estimate(double t_s) const override;
    // Writes a message about a held interval, which is no error.
    void log_held(double t_s) const;

    hnav_status attitude(hnav_attitude*) const override { return unsupported("attitude"); }
    hnav_status rate(double*) const override { return unsupported("rate"); }
    hnav_status gyro_bias(double*, double*) const override { return unsupported("gyroscope"); }
    hnav_status covariance(double* P) const override;
    hnav_status innovation(int, hnav_innovation*) const override { return no_fixed_sensors(); }
    void diagnostics(hnav_diagnostics* out) const override;
    void health(hnav_health* out) const override;

    const char* cannot_save() const override;
    std::size_t snapshot_size() const override;
    void take_snapshot(void* buffer) const override;
    bool restore_snapshot(const void* buffer, std::size_t bytes) override;
    bool release_snapshot(const void* buffer, std::size_t bytes) const override;

    hnav_status derivative(const double* x, double* dx) const override;
    hnav_status derivative_along(const double*, const double*, double*) const override {
        return unsupported("directional derivative");
    }
    double next_event_s() const override;
    Outcome jump(double t_s, const double* x_minus, double* x_plus) override;

private:
    hnav_status log_trouble(const char* what, double at_s, const char* happened) const;
    hnav_status no_fixed_sensors() const {
        return fail(HNAV_ERROR_UNSUPPORTED, "the sensors of an observer are those of its plant: hnav_observer_push and its kin");
    }
};

// Sizes of the structs before they had fields for events.
template <>
inline constexpr std::size_t first_size<hnav_plant> = offsetof(hnav_plant, n_indicators);
template <>
inline constexpr std::size_t first_size<hnav_observer_statistics> = offsetof(hnav_observer_statistics, min);
template <>
inline constexpr std::size_t first_size<hnav_observer_info> = offsetof(hnav_observer_info, parts);
template <>
inline constexpr std::size_t first_size<hnav_observer_run_output> = offsetof(hnav_observer_run_output, parts);

// Creates the observer of a plant and owns the plant, also on failure.
hnav_status make_observer(hnav_filter** filter, const hnav_observer_options& options, observer::Plant* plant,
                          const observer::Statistics& known, std::uint64_t fingerprint, const CallersMessage& caller);

// A second filter for the plant and the options of an observer, from its start, whose states have joint moments. It shares
// the plant.
hnav_status make_beside(const ObserverObject& of, ObserverObject* twin, const CallersMessage& caller);

// All holders of discrete states of the plant: every part of every state, and the workspace of the model. context: an observer.
void each_holder(const void* context, void (*seen)(void*, const double*), void* visitor);

} // namespace hnav
