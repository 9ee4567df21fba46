// The Ins FMU: position, velocity and attitude, aligned from any heading.
#include "adapter/filter_calls.hpp"
#include "adapter/inertial_model.hpp"
#include "adapter/state_rows.hpp"
#include "adapter/unit_check.hpp"
#include "ins/inputs.hpp"
#include "ins/outputs.hpp"

namespace hnav::fmu {
namespace {

using InsCalls = FilterCalls<hnav_filter_state_size, hnav_filter_save, hnav_filter_load>;

struct InsMemory : InertialMemory<ins_inputs> {
    double force[3]; // of the newest sample of the accelerometer
    double has_force;
    UnitCheck units;
};

class InsModel final : public InertialModel<InsCalls, InsMemory, hnav_ins_options, in_gyro, hnav_ins_create> {
public:
    void describe(Table& table) override {
        table.add(rows::time());
        in_.describe(table);
        out_.describe(table);
        StateRows::add_to(table, describe_states);
    }

    bool initialise(const double* values, double start_s, bool model_exchange, Message* why) override {
        const hnav_preset_info* preset = hnav_preset_of("ins", static_cast<std::int32_t>(values[in_.preset]));
        hnav_ins_options options = hnav_ins_defaults(static_cast<hnav_ins_preset>(preset->value));
        take_options(option_of<option_list>, in_.options, values, &options);
        if (!make_with(options, mode_in(values, in_.sampling_mode), why)) return false;
        memory_.model_exchange = model_exchange;
        return memory_.sampled.start(in_.sensor, values, start_s, in_.sampling_mode, InsInputs::periods, why);
    }

    void begin(const double* values) override { memory_.reset_level = values[in_.reset]; }

    // ------------------------------------------------------------------------------------------------ samples

    bool take_samples(double* values, double t_s) override {
        const bool begun = begins_to_count(in_.sensor, values);
        const bool was_reset = take_reset(values[in_.reset]) || begun;
        if (was_reset) memory_.has_force = 0;
        const bool taken = memory_.sampled.push_new(
            in_.sensor, values, t_s, [this](int s, double stamp_s, const double* value) { pushed(push(s, stamp_s, value)); });
        return was_reset || taken;
    }

    Lost lost() const override { return memory_.sampled.lost(name_of); }
    Lost repeated() const override { return memory_.sampled.repeated(name_of); }
    const char* mistaken() const override { return memory_.sampled.mistaken(name_of); }

    const char* implausible() const override { return memory_.units.finding(); }

    bool advance(double t_s, Message* why) override { return done(hnav_filter_advance(object_, t_s), why); }

    void refresh(double* values, unsigned groups) override { out_.refresh(object_, groups, memory_.sampled.missed, values); }

    // ------------------------------------------------------------------------------------------------ Model Exchange

    bool derivatives_along(double t_s, const double* x, const double* seed, double* out) const override {
        return hnav_filter_derivative_along(object_, t_s, x, seed, out) == HNAV_OK;
    }
    void rows_along(const double* seed, double* rows) const override { out_.along(object_, seed, rows); }

private:
    static const char* name_of(int s, bool counted) { return counted ? InsInputs::counters[s] : InsInputs::periods[s]; }

    // While the heading is unknown the navigation axes are turned about the vertical by the unknown angle.
    static void describe_states(StateRows& states) {
        for (const char* name : {"state.displacement[1]", "state.displacement[2]", "state.displacement[3]"})
            states.add(name, "m", 0, DependsOn::first_states,
                       "Displacement from an anchor near the body, in its axes north-east-down");
        for (const char* name : {"state.velocity[1]", "state.velocity[2]", "state.velocity[3]"})
            states.add(name, "m/s", 0, DependsOn::all_states, "Velocity over the ground in the axes of the anchor");
        states.add_attitude("Attitude, body to the axes of the anchor", DependsOn::all_states);
    }

    hnav_status push(int s, double t_s, const double* value) {
        switch (s) {
        case in_accel:
            std::memcpy(memory_.force, value, sizeof memory_.force);
            memory_.has_force = 1;
            memory_.units.take_force(value);
            return HNAV_OK;
        // A rate is pushed with the newest force: the library takes both at once.
        case in_gyro:
            memory_.units.take_rate(t_s, value);
            return memory_.has_force != 0 ? hnav_filter_push_imu(object_, t_s, value, memory_.force) : HNAV_OK;
        case in_position: return hnav_filter_push_position(object_, t_s, value[0], value[1], value[2], value + 3);
        case in_velocity: return hnav_filter_push_velocity(object_, t_s, value, value + 3);
        case in_pressure: return hnav_filter_push_pressure(object_, t_s, value[0], value[1]);
        case in_speed: return hnav_filter_push_speed(object_, t_s, value[0], value[1]);
        case in_heading: return hnav_filter_push_heading(object_, t_s, value[0], value[1]);
        default: return hnav_filter_push_mag(object_, t_s, value);
        }
    }

    InsInputs in_{};
    InsOutputs out_;
};

} // namespace

constexpr ModelInfo model_info = {
    HNAV_FMU_NAME,
    "Position, velocity and attitude from an inertial sensor, satellites, pressure and wheels, aligned from "
    "any heading, in motion or at rest, without a magnetometer",
    Experiment{0.01, 60},
    States{10, 6},
    true,
    true,
    false,
    HNAV_FMU_CLOCKS != 0};
Model* make_model() { return new InsModel; }

} // namespace hnav::fmu
