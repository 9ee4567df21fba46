// FMI 3.0, Model Exchange and Co-Simulation.
#include "base/memory.hpp"
#include "observer/fmi_calls.hpp"

#include <fmi3FunctionTypes.h>

#include <cstdio>

namespace hnav::observer {
namespace {

// The last message of an instance is kept for error texts.
void log(fmi3InstanceEnvironment environment, fmi3Status, fmi3String, fmi3String text) {
    auto* instance = static_cast<FmiInstance*>(environment);
    if (instance && text) std::snprintf(instance->said, sizeof instance->said, "%s", text);
}

struct Fmi3Functions {
    using Byte = fmi3Byte;
    NamedFunction* list = nullptr;
    HNAV_FMI_FUNCTION(instantiate, fmi3InstantiateModelExchange, by_exchange);
    HNAV_FMI_FUNCTION(instantiate_steps, fmi3InstantiateCoSimulation, by_steps);
    HNAV_FMI_FUNCTION(free, fmi3FreeInstance, always);
    HNAV_FMI_FUNCTION(enter_initialization, fmi3EnterInitializationMode, always);
    HNAV_FMI_FUNCTION(exit_initialization, fmi3ExitInitializationMode, always);
    HNAV_FMI_FUNCTION(set, fmi3SetFloat64, always);
    HNAV_FMI_FUNCTION(get, fmi3GetFloat64, always);
    HNAV_FMI_FUNCTION(do_step, fmi3DoStep, by_steps);
    HNAV_FMI_FUNCTION(enter_event_mode, fmi3EnterEventMode, by_exchange);
    HNAV_FMI_FUNCTION(iterate, fmi3UpdateDiscreteStates, by_exchange);
    HNAV_FMI_FUNCTION(enter_continuous_time_mode, fmi3EnterContinuousTimeMode, by_exchange);
    HNAV_FMI_FUNCTION(set_time, fmi3SetTime, by_exchange);
    HNAV_FMI_FUNCTION(set_states, fmi3SetContinuousStates, by_exchange);
    HNAV_FMI_FUNCTION(get_states, fmi3GetContinuousStates, by_exchange);
    HNAV_FMI_FUNCTION(get_nominals, fmi3GetNominalsOfContinuousStates, by_exchange);
    HNAV_FMI_FUNCTION(get_derivatives, fmi3GetContinuousStateDerivatives, by_exchange);
    HNAV_FMI_FUNCTION(get_indicators, fmi3GetEventIndicators, never);
    HNAV_FMI_FUNCTION(step_done, fmi3CompletedIntegratorStep, never);
    HNAV_FMI_FUNCTION(get_state, fmi3GetFMUState, never);
    HNAV_FMI_FUNCTION(set_state, fmi3SetFMUState, never);
    HNAV_FMI_FUNCTION(free_state, fmi3FreeFMUState, never);
    HNAV_FMI_FUNCTION(state_bytes, fmi3SerializedFMUStateSize, never);
    HNAV_FMI_FUNCTION(serialize, fmi3SerializeFMUState, never);
    HNAV_FMI_FUNCTION(deserialize, fmi3DeserializeFMUState, never);
    HNAV_FMI_FUNCTION(directional, fmi3GetDirectionalDerivative, never);
    HNAV_FMI_FUNCTION(indicators, fmi3GetNumberOfEventIndicators, never);
};

class Fmi3Instance final : public FmiCalls<Fmi3Functions> {
public:
    using FmiCalls::FmiCalls;

    bool instantiate(const char* token, const char* resources) override {
        instance_ =
            steps() ? f_.instantiate_steps("plant", token, resources, false, false, false, false, nullptr, 0, this, log, nullptr)
                    : f_.instantiate("plant", token, resources, false, false, this, log);
        return instance_ != nullptr;
    }

    Answer enter_initialization(double start_s) override { return ask(f_.enter_initialization, false, 0, start_s, false, 0); }
    int indicators(int declared) override {
        std::size_t count = 0;
        return ask(f_.indicators, &count) == Answer::ok ? static_cast<int>(count) : declared;
    }

    Answer iterate(Iteration* found) override {
        bool again = false, terminate = false, nominals = false, values = false, defined = false;
        double next_s = 0;
        const Answer done = ask(f_.iterate, &again, &terminate, &nominals, &values, &defined, &next_s);
        *found = {again, terminate, defined, next_s};
        return done;
    }

    Answer set(const Reference* references, int count, const double* values) override {
        return ask(f_.set, references, count, values, count);
    }
    Answer get(const Reference* references, int count, double* values) override {
        return ask(f_.get, references, count, values, count);
    }
    // The caller restores a state: the previous one is needed.
    Answer step_done(bool* wants_event, bool* terminate) override {
        *wants_event = *terminate = false;
        if (!f_.step_done.symbol) return Answer::ok;
        return ask(f_.step_done, false, wants_event, terminate);
    }
    Answer directional(const Reference* unknown, int rows, const Reference* known, int count, const double* seed,
                       double* column) override {
        return ask(f_.directional, unknown, rows, known, count, seed, count, column, rows);
    }

    Answer step(double t_s, double length_s, bool* terminate) override {
        bool event = false, early = false;
        double last_s = 0;
        return ask(f_.do_step, t_s, length_s, false, &event, terminate, &early, &last_s);
    }

    void destroy() override { destroy_object(this); }
};

} // namespace

FmiInstance* make_fmi3_instance(bool steps) { return make_object<Fmi3Instance>(steps); }

} // namespace hnav::observer
