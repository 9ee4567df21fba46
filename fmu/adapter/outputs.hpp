// Outputs from answers of the library: each row is declared with the field of the answer that it shows.
#pragma once

#include "adapter/variable.hpp"

#include <cstring>
#include <type_traits>

namespace hnav::fmu {

// Answer: the struct that one call of the library fills. group_number: the bit of Model::refresh for all rows. capacity: in
// variables, where a vector counts as one.
template <class Answer, int group_number, int capacity = 16>
class Outputs {
public:
    static constexpr unsigned group = 1u << group_number;
    using Show = void (*)(const Answer& answer, double* rows);

    // Appends a row, or rows name[1], name[2], ... for an array field; returns the number of the first.
    template <auto field>
    int add(Table& table, const Variable& variable) {
        constexpr int count = length<field>();
        return bind<field>(table, count > 0 ? table.add_vector(variable, count) : table.add(variable));
    }

    // A row, or `count` rows name[1], name[2], ..., whose values show computes.
    int add(Table& table, const Variable& variable, Show show) { return bind(table, table.add(variable), 1, show); }
    int add_vector(Table& table, const Variable& variable, int count, Show show) {
        return bind(table, table.add_vector(variable, count), count, show);
    }

    // The same for rows that are already in the table, from `first` on.
    template <auto field>
    int bind(Table& table, int first) {
        constexpr int count = length<field>();
        return bind(table, first, count > 0 ? count : 1, show_field<field>);
    }
    int bind(Table& table, int first, int count, Show show) {
        for (int i = 0; i < count && table.complete(); ++i) table.row(first + i).group = group;
        if (size_ < capacity) shown_[size_++] = {first, show};
        else table.give_up();
        return first;
    }

    // read fills an answer; called when the group is requested.
    template <class Read>
    void refresh(unsigned groups, double* values, Read read) const {
        if (!(groups & group)) return;
        Answer answer;
        read(&answer);
        for (int k = 0; k < size_; ++k) shown_[k].show(answer, values + shown_[k].first);
    }

private:
    template <auto field>
    using FieldOf = std::remove_reference_t<decltype(std::declval<Answer&>().*field)>;

    template <auto field>
    static constexpr int length() {
        return static_cast<int>(std::extent_v<FieldOf<field>>); // 0: no array
    }

    template <auto field>
    static void show_field(const Answer& answer, double* rows) {
        if constexpr (std::is_array_v<FieldOf<field>>) std::memcpy(rows, answer.*field, sizeof(answer.*field));
        else *rows = static_cast<double>(answer.*field);
    }

    struct Shown {
        int first;
        Show show;
    };
    Shown shown_[capacity];
    int size_ = 0;
};

} // namespace hnav::fmu
