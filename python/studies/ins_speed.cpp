// Thread CPU time of the navigation filter over one drive, in nanoseconds a sample of rate and force: all runs, one a line.
//
//     ins_speed DRIVE ROWS AIDS SOLVER EVERY RUNS
//
// DRIVE holds doubles: t_s (n), rate (n x 3), force (n x 3); of the aids t_s (m), sensor (m), value (m x 6). SOLVER: a number of
// hnav_solver. EVERY: a row of answers for so many samples. Only timed_run is to be counted.
#include "thread_time.hpp"

#include <hnav/hnav.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace {

struct Answers {
    std::vector<double> place, velocity, q, sigma_position, sigma_velocity, sigma_rotation;
    explicit Answers(std::size_t rows)
        : place(3 * rows),
          velocity(3 * rows),
          q(4 * rows),
          sigma_position(3 * rows),
          sigma_velocity(3 * rows),
          sigma_rotation(3 * rows) {}
};

int fail(const char* what) {
    std::fprintf(stderr, "ins_speed: %s\n", what);
    return 1;
}

} // namespace

extern "C" __attribute__((noinline)) hnav_status timed_run(hnav_filter* ins, std::size_t n, const hnav_ins_run_input& input,
                                                           const hnav_ins_run_output& output) {
    return hnav_ins_run(ins, n, &input, &output, nullptr);
}

int main(int argc, char** argv) {
    if (argc != 7) return fail("DRIVE ROWS AIDS SOLVER EVERY RUNS");
    const std::size_t n = std::strtoul(argv[2], nullptr, 10), m = std::strtoul(argv[3], nullptr, 10);
    std::vector<double> numbers(7 * n + 8 * m);
    std::ifstream in(argv[1], std::ios::binary);
    in.read(reinterpret_cast<char*>(numbers.data()), std::streamsize(numbers.size() * sizeof(double)));
    if (!in) return fail("DRIVE ends early");
    const double *aid_t_s = &numbers[7 * n], *sensors = aid_t_s + m;
    const std::vector<int32_t> aid_sensor(sensors, sensors + m);

    auto input = hnav_sized<hnav_ins_run_input>();
    input.t_s = numbers.data();
    input.rate_b_rad_s = &numbers[n];
    input.force_b_m_s2 = &numbers[4 * n];
    input.aids = m;
    input.aid_t_s = aid_t_s;
    input.aid_sensor = aid_sensor.data();
    input.aid_value = sensors + m;
    auto output = hnav_sized<hnav_ins_run_output>();
    output.every = std::strtoul(argv[5], nullptr, 10);
    if (output.every < 1) return fail("EVERY is at least 1");
    const std::size_t rows = n / output.every;
    Answers answers(rows);
    output.place = answers.place.data();
    output.velocity_n_m_s = answers.velocity.data();
    output.q_nb = answers.q.data();
    output.sigma_position_m = answers.sigma_position.data();
    output.sigma_velocity_m_s = answers.sigma_velocity.data();
    output.sigma_rotation_rad = answers.sigma_rotation.data();

    hnav_ins_options options = hnav_ins_defaults(HNAV_INS_INDUSTRIAL);
    options.solver = std::atoi(argv[4]);
    hnav_filter* ins = nullptr;
    if (hnav_ins_create(&ins, &options, nullptr, 0) != HNAV_OK) return fail("no filter with such options");
    for (int i = 0; i < std::atoi(argv[6]); ++i) {
        hnav_filter_reset(ins);
        const double start = cpu_s();
        const hnav_status status = timed_run(ins, n, input, output);
        std::printf("%.1f\n", 1e9 * (cpu_s() - start) / double(n));
        if (status != HNAV_OK) return fail(hnav_filter_message(ins));
    }
    auto end = hnav_sized<hnav_navigation>();
    hnav_ins_navigation(ins, &end);
    if (end.phase != HNAV_INS_PHASE_NAVIGATING) return fail("it does not navigate at the end");
    hnav_filter_destroy(ins);
    return 0;
}
