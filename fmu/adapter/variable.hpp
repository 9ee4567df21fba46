// The table of an FMU, one row for each scalar. Entry points, both model descriptions, start values, reset, save, load and
// the documentation are loops over it.
// The value of row i is values[i] of the instance, a double for every type: integers and booleans fit exactly. Value
// references: see arrays.hpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string_view>

namespace hnav::fmu {

constexpr double no_bound = std::numeric_limits<double>::infinity();

enum class Type { real, integer, boolean, enumeration, clock };

enum class Causality { independent, parameter, calculated, input, output, local };
enum class Variability { fixed, discrete, continuous };

// Dependency of a row on the continuous states in Model Exchange. Inputs are discrete: no row depends on them directly.
enum class DependsOn { nothing, first_states, all_states };

// The values of an enumeration, 0 to count - 1: their names and descriptions.
struct Choice {
    const char *name, *description;
};
struct Choices {
    Choice (*at)(const void* of, int k);
    const void* of;
    int count;

    Choice operator[](int k) const { return at(of, k); }
};

struct Variable {
    char name[64];
    const char* description;
    const char* unit; // of the unit table in units.hpp; "" for none
    const char* display_unit; // "" for none
    Choices choices; // of enumerations
    Type type;
    Causality causality;
    Variability variability;
    double start; // of parameters and inputs
    double min, max;
    bool min_is_open, max_is_open;
    DependsOn depends_on;
    unsigned group; // the bit of Model::refresh of its group
    int derivative_of; // row of the state, or -1
    bool is_state;
    bool basic; // one of the dozen parameters that most users set
    int clock; // row of the clock that it belongs to, or -1
    const char* field; // of the library, which calls it so in messages, or field[element] unless that is -1; may be null
    int element;

    // False for NaN and for infinities.
    bool admits(double value) const {
        return std::isfinite(value) && (min_is_open ? value > min : value >= min) && (max_is_open ? value < max : value <= max);
    }
    bool is_field(std::string_view word) const {
        if (!field || element < 0) return field && word == field;
        char own[64];
        std::snprintf(own, sizeof own, "%s[%d]", field, element);
        return word == own;
    }
};

// FNV-1a, 64 bits.
struct Hash {
    std::uint64_t value = 14695981039346656037ull;
    void add(unsigned char byte) { value = (value ^ byte) * 1099511628211ull; }
};

class Table {
public:
    ~Table() { std::free(rows_); }
    Table() = default;
    Table(const Table&) = delete;
    Table& operator=(const Table&) = delete;

    int size() const { return size_; }
    bool complete() const { return complete_; }
    void give_up() { complete_ = false; }
    const Variable& operator[](int i) const { return rows_[i]; }
    Variable& row(int i) { return rows_[i]; }
    // Marks the rows from first to last as clocked; the clock itself may be one of them.
    void put_on_clock(int clock, int first, int last) {
        for (int i = first; i <= last; ++i)
            if (i != clock) rows_[i].clock = clock;
    }

    // Appends a row and returns its number.
    int add(const Variable& variable) {
        if (size_ == capacity_) {
            const int capacity = capacity_ ? 2 * capacity_ : 256;
            auto* grown = static_cast<Variable*>(std::realloc(rows_, capacity * sizeof(Variable)));
            if (!grown) {
                give_up();
                return 0;
            }
            rows_ = grown;
            capacity_ = capacity;
        }
        rows_[size_] = variable;
        return size_++;
    }

    // `count` rows name[1] ... name[count]; the number of the first.
    int add_vector(const Variable& variable, int count) {
        const int first = size_;
        for (int i = 1; i <= count; ++i) {
            Variable element = variable;
            std::snprintf(element.name, sizeof element.name, "%.50s[%d]", variable.name, i);
            add(element);
        }
        return first;
    }

    // Appends rows name[1,1], name[1,2], ... of an n x n matrix, row by row, or of its upper triangle; returns the number of
    // the first.
    int add_matrix(const Variable& variable, int n) { return add_elements(variable, n, false); }
    int add_triangle(const Variable& variable, int n) { return add_elements(variable, n, true); }

    // Hash of names, types and order: an importer with the description of another version is refused. arrays: whether an
    // array is one variable.
    std::uint64_t token(bool arrays) const {
        Hash hash;
        if (arrays) hash.add(1);
        for (int i = 0; i < size_; ++i) {
            for (const char* c = rows_[i].name; *c; ++c) hash.add(static_cast<unsigned char>(*c));
            hash.add(static_cast<unsigned char>(rows_[i].type));
            hash.add(static_cast<unsigned char>(rows_[i].causality));
        }
        return hash.value;
    }

    // Copies a message with the names of variables in place of fields of the library. A field that may be a word of a sentence
    // counts only before its value.
    void name_fields(const char* text, char* out, std::size_t size) const {
        constexpr const char* ends = " ,:;";
        for (std::size_t used = 0; *text && used < size;) {
            const std::string_view word(text, std::strcspn(text, ends));
            text += word.size();
            const bool sure = word.find_first_of("_[") != word.npos || std::strncmp(text, " = ", 3) == 0;
            const int row = sure ? row_of_field(word) : -1;
            // A vector whose components have one field is named as a whole.
            const std::string_view name = row < 0 ? word : rows_[row].name;
            const auto shown = row >= 0 && rows_[row].element < 0 ? std::min(name.find('['), name.size()) : name.size();
            const std::size_t gap = std::strspn(text, ends);
            used += std::snprintf(out + used, size - used, "%.*s%.*s", int(shown), name.data(), int(gap), text);
            text += gap;
        }
    }

private:
    int row_of_field(std::string_view word) const {
        for (int row = 0; row < size_; ++row)
            if (rows_[row].is_field(word)) return row;
        return -1;
    }

    int add_elements(const Variable& variable, int n, bool triangle) {
        const int first = size_;
        for (int i = 1; i <= n; ++i)
            for (int j = triangle ? i : 1; j <= n; ++j) {
                Variable element = variable;
                std::snprintf(element.name, sizeof element.name, "%.40s[%d,%d]", variable.name, i, j);
                add(element);
            }
        return first;
    }

    Variable* rows_ = nullptr;
    int size_ = 0, capacity_ = 0;
    bool complete_ = true;
};

// A row with common values of its fields.
inline Variable variable(const char* name, Type type, Causality causality, Variability variability, const char* description) {
    Variable v{};
    std::snprintf(v.name, sizeof v.name, "%s", name);
    v.description = description;
    v.unit = v.display_unit = "";
    v.type = type;
    v.causality = causality;
    v.variability = variability;
    v.min = -no_bound;
    v.max = no_bound;
    v.derivative_of = v.clock = v.element = -1;
    return v;
}

} // namespace hnav::fmu
