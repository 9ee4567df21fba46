// The AircraftIns FMU: a linear aircraft and the readings of an INS with coloured errors.
#include "adapter/library_model.hpp"
#include "aircraft_ins/variables.hpp"

namespace hnav::fmu {
namespace {

using AircraftCalls = LibraryObject<hnav_aircraft, hnav_aircraft_destroy, hnav_aircraft_message, hnav_aircraft_state_size,
                                    hnav_aircraft_save, hnav_aircraft_load>;

// The inputs of earlier communication points.
struct AircraftMemory {
    SamplingClock clock;         // of the plant's own samples
    double taken_for, taken_s;   // sample and time of the newest command
    double command[nu];
    double non_finite;
};

class AircraftIns final : public LibraryModel<StatelessModel, AircraftCalls, AircraftMemory> {
public:
    void describe(Table& table) override { at_.describe(table); }

    bool initialise(const double* values, double start_s, bool, Message* why) override {
        hnav_aircraft_model model = at_.parameters.model(values);
        model.gravity_error = {values + at_.gravity_sigma, values + at_.gravity_time_constant};
        hnav_square_wave commands[nu];
        for (int j = 0; j < nu; ++j) commands[j] = {values[at_.amplitude + j], values[at_.period + j], values[at_.phase + j]};
        model.commands = commands;
        hnav_noise_fault faults[nx];
        for (int i = 0; i < nx; ++i)
            faults[i] = {values[at_.fault_start + i], values[at_.fault_stop + i], values[at_.fault_factor + i]};
        model.faults = faults;
        hnav_aircraft_options options = at_.parameters.options(values);
        options.seed = static_cast<std::uint64_t>(values[at_.seed]);
        if (!make(why, hnav_aircraft_create, &options, &model)) return false;
        memory_.clock = {start_s, model.interval_s, periodic, 0, 1}; // sample 0 exists from the start
        memory_.taken_for = -1;
        return true;
    }

    // ------------------------------------------------------------------------------------------------ samples

    // The command of an interval is that of the first communication point at or after its first sample, so smaller
    // communication steps change nothing. At that point the last value counts.
    bool take_samples(double* values, double t_s) override {
        if (!fly_to(t_s, nullptr)) return false; // said by what follows
        const double k = memory_.clock.due - 1;
        if (memory_.taken_for == k && memory_.taken_s != t_s) return false;
        memory_.taken_for = k;
        memory_.taken_s = t_s;
        for (int j = 0; j < nu; ++j) {
            const double command = values[at_.command + j];
            if (std::isfinite(command)) memory_.command[j] = command;
            else memory_.non_finite += 1;
        }
        return true;
    }

    double next_sample_s(const double*) const override { return memory_.clock.next_s(); }

    bool advance(double t_s, Message* why) override { return fly_to(t_s, why); }
    bool jump(double t_s, double*, bool*, Message* why) override { return fly_to(t_s, why); }

    // ------------------------------------------------------------------------------------------------ outputs

    void refresh(double* values, unsigned groups) override {
        at_.sample.refresh(groups, values, [this](Sample* sample) {
            auto s = hnav_sized<hnav_aircraft_sample>();
            s.x = sample->x;
            s.lambda = sample->lambda;
            s.z = sample->z;
            s.u = sample->u;
            s.noise_factor = sample->fault;
            hnav_aircraft_get_sample(object_, &s);
            for (double& factor : sample->fault) factor = factor != 1;
            sample->number = static_cast<double>(s.k) + 1;
            sample->t_s = memory_.clock.start_s + s.t_s;
        });
        at_.counts.refresh(groups, values, [this](Counts* c) { c->non_finite = memory_.non_finite; });
    }

private:
    // Computes all samples up to t_s, so that the end of a step shows the sample that is due there. False: too many samples.
    bool fly_to(double t_s, Message* why) {
        SamplingClock clock = memory_.clock;
        double more; // beside the one
        if (!clock.period_elapsed(t_s, &more)) return true;
        if (more >= max_samples_inside) {
            if (why)
                std::snprintf(why->text, sizeof why->text,
                              "a step to %g s holds more than %.0f samples at interval = %g s: take a shorter one", t_s,
                              max_samples_inside, clock.period_s);
            return false;
        }
        memory_.clock = clock;
        for (double k = 0; k <= more; ++k) hnav_aircraft_step(object_, memory_.command);
        return true;
    }

    Variables at_{};
};

} // namespace

constexpr ModelInfo model_info = {HNAV_FMU_NAME,
                                  "Linear aircraft read by an INS with time-correlated errors and noise faults: " AIRCRAFT_TITLE,
                                  Experiment{aircraft::interval_s, 20}};
Model* make_model() { return new AircraftIns; }

} // namespace hnav::fmu
