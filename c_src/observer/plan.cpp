#include "observer/plan.hpp"

#include "base/arena.hpp"
#include "base/memory.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>

namespace hnav::observer {
namespace {

constexpr int max_line = max_path + max_text;

// Lines that make rows.
enum Kind { states, inputs, unknowns, parameters, sensors, values, kinds };
constexpr const char* key_of[kinds] = {"state", "input", "unknown", "parameter", "sensor", "set"};

// The same number without its decimal point, for which strtod expects that of the process's locale: 1.25e-3 is 125e-5. Text that is no number
// with a point stays.
const char* without_point(const char* text, char* copy, std::size_t size) {
    const char* point = std::strchr(text, '.');
    if (!point) return text;
    const std::size_t decimals = std::strspn(point + 1, "0123456789");
    const char* tail = point + 1 + decimals;
    char* end = nullptr;
    const long exponent = *tail == 'e' || *tail == 'E' ? std::strtol(tail + 1, &end, 10) : 0;
    if (*(end ? end : tail)) return text;
    const int length = std::snprintf(copy, size, "%.*s%.*se%ld", static_cast<int>(point - text), text, static_cast<int>(decimals),
                                     point + 1, exponent - static_cast<long>(decimals));
    return length < static_cast<int>(size) ? copy : text;
}

bool is(const char* key, const char* name) { return std::strcmp(key, name) == 0; }

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
        char copy[64];
        const char* text = without_point(word(), copy, sizeof copy);
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

    void read(double* to) { *to = number(); }
    void read(std::uint32_t* to) { *to = reference(); }
    void read(std::uint8_t* to) { *to = flag(); }

    bool whole() const { return whole_; }

private:
    char* next_;
    bool whole_ = true;
};

// Reads line after line.
class Reader {
public:
    explicit Reader(Plan& plan) : plan_(plan), sizes_(plan.sizes) {}

    // Returns a message, or null if the line was read.
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

private:
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
        if (is(key, "set")) return take(values, plan_.set_count, words, plan_.set, plan_.set_value);
        if (is(key, "state")) return take_state(words);
        if (is(key, "input"))
            return take(inputs, sizes_.known_inputs(), words, plan_.input, plan_.input_is_discrete, plan_.input_start);
        if (is(key, "unknown")) return take_unknown(words);
        if (is(key, "parameter")) return take_parameter(words);
        if (is(key, "sensor"))
            return take(sensors, sizes_.outputs, words, plan_.sensor, plan_.sensor_is_output, plan_.sensor_sigma, plan_.gate_nis);
        if (is(key, "bound")) return take_bound(words);
        if (is(key, "logarithmic")) return take_logarithmic(words);
        if (is(key, "depends")) return take_dependencies(words);
        return "its first word is not known";
    }

    // The next row of a kind, a number for each array.
    template <class... Arrays>
    const char* take(Kind kind, int count, Words& words, Arrays*... to) {
        const int i = count_[kind]++;
        if (i >= count) return "the file changes while it is read";
        (words.read(to + i), ...);
        return nullptr;
    }

    const char* take_step(Words& words) {
        plan_.step_s = words.number();
        return plan_.step_s >= 0 && std::isfinite(plan_.step_s) ? nullptr : "a step has to be finite and at least 0";
    }

    const char* take_state(Words& words) {
        return take(states, sizes_.states, words, plan_.state, plan_.derivative, plan_.start, plan_.start_sigma, plan_.noise,
                    plan_.nominal, plan_.ready_sigma);
    }

    const char* take_unknown(Words& words) {
        const int i = sizes_.first(Variable::unknown_input);
        return take(unknowns, sizes_.unknown_inputs, words, plan_.input + sizes_.known_inputs(), plan_.start + i,
                    plan_.start_sigma + i, plan_.noise + i, plan_.nominal + i, plan_.ready_sigma + i, plan_.time_constant_s);
    }

    const char* take_parameter(Words& words) {
        const int i = sizes_.first(Variable::parameter);
        return take(parameters, sizes_.parameters, words, plan_.parameter, plan_.start + i, plan_.start_sigma + i,
                    plan_.noise + i, plan_.nominal + i, plan_.ready_sigma + i);
    }

    // Reads a place below count. Returns false if the next word is none.
    static bool place(Words& words, int count, std::uint32_t* i) {
        *i = words.reference();
        return *i < static_cast<std::uint32_t>(count);
    }

    const char* take_bound(Words& words) {
        std::uint32_t i;
        if (!place(words, sizes_.estimated(), &i)) return nothing_there;
        plan_.min[i] = words.number();
        plan_.max[i] = words.number();
        return nullptr;
    }

    const char* take_logarithmic(Words& words) {
        std::uint32_t i;
        if (!place(words, sizes_.parameters, &i)) return nothing_there;
        plan_.logarithmic[i] = 1;
        return nullptr;
    }

    const char* take_dependencies(Words& words) {
        const int moving = sizes_.first(Variable::parameter);
        std::uint32_t row, on;
        if (!place(words, sizes_.states, &row)) return nothing_there;
        plan_.declared[row] = 1;
        while (words.whole() && words.any()) {
            if (!place(words, moving, &on)) return nothing_there;
            plan_.dependent[row * moving + on] = 1;
        }
        return nullptr;
    }

    static constexpr const char* nothing_there = "there is nothing of that place";

    Plan& plan_;
    const PlantSizes& sizes_;
    bool ended_ = false;
    int count_[kinds] = {};
};

// Lines of each kind, before the end.
void count_lines(std::FILE* file, int (&count)[kinds]) {
    char line[max_line];
    while (std::fgets(line, sizeof line, file)) {
        Words words(line);
        const char* key = words.word();
        if (is(key, "end")) return;
        for (int k = 0; k < kinds; ++k) count[k] += is(key, key_of[k]);
    }
}

} // namespace

Plan::~Plan() { release_block(block_); }

bool Plan::take_rows() {
    bytes_ = place_rows(nullptr);
    block_ = take_block(bytes_);
    if (block_) place_rows(block_);
    return block_ != nullptr;
}

// Bytes of all.
std::size_t Plan::place_rows(void* block) {
    Arena arena(block);
    const int N = sizes.estimated(), moving = sizes.first(Variable::parameter);
    for (auto* row : {&state, &derivative}) *row = arena.rows<std::uint32_t>(sizes.states);
    input = arena.rows<std::uint32_t>(sizes.inputs);
    parameter = arena.rows<std::uint32_t>(sizes.parameters);
    sensor = arena.rows<std::uint32_t>(sizes.outputs);
    set = arena.rows<std::uint32_t>(set_count);
    set_value = arena.doubles(set_count);
    for (auto* row : {&start, &start_sigma, &noise, &nominal, &ready_sigma, &min, &max}) *row = arena.doubles(N);
    time_constant_s = arena.doubles(sizes.unknown_inputs);
    input_start = arena.doubles(sizes.known_inputs());
    for (auto* row : {&sensor_sigma, &gate_nis}) *row = arena.doubles(sizes.outputs);
    input_is_discrete = arena.rows<std::uint8_t>(sizes.inputs);
    sensor_is_output = arena.rows<std::uint8_t>(sizes.outputs);
    logarithmic = arena.rows<std::uint8_t>(sizes.parameters);
    declared = arena.rows<std::uint8_t>(sizes.states);
    dependent = arena.rows<std::uint8_t>(sizes.states * moving);
    return arena.used();
}

bool Plan::copy(const Plan& from) {
    release_block(block_);
    static_cast<PlanHead&>(*this) = from;
    if (!take_rows()) return false;
    std::memcpy(block_, from.block_, bytes_);
    return true;
}

// Its lines are counted first.
bool Plan::make_rows(std::FILE* file, Refusal& why) {
    int count[kinds] = {};
    count_lines(file, count);
    sizes.states = count[states];
    sizes.inputs = count[inputs] + count[unknowns];
    sizes.unknown_inputs = count[unknowns];
    sizes.parameters = count[parameters];
    sizes.outputs = count[sensors];
    set_count = count[values];
    if (!Problem::numbers_fit(sizes, why)) return false;
    if (std::fseek(file, 0, SEEK_SET) != 0 || !take_rows()) return why.refuse(Refusal::plant, "no memory for a plan");
    for (int i = 0; i < sizes.estimated(); ++i) {
        min[i] = -HUGE_VAL;
        max[i] = HUGE_VAL;
    }
    return true;
}

bool Plan::read_lines(std::FILE* file, Refusal& why) {
    char line[max_line];
    Reader reader(*this);
    const char* refused = nullptr;
    int number = 0;
    while (!refused && !reader.ended() && std::fgets(line, sizeof line, file)) {
        ++number;
        Words words(line);
        if (number == 1) refused = std::strcmp(line, "hnav_observer_plan 1") == 0 ? nullptr : "this is no plan of this version";
        else refused = reader.take(words);
    }
    if (refused) return why.refuse(Refusal::impossible, "observer.plan, line %d: %s", number, refused);
    if (!reader.ended()) return why.refuse(Refusal::impossible, "observer.plan ends before its last line, \"end\"");
    if (fmi != 2 && fmi != 3) return why.refuse(Refusal::impossible, "observer.plan: fmi is %d, not 2 or 3", fmi);
    return true;
}

bool Plan::read(const char* folder, Refusal& why) {
    char path[max_path];
    if (std::snprintf(path, sizeof path, "%s/observer.plan", folder) >= static_cast<int>(sizeof path))
        return why.refuse(Refusal::impossible, "the path of the folder is longer than %d characters", max_path);
    std::FILE* file = std::fopen(path, "r");
    if (!file) return why.refuse(Refusal::impossible, "%.200s cannot be read", path);
    const bool sound = make_rows(file, why) && read_lines(file, why);
    std::fclose(file);
    return sound;
}

} // namespace hnav::observer
