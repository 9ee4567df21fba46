// The Ins FMU: position, velocity and attitude, aligned from any heading.
#include "adapter/library_model.hpp"
#include "adapter/sampled_inputs.hpp"
#include "adapter/state_rows.hpp"
#include "ins/inputs.hpp"
#include "ins/outputs.hpp"

namespace hnav::fmu {
namespace {

using InsCalls = LibraryObject<hnav_ins, hnav_ins_destroy, hnav_ins_message, hnav_ins_state_size, hnav_ins_save, hnav_ins_load>;

// What was seen of the inputs so far.
struct InsMemory {
    SampledInputs<ins_inputs> sampled;
    double reset_level;
    double force[3]; // of the newest sample of the accelerometer
    double has_force;
    double was_reset; // in Model Exchange: the importer's states are still to be
    double model_exchange;
};

class InsModel final : public LibraryModel<Model, InsCalls, InsMemory> {
public:
    void describe(Table& table) override {
        table.add(rows::time());
        in_.describe(table);
        out_.describe(table);
        StateRows::add_to(table, describe_states);
    }

    bool initialise(const double* values, double start_s, bool model_exchange, Message* why) override {
        const hnav_preset_info* preset = hnav_ins_preset_info(static_cast<std::int32_t>(values[in_.preset]));
        hnav_ins_options options = hnav_ins_defaults(static_cast<hnav_ins_preset>(preset->value));
        take_options(hnav_ins_option, in_.options, values, &options);
        for (int s = 0; s < ins_inputs; ++s)
            if (!check_period(InsInputs::periods[s], values[in_.sensor[s].period], why)) return false;
        if (!make(why, hnav_ins_create, &options)) return false;
        memory_.reset_level = values[in_.reset];
        memory_.model_exchange = model_exchange;
        for (int s = 0; s < ins_inputs; ++s)
            memory_.sampled.clock[s] = {start_s, values[in_.sensor[s].period], values[in_.sampling_mode], 0, 0};
        return true;
    }

    // ------------------------------------------------------------------------------------------------ samples

    bool take_samples(double* values, double t_s) override {
        bool taken = false;
        if (rising(values[in_.reset], &memory_.reset_level)) {
            hnav_ins_reset(object_);
            memory_.has_force = 0;
            memory_.was_reset = memory_.model_exchange;
            taken = true;
        }
        for (int s = 0; s < ins_inputs; ++s) {
            const InsInputs::Sensor& in = in_.sensor[s];
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
        if (memory_.model_exchange != 0) hnav_ins_next_event_s(object_, &next);
        return std::fmin(next, memory_.sampled.next_s());
    }

    bool can_hold() const override { return true; }
    bool samples_inside() const override { return memory_.sampled.hold(); }

    Lost lost() const override {
        return memory_.sampled.lost([](int s, bool counted) { return counted ? InsInputs::counters[s] : InsInputs::periods[s]; });
    }

    bool advance(double t_s, Message* why) override { return done(hnav_ins_advance(object_, t_s), why); }

    void refresh(double* values, unsigned groups) override { out_.refresh(object_, groups, memory_.sampled.missed, values); }

    // ------------------------------------------------------------------------------------------------ Model Exchange

    void get_states(double* x) const override { hnav_ins_get_x(object_, x); }
    void get_nominals(double* nominals) const override { hnav_ins_nominal_x(object_, nominals); }
    bool derivatives(double t_s, const double* x, double* dx) const override {
        return hnav_ins_derivative(object_, t_s, x, dx) == HNAV_OK;
    }
    bool derivatives_along(double t_s, const double* x, const double* seed, double* out) const override {
        return hnav_ins_derivative_along(object_, t_s, x, seed, out) == HNAV_OK;
    }
    bool jump(double t_s, double* x, bool* changed, Message* why) override {
        if (memory_.was_reset != 0) hnav_ins_get_x(object_, x);
        *changed = memory_.was_reset != 0;
        memory_.was_reset = 0;
        double next_s;
        hnav_ins_next_event_s(object_, &next_s);
        if (next_s > t_s) return true;
        *changed = true;
        return done(hnav_ins_jump(object_, t_s, x, x), why);
    }
    void show(double t_s, const double* x) override { hnav_ins_show(object_, t_s, x); }
    void rows_along(const double* seed, double* rows) const override { out_.along(object_, seed, rows); }

private:
    // While the heading is unknown the axes are turned about the vertical by what is unknown.
    static void describe_states(StateRows& states) {
        for (const char* name : {"state.displacement[1]", "state.displacement[2]", "state.displacement[3]"})
            states.add(name, "m", 0, DependsOn::first_states,
                       "Displacement from an anchor near the body, in its axes north-east-down");
        for (const char* name : {"state.velocity[1]", "state.velocity[2]", "state.velocity[3]"})
            states.add(name, "m/s", 0, DependsOn::all_states, "Velocity over the ground in the axes of the anchor");
        states.add_attitude("Attitude, body to the axes of the anchor", DependsOn::all_states);
    }

    // What is no sample is refused and counted by the filter; that is no reason to stop a simulation.
    void push(int s, double t_s, const double* value) {
        hnav_status status = HNAV_OK;
        switch (s) {
        case in_accel:
            std::memcpy(memory_.force, value, sizeof memory_.force);
            memory_.has_force = 1;
            break;
        // A rate takes the newest force along: the library wants both at once.
        case in_gyro:
            if (memory_.has_force != 0) status = hnav_ins_push_imu(object_, t_s, value, memory_.force);
            break;
        case in_position: status = hnav_ins_push_position(object_, t_s, value[0], value[1], value[2], value + 3); break;
        case in_velocity: status = hnav_ins_push_velocity(object_, t_s, value, value + 3); break;
        case in_pressure: status = hnav_ins_push_pressure(object_, t_s, value[0], value[1]); break;
        case in_speed: status = hnav_ins_push_speed(object_, t_s, value[0], value[1]); break;
        case in_heading: status = hnav_ins_push_heading(object_, t_s, value[0], value[1]); break;
        default: status = hnav_ins_push_mag(object_, t_s, value); break;
        }
        if (status == HNAV_ERROR_QUEUE_FULL) memory_.sampled.missed += 1;
    }

    InsInputs in_{};
    InsOutputs out_;
};

} // namespace

constexpr ModelInfo model_info = {
    HNAV_FMU_NAME,
    "Position, velocity and attitude from an inertial sensor, satellites, pressure and wheels, aligned from "
    "any heading, in motion or at rest, without a magnetometer",
    Experiment{0.01, 60}, States{10, 6}};
Model* make_model() { return new InsModel; }

} // namespace hnav::fmu
