// The contents of an FMU as seen from the adapter: a table of variables and one class with this interface. The adapter adds
// Co-Simulation and Model Exchange, FMI 2 and FMI 3.
#pragma once

#include "adapter/variable.hpp"

#include <cstddef>
#include <cstdlib>

namespace hnav::fmu {

// A line for the importer's log.
struct Message {
    char text[320];
    Message() { text[0] = '\0'; } // not all of it: each step has one
};

// Which samples were lost: by the name of the period parameter and its value, or by the name of the counter, which has no
// value. sparse: none, but steps longer than the period have one sample each. unstamped: samples are counted, and their times are none.
struct Lost {
    const char* by = nullptr;
    double period_s = 0;
    bool sparse = false, unstamped = false;
};

// Why a sample is refused: by its value, such as a latitude in degrees, or by its time.
enum Refusal { of_value, of_time, refusals };

// Of the default experiment.
struct Experiment {
    double step_s, stop_s;
};

// The continuous states of Model Exchange, and the number of those that DependsOn::first_states means.
struct States {
    int count, first;
};

struct ModelInfo {
    const char* name; // modelName and modelIdentifier
    const char* description;
    Experiment experiment;
    States states = {0, 0};
    bool model_exchange = true; // offered at all
    bool derivatives = true; // along a direction of the states, in Model Exchange
    bool arrays = false; // vectors and matrices are one variable each, see arrays.hpp; FMI 3 alone
    bool clocks = false; // samples come or go by triggered clocks in place of counters; FMI 3 alone
};

// For a sensor, which samples a truth: no states, Co-Simulation only. PyFMI takes 500 steps over the default experiment: of 5
// s, each step is as long as the shortest default period.
constexpr ModelInfo sensor_info(const char* name, const char* description, bool clocks) {
    return {name, description, Experiment{0.01, 5}, States{0, 0}, false, false, false, clocks};
}

// Of this FMU.
extern const ModelInfo model_info;

// The files to compile for the sources in the archive, see cmake/fmu_sources.cmake; ends with null.
constexpr const char* source_files[] = {"fmu.cpp",
                                        "options/ahrs.cpp",
                                        "options/aid_sensor.cpp",
                                        "options/aircraft.cpp",
                                        "options/hrekf.cpp",
                                        "options/imu_mag_sensor.cpp",
                                        "options/ins.cpp",
                                        "options/ins_error.cpp",
                                        "options/magnetometer.cpp",
                                        "options/observer.cpp",
                                        "options/turntable.cpp",
                                        "options/vehicle.cpp",
                                        nullptr};

// Group of rows that are continuous states or their derivatives: the adapter fills them.
constexpr unsigned state_group = 1u << 31;

// Created by new, which returns null without memory: nothing here throws.
struct Allocated {
    static void* operator new(std::size_t bytes) noexcept { return std::malloc(bytes); }
    static void operator delete(void* memory) { std::free(memory); }
};

// values: one double for each row of the table, owned by the instance.
class Model : public Allocated {
public:
    Model() = default;
    Model(const Model&) = delete;
    Model& operator=(const Model&) = delete;
    virtual ~Model() = default;

    // For an FMU whose table is a file in its resources folder: reads the table. False, with the reason, if it cannot.
    virtual bool open(const char* /*resources*/, Message* /*why*/) { return true; }
    // Continuous states of Model Exchange.
    virtual int state_count() const { return model_info.states.count; }

    // Appends the rows and keeps their numbers.
    virtual void describe(Table& table) = 0;

    // Creates the model at start_s from the parameters in values; other values are not read. False, with the reason, if it
    // cannot.
    virtual bool initialise(const double* values, double start_s, bool model_exchange, Message* why) = 0;
    // Called afterwards, perhaps several times, with the inputs at the start.
    virtual void begin(const double* /*values*/) {}

    // Takes the new samples in values at t_s; a second call takes none. True when a sample was taken.
    virtual bool take_samples(double* values, double t_s) = 0;
    // The period or counter of the first sensor that has lost a sample; by is null if none has.
    virtual Lost lost() const { return {}; }
    // The first sensor whose importer holds each value for several periods, with that time; such values are used once.
    virtual Lost repeated() const { return {}; }
    // The first counter that changed after samples had been taken at the period of its sensor; null if there is none.
    virtual const char* mistaken() const { return nullptr; }
    // Why the first sample of a kind was refused; null if none was.
    virtual const char* refused(Refusal) const { return nullptr; }
    // Why the samples seem to have another unit than declared; null if they do not.
    virtual const char* implausible() const { return nullptr; }
    // Writes a finding about the run so far into what, if there is one; false if it is too early to decide.
    virtual bool judge(Message* /*what*/) { return true; }
    // The next time at which samples are due or taken samples take effect without a change of the inputs; infinity if none.
    virtual double next_sample_s(const double* values) const = 0;
    // The next time inside a Co-Simulation step to end_s at which held inputs are sampled; infinity if none.
    virtual double next_sample_inside_s(double /*end_s*/) const { return no_bound; }
    virtual bool can_hold() const { return false; } // by sampling_mode

    // Co-Simulation: advances the model to t_s.
    virtual bool advance(double t_s, Message* why) = 0;

    // Updates these groups to the time of the last advance; called only for groups that are read.
    virtual bool look_ahead(unsigned /*groups*/, Message* /*why*/) { return true; }
    // Writes the rows of the groups with set bits.
    virtual void refresh(double* values, unsigned groups) = 0;

    // Model Exchange: the states just after the last event, their nominal values, their derivatives, the correction by the
    // samples taken, and the outputs at the importer's states.
    virtual void get_states(double* x) const = 0;
    virtual void get_nominals(double* nominals) const = 0;
    virtual bool derivatives(double t_s, const double* x, double* dx) const = 0;
    // The derivative of the derivatives along the direction seed of x, for a model that offers it.
    virtual bool derivatives_along(double /*t_s*/, const double* /*x*/, const double* /*seed*/, double* /*out*/) const {
        return false;
    }
    // Event indicators of Model Exchange.
    virtual int indicator_count() const { return 0; }
    virtual bool indicators(double /*t_s*/, const double* /*x*/, double* /*z*/) const { return true; }
    // A completed step of the importer's integrator to x. wants_event: the importer is to enter event mode.
    virtual bool step_done(double /*t_s*/, const double* /*x*/, bool* /*wants_event*/) { return true; }
    virtual bool jump(double t_s, double* x, bool* changed, Message* why) = 0;
    virtual void show(double t_s, const double* x) = 0;
    // The derivatives of the continuous outputs along the direction seed of x, at the last shown state; the rows of other
    // outputs are 0.
    virtual void rows_along(const double* /*seed*/, double* /*rows*/) const {}

    // The complete state apart from values, as plain numbers; its size depends on the queued samples. load: into a model that
    // initialise has created from equal values.
    virtual std::size_t state_size() const = 0;
    virtual void save(void* buffer) const = 0;
    virtual bool load(const void* buffer, std::size_t bytes, Message* why) = 0;
    // Whether a saved state is valid in another process; and its release, for a model that keeps memory for it.
    virtual bool can_serialise(const void* /*saved*/, std::size_t /*bytes*/, Message* /*why*/) const { return true; }
    virtual void release(const void* /*saved*/, std::size_t /*bytes*/) {}

    // Returns to the state before initialise.
    virtual void clear() = 0;
};

// A model without continuous states: it changes only at samples.
class StatelessModel : public Model {
public:
    void get_states(double*) const override {}
    void get_nominals(double*) const override {}
    bool derivatives(double, const double*, double*) const override { return true; }
    bool jump(double, double*, bool*, Message*) override { return true; }
    void show(double, const double*) override {}
};

// Creates the model of this FMU; null without memory.
Model* make_model();

} // namespace hnav::fmu
