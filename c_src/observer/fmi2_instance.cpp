// FMI 2.0, Model Exchange and Co-Simulation.
#include "base/memory.hpp"
#include "observer/fmi_calls.hpp"

#include <fmi2FunctionTypes.h>

#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace hnav::observer {

namespace {

// The last message of an instance is kept for error texts.
void log(fmi2ComponentEnvironment environment, fmi2String, fmi2Status, fmi2String, fmi2String format, ...) {
    auto* instance = static_cast<FmiInstance*>(environment);
    if (!instance || !format) return;
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(instance->said, sizeof instance->said, format, arguments);
    va_end(arguments);
}

struct Fmi2Functions {
    using Byte = fmi2Byte;
    NamedFunction* list = nullptr;
    HNAV_FMI_FUNCTION(instantiate, fmi2Instantiate, always);
    HNAV_FMI_FUNCTION(set_up, fmi2SetupExperiment, always);
    HNAV_FMI_FUNCTION(free, fmi2FreeInstance, always);
    HNAV_FMI_FUNCTION(enter_initialization, fmi2EnterInitializationMode, always);
    HNAV_FMI_FUNCTION(exit_initialization, fmi2ExitInitializationMode, always);
    HNAV_FMI_FUNCTION(set, fmi2SetReal, always);
    HNAV_FMI_FUNCTION(get, fmi2GetReal, always);
    HNAV_FMI_FUNCTION(do_step, fmi2DoStep, by_steps);
    HNAV_FMI_FUNCTION(enter_event_mode, fmi2EnterEventMode, by_exchange);
    HNAV_FMI_FUNCTION(iterate, fmi2NewDiscreteStates, by_exchange);
    HNAV_FMI_FUNCTION(enter_continuous_time_mode, fmi2EnterContinuousTimeMode, by_exchange);
    HNAV_FMI_FUNCTION(set_time, fmi2SetTime, by_exchange);
    HNAV_FMI_FUNCTION(set_states, fmi2SetContinuousStates, by_exchange);
    HNAV_FMI_FUNCTION(get_states, fmi2GetContinuousStates, by_exchange);
    HNAV_FMI_FUNCTION(get_nominals, fmi2GetNominalsOfContinuousStates, by_exchange);
    HNAV_FMI_FUNCTION(get_derivatives, fmi2GetDerivatives, by_exchange);
    HNAV_FMI_FUNCTION(get_indicators, fmi2GetEventIndicators, never);
    HNAV_FMI_FUNCTION(step_done, fmi2CompletedIntegratorStep, never);
    HNAV_FMI_FUNCTION(get_state, fmi2GetFMUstate, never);
    HNAV_FMI_FUNCTION(set_state, fmi2SetFMUstate, never);
    HNAV_FMI_FUNCTION(free_state, fmi2FreeFMUstate, never);
    HNAV_FMI_FUNCTION(state_bytes, fmi2SerializedFMUstateSize, never);
    HNAV_FMI_FUNCTION(serialize, fmi2SerializeFMUstate, never);
    HNAV_FMI_FUNCTION(deserialize, fmi2DeSerializeFMUstate, never);
    HNAV_FMI_FUNCTION(directional, fmi2GetDirectionalDerivative, never);
};

class Fmi2Instance final : public FmiCalls<Fmi2Functions> {
public:
    using FmiCalls::FmiCalls;

    bool instantiate(const char* token, const char* resources) override {
        char uri[1200] = "file://";
        std::size_t at = std::strlen(uri);
        if (*resources != '/') uri[at++] = '/'; // C:/...
        for (const char* c = resources; *c && at + 4 < sizeof uri; ++c) at += escape(*c, uri + at);
        uri[at] = '\0';
        callbacks_ = {log, std::calloc, std::free, nullptr, this};
        instance_ = f_.instantiate("plant", steps() ? fmi2CoSimulation : fmi2ModelExchange, token, uri, &callbacks_, fmi2False,
                                   fmi2False);
        return instance_ != nullptr;
    }

    Answer enter_initialization(double start_s) override {
        const Answer set_up = ask(f_.set_up, fmi2False, 0, start_s, fmi2False, 0);
        return set_up == Answer::ok ? ask(f_.enter_initialization) : set_up;
    }
    int indicators(int declared) override { return declared; }

    Answer iterate(Iteration* found) override {
        fmi2EventInfo info{};
        const Answer done = ask(f_.iterate, &info);
        *found = {info.newDiscreteStatesNeeded != fmi2False, info.terminateSimulation != fmi2False,
                  info.nextEventTimeDefined != fmi2False, info.nextEventTime};
        return done;
    }

    Answer set(const Reference* references, int count, const double* values) override {
        return ask(f_.set, references, count, values);
    }
    Answer get(const Reference* references, int count, double* values) override { return ask(f_.get, references, count, values); }
    // The caller restores a state: the previous one is needed.
    Answer step_done(bool* wants_event, bool* terminate) override {
        *wants_event = *terminate = false;
        if (!f_.step_done.symbol) return Answer::ok;
        fmi2Boolean wants = fmi2False, ends = fmi2False;
        const Answer done = ask(f_.step_done, fmi2False, &wants, &ends);
        *wants_event = wants != fmi2False;
        *terminate = ends != fmi2False;
        return done;
    }
    Answer directional(const Reference* unknown, int rows, const Reference* known, int count, const double* seed,
                       double* column) override {
        return ask(f_.directional, unknown, rows, known, count, seed, column);
    }

    Answer step(double t_s, double length_s, bool* terminate) override {
        *terminate = false;
        return ask(f_.do_step, t_s, length_s, fmi2False);
    }

    void destroy() override { destroy_object(this); }

private:
    // A character of a path in a URI.
    static int escape(char c, char* to) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || std::strchr("/:._-~", c);
        if (!plain) return std::snprintf(to, 4, "%%%02X", static_cast<unsigned char>(c));
        *to = c;
        return 1;
    }

    fmi2CallbackFunctions callbacks_{};
};

} // namespace

FmiInstance* make_fmi2_instance(bool steps) { return make_object<Fmi2Instance>(steps); }

} // namespace hnav::observer
