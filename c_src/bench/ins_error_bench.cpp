// Times one step of the filter for coloured INS errors: 8 states, 8 measurements, 8 coloured errors, every form.
//
//     ins_error_bench [CSV]     prints a table; with a file name also writes it there
#include "hnav/hnav.h"
#include "timing.hpp"

#include <malloc.h>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

namespace {

constexpr int n = 8;
constexpr int steps = 2000;
constexpr int rounds = 15;

struct Case {
    const char* form_name;
    hnav_ins_error_form form;
    const char* scaling_name;
    hnav_noise_scaling scaling;
    std::vector<double> us;
    size_t heap_growth = 0;
};

// Two lightly damped fourth-order chains: A is full within each, as longitudinal and lateral motion are.
struct Model {
    double A[n * n] = {}, B[n * 2] = {}, I[n * n] = {}, An[n * n] = {}, Qw[n * n] = {}, Qv[n * n] = {}, QU[n * n] = {};

    Model() {
        for (int i = 0; i < n; ++i) {
            I[i * n + i] = 1;
            An[i * n + i] = 0.998;
            Qw[i * n + i] = 0.01;
            Qv[i * n + i] = 1;
            QU[i * n + i] = 0.004;
            B[i * 2 + i / 4] = 0.1;
            for (int j = i / 4 * 4; j < i / 4 * 4 + 4; ++j) A[i * n + j] = i == j ? 0.9 : 0.03 * ((i + 2 * j) % 5 - 2);
        }
    }

    hnav_ins_error_model view() const {
        auto m = hnav_sized<hnav_ins_error_model>();
        m.nx = m.nz = n;
        m.nu = 2;
        m.A = A;
        m.B = B;
        m.H = m.P0 = I;
        m.An = An;
        m.Qw = Qw;
        m.Qv = Qv;
        m.QU = QU;
        return m;
    }
};

void run(Case& c, const hnav_ins_error_model& model, const std::vector<double>& z) {
    hnav_ins_error_options options = hnav_ins_error_defaults();
    options.form = c.form;
    options.noise_scaling = c.scaling;
    char message[256];
    hnav_ins_error_filter* filter;
    if (hnav_ins_error_filter_create(&filter, &options, &model, message, sizeof message) != HNAV_OK) {
        std::fprintf(stderr, "ins_error_bench: %s\n", message);
        std::exit(1);
    }
    const double u[2] = {0.1, -0.2};
    const size_t heap = mallinfo2().uordblks;
    const double begin = bench::cpu_s();
    for (int k = 0; k < steps; ++k)
        if (hnav_ins_error_filter_step(filter, u, &z[k * n], nullptr) != HNAV_OK) {
            std::fprintf(stderr, "ins_error_bench: %s\n", hnav_ins_error_filter_message(filter));
            std::exit(1);
        }
    const double us = (bench::cpu_s() - begin) / steps * 1e6;
    c.heap_growth += mallinfo2().uordblks - heap;
    c.us.push_back(us);
    hnav_ins_error_filter_destroy(filter);
}

} // namespace

int main(int argc, char** argv) {
    const Model matrices;
    const hnav_ins_error_model model = matrices.view();
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::vector<double> z(steps * n);
    for (double& value : z) value = normal(random);

    std::vector<Case> cases;
    for (const auto& [form_name, form] : {std::pair<const char*, hnav_ins_error_form>{"augmented", HNAV_INS_ERROR_AUGMENTED},
                                          {"plain", HNAV_INS_ERROR_PLAIN},
                                          {"differenced", HNAV_INS_ERROR_DIFFERENCED}})
        for (const auto& [scaling_name, scaling] : {std::pair<const char*, hnav_noise_scaling>{"none", HNAV_NOISE_SCALING_NONE},
                                                    {"gated_match", HNAV_NOISE_SCALING_GATED_MATCH},
                                                    {"hmm", HNAV_NOISE_SCALING_HMM}})
            cases.push_back({form_name, form, scaling_name, scaling, {}, 0});
    cases.push_back({"augmented", HNAV_INS_ERROR_AUGMENTED, "joint", HNAV_NOISE_SCALING_JOINT, {}, 0});
    cases.push_back({"mdkf", HNAV_INS_ERROR_MDKF, "", HNAV_NOISE_SCALING_NONE, {}, 0});
    cases.push_back({"amdkf", HNAV_INS_ERROR_AMDKF, "", HNAV_NOISE_SCALING_NONE, {}, 0});
    for (int r = 0; r < rounds; ++r)
        for (Case& c : cases) run(c, model, z);

    FILE* csv = argc > 1 ? std::fopen(argv[1], "w") : nullptr;
    if (argc > 1 && !csv) {
        std::fprintf(stderr, "ins_error_bench: cannot write %s\n", argv[1]);
        return 2;
    }
    std::printf("one step, 8 states, 8 measurements, 8 coloured errors; CPU time, least and median of %d rounds of %d steps\n",
                rounds, steps);
    std::printf("%-12s %-12s %10s %10s %12s\n", "form", "scaling", "us/step", "median", "heap bytes");
    if (csv) std::fprintf(csv, "form,scaling,us_per_step,median_us_per_step,heap_growth_bytes\n");
    for (const Case& c : cases) {
        const double us = bench::least(c.us), median = bench::median(c.us);
        std::printf("%-12s %-12s %10.3f %10.3f %12zu\n", c.form_name, c.scaling_name, us, median, c.heap_growth);
        if (csv) std::fprintf(csv, "%s,%s,%.3f,%.3f,%zu\n", c.form_name, c.scaling_name, us, median, c.heap_growth);
    }
    if (csv) std::fclose(csv);
    return 0;
}
