// Times one interval of 10 ms with a sample of each sensor at its end: the paper's filter with every integrator and gamma
// mode (a correction of six rows each time), the AHRS with every integrator (a correction every 44 ms).
//
//     hnav_bench [CSV]          prints a table; with a file name also writes it there
//
// The last column is the ratio to a calibration loop of fixed work (7 x 7 products), which makes machines comparable.
#include "hnav/hnav.h"
#include "timing.hpp"

#include <Eigen/Geometry>

#include <malloc.h>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

constexpr int events = 2000;
constexpr int rounds = 15;
constexpr double interval_s = 0.01;

struct Samples {
    double t_s, rate[3], force[3], field[3];
};

// A body that turns at up to about 10 rad/s; the readings need not be exact to cost what they cost.
std::vector<Samples> tumbling() {
    std::vector<Samples> all(events);
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity(); // body to navigation
    for (int k = 0; k < events; ++k) {
        Samples& s = all[k];
        s.t_s = k * interval_s;
        const Eigen::Vector3d w(6 * std::sin(0.9 * s.t_s), 5 * std::cos(1.3 * s.t_s), 7 * std::sin(0.5 * s.t_s));
        const Eigen::Vector3d f = R.transpose() * Eigen::Vector3d(0, 0, -9.81);
        const Eigen::Vector3d m = R.transpose() * Eigen::Vector3d(2e-5, 0, 4.5e-5);
        for (int i = 0; i < 3; ++i) {
            s.rate[i] = w[i];
            s.force[i] = f[i];
            s.field[i] = m[i];
        }
        const double angle = w.norm() * interval_s;
        if (angle > 0) R = R * Eigen::AngleAxisd(angle, w.normalized()).toRotationMatrix();
    }
    return all;
}

void require(hnav_status status, const hnav_filter* filter) {
    if (status == HNAV_OK) return;
    std::fprintf(stderr, "hnav_bench: %s: %s\n", hnav_status_text(status), hnav_filter_message(filter));
    std::exit(1);
}

struct Case {
    const char* filter_name;
    const char* solver_name;
    hnav_solver solver;
    const char* gamma_name; // null for the AHRS, whose gamma is finite only at the start
    hnav_gamma_mode gamma_mode;
    std::vector<double> us;
    size_t heap_growth = 0;
    double rhs_evals = 0;
};

hnav_status create(hnav_filter** filter, const Case& c, char* message, size_t size) {
    if (!c.gamma_name) {
        hnav_ahrs_options options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
        options.solver = c.solver;
        return hnav_ahrs_create(filter, &options, message, size);
    }
    hnav_hrekf_options options = hnav_hrekf_defaults(HNAV_PRESET_DEFAULT);
    options.solver = c.solver;
    options.gamma_mode = c.gamma_mode;
    options.gamma = 1;
    return hnav_hrekf_create(filter, &options, message, size);
}

void run(Case& c, const std::vector<Samples>& samples) {
    char message[256];
    hnav_filter* filter;
    if (create(&filter, c, message, sizeof message) != HNAV_OK) {
        std::fprintf(stderr, "hnav_bench: %s\n", message);
        std::exit(1);
    }
    const size_t heap = mallinfo2().uordblks;
    const double begin = bench::cpu_s();
    for (const Samples& s : samples) {
        hnav_status status = hnav_filter_push_imu(filter, s.t_s, s.rate, s.force);
        if (status == HNAV_OK) status = hnav_filter_push_mag(filter, s.t_s, s.field);
        if (status == HNAV_OK) status = hnav_filter_advance(filter, s.t_s);
        require(status, filter);
    }
    const double us = (bench::cpu_s() - begin) / events * 1e6;
    c.heap_growth += mallinfo2().uordblks - heap;
    c.us.push_back(us);
    auto diagnostics = hnav_sized<hnav_diagnostics>();
    hnav_filter_diagnostics(filter, &diagnostics);
    c.rhs_evals = double(diagnostics.solver_rhs_evals) / events;
    hnav_filter_destroy(filter);
}

double calibration_us() {
    Eigen::Matrix<double, 7, 7> A = Eigen::Matrix<double, 7, 7>::Identity() * 0.5, B = A;
    A(0, 6) = A(3, 2) = 0.1;
    const double begin = bench::cpu_s();
    for (int k = 0; k < events; ++k) {
        B = A * B * A.transpose();
        B.diagonal().array() += 0.1;
    }
    volatile double keep = B(0, 0);
    (void)keep;
    return (bench::cpu_s() - begin) / events * 1e6;
}

} // namespace

int main(int argc, char** argv) {
    const std::vector<Samples> samples = tumbling();
    std::vector<Case> cases;
    const std::pair<const char*, hnav_solver> solvers[] = {{"erkstep", HNAV_SOLVER_ERKSTEP},
                                                           {"closed_form", HNAV_SOLVER_CLOSED_FORM},
                                                           {"euler", HNAV_SOLVER_EULER},
                                                           {"adams", HNAV_SOLVER_ADAMS}};
    for (const auto& [solver_name, solver] : solvers)
        cases.push_back({"ahrs", solver_name, solver, nullptr, HNAV_GAMMA_OFF, {}, 0, 0});
    for (const auto& [solver_name, solver] : solvers)
        for (const auto& [gamma_name, gamma_mode] : {std::pair<const char*, hnav_gamma_mode>{"off", HNAV_GAMMA_OFF},
                                                     {"fixed", HNAV_GAMMA_FIXED},
                                                     {"relative", HNAV_GAMMA_RELATIVE},
                                                     {"kl", HNAV_GAMMA_KL}})
            cases.push_back({"hrekf", solver_name, solver, gamma_name, gamma_mode, {}, 0, 0});

    std::vector<double> calibration;
    for (int r = 0; r < rounds; ++r) {
        calibration.push_back(calibration_us());
        for (Case& c : cases) run(c, samples);
    }

    FILE* csv = argc > 1 ? std::fopen(argv[1], "w") : nullptr;
    if (argc > 1 && !csv) {
        std::fprintf(stderr, "hnav_bench: cannot write %s\n", argv[1]);
        return 2;
    }
    const double unit = bench::least(calibration);
    std::printf("one interval of 10 ms and a sample of each sensor; CPU time, least and median of %d rounds of %d events\n",
                rounds, events);
    std::printf("calibration loop (one 7 x 7 triple product): %.3f us\n", unit);
    std::printf("%-9s %-12s %-9s %10s %10s %14s %12s %8s\n", "filter", "integrator", "gamma", "us/event", "median",
                "f evals/event", "heap bytes", "ratio");
    if (csv)
        std::fprintf(
            csv,
            "filter,integrator,gamma,us_per_event,median_us_per_event,rhs_evals_per_event,heap_growth_bytes,ratio_to_calibration\n");
    for (const Case& c : cases) {
        const double us = bench::least(c.us), median = bench::median(c.us);
        const char* gamma = c.gamma_name ? c.gamma_name : "-";
        std::printf("%-9s %-12s %-9s %10.3f %10.3f %14.2f %12zu %8.1f\n", c.filter_name, c.solver_name, gamma, us, median,
                    c.rhs_evals, c.heap_growth, us / unit);
        if (csv)
            std::fprintf(csv, "%s,%s,%s,%.3f,%.3f,%.2f,%zu,%.1f\n", c.filter_name, c.solver_name, gamma, us, median, c.rhs_evals,
                         c.heap_growth, us / unit);
    }
    if (csv) std::fclose(csv);
    return 0;
}
