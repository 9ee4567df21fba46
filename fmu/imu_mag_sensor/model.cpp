// The ImuMagSensor FMU: samples of gyroscope, accelerometer and magnetometer from the true motion, named like a filter's
// inputs.
#include "adapter/library_model.hpp"
#include "adapter/option_parameters.hpp"
#include "adapter/outputs.hpp"
#include "adapter/sampled_inputs.hpp"
#include "hnav/simulation.h"

namespace hnav::fmu {
namespace {

constexpr char option_list[] = "imu_mag_sensor";

constexpr int sensors = 3;
enum Group { reading_group, parameter_group };

using SensorCalls = LibraryObject<hnav_imu_mag_sensor, hnav_imu_mag_sensor_destroy, hnav_imu_mag_sensor_message,
                                  hnav_imu_mag_sensor_state_size, hnav_imu_mag_sensor_save, hnav_imu_mag_sensor_load>;

// The clocks of the three sensors are part of the library object.
struct SensorMemory {
    double blind; // the truth was invalid at the last look: due samples wait
    double period_s[sensors], now_s;
};

class ImuMagSensor final : public LibraryModel<StatelessModel, SensorCalls, SensorMemory> {
public:
    void describe(Table& table) override {
        table.add(rows::time());
        describe_truth(table);
        const hnav_imu_mag_sensor_options defaults = hnav_imu_mag_sensor_defaults();
        at_.options = add_options(table, option_of<option_list>, &defaults);
        describe_sensor(table, HNAV_SENSOR_GYRO, "gyro",
                        {"rate", "rad/s", "deg/s", "rad2/s", "Angular rate, newest sample delivered"});
        describe_sensor(table, HNAV_SENSOR_ACCEL, "accel",
                        {"force", "m/s2", "", "m2/s3", "Specific force, newest sample delivered"});
        describe_sensor(table, HNAV_SENSOR_MAG, "mag", {"field", "T", "uT", "T2.s", "Magnetic field, newest sample delivered"});
    }

    bool initialise(const double* values, double start_s, bool, Message* why) override {
        hnav_imu_mag_sensor_options options = hnav_imu_mag_sensor_defaults();
        take_options(option_of<option_list>, at_.options, values, &options);
        if (!make(why, hnav_imu_mag_sensor_create, &options, start_s)) return false;
        const double periods_s[] = {options.gyro.period_s, options.accel.period_s, options.mag.period_s};
        std::memcpy(memory_.period_s, periods_s, sizeof periods_s);
        memory_.now_s = start_s;
        return true;
    }

    // An invalid truth is no error: samples wait for a valid one.
    bool take_samples(double* values, double t_s) override {
        auto truth = hnav_sized<hnav_truth>();
        std::memcpy(truth.q_nb, values + at_.q, sizeof truth.q_nb);
        std::memcpy(truth.rate_b_rad_s, values + at_.rate, sizeof truth.rate_b_rad_s);
        std::memcpy(truth.force_b_m_s2, values + at_.force, sizeof truth.force_b_m_s2);
        std::memcpy(truth.field_b_tesla, values + at_.field, sizeof truth.field_b_tesla);
        memory_.blind = hnav_imu_mag_sensor_sample(object_, t_s, &truth) != HNAV_OK;
        return memory_.blind == 0;
    }
    double next_sample_s(const double*) const override {
        double next_s = no_bound;
        if (memory_.blind == 0) hnav_imu_mag_sensor_next_event_s(object_, &next_s); // else it waits for a valid truth
        return next_s;
    }

    Lost lost() const override {
        for (int s = 0; s < sensors; ++s) {
            auto reading = hnav_sized<hnav_reading>();
            hnav_imu_mag_sensor_reading(object_, static_cast<hnav_sensor>(s), &reading);
            if (reading.missed > 0) return {periods[s], memory_.period_s[s]};
        }
        return {};
    }

    bool advance(double t_s, Message* why) override {
        for (int s = 0; s < sensors; ++s) // slow errors change with every sample
            if (!check_span(memory_.now_s, t_s, periods[s], memory_.period_s[s], why)) return false;
        memory_.now_s = t_s;
        return done(hnav_imu_mag_sensor_advance(object_, t_s), why);
    }

    void refresh(double* values, unsigned groups) override {
        for (int s = 0; s < sensors; ++s) {
            const auto kind = static_cast<hnav_sensor>(s);
            density_[s].refresh(groups, values, [&](Density* d) { hnav_imu_mag_sensor_noise_psd(object_, kind, &d->psd); });
            reading_[s].refresh(groups, values, [&](hnav_reading* r) {
                r->size = sizeof *r;
                hnav_imu_mag_sensor_reading(object_, kind, r);
            });
        }
    }

private:
    static constexpr const char* periods[sensors] = {"gyro.period_s", "accel.period_s", "mag.period_s"};

    struct Density {
        double psd;
    };
    struct Described {
        const char *value, *unit, *display, *psd_unit, *text;
    };

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

    void describe_sensor(Table& table, int s, const char* name, const Described& d) {
        using namespace rows;
        density_[s].add<&Density::psd>(table, quantity(Name(name, "noise_psd"), Causality::calculated, Variability::fixed,
                                                       d.psd_unit, "", "Two-sided spectral density of the white noise"));
        auto& reading = reading_[s];
        const int value = reading.add<&hnav_reading::value>(table, output(Name(name, d.value), d.unit, d.display, d.text));
        const int mark = reading.add<&hnav_reading::count>(table, sample_mark(name));
        const int t_meas = reading.add<&hnav_reading::t_meas_s>(
            table, output(Name(name, "t_meas"), "s", "", "Time at which the sample was measured"));
        if (model_info.clocks) table.put_on_clock(mark, value, t_meas);
        reading.add(table, output(Name(name, "valid"), Type::boolean, "There is a sample"),
                    [](const hnav_reading& r, double* row) { *row = r.count > 0; });
        // Separate from the sample: the terminal of a filter has exactly the members above.
        reading.add<&hnav_reading::missed>(
            table, output(Name("count", name, ".missed"), Type::integer, "Samples that a coarse communication step lost"));
        reading.add<&hnav_reading::dropped>(
            table, output(Name("count", name, ".dropped"), Type::integer, "Samples taken and never delivered"));
    }

    struct {
        int q, rate, force, field, options;
    } at_{};
    Outputs<Density, parameter_group> density_[sensors];
    Outputs<hnav_reading, reading_group> reading_[sensors];
};

} // namespace

constexpr ModelInfo model_info =
    sensor_info(HNAV_FMU_NAME,
                "Gyroscope, accelerometer and magnetometer by their datasheets, with seeded noise and faults: truth to "
                "samples with counters and time stamps",
                HNAV_FMU_CLOCKS != 0);
Model* make_model() { return new ImuMagSensor; }

} // namespace hnav::fmu
