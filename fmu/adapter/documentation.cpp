// The terminals of FMI 3, and the page that people read.
#include "adapter/description.hpp"

#include <cstring>

namespace hnav::fmu {

// Inputs that share the part of the name before the dot are one plug: gyro, accel, mag, aid. So are the outputs of a
// plant, which bear the names of a filter's inputs.
void write_terminals(const Writer& w) {
    w.text(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n"
        "  <GraphicalRepresentation>\n    <CoordinateSystem x1=\"-100\" y1=\"-100\" x2=\"100\" y2=\"100\" suggestedScalingFactorTo_mm=\"0.1\"/>\n"
        "    <Icon x1=\"-100\" y1=\"-100\" x2=\"100\" y2=\"100\"/>\n  </GraphicalRepresentation>\n  <Terminals>\n");
    char open[64] = "";
    for (int i = 0; i < w.table.size(); ++i) {
        const Variable& v = w.table[i];
        const char* dot = std::strchr(v.name, '.');
        const bool plugged = v.causality == Causality::input || (model_info.is_plant && v.causality == Causality::output);
        if (!plugged || !dot) continue;
        char prefix[64];
        std::snprintf(prefix, sizeof prefix, "%.*s", static_cast<int>(dot - v.name), v.name);
        if (std::strcmp(prefix, "count") == 0) continue; // nothing connects to statistics
        if (std::strcmp(prefix, open) != 0) {
            if (*open) w.text("    </Terminal>\n");
            std::fprintf(w.file, "    <Terminal name=\"%s\" matchingRule=\"plug\">\n", prefix);
            std::snprintf(open, sizeof open, "%s", prefix);
        }
        std::fprintf(w.file, "      <TerminalMemberVariable variableName=\"%s\" memberName=\"%s\" variableKind=\"signal\"/>\n",
                     v.name, dot + 1);
    }
    if (*open) w.text("    </Terminal>\n");
    w.text("  </Terminals>\n</fmiTerminalsAndIcons>\n");
}

static void write_row(const Writer& w, const Variable& v) {
    std::fprintf(w.file, "<tr><td><code>%s</code></td><td>%s</td><td>%s</td><td>", v.name, name_of(v.causality),
                 type_element(v.type, true));
    w.escaped(v.unit);
    w.text("</td><td>");
    if (has_start(v)) {
        if (v.type == Type::enumeration) w.text(v.choices[static_cast<int>(v.start)].name);
        else if (v.type == Type::boolean) w.text(v.start != 0 ? "true" : "false");
        else std::fprintf(w.file, "%g", v.start);
    }
    w.text("</td><td>");
    w.escaped(v.description);
    for (int k = 0; k < v.choices.count; ++k) {
        std::fprintf(w.file, "<br><code>%s</code>: ", v.choices[k].name);
        w.escaped(v.choices[k].description);
    }
    w.text("</td></tr>\n");
}

bool write_documentation(const Writer& w, const char* introduction) {
    FILE* in = std::fopen(introduction, "r");
    if (!in) return false;
    std::fprintf(w.file, "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>%s</title>\n", model_info.name);
    w.text(
        "<style>body{font:16px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em}table{border-collapse:collapse}"
        "td,th{border:1px solid #ccc;padding:.2em .6em;text-align:left;vertical-align:top}code{font-size:90%}</style></head><body>\n");
    char line[1024];
    while (std::fgets(line, sizeof line, in)) w.text(line);
    std::fclose(in);
    w.text(
        "<h2>Variables</h2>\n<table><tr><th>name</th><th>kind</th><th>type</th><th>unit</th><th>start</th><th>meaning</th></tr>\n");
    for (int i = 0; i < w.table.size(); ++i) write_row(w, w.table[i]);
    w.text("</table>\n</body></html>\n");
    return true;
}

} // namespace hnav::fmu
