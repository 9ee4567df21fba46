// The InsErrorFilter FMU: the filter for coloured INS errors, made for one aircraft.
#include "adapter/model.hpp"
#include "ins_error_filter/variables.hpp"

#include <new>

namespace hnav::fmu {
namespace {

using aircraft::nu, aircraft::nx;

class InsErrorFilter final : public StatelessModel {
public:
    static Model* make() {
        void* memory = std::malloc(sizeof(InsErrorFilter));
        return memory ? new (memory) InsErrorFilter : nullptr;
    }

    const ModelInfo& info() const override {
        static constexpr ModelInfo info = {
            HNAV_FMU_NAME,
            "Filter for time-correlated INS errors (MDKF, AMDKF, differenced, augmented, plain) of the aircraft " AIRCRAFT_TITLE,
            aircraft::interval_s,
            20,
            0,
            0,
            true};
        return info;
    }

    void describe(Table& table) override { at_.describe(table); }

    bool initialise(double* values, const double*, double start_s, bool, Message* why) override {
        hnav_ins_error_options options = hnav_ins_error_defaults();
        for (int k = 0; const hnav_option_info* option = hnav_ins_error_option(k); ++k)
            set_option(*option, &options, 0, values[at_.options + k]);
        const hnav_aircraft_model model = at_.parameters.model(values);
        const hnav_aircraft_options plant_options = at_.parameters.options(values);
        clear();
        // The plant knows what its filter has to assume.
        hnav_aircraft* plant;
        if (hnav_aircraft_create(&plant, &plant_options, &model, why->text, sizeof why->text) != HNAV_OK) return false;
        hnav_ins_error_model filter_model;
        hnav_aircraft_filter_model(plant, &filter_model);
        const hnav_status status = hnav_ins_error_filter_create(&filter_, &options, &filter_model, why->text, sizeof why->text);
        hnav_aircraft_destroy(plant);
        if (status != HNAV_OK) return false;
        memory_ = {};
        memory_.clock.start_s = start_s;
        memory_.newest_s = memory_.before_s = start_s;
        memory_.reset_level = values[at_.reset];
        return true;
    }

    // ------------------------------------------------------------------------------------------------ samples

    // A step of the filter takes no time, so that nothing is left for advance and jump.
    bool take_samples(double* values, double t_s) override {
        bool taken = false;
        if (rising(values[at_.reset], &memory_.reset_level)) {
            hnav_ins_error_filter_reset(filter_);
            memory_.samples = memory_.missed = memory_.non_finite = memory_.failed = 0;
            taken = true;
        }
        const bool counted = values[at_.sampling_mode] == counter;
        double lost = 0;
        const bool due = counted ? memory_.clock.counter_changed(values[at_.sample], &lost)
                                 : memory_.clock.period_elapsed(t_s, values[at_.parameters.interval], &lost);
        if (!due) return taken;
        const double stamp_s = counted ? values[at_.t_meas] : t_s;

        for (int j = 0; j < nu; ++j) {
            const double u = values[at_.u + j];
            if (std::isfinite(u)) memory_.u[j] = u;
            else memory_.non_finite += 1;
        }
        double z[nx];
        for (int i = 0; i < nx; ++i) {
            z[i] = values[at_.present + i] != 0 ? values[at_.z + i] : NAN;
            if (std::isinf(z[i])) {
                z[i] = NAN;
                memory_.non_finite += 1;
            }
        }
        // One step of the model is one interval: samples that were lost pass as steps without a measurement. The first
        // sample meets the prior, whenever it comes.
        hnav_ins_error_status status;
        hnav_ins_error_filter_get_status(filter_, &status);
        if (status.steps > 0) {
            memory_.missed += lost;
            double nothing[nx];
            for (double& missing : nothing) missing = NAN;
            // After so many the start is forgotten, and a counter that jumps by millions must not stop the simulation.
            for (double k = std::fmin(lost, 10000); k > 0; --k) step(nothing, stamp_s - k * values[at_.parameters.interval]);
        }
        step(z, stamp_s);
        memory_.samples += 1;
        return true;
    }

    double next_sample_s(const double* values) const override {
        if (values[at_.sampling_mode] == counter) return no_bound;
        return memory_.clock.next_s(values[at_.parameters.interval]);
    }

    bool advance(double, Message*) override { return true; }

    // ------------------------------------------------------------------------------------------------ outputs

    void refresh(double* values, unsigned groups) override {
        hnav_ins_error_status status;
        hnav_ins_error_filter_get_status(filter_, &status);
        double estimate[nx];
        hnav_ins_error_filter_estimate(filter_, estimate, values + at_.sigma);
        if (groups & estimate_group) {
            std::memcpy(values + at_.estimate, estimate, sizeof estimate);
            values[at_.post_t] = status.shown_step + 1 < status.steps ? memory_.before_s : memory_.newest_s;
        }
        if (groups & lambda_group) {
            hnav_ins_error_filter_coloured_error(filter_, values + at_.lambda, values + at_.lambda_sigma,
                                                 values + at_.compensated);
            // Without a measurement: every channel reads one state.
            for (int i = 0; i < nx; ++i) {
                double &lambda = values[at_.lambda + i], &compensated = values[at_.compensated + i];
                if (std::isnan(lambda)) lambda = 0;
                if (std::isnan(compensated)) compensated = estimate[i];
            }
        }
        if (groups & innovation_group) refresh_innovation(values);
        if (groups & noise_group) hnav_ins_error_filter_noise(filter_, values + at_.noise_scale, values + at_.fault_probability);
        if (groups & status_group) {
            hnav_ins_error_filter_separability(filter_, values + at_.separability);
            values[at_.samples] = memory_.samples;
            values[at_.missed] = memory_.missed;
            values[at_.non_finite] = memory_.non_finite;
            values[at_.failed] = memory_.failed;
        }
    }

    // ------------------------------------------------------------------------------------------------ complete state

    std::size_t state_size() const override {
        std::size_t bytes = 0;
        hnav_ins_error_filter_state_size(filter_, &bytes);
        return sizeof memory_ + bytes;
    }
    void save(void* buffer) const override {
        std::memcpy(buffer, &memory_, sizeof memory_);
        hnav_ins_error_filter_save(filter_, static_cast<char*>(buffer) + sizeof memory_, state_size() - sizeof memory_);
    }
    bool load(const void* buffer, std::size_t bytes) override {
        if (bytes != state_size()) return false;
        std::memcpy(&memory_, buffer, sizeof memory_);
        return hnav_ins_error_filter_load(filter_, static_cast<const char*>(buffer) + sizeof memory_, bytes - sizeof memory_) ==
               HNAV_OK;
    }

    void clear() override {
        hnav_ins_error_filter_destroy(filter_);
        filter_ = nullptr;
    }
    void destroy() override {
        clear();
        this->~InsErrorFilter();
        std::free(this);
    }

private:
    InsErrorFilter() = default;
    ~InsErrorFilter() = default;

    void step(const double* z, double stamp_s) {
        // A step without an answer leaves the filter as it was; the model moves on without the measurement.
        if (hnav_ins_error_filter_step(filter_, memory_.u, z, nullptr) != HNAV_OK) {
            memory_.failed += 1;
            double nothing[nx];
            for (double& missing : nothing) missing = NAN;
            hnav_ins_error_filter_step(filter_, memory_.u, nothing, nullptr);
        }
        memory_.before_s = memory_.newest_s;
        memory_.newest_s = stamp_s;
    }

    void refresh_innovation(double* values) const {
        double* innovation = values + at_.innovation;
        double* nis = values + at_.nis;
        if (hnav_ins_error_filter_innovation(filter_, innovation, nullptr, nis) != HNAV_OK) {
            std::memset(innovation, 0, nx * sizeof(double)); // none yet
            *nis = 0;
        }
        for (int i = 0; i < nx; ++i)
            if (std::isnan(innovation[i])) innovation[i] = 0;
        if (std::isnan(*nis)) *nis = 0;
    }

    // What was seen of the inputs so far. Eight-byte numbers, saved as they are.
    struct Memory {
        SampleClock clock;
        double reset_level;
        double newest_s, before_s; // times of the two newest samples
        double u[nu];
        double samples, missed, non_finite, failed;
    };

    Places at_{};
    Memory memory_{};
    hnav_ins_error_filter* filter_ = nullptr;
};

} // namespace

Model* make_model() { return InsErrorFilter::make(); }

} // namespace hnav::fmu
