// modelDescription.xml of both versions.
#include "adapter/description.hpp"
#include "adapter/instance.hpp"
#include "adapter/units.hpp"

#include <cstring>
#include <ctime>

namespace hnav::fmu {

const char* type_element(Type type, bool fmi3) {
    switch (type) {
    case Type::real: return fmi3 ? "Float64" : "Real";
    case Type::integer: return fmi3 ? "Int32" : "Integer";
    case Type::boolean: return "Boolean";
    case Type::clock: return "Clock";
    default: return "Enumeration";
    }
}

const char* name_of(Causality causality) {
    constexpr const char* names[] = {"independent", "parameter", "calculatedParameter", "input", "output", "local"};
    return names[static_cast<int>(causality)];
}

namespace {

const char* const yes = "true";

const char* name_of(Variability variability) {
    constexpr const char* names[] = {"fixed", "discrete", "continuous"};
    return names[static_cast<int>(variability)];
}

bool is_calculated(const Variable& v) {
    return v.causality == Causality::output || v.causality == Causality::local || v.causality == Causality::calculated;
}

// ------------------------------------------------------------------------------------------------ head

// Ends the element of an interface, with the list of sources inside; FMI 3 has a separate file for them.
void end_interface(const Writer& w, const char* element) {
    if (w.fmi3) {
        w.text("/>\n");
        return;
    }
    w.text("><SourceFiles>");
    for (const char* const* file = source_files; *file; ++file) {
        w.text("<File");
        w.attribute("name", *file);
        w.text("/>");
    }
    std::fprintf(w.file, "</SourceFiles></%s>\n", element);
}

void begin_interface(const Writer& w, const char* element) {
    std::fprintf(w.file, "  <%s", element);
    w.attribute("modelIdentifier", model_info.name);
    w.attribute(w.fmi3 ? "canGetAndSetFMUState" : "canGetAndSetFMUstate", yes);
    w.attribute(w.fmi3 ? "canSerializeFMUState" : "canSerializeFMUstate", yes);
    if (!w.fmi3) w.attribute("canNotUseMemoryManagementFunctions", yes);
}

void write_interfaces(const Writer& w) {
    if (model_info.model_exchange) {
        begin_interface(w, "ModelExchange");
        if (model_info.derivatives) w.attribute(w.fmi3 ? "providesDirectionalDerivatives" : "providesDirectionalDerivative", yes);
        if (model_info.derivatives && w.fmi3) w.attribute("providesAdjointDerivatives", yes);
        w.attribute(w.fmi3 ? "needsCompletedIntegratorStep" : "completedIntegratorStepNotNeeded", w.fmi3 ? "false" : yes);
        end_interface(w, "ModelExchange");
    }
    begin_interface(w, "CoSimulation");
    w.attribute("canHandleVariableCommunicationStepSize", yes);
    if (w.fmi3) {
        w.attribute("hasEventMode", yes);
        w.attribute("providesIntermediateUpdate", yes);
    }
    end_interface(w, "CoSimulation");
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
        for (int k = 0; k < v.choices.count; ++k) {
            std::fprintf(w.file, "<Item name=\"%s\" value=\"%d\"", v.choices[k].name, k);
            w.attribute("description", v.choices[k].description);
            w.text("/>");
        }
        w.text(w.fmi3 ? "</EnumerationType>\n" : "</Enumeration></SimpleType>\n");
    }
    if (any) w.text("  </TypeDefinitions>\n");
}

// ------------------------------------------------------------------------------------------------ variables

// The range of a parameter; no attribute without a limit.
void write_bounds(const Writer& w, const Variable& v) {
    if (v.causality != Causality::parameter || v.type == Type::boolean) return;
    if (std::fabs(v.min) < 1e300) w.attribute("min", v.min);
    if (std::fabs(v.max) < 1e300) w.attribute("max", v.max);
}

void write_start(const Writer& w, int first) {
    if (!has_start(w.table[first])) return;
    w.text(" start=\"");
    for (int k = 0; k < w.rows(first); ++k) {
        const Variable& v = w.table[first + k];
        if (k > 0) w.text(" ");
        if (v.type == Type::boolean) w.text(v.start != 0 ? "true" : "false");
        else w.number(v.start);
    }
    w.text("\"");
}

void write_type(const Writer& w, int first) {
    const Variable& v = w.table[first];
    if (v.type == Type::enumeration) std::fprintf(w.file, " declaredType=\"choice.%s\"", v.name);
    if (v.type != Type::real) return;
    for (int k = 1; k < w.rows(first); ++k)
        if (std::strcmp(w.table[first + k].unit, v.unit) != 0) return; // elements with several units: none is declared
    if (*v.unit) w.attribute("unit", v.unit);
    if (*v.display_unit) w.attribute("displayUnit", v.display_unit);
}

// Attributes of the type: in FMI 2 on the inner element, in FMI 3 on the only one.
void write_value(const Writer& w, int row) {
    const Variable& v = w.table[row];
    write_type(w, row);
    write_bounds(w, v);
    write_start(w, row);
    if (v.derivative_of >= 0) w.attribute("derivative", w.reference(v.derivative_of));
    if (v.is_state) w.attribute("reinit", yes);
}

void write_dimensions(const Writer& w, int row) {
    const int count = w.rows(row), n = matrix_size(w.table, row, count);
    if (n > 0) std::fprintf(w.file, "><Dimension start=\"%d\"/><Dimension start=\"%d\"/>", n, n);
    else std::fprintf(w.file, "><Dimension start=\"%d\"/>", count);
}

void write_description(const Writer& w, const Variable& v) {
    w.text(v.basic ? " description=\"[basic] " : " description=\"");
    w.escaped(v.description);
    w.text("\"");
}

void write_variable(const Writer& w, int row) {
    const Variable& v = w.table[row];
    const char* element = w.fmi3 ? type_element(v.type, true) : "ScalarVariable";
    char name[64];
    w.name(row, name);
    std::fprintf(w.file, "    <%s", element);
    w.attribute("name", name);
    w.attribute("valueReference", w.reference(row));
    write_description(w, v);
    w.attribute("causality", name_of(v.causality));
    w.attribute("variability", name_of(v.variability));
    if (v.causality == Causality::parameter) w.attribute("initial", "exact");
    if (is_calculated(v) && v.type != Type::clock) w.attribute("initial", "calculated");
    if (v.type == Type::clock) w.attribute("intervalVariability", "triggered");
    if (v.clock >= 0) w.attribute("clocks", w.reference(v.clock));
    if (!w.fmi3) std::fprintf(w.file, "><%s", type_element(v.type, false));
    write_value(w, row);
    if (!w.fmi3) w.text("/></ScalarVariable>\n");
    else if (w.rows(row) > 1) {
        write_dimensions(w, row);
        std::fprintf(w.file, "</%s>\n", element);
    } else w.text("/>\n");
}

void write_variables(const Writer& w) {
    w.text("  <ModelVariables>\n");
    for (int i = 0; i < w.table.size(); ++i)
        if (w.rows(i) > 0) write_variable(w, i);
    w.text("  </ModelVariables>\n");
}

// ------------------------------------------------------------------------------------------------ structure

void write_unknown(const Writer& w, const char* element, int row, bool initial) {
    std::fprintf(w.file, w.fmi3 ? "    <%s valueReference=\"%d\"" : "      <%s index=\"%d\"", element, w.reference(row));
    if (!initial) {
        const Variable& v = w.table[row];
        const int count = v.depends_on == DependsOn::nothing        ? 0
                          : v.depends_on == DependsOn::first_states ? model_info.states.first
                                                                    : model_info.states.count;
        w.text(" dependencies=\"");
        int written = 0;
        for (int i = 0; i < w.table.size() && written < count; ++i) {
            if (!w.table[i].is_state || w.rows(i) == 0) continue;
            std::fprintf(w.file, written > 0 ? " %d" : "%d", w.reference(i));
            written += w.rows(i);
        }
        w.text("\"");
    }
    w.text("/>\n");
}

void write_structure(const Writer& w) {
    const auto each = [&](const char* element, bool initial, auto&& wanted) {
        for (int i = 0; i < w.table.size(); ++i)
            if (wanted(w.table[i]) && w.rows(i) > 0) write_unknown(w, element, i, initial);
    };
    const auto outputs = [](const Variable& v) { return v.causality == Causality::output; };
    const auto derivatives = [](const Variable& v) { return v.derivative_of >= 0; };
    const auto initial = [](const Variable& v) { return is_calculated(v) && v.clock < 0; }; // clocked ones wait for their clock
    w.text("  <ModelStructure>\n");
    if (w.fmi3) {
        each("Output", false, outputs);
        each("ContinuousStateDerivative", false, derivatives);
        each("InitialUnknown", true, initial);
    } else {
        w.text("    <Outputs>\n");
        each("Unknown", false, outputs);
        w.text("    </Outputs>\n");
        if (model_info.states.count > 0) { // the schema has no empty list
            w.text("    <Derivatives>\n");
            each("Unknown", false, derivatives);
            w.text("    </Derivatives>\n");
        }
        w.text("    <InitialUnknowns>\n");
        each("Unknown", true, initial);
        w.text("    </InitialUnknowns>\n");
    }
    w.text("  </ModelStructure>\n");
}

// SOURCE_DATE_EPOCH, if the build sets it: the date of the machine would make archives of equal sources differ.
void write_date(const Writer& w) {
    const char* seconds = std::getenv("SOURCE_DATE_EPOCH");
    if (!seconds || !*seconds) return;
    const auto time = static_cast<std::time_t>(std::strtoll(seconds, nullptr, 10));
    char date[32];
    std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&time));
    w.attribute("generationDateAndTime", date);
}

} // namespace

void write_build_description(const Writer& w) {
    w.text("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n  <BuildConfiguration");
    w.attribute("modelIdentifier", model_info.name);
    w.attribute("description", "C++17; Eigen is inside, SUNDIALS is not: closed forms take the place of its integrators");
    w.text(">\n    <SourceFileSet language=\"C++17\">\n");
    for (const char* const* file = source_files; *file; ++file) {
        w.text("      <SourceFile");
        w.attribute("name", *file);
        w.text("/>\n");
    }
    w.text("      <IncludeDirectory name=\".\"/>\n    </SourceFileSet>\n  </BuildConfiguration>\n</fmiBuildDescription>\n");
}

void write_model_description(const Writer& w, const char* version) {
    char token[64];
    Instance::format_token(w.table.token(model_info.arrays), token, sizeof token);
    w.text("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription");
    w.attribute("fmiVersion", w.fmi3 ? "3.0" : "2.0");
    w.attribute("modelName", model_info.name);
    w.attribute(w.fmi3 ? "instantiationToken" : "guid", token);
    w.attribute("description", model_info.description);
    w.attribute("version", version);
    w.attribute("license", "BSD-3-Clause");
    w.attribute("generationTool", "hnav");
    write_date(w);
    w.attribute("variableNamingConvention", "structured");
    if (!w.fmi3) w.attribute("numberOfEventIndicators", 0);
    w.text(">\n");
    write_interfaces(w);
    write_units(w);
    write_choices(w);
    w.text(
        "  <LogCategories>\n    <Category name=\"logStatusError\" description=\"What was wrong with a call; always on\"/>\n"
        "    <Category name=\"logStatusWarning\" description=\"What loses samples, said once; always on\"/>\n"
        "    <Category name=\"logEvents\" description=\"Initialisation, events, reset, end; on when logging is\"/>\n"
        "  </LogCategories>\n");
    w.text("  <DefaultExperiment");
    w.attribute("startTime", 0.0);
    w.attribute("stopTime", model_info.experiment.stop_s);
    w.attribute("tolerance", 1e-8);
    w.attribute("stepSize", model_info.experiment.step_s);
    w.text("/>\n");
    write_variables(w);
    write_structure(w);
    w.text("</fmiModelDescription>\n");
}

} // namespace hnav::fmu
