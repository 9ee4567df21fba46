// The ImuMagSensor FMU: truth becomes samples of gyroscope, accelerometer and magnetometer, named like a filter's inputs.
#include "adapter/model.hpp"
#include "adapter/option_parameters.hpp"
#include "hnav/simulation.h"

#include <cstring>
#include <new>

namespace hnav::fmu {
namespace {

constexpr int sensors = 3;
enum Group : unsigned { reading_group = 1, parameter_group = 2 };

class ImuMagSensor final : public StatelessModel {
public:
    const ModelInfo& info() const override {
        static constexpr ModelInfo sensor = {
            "ImuMagSensor",
            "Gyroscope, accelerometer and magnetometer by their datasheets, with seeded noise and faults: truth to samples with counters and time stamps",
            0.01,
            60,
            0,
            0,
            false,
            true};
        return sensor;
    }

    void describe(Table& table) override {
        using namespace rows;
        Variable time = variable("time", Type::real, Causality::independent, Variability::continuous, "Simulation time");
        time.unit = "s";
        table.add(time);
        describe_truth(table);
        const hnav_imu_mag_sensor_options defaults = hnav_imu_mag_sensor_defaults();
        at_.options = add_options(table, hnav_imu_mag_sensor_option, &defaults);

        struct Sensor {
            const char *prefix, *value, *unit, *display, *psd_unit, *text;
        };
        constexpr Sensor described[sensors] = {
            {"gyro", "rate", "rad/s", "deg/s", "rad2/s", "Angular rate, newest sample delivered"},
            {"accel", "force", "m/s2", "", "m2/s3", "Specific force, newest sample delivered"},
            {"mag", "field", "T", "uT", "T2.s", "Magnetic field, newest sample delivered"},
        };
        char name[64];
        const auto named = [&name](const char* prefix, const char* suffix) {
            std::snprintf(name, sizeof name, "%.20s.%.30s", prefix, suffix);
            return name;
        };
        constexpr auto held = Variability::discrete;
        for (int s = 0; s < sensors; ++s) {
            const Sensor& d = described[s];
            Place& place = at_.sensor[s];
            Variable psd = variable(named(d.prefix, "noise_psd"), Type::real, Causality::calculated, Variability::fixed,
                                    "Two-sided spectral density of the white noise");
            psd.unit = d.psd_unit;
            psd.group = parameter_group;
            place.psd = table.add(psd);
            place.value = table.add_vector(
                output(named(d.prefix, d.value), d.unit, d.display, reading_group, held, DependsOn::nothing, d.text), 3);
            place.sample = table.add(output(named(d.prefix, "sample"), Type::integer, reading_group,
                                            "Samples delivered: a change marks a new sample"));
            place.t_meas = table.add(output(named(d.prefix, "t_meas"), "s", "ms", reading_group, held, DependsOn::nothing,
                                            "Time at which the sample was measured"));
            place.valid = table.add(output(named(d.prefix, "valid"), Type::boolean, reading_group, "There is a sample"));
            // Not beside the sample: a plug of a filter has the members above and no others.
            std::snprintf(name, sizeof name, "count.%s.missed", d.prefix);
            place.missed = table.add(output(name, Type::integer, reading_group, "Samples that a coarse communication step lost"));
            std::snprintf(name, sizeof name, "count.%s.dropped", d.prefix);
            place.dropped = table.add(output(name, Type::integer, reading_group, "Samples taken and never delivered"));
        }
    }

    bool initialise(double* values, const double* written, double start_s, bool, Message* why) override {
        hnav_imu_mag_sensor_options options = hnav_imu_mag_sensor_defaults();
        take_options(hnav_imu_mag_sensor_option, at_.options, values, written, &options);
        clear();
        return hnav_imu_mag_sensor_create(&sensor_, &options, start_s, why->text, sizeof why->text) == HNAV_OK;
    }

    // A truth that is none stops nothing: the samples wait for one.
    bool take_samples(double* values, double t_s) override {
        hnav_truth truth{};
        std::memcpy(truth.q_nb, values + at_.q, sizeof truth.q_nb);
        std::memcpy(truth.rate_b_rad_s, values + at_.rate, sizeof truth.rate_b_rad_s);
        std::memcpy(truth.force_b_m_s2, values + at_.force, sizeof truth.force_b_m_s2);
        std::memcpy(truth.field_b_tesla, values + at_.field, sizeof truth.field_b_tesla);
        blind_ = hnav_imu_mag_sensor_sample(sensor_, t_s, &truth) != HNAV_OK;
        return !blind_;
    }
    double next_sample_s(const double*) const override {
        double next_s = no_bound;
        if (blind_) return next_s; // what is due waits for a truth, not for a time
        hnav_imu_mag_sensor_next_event_s(sensor_, &next_s);
        return next_s;
    }

    bool advance(double t_s, Message* why) override {
        const hnav_status status = hnav_imu_mag_sensor_advance(sensor_, t_s);
        if (status == HNAV_OK) return true;
        std::snprintf(why->text, sizeof why->text, "%s", hnav_status_text(status));
        return false;
    }

    void refresh(double* values, unsigned groups) override {
        for (int s = 0; s < sensors; ++s) {
            const Place& place = at_.sensor[s];
            const auto kind = static_cast<hnav_sensor>(s);
            if (groups & parameter_group) hnav_imu_mag_sensor_noise_psd(sensor_, kind, values + place.psd);
            if (!(groups & reading_group)) continue;
            hnav_reading reading;
            hnav_imu_mag_sensor_reading(sensor_, kind, &reading);
            std::memcpy(values + place.value, reading.value, sizeof reading.value);
            values[place.sample] = reading.count;
            values[place.t_meas] = reading.t_meas_s;
            values[place.valid] = reading.count > 0;
            values[place.missed] = reading.missed;
            values[place.dropped] = reading.dropped;
        }
    }

    std::size_t state_size() const override {
        std::size_t bytes = 0;
        hnav_imu_mag_sensor_state_size(sensor_, &bytes);
        return bytes;
    }
    void save(void* buffer) const override { hnav_imu_mag_sensor_save(sensor_, buffer, state_size()); }
    bool load(const void* buffer, std::size_t bytes) override {
        return hnav_imu_mag_sensor_load(sensor_, buffer, bytes) == HNAV_OK;
    }

    void clear() override {
        hnav_imu_mag_sensor_destroy(sensor_);
        sensor_ = nullptr;
    }
    void destroy() override {
        clear();
        this->~ImuMagSensor();
        std::free(this);
    }

private:
    ~ImuMagSensor() = default;

    void describe_truth(Table& table) {
        const auto truth = [&table](const char* name, const char* unit, const char* display, int count, const char* text) {
            Variable v = rows::input(name, unit, display, 0, text);
            v.variability = Variability::continuous;
            return table.add_vector(v, count);
        };
        at_.q = truth("truth.q", "", "", 4,
                      "Attitude, body to north-east-down, scalar first; of zero length: no truth yet, nothing is sampled");
        at_.rate = truth("truth.rate", "rad/s", "deg/s", 3, "Angular rate of the body, in body axes");
        at_.force = truth("truth.force", "m/s2", "", 3, "Specific force in body axes");
        at_.field = truth("truth.field", "T", "uT", 3, "Magnetic field in body axes");
        table.row(at_.q).start = 1;
        table.row(at_.force + 2).start = -9.80665;
        table.row(at_.field).start = 2e-5;
        table.row(at_.field + 2).start = 4.5e-5;
    }

    struct Place {
        int value, sample, t_meas, valid, missed, dropped, psd;
    };
    struct {
        int q, rate, force, field, options;
        Place sensor[sensors];
    } at_{};
    hnav_imu_mag_sensor* sensor_ = nullptr;
    bool blind_ = false; // by the newest look at the truth, which every step begins with
};

} // namespace

Model* make_model() {
    void* memory = std::malloc(sizeof(ImuMagSensor));
    return memory ? new (memory) ImuMagSensor : nullptr;
}

} // namespace hnav::fmu
