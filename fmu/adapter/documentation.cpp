// Writes the terminals and documentation/index.html.
#include "adapter/description.hpp"
#include "adapter/units.hpp"

#include <cstring>

namespace hnav::fmu {
namespace {

// The part of a name before the first dot, and a pointer to the dot; null for a name without one.
struct Prefix {
    char text[64];
    const char* dot;
    explicit Prefix(const Variable& v) : dot(std::strchr(v.name, '.')) {
        std::snprintf(text, sizeof text, "%.*s", dot ? static_cast<int>(dot - v.name) : 0, v.name);
    }
    bool operator==(const Prefix& other) const { return std::strcmp(text, other.text) == 0; }
};

// Statistics are not part of a terminal.
bool plugged(const Variable& v) {
    const Prefix prefix(v);
    return (v.causality == Causality::input || v.causality == Causality::output) && prefix.dot &&
           std::strcmp(prefix.text, "count") != 0;
}

} // namespace

// Inputs or outputs with the same prefix before the dot form one terminal: gyro, accel, mag, att, post. Outputs of a plant
// have the names of a filter's inputs, so that their terminals match.
void write_terminals(const Writer& w) {
    w.text(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n"
        "  <GraphicalRepresentation>\n    <CoordinateSystem x1=\"-100\" y1=\"-100\" x2=\"100\" y2=\"100\" suggestedScalingFactorTo_mm=\"0.1\"/>\n"
        "    <Icon x1=\"-100\" y1=\"-100\" x2=\"100\" y2=\"100\"/>\n  </GraphicalRepresentation>\n  <Terminals>\n");
    for (int i = 0; i < w.table.size(); ++i) {
        if (!plugged(w.table[i])) continue;
        const Prefix prefix(w.table[i]);
        const auto member = [&](int k) { return plugged(w.table[k]) && Prefix(w.table[k]) == prefix; };
        bool written = false;
        for (int k = 0; k < i; ++k) written = written || member(k);
        if (written) continue;
        std::fprintf(w.file, "    <Terminal name=\"%s\" matchingRule=\"plug\">\n", prefix.text);
        for (int k = i; k < w.table.size(); ++k) {
            char name[64];
            w.name(k, name);
            if (member(k) && w.rows(k) > 0)
                std::fprintf(w.file,
                             "      <TerminalMemberVariable variableName=\"%s\" memberName=\"%s\" variableKind=\"signal\"/>\n",
                             name, std::strchr(name, '.') + 1);
        }
        w.text("    </Terminal>\n");
    }
    w.text("  </Terminals>\n</fmiTerminalsAndIcons>\n");
}

// ------------------------------------------------------------------------------------------------ page

namespace {

// Rounded for readers; modelDescription.xml has all digits.
void write_number(const Writer& w, double value) { std::fprintf(w.file, value == std::floor(value) ? "%.10g" : "%.6g", value); }

void write_value(const Writer& w, const Variable& v, double value) {
    if (v.type == Type::enumeration) w.text(v.choices[static_cast<int>(value)].name);
    else if (v.type == Type::boolean) w.text(value != 0 ? "true" : "false");
    else write_number(w, value);
}

// The unit, its display unit, and the factor between the two.
void write_units(const Writer& w, const Variable& v) {
    w.escaped(v.unit);
    if (!*v.display_unit) return;
    for (const Unit& unit : units) {
        if (std::strcmp(unit.name, v.unit) != 0) continue;
        for (const DisplayUnit& display : unit.display) {
            if (!display.name || std::strcmp(display.name, v.display_unit) != 0) continue;
            w.text("<br><small>shown in ");
            w.escaped(display.name);
            w.text("</small>");
            // The start value as displayed; zero needs no factor.
            if (v.causality == Causality::parameter && v.start != 0)
                std::fprintf(w.file, "<br><small>%.4g %s</small>", v.start * display.factor, display.name);
        }
    }
}

void write_bound(const Writer& w, const Variable& v, double bound) {
    const bool number = v.type == Type::real || v.type == Type::integer;
    w.text("</td><td>");
    if (number && v.causality == Causality::parameter && std::fabs(bound) < 1e300) write_number(w, bound);
}

void write_row(const Writer& w, int row) {
    const Variable& v = w.table[row];
    char name[64];
    w.name(row, name);
    std::fprintf(w.file, "<tr><td><code>%s</code></td><td>%s", name, type_element(v.type, true));
    if (w.rows(row) > 1) std::fprintf(w.file, "[%d]", w.rows(row));
    w.text("</td><td>");
    write_units(w, v);
    w.text("</td><td>");
    if (has_start(v)) write_value(w, v, v.start);
    write_bound(w, v, v.min);
    write_bound(w, v, v.max);
    w.text("</td><td>");
    w.escaped(v.description);
    for (int k = 0; k < v.choices.count; ++k) {
        std::fprintf(w.file, "<br><code>%s</code> (%d): ", v.choices[k].name, k);
        w.escaped(v.choices[k].description);
    }
    w.text("</td></tr>\n");
}

// A table of the selected rows, if there are any.
template <class Wanted>
void write_section(const Writer& w, const char* id, const char* title, const char* about, Wanted wanted) {
    bool any = false;
    for (int i = 0; i < w.table.size(); ++i) {
        if (!wanted(w.table[i]) || w.rows(i) == 0) continue;
        if (!any)
            std::fprintf(
                w.file,
                "<h2 id=\"%s\">%s</h2>\n<p>%s</p>\n<div class=\"wide\"><table><tr><th>name</th><th>type</th><th>unit</th><th>start</th>"
                "<th>min</th><th>max</th><th>meaning</th></tr>\n",
                id, title, about);
        any = true;
        write_row(w, i);
    }
    if (any) w.text("</table></div>\n");
}

void write_sections(const Writer& w) {
    const auto of = [](Causality causality) { return [causality](const Variable& v) { return v.causality == causality; }; };
    write_section(w, "basic", "Parameters to look at first", "Marked [basic] in the descriptions that importers show.",
                  [](const Variable& v) { return v.basic; });
    write_section(w, "inputs", "Inputs", "Held between communication points.", of(Causality::input));
    write_section(w, "outputs", "Outputs", "The part of the name before the dot is a terminal.", of(Causality::output));
    write_section(w, "parameters", "All other parameters", "Fixed: set them before initialisation ends.",
                  [](const Variable& v) { return v.causality == Causality::parameter && !v.basic; });
    write_section(w, "calculated", "Calculated parameters", "Known after initialisation.", of(Causality::calculated));
    write_section(w, "states", "Continuous states", "Of Model Exchange, and their derivatives.", of(Causality::local));
}

} // namespace

bool write_documentation(const Writer& w, const char* introduction) {
    FILE* in = std::fopen(introduction, "r");
    if (!in) return false;
    std::fprintf(w.file,
                 "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
                 "content=\"width=device-width\"><title>%s</title>\n",
                 model_info.name);
    w.text(
        "<style>body{font:16px/1.5 sans-serif;max-width:72em;margin:2em auto;padding:0 1em}p{max-width:44em}"
        ".wide{overflow-x:auto}table{border-collapse:collapse;font-size:90%}td,th{border:1px solid #ccc;padding:.2em .6em;"
        "text-align:left;vertical-align:top}th{background:#f3f3f3}td:last-child{min-width:20em}td:nth-child(n+2):nth-child(-n+6){white-space:nowrap}"
        "code{font-size:95%}small{color:#555}</style></head><body>\n");
    char line[1024];
    while (std::fgets(line, sizeof line, in)) w.text(line);
    std::fclose(in);
    if (model_info.clocks)
        w.text(
            "<h2>Clocks</h2>\n<p>In this archive a sample is the tick of a triggered clock (<code>.tick</code>), which stands in the place of "
            "the counter, the flag <code>.valid</code>, <code>sampling_mode</code> and the periods of a filter. Clocks tick in event mode: "
            "the importer has to instantiate with <code>eventModeUsed</code>.</p>\n");
    write_sections(w);
    w.text("</body></html>\n");
    return true;
}

} // namespace hnav::fmu
