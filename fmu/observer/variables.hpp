// The variables of an Observer FMU. They belong to the plant inside, so they stand in a text in its resources, which hnav.Observer.export
// writes beside modelDescription.xml from the same table:
//
//     hnav_observer_variables 2          first
//     sizes STATES UNKNOWN PARAMETERS KNOWN SENSORS NX    second
//     ROLE INDEX START MIN MAX NAME      a variable, in the order of the value references; INDEX: of the sensor, input, ...
//     end                                last
#pragma once

#include "adapter/model.hpp"

namespace hnav::fmu::observer {

// The role of a variable; words[] in variables.cpp names them in this order.
enum Role {
    time_role,
    sensor_value,
    sensor_sample,
    sensor_t_meas,
    sensor_valid,
    input_value,
    input_sample,
    input_t_meas,
    reset_command,
    sampling_mode,
    sensor_period,
    input_period,
    start,
    start_sigma,
    noise,
    sensor_sigma,
    gate_nis,
    sensor_offset, // an archive may lack it
    option,
    post_t,
    post,
    post_sigma,
    estimate,
    sigma,
    covariance,
    innovation,
    innovation_sigma,
    nis,
    mean_nis,
    sensor_used,
    sensor_inflated,
    ready,
    begun,
    repeatable,
    events,
    corrections,
    late,
    non_finite,
    dropped,
    held_intervals,
    missed,
    parts,
    largest_part,
    plant_events,
    splits,
    grazing,
    chattering,
    projected,
    indicator,
    state,
    derivative,
    role_count
};

// Which call of the library a row is read from.
enum Group { posterior_group, estimate_group, covariance_group, innovation_group, info_group, indicator_group };

constexpr int max_index = 64; // of all roles but covariance, indicator, state and derivative
constexpr int max_indicators = 1000;

struct Sizes {
    int states = 0, unknown_inputs = 0, parameters = 0, known_inputs = 0, sensors = 0;
    int nx = 0; // of Model Exchange
    int indicators = 0; // rows of them
    int estimated() const { return states + unknown_inputs + parameters; }
};

class Variables {
public:
    ~Variables() { std::free(rows_); }
    Variables() = default;
    Variables(const Variables&) = delete;
    Variables& operator=(const Variables&) = delete;

    bool read(const char* path, Message* why);
    void describe(Table& table) const;

    // The row of a role, -1 if there is none.
    int row(Role role, int index = 0) const { return row_[role][index]; }
    const char* name(int row) const { return table_[row].name; }
    double value(const double* values, Role role, int index, double otherwise) const {
        return row(role, index) < 0 ? otherwise : values[row(role, index)];
    }

    // Calls show(role, index, place in values) for the rows of the groups with set bits.
    template <class Show>
    void each(unsigned groups, double* values, Show show) const {
        for (int i = 0; i < table_.size(); ++i)
            if (table_[i].group & groups) show(rows_[i].role, rows_[i].index, values + i);
    }

    Sizes sizes;

private:
    struct Row {
        Role role;
        int index;
    };

    const char* take(char* line);
    const char* take_sizes(char* numbers);
    int indices(Role role) const;
    bool grow();
    bool flows(Variable& v, Role role, int index);
    const char* add(Role role, int index, double start, double min, double max, const char* name);
    const char* check() const;

    Table table_;
    Row* rows_ = nullptr;
    int capacity_ = 0, first_state_ = -1, first_derivative_ = -1;
    int row_[role_count][max_index] = {};
};

} // namespace hnav::fmu::observer
