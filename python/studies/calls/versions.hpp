// FMI 2 and FMI 3 by the same calls, of a binary that is loaded: what is called alike in both keeps its name.
#pragma once

#include "chance.hpp"

#include <dlfcn.h>
#include <fmi2FunctionTypes.h>
#include <fmi3FunctionTypes.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <type_traits>
#include <vector>

inline int messages = 0; // since the last call began

template <class Function>
Function* symbol(void* library, const char* name) {
    void* address = dlsym(library, name);
    if (!address) {
        std::fprintf(stderr, "the binary has no function %s\n", name);
        std::exit(2);
    }
    return reinterpret_cast<Function*>(address);
}

inline void log2(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String text, ...) {
    messages += text && *text;
}
inline void log3(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String text) { messages += text && *text; }

// A call of a version, under the name that FMI 3 has for it.
#define CALL_AS(version, name, own) fmi##version##own##TYPE* name = symbol<fmi##version##own##TYPE>(library, "fmi" #version #own)
#define CALL(version, name) CALL_AS(version, name, name)
#define CALLS_OF_BOTH(version)                                                                                                   \
    CALL(version, FreeInstance);                                                                                                 \
    CALL(version, EnterInitializationMode);                                                                                      \
    CALL(version, ExitInitializationMode);                                                                                       \
    CALL(version, Terminate);                                                                                                    \
    CALL(version, Reset);                                                                                                        \
    CALL(version, GetBoolean);                                                                                                   \
    CALL(version, SetBoolean);                                                                                                   \
    CALL(version, GetDirectionalDerivative);                                                                                     \
    CALL(version, DoStep);                                                                                                       \
    CALL(version, EnterEventMode);                                                                                               \
    CALL(version, EnterContinuousTimeMode);                                                                                      \
    CALL(version, CompletedIntegratorStep);                                                                                      \
    CALL(version, SetTime);                                                                                                      \
    CALL(version, SetContinuousStates);                                                                                          \
    CALL(version, GetContinuousStates);                                                                                          \
    CALL(version, GetNominalsOfContinuousStates);                                                                                \
    CALL(version, GetEventIndicators)

struct Fmi2 {
    static constexpr int version = 2;
    using State = fmi2FMUstate;
    void* library;
    fmi2Component c = nullptr;
    fmi2CallbackFunctions callbacks = {log2, std::calloc, std::free, nullptr, nullptr};
    CALLS_OF_BOTH(2);
    CALL(2, Instantiate);
    CALL(2, SetupExperiment);
    CALL(2, GetReal);
    CALL(2, GetInteger);
    CALL(2, SetReal);
    CALL(2, SetInteger);
    CALL_AS(2, GetFMUState, GetFMUstate);
    CALL_AS(2, SetFMUState, SetFMUstate);
    CALL_AS(2, FreeFMUState, FreeFMUstate);
    CALL_AS(2, SerializedFMUStateSize, SerializedFMUstateSize);
    CALL(2, SerializeFMUstate);
    CALL(2, DeSerializeFMUstate);
    CALL(2, NewDiscreteStates);
    CALL_AS(2, GetContinuousStateDerivatives, GetDerivatives);

    void instantiate(const Plan& plan, Chance&) {
        c = Instantiate("random", plan.model_exchange ? fmi2ModelExchange : fmi2CoSimulation, plan.token.c_str(),
                        plan.resources.c_str(), &callbacks, fmi2False, fmi2True);
    }
    int initialise(double start_s) {
        const int status = SetupExperiment(c, fmi2False, 0, start_s, fmi2False, 0);
        return status ? status : EnterInitializationMode(c);
    }
    int get(char type, const unsigned* refs, std::size_t n, std::vector<double>& values) {
        if (type == 'r') return GetReal(c, refs, n, values.data());
        std::vector<int> whole(n);
        const int status = type == 'b' ? GetBoolean(c, refs, n, whole.data()) : GetInteger(c, refs, n, whole.data());
        values.assign(whole.begin(), whole.end());
        return status;
    }
    int set(char type, const unsigned* refs, std::size_t n, const std::vector<double>& values) {
        if (type == 'r') return SetReal(c, refs, n, values.data());
        std::vector<int> whole(n);
        for (std::size_t i = 0; i < n; ++i) whole[i] = std::fabs(values[i]) < 2e9 ? static_cast<int>(values[i]) : -1;
        return type == 'b' ? SetBoolean(c, refs, n, whole.data()) : SetInteger(c, refs, n, whole.data());
    }
    int derivative(const std::vector<unsigned>& unknowns, const std::vector<unsigned>& knowns, const double* seed,
                   double* answer) {
        return GetDirectionalDerivative(c, unknowns.data(), unknowns.size(), knowns.data(), knowns.size(), seed, answer);
    }
    int step(double t_s, double step_s) { return DoStep(c, t_s, step_s, fmi2True); }
    int update() {
        fmi2EventInfo info;
        return NewDiscreteStates(c, &info);
    }
    int mode(int which) { return which ? EnterEventMode(c) : EnterContinuousTimeMode(c); }
    int completed() {
        fmi2Boolean enter, end;
        return CompletedIntegratorStep(c, fmi2True, &enter, &end);
    }
    int write(State s, std::vector<char>& b) { return SerializeFMUstate(c, s, b.data(), b.size()); }
    int read(const std::vector<char>& b, std::size_t n, State* s) { return DeSerializeFMUstate(c, b.data(), n, s); }
};

struct Fmi3 {
    static constexpr int version = 3;
    using State = fmi3FMUState;
    void* library;
    fmi3Instance c = nullptr;
    CALLS_OF_BOTH(3);
    CALL(3, InstantiateModelExchange);
    CALL(3, InstantiateCoSimulation);
    CALL(3, GetFloat64);
    CALL(3, GetInt32);
    CALL(3, GetInt64);
    CALL(3, GetClock);
    CALL(3, SetFloat64);
    CALL(3, SetInt32);
    CALL(3, SetInt64);
    CALL(3, SetClock);
    CALL(3, GetFMUState);
    CALL(3, SetFMUState);
    CALL(3, FreeFMUState);
    CALL(3, SerializedFMUStateSize);
    CALL(3, SerializeFMUState);
    CALL(3, DeserializeFMUState);
    CALL(3, EnterStepMode);
    CALL(3, UpdateDiscreteStates);
    CALL(3, GetContinuousStateDerivatives);

    void instantiate(const Plan& plan, Chance& chance) {
        c = plan.model_exchange
                ? InstantiateModelExchange("random", plan.token.c_str(), plan.resources.c_str(), false, true, nullptr, log3)
                : InstantiateCoSimulation("random", plan.token.c_str(), plan.resources.c_str(), false, true,
                                          chance.choice(2) == 1, chance.choice(2) == 1, nullptr, 0, nullptr, log3, nullptr);
    }
    int initialise(double start_s) { return EnterInitializationMode(c, false, 0, start_s, false, 0); }
    template <class T, class Get>
    int get_as(Get call, const unsigned* refs, std::size_t n, std::vector<double>& values) {
        const std::size_t m = values.size();
        T whole[256] = {};
        const int status = call(c, refs, n, whole, m);
        for (std::size_t i = 0; i < m; ++i) values[i] = static_cast<double>(whole[i]);
        return status;
    }
    int get(char type, const unsigned* refs, std::size_t n, std::vector<double>& values) {
        switch (type) {
        case 'r': return get_as<double>(GetFloat64, refs, n, values);
        case 'i': return get_as<fmi3Int32>(GetInt32, refs, n, values);
        case 'e': return get_as<fmi3Int64>(GetInt64, refs, n, values);
        case 'b': return get_as<fmi3Boolean>(GetBoolean, refs, n, values);
        default: {
            fmi3Clock ticks[256] = {};
            return GetClock(c, refs, n, ticks);
        }
        }
    }
    template <class T, class Set>
    int set_as(Set call, const unsigned* refs, std::size_t n, const std::vector<double>& values) {
        T whole[256] = {};
        for (std::size_t i = 0; i < values.size(); ++i) {
            if constexpr (std::is_same_v<T, double>) whole[i] = values[i];
            else whole[i] = std::fabs(values[i]) < 2e9 ? static_cast<T>(values[i]) : T(-1);
        }
        return call(c, refs, n, whole, values.size());
    }
    int set(char type, const unsigned* refs, std::size_t n, const std::vector<double>& values) {
        switch (type) {
        case 'r': return set_as<double>(SetFloat64, refs, n, values);
        case 'i': return set_as<fmi3Int32>(SetInt32, refs, n, values);
        case 'e': return set_as<fmi3Int64>(SetInt64, refs, n, values);
        case 'b': return set_as<fmi3Boolean>(SetBoolean, refs, n, values);
        default: {
            fmi3Clock ticks[256] = {};
            for (std::size_t i = 0; i < n; ++i) ticks[i] = values[i] > 0;
            return SetClock(c, refs, n, ticks);
        }
        }
    }
    int derivative(const std::vector<unsigned>& unknowns, const std::vector<unsigned>& knowns, const double* seed,
                   double* answer) {
        return GetDirectionalDerivative(c, unknowns.data(), unknowns.size(), knowns.data(), knowns.size(), seed, knowns.size(),
                                        answer, unknowns.size());
    }
    int step(double t_s, double step_s) {
        bool event, end, early;
        double reached_s;
        return DoStep(c, t_s, step_s, true, &event, &end, &early, &reached_s);
    }
    int update() {
        bool needed, end, nominals, values, defined;
        double next_s;
        return UpdateDiscreteStates(c, &needed, &end, &nominals, &values, &defined, &next_s);
    }
    int mode(int which) { return which == 2 ? EnterStepMode(c) : which ? EnterEventMode(c) : EnterContinuousTimeMode(c); }
    int completed() {
        bool enter, end;
        return CompletedIntegratorStep(c, true, &enter, &end);
    }
    int write(State s, std::vector<char>& b) { return SerializeFMUState(c, s, reinterpret_cast<fmi3Byte*>(b.data()), b.size()); }
    int read(const std::vector<char>& b, std::size_t n, State* s) {
        return DeserializeFMUState(c, reinterpret_cast<const fmi3Byte*>(b.data()), n, s);
    }
};

#undef CALLS_OF_BOTH
#undef CALL
#undef CALL_AS
