// Measures the cost of the FMI layer: the same samples through the C API and through the FMU's binary, loaded as an importer
// loads it, in turn within one run.
//
//     fmi_bench FMU_BINARY [CSV]
#include "adapter/instance.hpp"
#include "hnav/hnav.h"
#include "timing.hpp"

#include <dlfcn.h>
#include <fmi3Functions.h>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace {

constexpr int steps = 20000;
constexpr int rounds = 11;
constexpr double step_s = 0.01;

[[noreturn]] void stop(const char* what) {
    std::fprintf(stderr, "fmi_bench: %s\n", what);
    std::exit(1);
}

struct Samples {
    double rate[3], force[3], field[3];
};

Samples sample(int k) {
    const double a = 0.3 * std::sin(0.002 * k);
    return {{0.06 * std::cos(0.002 * k), 0, 0},
            {0, -9.81 * std::sin(a), -9.81 * std::cos(a)},
            {2e-5, 4.5e-5 * std::sin(a), 4.5e-5 * std::cos(a)}};
}

// read: the attitude, which includes the look-ahead to the end of the step.
double c_api_us(bool read) {
    const hnav_hrekf_options options = hnav_hrekf_defaults(HNAV_PRESET_DEFAULT);
    hnav_filter* filter;
    if (hnav_hrekf_create(&filter, &options, nullptr, 0) != HNAV_OK) stop("create failed");
    auto attitude = hnav_sized<hnav_attitude>();
    const double begin = bench::cpu_s();
    for (int k = 0; k < steps; ++k) {
        const Samples s = sample(k);
        const double t_s = step_s * k;
        if (hnav_filter_push_imu(filter, t_s, s.rate, s.force) != HNAV_OK ||
            hnav_filter_push_mag(filter, t_s, s.field) != HNAV_OK)
            stop(hnav_filter_message(filter));
        const hnav_status status = read ? hnav_filter_advance(filter, t_s + step_s) : hnav_filter_commit(filter, t_s + step_s);
        if (status != HNAV_OK || (read && hnav_filter_attitude(filter, &attitude) != HNAV_OK)) stop(hnav_filter_message(filter));
    }
    const double us = (bench::cpu_s() - begin) / steps * 1e6;
    hnav_filter_destroy(filter);
    return us;
}

class Fmu {
public:
    explicit Fmu(const char* path) {
        library_ = dlopen(path, RTLD_NOW | RTLD_LOCAL);
        if (!library_) stop(dlerror());
        load(instantiate_, "fmi3InstantiateCoSimulation");
        load(enter_, "fmi3EnterInitializationMode");
        load(exit_, "fmi3ExitInitializationMode");
        load(set_, "fmi3SetFloat64");
        load(set_integers_, "fmi3SetInt32");
        load(set_enumeration_, "fmi3SetInt64");
        load(get_, "fmi3GetFloat64");
        load(step_, "fmi3DoStep");
        load(free_, "fmi3FreeInstance");
        load(get_state_, "fmi3GetFMUState");
        load(set_state_, "fmi3SetFMUState");
        load(free_state_, "fmi3FreeFMUState");
        model_ = hnav::fmu::make_model();
        model_->describe(table_);
    }

    double us(bool read) {
        char token[64];
        hnav::fmu::Instance::format_token(table_.token(false), token, sizeof token);
        fmi3Instance instance =
            instantiate_("bench", token, "", false, false, false, false, nullptr, 0, nullptr, nullptr, nullptr);
        if (!instance) stop("the FMU could not be instantiated");
        const fmi3ValueReference mode = row("sampling_mode");
        const fmi3Int64 counter = 1;
        set_enumeration_(instance, &mode, 1, &counter, 1);
        enter_(instance, false, 0, 0, false, 0);
        exit_(instance);
        std::vector<fmi3ValueReference> inputs, outputs, counters;
        for (const char* name : {"gyro.rate", "accel.force", "mag.field"})
            for (int i = 1; i <= 3; ++i) inputs.push_back(row(std::string(name) + "[" + std::to_string(i) + "]"));
        for (const char* name : {"gyro", "accel", "mag"}) {
            inputs.push_back(row(std::string(name) + ".t_meas"));
            counters.push_back(row(std::string(name) + ".sample"));
        }
        // The whole group of the attitude.
        const unsigned group = table_[static_cast<int>(row("att.q[1]")) - 1].group;
        for (int i = 0; i < table_.size(); ++i)
            if (table_[i].group == group && table_[i].type == hnav::fmu::Type::real)
                outputs.push_back(static_cast<unsigned>(i + 1));

        double values[12];
        std::vector<double> shown(outputs.size());
        const double begin = bench::cpu_s();
        for (int k = 0; k < steps; ++k) {
            const Samples s = sample(k);
            std::memcpy(values, &s, sizeof s);
            values[9] = values[10] = values[11] = step_s * k;
            const fmi3Int32 counts[3] = {k + 1, k + 1, k + 1};
            fmi3Boolean needed, terminate, early;
            fmi3Float64 last;
            if (set_(instance, inputs.data(), 12, values, 12) != fmi3OK ||
                set_integers_(instance, counters.data(), 3, counts, 3) != fmi3OK ||
                step_(instance, step_s * k, step_s, true, &needed, &terminate, &early, &last) != fmi3OK ||
                (read && get_(instance, outputs.data(), outputs.size(), shown.data(), shown.size()) != fmi3OK))
                stop("a call failed");
        }
        const double us = (bench::cpu_s() - begin) / steps * 1e6;
        state_us = back_and_forth_us(instance);
        free_(instance);
        return us;
    }

    double state_us = 0; // to take a state and go back to it

private:
    double back_and_forth_us(fmi3Instance instance) const {
        fmi3FMUState state = nullptr;
        const double begin = bench::cpu_s();
        for (int k = 0; k < steps; ++k)
            if (get_state_(instance, &state) != fmi3OK || set_state_(instance, state) != fmi3OK) stop("a state was refused");
        const double us = (bench::cpu_s() - begin) / steps * 1e6;
        free_state_(instance, &state);
        return us;
    }

    template <class F>
    void load(F*& function, const char* name) {
        function = reinterpret_cast<F*>(dlsym(library_, name));
        if (!function) stop(name);
    }

    fmi3ValueReference row(const std::string& name) const {
        for (int i = 0; i < table_.size(); ++i)
            if (name == table_[i].name) return static_cast<fmi3ValueReference>(i + 1);
        stop(name.c_str());
    }

    void* library_;
    hnav::fmu::Model* model_;
    hnav::fmu::Table table_;
    fmi3InstantiateCoSimulationTYPE* instantiate_;
    fmi3EnterInitializationModeTYPE* enter_;
    fmi3ExitInitializationModeTYPE* exit_;
    fmi3SetFloat64TYPE* set_;
    fmi3SetInt32TYPE* set_integers_;
    fmi3SetInt64TYPE* set_enumeration_;
    fmi3GetFloat64TYPE* get_;
    fmi3DoStepTYPE* step_;
    fmi3FreeInstanceTYPE* free_;
    fmi3GetFMUStateTYPE* get_state_;
    fmi3SetFMUStateTYPE* set_state_;
    fmi3FreeFMUStateTYPE* free_state_;
};

} // namespace

int main(int argc, char** argv) {
    if (argc < 2) stop("usage: fmi_bench FMU_BINARY [CSV]");
    Fmu fmu(argv[1]);
    std::vector<double> c[2], fmi[2], state;
    for (int r = 0; r < rounds; ++r)
        for (const bool read : {true, false}) {
            c[read].push_back(c_api_us(read));
            fmi[read].push_back(fmu.us(read));
            state.push_back(fmu.state_us);
        }
    FILE* csv = argc > 2 ? std::fopen(argv[2], "w") : nullptr;
    if (argc > 2 && !csv) stop("cannot write the CSV");
    if (csv) std::fprintf(csv, "outputs,c_api_us,fmi3_cs_us,difference_us,median_difference_us\n");
    std::printf("samples in, 10 ms step; CPU time, least of %d rounds of %d steps, of the difference the median too\n", rounds,
                steps);
    std::printf("%-22s %8s %8s %10s %8s\n", "outputs that are read", "C us", "FMI us", "above C", "median");
    for (const bool read : {true, false}) {
        const char* outputs = read ? "attitude" : "none";
        const double in_c = bench::least(c[read]), in_fmi = bench::least(fmi[read]);
        const double apart = bench::median(fmi[read]) - bench::median(c[read]);
        std::printf("%-22s %8.3f %8.3f %10.3f %8.3f\n", outputs, in_c, in_fmi, in_fmi - in_c, apart);
        if (csv) std::fprintf(csv, "%s,%.3f,%.3f,%.3f,%.3f\n", outputs, in_c, in_fmi, in_fmi - in_c, apart);
    }
    if (csv) std::fclose(csv);
    std::printf("a state taken and given back %.3f us\n", bench::least(state));
    return 0;
}
