// What describes an FMU, written from its table. Nothing in it depends on the day or the machine but the date of
// SOURCE_DATE_EPOCH: equal sources give equal bytes.
#pragma once

#include "adapter/arrays.hpp"
#include "adapter/model.hpp"

namespace hnav::fmu {

struct Writer {
    FILE* file;
    bool fmi3;
    const Table& table;

    // Rows of the variable that begins at a row, 0 inside of one.
    int rows(int row) const { return model_info.arrays ? rows_of_variable(table, row) : 1; }
    // Of the variable that begins at a row. In FMI 2 its position too.
    int reference(int row) const { return reference_of(table, row, model_info.arrays); }
    // The name of the variable that begins at a row.
    void name(int row, char (&name)[64]) const {
        std::snprintf(name, sizeof name, "%s", rows(row) > 1 ? ElementName(table[row].name).base : table[row].name);
    }

    void text(const char* s) const { std::fputs(s, file); }

    // The shortest text that reads as the same number.
    void number(double value) const {
        char shortest[32];
        if (value == std::floor(value) && std::fabs(value) < 1e10) {
            std::fprintf(file, "%.0f", value);
            return;
        }
        for (int digits = 1; digits <= 17; ++digits) {
            std::snprintf(shortest, sizeof shortest, "%.*g", digits, value);
            if (std::strtod(shortest, nullptr) == value) break;
        }
        text(shortest);
    }

    // Text of an attribute or element.
    void escaped(const char* s) const {
        for (; *s; ++s) switch (*s) {
            case '<': text("&lt;"); break;
            case '>': text("&gt;"); break;
            case '&': text("&amp;"); break;
            case '"': text("&quot;"); break;
            default: std::fputc(*s, file);
            }
    }

    void attribute(const char* name, const char* value) const {
        std::fprintf(file, " %s=\"", name);
        escaped(value);
        text("\"");
    }
    void attribute(const char* name, double value) const {
        std::fprintf(file, " %s=\"", name);
        number(value);
        text("\"");
    }
    void attribute(const char* name, int value) const { std::fprintf(file, " %s=\"%d\"", name, value); }
};

// As FMI spells them.
const char* type_element(Type type, bool fmi3);
const char* name_of(Causality causality);

// Of parameters and inputs the start value is the importer's to set.
inline bool has_start(const Variable& v) {
    return v.type != Type::clock && (v.causality == Causality::parameter || v.causality == Causality::input);
}

void write_model_description(const Writer& w, const char* version);
void write_terminals(const Writer& w);
// Of FMI 3, where the archive holds sources.
void write_build_description(const Writer& w);
// The run that answers the example input, null when the FMU has none, and its text.
bool write_reference(const Writer& w, FILE* input);
void write_reference_manifest(const Writer& w);
void write_reference_experiment(const Writer& w, bool has_input);
// The page that begins with the file `introduction`; false: it cannot be read.
bool write_documentation(const Writer& w, const char* introduction);

} // namespace hnav::fmu
