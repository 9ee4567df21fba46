// The functions of FMI 2.0 in any order, in any mode, with any references and values.
#include "fmu_input.hpp"

#include <fmi2Functions.h>

namespace {

using fuzz::description;
using fuzz::Input;
using hnav::fmu::Type;

void log(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String text, ...) {
    HOLDS(text && *text);
    ++fuzz::messages;
}

const fmi2CallbackFunctions callbacks = {log, nullptr, nullptr, nullptr, nullptr};

struct Sequence {
    fmi2Component c;
    fuzz::Clock clock;
    fmi2FMUstate state = nullptr;

    void answered(fmi2Status status) const { HOLDS(status == fmi2OK || (status == fmi2Error && fuzz::messages > 0)); }

    template <class T, class Get>
    void get(Input& in, Type type, Get read) {
        fmi2ValueReference references[4];
        T values[4];
        const std::size_t n = in.choice(5);
        for (std::size_t i = 0; i < n; ++i) references[i] = fuzz::reference(in, type);
        const fmi2Status status = read(c, references, n, values);
        answered(status);
        for (std::size_t i = 0; i < n && status == fmi2OK; ++i) fuzz::look_at(references[i], static_cast<double>(values[i]));
    }

    template <class T, class Set>
    void set(Input& in, Type type, Set write) {
        const fuzz::Setting<T> setting(in, type);
        answered(write(c, setting.references, setting.n, setting.values));
    }

    void snapshot(Input& in) {
        switch (in.choice(4)) {
        case 0: answered(fmi2GetFMUstate(c, &state)); break;
        case 1: answered(fmi2SetFMUstate(c, state)); break;
        case 2: answered(fmi2FreeFMUstate(c, &state)); break;
        default: {
            std::size_t size = 0;
            if (fmi2SerializedFMUstateSize(c, state, &size) != fmi2OK) return;
            std::vector<unsigned char> bytes(size);
            HOLDS(fmi2SerializeFMUstate(c, state, reinterpret_cast<fmi2Byte*>(bytes.data()), size) == fmi2OK);
            fuzz::damage(in, bytes);
            fmi2FMUstate other = nullptr;
            const fmi2Status status =
                fmi2DeSerializeFMUstate(c, reinterpret_cast<const fmi2Byte*>(bytes.data()), bytes.size() - in.choice(2), &other);
            answered(status);
            HOLDS((other != nullptr) == (status == fmi2OK));
            if (status == fmi2OK) answered(fmi2SetFMUstate(c, other));
            fmi2FreeFMUstate(c, &other);
        }
        }
        fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &clock.t_s);
    }

    void step(Input& in) {
        const double step_s = clock.step(in);
        answered(fmi2DoStep(c, clock.now(in), step_s, fmi2True));
        fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &clock.t_s);
    }

    void model_exchange(Input& in) {
        double x[64];
        const std::size_t nx = in.choice(16) == 15 ? in.choice(64) : static_cast<std::size_t>(description().nx);
        fmi2Boolean enter, end;
        switch (in.choice(8)) {
        case 0: answered(fmi2EnterEventMode(c)); break;
        case 1: {
            fmi2EventInfo info;
            answered(fmi2NewDiscreteStates(c, &info));
            break;
        }
        case 2: answered(fmi2EnterContinuousTimeMode(c)); break;
        case 3: answered(fmi2CompletedIntegratorStep(c, fmi2True, &enter, &end)); break;
        case 4: {
            const double t_s = clock.next(in);
            if (fmi2SetTime(c, t_s) == fmi2OK) clock.t_s = t_s;
            break;
        }
        case 5:
            if (fmi2GetContinuousStates(c, x, nx) != fmi2OK) break;
            HOLDS(fuzz::finite(x, static_cast<int>(nx)));
            for (int n = in.choice(3); n > 0 && nx > 0; --n) x[in.choice(static_cast<int>(nx))] = in.number();
            answered(fmi2SetContinuousStates(c, x, nx));
            break;
        case 6: answered(fmi2GetDerivatives(c, x, nx)); break;
        default:
            answered(fmi2GetNominalsOfContinuousStates(c, x, nx));
            answered(fmi2GetEventIndicators(c, x, in.choice(2)));
            break;
        }
    }

    void derivative(Input& in) {
        fuzz::Direction d(in);
        answered(fmi2GetDirectionalDerivative(c, d.unknowns, d.n, d.knowns, d.k, d.seed, d.sensitivity));
    }

    void life(Input& in) {
        switch (in.choice(8)) {
        case 0:
            answered(fmi2Reset(c));
            clock.t_s = 0;
            break;
        case 1: answered(fmi2Terminate(c)); break;
        case 2: {
            const double start = in.flag() ? in.number() : 0;
            const bool stop = in.flag();
            if (fmi2SetupExperiment(c, fmi2False, 0, start, stop, stop ? in.number() : 0) == fmi2OK) clock.t_s = start;
            break;
        }
        case 3: answered(fmi2SetDebugLogging(c, in.flag(), 0, nullptr)); break;
        case 4: answered(fmi2GetString(c, nullptr, in.choice(2), nullptr)); break;
        case 5: answered(fmi2GetReal(c, nullptr, 1, nullptr)); break;
        case 6: answered(fmi2CancelStep(c)); break;
        default:
            answered(fmi2EnterInitializationMode(c));
            answered(fmi2ExitInitializationMode(c));
            break;
        }
    }

    void call(Input& in) {
        fuzz::messages = 0;
        switch (in.choice(14)) {
        case 0: get<double>(in, Type::real, fmi2GetReal); break;
        case 1: get<int>(in, in.flag() ? Type::integer : Type::enumeration, fmi2GetInteger); break;
        case 2: get<int>(in, Type::boolean, fmi2GetBoolean); break;
        case 3:
        case 4: set<double>(in, Type::real, fmi2SetReal); break;
        case 5: set<int>(in, in.flag() ? Type::integer : Type::enumeration, fmi2SetInteger); break;
        case 6: set<int>(in, Type::boolean, fmi2SetBoolean); break;
        case 7: snapshot(in); break;
        case 8:
        case 9: step(in); break;
        case 10:
        case 11: model_exchange(in); break;
        case 12: derivative(in); break;
        default: life(in); break;
        }
    }
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    Input in(bytes, size);
    const int head = in.byte();
    const fmi2Type type = head & 1 ? fmi2ModelExchange : fmi2CoSimulation;
    fuzz::messages = 0;
    HOLDS(!fmi2Instantiate("fuzz", type, head & 2 ? "{}" : nullptr, nullptr, &callbacks, fmi2False, fmi2False) &&
          fuzz::messages > 0);
    Sequence s{fmi2Instantiate("fuzz", type, description().token, nullptr, &callbacks, fmi2False, fmi2True), {}, nullptr};
    HOLDS(s.c);
    if (head & 4) { // directly to step mode
        HOLDS(fmi2SetupExperiment(s.c, fmi2False, 0, 0, fmi2False, 0) == fmi2OK);
        HOLDS(fmi2EnterInitializationMode(s.c) == fmi2OK && fmi2ExitInitializationMode(s.c) == fmi2OK);
    }
    for (int calls = 0; calls < 100 && !in.end(); ++calls) s.call(in);
    // A reset succeeds after any calls.
    HOLDS(fmi2Reset(s.c) == fmi2OK && fmi2SetupExperiment(s.c, fmi2False, 0, 0, fmi2False, 0) == fmi2OK);
    HOLDS(fmi2EnterInitializationMode(s.c) == fmi2OK && fmi2ExitInitializationMode(s.c) == fmi2OK);
    if (type == fmi2CoSimulation) HOLDS(fmi2DoStep(s.c, 0, 0.01, fmi2True) == fmi2OK);
    fmi2FreeFMUstate(s.c, &s.state);
    fmi2FreeInstance(s.c);
    return 0;
}
