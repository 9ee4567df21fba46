// What an FMU is about, seen from the adapter. An FMU is a table and one class that implements this; Co-Simulation and
// Model Exchange, FMI 2 and FMI 3 are the adapter's.
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

// Which samples were lost: by the parameter that is the period and its value, or by the counter, which has none.
struct Lost {
    const char* by = nullptr;
    double period_s = 0;
};

// Of the default experiment.
struct Experiment {
    double step_s, stop_s;
};

// The continuous states of Model Exchange, and how many of them DependsOn::first_states means.
struct States {
    int count, first;
};

struct ModelInfo {
    const char* name; // modelName and modelIdentifier
    const char* description;
    Experiment experiment;
    States states = {0, 0};
    bool model_exchange = true; // offered at all
    bool derivatives = true;    // along a direction of the states, in Model Exchange
    bool arrays = false;        // vectors and matrices are one variable each, see arrays.hpp; FMI 3 alone
    bool clocks = false;        // samples come or go by triggered clocks in place of counters; FMI 3 alone
};

// Of a sensor, which samples a truth: no states, Co-Simulation alone. PyFMI takes 500 steps over the experiment, whatever their size:
// over 5 s these are as long as the shortest default period.
constexpr ModelInfo sensor_info(const char* name, const char* description, bool clocks) {
    return {name, description, Experiment{0.01, 5}, States{0, 0}, false, false, false, clocks};
}

// Of this FMU.
extern const ModelInfo model_info;

// What an FMU is compiled from by the sources in its archive, see cmake/fmu_sources.cmake; ends with null.
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

// Group of the rows that are continuous states or their derivatives: the adapter fills them itself.
constexpr unsigned state_group = 1u << 31;

// Made by new, which answers null without memory: nothing here throws.
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

    // Of an FMU whose variables stand in its resources, a folder: reads them. False: impossible, with the reason.
    virtual bool open(const char* /*resources*/, Message* /*why*/) { return true; }
    // Continuous states of Model Exchange.
    virtual int state_count() const { return model_info.states.count; }

    // Appends the rows and remembers their places.
    virtual void describe(Table& table) = 0;

    // Parameters are in values, and nothing else is read of them: makes the model at start_s. False: impossible, with the reason.
    virtual bool initialise(const double* values, double start_s, bool model_exchange, Message* why) = 0;
    // After that, perhaps several times: the inputs at the start.
    virtual void begin(const double* /*values*/) {}

    // Takes the samples that values hold at t_s; calling it twice takes nothing twice. True when something was taken.
    virtual bool take_samples(double* values, double t_s) = 0;
    // The inputs of the first sensor that has lost a sample, and what it is sampled by; by is null when none has.
    virtual Lost lost() const { return {}; }
    // The counter that first changed after samples had been taken at the period of its sensor; null when none has.
    virtual const char* mistaken() const { return nullptr; }
    // Why the first sample was refused whose value no sensor can have, such as a latitude in degrees; null when none was.
    virtual const char* refused() const { return nullptr; }
    // Why the samples seem to have another unit than the inputs declare; null while they do not.
    virtual const char* implausible() const { return nullptr; }
    // What a user should know of the run so far, if anything, goes into what; false while it is too early.
    virtual bool judge(Message* /*what*/) { return true; }
    // The next time at which samples are due, or taken ones act, without a change of the inputs; infinity if none.
    virtual double next_sample_s(const double* values) const = 0;
    // When a step of Co-Simulation to end_s next takes held inputs for a sample inside it; infinity if it does not.
    virtual double next_sample_inside_s(double /*end_s*/) const { return no_bound; }
    virtual bool can_hold() const { return false; } // by sampling_mode

    // Co-Simulation: brings the model to t_s.
    virtual bool advance(double t_s, Message* why) = 0;

    // Before that: brings what these groups show to the time of the last advance, when it is asked for only.
    virtual bool look_ahead(unsigned /*groups*/, Message* /*why*/) { return true; }
    // Writes the rows of the groups whose bits are set.
    virtual void refresh(double* values, unsigned groups) = 0;

    // Model Exchange: the states just after the last event, their sizes, their flow, the correction by the samples
    // taken, and the look of the model at a state of the importer's.
    virtual void get_states(double* x) const = 0;
    virtual void get_nominals(double* nominals) const = 0;
    virtual bool derivatives(double t_s, const double* x, double* dx) const = 0;
    // Along the direction seed of x; of a model that offers them.
    virtual bool derivatives_along(double /*t_s*/, const double* /*x*/, const double* /*seed*/, double* /*out*/) const {
        return false;
    }
    // Event indicators of Model Exchange.
    virtual int indicator_count() const { return 0; }
    virtual bool indicators(double /*t_s*/, const double* /*x*/, double* /*z*/) const { return true; }
    // A step of the importer's integrator has come to x. wants_event: it is to enter event mode.
    virtual bool step_done(double /*t_s*/, const double* /*x*/, bool* /*wants_event*/) { return true; }
    virtual bool jump(double t_s, double* x, bool* changed, Message* why) = 0;
    virtual void show(double t_s, const double* x) = 0;
    // The derivatives along the direction seed of x, where the model was shown last, of the outputs that flow; those of
    // others are 0 in rows, as they should be.
    virtual void rows_along(const double* /*seed*/, double* /*rows*/) const {}

    // The complete state apart from values, as plain numbers, whose size may change with what is waiting. load: into a model
    // made by initialise with equal values.
    virtual std::size_t state_size() const = 0;
    virtual void save(void* buffer) const = 0;
    virtual bool load(const void* buffer, std::size_t bytes, Message* why) = 0;
    // Whether what was saved is good in another process; and its end, for a model that keeps something for it.
    virtual bool can_serialise(const void* /*saved*/, std::size_t /*bytes*/, Message* /*why*/) const { return true; }
    virtual void release(const void* /*saved*/, std::size_t /*bytes*/) {}

    // Back to the moment before initialise.
    virtual void clear() = 0;
};

// A model without continuous states: all that happens, happens at samples.
class StatelessModel : public Model {
public:
    void get_states(double*) const override {}
    void get_nominals(double*) const override {}
    bool derivatives(double, const double*, double*) const override { return true; }
    bool jump(double, double*, bool*, Message*) override { return true; }
    void show(double, const double*) override {}
};

// Of this FMU; null when there is no memory.
Model* make_model();

} // namespace hnav::fmu
