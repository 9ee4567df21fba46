// Thread CPU time of one filter over one recording, in nanoseconds a sample: all runs, one a line.
//
//     timing SAMPLES ROWS CONTENDER RUNS
//
// SAMPLES holds doubles: t_s (n), rate (n x 3), force (n x 3), field (n x 3). Only timed_run is to be counted.
#include "contenders.hpp"
#include "thread_time.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <vector>

extern "C" __attribute__((noinline)) void timed_run(Contender& contender, const Samples& samples, const Results& results) {
    contender.run(samples, results);
}

static void time_runs(const char* file, std::size_t n, const std::string& name, int runs) {
    std::vector<double> numbers(10 * n);
    std::ifstream in(file, std::ios::binary);
    in.read(reinterpret_cast<char*>(numbers.data()), std::streamsize(numbers.size() * sizeof(double)));
    if (!in) throw std::runtime_error(std::string(file) + " ends early");
    const Samples samples{n, numbers.data(), &numbers[n], &numbers[4 * n], &numbers[7 * n]};
    std::vector<double> q(4 * n), sigma(3 * n);
    std::unique_ptr<Contender> contender = own_contender(name);
    if (!contender && peer_contender) contender = peer_contender(name);
    if (!contender) throw std::runtime_error("there is no contender " + name);
    for (int i = 0; i < runs; ++i) {
        contender->begin(samples);
        const double start = cpu_s();
        timed_run(*contender, samples, {q.data(), sigma.data()});
        std::printf("%.1f\n", 1e9 * (cpu_s() - start) / double(n));
    }
    if (!std::isfinite(q[4 * n - 1])) throw std::runtime_error(name + " has no attitude at the end");
}

int main(int argc, char** argv) {
    try {
        if (argc != 5) throw std::runtime_error("SAMPLES ROWS CONTENDER RUNS");
        time_runs(argv[1], std::strtoul(argv[2], nullptr, 10), argv[3], std::atoi(argv[4]));
        return 0;
    } catch (const std::exception& reason) {
        std::fprintf(stderr, "timing: %s\n", reason.what());
        return 1;
    }
}
