#include "observer/plan.hpp"

#include "base/memory.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>

namespace hnav::observer {
namespace {

enum Kind { states, inputs, unknowns, parameters, kinds };

// The words of one line, taken one after the other.
class Words {
public:
    explicit Words(char* line) : next_(line) { next_[std::strcspn(next_, "\r\n")] = '\0'; }

    const char* word() {
        next_ += std::strspn(next_, " \t");
        char* begin = next_;
        next_ += std::strcspn(next_, " \t");
        if (*next_) *next_++ = '\0';
        return begin;
    }

    bool any() { return *rest() != '\0'; }

    const char* rest() { return next_ + std::strspn(next_, " \t"); }

    double number() {
        const char* text = word();
        char* end = nullptr;
        const double value = std::strtod(text, &end);
        if (end == text || *end) whole_ = false;
        return value;
    }

    std::uint32_t reference() {
        const double value = number();
        if (!(value >= 0 && value <= 4294967295.0 && value == std::floor(value))) whole_ = false;
        return whole_ ? static_cast<std::uint32_t>(value) : 0;
    }

    bool flag() {
        const double value = number();
        if (value != 0 && value != 1) whole_ = false;
        return value == 1;
    }

    bool whole() const { return whole_; }

private:
    char* next_;
    bool whole_ = true;
};

// Statistics of an estimated number, until the number of states is known.
struct Estimated {
    double start, sigma, noise, nominal, ready, time_constant;

    void read(Words& words) {
        start = words.number();
        sigma = words.number();
        noise = words.number();
        nominal = words.number();
        ready = words.number();
    }
};

// Reads line after line.
class Reader {
public:
    explicit Reader(Plan& plan) : plan_(plan) {}

    // Null: the line was read.
    const char* take(Words& words) {
        const char* key = words.word();
        if (!*key) return nullptr;
        if (is(key, "end")) return ended_ = true, nullptr;
        if (is(key, "identifier")) return text(words.rest(), plan_.identifier, sizeof plan_.identifier);
        if (is(key, "token")) return text(words.rest(), plan_.token, sizeof plan_.token);
        if (is(key, "binary")) return text(words.rest(), plan_.binary, sizeof plan_.binary);
        if (const char* refused = take_numbers(key, words)) return refused;
        return words.whole() ? nullptr : "a number is missing or is none";
    }

    bool ended() const { return ended_; }

    // Collects the rows that were read.
    void finish() {
        plan_.sizes.states = count_[states];
        plan_.sizes.inputs = count_[inputs] + count_[unknowns];
        plan_.sizes.unknown_inputs = count_[unknowns];
        plan_.sizes.parameters = count_[parameters];
        for (int i = 0; i < count_[unknowns]; ++i) {
            plan_.input[count_[inputs] + i] = unknown_[i];
            plan_.input_is_discrete[count_[inputs] + i] = false;
            plan_.time_constant_s[i] = row_[unknowns][i].time_constant;
        }
        int next = 0;
        for (const Kind kind : {states, unknowns, parameters})
            for (int i = 0; i < count_[kind] && next < max_estimated; ++i, ++next) {
                const Estimated& e = row_[kind][i];
                plan_.start[next] = e.start;
                plan_.start_sigma[next] = e.sigma;
                plan_.noise[next] = e.noise;
                plan_.nominal[next] = e.nominal;
                plan_.ready_sigma[next] = e.ready;
            }
    }

private:
    static bool is(const char* key, const char* name) { return std::strcmp(key, name) == 0; }

    static const char* text(const char* from, char* to, std::size_t size) {
        if (std::strlen(from) >= size) return "a text is too long";
        std::strcpy(to, from);
        return nullptr;
    }

    // Null: the line is another one.
    bool* flag_of(const char* key) {
        const struct {
            const char* name;
            bool* flag;
        } flags[] = {{"derivatives", &plan_.derivatives}, {"discrete", &plan_.discrete},
                     {"step_done", &plan_.step_done},     {"once", &plan_.once},
                     {"memoryless", &plan_.memoryless},   {"never_freed", &plan_.never_freed}};
        for (const auto& f : flags)
            if (is(key, f.name)) return f.flag;
        return nullptr;
    }

    const char* take_numbers(const char* key, Words& words) {
        if (is(key, "fmi")) return plan_.fmi = static_cast<int>(words.reference()), nullptr;
        if (is(key, "indicators")) return plan_.indicators = static_cast<int>(words.reference()), nullptr;
        if (bool* flag = flag_of(key)) return *flag = words.flag(), nullptr;
        if (is(key, "state_access")) return plan_.state_access = static_cast<int>(words.reference()), nullptr;
        if (is(key, "cosimulation")) return take_step(words);
        if (is(key, "set")) return take_set(words);
        if (is(key, "state")) return take_state(words);
        if (is(key, "input")) return take_input(words);
        if (is(key, "unknown")) return take_unknown(words);
        if (is(key, "parameter")) return take_parameter(words);
        if (is(key, "sensor")) return take_sensor(words);
        if (is(key, "bound")) return take_bound(words);
        if (is(key, "logarithmic")) return take_logarithmic(words);
        if (is(key, "depends")) return take_dependencies(words);
        return "its first word is not known";
    }

    const char* more_than(int most, const char* what) {
        std::snprintf(said_, sizeof said_, "there are more than %d %s", most, what);
        return said_;
    }

    const char* take_step(Words& words) {
        plan_.step_s = words.number();
        return plan_.step_s >= 0 && std::isfinite(plan_.step_s) ? nullptr : "a step has to be finite and at least 0";
    }

    const char* take_set(Words& words) {
        if (plan_.set_count == max_set) return "there are too many start values";
        plan_.set[plan_.set_count] = words.reference();
        plan_.set_value[plan_.set_count++] = words.number();
        return nullptr;
    }

    const char* take_state(Words& words) {
        if (count_[states] == max_estimated) return more_than(max_estimated, "states");
        const int i = count_[states]++;
        plan_.state[i] = words.reference();
        plan_.derivative[i] = words.reference();
        row_[states][i].read(words);
        return nullptr;
    }

    const char* take_input(Words& words) {
        if (count_[inputs] == max_channels_used) return more_than(max_channels_used, "inputs");
        const int i = count_[inputs]++;
        plan_.input[i] = words.reference();
        plan_.input_is_discrete[i] = words.flag();
        plan_.input_start[i] = words.number();
        return nullptr;
    }

    const char* take_unknown(Words& words) {
        if (count_[unknowns] == max_estimated) return more_than(max_estimated, "unknown inputs");
        const int i = count_[unknowns]++;
        unknown_[i] = words.reference();
        row_[unknowns][i].read(words);
        row_[unknowns][i].time_constant = words.number();
        return nullptr;
    }

    const char* take_parameter(Words& words) {
        if (count_[parameters] == max_estimated) return more_than(max_estimated, "parameters");
        const int i = count_[parameters]++;
        plan_.parameter[i] = words.reference();
        row_[parameters][i].read(words);
        return nullptr;
    }

    const char* take_sensor(Words& words) {
        if (plan_.sizes.outputs == max_channels_used) return more_than(max_channels_used, "sensors");
        const int i = plan_.sizes.outputs++;
        plan_.sensor[i] = words.reference();
        plan_.sensor_is_output[i] = words.flag();
        plan_.sensor_sigma[i] = words.number();
        plan_.gate_nis[i] = words.number();
        return nullptr;
    }

    const char* take_bound(Words& words) {
        const std::uint32_t i = words.reference();
        if (i >= max_estimated) return "there is nothing of that place";
        plan_.min[i] = words.number();
        plan_.max[i] = words.number();
        return nullptr;
    }

    const char* take_logarithmic(Words& words) {
        const std::uint32_t i = words.reference();
        if (i >= max_estimated) return "there is nothing of that place";
        plan_.logarithmic[i] = 1;
        return nullptr;
    }

    const char* take_dependencies(Words& words) {
        const std::uint32_t row = words.reference();
        if (row >= max_estimated) return "there is nothing of that place";
        plan_.declared[row] = true;
        while (words.whole() && words.any()) {
            const std::uint32_t on = words.reference();
            if (on >= max_estimated) return "there is nothing of that place";
            plan_.dependent.set(row * max_estimated + on);
        }
        return nullptr;
    }

    Plan& plan_;
    bool ended_ = false;
    int count_[kinds] = {};
    char said_[64] = ""; // by more_than
    std::uint32_t unknown_[max_estimated] = {};
    Estimated row_[kinds][max_estimated] = {};
};

} // namespace

bool Plan::read(const char* folder, Refusal& why) {
    char path[max_path], line[max_path + max_text];
    if (std::snprintf(path, sizeof path, "%s/observer.plan", folder) >= static_cast<int>(sizeof path))
        return why.refuse(Refusal::impossible, "the path of the folder is longer than %d characters", max_path);
    std::FILE* file = std::fopen(path, "r");
    if (!file) return why.refuse(Refusal::impossible, "%.200s cannot be read", path);
    auto* reader = make_object<Reader>(*this); // too large for the stack of some threads
    if (!reader) {
        std::fclose(file);
        return why.refuse(Refusal::plant, "no memory for a plan");
    }
    const char* refused = nullptr;
    int number = 0;
    while (!refused && !reader->ended() && std::fgets(line, sizeof line, file)) {
        ++number;
        Words words(line);
        if (number == 1) refused = std::strcmp(line, "hnav_observer_plan 1") == 0 ? nullptr : "this is no plan of this version";
        else refused = reader->take(words);
    }
    std::fclose(file);
    const bool ended = reader->ended();
    const bool sound = !refused || why.refuse(Refusal::impossible, "observer.plan, line %d: %s", number, refused);
    reader->finish();
    destroy_object(reader);
    if (!sound) return false;
    if (!ended) return why.refuse(Refusal::impossible, "observer.plan ends before its last line, \"end\"");
    if (fmi != 2 && fmi != 3) return why.refuse(Refusal::impossible, "observer.plan: fmi is %d, not 2 or 3", fmi);
    return true;
}

} // namespace hnav::observer
