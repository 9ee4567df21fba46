// Plants with events of their own, by callbacks, and their truth.
#pragma once

#include "laws.hpp"
#include "observer.hpp"

#include <cmath>

namespace hnav::test::event_plants {

inline constexpr double gravity = 9.81, restitution = 0.7;

// A ball that bounces: h' = v, v' = -g, v+ = -e v where h <= 0 and v < 0.
inline int ball_flow(void*, double, const double* x, const double*, const double*, double* dx) {
    dx[0] = x[1];
    dx[1] = -gravity;
    return 0;
}

inline int ball_height(void*, double, const double* x, const double*, const double*, double* z) {
    z[0] = x[0];
    return 0;
}

inline int ball_bounce(void*, double, const double* x, const double*, const double* p, double* after) {
    if (x[0] > 0 || x[1] >= 0) return 0;
    after[0] = 0;
    after[1] = -(p ? p[0] : restitution) * x[1];
    return 0;
}

inline Given ball(Numbers start = {1, 0}, Numbers start_sigma = {0.05, 0.3}, double noise = std::sqrt(0.02),
                  double sensor = 0.02) {
    Given g;
    g.plant.n_states = 2;
    g.plant.n_outputs = 1;
    g.plant.n_indicators = 1;
    g.plant.derivatives = ball_flow;
    g.plant.outputs = ball_height;
    g.plant.indicators = ball_height;
    g.plant.event = [](void* c, double t_s, const double* x, const double* u, const double*, double* after) {
        return ball_bounce(c, t_s, x, u, nullptr, after);
    };
    g.start = start;
    g.start_sigma = start_sigma;
    g.noise = {0, noise};
    g.sensor_sigma = {sensor};
    g.options.start_mode = HNAV_OBSERVER_START_GIVEN;
    return g;
}

// The truth: Heun steps, with a bounce at the end of the step that goes below 0.
struct Ball {
    void step(double T) {
        constexpr int n = 200;
        for (int k = 0; k < n; ++k) {
            const double d = T / n, w = v - gravity * d + random.normal(noise * std::sqrt(d));
            h += 0.5 * (v + w) * d;
            v = w;
            if (h <= 0 && v < 0) {
                h = 0;
                v = -e * v;
            }
        }
    }
    Random random;
    double h, v, noise = std::sqrt(0.02), e = restitution;
};

// A pendulum with a stop at -0.2 rad.
inline constexpr double stop_rad = -0.2;

inline Given pendulum() {
    Given g = ball({0.5, 0}, {0.05, 0.1}, 0.05, 0.02);
    g.plant.derivatives = [](void*, double, const double* x, const double*, const double*, double* dx) {
        dx[0] = x[1];
        dx[1] = -gravity * std::sin(x[0]) - 0.1 * x[1];
        return 0;
    };
    g.plant.indicators = [](void*, double, const double* x, const double*, const double*, double* z) {
        z[0] = x[0] - stop_rad;
        return 0;
    };
    g.plant.event = [](void*, double, const double* x, const double*, const double*, double* after) {
        if (x[0] <= stop_rad && x[1] < 0) after[1] = -0.8 * x[1];
        return 0;
    };
    return g;
}

struct Pendulum {
    void step(double T) {
        constexpr int n = 400;
        for (int k = 0; k < n; ++k) {
            const double d = T / n;
            w += d * (-gravity * std::sin(a) - 0.1 * w) + random.normal(0.05 * std::sqrt(d));
            a += d * w;
            if (a <= stop_rad && w < 0) {
                a = 2 * stop_rad - a;
                w = -0.8 * w;
            }
        }
    }
    Random random;
    double a, w;
};

// A heater switched by a thermostat: x' = -x + 3 on, on below -1, off above 1. The state of the thermostat is discrete and
// inside the plant.
struct Heater {
    double on = 1;

    static int flow(void* c, double, const double* x, const double*, const double*, double* dx) {
        dx[0] = (static_cast<Heater*>(c)->on > 0 ? 3 : -3) - x[0];
        return 0;
    }
    static int to_switch(void* c, double, const double* x, const double*, const double*, double* z) {
        z[0] = static_cast<Heater*>(c)->on > 0 ? 1 - x[0] : x[0] + 1;
        return 0;
    }
    static int switch_over(void* c, double, const double* x, const double*, const double*, double*) {
        double& on = static_cast<Heater*>(c)->on;
        if (on > 0 && x[0] >= 1) on = 0;
        else if (on == 0 && x[0] <= -1) on = 1;
        return 0;
    }

    Given given() {
        Given g = ball({0}, {0.3}, 0, 0.1);
        g.noise = {0.1};
        g.plant.n_states = 1;
        g.plant.n_discrete = 1;
        g.plant.context = this;
        g.plant.derivatives = flow;
        g.plant.indicators = to_switch;
        g.plant.event = switch_over;
        g.plant.get_discrete = [](void* c, double* d) { *d = static_cast<Heater*>(c)->on; };
        g.plant.set_discrete = [](void* c, const double* d) { static_cast<Heater*>(c)->on = *d; };
        return g;
    }
};

struct Room {
    void step(double T) {
        constexpr int n = 200;
        for (int k = 0; k < n; ++k) {
            const double d = T / n;
            x += d * ((on ? 3 : -3) - x) + random.normal(0.1 * std::sqrt(d));
            if (on ? x >= 1 : x <= -1) on = !on;
        }
    }
    Random random;
    double x;
    bool on = true;
};

} // namespace hnav::test::event_plants
