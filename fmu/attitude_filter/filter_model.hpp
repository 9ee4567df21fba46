// An attitude filter of the C API as a Model of the adapter. kind.hpp describes Kind.
#pragma once

#include "adapter/filter_calls.hpp"
#include "adapter/inertial_model.hpp"
#include "adapter/unit_check.hpp"
#include "attitude_filter/inputs.hpp"
#include "attitude_filter/kind.hpp"
#include "attitude_filter/outputs.hpp"

namespace hnav::fmu {

using AttitudeCalls = FilterCalls<hnav_filter_snapshot_size, hnav_filter_take_snapshot, hnav_filter_restore_snapshot>;

template <int sensors>
struct FilterMemory : InertialMemory<sensors> {
    double start_s;
    double realign_level;
    double was_realigned; // in Model Exchange: the importer's states are still to be
    double now_s;         // of the last step
    double behind;        // 1: outputs of the look-ahead must still be computed for now_s
    UnitCheck units;
    FieldUnitCheck field_unit;
};

template <class Kind>
using InertialModelOf =
    InertialModel<AttitudeCalls, FilterMemory<Kind::sensors>, typename Kind::Options, HNAV_SENSOR_GYRO, Kind::create>;

template <class Kind>
class FilterModel final : public InertialModelOf<Kind> {
    using Base = InertialModelOf<Kind>;
    using Inputs = fmu::Inputs<Kind::sensors>;
    using Base::begins_to_count, Base::done, Base::get_states, Base::make_with, Base::memory_, Base::object_, Base::pushed,
        Base::take_reset;

public:
    void describe(Table& table) override {
        table.add(rows::time());
        in_.template describe<Kind>(table);
        out_.describe<Kind>(table);
        StateRows::add_to(table, Kind::describe_states);
    }

    bool initialise(const double* values, double start_s, bool model_exchange, Message* why) override {
        typename Kind::Options options = Kind::defaults(in_.preset < 0 ? 0 : static_cast<int>(values[in_.preset]));
        take_options(Kind::option, in_.options, values, &options);
        if (!Kind::reholds && model_exchange && options.gyro_hold != HNAV_GYRO_HOLD_FORWARD) {
            std::snprintf(
                why->text, sizeof why->text,
                "gyro_hold needs to be forward in Model Exchange: an integrator outside cannot know a rate before its sample");
            return false;
        }
        if (!make_with(options, mode_in(values, in_.sampling_mode), why)) return false;
        memory_.start_s = start_s;
        memory_.model_exchange = model_exchange;
        return memory_.sampled.start(in_.sensor, values, start_s, in_.sampling_mode, Inputs::periods, why);
    }

    void begin(const double* values) override {
        memory_.reset_level = values[in_.reset];
        memory_.realign_level = values[in_.realign];
    }

    // ------------------------------------------------------------------------------------------------ samples

    bool take_samples(double* values, double t_s) override {
        const bool begun = begins_to_count(in_.sensor, values);
        const bool was_reset = take_reset(values[in_.reset]) || begun;
        const bool was_realigned = rising(values[in_.realign], &memory_.realign_level);
        if (was_realigned) {
            hnav_filter_realign(object_);
            memory_.was_realigned = memory_.model_exchange;
        }
        const bool taken = memory_.sampled.push_new(
            in_.sensor, values, t_s, [this](int s, double stamp_s, const double* value) { pushed(push(s, stamp_s, value)); });
        return was_reset || was_realigned || taken;
    }

    Lost lost() const override { return memory_.sampled.lost(name_of); }
    Lost repeated() const override { return memory_.sampled.repeated(name_of); }
    const char* mistaken() const override { return memory_.sampled.mistaken(name_of); }

    const char* implausible() const override {
        const char* of_inertial = memory_.units.finding();
        return of_inertial ? of_inertial : memory_.field_unit.finding(Kind::has_field);
    }

    // An infeasible gamma remains infeasible from the first corrections on.
    bool judge(Message* what) override {
        hnav_diagnostics seen{};
        seen.size = sizeof seen;
        if (hnav_filter_diagnostics(object_, &seen) != HNAV_OK || seen.corrections < judged_corrections) return false;
        if (2 * seen.gamma_raised > seen.corrections)
            std::snprintf(
                what->text, sizeof what->text,
                "robust.gamma was infeasible at %.0f of the first %.0f corrections and raised to the limit, where the filter "
                "trusts its samples alone: give a larger one, or robust.gamma_mode = relative",
                static_cast<double>(seen.gamma_raised), static_cast<double>(seen.corrections));
        return true;
    }

    // The estimate alone: the look-ahead doubles the cost, and it is not read at every step by all importers.
    bool advance(double t_s, Message* why) override {
        memory_.now_s = t_s;
        memory_.behind = 1;
        return done(hnav_filter_commit(object_, t_s), why);
    }

    bool look_ahead(unsigned groups, Message* why) override {
        if (memory_.behind == 0 || !(groups & FilterOutputs::looking_ahead)) return true;
        memory_.behind = 0;
        return done(hnav_filter_advance(object_, memory_.now_s), why);
    }

    void refresh(double* values, unsigned groups) override {
        out_.refresh(object_, groups, memory_.start_s, memory_.sampled.missed, values);
    }

    // ------------------------------------------------------------------------------------------------ Model Exchange

    bool derivatives_along(double t_s, const double* x, const double* seed, double* out) const override {
        return hnav_filter_derivative_along(object_, t_s, x, seed, out) == HNAV_OK;
    }
    bool jump(double t_s, double* x, bool* changed, Message* why) override {
        if (memory_.was_realigned != 0) {
            get_states(x);
            memory_.was_realigned = 0;
            *changed = true;
        }
        return Base::jump(t_s, x, changed, why);
    }
    void rows_along(const double* seed, double* rows) const override { out_.along(object_, seed, rows); }

private:
    static constexpr std::uint64_t judged_corrections = 100;
    static const char* name_of(int s, bool counted) { return counted ? Inputs::counters[s] : Inputs::periods[s]; }

    hnav_status push(int s, double t_s, const double* value) {
        switch (s) {
        case HNAV_SENSOR_GYRO: memory_.units.take_rate(t_s, value); return hnav_filter_push_gyro(object_, t_s, value);
        case HNAV_SENSOR_ACCEL: memory_.units.take_force(value); return hnav_filter_push_accel(object_, t_s, value);
        case HNAV_SENSOR_MAG: memory_.field_unit.take(value); return hnav_filter_push_mag(object_, t_s, value);
        case HNAV_SENSOR_HEADING: return hnav_filter_push_heading(object_, t_s, value[0], value[1]);
        default: return hnav_filter_push_speed(object_, t_s, value[0], value[1]);
        }
    }

    Inputs in_{};
    FilterOutputs out_;
};

} // namespace hnav::fmu
