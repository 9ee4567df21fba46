#include "observer/variables.hpp"

#include "hnav/hnav.h"

#include <cstring>
#include <initializer_list>

namespace hnav::fmu::observer {
namespace {

// What the index of a role counts.
enum class Index { one, sensors, inputs, options, estimated, covariance, indicators, states };

struct Kind {
    const char* word;
    Type type;
    Causality causality;
    int group; // -1: of none
    Index index;
};

constexpr Kind kinds[] = {
    {"time", Type::real, Causality::independent, -1, Index::one},
    {"sensor_value", Type::real, Causality::input, -1, Index::sensors},
    {"sensor_sample", Type::integer, Causality::input, -1, Index::sensors},
    {"sensor_t_meas", Type::real, Causality::input, -1, Index::sensors},
    {"sensor_valid", Type::boolean, Causality::input, -1, Index::sensors},
    {"input_value", Type::real, Causality::input, -1, Index::inputs},
    {"input_sample", Type::integer, Causality::input, -1, Index::inputs},
    {"input_t_meas", Type::real, Causality::input, -1, Index::inputs},
    {"reset", Type::boolean, Causality::input, -1, Index::one},
    {"sampling_mode", Type::enumeration, Causality::parameter, -1, Index::one},
    {"sensor_period", Type::real, Causality::parameter, -1, Index::sensors},
    {"input_period", Type::real, Causality::parameter, -1, Index::inputs},
    {"start", Type::real, Causality::parameter, -1, Index::estimated},
    {"start_sigma", Type::real, Causality::parameter, -1, Index::estimated},
    {"noise", Type::real, Causality::parameter, -1, Index::estimated},
    {"sensor_sigma", Type::real, Causality::parameter, -1, Index::sensors},
    {"gate_nis", Type::real, Causality::parameter, -1, Index::sensors},
    {"sensor_offset", Type::real, Causality::parameter, -1, Index::sensors},
    {"option", Type::real, Causality::parameter, -1, Index::options}, // its type is the option's
    {"post_t", Type::real, Causality::output, posterior_group, Index::one},
    {"post", Type::real, Causality::output, posterior_group, Index::estimated},
    {"post_sigma", Type::real, Causality::output, posterior_group, Index::estimated},
    {"estimate", Type::real, Causality::output, estimate_group, Index::estimated},
    {"sigma", Type::real, Causality::output, estimate_group, Index::estimated},
    {"covariance", Type::real, Causality::output, covariance_group, Index::covariance},
    {"innovation", Type::real, Causality::output, innovation_group, Index::sensors},
    {"innovation_sigma", Type::real, Causality::output, innovation_group, Index::sensors},
    {"nis", Type::real, Causality::output, innovation_group, Index::sensors},
    {"mean_nis", Type::real, Causality::output, innovation_group, Index::sensors},
    {"sensor_used", Type::integer, Causality::output, innovation_group, Index::sensors},
    {"sensor_inflated", Type::integer, Causality::output, innovation_group, Index::sensors},
    {"ready", Type::boolean, Causality::output, info_group, Index::one},
    {"begun", Type::boolean, Causality::output, info_group, Index::one},
    {"repeatable", Type::boolean, Causality::output, info_group, Index::one},
    {"events", Type::integer, Causality::output, info_group, Index::one},
    {"corrections", Type::integer, Causality::output, info_group, Index::one},
    {"late", Type::integer, Causality::output, info_group, Index::one},
    {"non_finite", Type::integer, Causality::output, info_group, Index::one},
    {"dropped", Type::integer, Causality::output, info_group, Index::one},
    {"held", Type::integer, Causality::output, info_group, Index::one},
    {"missed", Type::integer, Causality::output, info_group, Index::one},
    {"parts", Type::integer, Causality::output, info_group, Index::one},
    {"largest_part", Type::real, Causality::output, info_group, Index::one},
    {"plant_events", Type::integer, Causality::output, info_group, Index::one},
    {"splits", Type::integer, Causality::output, info_group, Index::one},
    {"grazing", Type::integer, Causality::output, info_group, Index::one},
    {"chattering", Type::integer, Causality::output, info_group, Index::one},
    {"projected", Type::integer, Causality::output, info_group, Index::one},
    {"indicator", Type::real, Causality::local, indicator_group, Index::indicators},
    {"state", Type::real, Causality::local, -1, Index::states},
    {"derivative", Type::real, Causality::local, -1, Index::states},
};
static_assert(sizeof kinds / sizeof *kinds == role_count);

Role role_of(const char* word) {
    int role = 0;
    while (role < role_count && std::strcmp(kinds[role].word, word) != 0) ++role;
    return static_cast<Role>(role);
}

Type type_of_option(int index) {
    const hnav_option_info* option = hnav_option("observer", index);
    if (option && option->kind == HNAV_OPTION_INTEGER) return Type::integer;
    return option && option->kind == HNAV_OPTION_CHOICE ? Type::enumeration : Type::real;
}

// What messages of the library call it.
const char* field_of(Role role, int index) {
    const hnav_option_info* info = role == option ? hnav_option("observer", index) : nullptr;
    if (info) return info->name;
    return role == sensor_value ? "outputs" : role == derivative ? "derivatives" : kinds[role].word;
}

} // namespace

bool Variables::read(const char* path, Message* why) {
    for (auto& of_role : row_)
        for (int& row : of_role) row = -1;
    std::FILE* file = std::fopen(path, "r");
    if (!file) {
        std::snprintf(why->text, sizeof why->text, "%.250s cannot be read", path);
        return false;
    }
    char line[1024];
    const char* wrong = nullptr;
    int number = 0;
    bool ended = false;
    while (!wrong && !ended && std::fgets(line, sizeof line, file)) {
        ++number;
        line[std::strcspn(line, "\r\n")] = '\0';
        ended = std::strcmp(line, "end") == 0;
        if (number == 1) wrong = std::strcmp(line, "hnav_observer_variables 2") == 0 ? nullptr : "this is of another version";
        else if (!ended) wrong = take(line);
    }
    std::fclose(file);
    if (!wrong) wrong = ended ? check() : "it ends before its last line, \"end\"";
    if (wrong) std::snprintf(why->text, sizeof why->text, "variables.txt, line %d: %s", number, wrong);
    return !wrong;
}

void Variables::describe(Table& table) const {
    for (int i = 0; i < table_.size(); ++i) table.add(table_[i]);
}

// Null: the line is valid.
const char* Variables::take(char* line) {
    char word[32] = "";
    int index = 0, used = 0;
    if (std::strncmp(line, "sizes ", 6) == 0) return take_sizes(line + 6);
    if (std::sscanf(line, "%31s %d%n", word, &index, &used) < 2) return "a word or a number is missing";
    double numbers[3];
    char* next = line + used;
    for (double& value : numbers) {
        char* end = nullptr;
        value = std::strtod(next, &end);
        if (end == next) return "a number is missing or is none";
        next = end;
    }
    const Role role = role_of(word);
    if (role == role_count) return "its first word is not known";
    while (*next == ' ') ++next;
    return add(role, index, numbers[0], numbers[1], numbers[2], next);
}

const char* Variables::take_sizes(char* numbers) {
    Sizes& s = sizes;
    if (std::sscanf(numbers, "%d %d %d %d %d %d", &s.states, &s.unknown_inputs, &s.parameters, &s.known_inputs, &s.sensors,
                    &s.nx) < 6)
        return "a size is missing";
    const auto within = [](int size, int min, int max) { return size >= min && size <= max; };
    const bool possible = within(s.states, 1, max_index) && within(s.unknown_inputs, 0, max_index) &&
                          within(s.parameters, 0, max_index) && s.estimated() <= max_index && within(s.known_inputs, 0, 62) &&
                          within(s.sensors, 1, 62 - s.known_inputs) && within(s.nx, 0, 100000);
    return possible ? nullptr : "a size is impossible";
}

// The largest index of a role; 0 before the sizes are known.
int Variables::indices(Role role) const {
    const int N = sizes.estimated();
    switch (N > 0 ? kinds[role].index : Index::options) {
    case Index::one: return 1;
    case Index::sensors: return sizes.sensors;
    case Index::inputs: return sizes.known_inputs;
    case Index::options: return N > 0 ? max_index : 0;
    case Index::estimated: return N;
    case Index::covariance: return N * N;
    case Index::indicators: return max_indicators;
    default: return sizes.nx;
    }
}

const char* Variables::add(Role role, int index, double start, double min, double max, const char* name) {
    if (index < 0 || index >= indices(role)) return "its index is impossible";
    const int row = table_.size();
    if (row == capacity_ && !grow()) return "no memory for the variables";
    const Kind& kind = kinds[role];
    Variable v = variable(name, role == option ? type_of_option(index) : kind.type, kind.causality, Variability::discrete, "");
    v.start = start;
    v.min = min;
    v.max = max;
    v.field = field_of(role, index);
    v.element = role == option ? -1 : index;
    if (kind.group >= 0) v.group = 1u << kind.group;
    if ((role == state || role == derivative) && !flows(v, role, index)) return "states stand together, in order";
    if (role == indicator && index != sizes.indicators++) return "indicators stand in order";
    rows_[row] = {role, index};
    if (index < max_index) row_[role][index] = row;
    table_.add(v);
    return table_.complete() ? nullptr : "no memory for the variables";
}

bool Variables::grow() {
    const int capacity = capacity_ ? 2 * capacity_ : 256;
    auto* grown = static_cast<Row*>(std::realloc(rows_, capacity * sizeof(Row)));
    if (!grown) return false;
    rows_ = grown;
    capacity_ = capacity;
    return true;
}

// Marks a state or a derivative. False: the row is out of order.
bool Variables::flows(Variable& v, Role role, int index) {
    int& first = role == state ? first_state_ : first_derivative_;
    if (first < 0) first = table_.size();
    v.group = state_group;
    v.is_state = role == state;
    if (role == derivative) v.derivative_of = first_state_ + index;
    return index == table_.size() - first;
}

// What a model relies on.
const char* Variables::check() const {
    if (sizes.states == 0) return "the sizes are missing";
    for (int i = 0; i < sizes.sensors; ++i)
        for (const Role role : {sensor_value, sensor_sample, sensor_t_meas, sensor_valid})
            if (row(role, i) < 0) return "an input of a sensor is missing";
    for (int i = 0; i < sizes.known_inputs; ++i)
        for (const Role role : {input_value, input_sample, input_t_meas})
            if (row(role, i) < 0) return "an input is missing";
    if (row(reset_command) < 0 || row(sampling_mode) < 0) return "reset or sampling_mode is missing";
    if (sizes.nx == 0) return nullptr; // the plant steps itself: no Model Exchange
    const bool states =
        first_state_ >= 0 && first_derivative_ == first_state_ + sizes.nx && first_derivative_ + sizes.nx == table_.size();
    return states ? nullptr : "states and derivatives are not the last rows, nx of each";
}

} // namespace hnav::fmu::observer
