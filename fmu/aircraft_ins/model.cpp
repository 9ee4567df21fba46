// The AircraftIns FMU: a linear aircraft and what an INS with coloured errors reads of it.
#include "adapter/model.hpp"
#include "aircraft_ins/variables.hpp"

#include <cstring>
#include <new>

namespace hnav::fmu {
namespace {

using aircraft::nu, aircraft::nx;

class AircraftIns final : public StatelessModel {
public:
    static Model* make() {
        void* memory = std::malloc(sizeof(AircraftIns));
        return memory ? new (memory) AircraftIns : nullptr;
    }

    const ModelInfo& info() const override {
        static constexpr ModelInfo info = {
            HNAV_FMU_NAME,
            "Linear aircraft read by an INS with time-correlated errors and noise faults: " AIRCRAFT_TITLE,
            aircraft::interval_s,
            20,
            0,
            0,
            true};
        return info;
    }

    void describe(Table& table) override { at_.describe(table); }

    bool initialise(double* values, const double*, double start_s, bool, Message* why) override {
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
        clear();
        if (hnav_aircraft_create(&plant_, &options, &model, why->text, sizeof why->text) != HNAV_OK) return false;
        memory_ = {};
        memory_.start_s = start_s;
        memory_.interval_s = model.interval_s;
        memory_.taken_for = -1;
        return true;
    }

    // ------------------------------------------------------------------------------------------------ samples

    // The command of an interval is that of the first point at or after its first sample, and of no later one: so finer
    // communication steps change nothing. At that point itself the last word counts.
    bool take_samples(double* values, double t_s) override {
        fly_to(t_s);
        const double k = sample().k;
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

    double next_sample_s(const double*) const override { return due_s(); }

    bool advance(double t_s, Message*) override {
        fly_to(t_s);
        return true;
    }

    // ------------------------------------------------------------------------------------------------ outputs

    void refresh(double* values, unsigned groups) override {
        values[at_.non_finite] = std::fmin(memory_.non_finite, 2147483647);
        if (!(groups & sample_group)) return;
        double noise_factor[nx];
        hnav_aircraft_sample s{};
        s.x = values + at_.truth;
        s.lambda = values + at_.lambda;
        s.z = values + at_.z;
        s.u = values + at_.u;
        s.noise_factor = noise_factor;
        hnav_aircraft_get_sample(plant_, &s);
        for (int i = 0; i < nx; ++i) values[at_.fault + i] = noise_factor[i] != 1;
        values[at_.sample] = std::fmin(static_cast<double>(s.k) + 1, 2147483647);
        values[at_.t_meas] = memory_.start_s + s.t_s;
    }

    // ------------------------------------------------------------------------------------------------ complete state

    std::size_t state_size() const override {
        std::size_t bytes = 0;
        hnav_aircraft_state_size(plant_, &bytes);
        return sizeof memory_ + bytes;
    }
    void save(void* buffer) const override {
        std::memcpy(buffer, &memory_, sizeof memory_);
        hnav_aircraft_save(plant_, static_cast<char*>(buffer) + sizeof memory_, state_size() - sizeof memory_);
    }
    bool load(const void* buffer, std::size_t bytes) override {
        if (bytes != state_size()) return false;
        std::memcpy(&memory_, buffer, sizeof memory_);
        return hnav_aircraft_load(plant_, static_cast<const char*>(buffer) + sizeof memory_, bytes - sizeof memory_) == HNAV_OK;
    }

    void clear() override {
        hnav_aircraft_destroy(plant_);
        plant_ = nullptr;
    }
    void destroy() override {
        clear();
        this->~AircraftIns();
        std::free(this);
    }

private:
    AircraftIns() = default;
    ~AircraftIns() = default;

    hnav_aircraft_sample sample() const {
        hnav_aircraft_sample s{};
        hnav_aircraft_get_sample(plant_, &s);
        return s;
    }

    double due_s() const { return memory_.start_s + (static_cast<double>(sample().k) + 1) * memory_.interval_s; }

    // All samples up to t_s, so that the end of a step shows the sample that is due there.
    void fly_to(double t_s) {
        const double tolerance = 1e-9 * std::fmax(1, std::fabs(t_s));
        while (due_s() <= t_s + tolerance) hnav_aircraft_step(plant_, memory_.command);
    }

    // What was seen of the inputs so far. Eight-byte numbers, saved as they are.
    struct Memory {
        double start_s, interval_s;
        double taken_for, taken_s; // sample and time of the newest command
        double command[nu];
        double non_finite;
    };

    Places at_{};
    Memory memory_{};
    hnav_aircraft* plant_ = nullptr;
};

} // namespace

Model* make_model() { return AircraftIns::make(); }

} // namespace hnav::fmu
