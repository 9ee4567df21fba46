// The Ins FMU: position, velocity and attitude, aligned from any heading.
#include "adapter/library_model.hpp"
#include "adapter/sampled_inputs.hpp"
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
};

class InsModel final : public LibraryModel<StatelessModel, InsCalls, InsMemory> {
public:
    void describe(Table& table) override {
        table.add(rows::time());
        in_.describe(table);
        out_.describe(table);
    }

    bool initialise(const double* values, double start_s, bool, Message* why) override {
        const hnav_preset_info* preset = hnav_ins_preset_info(static_cast<std::int32_t>(values[in_.preset]));
        hnav_ins_options options = hnav_ins_defaults(static_cast<hnav_ins_preset>(preset->value));
        take_options(hnav_ins_option, in_.options, values, &options);
        for (int s = 0; s < ins_inputs; ++s)
            if (!check_period(InsInputs::periods[s], values[in_.sensor[s].period], why)) return false;
        if (!make(why, hnav_ins_create, &options)) return false;
        memory_.reset_level = values[in_.reset];
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

    double next_sample_s(const double*) const override { return memory_.sampled.next_s(); }

    bool can_hold() const override { return true; }
    bool samples_inside() const override { return memory_.sampled.hold(); }

    Lost lost() const override {
        return memory_.sampled.lost([](int s, bool counted) { return counted ? InsInputs::counters[s] : InsInputs::periods[s]; });
    }

    bool advance(double t_s, Message* why) override { return done(hnav_ins_advance(object_, t_s), why); }
    // Model Exchange: between events nothing is shown, so that an event brings the filter to its time.
    bool jump(double t_s, double*, bool*, Message* why) override { return advance(t_s, why); }

    void refresh(double* values, unsigned groups) override { out_.refresh(object_, groups, memory_.sampled.missed, values); }

private:
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
        default: status = hnav_ins_push_heading(object_, t_s, value[0], value[1]); break;
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
    Experiment{0.01, 60}, States{0, 0}};
Model* make_model() { return new InsModel; }

} // namespace hnav::fmu
