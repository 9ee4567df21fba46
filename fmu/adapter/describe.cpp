// Writes, at build time, everything in an FMU that follows from its table:
//
//     describe FOLDER 2|3 DOC_HTML VERSION
//
// modelDescription.xml, the reference run, documentation/index.html, resources/example_input.csv and, in FMI 3, the terminals:
// FMILibrary refuses those of FMI 3 in an FMI 2 archive.
#include "adapter/description.hpp"
#include "adapter/example_input.hpp"

namespace hnav::fmu {
namespace {

FILE* create(const char* folder, const char* name) {
    char path[1024];
    std::snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE* file = std::fopen(path, "w");
    if (!file) std::fprintf(stderr, "describe: cannot write %s\n", path);
    return file;
}

bool has_inputs(const Table& table) {
    for (int i = 0; i < table.size(); ++i)
        if (table[i].causality == Causality::input) return true;
    return false;
}

} // namespace
} // namespace hnav::fmu

namespace {

using namespace hnav::fmu;

constexpr const char* references = "extra/org.fmi-standard.fmi-ls-ref";

// Writes the file folder/name by body.
template <class Body>
bool write(Writer* w, const char* folder, const char* name, Body body) {
    w->file = create(folder, name);
    if (!w->file) return false;
    const bool ok = body();
    return std::fclose(w->file) == 0 && ok;
}

bool write_references(Writer* w, const char* folder) {
    char place[1024], input_path[1100];
    std::snprintf(place, sizeof place, "%s/%s", folder, references);
    std::snprintf(input_path, sizeof input_path, "%s/input.csv", place);
    const bool inputs = has_inputs(w->table);
    if (inputs && !write(w, place, "input.csv", [&] { return write_example_input(w->file), true; })) return false;
    FILE* input = inputs ? std::fopen(input_path, "r") : nullptr;
    const bool ok = write(w, place, "reference.csv", [&] { return write_reference(*w, input); }) &&
                    write(w, place, "experiments.xml", [&] { return write_reference_experiment(*w, inputs), true; }) &&
                    write(w, place, "fmi-ls-manifest.xml", [&] { return write_reference_manifest(*w), true; });
    if (input) std::fclose(input);
    if (!ok) std::fprintf(stderr, "describe: the reference run failed\n");
    return ok;
}

bool write_all(Writer* w, const char* folder, const char* doc_html, const char* version) {
    const auto written = [&](const char* name, auto&& body) { return write(w, folder, name, [&] { return body(), true; }); };
    const bool examples = !model_info.arrays && !model_info.clocks; // which are held values of scalars
    if (!write(w, folder, "documentation/index.html", [&] { return write_documentation(*w, doc_html); })) {
        std::fprintf(stderr, "describe: cannot read %s\n", doc_html);
        return false;
    }
    if (!written("modelDescription.xml", [&] { write_model_description(*w, version); })) return false;
    if (w->fmi3 && (!written("terminalsAndIcons/terminalsAndIcons.xml", [&] { write_terminals(*w); }) ||
                    !written("sources/buildDescription.xml", [&] { write_build_description(*w); })))
        return false;
    if (examples && has_inputs(w->table) && !written("resources/example_input.csv", [&] { write_example_input(w->file); }))
        return false;
    return !examples || write_references(w, folder);
}

} // namespace

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
    if (!table.complete()) {
        std::fprintf(stderr, "describe: the table is not complete: an Outputs is full, or there is no memory\n");
        return 1;
    }
    Writer w{nullptr, argv[2][0] == '3', table};

    const bool ok = write_all(&w, folder, argv[3], argv[4]);
    delete model;
    return ok ? 0 : 1;
}
