// Writes what describes an FMU from its table. Equal sources give equal bytes: no date except SOURCE_DATE_EPOCH enters.
#pragma once

#include "adapter/arrays.hpp"
#include "adapter/model.hpp"

namespace hnav::fmu {

struct Writer {
    FILE* file;
    bool fmi3;
    const Table& table;

    // Number of rows of the variable that begins at a row, 0 inside an array.
    int rows(int row) const { return model_info.arrays ? rows_of_variable(table, row) : 1; }
    // Value reference of the variable that begins at a row. In FMI 2 also its position.
    int reference(int row) const { return reference_of(table, row, model_info.arrays); }
    // The name of the variable that begins at a row.
    void name(int row, char (&name)[64]) const {
        std::snprintf(name, sizeof name, "%s", rows(row) > 1 ? ElementName(table[row].name).base : table[row].name);
    }

    void text(const char* s) const { std::fputs(s, file); }

    // The shortest text that parses to the same number.
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

    // Escaped text of an attribute or element.
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

// The importer may set the start values of parameters and inputs.
inline bool has_start(const Variable& v) {
    return v.type != Type::clock && (v.causality == Causality::parameter || v.causality == Causality::input);
}

void write_model_description(const Writer& w, const char* version);
void write_terminals(const Writer& w);
// The build description of FMI 3, for an archive with sources.
void write_build_description(const Writer& w);
// The outputs for the example input as CSV text; null if the FMU has no example.
bool write_reference(const Writer& w, FILE* input);
void write_reference_manifest(const Writer& w);
void write_reference_experiment(const Writer& w, bool has_input);
// The page that begins with the file `introduction`; false: it cannot be read.
bool write_documentation(const Writer& w, const char* introduction);

} // namespace hnav::fmu
