// Shared by the FMUs Gnss, Baro and Wheel: a sensor of the library that samples the true motion of a vehicle. Each names its
// inputs and outputs.
#pragma once

#include "adapter/library_model.hpp"
#include "adapter/option_parameters.hpp"
#include "adapter/outputs.hpp"
#include "adapter/sampled_inputs.hpp"
#include "hnav/simulation.h"

namespace hnav::fmu {

using AidSensorCalls = LibraryObject<hnav_aid_sensor, hnav_aid_sensor_destroy, hnav_aid_sensor_message,
                                     hnav_aid_sensor_state_size, hnav_aid_sensor_save, hnav_aid_sensor_load>;

// The clock is part of the library object.
struct AidSensorMemory {
    double blind; // the truth was invalid at the last look: due samples wait
    double period_s, now_s;
};

// The options of one sensor of the list, and those common to all.
template <hnav_aid_sensor_kind kind>
const hnav_option_info* aid_sensor_option(std::int32_t index) {
    constexpr const char* groups[] = {"gnss", "baro", "wheel"};
    for (std::int32_t k = 0; const hnav_option_info* row = hnav_option("aid_sensor", k); ++k)
        if ((!std::strcmp(row->group, groups[kind]) || !std::strcmp(row->group, "chance")) && index-- == 0) return row;
    return nullptr;
}

template <hnav_aid_sensor_kind kind>
class AidSensorModel : public LibraryModel<StatelessModel, AidSensorCalls, AidSensorMemory> {
public:
    bool initialise(const double* values, double start_s, bool, Message* why) final {
        hnav_aid_sensor_options options = hnav_aid_sensor_defaults();
        take_options(aid_sensor_option<kind>, options_, values, &options);
        const hnav_aid_sensor_kind of = kind;
        if (!make(why, hnav_aid_sensor_create, of, &options, start_s)) return false;
        const double periods_s[] = {options.gnss.period_s, options.baro.period_s, options.wheel.period_s};
        memory_.period_s = periods_s[kind];
        memory_.now_s = start_s;
        return true;
    }

    // An invalid truth is no error: samples wait for a valid one.
    bool take_samples(double* values, double t_s) final {
        auto truth = hnav_sized<hnav_vehicle_truth>();
        truth.q_nb[0] = 1;
        read(values, &truth);
        memory_.blind = hnav_aid_sensor_sample(object_, t_s, &truth) != HNAV_OK;
        return memory_.blind == 0;
    }
    double next_sample_s(const double*) const final {
        double next_s = no_bound;
        if (memory_.blind == 0) hnav_aid_sensor_next_event_s(object_, &next_s);
        return next_s;
    }

    Lost lost() const final {
        auto reading = hnav_sized<hnav_aid_reading>();
        hnav_aid_sensor_reading(object_, &reading);
        return reading.missed > 0 ? Lost{periods[kind], memory_.period_s} : Lost{};
    }

    bool advance(double t_s, Message* why) final {
        if (!check_span(memory_.now_s, t_s, periods[kind], memory_.period_s, why)) return false; // slow errors
        memory_.now_s = t_s;
        return done(hnav_aid_sensor_advance(object_, t_s), why);
    }

    void refresh(double* values, unsigned groups) final {
        reading_.refresh(groups, values, [this](hnav_aid_reading* r) {
            r->size = sizeof *r;
            hnav_aid_sensor_reading(object_, r);
        });
    }

protected:
    using Reading = hnav_aid_reading;

    // The inputs that the sensor reads.
    virtual void read(const double* values, hnav_vehicle_truth* truth) const = 0;

    static Variable truth_row(const char* name, const char* unit, const char* display, const char* text) {
        Variable v = rows::input(name, unit, display, 0, text);
        v.variability = Variability::continuous;
        return v;
    }
    // Attitude, rate, velocity and latitude, from which the velocity of any point of the body follows.
    struct BodyRows {
        int latitude, velocity, q, rate;

        void describe(Table& table) {
            latitude = table.add(truth_row("truth.latitude", "rad", "deg", "Latitude"));
            velocity = table.add_vector(truth_row("truth.velocity", "m/s", "", "Velocity north, east, down"), 3);
            q = table.add_vector(
                truth_row("truth.q", "", "",
                          "Attitude, body to north-east-down, scalar first; of zero length: no truth yet, nothing is "
                          "sampled"),
                4);
            table.row(q).start = 1;
            rate = table.add_vector(truth_row("truth.rate", "rad/s", "deg/s", "Angular rate against inertial axes, in body axes"),
                                    3);
        }
        void read(const double* values, hnav_vehicle_truth* truth) const {
            truth->latitude_rad = values[latitude];
            std::memcpy(truth->velocity_n_m_s, values + velocity, sizeof truth->velocity_n_m_s);
            std::memcpy(truth->q_nb, values + q, sizeof truth->q_nb);
            std::memcpy(truth->rate_b_rad_s, values + rate, sizeof truth->rate_b_rad_s);
        }
    };

    void describe_options(Table& table) {
        const hnav_aid_sensor_options defaults = hnav_aid_sensor_defaults();
        options_ = add_options(table, aid_sensor_option<kind>, &defaults);
    }

    // Adds one component of the sample, or three; returns the number of the first row.
    template <int first, int count = 1>
    int show_value(Table& table, const Variable& variable) {
        const auto show = [](const Reading& r, double* row) { std::memcpy(row, r.value + first, count * sizeof *row); };
        return count == 1 ? reading_.add(table, variable, show) : reading_.add_vector(table, variable, count, show);
    }
    template <int first, int count = 1>
    void show_sigma(Table& table, const Variable& variable) {
        const auto show = [](const Reading& r, double* row) { std::memcpy(row, r.sigma + first, count * sizeof *row); };
        if (count == 1) reading_.add(table, variable, show);
        else reading_.add_vector(table, variable, count, show);
    }
    // Counter or clock, time stamp and flag, named like the inputs of a filter. first: row of the values.
    void show_marks(Table& table, const char* name, int first) {
        using namespace rows;
        const int mark = reading_.add<&Reading::count>(table, sample_mark(name));
        const int t_meas = reading_.add<&Reading::t_meas_s>(
            table, output(Name(name, "t_meas"), "s", "", "Time at which the sample was measured"));
        if (model_info.clocks) table.put_on_clock(mark, first, t_meas);
        reading_.add<&Reading::valid>(table,
                                      output(Name(name, "valid"), Type::boolean, "There is a sample, and no outage since"));
    }
    void show_counts(Table& table) {
        using namespace rows;
        reading_.add<&Reading::missed>(table,
                                       output("count.missed", Type::integer, "Samples that a coarse communication step lost"));
        reading_.add<&Reading::dropped>(table, output("count.dropped", Type::integer, "Samples taken and never delivered"));
    }

private:
    static constexpr const char* periods[] = {"gnss.period_s", "baro.period_s", "wheel.period_s"};

    int options_ = 0;
    Outputs<Reading, 0, 20> reading_;
};

} // namespace hnav::fmu
