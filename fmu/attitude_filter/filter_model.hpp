// An attitude filter of the C API behind the adapter's Model. Kind is described in kind.hpp.
#pragma once

#include "adapter/library_model.hpp"
#include "adapter/sampled_inputs.hpp"
#include "attitude_filter/inputs.hpp"
#include "attitude_filter/kind.hpp"
#include "attitude_filter/outputs.hpp"

namespace hnav::fmu {

using FilterCalls = LibraryObject<hnav_filter, hnav_filter_destroy, hnav_filter_message, hnav_filter_snapshot_size,
                                  hnav_filter_take_snapshot, hnav_filter_restore_snapshot>;

// What was seen of the inputs so far.
struct FilterMemory {
    double start_s;
    SampledInputs<Inputs::sensors> sampled;
    double reset_level, realign_level;
    double command; // that Model Exchange has still to apply to the importer's states
    double model_exchange;
    double now_s;  // of the last step
    double behind; // 1: outputs that look ahead to now_s are still to be brought there
};

template <class Kind>
class FilterModel final : public LibraryModel<Model, FilterCalls, FilterMemory> {
public:
    void describe(Table& table) override {
        table.add(rows::time());
        in_.describe<Kind>(table);
        out_.describe<Kind>(table);
        StateRows::add_to(table, Kind::describe_states);
    }

    bool initialise(const double* values, double start_s, bool model_exchange, Message* why) override {
        typename Kind::Options options = Kind::defaults(in_.preset < 0 ? 0 : static_cast<int>(values[in_.preset]));
        take_options(Kind::option, in_.options, values, &options);
        if (!Kind::reholds && model_exchange && options.gyro_hold == HNAV_GYRO_HOLD_BACKWARD) {
            std::snprintf(why->text, sizeof why->text,
                          "gyro_hold = backward needs Co-Simulation: an integrator outside cannot know a rate before its sample");
            return false;
        }
        for (int s = 0; s < Inputs::sensors; ++s)
            if (!check_period(Inputs::periods[s], values[in_.sensor[s].period], why)) return false;
        if (!make(why, Kind::create, &options)) return false;
        memory_.start_s = start_s;
        memory_.model_exchange = model_exchange;
        memory_.reset_level = values[in_.reset];
        memory_.realign_level = values[in_.realign];
        for (int s = 0; s < Inputs::sensors; ++s)
            memory_.sampled.clock[s] = {start_s, values[in_.sensor[s].period], values[in_.sampling_mode], 0, 0};
        return true;
    }

    // ------------------------------------------------------------------------------------------------ samples

    bool take_samples(double* values, double t_s) override {
        bool taken = false;
        if (rising(values[in_.reset], &memory_.reset_level)) {
            hnav_filter_reset(object_);
            memory_.command = command_reset;
            taken = true;
        }
        if (rising(values[in_.realign], &memory_.realign_level)) {
            hnav_filter_realign(object_);
            if (memory_.command != command_reset) memory_.command = command_realign;
            taken = true;
        }
        for (int s = 0; s < Inputs::sensors; ++s) {
            const Inputs::Sensor& in = in_.sensor[s];
            const bool valid = values[in.valid] != 0;
            NewSample sample;
            if (!memory_.sampled.take(s, t_s, valid, values[in.sample], values[in.t_meas], &sample)) continue;
            push(s, sample.t_s, values + in.value);
            taken = true;
        }
        return taken;
    }

    double next_sample_s(const double*) const override {
        double next = no_bound;
        // In Model Exchange a sample stamped later than it came waits for its time.
        if (memory_.model_exchange != 0) hnav_filter_next_event_s(object_, &next);
        return std::min(next, memory_.sampled.next_s());
    }

    bool can_hold() const override { return true; }
    bool samples_inside() const override { return memory_.sampled.hold(); }

    Lost lost() const override {
        return memory_.sampled.lost([](int s, bool counted) { return counted ? Inputs::counters[s] : Inputs::periods[s]; });
    }

    // A gamma that is infeasible from the first corrections on stays so.
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

    // The estimate alone: the look-ahead costs as much again, and not everybody reads it at every step.
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

    void get_states(double* x) const override { hnav_filter_get_x(object_, x); }
    void get_nominals(double* nominals) const override { hnav_filter_nominal_x(object_, nominals); }
    bool derivatives(double t_s, const double* x, double* dx) const override {
        return hnav_filter_derivative(object_, t_s, x, dx) == HNAV_OK;
    }
    bool derivatives_along(double t_s, const double* x, const double* seed, double* out) const override {
        return hnav_filter_derivative_along(object_, t_s, x, seed, out) == HNAV_OK;
    }
    bool jump(double t_s, double* x, bool* changed, Message* why) override {
        if (memory_.command != 0) {
            double replaced[Kind::info.states.count];
            hnav_filter_get_x(object_, replaced);
            if (memory_.command == command_realign) Kind::keep_on_realign(x, replaced);
            std::memcpy(x, replaced, sizeof replaced);
            memory_.command = 0;
            *changed = true;
        }
        double next_s;
        hnav_filter_next_event_s(object_, &next_s);
        if (next_s > t_s) return true;
        *changed = true;
        return done(hnav_filter_jump(object_, t_s, x, x), why);
    }
    void show(double t_s, const double* x) override { hnav_filter_show(object_, t_s, x); }
    void rows_along(const double* seed, double* rows) const override { out_.along(object_, seed, rows); }

private:
    static constexpr std::uint64_t judged_corrections = 100;
    enum Command { command_reset = 1, command_realign = 2 };

    // What is no sample is refused and counted by the filter; that is no reason to stop a simulation.
    void push(int s, double t_s, const double* value) {
        hnav_status status = HNAV_OK;
        switch (s) {
        case HNAV_SENSOR_GYRO: status = hnav_filter_push_gyro(object_, t_s, value); break;
        case HNAV_SENSOR_ACCEL: status = hnav_filter_push_accel(object_, t_s, value); break;
        case HNAV_SENSOR_MAG: status = hnav_filter_push_mag(object_, t_s, value); break;
        default: status = hnav_filter_push_heading(object_, t_s, value[0], value[1]); break;
        }
        if (status == HNAV_ERROR_QUEUE_FULL) memory_.sampled.missed += 1;
    }

    Inputs in_{};
    FilterOutputs out_;
};

} // namespace hnav::fmu
