// FMI 2.0, Model Exchange and Co-Simulation.
#include "base/memory.hpp"
#include "observer/fmi_instance.hpp"

#include <fmi2FunctionTypes.h>

#include <algorithm>
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

class Fmi2Instance final : public FmiInstance {
public:
    explicit Fmi2Instance(bool steps) : FmiInstance(steps) {}

    bool find(const SharedLibrary& library, const char** missing) override {
        // Optional functions.
        get_indicators_ = library.function<fmi2GetEventIndicatorsTYPE>("fmi2GetEventIndicators");
        step_done_ = library.function<fmi2CompletedIntegratorStepTYPE>("fmi2CompletedIntegratorStep");
        get_state_ = library.function<fmi2GetFMUstateTYPE>("fmi2GetFMUstate");
        set_state_ = library.function<fmi2SetFMUstateTYPE>("fmi2SetFMUstate");
        free_state_ = library.function<fmi2FreeFMUstateTYPE>("fmi2FreeFMUstate");
        state_size_ = library.function<fmi2SerializedFMUstateSizeTYPE>("fmi2SerializedFMUstateSize");
        serialize_ = library.function<fmi2SerializeFMUstateTYPE>("fmi2SerializeFMUstate");
        deserialize_ = library.function<fmi2DeSerializeFMUstateTYPE>("fmi2DeSerializeFMUstate");
        directional_ = library.function<fmi2GetDirectionalDerivativeTYPE>("fmi2GetDirectionalDerivative");
        const bool found[] = {take(library, instantiate_, "fmi2Instantiate", missing),
                              take(library, free_, "fmi2FreeInstance", missing),
                              take(library, setup_, "fmi2SetupExperiment", missing),
                              take(library, enter_init_, "fmi2EnterInitializationMode", missing),
                              take(library, exit_init_, "fmi2ExitInitializationMode", missing),
                              take(library, set_, "fmi2SetReal", missing),
                              take(library, get_, "fmi2GetReal", missing)};
        if (!all(found)) return false;
        if (steps()) return take(library, step_, "fmi2DoStep", missing);
        const bool exchange[] = {take(library, event_mode_, "fmi2EnterEventMode", missing),
                                 take(library, iterate_, "fmi2NewDiscreteStates", missing),
                                 take(library, continuous_, "fmi2EnterContinuousTimeMode", missing),
                                 take(library, set_time_, "fmi2SetTime", missing),
                                 take(library, set_states_, "fmi2SetContinuousStates", missing),
                                 take(library, get_states_, "fmi2GetContinuousStates", missing),
                                 take(library, nominals_, "fmi2GetNominalsOfContinuousStates", missing),
                                 take(library, derivatives_, "fmi2GetDerivatives", missing)};
        return all(exchange);
    }

    bool instantiate(const char* token, const char* resources) override {
        char uri[1200] = "file://";
        std::size_t at = std::strlen(uri);
        if (*resources != '/') uri[at++] = '/'; // C:/...
        for (const char* c = resources; *c && at + 4 < sizeof uri; ++c) at += escape(*c, uri + at);
        uri[at] = '\0';
        callbacks_ = {log, std::calloc, std::free, nullptr, this};
        instance_ =
            instantiate_("plant", steps() ? fmi2CoSimulation : fmi2ModelExchange, token, uri, &callbacks_, fmi2False, fmi2False);
        return instance_ != nullptr;
    }

    void free() override {
        if (instance_ && !dead) free_(instance_);
        instance_ = nullptr;
    }

    Answer enter_initialization(double start_s) override {
        const Answer set_up = answer(setup_(instance_, fmi2False, 0, start_s, fmi2False, 0));
        return set_up == Answer::ok ? answer(enter_init_(instance_)) : set_up;
    }
    Answer exit_initialization() override { return answer(exit_init_(instance_)); }
    int indicators(int declared) override { return declared; }

    Answer enter_event_mode() override { return answer(event_mode_(instance_)); }
    Answer iterate(Iteration* found) override {
        fmi2EventInfo info{};
        const Answer done = answer(iterate_(instance_, &info));
        *found = {info.newDiscreteStatesNeeded != fmi2False, info.terminateSimulation != fmi2False,
                  info.nextEventTimeDefined != fmi2False, info.nextEventTime};
        return done;
    }
    Answer enter_continuous_time_mode() override { return answer(continuous_(instance_)); }

    Answer set(const Reference* references, int count, const double* values) override {
        return answer(set_(instance_, references, count, values));
    }
    Answer get(const Reference* references, int count, double* values) override {
        return answer(get_(instance_, references, count, values));
    }
    Answer set_time(double t_s) override { return answer(set_time_(instance_, t_s)); }
    Answer set_states(const double* x, int count) override { return answer(set_states_(instance_, x, count)); }
    Answer get_states(double* x, int count) override { return answer(get_states_(instance_, x, count)); }
    Answer get_nominals(double* x, int count) override { return answer(nominals_(instance_, x, count)); }
    Answer get_derivatives(double* dx, int count) override { return answer(derivatives_(instance_, dx, count)); }
    Answer get_indicators(double* z, int count) override {
        return get_indicators_ ? answer(get_indicators_(instance_, z, count)) : Answer::broken;
    }
    // The caller restores a state: the previous one is needed.
    Answer step_done(bool* wants_event, bool* terminate) override {
        *wants_event = *terminate = false;
        if (!step_done_) return Answer::ok;
        fmi2Boolean wants = fmi2False, ends = fmi2False;
        const Answer done = answer(step_done_(instance_, fmi2False, &wants, &ends));
        *wants_event = wants != fmi2False;
        *terminate = ends != fmi2False;
        return done;
    }
    Answer get_state(void** state) override { return get_state_ ? answer(get_state_(instance_, state)) : Answer::broken; }
    Answer set_state(void* state) override { return set_state_ ? answer(set_state_(instance_, state)) : Answer::broken; }
    void free_state(void** state) override {
        if (*state && free_state_ && instance_ && !dead) free_state_(instance_, state);
        *state = nullptr;
    }
    Answer state_bytes(void* state, std::size_t* bytes) override {
        return state_size_ ? answer(state_size_(instance_, state, bytes)) : Answer::broken;
    }
    Answer serialize(void* state, void* bytes, std::size_t count) override {
        return serialize_ ? answer(serialize_(instance_, state, static_cast<fmi2Byte*>(bytes), count)) : Answer::broken;
    }
    Answer deserialize(const void* bytes, std::size_t count, void** state) override {
        return deserialize_ ? answer(deserialize_(instance_, static_cast<const fmi2Byte*>(bytes), count, state)) : Answer::broken;
    }
    Answer directional(const Reference* unknown, int rows, const Reference* known, int count, const double* seed,
                       double* column) override {
        if (!directional_) return Answer::broken;
        return answer(directional_(instance_, unknown, rows, known, count, seed, column));
    }

    Answer step(double t_s, double length_s, bool* terminate) override {
        *terminate = false;
        return answer(step_(instance_, t_s, length_s, fmi2False));
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

    fmi2Component instance_ = nullptr;
    fmi2CallbackFunctions callbacks_{};
    fmi2InstantiateTYPE* instantiate_ = nullptr;
    fmi2FreeInstanceTYPE* free_ = nullptr;
    fmi2DoStepTYPE* step_ = nullptr;
    fmi2SetupExperimentTYPE* setup_ = nullptr;
    fmi2EnterInitializationModeTYPE* enter_init_ = nullptr;
    fmi2ExitInitializationModeTYPE* exit_init_ = nullptr;
    fmi2EnterEventModeTYPE* event_mode_ = nullptr;
    fmi2NewDiscreteStatesTYPE* iterate_ = nullptr;
    fmi2EnterContinuousTimeModeTYPE* continuous_ = nullptr;
    fmi2SetRealTYPE* set_ = nullptr;
    fmi2GetRealTYPE* get_ = nullptr;
    fmi2SetTimeTYPE* set_time_ = nullptr;
    fmi2SetContinuousStatesTYPE* set_states_ = nullptr;
    fmi2GetContinuousStatesTYPE* get_states_ = nullptr;
    fmi2GetNominalsOfContinuousStatesTYPE* nominals_ = nullptr;
    fmi2GetDerivativesTYPE* derivatives_ = nullptr;
    fmi2GetDirectionalDerivativeTYPE* directional_ = nullptr;
    fmi2GetEventIndicatorsTYPE* get_indicators_ = nullptr;
    fmi2CompletedIntegratorStepTYPE* step_done_ = nullptr;
    fmi2GetFMUstateTYPE* get_state_ = nullptr;
    fmi2SetFMUstateTYPE* set_state_ = nullptr;
    fmi2FreeFMUstateTYPE* free_state_ = nullptr;
    fmi2SerializedFMUstateSizeTYPE* state_size_ = nullptr;
    fmi2SerializeFMUstateTYPE* serialize_ = nullptr;
    fmi2DeSerializeFMUstateTYPE* deserialize_ = nullptr;
};

} // namespace

FmiInstance* make_fmi2_instance(bool steps) { return make_object<Fmi2Instance>(steps); }

} // namespace hnav::observer
