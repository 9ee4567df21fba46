// Writes the FMU's outputs for its example input, so that users can compare them in their importer: the files of the FMI
// layered standard for references (fmi-ls-ref).
#include "adapter/description.hpp"
#include "adapter/instance.hpp"

#include <cstring>

namespace hnav::fmu {

namespace {

constexpr int steps = 200, steps_per_row = 10;
constexpr double tolerance = 1e-6; // of outputs, relative to the larger of them and 1

// A signal as CSV, held between its rows.
class Signal {
public:
    // No file: no inputs.
    Signal(FILE* file, const Table& table) : file_(file), table_(table) {
        if (!file_ || !std::fgets(line_, sizeof line_, file_)) return;
        for (char* name = std::strtok(line_, ",\n"); name && columns_ < largest; name = std::strtok(nullptr, ",\n")) {
            int row = 0;
            for (int i = 0; i < table.size(); ++i)
                if (std::strcmp(table[i].name, name) == 0) row = i;
            rows_[columns_++] = row;
        }
        waiting_ = read();
    }

    // Sets the values at t_s, which increases from call to call.
    bool set(Instance* instance, double t_s) {
        bool ok = true;
        while (waiting_ && values_[0] <= t_s + 1e-9) {
            for (int i = 1; i < columns_ && ok; ++i) ok = set_one(instance, rows_[i], values_[i]) == Status::ok;
            waiting_ = read();
        }
        return ok;
    }

private:
    static constexpr int largest = 64;

    Status set_one(Instance* instance, int row, double value) const {
        const bool flag = value != 0;
        const auto reference = static_cast<unsigned>(reference_of(table_, row, model_info.arrays));
        if (table_[row].type == Type::boolean) return instance->set(Type::boolean, &reference, 1, &flag);
        return instance->set(Type::real, &reference, 1, &value);
    }

    bool read() {
        if (!std::fgets(line_, sizeof line_, file_)) return false;
        char* place = line_;
        for (int i = 0; i < columns_; ++i, ++place) values_[i] = std::strtod(place, &place);
        return true;
    }

    FILE* file_;
    const Table& table_;
    char line_[4096] = "";
    int columns_ = 0;
    int rows_[largest] = {};
    double values_[largest] = {};
    bool waiting_ = false;
};

bool is_reference(const Variable& v) { return v.causality == Causality::output && v.type != Type::enumeration; }

void write_names(const Writer& w) {
    w.text("time");
    for (int i = 0; i < w.table.size(); ++i)
        if (is_reference(w.table[i])) std::fprintf(w.file, ",\"%s\"", w.table[i].name);
    w.text("\n");
}

bool write_values(const Writer& w, Instance* instance) {
    std::fprintf(w.file, "%.17g", instance->time_s());
    for (int i = 0; i < w.table.size(); ++i) {
        const Variable& v = w.table[i];
        if (!is_reference(v)) continue;
        const auto reference = static_cast<unsigned>(w.reference(i));
        double real = 0;
        int integer = 0;
        bool boolean = false;
        Status status = Status::ok;
        if (v.type == Type::real) status = instance->get(v.type, &reference, 1, &real);
        else if (v.type == Type::integer) status = instance->get(v.type, &reference, 1, &integer);
        else status = instance->get(v.type, &reference, 1, &boolean);
        if (status != Status::ok) return false;
        w.text(",");
        w.number(real + integer + boolean);
    }
    w.text("\n");
    return true;
}

} // namespace

bool write_reference(const Writer& w, FILE* input) {
    char token[64];
    Instance::format_token(w.table.token(model_info.arrays), token, sizeof token);
    Instance* instance = Instance::create("reference", token, {}, {});
    if (!instance) return false;
    Signal signal(input, w.table);
    const double step_s = model_info.experiment.step_s;
    bool ok = instance->set_up_experiment(0, false, 0) == Status::ok && instance->enter_initialization() == Status::ok &&
              instance->exit_initialization(true) == Status::ok;
    write_names(w);
    for (int k = 0; k < steps && ok; ++k) {
        Instance::Step reply;
        ok = signal.set(instance, k * step_s) && instance->do_step(k * step_s, step_s, nullptr, &reply) == Status::ok;
        if (ok && (k + 1) % steps_per_row == 0) ok = write_values(w, instance);
    }
    delete instance;
    return ok;
}

void write_reference_manifest(const Writer& w) {
    w.text(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<fmiReferences xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\" fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-ref\"\n"
        "    fmi-ls:fmi-ls-version=\"1.0.0-alpha.1\" fmi-ls:fmi-ls-description=\"Reference input and output\">\n"
        "  <File source=\"experiments.xml\" type=\"application/xml\" role=\"experiments\" description=\"What the FMU answers to its "
        "example input\"/>\n</fmiReferences>\n");
}

void write_reference_experiment(const Writer& w, bool has_input) {
    w.text("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Experiments name=\"References\">\n  <Experiment name=\"example\"");
    w.attribute(
        "description",
        "Co-Simulation with held inputs; outputs agree to tolerance x max(1, |value|), counts and flags exactly, but for those of the solver, which also counts what is read");
    w.attribute("startTime", 0.0);
    w.attribute("stopTime", steps * model_info.experiment.step_s);
    w.attribute("stepSize", model_info.experiment.step_s);
    w.attribute("tolerance", tolerance);
    w.text(">\n");
    if (has_input) w.text("    <Stimuli source=\"input.csv\" type=\"text/csv\"/>\n");
    w.text("    <References source=\"reference.csv\" type=\"text/csv\"/>\n  </Experiment>\n</Experiments>\n");
}

} // namespace hnav::fmu
