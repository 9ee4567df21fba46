// The InsErrorFilter FMU: the filter for coloured INS errors of one aircraft.
#include "adapter/library_model.hpp"
#include "ins_error_filter/variables.hpp"

namespace hnav::fmu {
namespace {

using FilterCalls = LibraryObject<hnav_ins_error_filter, hnav_ins_error_filter_destroy, hnav_ins_error_filter_message,
                                  hnav_ins_error_filter_state_size, hnav_ins_error_filter_save, hnav_ins_error_filter_load>;

// The inputs of earlier communication points.
struct FilterMemory {
    SamplingClock clock;
    double reset_level;
    double newest_s, before_s; // times of the two newest samples
    double u[nu];
    double samples, missed, non_finite, failed;
    double sparse; // intervals without a measurement within longer steps, in automatic mode
    double mistaken; // 1: the counter changed after samples at the period
};

class InsErrorFilter final : public LibraryModel<StatelessModel, FilterCalls, FilterMemory> {
public:
    void describe(Table& table) override { at_.describe(table); }

    bool initialise(const double* values, double start_s, bool, Message* why) override {
        hnav_ins_error_options options = hnav_ins_error_defaults();
        take_options(option_of<option_list>, at_.options, values, &options);
        const hnav_aircraft_model model = at_.parameters.model(values);
        const hnav_aircraft_options plant_options = at_.parameters.options(values);
        clear();
        // The plant's parameters are those that its filter has to assume.
        hnav_aircraft* plant;
        if (hnav_aircraft_create(&plant, &plant_options, &model, why->text, sizeof why->text) != HNAV_OK) return false;
        auto filter_model = hnav_sized<hnav_ins_error_model>();
        hnav_aircraft_filter_model(plant, &filter_model);
        const bool made = make(why, hnav_ins_error_filter_create, &options, &filter_model);
        hnav_aircraft_destroy(plant);
        if (!made) return false;
        memory_.clock = {start_s, model.interval_s, values[at_.sampling_mode], 0, 0};
        memory_.newest_s = memory_.before_s = start_s;
        return true;
    }

    void begin(const double* values) override { memory_.reset_level = values[at_.reset]; }

    // ------------------------------------------------------------------------------------------------ samples

    // A filter step happens at one instant, so advance and jump have nothing to do.
    bool take_samples(double* values, double t_s) override {
        bool taken = false;
        const bool mistaken = memory_.clock.begins_to_count(values[at_.sample]);
        if (mistaken) {
            memory_.mistaken = 1;
            memory_.clock.by_period = 0;
        }
        if (rising(values[at_.reset], &memory_.reset_level) || mistaken) {
            hnav_ins_error_filter_reset(object_);
            memory_.samples = memory_.missed = memory_.sparse = memory_.non_finite = memory_.failed = 0;
            taken = true;
        }
        NewSample sample;
        if (!memory_.clock.take(t_s, values[at_.sample], values[at_.t_meas], &sample)) return taken;
        memory_.clock.by_period = 1;
        take_controls(values + at_.u);
        double z[nx];
        for (int i = 0; i < nx; ++i) {
            z[i] = values[at_.present + i] != 0 ? values[at_.z + i] : NAN;
            if (std::isinf(z[i])) {
                z[i] = NAN;
                memory_.non_finite += 1;
            }
        }
        pass_lost(sample);
        step(z, sample.t_s);
        memory_.samples += 1;
        return true;
    }

    double next_sample_s(const double*) const override { return memory_.clock.next_s(); }

    bool can_hold() const override { return true; }
    double next_sample_inside_s(double end_s) const override { return memory_.clock.next_inside_s(end_s); }
    const char* mistaken() const override { return memory_.mistaken != 0 ? "z.sample" : nullptr; }

    Lost lost() const override {
        if (memory_.missed == 0 && memory_.sparse == 0) return {};
        if (memory_.clock.mode == counter) return {"z.sample", 0};
        return {"interval", memory_.clock.period_s, memory_.missed == 0};
    }

    bool advance(double, Message*) override { return true; }

    // ------------------------------------------------------------------------------------------------ outputs

    void refresh(double* values, unsigned groups) override {
        at_.estimate.refresh(groups, values, [this](Estimate* e) {
            const hnav_ins_error_info s = info();
            hnav_ins_error_filter_estimate(object_, e->x, e->sigma);
            e->t_s = s.shown_step + 1 < s.steps ? memory_.before_s : memory_.newest_s;
        });
        at_.lambda.refresh(groups, values, [this](ColouredError* e) { read_coloured_error(e); });
        at_.innovation.refresh(groups, values, [this](Innovation* i) { read_innovation(i); });
        at_.noise.refresh(groups, values, [this](Noise* n) {
            hnav_ins_error_filter_noise(object_, n->scale, nullptr);
            hnav_ins_error_filter_faults(object_, n->fault_probability, n->bias_fault_probability, &n->process_fault_probability);
        });
        at_.counts.refresh(groups, values, [this](Counts* c) {
            *c = {0, memory_.samples, memory_.missed, memory_.non_finite, memory_.failed};
            hnav_ins_error_filter_separability(object_, &c->separability);
        });
    }

private:
    hnav_ins_error_info info() const {
        auto s = hnav_sized<hnav_ins_error_info>();
        hnav_ins_error_filter_info(object_, &s);
        return s;
    }

    static void no_measurement(double* z) {
        for (int i = 0; i < nx; ++i) z[i] = NAN;
    }

    // A control of NaN leaves the previous one in force.
    void take_controls(const double* u) {
        for (int j = 0; j < nu; ++j)
            if (std::isfinite(u[j])) memory_.u[j] = u[j];
            else memory_.non_finite += 1;
    }

    // A step of the model is one interval: lost samples are steps without a measurement. The first sample corrects the prior,
    // whenever it arrives.
    void pass_lost(const NewSample& sample) {
        if (info().steps == 0) return;
        (memory_.clock.mode == automatic ? memory_.sparse : memory_.missed) += sample.lost;
        double nothing[nx];
        no_measurement(nothing);
        // After so many steps the start no longer matters, and a counter that jumps by millions must not block the
        // simulation.
        for (double k = std::fmin(sample.lost, 10000); k > 0; --k) step(nothing, sample.t_s - k * memory_.clock.period_s);
    }

    void step(const double* z, double stamp_s) {
        // A failed step leaves the filter unchanged; the model then propagates without the measurement.
        if (hnav_ins_error_filter_step(object_, memory_.u, z, nullptr) != HNAV_OK) {
            memory_.failed += 1;
            double nothing[nx];
            no_measurement(nothing);
            hnav_ins_error_filter_step(object_, memory_.u, nothing, nullptr);
        }
        memory_.before_s = memory_.newest_s;
        memory_.newest_s = stamp_s;
    }

    void read_coloured_error(ColouredError* e) const {
        double estimate[nx], sigma[nx];
        hnav_ins_error_filter_estimate(object_, estimate, sigma);
        hnav_ins_error_filter_coloured_error(object_, e->lambda, e->sigma, e->compensated);
        // Without a measurement: every channel reads one state.
        for (int i = 0; i < nx; ++i) {
            if (std::isnan(e->lambda[i])) e->lambda[i] = 0;
            if (std::isnan(e->compensated[i])) e->compensated[i] = estimate[i];
        }
    }

    void read_innovation(Innovation* i) const {
        *i = {}; // none yet
        hnav_ins_error_filter_innovation(object_, i->value, nullptr, &i->nis);
        for (double& value : i->value)
            if (std::isnan(value)) value = 0;
        if (std::isnan(i->nis)) i->nis = 0;
    }

    Variables at_{};
};

} // namespace

constexpr ModelInfo model_info = {HNAV_FMU_NAME,
                                  "Filter for time-correlated INS errors (MDKF, AMDKF, differenced, augmented, plain) "
                                  "of the aircraft " AIRCRAFT_TITLE,
                                  Experiment{aircraft::interval_s, 20}};
Model* make_model() { return new InsErrorFilter; }

} // namespace hnav::fmu
