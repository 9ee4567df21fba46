// The functions of FMI 3.0 in any order, in any mode, with any references and values.
#include "fmu_input.hpp"

#include <fmi3Functions.h>

namespace {

using fuzz::description;
using fuzz::Input;
using hnav::fmu::Type;

void log(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String text) {
    HOLDS(text && *text);
    ++fuzz::messages;
}

fmi3Instance in_callback = nullptr;

// While a step is in progress the importer may read; all other calls must be refused.
void intermediate(fmi3InstanceEnvironment, fmi3Float64 t_s, fmi3Boolean, fmi3Boolean get_allowed, fmi3Boolean, fmi3Boolean,
                  fmi3Boolean*, fmi3Float64*) {
    const fmi3ValueReference time = 1;
    double value;
    HOLDS(std::isfinite(t_s) && get_allowed && fmi3GetFloat64(in_callback, &time, 1, &value, 1) == fmi3OK);
    HOLDS(fmi3Reset(in_callback) == fmi3Error && fmi3Terminate(in_callback) == fmi3Error);
}

struct Sequence {
    fmi3Instance c;
    fuzz::Clock clock;
    fmi3FMUState state = nullptr;

    void answered(fmi3Status status) const { HOLDS(status == fmi3OK || (status == fmi3Error && fuzz::messages > 0)); }

    // The time of the instance is its first variable.
    void read_time() {
        const fmi3ValueReference time = 1;
        double t_s;
        if (fmi3GetFloat64(c, &time, 1, &t_s, 1) == fmi3OK) clock.t_s = t_s;
    }

    template <class T, class Get>
    void get(Input& in, Type type, Get read) {
        fmi3ValueReference references[4];
        T values[4];
        const std::size_t n = in.choice(5), n_values = in.choice(16) == 15 ? in.choice(4) : n;
        for (std::size_t i = 0; i < n; ++i) references[i] = fuzz::reference(in, type);
        const fmi3Status status = read(c, references, n, values, n_values);
        answered(status);
        if (n != n_values) HOLDS(status != fmi3OK);
        for (std::size_t i = 0; i < n && status == fmi3OK; ++i) fuzz::look_at(references[i], static_cast<double>(values[i]));
    }

    template <class T, class Set>
    void set(Input& in, Type type, Set write) {
        const fuzz::Setting<T> setting(in, type);
        answered(write(c, setting.references, setting.n, setting.values, setting.n));
    }

    void snapshot(Input& in) {
        switch (in.choice(4)) {
        case 0: answered(fmi3GetFMUState(c, &state)); break;
        case 1: answered(fmi3SetFMUState(c, state)); break;
        case 2: answered(fmi3FreeFMUState(c, &state)); break;
        default: {
            std::size_t size = 0;
            if (fmi3SerializedFMUStateSize(c, state, &size) != fmi3OK) return;
            std::vector<unsigned char> bytes(size);
            HOLDS(fmi3SerializeFMUState(c, state, bytes.data(), size) == fmi3OK);
            const std::vector<unsigned char> whole = bytes;
            fuzz::damage(in, bytes);
            fmi3FMUState other = nullptr;
            const fmi3Status status = fmi3DeserializeFMUState(c, bytes.data(), bytes.size() - in.choice(2), &other);
            answered(status);
            HOLDS((other != nullptr) == (status == fmi3OK));
            HOLDS(status != fmi3OK || bytes == whole);
            if (status == fmi3OK) answered(fmi3SetFMUState(c, other));
            fmi3FreeFMUState(c, &other);
        }
        }
        read_time();
    }

    void step(Input& in) {
        fmi3Boolean event, end, early;
        double reached = clock.t_s;
        const double step_s = clock.step(in), now_s = clock.now(in);
        in_callback = c;
        const fmi3Status status = fmi3DoStep(c, now_s, step_s, fmi3True, &event, &end, &early, &reached);
        answered(status);
        HOLDS(!std::isnan(reached) && (status != fmi3OK || early || reached == now_s + step_s));
        read_time();
    }

    void modes(Input& in) {
        fmi3Boolean needed, end, nominals, values, defined;
        double next;
        switch (in.choice(4)) {
        case 0: answered(fmi3EnterEventMode(c)); break;
        case 1: answered(fmi3EnterStepMode(c)); break;
        case 2: answered(fmi3EnterContinuousTimeMode(c)); break;
        default:
            answered(fmi3UpdateDiscreteStates(c, &needed, &end, &nominals, &values, &defined, &next));
            HOLDS(!defined || std::isfinite(next));
            break;
        }
    }

    void model_exchange(Input& in) {
        double x[64];
        const std::size_t nx = in.choice(16) == 15 ? in.choice(64) : static_cast<std::size_t>(description().nx);
        fmi3Boolean enter, end;
        switch (in.choice(5)) {
        case 0: answered(fmi3CompletedIntegratorStep(c, fmi3True, &enter, &end)); break;
        case 1: {
            const double t_s = clock.next(in);
            if (fmi3SetTime(c, t_s) == fmi3OK) clock.t_s = t_s;
            break;
        }
        case 2:
            if (fmi3GetContinuousStates(c, x, nx) != fmi3OK) break;
            HOLDS(fuzz::finite(x, static_cast<int>(nx)));
            for (int n = in.choice(3); n > 0 && nx > 0; --n) x[in.choice(static_cast<int>(nx))] = in.number();
            answered(fmi3SetContinuousStates(c, x, nx));
            break;
        case 3: answered(fmi3GetContinuousStateDerivatives(c, x, nx)); break;
        default:
            answered(fmi3GetNominalsOfContinuousStates(c, x, nx));
            answered(fmi3GetEventIndicators(c, x, in.choice(2)));
            break;
        }
    }

    void derivative(Input& in) {
        fuzz::Direction d(in);
        answered(fmi3GetDirectionalDerivative(c, d.unknowns, d.n, d.knowns, d.k, d.seed, in.choice(8) == 7 ? 3 : d.k,
                                              d.sensitivity, d.n));
    }

    void life(Input& in) {
        switch (in.choice(8)) {
        case 0:
            answered(fmi3Reset(c));
            clock.t_s = 0;
            break;
        case 1: answered(fmi3Terminate(c)); break;
        case 2: {
            const double start = in.flag() ? in.number() : 0;
            const bool stop = in.flag();
            if (fmi3EnterInitializationMode(c, fmi3False, 0, start, stop, stop ? in.number() : 0) == fmi3OK) clock.t_s = start;
            break;
        }
        case 3: answered(fmi3SetDebugLogging(c, in.flag(), 0, nullptr)); break;
        case 4: answered(fmi3GetString(c, nullptr, in.choice(2), nullptr, 0)); break;
        case 5: answered(fmi3GetFloat64(c, nullptr, 1, nullptr, 1)); break;
        case 6: answered(fmi3EnterConfigurationMode(c)); break;
        default: answered(fmi3ExitInitializationMode(c)); break;
        }
    }

    void call(Input& in) {
        fuzz::messages = 0;
        switch (in.choice(15)) {
        case 0: get<double>(in, Type::real, fmi3GetFloat64); break;
        case 1: get<fmi3Int64>(in, Type::enumeration, fmi3GetInt64); break;
        case 2: get<bool>(in, Type::boolean, fmi3GetBoolean); break;
        case 3: get<fmi3Int32>(in, Type::integer, fmi3GetInt32); break;
        case 4:
        case 5: set<double>(in, Type::real, fmi3SetFloat64); break;
        case 6: set<fmi3Int64>(in, Type::enumeration, fmi3SetInt64); break;
        case 7: set<bool>(in, Type::boolean, fmi3SetBoolean); break;
        case 8: snapshot(in); break;
        case 9:
        case 10: step(in); break;
        case 11: modes(in); break;
        case 12: model_exchange(in); break;
        case 13: derivative(in); break;
        default: life(in); break;
        }
    }
};

fmi3Instance instantiate(int head, const char* token) {
    if (head & 1) return fmi3InstantiateModelExchange("fuzz", token, nullptr, fmi3False, fmi3True, nullptr, log);
    return fmi3InstantiateCoSimulation("fuzz", token, nullptr, fmi3False, fmi3True, head & 8, head & 16, nullptr, 0, nullptr, log,
                                       head & 32 ? intermediate : nullptr);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    Input in(bytes, size);
    const int head = in.byte();
    fuzz::messages = 0;
    HOLDS(!instantiate(head, head & 2 ? "{}" : nullptr) && fuzz::messages > 0);
    Sequence s{instantiate(head, description().token), {}, nullptr};
    HOLDS(s.c);
    if (head & 4) // directly to step mode
        HOLDS(fmi3EnterInitializationMode(s.c, fmi3False, 0, 0, fmi3False, 0) == fmi3OK &&
              fmi3ExitInitializationMode(s.c) == fmi3OK);
    for (int calls = 0; calls < 100 && !in.end(); ++calls) s.call(in);
    // A reset succeeds after any calls.
    HOLDS(fmi3Reset(s.c) == fmi3OK);
    HOLDS(fmi3EnterInitializationMode(s.c, fmi3False, 0, 0, fmi3False, 0) == fmi3OK && fmi3ExitInitializationMode(s.c) == fmi3OK);
    s.clock.t_s = 0;
    if (!(head & 1)) {
        fmi3Boolean flags[3];
        double reached;
        if (head & 8) HOLDS(fmi3EnterStepMode(s.c) == fmi3OK);
        in_callback = s.c;
        HOLDS(fmi3DoStep(s.c, 0, 0.01, fmi3True, flags, flags + 1, flags + 2, &reached) == fmi3OK);
    }
    fmi3FreeFMUState(s.c, &s.state);
    fmi3FreeInstance(s.c);
    return 0;
}
