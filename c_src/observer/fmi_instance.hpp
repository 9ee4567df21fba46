// One instance of an FMU in Model Exchange or Co-Simulation, in the calls that FMI 2 and FMI 3 share.
#pragma once

#include "observer/problem.hpp"
#include "observer/shared_library.hpp"

#include <cstddef>
#include <cstdint>

namespace hnav::observer {

using Reference = std::uint32_t;

class FmiInstance {
public:
    explicit FmiInstance(bool steps) : steps_(steps) {}

    struct Iteration {
        bool again, terminate, next_event_defined;
        double next_event_s;
    };

    // False: missing is the name of the missing function.
    virtual bool find(const SharedLibrary& library, const char** missing) = 0;
    // resources: the folder, full and with / at its end.
    virtual bool instantiate(const char* token, const char* resources) = 0;
    virtual void free() = 0;
    virtual Answer enter_initialization(double start_s) = 0;
    virtual Answer exit_initialization() = 0;
    virtual int indicators(int declared) = 0;

    virtual Answer enter_event_mode() = 0;
    virtual Answer iterate(Iteration* found) = 0;
    virtual Answer enter_continuous_time_mode() = 0;

    virtual Answer set(const Reference* references, int count, const double* values) = 0;
    virtual Answer get(const Reference* references, int count, double* values) = 0;
    virtual Answer set_time(double t_s) = 0;
    virtual Answer set_states(const double* x, int count) = 0;
    virtual Answer get_states(double* x, int count) = 0;
    virtual Answer get_nominals(double* x, int count) = 0;
    virtual Answer get_derivatives(double* dx, int count) = 0;
    virtual Answer get_indicators(double* z, int count) = 0;
    virtual Answer step_done(bool* wants_event, bool* terminate) = 0;
    // Copies of the whole state of the instance. get reuses an existing copy, or takes null.
    virtual Answer get_state(void** state) = 0;
    virtual Answer set_state(void* state) = 0;
    virtual void free_state(void** state) = 0;
    virtual Answer state_bytes(void* state, std::size_t* bytes) = 0;
    virtual Answer serialize(void* state, void* bytes, std::size_t count) = 0;
    virtual Answer deserialize(const void* bytes, std::size_t count, void** state) = 0;
    // Along all the known ones together, by as much of each as seed has.
    virtual Answer directional(const Reference* unknown, int rows, const Reference* known, int count, const double* seed,
                               double* column) = 0;

    // Of Co-Simulation; it may be set back to a state before this step.
    virtual Answer step(double t_s, double length_s, bool* terminate) = 0;

    virtual void destroy() = 0;

    char said[256] = "";
    bool dead = false; // after a fatal error no function may be called

protected:
    ~FmiInstance() = default;

    // In Co-Simulation.
    bool steps() const { return steps_; }

    // Statuses have the same numbers in both versions.
    Answer answer(int status) {
        if (status >= 4) dead = true;
        return status <= 1 ? Answer::ok : status == 2 ? Answer::elsewhere : Answer::broken;
    }

private:
    const bool steps_;
};

// steps: in Co-Simulation. Null: no memory.
FmiInstance* make_fmi2_instance(bool steps);
FmiInstance* make_fmi3_instance(bool steps);

} // namespace hnav::observer
