// Writes, at build time, everything in an FMU that follows from its table:
//
//     describe FOLDER 2|3 DOC_HTML
//
// modelDescription.xml, documentation/index.html, resources/example_input.csv and, for FMI 3, the terminals. Nothing in
// it depends on the day or the machine: equal sources give equal bytes.
#include "adapter/example_input.hpp"
#include "adapter/instance.hpp"
#include "adapter/units.hpp"

#include <cstring>

namespace hnav::fmu {
namespace {

struct Writer {
    FILE* file;
    bool fmi3;
    const Table& table;

    void text(const char* s) const { std::fputs(s, file); }

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
    void attribute(const char* name, double value) const { std::fprintf(file, " %s=\"%.17g\"", name, value); }
    void attribute(const char* name, int value) const { std::fprintf(file, " %s=\"%d\"", name, value); }
};

const char* const yes = "true";

const char* type_element(Type type, bool fmi3) {
    switch (type) {
    case Type::real: return fmi3 ? "Float64" : "Real";
    case Type::integer: return fmi3 ? "Int32" : "Integer";
    case Type::boolean: return "Boolean";
    default: return "Enumeration";
    }
}

const char* name_of(Causality causality) {
    constexpr const char* names[] = {"independent", "parameter", "calculatedParameter", "input", "output", "local"};
    return names[static_cast<int>(causality)];
}

const char* name_of(Variability variability) {
    constexpr const char* names[] = {"fixed", "discrete", "continuous"};
    return names[static_cast<int>(variability)];
}

bool is_calculated(const Variable& v) {
    return v.causality == Causality::output || v.causality == Causality::local || v.causality == Causality::calculated;
}

bool has_inputs(const Table& table) {
    for (int i = 0; i < table.size(); ++i)
        if (table[i].causality == Causality::input) return true;
    return false;
}

// ------------------------------------------------------------------------------------------------ head

void write_interfaces(const Writer& w) {
    if (model_info.model_exchange) {
        w.text("  <ModelExchange");
        w.attribute("modelIdentifier", model_info.name);
        w.attribute(w.fmi3 ? "canGetAndSetFMUState" : "canGetAndSetFMUstate", yes);
        w.attribute(w.fmi3 ? "canSerializeFMUState" : "canSerializeFMUstate", yes);
        w.attribute(w.fmi3 ? "providesDirectionalDerivatives" : "providesDirectionalDerivative", yes);
        w.attribute(w.fmi3 ? "needsCompletedIntegratorStep" : "completedIntegratorStepNotNeeded", w.fmi3 ? "false" : yes);
        w.text("/>\n");
    }
    w.text("  <CoSimulation");
    w.attribute("modelIdentifier", model_info.name);
    w.attribute("canHandleVariableCommunicationStepSize", yes);
    w.attribute(w.fmi3 ? "canGetAndSetFMUState" : "canGetAndSetFMUstate", yes);
    w.attribute(w.fmi3 ? "canSerializeFMUState" : "canSerializeFMUstate", yes);
    if (w.fmi3) {
        w.attribute("hasEventMode", yes);
        w.attribute("providesIntermediateUpdate", yes);
    }
    w.text("/>\n");
}

void write_units(const Writer& w) {
    w.text("  <UnitDefinitions>\n");
    for (const Unit& unit : units) {
        bool used = false;
        for (int i = 0; i < w.table.size(); ++i) used = used || !std::strcmp(w.table[i].unit, unit.name);
        if (!used) continue;
        w.text("    <Unit");
        w.attribute("name", unit.name);
        w.text(">");
        if (unit.has_base) {
            w.text("<BaseUnit");
            const struct {
                const char* name;
                int exponent;
            } exponents[] = {{"kg", unit.kg}, {"m", unit.m}, {"s", unit.s}, {"A", unit.A}, {"rad", unit.rad}};
            for (const auto& e : exponents)
                if (e.exponent) w.attribute(e.name, e.exponent);
            w.text("/>");
            for (const DisplayUnit& display : unit.display) {
                if (!display.name) break;
                w.text("<DisplayUnit");
                w.attribute("name", display.name);
                w.attribute("factor", display.factor);
                w.text("/>");
            }
        }
        w.text("</Unit>\n");
    }
    w.text("  </UnitDefinitions>\n");
}

void write_choices(const Writer& w) {
    bool any = false; // the schema has no empty list
    for (int i = 0; i < w.table.size(); ++i) {
        const Variable& v = w.table[i];
        if (v.type != Type::enumeration) continue;
        if (!any) w.text("  <TypeDefinitions>\n");
        any = true;
        std::fprintf(w.file,
                     w.fmi3 ? "    <EnumerationType name=\"choice.%s\">" : "    <SimpleType name=\"choice.%s\"><Enumeration>",
                     v.name);
        for (int k = 0; k < v.choice_count; ++k) std::fprintf(w.file, "<Item name=\"%s\" value=\"%d\"/>", v.choices[k], k);
        w.text(w.fmi3 ? "</EnumerationType>\n" : "</Enumeration></SimpleType>\n");
    }
    if (any) w.text("  </TypeDefinitions>\n");
}

// ------------------------------------------------------------------------------------------------ variables

// Attributes of the type: in FMI 2 on the inner element, in FMI 3 on the only one.
void write_value(const Writer& w, const Variable& v) {
    if (v.type == Type::enumeration) std::fprintf(w.file, " declaredType=\"choice.%s\"", v.name);
    if (v.type == Type::real) {
        if (*v.unit) w.attribute("unit", v.unit);
        if (*v.display_unit) w.attribute("displayUnit", v.display_unit);
    }
    if (v.causality == Causality::parameter && v.type != Type::boolean) {
        if (std::fabs(v.min) < 1e300) w.attribute("min", v.min);
        if (std::fabs(v.max) < 1e300) w.attribute("max", v.max);
    }
    if (v.causality == Causality::parameter || v.causality == Causality::input) {
        if (v.type == Type::boolean) w.attribute("start", v.start != 0 ? "true" : "false");
        else w.attribute("start", v.start);
    }
    // FMI 2 counts variables from 1, FMI 3 names them by value reference.
    if (v.derivative_of >= 0) w.attribute("derivative", w.fmi3 ? v.derivative_of : v.derivative_of + 1);
    if (v.is_state) w.attribute("reinit", yes);
}

void write_variables(const Writer& w) {
    w.text("  <ModelVariables>\n");
    for (int i = 0; i < w.table.size(); ++i) {
        const Variable& v = w.table[i];
        std::fprintf(w.file, "    <%s", w.fmi3 ? type_element(v.type, true) : "ScalarVariable");
        w.attribute("name", v.name);
        w.attribute("valueReference", i);
        w.attribute("description", v.description);
        w.attribute("causality", name_of(v.causality));
        w.attribute("variability", name_of(v.variability));
        if (v.causality == Causality::parameter) w.attribute("initial", "exact");
        if (is_calculated(v)) w.attribute("initial", "calculated");
        if (w.fmi3) {
            write_value(w, v);
            w.text("/>\n");
        } else {
            std::fprintf(w.file, "><%s", type_element(v.type, false));
            write_value(w, v);
            w.text("/></ScalarVariable>\n");
        }
    }
    w.text("  </ModelVariables>\n");
}

// ------------------------------------------------------------------------------------------------ structure

void write_unknown(const Writer& w, const char* element, int row, bool initial) {
    const int shift = w.fmi3 ? 0 : 1;
    std::fprintf(w.file, w.fmi3 ? "    <%s valueReference=\"%d\"" : "      <%s index=\"%d\"", element, row + shift);
    if (!initial) {
        const Variable& v = w.table[row];
        const int count = v.depends_on == DependsOn::nothing        ? 0
                          : v.depends_on == DependsOn::first_states ? model_info.first_states
                                                                    : model_info.nx;
        w.text(" dependencies=\"");
        int written = 0;
        for (int i = 0; i < w.table.size() && written < count; ++i)
            if (w.table[i].is_state) std::fprintf(w.file, written++ ? " %d" : "%d", i + shift);
        w.text("\"");
    }
    w.text("/>\n");
}

void write_structure(const Writer& w) {
    const auto each = [&](const char* element, bool initial, auto&& wanted) {
        for (int i = 0; i < w.table.size(); ++i)
            if (wanted(w.table[i])) write_unknown(w, element, i, initial);
    };
    const auto outputs = [](const Variable& v) { return v.causality == Causality::output; };
    const auto derivatives = [](const Variable& v) { return v.derivative_of >= 0; };
    w.text("  <ModelStructure>\n");
    if (w.fmi3) {
        each("Output", false, outputs);
        each("ContinuousStateDerivative", false, derivatives);
        each("InitialUnknown", true, is_calculated);
    } else {
        w.text("    <Outputs>\n");
        each("Unknown", false, outputs);
        w.text("    </Outputs>\n");
        if (model_info.nx > 0) { // the schema has no empty list
            w.text("    <Derivatives>\n");
            each("Unknown", false, derivatives);
            w.text("    </Derivatives>\n");
        }
        w.text("    <InitialUnknowns>\n");
        each("Unknown", true, is_calculated);
        w.text("    </InitialUnknowns>\n");
    }
    w.text("  </ModelStructure>\n");
}

void write_model_description(const Writer& w, const char* version) {
    char token[64];
    Instance::format_token(w.table.token(), token, sizeof token);
    w.text("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription");
    w.attribute("fmiVersion", w.fmi3 ? "3.0" : "2.0");
    w.attribute("modelName", model_info.name);
    w.attribute(w.fmi3 ? "instantiationToken" : "guid", token);
    w.attribute("description", model_info.description);
    w.attribute("version", version);
    w.attribute("license", "BSD-3-Clause");
    w.attribute("generationTool", "hnav");
    w.attribute("variableNamingConvention", "structured");
    if (!w.fmi3) w.attribute("numberOfEventIndicators", 0);
    w.text(">\n");
    write_interfaces(w);
    write_units(w);
    write_choices(w);
    w.text("  <LogCategories><Category name=\"logStatusError\" description=\"What was wrong with a call\"/></LogCategories>\n");
    w.text("  <DefaultExperiment");
    w.attribute("startTime", 0.0);
    w.attribute("stopTime", model_info.stop_s);
    w.attribute("tolerance", 1e-8);
    w.attribute("stepSize", model_info.step_s);
    w.text("/>\n");
    write_variables(w);
    write_structure(w);
    w.text("</fmiModelDescription>\n");
}

// ------------------------------------------------------------------------------------------------ terminals, documentation

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
        if (!std::strcmp(prefix, "count")) continue; // nothing connects to statistics
        if (std::strcmp(prefix, open)) {
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
    for (int i = 0; i < w.table.size(); ++i) {
        const Variable& v = w.table[i];
        std::fprintf(w.file, "<tr><td><code>%s</code></td><td>%s</td><td>%s</td><td>", v.name, name_of(v.causality),
                     type_element(v.type, true));
        w.escaped(v.unit);
        w.text("</td><td>");
        if (v.causality == Causality::parameter || v.causality == Causality::input) {
            if (v.type == Type::enumeration) w.text(v.choices[static_cast<int>(v.start)]);
            else if (v.type == Type::boolean) w.text(v.start != 0 ? "true" : "false");
            else std::fprintf(w.file, "%g", v.start);
        }
        w.text("</td><td>");
        w.escaped(v.description);
        if (v.type == Type::enumeration) {
            w.text(":");
            for (int k = 0; k < v.choice_count; ++k) std::fprintf(w.file, "%s %s", k ? "," : "", v.choices[k]);
        }
        w.text("</td></tr>\n");
    }
    w.text("</table>\n</body></html>\n");
    return true;
}

FILE* create(const char* folder, const char* name) {
    char path[1024];
    std::snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE* file = std::fopen(path, "w");
    if (!file) std::fprintf(stderr, "describe: cannot write %s\n", path);
    return file;
}

} // namespace
} // namespace hnav::fmu

int main(int argc, char** argv) {
    using namespace hnav::fmu;
    if (argc != 5) {
        std::fprintf(stderr, "usage: describe FOLDER 2|3 DOC_HTML VERSION\n");
        return 2;
    }
    const char* folder = argv[1];
    Model* model = make_model();
    Table table;
    model->describe(table);
    Writer w{nullptr, argv[2][0] == '3', table};

    const auto write = [&](const char* name, auto&& body) {
        w.file = create(folder, name);
        if (!w.file) return false;
        body();
        return std::fclose(w.file) == 0;
    };
    bool documented = true;
    const bool ok = write("modelDescription.xml", [&] { write_model_description(w, argv[4]); }) &&
                    write("documentation/index.html", [&] { documented = write_documentation(w, argv[3]); }) &&
                    (!has_inputs(table) || write("resources/example_input.csv", [&] { write_example_input(w.file); })) &&
                    (!w.fmi3 || write("terminalsAndIcons/terminalsAndIcons.xml", [&] { write_terminals(w); }));
    if (!documented) std::fprintf(stderr, "describe: cannot read %s\n", argv[3]);
    delete model;
    return ok && documented ? 0 : 1;
}
