// FMI 3.0, Model Exchange and Co-Simulation.
#include "base/memory.hpp"
#include "observer/fmi_instance.hpp"

#include <fmi3FunctionTypes.h>

#include <algorithm>
#include <cstdio>

namespace hnav::observer {
namespace {

// The last message of an instance is kept for error texts.
void log(fmi3InstanceEnvironment environment, fmi3Status, fmi3String, fmi3String text) {
    auto* instance = static_cast<FmiInstance*>(environment);
    if (instance && text) std::snprintf(instance->said, sizeof instance->said, "%s", text);
}

class Fmi3Instance final : public FmiInstance {
public:
    explicit Fmi3Instance(bool steps) : FmiInstance(steps) {}

    bool find(const SharedLibrary& library, const char** missing) override {
        // Optional functions.
        get_indicators_ = library.function<fmi3GetEventIndicatorsTYPE>("fmi3GetEventIndicators");
        step_done_ = library.function<fmi3CompletedIntegratorStepTYPE>("fmi3CompletedIntegratorStep");
        get_state_ = library.function<fmi3GetFMUStateTYPE>("fmi3GetFMUState");
        set_state_ = library.function<fmi3SetFMUStateTYPE>("fmi3SetFMUState");
        free_state_ = library.function<fmi3FreeFMUStateTYPE>("fmi3FreeFMUState");
        state_size_ = library.function<fmi3SerializedFMUStateSizeTYPE>("fmi3SerializedFMUStateSize");
        serialize_ = library.function<fmi3SerializeFMUStateTYPE>("fmi3SerializeFMUState");
        deserialize_ = library.function<fmi3DeserializeFMUStateTYPE>("fmi3DeserializeFMUState");
        directional_ = library.function<fmi3GetDirectionalDerivativeTYPE>("fmi3GetDirectionalDerivative");
        indicators_ = library.function<fmi3GetNumberOfEventIndicatorsTYPE>("fmi3GetNumberOfEventIndicators");
        const bool found[] = {take(library, free_, "fmi3FreeInstance", missing),
                              take(library, enter_init_, "fmi3EnterInitializationMode", missing),
                              take(library, exit_init_, "fmi3ExitInitializationMode", missing),
                              take(library, set_, "fmi3SetFloat64", missing), take(library, get_, "fmi3GetFloat64", missing)};
        if (!all(found)) return false;
        if (steps())
            return take(library, instantiate_steps_, "fmi3InstantiateCoSimulation", missing) &&
                   take(library, step_, "fmi3DoStep", missing);
        const bool exchange[] = {take(library, instantiate_, "fmi3InstantiateModelExchange", missing),
                                 take(library, event_mode_, "fmi3EnterEventMode", missing),
                                 take(library, iterate_, "fmi3UpdateDiscreteStates", missing),
                                 take(library, continuous_, "fmi3EnterContinuousTimeMode", missing),
                                 take(library, set_time_, "fmi3SetTime", missing),
                                 take(library, set_states_, "fmi3SetContinuousStates", missing),
                                 take(library, get_states_, "fmi3GetContinuousStates", missing),
                                 take(library, nominals_, "fmi3GetNominalsOfContinuousStates", missing),
                                 take(library, derivatives_, "fmi3GetContinuousStateDerivatives", missing)};
        return all(exchange);
    }

    bool instantiate(const char* token, const char* resources) override {
        instance_ =
            steps() ? instantiate_steps_("plant", token, resources, false, false, false, false, nullptr, 0, this, log, nullptr)
                    : instantiate_("plant", token, resources, false, false, this, log);
        return instance_ != nullptr;
    }

    void free() override {
        if (instance_ && !dead) free_(instance_);
        instance_ = nullptr;
    }

    Answer enter_initialization(double start_s) override { return answer(enter_init_(instance_, false, 0, start_s, false, 0)); }
    Answer exit_initialization() override { return answer(exit_init_(instance_)); }
    int indicators(int declared) override {
        std::size_t count = 0;
        return indicators_ && answer(indicators_(instance_, &count)) == Answer::ok ? static_cast<int>(count) : declared;
    }

    Answer enter_event_mode() override { return answer(event_mode_(instance_)); }
    Answer iterate(Iteration* found) override {
        bool again = false, terminate = false, nominals = false, values = false, defined = false;
        double next_s = 0;
        const Answer done = answer(iterate_(instance_, &again, &terminate, &nominals, &values, &defined, &next_s));
        *found = {again, terminate, defined, next_s};
        return done;
    }
    Answer enter_continuous_time_mode() override { return answer(continuous_(instance_)); }

    Answer set(const Reference* references, int count, const double* values) override {
        return answer(set_(instance_, references, count, values, count));
    }
    Answer get(const Reference* references, int count, double* values) override {
        return answer(get_(instance_, references, count, values, count));
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
        return answer(step_done_(instance_, false, wants_event, terminate));
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
        return serialize_ ? answer(serialize_(instance_, state, static_cast<fmi3Byte*>(bytes), count)) : Answer::broken;
    }
    Answer deserialize(const void* bytes, std::size_t count, void** state) override {
        return deserialize_ ? answer(deserialize_(instance_, static_cast<const fmi3Byte*>(bytes), count, state)) : Answer::broken;
    }
    Answer directional(const Reference* unknown, int rows, const Reference* known, int count, const double* seed,
                       double* column) override {
        if (!directional_) return Answer::broken;
        return answer(directional_(instance_, unknown, rows, known, count, seed, count, column, rows));
    }

    Answer step(double t_s, double length_s, bool* terminate) override {
        bool event = false, early = false;
        double last_s = 0;
        return answer(step_(instance_, t_s, length_s, false, &event, terminate, &early, &last_s));
    }

    void destroy() override { destroy_object(this); }

private:
    fmi3Instance instance_ = nullptr;
    fmi3InstantiateModelExchangeTYPE* instantiate_ = nullptr;
    fmi3InstantiateCoSimulationTYPE* instantiate_steps_ = nullptr;
    fmi3DoStepTYPE* step_ = nullptr;
    fmi3FreeInstanceTYPE* free_ = nullptr;
    fmi3EnterInitializationModeTYPE* enter_init_ = nullptr;
    fmi3ExitInitializationModeTYPE* exit_init_ = nullptr;
    fmi3GetNumberOfEventIndicatorsTYPE* indicators_ = nullptr;
    fmi3EnterEventModeTYPE* event_mode_ = nullptr;
    fmi3UpdateDiscreteStatesTYPE* iterate_ = nullptr;
    fmi3EnterContinuousTimeModeTYPE* continuous_ = nullptr;
    fmi3SetFloat64TYPE* set_ = nullptr;
    fmi3GetFloat64TYPE* get_ = nullptr;
    fmi3SetTimeTYPE* set_time_ = nullptr;
    fmi3SetContinuousStatesTYPE* set_states_ = nullptr;
    fmi3GetContinuousStatesTYPE* get_states_ = nullptr;
    fmi3GetNominalsOfContinuousStatesTYPE* nominals_ = nullptr;
    fmi3GetContinuousStateDerivativesTYPE* derivatives_ = nullptr;
    fmi3GetDirectionalDerivativeTYPE* directional_ = nullptr;
    fmi3GetEventIndicatorsTYPE* get_indicators_ = nullptr;
    fmi3CompletedIntegratorStepTYPE* step_done_ = nullptr;
    fmi3GetFMUStateTYPE* get_state_ = nullptr;
    fmi3SetFMUStateTYPE* set_state_ = nullptr;
    fmi3FreeFMUStateTYPE* free_state_ = nullptr;
    fmi3SerializedFMUStateSizeTYPE* state_size_ = nullptr;
    fmi3SerializeFMUStateTYPE* serialize_ = nullptr;
    fmi3DeserializeFMUStateTYPE* deserialize_ = nullptr;
};

} // namespace

FmiInstance* make_fmi3_instance(bool steps) { return make_object<Fmi3Instance>(steps); }

} // namespace hnav::observer
