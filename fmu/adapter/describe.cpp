// Writes, at build time, everything in an FMU that follows from its table:
//
//     describe FOLDER 2|3 DOC_HTML VERSION
//
// modelDescription.xml, documentation/index.html, resources/example_input.csv and the terminals, which
// FMI 2 archives have as importers that know them from FMI 3 read them.
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
                    write("terminalsAndIcons/terminalsAndIcons.xml", [&] { write_terminals(w); });
    if (!documented) std::fprintf(stderr, "describe: cannot read %s\n", argv[3]);
    delete model;
    return ok && documented ? 0 : 1;
}
