// The observer in C: one case, so many times.
//
//     cost CASE RUNS                    nanoseconds of CPU time of a sample, all runs, one a line
//
// Cases: van_der_pol, a sample each 0.05 s; bouncing_ball, one in each jump, a little behind its top, so that a bounce and the return of
// its indicator lie in every interval; falling_ball, the same without a floor. The estimate never splits. Only timed_run is to be counted.
#include "hnav/hnav.h"
#include "thread_time.hpp"
#include "van_der_pol.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

using namespace hnav::test;

namespace {

constexpr double gravity = 9.81;

int first_of_two(void*, double, const double*, const double*, const double*, double* H) {
    H[0] = 1;
    H[1] = 0;
    return 0;
}

int fall(void*, double, const double* x, const double*, const double*, double* dx) {
    dx[0] = x[1];
    dx[1] = -gravity;
    return 0;
}

int fall_jacobian(void*, double, const double*, const double*, const double*, double* J) {
    J[0] = J[2] = J[3] = 0;
    J[1] = 1;
    return 0;
}

int bounce(void*, double, const double* x, const double*, const double*, double* after) {
    if (x[0] > 0 || x[1] >= 0) return 0;
    after[0] = 0;
    after[1] = -x[1];
    return 0;
}

constexpr int samples = 200;
constexpr double behind = 0.1; // of an interval

struct Case {
    hnav_filter* observer = nullptr;
    const bool bounces, ball;
    const double interval_s, start;

    explicit Case(const char* name)
        : bounces(std::strcmp(name, "bouncing_ball") == 0),
          ball(bounces || std::strcmp(name, "falling_ball") == 0),
          interval_s(ball ? 2 * std::sqrt(2 / gravity) : 0.05),
          start(bounces ? 1
                : ball  ? 1e6
                        : 2) {
        if (!ball && std::strcmp(name, "van_der_pol") != 0) throw std::runtime_error("there is no such case");
        auto plant = hnav_sized<hnav_plant>();
        plant.n_states = 2;
        plant.n_outputs = 1;
        plant.derivatives = ball ? fall : van_der_pol;
        plant.derivatives_jacobian = ball ? fall_jacobian : van_der_pol_jacobian;
        plant.outputs = first_state;
        plant.outputs_jacobian = first_of_two;
        if (ball) {
            plant.n_indicators = 1;
            plant.indicators = first_state;
            plant.event = bounce;
        }
        const double starts[] = {start, 0}, sigma[] = {0.01, 0.02}, noise[] = {0.01, 0.1}, sensor = 0.02;
        auto known = hnav_sized<hnav_observer_statistics>();
        known.start = starts;
        known.start_sigma = sigma;
        known.noise = noise;
        known.sensor_sigma = &sensor;
        hnav_observer_options options = hnav_observer_defaults();
        options.start_mode = HNAV_OBSERVER_START_GIVEN;
        char message[320];
        if (hnav_observer_create(&observer, &options, &plant, &known, message, sizeof message) != HNAV_OK)
            throw std::runtime_error(message);
    }

    double sample(double t_s) const {
        const double fallen_s = bounces ? behind * interval_s : t_s;
        return ball ? start - 0.5 * gravity * fallen_s * fallen_s : start * std::cos(t_s);
    }

    void check() const {
        auto info = hnav_sized<hnav_observer_info>();
        hnav_observer_get_info(observer, &info);
        if (info.dropped != 0 || info.splits + info.grazing != 0 || info.plant_events != (bounces ? samples : 0))
            throw std::runtime_error("it went otherwise than meant");
    }
};

} // namespace

extern "C" __attribute__((noinline)) void timed_run(const Case& of) {
    for (int k = 1; k <= samples; ++k) {
        const double t_s = of.interval_s * (k + behind);
        hnav_observer_push(of.observer, 0, t_s, of.sample(t_s));
        hnav_filter_commit(of.observer, t_s);
    }
}

int main(int argc, char** argv) {
    try {
        if (argc != 3) throw std::runtime_error("CASE RUNS");
        const Case of(argv[1]);
        for (int run = 0; run < std::atoi(argv[2]); ++run) {
            hnav_filter_reset(of.observer);
            const double start_s = cpu_s();
            timed_run(of);
            std::printf("%.1f\n", 1e9 * (cpu_s() - start_s) / samples);
            of.check();
        }
        return 0;
    } catch (const std::exception& reason) {
        std::fprintf(stderr, "cost: %s\n", reason.what());
        return 1;
    }
}
