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
#include "thread_time.hpp"
#include "versions.hpp"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

struct Totals {
    unsigned long long seed = 0, calls = 0, ok = 0, sequences = 0;
    double longest_s = 0;
    const char* call = "";
} totals;

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
        if (state_) fmi_.FreeFMUState(fmi_.c, &state_);
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
        case 1: timed("derivatives", [&] { return fmi_.GetContinuousStateDerivatives(fmi_.c, x.data(), n); }); break;
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
        case 0: timed("save", [&] { return fmi_.GetFMUState(fmi_.c, &state_); }); break;
        case 1:
            if (state_ || !ordinary_) timed("load", [&] { return fmi_.SetFMUState(fmi_.c, state_); });
            break;
        case 2: timed("free state", [&] { return fmi_.FreeFMUState(fmi_.c, &state_); }); break;
        default: serialise();
        }
    }
    void serialise() {
        std::size_t size = 0;
        if (!state_ || timed("size of state", [&] { return fmi_.SerializedFMUStateSize(fmi_.c, state_, &size); })) return;
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
            timed("load", [&] { return fmi_.SetFMUState(fmi_.c, other); });
        fmi_.FreeFMUState(fmi_.c, &other);
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
