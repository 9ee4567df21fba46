// Random calls on the binary of an FMU, as an importer may make them in any order, with any value:
//
//     driver BINARY PLAN FIRST_SEED SECONDS
//
// The plan is text, written by the study from the model description, so that nothing here reads XML:
//
//     2 | 3   CS | ME              version of FMI, kind
//     instantiation token
//     resource folder              as a URI for FMI 2, as a path for FMI 3
//     states   variables           how many
//     reference type causality count minimum maximum      a line for each variable; type: r i e b c, causality: p i o s
//
// Each sequence has a seed and up to 200 calls. Half of them are ordinary: parameters and inputs are finite and within their ranges
// and outputs have to be finite. The others hold values at which arithmetic breaks, times far ahead and behind, and saved states
// with damaged bytes. A call answers OK, or something else with a message. The last line of the output counts the calls and has the
// longest time of one in seconds of this thread; a broken promise or a crash names the seed and exits with 1.
#include <dlfcn.h>
#include <time.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <fmi2FunctionTypes.h>
#include <fmi3FunctionTypes.h>

namespace {

struct Variable {
    unsigned reference;
    char type, causality;
    int count;
    double min, max;
};

struct Plan {
    int version = 0;
    bool model_exchange = false;
    std::string token, resources;
    int nx = 0;
    std::vector<Variable> variables;
};

struct Totals {
    unsigned long long seed = 0, calls = 0, ok = 0, sequences = 0;
    double longest_s = 0;
    const char* call = "";
} totals;
int messages = 0;

[[noreturn]] void broken(const char* promise) {
    std::printf("seed %llu, %s: %s\n", totals.seed, totals.call, promise);
    std::exit(1);
}

void crashed(int signal) {
    char line[200];
    const int length = std::snprintf(line, sizeof line, "seed %llu, %s: signal %d\n", totals.seed, totals.call, signal);
    if (write(1, line, static_cast<size_t>(length)) < 0) _exit(2);
    _exit(1);
}

double cpu_s() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

Plan read_plan(const char* path) {
    std::ifstream file(path);
    Plan plan;
    std::string kind;
    std::size_t n = 0;
    file >> plan.version >> kind >> std::ws;
    plan.model_exchange = kind == "ME";
    std::getline(file, plan.token);
    std::getline(file, plan.resources);
    file >> plan.nx >> n;
    plan.variables.resize(n);
    for (Variable& v : plan.variables) {
        std::string low, high; // streams do not read inf
        file >> v.reference >> v.type >> v.causality >> v.count >> low >> high;
        v.min = std::strtod(low.c_str(), nullptr), v.max = std::strtod(high.c_str(), nullptr);
    }
    if (!file) {
        std::fprintf(stderr, "%s is no plan\n", path);
        std::exit(2);
    }
    return plan;
}

class Chance {
public:
    explicit Chance(unsigned long long seed) : engine_(seed) {}

    int choice(int count) { return static_cast<int>(engine_() % static_cast<unsigned long long>(count)); }
    double within(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53; }

    // A value that the variable takes: within its range, in orders of magnitude where that is positive or has no end.
    double ordinary(const Variable& v) {
        const bool low = std::isfinite(v.min), high = std::isfinite(v.max);
        if (v.type != 'r') return std::floor(within(low ? v.min : 0, (high ? v.max : 3) + 1));
        if (!low && !high) return (choice(2) ? 1 : -1) * std::pow(10, within(-4, 1.5));
        if (!high) return v.min + std::pow(10, within(-4, 1.5));
        if (!low) return v.max - std::pow(10, within(-4, 1.5));
        if (v.min >= 0 && v.max > 0)
            return std::fmax(v.min, v.max * std::pow(10, within(std::log10(std::fmax(v.min / v.max, 1e-9)), 0)));
        return within(v.min, v.max);
    }

    double wild() {
        constexpr double inf = std::numeric_limits<double>::infinity();
        constexpr double values[] = {0.0,      -0.0, NAN,  inf,    -inf,  5e-324, 2.3e-308, 1.7e308,
                                     -1.7e308, 1e6,  -1e6, 1e-150, 1e150, 1,      -1};
        switch (choice(4)) {
        case 0: return values[choice(sizeof values / sizeof *values)];
        case 1: {
            const unsigned long long bits = engine_();
            double value;
            std::memcpy(&value, &bits, sizeof value);
            return value;
        }
        default: return within(-1, 1) * std::pow(10, within(-6, 8));
        }
    }

private:
    std::mt19937_64 engine_;
};

template <class Function>
Function* symbol(void* library, const char* name) {
    void* address = dlsym(library, name);
    if (!address) {
        std::fprintf(stderr, "the binary has no function %s\n", name);
        std::exit(2);
    }
    return reinterpret_cast<Function*>(address);
}

// ------------------------------------------------------------------------------- both versions by the same calls

void log2(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String text, ...) { messages += text && *text; }
void log3(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String text) { messages += text && *text; }

#define CALL(version, name) fmi##version##name##TYPE* name = symbol<fmi##version##name##TYPE>(library, "fmi" #version #name)

struct Fmi2 {
    static constexpr int version = 2;
    using State = fmi2FMUstate;
    void* library;
    fmi2Component c = nullptr;
    fmi2CallbackFunctions callbacks = {log2, std::calloc, std::free, nullptr, nullptr};
    CALL(2, Instantiate);
    CALL(2, FreeInstance);
    CALL(2, SetupExperiment);
    CALL(2, EnterInitializationMode);
    CALL(2, ExitInitializationMode);
    CALL(2, Terminate);
    CALL(2, Reset);
    CALL(2, GetReal);
    CALL(2, GetInteger);
    CALL(2, GetBoolean);
    CALL(2, SetReal);
    CALL(2, SetInteger);
    CALL(2, SetBoolean);
    CALL(2, GetFMUstate);
    CALL(2, SetFMUstate);
    CALL(2, FreeFMUstate);
    CALL(2, SerializedFMUstateSize);
    CALL(2, SerializeFMUstate);
    CALL(2, DeSerializeFMUstate);
    CALL(2, GetDirectionalDerivative);
    CALL(2, DoStep);
    CALL(2, EnterEventMode);
    CALL(2, NewDiscreteStates);
    CALL(2, EnterContinuousTimeMode);
    CALL(2, CompletedIntegratorStep);
    CALL(2, SetTime);
    CALL(2, SetContinuousStates);
    CALL(2, GetContinuousStates);
    CALL(2, GetDerivatives);
    CALL(2, GetNominalsOfContinuousStates);
    CALL(2, GetEventIndicators);

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
    int derivatives(double* x, std::size_t n) { return GetDerivatives(c, x, n); }
    int save(State* s) { return GetFMUstate(c, s); }
    int load(State s) { return SetFMUstate(c, s); }
    int forget(State* s) { return FreeFMUstate(c, s); }
    int size_of(State s, std::size_t* n) { return SerializedFMUstateSize(c, s, n); }
    int write(State s, std::vector<char>& b) { return SerializeFMUstate(c, s, b.data(), b.size()); }
    int read(const std::vector<char>& b, std::size_t n, State* s) { return DeSerializeFMUstate(c, b.data(), n, s); }
};

struct Fmi3 {
    static constexpr int version = 3;
    using State = fmi3FMUState;
    void* library;
    fmi3Instance c = nullptr;
    CALL(3, InstantiateModelExchange);
    CALL(3, InstantiateCoSimulation);
    CALL(3, FreeInstance);
    CALL(3, EnterInitializationMode);
    CALL(3, ExitInitializationMode);
    CALL(3, Terminate);
    CALL(3, Reset);
    CALL(3, GetFloat64);
    CALL(3, GetInt32);
    CALL(3, GetInt64);
    CALL(3, GetBoolean);
    CALL(3, GetClock);
    CALL(3, SetFloat64);
    CALL(3, SetInt32);
    CALL(3, SetInt64);
    CALL(3, SetBoolean);
    CALL(3, SetClock);
    CALL(3, GetFMUState);
    CALL(3, SetFMUState);
    CALL(3, FreeFMUState);
    CALL(3, SerializedFMUStateSize);
    CALL(3, SerializeFMUState);
    CALL(3, DeserializeFMUState);
    CALL(3, GetDirectionalDerivative);
    CALL(3, DoStep);
    CALL(3, EnterEventMode);
    CALL(3, EnterStepMode);
    CALL(3, UpdateDiscreteStates);
    CALL(3, EnterContinuousTimeMode);
    CALL(3, CompletedIntegratorStep);
    CALL(3, SetTime);
    CALL(3, SetContinuousStates);
    CALL(3, GetContinuousStates);
    CALL(3, GetContinuousStateDerivatives);
    CALL(3, GetNominalsOfContinuousStates);
    CALL(3, GetEventIndicators);

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
    int derivatives(double* x, std::size_t n) { return GetContinuousStateDerivatives(c, x, n); }
    int save(State* s) { return GetFMUState(c, s); }
    int load(State s) { return SetFMUState(c, s); }
    int forget(State* s) { return FreeFMUState(c, s); }
    int size_of(State s, std::size_t* n) { return SerializedFMUStateSize(c, s, n); }
    int write(State s, std::vector<char>& b) { return SerializeFMUState(c, s, reinterpret_cast<fmi3Byte*>(b.data()), b.size()); }
    int read(const std::vector<char>& b, std::size_t n, State* s) {
        return DeserializeFMUState(c, reinterpret_cast<const fmi3Byte*>(b.data()), n, s);
    }
};

// ---------------------------------------------------------------------------------------------- one sequence

template <class Fmi>
class Sequence {
public:
    Sequence(Fmi& fmi, const Plan& plan, unsigned long long seed)
        : fmi_(fmi), plan_(plan), chance_(seed), ordinary_(seed % 2 == 0) {}

    void run() {
        timed("instantiate", [&] {
            fmi_.instantiate(plan_, chance_);
            return 0;
        });
        if (!fmi_.c) broken("no instance");
        for (int n = chance_.choice(4); n > 0; --n) set();
        if (ordinary_ || chance_.choice(4)) start();
        for (int n = chance_.choice(200); n > 0; --n) call();
        if (state_) fmi_.forget(&state_);
        fmi_.FreeInstance(fmi_.c);
    }

private:
    template <class Function>
    int timed(const char* name, Function function) {
        totals.call = name;
        messages = 0;
        const double began_s = cpu_s();
        const int status = function();
        const double took_s = cpu_s() - began_s;
        ++totals.calls;
        totals.ok += status == 0;
        if (took_s > totals.longest_s) totals.longest_s = took_s;
        if (took_s > 1) std::printf("seed %llu, %s: %.1f s\n", totals.seed, name, took_s);
        if (status < 0 || status > 3) broken("a status that ends the simulation");
        if (status > 1 && messages == 0) broken("an error without a message");
        return status;
    }

    void start() {
        if (timed("initialise", [&] { return fmi_.initialise(0); })) return;
        if (chance_.choice(2)) set();
        if (chance_.choice(2)) get();
        timed("exit initialisation", [&] { return fmi_.ExitInitializationMode(fmi_.c); });
        t_s_ = 0;
    }

    // Up to four variables of one type.
    std::vector<const Variable*> some(bool settable) {
        const auto size = static_cast<int>(plan_.variables.size());
        std::vector<const Variable*> chosen;
        for (int tries = 0, n = 1 + chance_.choice(4); tries < 40 && static_cast<int>(chosen.size()) < n; ++tries) {
            const Variable& v = plan_.variables[static_cast<std::size_t>(chance_.choice(size))];
            if (settable && ordinary_ && v.causality != 'p' && v.causality != 'i') continue;
            if (chosen.empty() || chosen[0]->type == v.type) chosen.push_back(&v);
        }
        return chosen;
    }
    std::vector<unsigned> references_of(const std::vector<const Variable*>& chosen) {
        std::vector<unsigned> refs;
        for (const Variable* v : chosen)
            refs.push_back(ordinary_ || chance_.choice(32) ? v->reference : static_cast<unsigned>(chance_.choice(1 << 30)));
        return refs;
    }
    std::size_t count_of(const std::vector<const Variable*>& chosen) {
        std::size_t n = 0;
        for (const Variable* v : chosen) n += static_cast<std::size_t>(v->count);
        return n;
    }

    void set() {
        const auto chosen = some(true);
        if (chosen.empty()) return;
        const auto refs = references_of(chosen);
        std::vector<double> values;
        for (const Variable* v : chosen)
            for (int i = 0; i < v->count; ++i)
                values.push_back(ordinary_ || chance_.choice(2) ? chance_.ordinary(*v) : chance_.wild());
        timed("set", [&] { return fmi_.set(chosen[0]->type, refs.data(), refs.size(), values); });
    }

    void get() {
        const auto chosen = some(false);
        if (chosen.empty()) return;
        const auto refs = references_of(chosen);
        std::vector<double> values(count_of(chosen));
        const int status = timed("get", [&] { return fmi_.get(chosen[0]->type, refs.data(), refs.size(), values); });
        if (status || !ordinary_) return;
        std::size_t at = 0;
        for (const Variable* v : chosen)
            for (int i = 0; i < v->count; ++i, ++at) look_at(*v, values[at]);
    }
    void look_at(const Variable& v, double value) {
        char promise[120];
        if (v.causality == 'o' && v.type == 'r' && !std::isfinite(value)) {
            std::snprintf(promise, sizeof promise, "output %u is %g", v.reference, value);
            broken(promise);
        }
        if (v.type == 'e' && (value < v.min || value > v.max)) broken("an enumeration outside its values");
    }

    void step() {
        const double step_s = !ordinary_ && chance_.choice(8) == 0 ? chance_.wild() : .01 * (1 + chance_.choice(4));
        const double now_s = !ordinary_ && chance_.choice(16) == 0 ? chance_.wild() : t_s_;
        if (timed("step", [&] { return fmi_.step(now_s, step_s); }) == 0) t_s_ = now_s + step_s;
    }

    void time() {
        const double next_s = !ordinary_ && chance_.choice(8) == 0 ? chance_.wild() : t_s_ + .01 * chance_.choice(4);
        if (timed("set time", [&] { return fmi_.SetTime(fmi_.c, next_s); }) == 0) t_s_ = next_s;
    }

    void states() {
        std::vector<double> x(static_cast<std::size_t>(plan_.nx) + 1);
        const std::size_t n = !ordinary_ && chance_.choice(16) == 0 ? x.size() : x.size() - 1;
        switch (chance_.choice(4)) {
        case 0:
            if (timed("get states", [&] { return fmi_.GetContinuousStates(fmi_.c, x.data(), n); })) return;
            if (!ordinary_ && n) x[static_cast<std::size_t>(chance_.choice(static_cast<int>(n)))] = chance_.wild();
            timed("set states", [&] { return fmi_.SetContinuousStates(fmi_.c, x.data(), n); });
            break;
        case 1: timed("derivatives", [&] { return fmi_.derivatives(x.data(), n); }); break;
        case 2: timed("nominals", [&] { return fmi_.GetNominalsOfContinuousStates(fmi_.c, x.data(), n); }); break;
        default: timed("indicators", [&] { return fmi_.GetEventIndicators(fmi_.c, x.data(), 0); });
        }
    }

    void derivative() {
        std::vector<unsigned> unknowns, knowns;
        for (const Variable& v : plan_.variables)
            if (v.type == 'r' && v.count == 1 && chance_.choice(static_cast<int>(plan_.variables.size())) < 2)
                (v.causality == 'o' ? unknowns : knowns).push_back(v.reference);
        std::vector<double> seed(knowns.size() + 1, 1.), answer(unknowns.size() + 1);
        timed("directional derivative", [&] { return fmi_.derivative(unknowns, knowns, seed.data(), answer.data()); });
    }

    void snapshot() {
        switch (chance_.choice(4)) {
        case 0: timed("save", [&] { return fmi_.save(&state_); }); break;
        case 1:
            if (state_ || !ordinary_) timed("load", [&] { return fmi_.load(state_); });
            break;
        case 2: timed("free state", [&] { return fmi_.forget(&state_); }); break;
        default: serialise();
        }
    }
    void serialise() {
        std::size_t size = 0;
        if (!state_ || timed("size of state", [&] { return fmi_.size_of(state_, &size); })) return;
        std::vector<char> bytes(size);
        timed("serialise", [&] { return fmi_.write(state_, bytes); });
        if (!ordinary_)
            for (int n = chance_.choice(4); n > 0 && size; --n) {
                const auto at = static_cast<std::size_t>(
                    chance_.choice(static_cast<int>(chance_.choice(2) ? size : std::min<std::size_t>(size, 96))));
                bytes[at] = static_cast<char>(bytes[at] ^ (1 + chance_.choice(255)));
            }
        typename Fmi::State other = nullptr;
        const std::size_t given = ordinary_ ? size : size - static_cast<std::size_t>(chance_.choice(2));
        if (timed("deserialise", [&] { return fmi_.read(bytes, given, &other); }) == 0)
            timed("load", [&] { return fmi_.load(other); });
        fmi_.forget(&other);
    }

    void life() {
        switch (chance_.choice(4)) {
        case 0: timed("reset", [&] { return fmi_.Reset(fmi_.c); }); break;
        case 1: timed("terminate", [&] { return fmi_.Terminate(fmi_.c); }); break;
        default: start();
        }
    }

    // What moves the time on.
    void flow() {
        if (!plan_.model_exchange || (!ordinary_ && chance_.choice(32) == 0)) return step();
        switch (chance_.choice(4)) {
        case 0: return time();
        case 1: timed("completed step", [&] { return fmi_.completed(); }); return;
        default: return states();
        }
    }

    void call() {
        const int which = chance_.choice(16);
        if (which < 3) return get();
        if (which < 6) return set();
        switch (which) {
        case 6: return snapshot();
        case 7: timed("mode", [&] { return fmi_.mode(chance_.choice(Fmi::version)); }); return;
        case 8: timed("update", [&] { return fmi_.update(); }); return;
        case 9: return derivative();
        case 10:
            if (chance_.choice(8) == 0) life();
            return;
        default: return flow();
        }
    }

    Fmi& fmi_;
    const Plan& plan_;
    Chance chance_;
    typename Fmi::State state_ = nullptr;
    double t_s_ = 0;
    bool ordinary_;
};

template <class Fmi>
void run(void* library, const Plan& plan, unsigned long long first, double seconds) {
    Fmi fmi{library};
    const double began_s = cpu_s();
    do {
        totals.seed = first + totals.sequences++;
        Sequence<Fmi>(fmi, plan, totals.seed).run();
    } while (cpu_s() - began_s < seconds);
}

} // namespace

int main(int count, char** arguments) {
    if (count != 5) {
        std::fprintf(stderr, "driver BINARY PLAN FIRST_SEED SECONDS\n");
        return 2;
    }
    void* library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        std::fprintf(stderr, "%s\n", dlerror());
        return 2;
    }
    const Plan plan = read_plan(arguments[2]);
    for (int signal : {SIGSEGV, SIGFPE, SIGABRT, SIGBUS, SIGILL}) std::signal(signal, crashed);
    const unsigned long long first = std::strtoull(arguments[3], nullptr, 10);
    const double seconds = std::atof(arguments[4]);
    if (plan.version == 2) run<Fmi2>(library, plan, first, seconds);
    else run<Fmi3>(library, plan, first, seconds);
    std::printf("%llu calls, %llu ok, in %llu sequences, longest %.3f s\n", totals.calls, totals.ok, totals.sequences,
                totals.longest_s);
}
